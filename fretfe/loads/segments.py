# SPDX-License-Identifier: LGPL-3.0-or-later
"""From the segments of a load to functions of time that continue each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, CsvPoints, Hold, Points, Ramp, Segment, Wave, complaint
from fretfe.case.base import MOST_STEPS
from fretfe.errors import CaseError
from fretfe.loads.csv_file import read_columns

Key = tuple[str | int, ...]

# Times closer than this fraction of the whole history are one time.
SAME_TIME = 1e-9
# A wave or table may start this fraction of its largest value away from where the load stands:
# values typed with seven digits are continuous.
SAME_VALUE = 1e-6
# The ends of a table that is repeated may differ by this fraction of its range.
SAME_END = 1e-9


@dataclass(frozen=True)
class Piece:
    """One segment in the half-open interval (start, end]; ``period`` only if it repeats itself.

    ``curved`` unless it is a straight line between its steps.
    """

    start: float
    end: float
    steps: Array
    value: Callable[[Array], Array]
    period: float | None = None
    curved: bool = False


def read_pieces(case: Case, name: str) -> list[Piece]:
    """The segments of one load, each starting where the one before ends."""
    pieces: list[Piece] = []
    time = value = 0.0
    _require_few_steps(case, name)
    for index, segment in enumerate(case.loads[name].history):
        key = ("loads", name, "history", index)
        try:
            piece = _piece(case, segment, time, value)
        except _Invalid as error:
            raise CaseError(complaint(case.source, (*key, *error.key), error.text)) from None
        pieces.append(piece)
        time, value = piece.end, float(piece.value(np.array([piece.end]))[0])
    return pieces


def _require_few_steps(case: Case, name: str) -> None:
    """Check the steps of a load before there are arrays of them."""
    counts = [_count(segment) for segment in case.loads[name].history]
    if sum(counts) > MOST_STEPS:
        index = counts.index(max(counts))
        text = (
            f"expected at most {MOST_STEPS:,} steps in the history of a load, found "
            f"{sum(counts):,}, {counts[index]:,} of them here"
        )
        raise CaseError(complaint(case.source, ("loads", name, "history", index), text))


def _count(segment: Segment) -> int:
    match segment:
        case Ramp() | Hold():
            return segment.steps
        case Wave():
            return segment.cycles * (segment.steps_per_cycle + 2)
        case Points():
            return len(segment.times)
    return segment.repeat  # times rows


class _Invalid(Exception):
    """A segment that cannot follow; the key is relative to the segment."""

    def __init__(self, key: Key, text: str) -> None:
        super().__init__(text)
        self.key, self.text = key, text


def _piece(case: Case, segment: Segment, start: float, value: float) -> Piece:
    match segment:
        case Ramp():
            return _line(segment, start, value, segment.ramp)
        case Hold():
            return _line(segment, start, value, value)
        case Wave():
            return _wave(segment, start, value)
        case Points():
            times, values = np.array(segment.times), np.array(segment.values)
            return _table(times, values, start, value, ("times",))
        case CsvPoints():
            return _csv(case, segment, start, value)


def _csv(case: Case, segment: CsvPoints, start: float, value: float) -> Piece:
    """The rows of a file, as often as they are to follow one another."""
    path = case.resolve(segment.csv)
    try:
        times, values = read_columns(path, segment.time, segment.value, segment.separator)
    except CaseError as error:
        raise _Invalid(("csv",), str(error)) from None
    values = segment.scale * values + segment.offset
    if segment.repeat == 1:
        return _table(times, values, start, value, ("csv",))
    if len(times) == 1:
        raise _Invalid(("repeat",), f"expected two rows at least to be repeated in {path}")
    if abs(values[-1] - values[0]) > SAME_END * np.ptp(values):
        text = (
            f"expected the same first and last value in the column {segment.value!r} of {path}, so "
            f"that it can be repeated, found {values[0]:.10g} and {values[-1]:.10g}"
        )
        raise _Invalid(("repeat",), text)
    if len(times) * segment.repeat > MOST_STEPS:
        text = f"expected at most {MOST_STEPS:,} rows in all, found {len(times) * segment.repeat:,}"
        raise _Invalid(("repeat",), text)
    period = float(times[-1] - times[0])
    later = period * np.arange(1, segment.repeat)[:, None]
    times = np.append(times, times[1:] + later)
    values = np.append(values, np.tile(values[1:], segment.repeat - 1))
    return replace(_table(times, values, start, value, ("csv",)), period=period)


def _line(segment: Ramp | Hold, start: float, value: float, target: float) -> Piece:
    if segment.until - start <= SAME_TIME * start:
        raise _Invalid(
            ("until",),
            f"expected a time after {start:g}, where the segment starts, found {segment.until:g}",
        )
    steps = np.linspace(start, segment.until, segment.steps + 1)[1:]
    ends = ([start, segment.until], [value, target])
    return Piece(start, segment.until, steps, lambda time: np.interp(time, *ends))


def _wave(segment: Wave, start: float, value: float) -> Piece:
    def values(time: Array) -> Array:
        turns = (time - start) / segment.period + segment.phase / 360
        shape = _sine(turns) if segment.wave == "sine" else _triangle(turns)
        return segment.mean + segment.amplitude * shape

    first = float(values(np.array([start]))[0])
    _check_continuous(("wave",), start, value, first, abs(segment.mean) + abs(segment.amplitude))
    steps = start + segment.period * _wave_steps(segment)
    curved = segment.wave == "sine"
    return Piece(start, float(steps[-1]), steps, values, segment.period, curved)


def _wave_steps(segment: Wave) -> Array:
    """Step times of a wave in periods from its start: equal steps and the turning instants."""
    per_cycle = segment.steps_per_cycle
    equal = np.arange(1, segment.cycles * per_cycle + 1) / per_cycle
    first_turn = (0.25 - segment.phase / 360) % 0.5
    turns = first_turn + 0.5 * np.arange(2 * segment.cycles)
    # A turning instant within a millionth of a step from a step is that step.
    between = np.abs(turns * per_cycle - np.rint(turns * per_cycle)) > 1e-6
    return np.sort(np.concatenate([equal, turns[between]]))


def _sine(turns: Array) -> Array:
    # Without the whole turns every cycle has the same values to the last digit.
    return np.sin(2 * np.pi * (turns - np.floor(turns)))


def _triangle(turns: Array) -> Array:
    shifted = turns + 0.25
    return 1 - 4 * np.abs(shifted - np.floor(shifted) - 0.5)


def _table(times: Array, values: Array, start: float, value: float, key: Key) -> Piece:
    """Points joined by straight lines, the first one with where the channel stands."""
    gap = times[0] - start
    if gap < -SAME_TIME * start:
        raise _Invalid(
            key, f"expected times from {start:g} on, where the segment starts, found {times[0]:g}"
        )
    if gap <= SAME_TIME * start:
        scale = max(float(np.max(np.abs(values))), abs(value))
        _check_continuous(key, start, value, float(values[0]), scale)
        times, values = times[1:], values[1:]
    knots, ordinates = np.append(start, times), np.append(value, values)
    return Piece(start, float(knots[-1]), times, lambda time: np.interp(time, knots, ordinates))


def _check_continuous(key: Key, time: float, value: float, first: float, scale: float) -> None:
    if abs(first - value) <= SAME_VALUE * scale:
        return
    unloaded = " (at time 0 every load is 0: the unloaded state)" if time == 0 else ""
    raise _Invalid(
        key,
        f"expected the value {value:.10g} at time {time:g}, where the load stands{unloaded}, found "
        f"{first:.10g}: put a ramp to {first:.10g} before this segment",
    )
