# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve a load history: march from step to step, record, and leave out what repeats itself."""

from __future__ import annotations

import time
from collections.abc import Callable

from fretfe.contact.march import March
from fretfe.contact.recorder import Recorder
from fretfe.contact.repeats import Repetition
from fretfe.contact.state import StepTable
from fretfe.errors import ConvergenceError

# Steps or seconds between two notes of the state of a history, and the fewest seconds: at least so
# many times what the last one took.
NOTE_STEPS, NOTE_SECONDS, LEAST_SECONDS, SPARING = 50, 5.0, 0.5, 50.0
# Called with the number of a step, the number of all steps, and what to say about it.
Progress = Callable[[int, int, str], None]


def solve_history(
    march: March, recorder: Recorder, steps: StepTable, until_steady: bool, progress: Progress
) -> None:
    """Solve all steps of a history.

    Args:
        march: advances the states.
        recorder: gets the accepted steps; holds the unloaded state.
        steps: the loads.
        until_steady: whether repeated blocks are solved until they are steady and then not again.
        progress: called with each accepted step, and once for each row of repeated ones.

    Raises:
        ConvergenceError: if a step has no solution, or `progress` wants the history to end; what
            was recorded stands.
    """
    try:
        _march(march, recorder, steps, Repetition(steps) if until_steady else None, progress)
    except ConvergenceError:
        recorder.note()
        raise
    recorder.note()


def _march(
    march: March,
    recorder: Recorder,
    steps: StepTable,
    repetition: Repetition | None,
    progress: Progress,
) -> None:
    count, pace = len(steps) - 1, Pace()
    while recorder.count <= count:
        now = recorder.count - 1
        repeated = bool(recorder.repeats) and recorder.repeats[-1].last == now
        repeat = repetition.after(recorder) if repetition and not repeated else None
        if repeat is not None:
            recorder.repeat(repeat)
            progress(repeat.last, count, repeat.text)
            continue
        result = next(march.run(steps, recorder.count, recorder.last))
        recorder.add(result)
        if pace.due():
            recorder.note()
            pace.noted()
        progress(recorder.count - 1, count, result.summary)


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
