# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones next to many edges from the histories of their edge factors.

The stations of a front feel each other only through their edge factors. Next to each of them the
fields are those of a plane contact with three displacement components: relative displacements of
half-planes by pressure and shear in the plane, and by shear across it, whose compliance is
1/(1 - ν) of that in the plane for isotropic bodies of one material; shear along one direction moves
crystals along the other as well. Pressure and friction bound are known in closed form from K_N and
K_I, but for what shear between unlike bodies adds (`fretfe.local.unlike`); K_T and K_S load the
contact, and friction is one bound on the vector.

All stations have the same operators but for the materials once lengths are in units of the
half-width: those that want elements of about the same size are marched together.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.edges import sliding_exponent
from fretfe.local.friction import Bound, Slipped, Stiffness, partial_slip, unit
from fretfe.local.half_planes import Contacts, HalfPlanes, WholeHalfPlanes, pressure_shapes
from fretfe.local.unlike import Before, Pressed, UnlikeContacts, coupled_slip

# Movement of the edge within a part of a step, over the half-width and over the smallest zone.
LARGEST_MOVE = 0.01
ZONE_MOVE = 0.25
MOST_PARTS = 64
# Error of the shear over the largest f p.
TOLERANCE = 1e-9
# Change of the shear over a steady cycle, added up over the nodes, over the swing of the force.
# What remains of it sits in a few nodes at the border of slip, where shear across the line of
# (K_T, K_S) dies out slowly.
STEADY = 2e-3
MOST_CYCLES = 12
SLIDES = (
    "in the plane problem next to the front all of the contact would slide: K_T and K_S are too "
    "large for its friction"
)
UNSETTLED = (
    "in the plane problem next to the front pressure and shear of unlike bodies do not settle"
)
# Shear over that of sliding, times which an edge has gone all of the way that sliding moves it.
FARTHER = 3.0


@dataclass(frozen=True)
class EdgeHistories:
    """Histories of S edges of one contact through T states, and what is wanted of them.

    Lengths, stresses and forces in one system of units, forces per unit length of the edge.

    Attributes:
        contacts: symmetric contacts of half-planes that stand for the edges.
        k: (S, T, 2) K_T and K_S; constant up to the first state that counts.
        k_i: (S, T) K_I, counted from the reference state; constant up to that state. Between unlike
            bodies K_T and K_I are those of full stick at the length of twice the half-width, over
            cosh(pi epsilon): what P and Q make of half-planes without rotation.
        locked: (S, 2) shear over the pressure in that state.
        direction: (S, 2) unit vectors along which slip is told forward from backward.
        zone: (S,) length of the smallest slip zone that is to be resolved.
        halves: (S,) half cycles of each edge, as their first and last states in time order.
        counted: (S, T) whether slip in the step to each state counts for the half cycles.
        friction: (S,) coefficient, at the edge where it is not the same everywhere.
        behind: (S,) places inward from the edge in the reference state and coefficients there over
            that, (2, m) each; None where they are the same.
        modulus: (S,) E* by the compliance of the bodies to pressure.
        tangential: (S, 2, 2) their compliance to shear inward and along the edge over that.
        cycle: first and last state of the cycle that repeats itself, or None.
        dundurs: beta of unlike bodies; zero of similar ones.
        shown: states in which tractions are wanted; none for those at the ends of half cycles.
    """

    contacts: Contacts
    k: Array
    k_i: Array
    locked: Array
    direction: Array
    zone: Array
    halves: tuple[tuple[tuple[int, int], ...], ...]
    counted: Bools
    friction: Array
    behind: tuple[Array | None, ...]
    modulus: Array
    tangential: Array
    cycle: tuple[int, int] | None
    dundurs: float = 0.0
    shown: tuple[int, ...] = ()

    @cached_property
    def shift(self) -> Array:
        """(S,) farthest that the shear of unlike bodies moves an edge, over the half-width.

        A parabola that slides without turning reaches from -(1 - lambda) L to lambda L, and L grows
        with 1/sqrt(lambda (1 - lambda)); a contact that sticks in part, less far.
        """
        if not self.dundurs:
            return np.zeros(len(self.k))
        low = sliding_exponent(abs(self.dundurs), self.friction)
        contacts = self.contacts
        sliding = self.friction * contacts.k_n * contacts.half_width / (2 * contacts.power)
        share = np.nanmax(np.abs(self.k[..., 0]), axis=1) / sliding
        return np.asarray((np.sqrt((1 - low) / low) - 1) * np.minimum(1.0, FARTHER * share))

    @cached_property
    def outermost(self) -> Array:
        """(S,) largest half-widths, with room for shear that moves the edge."""
        return np.asarray(self.contacts.widths(self.k_i).max(axis=1) * (1 + self.shift))

    def coefficients(self, s: Array) -> Array:
        """(S, n) at nodes (n,) inward from the outermost place, over its half-width."""
        found = np.repeat(self.friction[:, None], len(s), axis=1)
        for edge, behind in enumerate(self.behind):
            if behind is not None:
                place = self.outermost[edge] * (s - 1) + self.contacts.half_width[edge]
                found[edge] *= np.interp(place, *behind)
        return found

    def of(self, edges: Indices) -> EdgeHistories:
        """The same for some edges."""
        own = ("k", "k_i", "locked", "direction", "zone", "counted", "friction", "modulus")
        return replace(
            self,
            contacts=Contacts(*(each[edges] for each in vars(self.contacts).values())),
            halves=tuple(self.halves[edge] for edge in edges),
            behind=tuple(self.behind[edge] for edge in edges),
            **{name: getattr(self, name)[edges] for name in (*own, "tangential")},
        )


@dataclass(frozen=True)
class Tractions:
    """Tractions next to an edge in one state, (m,) each.

    Attributes:
        s: distance from the edge inward.
        pressure: p.
        shear: (m, 2) along `inward` and `along` of the station, on body 2.
    """

    s: Array
    pressure: Array
    shear: Array


@dataclass(frozen=True)
class SlipProfile:
    """Slip that a half cycle leaves behind next to an edge, (m,) each.

    Attributes:
        s: distance from the edge at the end of the half cycle inward, as far as the middle.
        slip: in the direction in which it is largest.
    """

    s: Array
    slip: Array


@dataclass(frozen=True)
class EdgeSlip:
    """The solution next to an edge.

    Attributes:
        profiles: of the half cycles, by their numbers; those up to where the contact slides.
        tractions: by the states that are shown, in their order.
        work: friction work in the cycle that repeats itself, or in all steps, per unit length.
        change: of the shear over the last cycle, over the swing of the force; NaN without one.
        reason: why there is no solution in all states, in words; empty if there is.
    """

    profiles: Mapping[int, SlipProfile]
    tractions: Mapping[int, Tractions]
    work: float
    change: float
    reason: str = ""


@dataclass(frozen=True)
class _Calendar:
    """Edges for which something begins or ends in a state, by states.

    Attributes:
        begins: edges a half cycle of which begins.
        ends: edges and numbers of the half cycles that end.
        show: edges whose tractions are wanted, and as which state.
    """

    begins: defaultdict[int, list[int]] = field(default_factory=lambda: defaultdict(list))
    ends: defaultdict[int, list[tuple[int, int]]] = field(default_factory=lambda: defaultdict(list))
    show: defaultdict[int, list[tuple[int, int]]] = field(default_factory=lambda: defaultdict(list))


def _calendar(
    halves: Sequence[Sequence[tuple[int, int]]],
    shown: Sequence[int],
    repeated: tuple[int, int] | None = None,
) -> _Calendar:
    """That of the half cycles of edges; of a repeated cycle those that come again in it.

    A half cycle that is not one of first loading began a period before, at the end of another one.
    """
    calendar = _Calendar()
    first, last = repeated or (0, 0)
    for edge, own in enumerate(halves):
        ends = {end for _, end in own}
        for number, (begin, end) in enumerate(own):
            later = begin + last - first
            if repeated and begin < first and later not in ends:
                continue
            for start in {begin, later}:
                calendar.begins[start].append(edge)
            calendar.ends[end].append((edge, number))
            if not shown:
                calendar.show[later if begin < first else begin].append((edge, begin))
                calendar.show[end].append((edge, end))
        for state in shown:
            calendar.show[state].append((edge, state))
    return calendar


class March:
    """Goes through the histories of S edges; lengths over the outermost half-width, E* = 1."""

    def __init__(self, histories: EdgeHistories, bodies: HalfPlanes) -> None:
        self._given, self._bodies = histories, bodies
        self._stiffness: Stiffness = bodies.stiffness(histories.tangential)
        self._shapes = pressure_shapes(histories.contacts.power)
        self._outermost = histories.outermost
        edges, nodes = len(histories.k), len(bodies.s)
        self._bound, self._pressure = np.zeros((2, edges, nodes))
        self._pressed: Pressed | None = None
        self._edges = np.zeros(edges)
        self._slipping = np.zeros((edges, nodes), dtype=bool)
        self._slip = np.zeros((2, edges, nodes))  # forward and backward in the half cycle
        self._work = np.zeros(edges)
        self._lost = np.zeros(edges, dtype=bool)
        # Which edges are given up changes on the way.
        self._limit = Bound(histories.coefficients(bodies.s), self._lost)
        self._reasons = np.full(edges, SLIDES, dtype=object)
        self._shear = histories.locked[:, None] * self._pressed_by(self._widths(1, 0.0))[..., None]
        self._drift, self._swing = self._drifts()
        self._farthest = self._largest_turns()
        self._profiles: list[dict[int, SlipProfile]] = [{} for _ in histories.halves]
        self._tractions: list[dict[int, Tractions]] = [{} for _ in histories.halves]

    def solve(self) -> list[EdgeSlip]:
        """March through all states, and again through the cycle until it is steady."""
        given, states = self._given, self._given.k.shape[1]
        first, last = given.cycle or (0, states - 1)
        change, whole = np.full(len(given.k), np.nan), _calendar(given.halves, given.shown)
        for state in range(1, last + 1):
            if state == first + 1:
                before, self._work[:] = self._shear.copy(), 0.0
            self._step(state, whole)
        if given.cycle is not None:
            change, again = self._changed(before), _calendar(given.halves, given.shown, given.cycle)
            for _ in range(MOST_CYCLES):
                if not (change[~self._lost] > STEADY).any():
                    break
                before, self._work[:] = self._shear.copy(), 0.0
                for edge, shown in again.show[first]:
                    self._tractions[edge][shown] = self._now(edge, last)
                for state in range(first + 1, last + 1):
                    self._step(state, again)
                change = self._changed(before)
        return [self._solution(edge, change[edge]) for edge in range(len(given.k))]

    def _drifts(self) -> tuple[Array, Array]:
        """(S, 2) force that the loads of a cycle leave, over all their changes, and (S,) its swing.

        Factors that are added up along a loop of P and Q out of phase need not come back to where
        they began, as the forces do: without it repeated cycles would move the contact on.
        """
        if self._given.cycle is None:
            return np.zeros((len(self._given.k), 2)), np.full(len(self._given.k), np.nan)
        first, last = self._given.cycle
        loads = np.array([self._load(state, 0.0, 1.0) for state in range(first + 1, last + 1)])
        size = np.abs(loads).sum(axis=0)
        drift = loads.sum(axis=0) / np.where(size > 0, size, 1.0)
        return drift, np.hypot(*size.T) / 2

    def _largest_turns(self) -> Array:
        """(S,) change of (K_T, K_S) in a part of a step where they turn, as slip follows them.

        A fortieth: around a hexagon, in one step a side or in ten, lengths are the same to 4 %.
        """
        k, (inward, along) = self._given.k, self._given.direction.T[..., None]
        swing = np.ptp(k[..., 0] * inward + k[..., 1] * along, axis=1)
        turn = np.ptp(k[..., 1] * inward - k[..., 0] * along, axis=1)
        return np.where(10 * turn > swing, swing / 40, np.inf)

    def _widths(self, state: int, share: float) -> Array:
        """(S,) half-widths at a share of the step to a state."""
        k_i = self._given.k_i
        return self._given.contacts.widths((1 - share) * k_i[:, state - 1] + share * k_i[:, state])

    def _pressed_by(self, width: Array) -> Array:
        """(S, n) pressure at half-widths, without what shear between unlike bodies adds."""
        level = self._given.contacts.level(width) / self._given.modulus
        return self._bodies.pressure(self._shapes, width / self._outermost) * level[:, None]

    def _load(self, state: int, begin: float, end: float) -> Array:
        """(S, 2) shear force that a part of a step adds, with E* = 1 and half-width 1."""
        contacts, middle = self._given.contacts, self._widths(state, (begin + end) / 2)
        added = (end - begin) * (self._given.k[:, state] - self._given.k[:, state - 1])
        scale = contacts.forces(middle) / (self._given.modulus * self._outermost)
        return np.asarray(scale[:, None] * added)

    def _step(self, state: int, calendar: _Calendar) -> None:
        """One step of the histories, or of a repeated cycle by its own calendar."""
        self._slip[:, calendar.begins[state - 1]] = 0.0
        moved = np.abs(self._widths(state, 1.0) - self._widths(state, 0.0))
        scale = np.minimum(LARGEST_MOVE * self._outermost, ZONE_MOVE * self._given.zone)
        turned = np.hypot(*(self._given.k[:, state] - self._given.k[:, state - 1]).T)
        most = np.maximum(moved / scale, turned / self._farthest).max()
        parts = int(np.clip(np.ceil(most - 1e-9), 1, MOST_PARTS))
        for part in range(parts):
            self._part(state, part / parts, (part + 1) / parts)
        for edge, number in calendar.ends[state]:
            if not self._lost[edge]:
                self._profiles[edge][number] = self._profile(edge, state)
        for edge, shown in calendar.show[state]:
            self._tractions[edge][shown] = self._now(edge, state)

    def _part(self, state: int, begin: float, end: float) -> None:
        given, bodies = self._given, self._bodies
        load = self._load(state, begin, end)
        if given.cycle is not None and state > given.cycle[0]:
            load = load - self._drift * np.abs(load)
        stuck = self._shear + bodies.part * self._stiffness.stuck[:, None] * load[:, None]
        if self._lost.all():
            return
        width = self._widths(state, end)
        pressure = self._pressed_by(width)
        bounds = (self._limit.friction * pressure).max(axis=1)
        tolerance = TOLERANCE * float(bounds[~self._lost].max())
        if isinstance(bodies, WholeHalfPlanes):
            contacts = UnlikeContacts.of(
                bodies,
                given.dundurs,
                self._shapes,
                given.contacts.power,
                given.contacts.level(width) / given.modulus,
                width / self._outermost,
            )
            pressure, solved = self._coupled(contacts, pressure, stuck, tolerance)
            bound = self._limit.of(pressure)
        else:
            bound = self._limit.of(pressure)
            solved = partial_slip(self._stiffness, bound, stuck, self._slipping, tolerance)
        self._lost[solved.unsolved] = True
        slip = np.where((bound > tolerance)[..., None], solved.slip, 0.0)
        direction = unit(solved.shear)
        amount = np.maximum(-np.sum(slip * direction, axis=-1), 0.0)
        works = amount * (bound + self._bound) / 2
        self._work += np.sum(works[:, self._bodies.own], axis=1)
        along = np.sum(slip * given.direction[:, None], axis=-1)
        counted = given.counted[:, state, None] * amount
        # Slip of body 2 against the shear: forward shear makes backward slip.
        self._slip += counted * np.array([along < 0, along >= 0])
        self._shear, self._bound, self._slipping = solved.shear, bound, solved.slipping
        self._pressure = pressure

    def _coupled(
        self, contacts: UnlikeContacts, pressure: Array, stuck: Array, tolerance: float
    ) -> tuple[Array, Slipped]:
        """Pressure and shear of unlike bodies, from the pressure (S, n) without shear."""
        if self._pressed is None:  # nothing has acted before
            middle = np.zeros(len(pressure))
            self._pressed = Pressed(pressure, contacts.half_width, middle)
        before = Before(self._pressed, self._slipping, self._shear)
        found = coupled_slip(contacts, self._stiffness, self._limit, stuck, before, tolerance)
        self._reasons[np.setdiff1d(found.unsettled, found.slipped.unsolved)] = UNSETTLED
        self._lost[found.unsettled] = True
        self._pressed = found.pressed
        self._edges = 1 + found.pressed.centre - found.pressed.half_width
        return found.pressed.pressure, found.slipped

    def _changed(self, before: Array) -> Array:
        change = np.hypot(*np.moveaxis(self._shear - before, -1, 0)) @ self._bodies.weights
        change /= self._bodies.part
        return np.asarray(change / np.where(self._swing > 0, self._swing, np.inf))

    def _profile(self, edge: int, state: int) -> SlipProfile:
        """Slip of a half cycle that ends in a state."""
        own, size = self._bodies.own, self._outermost[edge]
        both = (self._slip[:, edge] / self._bodies.weights)[:, own]
        s = size * self._bodies.s[own] - self._inside(edge, state)
        slip = both[np.argmax(both.max(axis=1))] * size
        return SlipProfile(s[s > 0], slip[s > 0])

    def _inside(self, edge: int, state: int) -> float:
        """Distance of an edge from its outermost place, of unlike bodies where it is now."""
        if self._given.dundurs:
            return float(self._outermost[edge] * self._edges[edge])
        return float(self._outermost[edge] - self._widths(state, 1.0)[edge])

    def _now(self, edge: int, state: int) -> Tractions:
        """Tractions next to an edge, of the front of a circle as there."""
        contacts, width = self._given.contacts, self._widths(state, 1.0)
        own = self._bodies.own
        s = self._outermost[edge] * self._bodies.s[own] - self._inside(edge, state)
        longer = (contacts.half_width / width) ** (contacts.power - 2)
        stress = self._given.modulus[edge] * longer[edge]
        touching = s > 0
        pressure, shear = self._pressure[edge, own], self._shear[edge, own]
        return Tractions(s[touching], stress * pressure[touching], stress * shear[touching])

    def _solution(self, edge: int, change: float) -> EdgeSlip:
        if self._lost[edge]:
            # In a cycle that repeats itself no half cycle comes before the sliding.
            known = {} if self._given.cycle else self._profiles[edge]
            return EdgeSlip(known, {}, math.nan, math.nan, str(self._reasons[edge]))
        tractions = dict(sorted(self._tractions[edge].items()))
        work = float(self._work[edge] * self._given.modulus[edge] * self._outermost[edge] ** 2)
        return EdgeSlip(self._profiles[edge], tractions, work, float(change))
