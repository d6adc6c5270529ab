# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles: whether the evaluated one is steady, where slip turns round, those of irregular loads.

An edge slips forward where K_T - f K_I exceeds what it was, and backward where K_T + f K_I falls
below. Each place inward from the edge remembers the reversals of the two as a play does: at
constant P the range of K_T from a forward to a backward reversal, over f K_N, is how far slip
reaches in between. Where P moves the edge `edge_memory` tells that. Counted is K_T.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic._numerics import check_positive
from fretfe.analytic.paths import rainflow
from fretfe.evaluate.contacts import ROUND_OFF, SAME_RANGE, CountedCycles, StationHistory, no_cycles
from fretfe.evaluate.edge_memory import NO_FALL, longest_zones, slip_drive, takes_away
from fretfe.evaluate.numerics import most_loaded
from fretfe.history.solution import Solution
from fretfe.history.state_array import StateArray, blocks
from fretfe.loads import CycleChoice
from fretfe.surface.friction import Friction

# Changes below this fraction of the range are no reversal.
TOLERANCE = 1e-6
# Ends of a cycle that differ by less than this fraction of the range are the same state.
CLOSED = 1e-2
# Extremes that differ by less than this fraction of the range are equal.
EQUAL = 1e-6
# Change of the shear from one cycle to the next, relative to f p_max, below which it is steady.
STEADY_CHANGE = 1e-3
# Cycles that are compared, and the fraction of the largest load within which loads are the same.
MOST_CYCLES = 3
SAME_LOAD = 1e-9
# A change that is at least so large a part of the one before does not fall.
FALLING = 0.98


def slip_phases(drive: Array, forward: Array, backward: Array) -> tuple[Indices, Indices]:
    """Last states of the phases in which slip goes one way, in time order.

    Of a plateau the first state counts. Between two phases an edge may stick. It slips the same way
    in both if it has covered new places in between, on which slip does not come to that before.

    Args:
        drive: (T,) of slip, as of `slip_drive`.
        forward: (T,) K_T - f K_I.
        backward: (T,) K_T + f K_I.

    Returns:
        (n,) ends, and (n,) directions: 1 forward, -1 backward. The last phase may not be complete.
    """
    least = TOLERANCE * float(max(np.ptp(forward), np.ptp(backward)))
    phases = [(0, 0)]  # end and direction
    for state, value in enumerate(drive.tolist()):
        end, _ = phases[-1]
        if abs(value - drive[end]) <= least:
            continue
        way = 1 if value > drive[end] else -1
        reached = forward if way > 0 else -backward
        while phases[-1][1] == way and reached[state] >= reached[phases[-1][0]] - least:
            phases.pop()
        phases.append((state, way))
    found = np.array(phases, dtype=np.int64)[1:]
    return found[:, 0], found[:, 1]


@dataclass(frozen=True)
class Worst:
    """The cycle that an edge under irregular loads is judged by.

    Attributes:
        half_cycles: first and last state of each, in time order.
        predicted: slip length by its range; NaN where P moves the edge.
        steps: of each half cycle (T,) whether the step to each state belongs to the way from
            reversal to reversal, and not to a smaller cycle in between; true outside of it.
    """

    half_cycles: tuple[tuple[int, int], ...]
    predicted: float
    steps: tuple[Bools, ...]

    @property
    def outer(self) -> Bools:
        """(T,) whether the step to each state belongs to one of the ways, or lies outside."""
        found, within = np.zeros((2, len(self.steps[0])), dtype=bool)
        for (start, end), steps in zip(self.half_cycles, self.steps, strict=True):
            half = slice(start + 1, end + 1)
            found[half] |= steps[half]
            within[half] = True
        return np.asarray(found | ~within)

    def apart(self) -> tuple[Worst, ...]:
        """Each half cycle alone: one may lie within the other where P moves the edge."""
        return tuple(
            Worst((half,), self.predicted, (steps,))
            for half, steps in zip(self.half_cycles, self.steps, strict=True)
        )


@dataclass(frozen=True)
class _Slip:
    """The drivers of the slip of an edge.

    Attributes:
        forward, backward: (T,) K_T - f K_I and K_T + f K_I.
        drive: (T,) of slip, up to the last of the states that are looked at; NaN where not known.
        begin: first state from which on they are known, and there is friction.
    """

    forward: Array
    backward: Array
    drive: Array
    begin: int

    def pressed(self, end: int, least: float) -> _Slip:
        """The same from where P last is what it is in a state, but for what moves edges by `least`.

        What drives slip while P grows is no reversal of what comes then.
        """
        retreat = (self.forward - self.backward)[self.begin : end + 1] / 2
        lower = np.flatnonzero(retreat > least)
        return replace(self, begin=self.begin + int(lower[-1]) + 1) if len(lower) else self

    def reached(self, states: Indices | int, way: int) -> Array:
        """Largest drive of slip one way, 1 or -1, in some states."""
        return np.asarray(self.forward[states] if way > 0 else -self.backward[states])


def count_cycles(
    cycle: Indices, friction: Array, station: StationHistory, returns: bool = False
) -> CountedCycles:
    """Count the cycles of a station.

    Args:
        cycle: states of the evaluated cycle; empty to count the whole history.
        friction: (T,) coefficient in the step that ends at each state.
        station: its factors.
        returns: whether all loads return in the cycle. Increments of an edge that moves need not
            add up to nothing then: K_T goes on from cycle to cycle, and slip does not.
    """
    known = np.isfinite(station.k_t) & np.isfinite(station.k_i)
    if not friction.any():
        return no_cycles("there is no friction")
    first = max(int(np.argmax(friction > 0)) - 1, 0)
    states = cycle if len(cycle) else np.arange(max(first, int(np.argmax(known))), len(known))
    unknown = states[~known[states]]
    if len(unknown):
        return no_cycles(f"K_T is unknown in {len(unknown)} of {len(states)} states")
    if len(states) < 2:
        return no_cycles("nothing varies")
    if friction[states[1:]].min(initial=np.inf) == 0:
        return no_cycles("there is no friction in a part of the cycle")
    order, closed = _order(states, station.k_t, returns) if len(cycle) else (states, False)
    k_t = _without_drift(station.k_t, states)[order] if closed else station.k_t[order]
    ends, _ = slip_phases(k_t, k_t, k_t)
    if not np.ptp(k_t) > ROUND_OFF * friction.max() * np.ptp(station.k_i[states]):
        return no_cycles("nothing varies")
    turns = np.append(0, ends)
    # The repetition itself leads from the last reversal, which is the first one, on.
    counted = rainflow(k_t[turns[:-1]] if closed else k_t[turns], repeated=closed)
    start, end = order[turns[counted.start]], order[turns[counted.end]]
    reach = counted.range
    if not len(cycle) and int(states[0]) == first:
        reach = np.maximum(reach, _first_loading(k_t[turns])[counted.end])
    f_k_i = friction.max() * station.k_i
    if takes_away(f_k_i[states].max() - f_k_i[states], k_t):
        ways = np.sort([start, end], axis=0).T
        moved = np.array([np.ptp(f_k_i[first : last + 1]) for first, last in ways])
        reach = np.where(moved <= CLOSED * counted.range, reach, np.nan)
    return CountedCycles(
        start=start,
        end=end,
        count=counted.count,
        k_t_range=np.abs(station.k_t[end] - station.k_t[start]),
        k_t_mean=(station.k_t[end] + station.k_t[start]) / 2,
        slip=reach / (friction.max() * station.k_n[end]),
        closed=closed,
        reason="",
    )


def _order(states: Indices, k_t: Array, returns: bool) -> tuple[Indices, bool]:
    """States of a cycle as they are counted, and whether they repeat themselves.

    A cycle that returns to where it began is counted from its largest K_T on, to itself.
    """
    if not returns and abs(k_t[states[-1]] - k_t[states[0]]) > CLOSED * np.ptp(k_t[states]):
        return states, False
    period = states[1:]
    largest = int(np.argmax(k_t[period]))
    return np.append(np.roll(period, -largest), period[largest]), True


def _without_drift(k_t: Array, states: Indices) -> Array:
    """(T,) K_T that returns in a cycle: increments of an edge that moves add up to a drift."""
    returned = k_t.copy()
    returned[states] -= np.linspace(0.0, k_t[states[-1]] - k_t[states[0]], len(states))
    return returned


def _first_loading(values: Array) -> Array:
    """(n,) twice the load at each reversal from the first on if it is the largest yet, else 0.

    Beyond all that was before, slip reaches as far as if the load had grown from nothing.
    """
    loads = np.abs(values - values[0])
    before = np.append(0.0, np.maximum.accumulate(loads)[:-1])
    return np.asarray(np.where(loads > (1 + SAME_RANGE) * before, 2 * loads, 0.0))


def _slip(states: Indices, friction: Array, station: StationHistory) -> _Slip:
    """The drivers of the slip, with K_I from its largest value in some states on."""
    first = max(int(np.argmax(friction > 0)) - 1, 0)
    normal = friction.max() * (station.k_i - station.k_i[states].max())
    forward, backward = station.k_t - normal, station.k_t + normal
    gaps = np.flatnonzero(~np.isfinite(forward[: states[0] + 1]))
    begin = max(first, int(gaps[-1]) + 1 if len(gaps) else 0)
    inside = slice(begin, int(states.max()) + 1)
    drive = np.full(len(forward), math.nan)
    drive[inside] = slip_drive(station.k_t[inside], friction.max() * station.k_i[inside])
    return _Slip(forward, backward, drive, begin)


def worst_path(
    cycles: CountedCycles, cycle: Indices, friction: Array, station: StationHistory
) -> Indices:
    """(n,) states on the way through the worst cycle, without those in smaller ones.

    Empty if all cycles of the station are alike, or P moves its edge: what P does counts, too.
    Arguments as for `worst_cycle`.
    """
    worst = worst_cycle(cycles, cycle, friction, station)
    if worst is None or not math.isfinite(worst.predicted):
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
    f_k_i = friction.max() * station.k_i
    if takes_away(f_k_i[states].max() - f_k_i[states], station.k_t[states]):
        ways, predicted = _longest_ways(slip, f_k_i, station, cycle), math.nan
        if not ways:
            return None
    else:
        slip = slip.pressed(end, NO_FALL * float(np.ptp(station.k_t[states])))
        # A range from backward to forward reversal is the larger one that way round.
        upward = slip.forward[end] - slip.backward[start]
        way = 1 if upward > slip.forward[start] - slip.backward[end] else -1
        period = len(cycle) - 1
        halves = _closed_halves(end, way, period, slip) if cycles.closed else ((start, end),)
        ways = tuple(zip(halves, (-way, way)[-len(halves) :], strict=True))
        predicted = float(cycles.slip[number])
    masks = np.ones((len(ways), len(station.k_t)), dtype=bool)
    for mask, (half, sense) in zip(masks, ways, strict=True):
        mask[half[0] + 1 : half[1] + 1] = _outer_steps(slip, *half, sense)
    return Worst(tuple(half for half, _ in ways), predicted, tuple(masks))


def _longest_ways(
    slip: _Slip, f_k_i: Array, station: StationHistory, cycle: Indices
) -> tuple[tuple[tuple[int, int], int], ...]:
    """Half cycles with the longest slip zones, in time order, and which way slip goes in each."""
    begin, last = slip.begin, int(cycle[-1]) if len(cycle) else len(station.k_t) - 1
    known = slice(begin, last + 1)
    first = int(cycle[0]) - begin if len(cycle) else 0
    k_n = station.k_n[known]
    # Where it is not known its largest value ranks them well enough.
    k_n = np.where(k_n > 0, k_n, np.nanmax(k_n, initial=0.0) or 1.0)
    found = longest_zones(station.k_t[known], f_k_i[known], k_n, slip.drive[known], first)
    ways = [
        ((half[0] + begin, half[1] + begin), way)
        for half, way in zip(found, (1, -1), strict=True)
        if half is not None
    ]
    return tuple(sorted(ways, key=lambda each: each[0][1]))


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
    inside = np.arange(start, end + 1)
    ends, ways = slip_phases(slip.drive[inside], slip.forward[inside], slip.backward[inside])
    turns = np.diff(ways, prepend=0) != 0
    reached = slip.reached(inside, way)
    before = np.full(len(reached), -np.inf)
    peaks = ends[turns & (ways == way)]
    before[peaks] = reached[peaks]
    return np.asarray(reached[1:] > np.maximum.accumulate(before)[:-1])


def cycle_changes(
    solution: Solution,
    traction: StateArray | NDArray[np.float64],
    friction: Friction,
    weights: Array,
) -> list[float]:
    """Largest changes of the shear over cycles, relative to f p_max of the evaluated one.

    Args:
        solution: the solved history.
        traction: (T, N, d) of a contact, the pressure first.
        friction: of it.
        weights: (N,) of its nodes.

    Returns:
        That of the evaluated cycle, and those of a few cycles before it under the same loads, the
        latest first; NaN alone if there is no cycle, pressure or friction.
    """
    cycles = _same_cycles(solution, friction)
    if not cycles:
        return [math.nan]
    states = np.arange(cycles[0][0], cycles[0][1] + 1)
    forces = [
        traction[states[part], :, 0] @ weights for part in blocks(len(states), traction[0].size)
    ]
    state = int(states[most_loaded(np.concatenate(forces), np.arange(len(states)))])
    pressure = traction[state][:, 0]
    largest, bound = float(pressure.max()), float((friction.at(state) * pressure).max())
    if bound <= 0:
        return [math.nan]
    return [
        cycle_change(traction[end][:, 1:], traction[begin][:, 1:], bound / largest, largest)
        for begin, end in cycles
    ]


def _same_cycles(solution: Solution, friction: Friction) -> list[tuple[int, int]]:
    """First and last state of the evaluated cycle and of the same ones before it, latest first."""
    if solution.cycle is None:
        return []
    # By the ends of steps: how steps are divided may differ from cycle to cycle.
    ends = solution.ends
    values, number = solution.values[ends], friction.number[ends]
    first, last = (solution.step_of(state) for state in solution.cycle)
    found = [(first, last)]
    period, scale = last - first, np.abs(values).max(axis=0)
    while len(found) < MOST_CYCLES and found[-1][0] >= period:
        end = found[-1][0]
        begin = end - period
        difference = np.abs(values[begin : end + 1] - values[first : last + 1])
        sliding = number[begin + 1 : end + 1]
        if np.any(difference > SAME_LOAD * scale) or np.any(sliding != number[last]):
            break
        found.append((begin, end))
    return [(int(ends[begin]), int(ends[end])) for begin, end in found]


def may_become_steady(changes: Sequence[Sequence[float]]) -> bool:
    """True if some contact is not steady, and more cycles may help: no change stays what it was.

    Args:
        changes: for each contact as of `cycle_changes`.
    """
    unsteady = [each for each in changes if each[0] >= STEADY_CHANGE]
    lasting = (
        len(each) == MOST_CYCLES
        and all(late > FALLING * early for late, early in itertools.pairwise(each))
        for each in unsteady
    )
    return bool(unsteady) and not any(lasting)


# Places of more cycles, by the choice of the evaluated one; else at the end.
WHERE = {
    CycleChoice.GIVEN: " before the one in [cycle]",
    CycleChoice.OTHER_RUN: " to the case of the run that the cuts follow, and cut it again",
}


def unsteady_text(changes: Sequence[float], choice: CycleChoice | None = None) -> str:
    """Say that a cycle is not steady, and how many more it takes; empty if it is.

    Args:
        changes: as of `cycle_changes`.
        choice: of the cycle.
    """
    where = "" if choice is None else WHERE.get(choice, "")
    now, *before = changes
    if not now >= STEADY_CHANGE:
        return ""
    found = f"not in steady state: the shear changes by {now:.2g} f p_max over the evaluated cycle"
    if not before:
        return f"{found}; add a cycle{where}: the changes over two say about how many it takes"
    # The slower fall of the last two: the first one, out of the unloaded state, is the fastest.
    factor = max(
        late / early if early > 0 else math.inf for late, early in itertools.pairwise(changes)
    )
    if factor > FALLING:
        return (
            f"{found}, and by {before[0]:.2g} over the one before: the change does not fall, and "
            "more cycles would not make it steady"
        )
    count = max(1, math.ceil(math.log(STEADY_CHANGE / now) / math.log(factor)))
    cycles = "cycle" if count == 1 else "cycles"
    return (
        f"{found}; add about {count} {cycles}{where}: the change falls by a factor of "
        f"{1 / factor:.2g} from one to the next"
    )


def cycle_change(q: Array, q_previous: Array, friction: float, p_max: float) -> float:
    """Return the largest change of q between the same states of two cycles, relative to f p_max.

    Args:
        q: (..., n) shear in one cycle.
        q_previous: (..., n) shear in the cycle before.
        friction: coefficient f.
        p_max: largest pressure.

    Raises:
        ValueError: if ``friction`` or ``p_max`` is not positive.
    """
    bound = check_positive("friction", friction) * check_positive("p_max", p_max)
    return float(np.max(np.abs(q - q_previous)) / bound)
