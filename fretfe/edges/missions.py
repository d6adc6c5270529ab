# SPDX-License-Identifier: LGPL-3.0-or-later
"""Irregular loads at a station: its cycles by the rainflow method, and the worst of them.

An edge slips forward where K_T - f K_I exceeds what it was, and backward where K_T + f K_I falls
below. Each place inward from the edge remembers the reversals of the two as a play does, so that
the range from a forward to a backward reversal, over f K_N, is how far slip reaches in between.
Counted are therefore the peaks of the one and the valleys of the other, with K_I from the outermost
place of the edge on; at constant P both are K_T.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.rainflow import rainflow
from fretfe.edges.front import CountedCycles, StationHistory
from fretfe.edges.reversals import slip_phases

# Ends of a cycle that differ by less than this fraction of the range are the same state.
CLOSED = 1e-2
# Extremes that differ by less than this fraction of the range are equal.
EQUAL = 1e-6


@dataclass(frozen=True)
class Worst:
    """The cycle that an edge under irregular loads is judged by.

    Attributes:
        half_cycles: first and last state of each, in time order.
        predicted: slip length by its range.
        outer: (T,) whether the step to each state belongs to the way from reversal to reversal,
            and not to a smaller cycle in between; true outside of the half cycles.
    """

    half_cycles: tuple[tuple[int, int], ...]
    predicted: float
    outer: Bools


@dataclass(frozen=True)
class _Slip:
    """What drives the slip of an edge.

    Attributes:
        forward, backward: (T,) K_T - f K_I and K_T + f K_I.
        begin: first state from which on they are known, and there is friction.
        fresh: whether nothing has slipped before that state.
    """

    forward: Array
    backward: Array
    begin: int
    fresh: bool

    def reached(self, states: Indices | int, way: int) -> Array:
        """How far slip one way, 1 or -1, is driven in some states."""
        return np.asarray(self.forward[states] if way > 0 else -self.backward[states])


def count_cycles(cycle: Indices, friction: Array, station: StationHistory) -> CountedCycles:
    """Count the cycles of a station.

    Args:
        cycle: states of the evaluated cycle; empty to count the whole history.
        friction: (T,) coefficient in the step that ends at each state.
        station: its factors.
    """
    known = np.isfinite(station.k_t) & np.isfinite(station.k_i)
    if not friction.any():
        return _nothing("there is no friction")
    first = max(int(np.argmax(friction > 0)) - 1, 0)
    states = cycle if len(cycle) else np.arange(max(first, int(np.argmax(known))), len(known))
    unknown = states[~known[states]]
    if len(unknown):
        return _nothing(
            f"K_T is unknown in {len(unknown)} of {len(states)} states, first in state {unknown[0]}"
        )
    if len(states) < 2:
        return _nothing("nothing varies")
    if friction[states[1:]].min(initial=np.inf) == 0:
        return _nothing("there is no friction in a part of the cycle")
    slip = _slip(states, friction, station)
    order, closed = _order(states, slip) if len(cycle) else (states, False)
    ends, directions = slip_phases(slip.forward[order], slip.backward[order])
    if not len(ends):
        return _nothing("nothing varies")
    turns = order[np.append(0, ends)]
    upward = np.append(-directions[0], directions) > 0
    values = np.where(upward, slip.forward[turns], slip.backward[turns])
    # The repetition itself leads from the last reversal, which is the first one, on.
    counted = rainflow(values[:-1] if closed else values, repeated=closed)
    start, end = turns[counted.start], turns[counted.end]
    reach = counted.range
    if slip.fresh and not len(cycle):
        reach = np.maximum(reach, _first_loading(values)[counted.end])
    retreat = 2 * friction.max() * (station.k_i[states].max() - station.k_i[end])
    return CountedCycles(
        start=start,
        end=end,
        count=counted.count,
        k_t_range=np.abs(station.k_t[end] - station.k_t[start]),
        k_t_mean=(station.k_t[end] + station.k_t[start]) / 2,
        effective_range=counted.range,
        slip=np.maximum(reach - retreat, 0.0) / (friction.max() * station.k_n[end]),
        closed=closed,
        reason="",
    )


def _nothing(reason: str) -> CountedCycles:
    none, states = np.zeros(0), np.zeros(0, dtype=np.int64)
    return CountedCycles(states, states, none, none, none, none, none, False, reason)


def _slip(states: Indices, friction: Array, station: StationHistory) -> _Slip:
    """What drives the slip, with K_I from its largest value in some states on."""
    first = max(int(np.argmax(friction > 0)) - 1, 0)
    normal = friction.max() * (station.k_i - station.k_i[states].max())
    forward, backward = station.k_t - normal, station.k_t + normal
    gaps = np.flatnonzero(~np.isfinite(forward[: states[0] + 1]))
    begin = max(first, int(gaps[-1]) + 1 if len(gaps) else 0)
    return _Slip(forward, backward, begin, fresh=begin == first)


def _order(states: Indices, slip: _Slip) -> tuple[Indices, bool]:
    """States of a cycle as they are counted, and whether they repeat themselves.

    A cycle that returns to where it began is counted from its largest load on, to itself.
    """
    signals = np.array([slip.forward[states], slip.backward[states]])
    drift = np.abs(signals[:, -1] - signals[:, 0])
    if (drift > CLOSED * np.ptp(signals, axis=1).max()).any():
        return states, False
    period = states[1:]
    largest = int(np.argmax(slip.forward[period]))
    return np.append(np.roll(period, -largest), period[largest]), True


def _first_loading(values: Array) -> Array:
    """(n,) twice the load at each reversal from the first on if it is the largest yet, else 0.

    Beyond all that was before, slip reaches as far as if the load had grown from nothing.
    """
    loads = np.abs(values - values[0])
    return np.asarray(np.where(loads >= np.maximum.accumulate(loads), 2 * loads, 0.0))


def worst_path(
    cycles: CountedCycles, cycle: Indices, friction: Array, station: StationHistory
) -> Indices:
    """(n,) states on the way through the worst cycle, without those in smaller ones.

    Empty if all cycles of the station are alike; arguments as for `worst_cycle`.
    """
    worst = worst_cycle(cycles, cycle, friction, station)
    if worst is None:
        return np.zeros(0, dtype=np.int64)
    first, last = worst.half_cycles[0][0], worst.half_cycles[-1][1]
    steps = np.arange(first + 1, last + 1)
    return np.append(first, steps[worst.outer[steps]])


def worst_cycle(
    cycles: CountedCycles, cycle: Indices, friction: Array, station: StationHistory
) -> Worst | None:
    """The largest counted cycle of a station; None if all its cycles are alike.

    Args:
        cycles: as counted.
        cycle: states of the evaluated cycle; empty without one.
        friction: (T,) coefficient in the step that ends at each state.
        station: its factors.
    """
    if not cycles.irregular:
        return None
    number = cycles.worst
    start, end = sorted((int(cycles.start[number]), int(cycles.end[number])))
    states = cycle if len(cycle) else np.arange(start, len(station.k_t))
    slip = _slip(states, friction, station)
    # A range from backward to forward reversal is the larger one that way round.
    upward = slip.forward[end] - slip.backward[start]
    way = 1 if upward > slip.forward[start] - slip.backward[end] else -1
    halves = _closed_halves(end, way, len(cycle) - 1, slip) if cycles.closed else ((start, end),)
    outer = np.ones(len(station.k_t), dtype=bool)
    for half, sense in zip(reversed(halves), (way, -way), strict=False):
        outer[half[0] + 1 : half[1] + 1] = _outer_steps(slip, *half, sense)
    return Worst(halves, float(cycles.slip[number]), outer)


def _closed_halves(last: int, way: int, period: int, slip: _Slip) -> tuple[tuple[int, int], ...]:
    """Half cycles that end at the later reversal of a cycle and at the one before it.

    The first of them is left out if the history before the cycle does not reach as far.

    Args:
        last: state of the later reversal.
        way: in which slip goes until then.
        period: number of steps of the cycle.
        slip: what drives it.
    """
    middle = _previous(last, -way, period, slip)
    halves = ((middle, last),)
    if middle == slip.begin:
        return halves
    first = _previous(middle, way, period, slip)
    size = slip.reached(last, way) + slip.reached(middle, -way)
    missing = slip.reached(last, way) - slip.reached(first, way)
    return halves if missing > CLOSED * size else ((first, middle), *halves)


def _previous(state: int, way: int, period: int, slip: _Slip) -> int:
    """Last state within a period before another one in which slip is driven farthest one way."""
    window = np.arange(max(slip.begin, state - period), state)
    reached = slip.reached(window, way)
    equal = reached >= reached.max() - EQUAL * np.ptp(slip.forward[window])
    return int(window[np.flatnonzero(equal)[-1]])


def _outer_steps(slip: _Slip, start: int, end: int, way: int) -> Bools:
    """(end - start,) steps between two states that drive slip one way farther than before."""
    inside = slice(start, end + 1)
    ends, ways = slip_phases(slip.forward[inside], slip.backward[inside])
    reached = slip.reached(np.arange(start, end + 1), way)
    before = np.full(len(reached), -np.inf)
    peaks = ends[ways == way]
    before[peaks] = reached[peaks]
    return np.asarray(reached[1:] > np.maximum.accumulate(before)[:-1])
