# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many cases that differ in a few values, one table of all."""

from __future__ import annotations

from fretfe.sweeps.engine import Solved, Sweep, run_sweep
from fretfe.sweeps.variants import Variant, make_variants, parse_ranges

__all__ = ["Solved", "Sweep", "Variant", "make_variants", "parse_ranges", "run_sweep"]
