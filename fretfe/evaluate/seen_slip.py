# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half cycles of an edge between unlike bodies, where the slip of its nodes turns round.

P makes slip there, too, so that no factor tells when slip turns round, or where it is longest.
Places are named by their distance from the middle of the contact in place of the hold.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.edge_memory import INNER, EdgeMemory
from fretfe.evaluate.edge_slip import BEHIND, HalfCycle, Places, Slip
from fretfe.evaluate.factors import K_T_LENGTH, factors_at
from fretfe.evaluate.numerics import last_known
from fretfe.evaluate.slip import FEWEST_STUCK, FindBorder, SlipBorder
from fretfe.history.solution import Factor

# Slip goes with the length of a zone to the power of 3/2: zones of a twentieth of the longest are
# none, nor is the slip of a step that is as small a part of its half cycle.
FAINT = INNER**1.5
# What slips last makes a zone longer by 2/3 of its part of the slip, unless it is slip from inside.
LATE = FAINT / 4
# Part of the way of an edge in a step by which its slip zone may be off. It was up to a fifth; with
# this 138 of 144 zones of random waves were within their bars.
MOVED = 1 / 24
# Cosine of the angle between loads of two steps from which on they go on: five steps a wave do.
SMOOTH = math.cos(2 * math.pi / 4.5)


@dataclass(frozen=True)
class SeenEdge(EdgeMemory):
    """An edge followed by the slip of nodes.

    Attributes:
        seen: that slip.
        find: gives its border between two states.
        size: of an element at the edge.
        retreat: (T,) how far the inner end of slip goes outward in the step to each state.
    """

    seen: Slip
    find: FindBorder
    size: float
    retreat: Array

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
        # Where slip goes on all slips that a step covers.
        on = way == np.append(0.0, way[:-1])
        front = np.where(on, np.minimum(front, np.append(0.0, hold[own][:-1])), front)
        retreat = np.diff(front, prepend=math.nan)
        retreat = np.where(on & (retreat > size), retreat, 0.0)
        states = np.flatnonzero(front < hold[own])
        low, high = front[states], hold[own][states]
        slices = np.column_stack([low, high, memory.friction[states] * (high - low)])
        seen = Slip(hold, way, front, states, slices, np.zeros((0, 2)), BEHIND)
        # As far from the middle.
        places = Places(np.zeros(1), np.ones(1), 1.0, 1.0, np.zeros(1), np.ones(1), 0.0)
        moved = replace(memory, station=replace(station, hold=hold), places=places, gained=hold)
        found = cls(**vars(moved), seen=seen, find=find, size=size, retreat=retreat)
        return replace(found, seen=seen.where(found._counted(np.abs(slip))))

    @cached_property
    def half_cycles(self) -> tuple[HalfCycle, ...]:
        """All half cycles, each with the state in which its border is farthest from the edge."""
        return tuple(map(self._longest, super().half_cycles))

    def border(self, start: int, end: int) -> SlipBorder:
        """Border of slip at the edge between two states; by nodes if more slips farther inward.

        A step shows all that slips within it: in the middle it is shorter by half of the retreat.
        """
        found, half = self.find(start, end), float(self.retreat[end]) / 2
        length = self.step_length(end) + half
        near = 2 * self.size + 3 * INNER * length
        # Without a retreat, slip in the step may be faint in all of it, or not count.
        least = length - near if half else 0.0
        likely = found.resolved and least <= found.length <= length + near
        if length > 0 and not (found.gross or likely):
            found = SlipBorder(length, resolved=True, gross=False, spread=near)
        return replace(found, length=found.length - half, spread=math.hypot(found.spread, half))

    def step_length(self, state: int) -> float:
        """Length from the edge to the inner end of what slips in the middle of a step."""
        front = self.seen.front[state] + self.retreat[state] / 2
        return float(np.nan_to_num(self.hold[state] - front))

    def _longest(self, half: HalfCycle) -> HalfCycle:
        """A half cycle that ends with its longest zone, by borders.

        What slips in a step is the zone then: places that have slipped before and stick are none.
        """
        if math.isnan(half.length):
            return half
        stretches = self._stretches(half.start, half.turn, half.way)
        longest, best = 0.0, stretches[0]
        for state, front, since in sorted(stretches, key=lambda each: -self.step_length(each[0])):
            if longest > (1 + 3 * INNER) * self.step_length(state) + 3 * self.size:
                break
            found = self.border(since, state)
            if found.resolved and not found.gross and found.length > longest:
                longest, best = found.length, (state, front, since)
        end, front, since = best
        moved = MOVED * float(self.hold[end] - self.hold[end - 1])
        within = math.hypot(self._between(end, half.way), moved)
        return replace(half, start=since, end=end, front=front, within=within)

    def longest(self, cycle: Sequence[int] | Indices) -> tuple[HalfCycle, ...]:
        """The half cycles with the longest zone each way, since they slip."""
        own = {each.end: each for each in self.half_cycles}
        return tuple(own[each.end] for each in super().longest(cycle))

    def _between(self, state: int, way: int) -> float:
        """By how much a zone may be longer between states, if loads go on."""
        if state == self.last or not self._smooth(state):
            return 0.0
        lengths = [self.step_length(each) for each in (state - 1, state, state + 1)]
        if self.seen.way[state + 1] == way == self.seen.way[state - 1]:
            return abs(lengths[2] - lengths[0]) / 3
        return abs(lengths[1] - lengths[0]) / 2

    def _stretches(self, start: int, turn: int, way: int) -> list[tuple[int, float, int]]:
        """States in which an edge slips one way, inner end of that slip, since when it comes there.

        What has slipped before farther inward is no part of it.
        """
        found, front = [], self.seen.front
        slips = start + 1 + np.flatnonzero(self.seen.way[start + 1 : turn + 1] == way)
        for number, state in enumerate(slips.tolist()):
            deeper = np.flatnonzero(front[slips[:number]] < front[state] - self.size)
            first = slips[deeper[-1] + 1 if len(deeper) else 0]
            found.append((state, float(front[state]), int(first) - 1))
        return found

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
            after = size[::-1].cumsum()[::-1]
            counted[steps] = (size > FAINT * size.max()) & (after > LATE * after[0])
            counted[steps] &= after[0] > FAINT * most
        return counted

    @property
    def slip(self) -> Slip:
        """As nodes show it."""
        return self.seen


def seen_slip(
    steps: Array, s: Array, closed: Bools, depth: Array, firm: float = FAINT
) -> tuple[Array, Array]:
    """(T,) largest slip of nodes in the step to a state, and how far inward of the edge it comes.

    Infinitely far if all of them slip; slip that does not begin at the edge does not count.

    Args:
        steps: (T - 1, n) slip along the main direction of the edge.
        s: (T - 1, n) distances inward of where the edge is after each step.
        closed: (T - 1, n) nodes in contact then.
        depth: (T - 1,) distances up to which nodes belong to the edge.
        firm: part of the largest slip of a step from which on slip counts.
    """
    own = closed & (s <= depth[:, None])
    size = np.where(own, np.abs(steps), 0.0)
    largest = np.take_along_axis(steps, size.argmax(axis=1)[:, None], axis=1)[:, 0]
    least = firm * size.max(axis=1, keepdims=True)
    slips: Any = own & (steps * np.sign(largest)[:, None] > least)
    inward = np.argsort(s, axis=1)
    slipping, there, s = (np.take_along_axis(each, inward, axis=1) for each in (slips, own, s))
    begins = (there & ~slipping).cumsum(axis=1) < FEWEST_STUCK
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
