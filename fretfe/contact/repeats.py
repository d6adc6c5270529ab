# SPDX-License-Identifier: LGPL-3.0-or-later
"""Repeated blocks of a load history that need not be solved again, as the cycle is steady.

A block is steady if it leaves the contact as it found it. The same loads then lead through the same
states: a state follows from the one before and from the loads alone.
"""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.contact.recorder import Recorder
from fretfe.contact.state import ContactState, StepTable
from fretfe.results.solution import Repeat

# Loads that differ by less than this fraction of the largest one are the same.
SAME_LOAD = 1e-11
# States whose tractions and displacements differ by less than this fraction of the largest of their
# kind are the same.
SAME_STATE = 1e-10
# Earlier states under the same load that are looked at, the last ones.
MOST_CANDIDATES = 16


class Repetition:
    """Finds out, while a history is solved, which of its next states are known already.

    Args:
        steps: loads of the history.
    """

    def __init__(self, steps: StepTable) -> None:
        self._loads = _load_numbers(steps)
        # The states under each load, in time order, one load after the other.
        self._states = np.argsort(self._loads, kind="stable")
        self._places = np.searchsorted(self._loads[self._states], np.arange(self._loads.max() + 2))

    def after(self, recorder: Recorder) -> Repeat | None:
        """The states that follow the last one of a record, if they repeat those of a steady block.

        At least one whole block follows.
        """
        now, loads = recorder.count - 1, self._loads
        if now + 1 >= len(loads):
            return None
        for earlier in self._candidates(now).tolist():
            period = now - earlier
            if (
                np.array_equal(loads[now + 1 : now + 1 + period], loads[earlier + 1 : now + 1])
                and np.allclose(recorder.marks[now], recorder.marks[earlier], rtol=1e-8, atol=0.0)
                and _same(recorder.last, recorder.state(earlier))
            ):
                different = np.flatnonzero(loads[now + 1 :] != loads[earlier + 1 : -period])
                count = int(different[0]) if len(different) else len(loads) - 1 - now
                return Repeat(now + 1, now + count, period)
        return None

    def _candidates(self, now: int) -> Indices:
        """Earlier states under the load of a state, and with the same next load, latest first."""
        loads = self._loads
        states = self._states[slice(*self._places[loads[now] :][:2])]
        before = states[: np.searchsorted(states, now)]
        # The block ends now, and as long a one is to follow.
        before = before[2 * now - before < len(loads)]
        return before[loads[before + 1] == loads[now + 1]][-MOST_CANDIDATES:][::-1]


def _load_numbers(steps: StepTable) -> Indices:
    """(T,) numbers of the loads, the same for the same loads."""
    loads = np.column_stack([steps.amplitudes, steps.values, steps.friction])
    scale = np.abs(loads).max(axis=0)
    rounded = np.rint(loads / (SAME_LOAD * np.where(scale > 0, scale, 1.0)))
    return np.unique(rounded, axis=0, return_inverse=True)[1].ravel()


def _same(one: ContactState, other: ContactState) -> bool:
    """True if two states are the same but for round-off."""
    return np.array_equal(one.status, other.status) and all(
        _close(*pair)
        for pair in (
            (one.traction, other.traction),
            # Far gaps are large against what slips.
            (one.relative[:, 0], other.relative[:, 0]),
            (one.relative[:, 1:], other.relative[:, 1:]),
            (one.coordinates, other.coordinates),
            (one.forces, other.forces),
        )
    )


def _close(one: Array, other: Array) -> bool:
    """True if quantities differ by less than a fraction of the largest of them."""
    size = np.abs(one).max(initial=0.0)
    return bool(np.abs(one - other).max(initial=0.0) <= SAME_STATE * size)
