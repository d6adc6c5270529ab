# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many cases that differ in a few values, one table of all."""

from __future__ import annotations

from fretfe.sweeps.engine import (
    Solved,
    Sweep,
    Variant,
    make_variants,
    parse_ranges,
    require_apart,
    run_sweep,
)

__all__ = [
    "Solved",
    "Sweep",
    "Variant",
    "make_variants",
    "parse_ranges",
    "require_apart",
    "run_sweep",
]
