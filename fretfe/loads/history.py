# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads on one clock: the functions of time of their segments, arrays, and the evaluated cycle."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import compress

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Case, CsvPoints, Hold, Points, Ramp, Segment, Wave, complaint
from fretfe.case.base import MOST_STEPS
from fretfe.errors import CaseError
from fretfe.loads.csv_file import read_columns
from fretfe.loads.friction import read_coefficients
from fretfe.loads.over_surface import read_gap, read_layer

Key = tuple[str | int, ...]

# Times closer than this fraction of the whole history are one time.
SAME_TIME = 1e-9
# A wave or table may start this fraction of its largest value away from where the load stands:
# values typed with seven digits are continuous.
SAME_VALUE = 1e-6
# The ends of a table that is repeated may differ by this fraction of its range; loads of less than
# this part of their largest value are round-off of nothing.
SAME_END = 1e-9
# Periods divide a cycle if their ratio is a whole number to this accuracy (periods are typed).
WHOLE_NUMBER = 1e-6
# A cycle is closed if no load differs by more than this fraction of its largest value.
CLOSED = 1e-6
# Parts of a step at whose ends the loads are known.
PARTS = 8


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
            piece = _piece(case, name, segment, time, value)
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


def _piece(case: Case, name: str, segment: Segment, start: float, value: float) -> Piece:
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
            return _csv(case, name, segment, start, value)


def _csv(case: Case, name: str, segment: CsvPoints, start: float, value: float) -> Piece:
    """The rows of a file, as often as they are to follow one another."""
    path, columns = case.resolve(segment.csv), (segment.time, segment.value)
    units: dict[str, str | tuple[str, ...]] = {segment.time: case.units.time}
    if segment.scale == 1:
        units[segment.value] = _load_units(case, name)
    try:
        times, values = read_columns(path, *columns, units, segment.separator)
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


def _load_units(case: Case, name: str) -> tuple[str, ...]:
    """Units of a load; with unit thickness forces are those per thickness too."""
    unit = case.loads[name].unit(case.units)
    if unit == case.units.force and case.geometry.solid is None and case.model.thickness == 1:
        return unit, f"{unit}/{case.units.length}"
    return (unit,)


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
    """First and last step of the cycle: given, that of the slowest wave, or the last mission.

    A given one may lie within a table that is repeated, as if all its rows were written out.

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
        waves = {(name, index): piece for (name, index), piece in waves.items()
                 if isinstance(case.loads[name].history[index], Wave)}  # fmt: skip
    elif waves:
        slowest = max(waves.values(), key=lambda wave: (wave.period, wave.end))
        start, end = slowest.end - (slowest.period or 0.0), slowest.end
    else:
        return _mission(case, times, values)
    _check_periods(case, start, end, waves)
    first, last = (int(np.argmin(np.abs(times - time))) for time in (start, end))
    if case.cycle.given is None:
        _check_closed(case, times, values, first, last)
    return first, last


def _mission(case: Case, times: Array, values: Array) -> tuple[int, int] | None:
    """First and last step of the last time at which the loads rise from zero and return to it.

    None if they never return, if a load is larger behind that, or friction does not act from the
    beginning on: what comes before a state without any load has no part in what comes behind it.
    """
    size = np.abs(values)
    resting = np.flatnonzero((size <= CLOSED * size.max(axis=0)).all(axis=1))
    flights = np.flatnonzero(np.diff(resting) > 1)
    if not len(flights):
        return None
    first, end = (int(each) for each in resting[flights[-1] : flights[-1] + 2])
    largest = size[first : end + 1].max(axis=0)
    if (size[end:] > largest * (1 + CLOSED)).any():
        return None
    rough = all(each.friction_from <= times[first] for each in case.contacts.values())
    return (first, end) if rough else None


def _named_times(case: Case) -> Iterator[tuple[Key, float]]:
    for name, contact in case.contacts.items():
        yield ("contacts", name, "friction_from"), contact.friction_from
    if case.start is not None:
        yield ("start", "time"), case.start.time
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


class CycleChoice(StrEnum):
    """The rule by which the evaluated cycle was chosen."""

    GIVEN = "given"
    """By `[cycle]` of the case."""
    OTHER_RUN = "other run"
    """By `[cycle]` of a part that follows the run it is cut from."""
    LAST_PERIOD = "last period"
    """The last whole period of the slowest wave."""
    LAST_REPETITION = "last repetition"
    """The last whole repetition of the table with the longest period; no load is a wave."""
    MISSION = "mission"
    """The last part of loads without waves that begins and ends with all loads zero."""
    ADDED = "added"
    """The last whole one of the cycles that were added behind one of the above."""


@dataclass(frozen=True)
class History:
    """All channels on one clock.

    Attributes:
        channels: names of the loads, in the order of the case file.
        times: (T,) increasing; ``times[0] == 0``.
        values: (T, C), in the units of each load; row 0 is zero: the unloaded state.
        cycle: first and last step index of the cycle that is evaluated, if there is one.
        between: (T-1, PARTS-1, C) values within each of the steps, at equal distances in time; None
            if all loads are straight lines there, or not known.
        choice: the reason for this cycle; None without one, or of loads that no case describes.
    """

    channels: tuple[str, ...]
    times: Array
    values: Array
    cycle: tuple[int, int] | None
    between: Array | None = None
    choice: CycleChoice | None = None

    @property
    def evaluated(self) -> tuple[int, int]:
        """First and last state of the evaluated cycle, or of everything without one."""
        return self.cycle or (0, len(self.times) - 1)

    def at(self, time: float) -> Array:
        """Values (C,) at a time, linear between steps and constant after the last one."""
        return np.array([np.interp(time, self.times, column) for column in self.values.T])

    def step(self, time: float) -> int:
        """Index of the step at a time, the nearest one if there is none."""
        return int(np.argmin(np.abs(self.times - time)))

    def prolonged(self, count: int) -> History:
        """The loads with their cycle, which ends them, so many times more."""
        if not count or self.cycle is None:
            return self
        first, last = self.cycle
        period = self.times[last] - self.times[first]
        later = period * np.arange(1, count + 1)[:, None]
        between = self.between
        if between is not None:
            between = np.concatenate([between, *[between[first:last]] * count])
        return replace(
            self,
            times=np.append(self.times, self.times[first + 1 : last + 1] + later),
            values=np.concatenate([self.values, *[self.values[first + 1 : last + 1]] * count]),
            between=between,
        )

    @property
    def returns(self) -> bool:
        """True if there is a cycle to evaluate, and every load is at its end what it was before."""
        return self.cycle is not None and not self.open_channels

    @property
    def open_channels(self) -> tuple[str, ...]:
        """Loads that do not return in the cycle, as one that `[cycle]` gives may have them."""
        first, last = self.values[list(self.cycle or (0, 0))]
        drifts = np.abs(last - first) > CLOSED * np.abs(self.values).max(axis=0)
        return tuple(compress(self.channels, drifts))

    def until(self, step: int, later: int = 0) -> History:
        """The loads until a step.

        Args:
            step: the last one that is kept.
            later: so many of the cycles that were added lie between the cycle of these loads and
                the one to evaluate, or are that one; 0 for the same cycle.
        """
        cycle, between, choice = self.cycle, self.between, self.choice
        if cycle is not None and later:
            first, last = cycle
            moved = later * (last - first)
            cycle, choice = (first + moved, last + moved), CycleChoice.ADDED
        return replace(
            self,
            times=self.times[: step + 1],
            values=self.values[: step + 1],
            cycle=cycle,
            between=None if between is None else between[:step],
            choice=choice,
        )

    def divided(self, steps: Indices, shares: Array) -> History:
        """The same loads on a finer clock.

        Args:
            steps: (n,) number of the step in which each state of the finer clock lies.
            shares: (n,) of the step, in (0, 1], at which it is reached: 1 at its end.
        """
        if np.all(shares == 1.0) and np.array_equal(steps, np.arange(len(self.times))):
            return self
        ends = np.flatnonzero(shares == 1.0)
        between = None
        if self.between is not None:
            begin = np.where(np.append(-1, steps[:-1]) == steps, np.append(0.0, shares[:-1]), 0.0)
            places = begin[1:, None] + (shares - begin)[1:, None] * np.arange(1, PARTS) / PARTS
            inner = within_steps(
                self.values, self.between, np.repeat(steps[1:], PARTS - 1), places.ravel()
            )
            between = inner.reshape(len(steps) - 1, PARTS - 1, len(self.channels))
        cycle = choice = None
        if self.cycle is not None and self.cycle[1] < len(ends):
            cycle = (int(ends[self.cycle[0]]), int(ends[self.cycle[1]]))
            choice = self.choice
        return replace(
            self,
            times=within_steps(self.times[:, None], None, steps, shares)[:, 0],
            values=within_steps(self.values, self.between, steps, shares),
            cycle=cycle,
            between=between,
            choice=choice,
        )


def within_steps(values: Array, between: Array | None, steps: Indices, shares: Array) -> Array:
    """(n, C) values at shares (n,) of steps (n,).

    Each load follows one smooth segment within a step, as all kinks are at the ends of steps.

    Args:
        values: (T, C) at the ends of the steps.
        between: (T-1, PARTS-1, C) within them, as of `History`; None for straight lines.
        steps: (n,) numbers of steps.
        shares: (n,) of them, in (0, 1].
    """
    found = values[steps].astype(float)
    inside = np.flatnonzero(shares < 1.0)
    own = steps[inside]
    ends = values[own - 1], values[own]
    if between is None:
        share = shares[inside, None]
        found[inside] = (1 - share) * ends[0] + share * ends[1]
    else:
        points = np.concatenate([ends[0][:, None], between[own - 1], ends[1][:, None]], axis=1)
        found[inside] = np.einsum("np,npc->nc", _lagrange(shares[inside]), points)
    return found


def build_history(case: Case) -> History:
    """Put the histories of all loads on one clock.

    The clock is the sorted union of the step times of all channels. Every channel is evaluated at
    every step, waves exactly, and keeps its value after its last segment.

    Raises:
        CaseError: a segment ends before it starts or does not continue the one before, a table or
            CSV file is not usable, there is no step at all, steps are too close for a history of
            this length, several loads turn the bodies at once, a time that the case names
            (friction_from, cycle, output.fields) is not that of a step, or friction over time does
            not cover the history. Problems of different loads are listed together.
    """
    channels: dict[str, list[Piece]] = {}
    problems: list[str] = []
    for name in case.loads:
        try:
            channels[name] = read_pieces(case, name)
        except CaseError as error:
            problems.append(str(error))
    if problems:
        raise CaseError("\n".join(problems))
    times = _clock([piece for pieces in channels.values() for piece in pieces])
    if len(times) == 1:
        text = "expected a load with at least one step after time 0, found none"
        raise CaseError(complaint(case.source, ("loads",), text))
    _require_apart(case, channels, times[-1])
    values = np.column_stack([_evaluate(pieces, times) for pieces in channels.values()])
    _require_one_rotation(case, times, values)
    check_times(case, times)
    for name in case.contacts:
        read_coefficients(case, name).require_times(float(times[-1]))
        read_gap(case, name)
        read_layer(case, name)
    cycle = find_cycle(case, times, values, channels)
    choice = None if cycle is None else _choice(case, channels)
    return History(tuple(channels), times, values, cycle, _between(channels, times), choice)


def _choice(case: Case, channels: Mapping[str, Sequence[Piece]]) -> CycleChoice:
    """The rule by which the cycle of some loads was found."""
    if case.cycle.given is not None:
        return CycleChoice.OTHER_RUN if case.cut_loads else CycleChoice.GIVEN
    if all(piece.period is None for pieces in channels.values() for piece in pieces):
        return CycleChoice.MISSION
    entries = (entry for load in case.loads.values() for entry in load.history)
    waves = any(isinstance(entry, Wave) for entry in entries)
    return CycleChoice.LAST_PERIOD if waves else CycleChoice.LAST_REPETITION


def _lagrange(shares: Array) -> Array:
    """(n, PARTS+1) weights of values at equal distances within a step, at shares (n,) of it.

    Those of the polynomial through all of them: of a sine with 7 steps a cycle it is right to 1e-9.
    """
    nodes = np.arange(PARTS + 1) / PARTS
    signs = [(-1) ** j * math.comb(PARTS, j) for j in range(PARTS + 1)]
    distance = shares[:, None] - nodes
    at_node = np.abs(distance) < 1e-14
    # The barycentric form, which is not defined at the nodes themselves.
    parts = np.array(signs) / np.where(at_node, 1.0, distance)
    weights = parts / parts.sum(axis=1, keepdims=True)
    return np.where(at_node.any(axis=1, keepdims=True), at_node.astype(float), weights)


def _between(channels: Mapping[str, Sequence[Piece]], times: Array) -> Array | None:
    """(T-1, PARTS-1, C) values of all loads within the steps; None if all are straight lines."""
    if not any(piece.curved for pieces in channels.values() for piece in pieces):
        return None
    shares = np.arange(1, PARTS) / PARTS
    instants = (times[:-1, None] + np.diff(times)[:, None] * shares).ravel()
    values = np.column_stack([_evaluate(pieces, instants) for pieces in channels.values()])
    return values.reshape(len(times) - 1, PARTS - 1, len(channels))


def _clock(pieces: Sequence[Piece]) -> Array:
    """Sorted union of all step times and 0; of times that are the same the earliest is kept."""
    times = np.unique(np.concatenate([np.zeros(1), *(piece.steps for piece in pieces)]))
    tolerance = SAME_TIME * times[-1]
    if len(times) == 1 or np.diff(times).min() > tolerance:
        return times
    kept = [0.0]
    for time in times:
        if time - kept[-1] > tolerance:
            kept.append(float(time))
    return np.array(kept)


def _require_apart(case: Case, channels: Mapping[str, Sequence[Piece]], end: float) -> None:
    """Check that the steps of each segment are not one and the same time on the common clock."""
    for name, pieces in channels.items():
        for index, piece in enumerate(pieces):
            spacing = (piece.end - piece.start) / len(piece.steps)
            if spacing <= SAME_TIME * end:
                text = (
                    f"expected steps more than {SAME_TIME:g} of the whole history apart, found "
                    f"{spacing:.4g} in a history that ends at {end:.4g}: they would be one time"
                )
                raise CaseError(complaint(case.source, ("loads", name, "history", index), text))


def _require_one_rotation(case: Case, times: Array, values: Array) -> None:
    """Check that speeds are not to be added: the force goes with the square of their sum."""
    turning = [load.body_force and load.about is not None for load in case.loads.values()]
    both = np.flatnonzero(np.count_nonzero(values[:, turning], axis=1) > 1)
    if both.size:
        names = " and ".join(compress(case.loads, turning))
        text = (
            f"expected one load of the type rotation at a time, found {names} at time "
            f"{times[both[0]]:g}: the force goes with the square of the whole speed, so give that "
            "by one of them"
        )
        raise CaseError(complaint(case.source, ("loads",), text))


def _evaluate(pieces: Sequence[Piece], times: Array) -> Array:
    values = np.zeros_like(times)
    for piece in pieces:
        after = times > piece.start
        values[after] = piece.value(np.minimum(times[after], piece.end))
    return np.where(np.abs(values) > SAME_END * np.abs(values).max(), values, 0.0)
