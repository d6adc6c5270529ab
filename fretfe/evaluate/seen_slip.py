# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half cycles of an edge between unlike bodies, where the slip of its nodes turns round.

P makes slip there, too, so that no factor tells when slip turns round, or where it is longest.
Places are named by their distance from the middle of the contact in place of the hold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.edge_memory import INNER, EdgeMemory
from fretfe.evaluate.edge_slip import BEHIND, HalfCycle, Places, Slip
from fretfe.evaluate.factors import K_T_LENGTH, factors_at
from fretfe.evaluate.numerics import last_known
from fretfe.evaluate.slip import FEWEST_STUCK, SMALLEST_SLIP, FindBorder, SlipBorder
from fretfe.history.solution import Factor

# Slip goes with the length of a zone to the power of 3/2: zones of a twentieth of the longest are
# none, nor is the slip of a step that is as small a part of its half cycle.
FAINT = INNER**1.5
# Cosine of the angle between loads of two steps from which on they go on: five steps a wave do.
SMOOTH = math.cos(2 * math.pi / 4.5)


@dataclass(frozen=True)
class SeenEdge(EdgeMemory):
    """An edge followed by the slip of nodes.

    Attributes:
        seen: that slip.
        find: gives its border between two states.
        size: of an element at the edge.
        covers: (T,) whether all places slip that the step to a state covers.
    """

    seen: Slip
    find: FindBorder
    size: float
    covers: Bools

    @classmethod
    def by(
        cls,
        memory: EdgeMemory,
        half_width: float,
        slip: Array,
        reach: Array,
        find: FindBorder,
        size: float,
    ) -> SeenEdge:
        """The edge of a memory as nodes show it.

        Args:
            memory: that of its factors.
            half_width: of the contact in the state `last` of the station.
            slip: (T,) largest slip along its main direction in the step to each state.
            reach: (T,) how far inward of the edge it comes.
            find: gives the border of slip between two states.
            size: of an element at the edge.
        """
        station = memory.station
        outward = -station.inward * station.position
        middle = last_known(outward, np.arange(station.last % len(outward) + 1)) - half_width
        hold = np.where(station.hold > 0, np.nan_to_num(outward - middle), 0.0).clip(0.0)
        own = np.arange(memory.last + 1)
        way = np.where(own > memory.begin, np.sign(slip[own]), 0.0)
        front = np.where(way == 0, np.nan, np.maximum(hold[own] - reach[own], 0.0))
        # What a step covers slips from the old edge on, or not at all, but for what steps miss.
        old = np.append(math.nan, hold[own][:-1])
        covers = (way == np.append(0, way[:-1])) & (front - old < size + INNER * (hold[own] - old))
        front = np.where(covers, np.minimum(front, old), front)
        states = np.flatnonzero(front < hold[own])
        low, high = front[states], hold[own][states]
        slices = np.column_stack([low, high, memory.friction[states] * (high - low)])
        seen = Slip(hold, way, front, states, slices, np.zeros((0, 2)), BEHIND)
        # As far from the middle.
        places = Places(np.zeros(1), np.ones(1), 1.0, 1.0, np.zeros(1), np.ones(1), 0.0)
        moved = replace(memory, station=replace(station, hold=hold), places=places, gained=hold)
        found = cls(**vars(moved), seen=seen, find=find, size=size, covers=covers)
        return replace(found, seen=seen.where(found._counted(np.abs(slip))))

    @cached_property
    def half_cycles(self) -> tuple[HalfCycle, ...]:
        """All half cycles, each with the state in which its border is farthest from the edge."""
        return tuple(map(self._longest, super().half_cycles))

    def over_holes(self, find: FindBorder) -> FindBorder:
        """Borders of slip between two states, beyond what steps miss of places that they cover."""

        def border(start: int, end: int) -> SlipBorder:
            found = before = find(start, end)
            state = end
            while self.covers[state] and state - 1 > start and not before.resolved:
                state -= 1
                before = find(start, state)
            inner = float(self.hold[state]) - before.length  # NaN where all slips
            own = self.seen.front[state + 1 : end + 1] >= inner - self.size
            if state == end or not (before.resolved and own.all()):
                return found
            length, spread = float(self.hold[end]) - inner, math.hypot(before.spread, self.size)
            return replace(before, length=length, spread=spread)

        return border

    def _longest(self, half: HalfCycle) -> HalfCycle:
        """A half cycle that ends where borders tell, where nodes are the same to an element.

        One that ends with its longest zone may go on within the next step, unless loads turn there.
        """
        if math.isnan(half.length):
            return half
        stretches = self._stretches(half.start, half.turn, half.way)
        near = [each for each in stretches if self.length(*each[:2]) >= half.length - self.size]
        find = self.over_holes(self.find)
        borders = [find(half.start, state) for state, *_ in near]
        # All of them may slip, or nodes do not tell where they stick.
        known = [each.length if each.resolved and not each.gross else 0.0 for each in borders]
        longest, (end, front, since) = max(zip(known, near, strict=True))
        before = find(half.start, end - 1).length if end - 1 > half.start else 0.0
        goes_on = end == half.turn < self.last and math.isfinite(before) and self._smooth(end)
        grown = abs(longest - before) / 2 if goes_on else 0.0
        # It may have begun a step before nodes show it, on what that has covered.
        covered = front - float(self.hold[max(since - 1, self.begin)])
        return replace(half, end=end, within=max(grown, covered))

    def _smooth(self, state: int) -> bool:
        """True if loads go through a state like a wave, and do not turn there."""
        loads = np.array([self.station.k_i, self.station.k_t])[:, state - 1 : state + 2]
        before, after = np.diff(loads / np.nanmax(np.abs(loads), axis=1, keepdims=True), axis=1).T
        return bool(before @ after > SMOOTH * np.linalg.norm(before) * np.linalg.norm(after))

    def _counted(self, slip: Array) -> Bools:
        """(T,) steps to states that are no faint part of a half cycle, nor those of a faint one."""
        counted = np.ones(self.last + 1, dtype=bool)
        own = [slice(each.start + 1, each.turn + 1) for each in super().half_cycles]
        most = max((float(slip[each].sum()) for each in own), default=0.0)
        for steps in own:
            size = slip[steps]
            counted[steps] = (size > FAINT * size.max()) & (size.sum() > FAINT * most)
        return counted

    @property
    def slip(self) -> Slip:
        """As nodes show it."""
        return self.seen


def seen_slip(
    steps: Array, s: Array, closed: Bools, depth: Array, firm: float = SMALLEST_SLIP
) -> tuple[Array, Array]:
    """(T,) largest slip of nodes in the step to a state, and how far inward of the edge it comes.

    Infinitely far if all of them slip; slip that does not begin at the edge does not count.

    Args:
        steps: (T - 1, n) slip along the main direction of the edge.
        s: (T - 1, n) distances inward of where the edge is after each step.
        closed: (T - 1, n) nodes in contact then.
        depth: (T - 1,) distances up to which nodes belong to the edge.
        firm: part of the largest slip from which on slip counts.
    """
    own = closed & (s <= depth[:, None])
    size = np.where(own, np.abs(steps), 0.0)
    largest = np.take_along_axis(steps, size.argmax(axis=1)[:, None], axis=1)[:, 0]
    slips = own & (steps * np.sign(largest)[:, None] > firm * size.max(initial=0.0))
    inward = np.argsort(s, axis=1)
    slipping, there, s = (np.take_along_axis(each, inward, axis=1) for each in (slips, own, s))
    stuck, passed = (there & ~slipping).cumsum(axis=1), there.cumsum(axis=1)
    begins = stuck < FEWEST_STUCK + INNER * passed
    reach = np.where(slipping & begins, s, 0.0).max(axis=1, initial=0.0)
    reach[(slipping | ~there).all(axis=1)] = np.inf
    return np.append(0.0, np.where(reach > 0, largest, 0.0)), np.append(0.0, reach)


def pressed_on(
    factors: Array, dundurs: float, length: float, friction: Array, cycle: Indices
) -> bool:
    """True if P alone drives an edge: there is no cycle, and K_T grows by less than f K_I.

    Args:
        factors: (T, d) of the edge, between unlike bodies at the length 1.
        dundurs: beta.
        length: at which P adds nothing to K_T of unlike bodies, about the width of the contact.
        friction: (T,) coefficient in the step that ends at each state.
        cycle: states of the evaluated cycle.
    """
    own = factors_at(factors, dundurs, length / K_T_LENGTH) if dundurs else factors
    begin = max(int(np.argmax(friction > 0)) - 1, 0)
    steps = np.abs(np.diff(own[begin:][np.isfinite(own[begin:]).all(axis=1)], axis=0))
    bound = float(friction.max()) * steps[:, Factor.K_I]
    shear = np.linalg.norm(steps[:, Factor.K_T :], axis=1)
    # In all of its steps, but for what is faint.
    return bool(not len(cycle) and np.maximum(shear - bound, 0.0).sum() < FAINT * bound.sum())
