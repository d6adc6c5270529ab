# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles of slip at an edge that moves, each where places remember all of it.

A place sticks within r of what it remembers, and forgets that once f K_I has fallen by more than r:
the edge has left it. A range R of slip drives places as far as r = R/2. Of a history those cycles
therefore count whose range is more than twice the largest fall of f K_I. The states with that fall
divide it into parts, in which K_T begins anew; smaller cycles are counted in each of them, in the
same way.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.paths import Rainflow, rainflow

# Falls of f K_I that differ by less than this part are equal.
SAME_FALL = 0.02
# A fall below this part of the range of K_T takes nothing away that counts.
NO_FALL = 1e-3


def takes_away(fall: Array, k_t: Array) -> bool:
    """True if an edge leaves places that count.

    Args:
        fall: (n,) f K_I below its largest value.
        k_t: (m,) over the whole history.
    """
    return bool(fall.max(initial=0.0) > NO_FALL * np.ptp(k_t))


@dataclass(frozen=True)
class Reversals:
    """An edge at its reversals, and between them.

    Attributes:
        k_t: (n,) in all states.
        fall: (n,) f K_I below its largest value.
        left: (n,) that of the places that the edge has left: no less, and infinite without contact.
        turns: (m,) places of the reversals among the states, increasing.
        upward: (m,) whether slip goes forward until then.
    """

    k_t: Array
    fall: Array
    left: Array
    turns: Indices
    upward: Bools

    @cached_property
    def values(self) -> Array:
        """(m,) K_T - f K_I where slip has gone forward, else K_T + f K_I."""
        return self.k_t[self.turns] + np.where(self.upward, 1, -1) * self.fall[self.turns]

    def begun_at(self, place: int) -> Reversals:
        """Of a history that returns to its first state the same, from another place on."""
        period = len(self.k_t) - 1
        turns = (self.turns[:-1] - place) % period
        order = np.argsort(turns)
        states = (place + np.arange(period + 1)) % period
        return Reversals(
            k_t=self.k_t[states],
            fall=self.fall[states],
            left=self.left[states],
            turns=turns[order],
            upward=self.upward[:-1][order],
        )


@dataclass(frozen=True)
class Loops:
    """Counted cycles, n of them.

    Attributes:
        start, end: (n,) places of the two reversals.
        count: (n,) 1, or 0.5 for a range that nothing closes.
        range: (n,) of what drives slip, K_I counted from where the edge is farther out at the two;
            0 where the edge remembers nothing at one of them.
        reach: (n,) the same with K_I from the outermost place, and twice the way from the
            beginning where slip is driven farther than ever before; NaN where the range is 0.
    """

    start: Indices
    end: Indices
    count: Array
    range: Array
    reach: Array


@dataclass(frozen=True)
class _Part:
    """A part of a history between two places.

    Attributes:
        ends: (2,) the places.
        anew: (2,) whether the edge remembers nothing there.
        fresh: whether nothing that it remembers has slipped before.
        most: largest range that is counted.
    """

    ends: tuple[int, int]
    anew: tuple[bool, bool]
    fresh: bool
    most: float = np.inf

    @property
    def inside(self) -> tuple[int, int]:
        """The first place that remembers something, and the last one."""
        return self.ends[0] + self.anew[0], self.ends[1] - self.anew[1]

    def reversals(self, history: Reversals) -> tuple[Indices, Array]:
        """(m,) places, and values there: K_T where the edge remembers nothing."""
        first, last = np.searchsorted(history.turns, np.add(self.inside, (0, 1)))
        places, values = history.turns[first:last], history.values[first:last]
        for side, at in ((1, len(places)), (0, 0)):
            if self.anew[side]:
                places = np.insert(places, at, self.ends[side])
                values = np.insert(values, at, history.k_t[self.ends[side]])
        return places, values

    def divided(self, cuts: Indices, most: float) -> list[_Part]:
        """The parts between places at which the edge remembers nothing."""
        anew = {*cuts.tolist(), *np.array(self.ends)[np.array(self.anew)].tolist()}
        return [
            _Part((first, last), (first in anew, last in anew), first in anew or self.fresh, most)
            for first, last in pairwise(np.unique([*cuts, *self.ends]).tolist())
        ]


def count_loops(history: Reversals, repeated: bool, fresh: bool) -> Loops:
    """Count the cycles of an edge.

    Args:
        history: its reversals; one that repeats itself from its largest load to that load.
        repeated: whether it does.
        fresh: whether nothing has slipped before it.
    """
    period, values = len(history.k_t) - 1, history.values
    whole = _Part((0, period), (False, False), fresh and not repeated)
    # The repetition itself leads from the last reversal, which is the first one, on.
    flow = rainflow(values[:-1] if repeated else values, repeated)
    loops, largest, cuts = _counted(whole, flow, history.turns, values, history)
    found, begin = [loops], 0
    if repeated and len(cuts):
        # All that is left is remembered from one of these places to the same one.
        begin, whole = int(cuts[0]), replace(whole, anew=(True, True))
        history, cuts = history.begun_at(begin), cuts - begin
    waiting = whole.divided(cuts, 2 * largest) if len(cuts) else []
    while waiting:
        part = waiting.pop()
        turns, values = part.reversals(history)
        loops, largest, cuts = _counted(part, rainflow(values), turns, values, history)
        start, end = ((each + begin) % (period + (not begin)) for each in (loops.start, loops.end))
        found.append(replace(loops, start=start, end=end))
        waiting += part.divided(cuts, 2 * largest) if len(cuts) else []
    joined = {each.name: [getattr(loops, each.name) for loops in found] for each in fields(Loops)}
    return Loops(**{name: np.concatenate(arrays) for name, arrays in joined.items()})


def _counted(
    part: _Part, flow: Rainflow, places: Indices, values: Array, history: Reversals
) -> tuple[Loops, float, Indices]:
    """Cycles that count in a part, its largest fall, and the places of that, none if all count.

    Args:
        part: of the history.
        flow: all cycles between its reversals.
        places: (m,) of these.
        values: (m,) there.
        history: the whole of it.
    """
    first, last = part.inside
    start, end, fall = places[flow.start], places[flow.end], history.fall
    left = history.left[first : last + 1]
    largest = float(left.max()) if takes_away(left, history.k_t) else 0.0
    deep = flow.range > 2 * largest
    cuts = first + np.flatnonzero(left >= (1 - SAME_FALL) * largest)
    inside = (start >= first) & (start <= last) & (end >= first) & (end <= last)
    at_cut = np.isin(start, cuts) | np.isin(end, cuts)
    kept = inside & (flow.range <= part.most) & (deep | at_cut)
    way = np.abs(values - values[0])
    farthest = part.fresh & (way >= np.maximum.accumulate(way))[flow.end]
    reach = np.where(farthest, np.maximum(flow.range, 2 * way[flow.end]), flow.range)
    outer = np.minimum(fall[start], fall[end])
    loops = Loops(
        start[kept],
        end[kept],
        flow.count[kept],
        np.where(deep, flow.range - 2 * outer, 0.0)[kept],
        np.where(deep, reach, np.nan)[kept],
    )
    return loops, largest, cuts if inside.any() and not deep[inside].all() else cuts[:0]
