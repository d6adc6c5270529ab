# SPDX-License-Identifier: LGPL-3.0-or-later
"""Times that a case names, and the cycle that is evaluated, as steps of the clock."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, CsvPoints, complaint
from fretfe.errors import CaseError
from fretfe.loads.segments import SAME_TIME, Key, Piece

# Periods divide a cycle if their ratio is a whole number to this accuracy (periods are typed).
WHOLE_NUMBER = 1e-6
# A cycle is closed if no load differs by more than this fraction of its largest value.
CLOSED = 1e-6


def check_times(case: Case, times: Array) -> None:
    """Check that every time that the case names is the time of a step.

    Args:
        case: the case.
        times: (T,) step times.

    Raises:
        CaseError: lists all times that are not, each with the nearest step times.
    """
    problems = [
        complaint(case.source, key, _no_step(times, time))
        for key, time in _named_times(case)
        if np.min(np.abs(times - time)) > SAME_TIME * times[-1]
    ]
    if problems:
        raise CaseError("\n".join(problems))


def find_cycle(
    case: Case, times: Array, values: Array, channels: Mapping[str, Sequence[Piece]]
) -> tuple[int, int] | None:
    """First and last step of the cycle: the one the case gives, or that of the slowest wave.

    Args:
        case: the case, its times checked.
        times: (T,) step times.
        values: (T, C) load values.
        channels: segments of each load.

    Raises:
        CaseError: the cycle is not a whole number of periods of every wave in it, or the last
            period of the slowest wave does not bring all loads back.
    """
    waves = {
        (name, index): piece
        for name, pieces in channels.items()
        for index, piece in enumerate(pieces)
        if piece.period is not None
    }
    if case.cycle.given is not None:
        start, end = case.cycle.given
    elif waves:
        slowest = max(waves.values(), key=lambda wave: (wave.period, wave.end))
        start, end = slowest.end - (slowest.period or 0.0), slowest.end
    else:
        return None
    _check_periods(case, start, end, waves)
    first, last = (int(np.argmin(np.abs(times - time))) for time in (start, end))
    if case.cycle.given is None:
        _check_closed(case, times, values, first, last)
    return first, last


def _named_times(case: Case) -> Iterator[tuple[Key, float]]:
    for name, contact in case.contacts.items():
        yield ("contacts", name, "friction_from"), contact.friction_from
    if case.cycle.given is not None:
        yield from zip((("cycle", "start"), ("cycle", "end")), case.cycle.given, strict=True)
    if not isinstance(case.output.fields, str):
        for index, time in enumerate(case.output.fields):
            yield ("output", "fields", index), time


def _no_step(times: Array, time: float) -> str:
    if time > times[-1]:
        return f"expected a time within the history, which ends at {times[-1]:g}, found {time:g}"
    after = int(np.searchsorted(times, time))
    return (
        f"expected the time of a step, found {time:.10g}; the nearest steps are at "
        f"{times[after - 1]:.10g} and {times[after]:.10g}"
    )


def _check_periods(
    case: Case, start: float, end: float, waves: Mapping[tuple[str, int], Piece]
) -> None:
    """Demand that the cycle holds whole periods of every wave that acts in it."""
    for (name, index), wave in waves.items():
        # A wave that ends where the cycle starts, or the other way round, does not act in it.
        shared = min(end, wave.end) - max(start, wave.start)
        periods = (end - start) / (wave.period or end - start)
        if shared <= SAME_TIME * end or abs(periods - round(periods)) <= WHOLE_NUMBER * periods:
            continue
        text = (
            f"expected a period that divides the cycle from {start:g} to {end:g} (length "
            f"{end - start:g}), found {wave.period:g}: change it, or give [cycle] a length that is "
            "a whole multiple of every period"
        )
        key = "csv" if isinstance(case.loads[name].history[index], CsvPoints) else "period"
        raise CaseError(complaint(case.source, ("loads", name, "history", index, key), text))


def _check_closed(case: Case, times: Array, values: Array, first: int, last: int) -> None:
    drift = np.abs(values[last] - values[first])
    open_channels = np.flatnonzero(drift > CLOSED * np.max(np.abs(values), axis=0))
    if not open_channels.size:
        return
    channel = int(open_channels[0])
    name = list(case.loads)[channel]
    text = (
        "expected every load to return in the cycle, the last period of the slowest wave, found "
        f"{values[first, channel]:g} at time {times[first]:g} and {values[last, channel]:g} at "
        f"time {times[last]:g}: hold the load during that period, or name the cycle in [cycle]"
    )
    raise CaseError(complaint(case.source, ("loads", name), text))
