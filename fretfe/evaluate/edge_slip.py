# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip at an edge that is followed by its hold, and where its places are."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.contacts import NOTHING, ROUND_OFF, StationHistory

# Slip by less than this part of the largest one is no reversal.
TOLERANCE = 1e-6
# Rates farther apart than that tell how they go on.
WIDE = 1.2
# A zone jumps where a loop closes: the part of what drives a half cycle that has to lie behind it.
BEHIND = 1e-3


@dataclass(frozen=True)
class Places:
    """Places behind an edge, by the hold that it gains on its way outward from the first known one.

    It gains K_N/(2 u) of it a length, with the unit factor u. That belongs to the place, whatever
    has slipped before; it is straight between known places, as on cylinders and wedges. Inward of
    the first one the hold is a power of the distance from where nothing is left of it: 1 of a
    wedge, 2 of a cylinder, 3 of a sphere.

    Attributes:
        outward: (n,) known places, increasing.
        rate: (n,) what it gains there a length.
        reach: how far inward of the first one nothing is left of the hold.
        power: of the distance from there.
        gained: (n,) what it has gained.
        unit: (n,) factors of the edge.
        middle: place of the middle of the contact; NaN if not known.
    """

    outward: Array
    rate: Array
    reach: float
    power: float
    gained: Array
    unit: Array
    middle: float

    @cached_property
    def _pieces(self) -> tuple[Array, Array]:
        """(k,) rates at the inner ends of the k pieces, and how they change; straight from one."""
        width, rate = np.diff(self.outward), self.rate
        if not len(width):
            return rate, 0 * rate
        # What straight lines miss of the hold where it is known, shared out.
        share = np.diff(self.gained) / (width * (rate[:-1] + rate[1:]) / 2)
        return share * rate[:-1], share * np.diff(rate) / width

    @property
    def _least(self) -> float:
        """Least share of the reach that is left: what is straight has no end."""
        return 0.0 if self.power > 1 else -math.inf

    def at(self, gained: float) -> float:
        """Place where it has gained so much, at most back to where no hold is left."""
        if not len(self.gained):
            return math.nan
        more, rate = gained - float(self.gained[0]), float(self.rate[0])
        if more <= 0:
            share = max(1 + self.power * more / (rate * self.reach), self._least)
            return float(self.outward[0]) + self.reach * (share ** (1 / self.power) - 1)
        number = max(int(np.searchsorted(self.gained[:-1], gained, "right")) - 1, 0)
        rate, bend = (float(each[number]) for each in self._pieces)
        more = gained - float(self.gained[number])
        square = rate**2 + 2 * bend * more
        if not square >= 0:
            return math.nan
        return float(self.outward[number]) + 2 * more / (rate + math.sqrt(square))

    def unit_at(self, gained: float) -> float:
        """Factor of the edge where it has gained so much: one over the root of its size.

        That is straight between places, and to nothing in the middle (exact for half-planes).
        """
        place = self.at(gained)
        if math.isnan(place):
            return math.nan
        if place < self.outward[0] and math.isfinite(self.middle):
            share = (place - self.middle) / (self.outward[0] - self.middle)
            return float(self.unit[0] / math.sqrt(share)) if share > 0 else math.inf
        return float(np.interp(place, self.outward, self.unit**-2.0) ** -0.5)

    def gain(self, outward: Array, hold: Array) -> Array:
        """(T,) what it has gained at places (T,), by its hold (T,) where that is faint."""
        if not len(self.gained):
            return math.nan * outward
        way, left = outward - self.outward[0], float(self.rate[0]) * self.reach / self.power
        share = np.maximum(1 + np.minimum(way, 0.0) / self.reach, self._least)
        rate, bend = self._pieces
        number = np.clip(np.searchsorted(self.outward, outward) - 1, 0, len(rate) - 1)
        along = outward - self.outward[number]
        inside = self.gained[number] + along * (rate[number] + along * bend[number] / 2)
        told = np.where(way < 0, self.gained[0] + left * (share**self.power - 1), inside)
        return np.where(_placed(hold), told, self.gained[0] + hold - left)


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


@dataclass(frozen=True)
class HalfCycle:
    """Slip of an edge one way, from a reversal to the next.

    Attributes:
        start, turn: first state, and last one in which it slips on.
        end: state in between in which its zone is longest.
        way: 1 forward, -1 backward, 0 if nothing slips.
        front: hold of the inner end of the zone at `end`.
        length: of the zone; NaN if the whole contact slips.
        deepest: states in between from which and in which slip comes deepest of what is left at
            `turn`, also where places have been covered and stick since.
        within: by how much the zone may be longer within steps, by nodes.
    """

    start: int
    turn: int
    end: int
    way: int
    front: float
    length: float
    deepest: tuple[int, int]
    within: float = 0.0

    @classmethod
    def still(cls, start: int, end: int) -> HalfCycle:
        """One in which nothing slips."""
        return cls(start, end, end, 0, math.nan, 0.0, (start, end))


def _placed(hold: Array) -> Bools:
    """(T,) states whose hold is more than next to nothing: elements tell the place of the edge.

    With less they do not tell how large a flat still is.
    """
    return np.asarray(hold > NOTHING * np.nanmax(hold, initial=0.0))


def places_of(
    station: StationHistory, last: int, half_width: float, exact: bool, stiffening: float
) -> Places:
    """Places of an edge by all states up to one.

    Args:
        station: of the edge.
        last: the last state.
        half_width: of the contact in the state `last` of the station.
        exact: whether its hold is known as well as its positions.
        stiffening: relative growth of dP/da with the half-width in that state; NaN if not known.
    """
    every = slice(0, last + 1)
    outward, hold, unit = -station.inward * station.position[every], station.hold, station.unit
    hold, unit = hold[every], unit[every]
    rate = station.k_n[every] / (2 * unit)
    states = np.flatnonzero(np.isfinite(outward) & (rate > 0) & _placed(hold))
    states = states[np.argsort(outward[states], kind="stable")]
    middle = -station.inward * station.position[station.last] - half_width
    if not len(states):
        none = np.zeros(0)
        return Places(none, none, math.nan, math.nan, none, none, middle)
    apart = TOLERANCE * max(float(np.ptp(outward[states])), TOLERANCE * half_width)
    states = states[np.diff(outward[states], prepend=-math.inf) > apart]
    outward, hold, rate = outward[states], hold[states], rate[states]
    gained = np.append(0.0, np.cumsum(np.diff(outward) * (rate[1:] + rate[:-1]) / 2))
    reach, growth = float(outward[0] - middle), stiffening
    if rate.max() > WIDE * rate.min():
        growth = float((rate[-1] - rate[0]) / (outward[-1] - outward[0]) / rate[0])
    if exact:
        growth = math.nan
        gained = hold if (np.diff(hold) > 0).all() else gained
    if not reach > 0:  # a parabola, or a straight line
        growth = float(np.nan_to_num(growth))
        reach = 1 / growth if growth else 1.0
    # The rate of h x^m grows by (m - 1)/x; what slides as a whole changes h, but not that.
    power = float(rate[0]) * reach / float(hold[0]) if math.isnan(growth) else 1 + growth * reach
    return Places(outward, rate, reach, max(power, 1.0), gained, unit[states], float(middle))
