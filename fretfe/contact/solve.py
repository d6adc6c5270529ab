# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve a load history: march from step to step, record, and leave out what repeats itself."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.contact.march import Division, March, summary
from fretfe.contact.recorder import Recorder
from fretfe.contact.state import ContactState, StepTable
from fretfe.errors import ConvergenceError
from fretfe.history.solution import Repeat

# Loads that differ by less than this fraction of the largest one are the same.
SAME_LOAD = 1e-11
# States whose tractions and displacements differ by less than this fraction of the largest of their
# kind are the same.
SAME_STATE = 1e-10
# Earlier states under the same load that are looked at, the last ones.
MOST_CANDIDATES = 16
# Steps or seconds between two notes of the state of a history, and the fewest seconds: at least so
# many times what the last one took.
NOTE_STEPS = 50
NOTE_SECONDS = 5.0
LEAST_SECONDS = 0.5
SPARING = 50.0
# The slowest fall of a change from cycle to cycle that slip is extrapolated with: it is never known
# better, as the slowest parts of a change last.
SLOWEST = 0.92
# Called with the number of a step, the number of all steps, and what to say about it.
Progress = Callable[[int, int, str], None]


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
        """The steps that follow the last one of a record, if they repeat those of a steady block.

        At least one whole block follows.
        """
        now, loads, ends = recorder.steps_done, self._loads, recorder.ends
        if now + 1 >= len(loads):
            return None
        for earlier in self._candidates(now).tolist():
            period = now - earlier
            if (
                np.array_equal(loads[now + 1 : now + 1 + period], loads[earlier + 1 : now + 1])
                and np.allclose(
                    recorder.mark(ends[now]), recorder.mark(ends[earlier]), rtol=1e-8, atol=0.0
                )
                and _same(recorder.last, recorder.state(ends[earlier]))
            ):
                different = np.flatnonzero(loads[now + 1 :] != loads[earlier + 1 : -period])
                count = int(different[0]) if len(different) else len(loads) - 1 - now
                return Repeat(now + 1, now + count, period)
        return None

    def like_next(self, recorder: Recorder) -> ContactState | None:
        """The state at the end of the last step that was one between the loads of the next one."""
        now, loads = recorder.steps_done, self._loads
        same = (loads[1 : now + 1] == loads[now + 1]) & (loads[:now] == loads[now])
        steps = 1 + np.flatnonzero(same)
        return recorder.state(recorder.ends[steps[-1]]) if len(steps) else None

    def _candidates(self, now: int) -> Indices:
        """Earlier states under the load of a state, and with the same next load, latest first."""
        loads = self._loads
        states = self._states[slice(*self._places[loads[now] :][:2])]
        before = states[: np.searchsorted(states, now)]
        # The block ends now, and as long a one is to follow.
        before = before[2 * now - before < len(loads)]
        return before[loads[before + 1] == loads[now + 1]][-MOST_CANDIDATES:][::-1]


def extrapolate_slip(recorder: Recorder, period: int) -> None:
    """Let the next step start from where the slip of closed nodes tends to from cycle to cycle.

    Slip that stays in the contact changes ever more slowly: by the part λ of the cycle before, and
    in the end by λ/(1 - λ) times the last change. The states that follow meet all contact
    conditions, but the first step is not one between two recorded states.

    Args:
        recorder: holds the ends of three cycles at least; the last step is one.
        period: steps of a cycle.
    """
    ends, now = recorder.ends, recorder.steps_done
    states = [recorder.state(int(ends[now - period * back])) for back in range(3)]
    last = states[0]
    slips = [state.relative[last.closed, 1:] for state in states]
    change, before = slips[0] - slips[1], slips[1] - slips[2]
    factor = float(np.vdot(change, before)) / max(float(np.vdot(before, before)), 1e-300)
    if not 0 < factor < 1:
        return
    factor = min(factor, SLOWEST)
    relative = last.relative.copy()
    relative[last.closed, 1:] += factor / (1 - factor) * change
    recorder.last = replace(last, relative=relative)


def _load_numbers(steps: StepTable) -> Indices:
    """(T,) numbers of the loads, the same for the same loads."""
    friction = (each.number for each in steps.friction)
    loads = np.column_stack([steps.amplitudes, steps.values, *friction])
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


def solve_history(
    march: March,
    recorder: Recorder,
    steps: StepTable,
    until_steady: bool,
    progress: Progress,
    like: Recorder | None = None,
) -> None:
    """Solve all steps of a history.

    Args:
        march: advances the states.
        recorder: gets the accepted steps; holds the unloaded state.
        steps: the loads.
        until_steady: whether repeated blocks are solved until they are steady and then not again.
        progress: called with each accepted step, and once for each row of repeated ones.
        like: another history of this march, whose states at the same steps may resemble these.

    Raises:
        ConvergenceError: if a step has no solution, or `progress` wants the history to end; what
            was recorded stands.
    """
    try:
        _march(march, recorder, steps, until_steady, progress, like)
    except ConvergenceError:
        recorder.note()
        raise
    recorder.note()


def _march(
    march: March,
    recorder: Recorder,
    steps: StepTable,
    until_steady: bool,
    progress: Progress,
    like: Recorder | None,
) -> None:
    count, pace, division = len(steps) - 1, Pace(), Division(march, steps, recorder.places)
    repetition = Repetition(steps)
    while (now := recorder.steps_done) < count:
        repeated = bool(recorder.repeats) and recorder.repeats[-1].last == now
        repeat = repetition.after(recorder) if until_steady and not repeated else None
        if repeat is not None:
            recorder.repeat(repeat)
            progress(repeat.last, count, repeat.text)
            continue
        # Saves two of five iterations.
        guess = repetition.like_next(recorder)
        if guess is None and like is not None and now < like.steps_done:
            guess = like.state(int(like.ends[now + 1]))
        parts = division.solve(now + 1, recorder.last, guess)
        recorder.add(now + 1, parts)
        if pace.due():
            recorder.note()
            pace.noted()
        progress(now + 1, count, summary(parts))


class Pace:
    """Says after which steps a note of the state of the history is due."""

    def __init__(self) -> None:
        self._steps = 0
        self._wait = 0.0
        self._asked = self._last = time.monotonic()

    def due(self) -> bool:
        """Count a step, and tell whether a note is due after it."""
        self._steps += 1
        self._asked = time.monotonic()
        seconds = self._asked - self._last
        if seconds < max(LEAST_SECONDS, self._wait):
            return False
        return seconds >= NOTE_SECONDS or self._steps >= NOTE_STEPS

    def noted(self) -> None:
        """Note that there is one now; if it took long, the next one waits for longer."""
        self._steps, self._last = 0, time.monotonic()
        self._wait = SPARING * (self._last - self._asked)
