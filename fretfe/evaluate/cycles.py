# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles: whether the evaluated one is steady, and those of irregular loads.

Counted are the ranges of K from reversal to reversal, as if the edge had one size. How far slip
reaches `edge_memory` tells.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.analytic.paths import rainflow
from fretfe.evaluate.contacts import ROUND_OFF, CountedCycles, StationHistory, no_cycles
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.loaded import normal_force
from fretfe.evaluate.numerics import most_loaded
from fretfe.history.solution import ContactHistory, Solution
from fretfe.loads import CycleChoice
from fretfe.surface.friction import Friction

# Changes below this fraction of the range are no reversal.
TOLERANCE = 1e-6
# Ends of a cycle that differ by less than this fraction of the range are the same state.
CLOSED = 1e-2
# Change of the shear from one cycle to the next, relative to the friction bound, below which it is
# steady.
STEADY_CHANGE = 1e-3
# Cycles that are compared, and the fraction of the largest load within which loads are the same.
MOST_CYCLES = 3
SAME_LOAD = 1e-9
# A change that is at least so large a part of the one before does not fall.
FALLING = 0.98


def reversals(values: Array) -> Indices:
    """(n,) places where values turn round, the last one included; of a plateau the first."""
    least, turns, ways = TOLERANCE * float(np.ptp(values)), [0], [0]
    for place, value in enumerate(values.tolist()):
        change = value - values[turns[-1]]
        if abs(change) <= least:
            continue
        way = 1 if change > 0 else -1
        if way == ways[-1]:
            turns[-1] = place
        else:
            turns.append(place)
            ways.append(way)
    return np.array(turns[1:], dtype=np.int64)


def count_cycles(
    cycle: Indices,
    friction: Array,
    station: StationHistory,
    memory: EdgeMemory | None = None,
    returns: bool = False,
) -> CountedCycles:
    """Count the cycles of a station.

    Args:
        cycle: states of the evaluated cycle; empty to count the whole history.
        friction: (T,) coefficient in the step that ends at each state.
        station: its factors.
        memory: of the edge, which tells how far slip comes; None if that is not known.
        returns: whether all loads return in the cycle. Increments of an edge that moves need not
            add up to nothing then: K_T goes on from cycle to cycle, and slip does not.
    """
    known = np.isfinite(station.shear) & np.isfinite(station.hold)
    if not friction.any():
        return no_cycles("there is no friction")
    first = max(int(np.argmax(friction > 0)) - 1, 0)
    states = cycle if len(cycle) else np.arange(max(first, int(np.argmax(known))), len(known))
    unknown = states[~(known & np.isfinite(station.k_t))[states]]
    if len(unknown):
        return no_cycles(f"K_T is unknown in {len(unknown)} of {len(states)} states")
    if len(states) < 2:
        return no_cycles("nothing varies")
    if friction[states[1:]].min(initial=np.inf) == 0:
        return no_cycles("there is no friction in a part of the cycle")
    order, closed = _order(states, station.shear, returns) if len(cycle) else (states, False)
    shear, f_hold = station.shear[order], friction.max() * station.hold
    if not np.ptp(shear) > ROUND_OFF * np.ptp(f_hold[states]):
        return no_cycles("nothing varies")
    turns = np.append(0, reversals(shear))
    # The repetition itself leads from the last reversal, which is the first one, on.
    counted = rainflow(shear[turns[:-1]] if closed else shear[turns], repeated=closed)
    start, end = order[turns[counted.start]], order[turns[counted.end]]
    slips = (_slip(*each, memory) for each in zip(start, end, counted.count, strict=True))
    return CountedCycles(
        start=start,
        end=end,
        count=counted.count,
        k_t_range=np.abs(station.k_t[end] - station.k_t[start]),
        k_t_mean=(station.k_t[end] + station.k_t[start]) / 2,
        slip=np.array(list(slips)),
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


def _slip(start: int, end: int, count: float, memory: EdgeMemory | None) -> float:
    """Slip length from one reversal to another; NaN if P moves the edge in between."""
    if memory is None or not memory.station.at_rest(min(start, end), max(start, end), CLOSED):
        return math.nan
    change = float(memory.station.shear[end] - memory.station.shear[start])
    # A half cycle may load for the first time; slip of all others has to turn round.
    front = memory.hold[end] - abs(change) / (2 * memory.friction[end])
    if count < 1 and start < end:
        front = memory.slip.between(start, end, 1 if change > 0 else -1).front
    return memory.length(end, front)


def cycle_changes(solution: Solution, contact: ContactHistory) -> list[float]:
    """Changes of the shear over cycles, relative to the friction bound in the evaluated one.

    In the plane the largest at a node over f p_max. Of solids the mean over the contact over that
    of f p: the shear of single nodes at free ends creeps far longer than that of any front.

    Args:
        solution: the solved history.
        contact: one of its contacts.

    Returns:
        That of the evaluated cycle, and those of a few cycles before it under the same loads, the
        latest first; NaN alone if there is no cycle, pressure or friction.
    """
    friction, solid = contact.friction, contact.surface.facets is not None
    traction = contact.mean_traction if solid else contact.traction
    cycles = same_cycles(solution, friction)
    if not cycles:
        return [math.nan]
    force = normal_force(contact, slice(cycles[0][0], cycles[0][1] + 1))
    state = cycles[0][0] + most_loaded(force, np.arange(len(force)))
    bound = friction.at(state) * traction[state][:, 0]
    weights, order = (contact.surface.weights, 1) if solid else (np.ones(len(bound)), math.inf)
    changes = (traction[end] - traction[begin] for begin, end in cycles[:MOST_CYCLES])
    sizes = (bound, *(np.linalg.norm(each[:, 1:], axis=1) for each in changes))
    limit, *found = (float(np.linalg.norm(weights * each, order)) for each in sizes)
    return [each / limit for each in found] if limit > 0 else [math.nan]


def same_cycles(solution: Solution, friction: Friction) -> list[tuple[int, int]]:
    """First and last state of the evaluated cycle and of the same ones before it, latest first."""
    if solution.cycle is None:
        return []
    # By the ends of steps: how steps are divided may differ from cycle to cycle.
    ends = solution.ends
    values, number = solution.values[ends], friction.number[ends]
    first, last = (solution.step_of(state) for state in solution.cycle)
    found = [(first, last)]
    period, scale = last - first, np.abs(values).max(axis=0)
    while found[-1][0] >= period:
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
    CycleChoice.ADDED: " by a larger `more` in [cycle]",
    CycleChoice.OTHER_RUN: " to the case of the run that the cuts follow, and cut it again",
}


def unsteady_text(
    changes: Sequence[float], choice: CycleChoice | None = None, drifting: Sequence[str] = ()
) -> str:
    """Say that a cycle is not steady, and how many more it takes; empty if it is.

    Args:
        changes: as of `cycle_changes`.
        choice: of the cycle.
        drifting: loads that do not return in it, so that it cannot be repeated.
    """
    where = "" if choice is None else WHERE.get(choice, "")
    now, *before = changes
    if not now >= STEADY_CHANGE:
        return ""
    found = f"not in steady state: shear changes by {now:.2g} of its bound over the evaluated cycle"
    if drifting:
        return f"{found}, in which {', '.join(drifting)} does not return: end it where loads do"
    if not before:
        return f"{found}; add a cycle{where}: the changes over two say about how many it takes"
    # The slower fall of the last two: the first one, out of the unloaded state, is the fastest.
    pairs = itertools.pairwise(changes)
    factor = max(late / early if early > 0 else math.inf for late, early in pairs)
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
