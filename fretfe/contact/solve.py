# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve a load history: march from step to step, record, and leave out what repeats itself."""

from __future__ import annotations

from collections.abc import Callable

from fretfe.contact.march import March
from fretfe.contact.recorder import Recorder
from fretfe.contact.repeats import Repetition
from fretfe.contact.state import StepTable

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
    repetition = Repetition(steps) if until_steady else None
    count = len(steps) - 1
    while recorder.count <= count:
        for result in march.run(steps, recorder.count, recorder.last):
            recorder.add(result)
            progress(recorder.count - 1, count, result.summary)
            repeat = repetition.after(recorder) if repetition else None
            if repeat is not None:
                recorder.repeat(repeat)
                progress(repeat.last, count, repeat.text)
                break
