# SPDX-License-Identifier: LGPL-3.0-or-later
"""All inputs, always the same."""

from __future__ import annotations

from faults import (
    case_files,
    decisions,
    disc,
    exports,
    fields,
    files,
    folders,
    lives,
    models,
    pieces,
    rigs,
    tables,
)
from faults.fault import Fault

SOURCES = (
    case_files, files, tables, fields, folders, models, rigs, lives, exports, pieces, disc,
    decisions,
)  # fmt: skip


def all_faults() -> list[Fault]:
    """All inputs, in an order that does not change."""
    found = [fault for each in SOURCES for fault in each.faults()]
    names = [fault.name for fault in found]
    repeated = {name for name in names if names.count(name) > 1}
    assert not repeated, repeated
    return found
