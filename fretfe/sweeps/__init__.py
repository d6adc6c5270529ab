# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many cases that differ in a few values, one table of all."""

from __future__ import annotations

from fretfe.sweeps.engine import (
    Points,
    Solved,
    Sweep,
    Variant,
    make_variants,
    parse_ranges,
    require_apart,
    run_sweep,
    sample,
)

__all__ = [
    "Points",
    "Solved",
    "Sweep",
    "Variant",
    "make_variants",
    "parse_ranges",
    "require_apart",
    "run_sweep",
    "sample",
]
