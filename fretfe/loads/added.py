# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles that are added behind the loads of a case until the last one is steady."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Indices
from fretfe.case import Case, Wave
from fretfe.loads.history import CycleChoice, History

# Added cycles from one extrapolation of slip to the next: it takes two changes without one between.
PER_EXTRAPOLATION = 3
REASONS = {
    CycleChoice.GIVEN: "given in [cycle]",
    CycleChoice.OTHER_RUN: "given in [cycle], of the run that the cuts follow",
    CycleChoice.LAST_PERIOD: "the last whole period of the slowest wave",
    CycleChoice.LAST_REPETITION: "the last repetition of the table with the longest period",
    CycleChoice.MISSION: "the last time at which all loads rise from zero and return to it",
    CycleChoice.ADDED: "the last one of the cycles that were added",
    None: "that of the loads it was run with",
}


class AddedCycles:
    """The loads as written, and their cycle again and again.

    After every third added cycle slip is extrapolated, so that the one that follows does not begin
    with the state before it. It is not evaluated, nor is it the last one.

    Args:
        history: the loads as written.
        more: number of cycles that may be added; 0 unless the cycle ends the loads.

    Attributes:
        longest: the loads with all of these.
        written: last step of the loads as written.
        period: number of steps of a cycle.
        ends: last steps of the loads as written and of each added cycle.
    """

    def __init__(self, history: History, more: int) -> None:
        self.longest, self.written = history.prolonged(more), len(history.times) - 1
        first, last = history.cycle or (0, self.written)
        self.period = last - first
        self.ends = range(self.written, len(self.longest.times), self.period)

    def extrapolated(self, added: int) -> bool:
        """True if slip is extrapolated after so many added cycles: not before the last ones."""
        return added % PER_EXTRAPOLATION == 1 and added + PER_EXTRAPOLATION < len(self.ends)

    def solved(self, step: int) -> History:
        """The loads until a step, but all that are written, and what is evaluated of them.

        That is the cycle as written, or the last whole one of those that were added behind it.
        """
        added = max(0, step - self.written) // self.period
        later = added - 1 if self.extrapolated(added - 1) else added
        return self.longest.until(max(self.written, step), later)


def most_added(case: Case, history: History, dimension: int) -> int:
    """Largest number of cycles that may be added to make the last one steady.

    Those of solids, if the loads end with a closed cycle and one of them with a wave.
    """
    if dimension == 2 or history.cycle is None or history.cycle[1] != len(history.times) - 1:
        return 0
    waves = (isinstance(load.history[-1], Wave) for load in case.loads.values())
    return case.cycle.most_more if history.returns and any(waves) else 0


def told_states(loads: History, written: int) -> Indices:
    """(n,) solved states of the loads as written, and those of the evaluated cycle.

    Cycles that were added between them are steps on the way to it, and no more.

    Args:
        loads: that were solved.
        written: last step of the loads as written.
    """
    states, (first, last) = np.arange(1, len(loads.times)), loads.evaluated
    return states[(states <= written) | ((states >= first) & (states <= last))]


def cycle_words(loads: History, unit: str) -> str:
    """The cycle of some loads, "t = 2 to 3 s, the reason"; empty without one."""
    if loads.cycle is None:
        return ""
    first, last = (loads.times[state] for state in loads.cycle)
    found = f"t = {first:.6g} to {last:.6g} {unit}, {REASONS[loads.choice]}"
    if loads.choice is CycleChoice.GIVEN and loads.open_channels:
        names = ", ".join(f"loads.{name}" for name in loads.open_channels)
        found += f", without a return of {names}, which more cycles do not bring"
    return found
