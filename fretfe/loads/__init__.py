# SPDX-License-Identifier: LGPL-3.0-or-later
"""Load histories: from the segments of a case file to arrays on one clock. NumPy only."""

from __future__ import annotations

from fretfe.loads.added import AddedCycles, cycle_words, most_added, told_states
from fretfe.loads.history import CycleChoice, History, build_history

__all__ = [
    "AddedCycles",
    "CycleChoice",
    "History",
    "build_history",
    "cycle_words",
    "most_added",
    "told_states",
]
