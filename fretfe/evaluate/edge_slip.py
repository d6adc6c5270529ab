# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip at an edge that is followed by its hold, and where its places are."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.contacts import ROUND_OFF, StationHistory

# Slip by less than this part of the largest one is no reversal.
TOLERANCE = 1e-6
# A zone jumps where a loop closes: the part of what drives a half cycle that has to lie behind it.
BEHIND = 1e-3


@dataclass(frozen=True)
class Places:
    """Place of the edge by its hold.

    Attributes:
        hold: (n,) increasing.
        depth: (n,) inward, of the edge with that hold.
        slope: (n,) change of the depth with the hold, -2 u/K_N with the unit factor u.
        reach: half-width of the contact at the first of them.
    """

    hold: Array
    depth: Array
    slope: Array
    reach: float

    def at(self, hold: float) -> float:
        """Depth of the edge with a hold, a cubic curve through places and slopes.

        Below the first one the half-width grows with the power of the hold that its slope tells:
        1/2 of cylinders, 1 of wedges.
        """
        first = float(self.hold[0])
        if hold < first:
            power = -float(self.slope[0]) * first / self.reach
            return float(self.depth[0]) + self.reach * (1 - (max(hold, 0.0) / first) ** power)
        if len(self.hold) == 1:
            return float(self.depth[0])
        last = min(hold, float(self.hold[-1]))
        low = min(int(np.searchsorted(self.hold, last, "right")) - 1, len(self.hold) - 2)
        width = float(self.hold[low + 1] - self.hold[low])
        part, begin = (last - float(self.hold[low])) / width, float(self.depth[low])
        way, first, second = float(self.depth[low + 1]) - begin, *width * self.slope[low : low + 2]
        bend = 3 * way - 2 * first - second - part * (2 * way - first - second)
        return begin + part * (first + part * float(bend))


@dataclass(frozen=True)
class Slip:
    """Slip at an edge in all steps.

    Attributes:
        hold: (T,) of the edge.
        way: (T,) of the slip in the step to each state: 1 forward, -1 backward, 0 without.
        front: (T,) hold of the place that it comes to; NaN without slip.
        states, slices: (m,) and (m, 3) what slip takes in the step to a state: lowest and highest
            hold of places, and how much of the shear.
        locked: (k, 2) at the end, the lowest hold of places and their part of f p, outward.
        behind: part of what drives a half cycle that has to lie behind a jump of its zone.
    """

    hold: Array
    way: Array
    front: Array
    states: Indices
    slices: Array
    locked: Array
    behind: float

    @cached_property
    def taken(self) -> Array:
        """(T,) shear that slip takes in the step to each state."""
        return np.bincount(self.states, self.slices[:, 2], len(self.way))

    def where(self, counts: Bools) -> Slip:
        """The slip in steps to some states (T,)."""
        way, front = np.where(counts, self.way, 0.0), np.where(counts, self.front, math.nan)
        own = counts[self.states]
        return replace(self, way=way, front=front, states=self.states[own], slices=self.slices[own])

    def between(self, start: int, end: int, way: int, outer: Bools | None = None) -> Pieces:
        """Places that slip one way takes between two states.

        Args:
            start: the first state.
            end: the second one.
            way: 1 or -1.
            outer: (T,) whether the step to each state counts; None if all of them do.
        """
        own = slice(*np.searchsorted(self.states, (start + 1, end + 1)))
        states = self.states[own]
        counted = self.way[states] == way
        if outer is not None:
            counted &= outer[states]
        slices = self.slices[own][counted]
        low, high, taken = slices.T
        # Where loops close round-off reaches to the older front, and where the coefficient changes
        # places take a little that have slipped so already.
        share = taken / np.maximum(high - low, ROUND_OFF)
        driven = (taken > ROUND_OFF * taken.sum()) & (share > BEHIND * share.max(initial=0.0))
        return Pieces(slices[driven], float(self.hold[end]), self.behind)


def follow(station: StationHistory, friction: Array, begin: int, *, at_once: bool) -> Slip:
    """Follow an edge from a state on, to the last one with a coefficient (T,)."""
    # Imported where it is needed: pages of results do without compiled code.
    from fretfe._core import _kernels

    known = np.arange(len(friction)) >= begin
    hold, shear, friction, slid = (
        np.where(known, each[: len(known)], 0.0)
        for each in (station.hold, station.shear, friction, station.slid)
    )
    found = _kernels.follow_edge(hold, shear, friction, slid, begin, at_once)
    # What drivers leave over may close a loop, or not.
    slip = Slip(hold, *found, behind=max(BEHIND, station.loose))
    return slip.where(slip.taken > ROUND_OFF * slip.taken.max(initial=0.0))


@dataclass(frozen=True)
class Pieces:
    """Places that slip has taken.

    Attributes:
        slices: (m, 3) lowest and highest hold, and how much of the shear.
        hold: of the edge.
        behind: as of `Slip`.
    """

    slices: Array
    hold: float
    behind: float

    @property
    def taken(self) -> float:
        """Part of the shear that it takes."""
        return float(self.slices[:, 2].sum())

    @property
    def deepest(self) -> float:
        """Lowest hold of all these places."""
        return float(self.slices[:, 0].min(initial=self.hold))

    def within(self, hold: Array) -> Array:
        """(n - 1,) how much of that it takes between holds (n,), which fall."""
        low, high, taken = self.slices.T
        shares = (high - hold[:, None]) / np.where(high > low, high - low, 1.0)
        return np.asarray(np.diff(np.clip(shares, 0.0, 1.0) @ taken))

    @cached_property
    def front(self) -> float:
        """Hold of the deepest place, but for what lies behind a jump without driving anything."""
        low, high, taken = self.slices[np.argsort(self.slices[:, 0])].T
        if not len(low):
            return self.hold
        behind = np.cumsum(taken)
        # The next ones outward begin where all those farther inward have ended.
        jumps = np.append(low[1:] > np.maximum.accumulate(high)[:-1], False)
        faint = np.flatnonzero(jumps & (behind < self.behind * behind[-1]))
        return float(low[faint[-1] + 1] if len(faint) else low[0])


def places_of(station: StationHistory, half_width: float, last: int) -> Places:
    """Places of an edge by all states up to one, with the half-width in that of the station."""
    states = np.arange(last + 1)
    known = np.isfinite(station.position[states] + station.k_n[states]) & (station.hold[states] > 0)
    states = states[known]
    hold, unique = np.unique(station.hold[states], return_index=True)
    states = states[unique]
    apart = np.diff(hold, prepend=-math.inf) > TOLERANCE * float(hold.max(initial=0.0))
    states = states[apart]
    slope = -2 * station.unit[states] / station.k_n[states]
    depth = station.inward * station.position[states]
    reach = half_width + station.inward * float(station.position[station.last]) - float(depth[0])
    return Places(hold[apart], depth, slope, reach)
