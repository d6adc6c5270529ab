# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts, their fronts and stations, and what an evaluation tells of them.

A front is a boundary curve of the contact area, a station a point of it with a frame. A plane
contact has two fronts, "left" and "right", of one station each: its edges. T is the number of
states; lengths, stresses and forces are in the units of the case, forces of plane contacts per unit
thickness.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from fretfe._typing import Array, Bools, Indices

# Error bar of K_N or of the range of K_T, relative to it, from which it is marked as uncertain.
LARGEST_SPREAD = 0.05
# The same of the length of a slip zone.
LARGEST_ZONE_SPREAD = 0.1
# Error bar, relative to its number, beyond which tables show no number.
NO_NUMBER = 0.5
# Counted cycles whose ranges differ by less than this fraction are the same cycle.
SAME_RANGE = 1e-3


def reported(value: float, spread: float) -> float:
    """A number with its error bar; NaN if the bar is unknown or more than half of the number."""
    return float(value) if spread <= NO_NUMBER * abs(value) else math.nan


def known_length(length: float, spread: float) -> bool:
    """True if the length of a slip zone is known to a tenth or better, or there is no slip."""
    return length == 0 or spread <= LARGEST_ZONE_SPREAD * length


@dataclass(frozen=True)
class Frame:
    """Right-handed unit vectors of a station before deformation, (3,) each; NaN where unknown.

    Attributes:
        inward: normal of the front in the tangent plane of the contact, into the contact.
        along: tangent of the front, `across` x `inward`; in the plane out of it.
        across: outward normal of body 2.
    """

    inward: Array
    along: Array
    across: Array


@dataclass(frozen=True)
class SlipZone:
    """Slip at one station in one direction, from one reversal to the next.

    Attributes:
        start, end: states between which the nodes slipped.
        length: slip-zone length from the front at `end`, inward; NaN if the whole contact slipped.
        border: position of its inner end along the arc.
        spread: half the width of an interval that is meant to hold `length` with 95 %: border of
            the slip, position of the front, and extremes of the cycle between the steps; infinite
            where it cannot be told.
        resolved: whether the mesh resolves the zone: its border and the front.
        gross: whether the whole contact slipped.
        predicted: slip length from K_T and K_N: 2 K_T/(f K_N) for first loading, ΔK_T/(f K_N) in
            the evaluated cycle; NaN elsewhere.
        predicted_loop: the same with varying normal load, from `end`; NaN outside the cycle.
        across: between solids the mean shear across the direction of (K_T, K_S) over that of f p,
            behind the predicted zone and when the half cycle begins; NaN in the plane.
        flank: mean shear along that direction over that of f p, farther behind and at `end`, where
            the mesh does not resolve the zone; NaN elsewhere.
    """

    start: int
    end: int
    length: float
    border: float
    spread: float
    resolved: bool
    gross: bool
    predicted: float
    predicted_loop: float
    across: float = field(default=math.nan, kw_only=True)
    flank: float = field(default=math.nan, kw_only=True)

    @property
    def reported_length(self) -> float:
        """The length, unless its error bar is unknown or more than half of it: then NaN.

        No slip is told as 0, with its bar.
        """
        return 0.0 if self.length == 0 else reported(self.length, self.spread)

    @property
    def uncertain(self) -> bool:
        """True if the mesh does not resolve the zone, or its length is known to a tenth at best."""
        return not (self.gross or (self.resolved and known_length(self.length, self.spread)))

    @property
    def prediction(self) -> float:
        """Predicted length to compare with: `predicted_loop` in the cycle, else `predicted`."""
        return self.predicted_loop if np.isfinite(self.predicted_loop) else self.predicted


@dataclass(frozen=True)
class CountedCycles:
    """Cycles of a station, counted by the rainflow method: n of them, in the order they close.

    Attributes:
        start, end: (n,) states of the two reversals. `start` may be the later one in a cycle that
            repeats itself: the range then goes on in the next repetition.
        count: (n,) 1, or 0.5 for a range that nothing closes.
        k_t_range, k_t_mean: (n,) difference of K_T at the two reversals, positive, and its mean.
        effective_range: (n,) larger K_T - f K_I less smaller K_T + f K_I, with K_I counted from the
            outermost place of the edge: what is counted, and the same as `k_t_range` at constant P.
        slip: (n,) predicted length of the slip zone from the edge as it is at `end`; NaN where K_N
            is unknown there.
        closed: whether the history that was counted repeats itself: all counts are 1.
        reason: why nothing was counted; empty if it was.
    """

    start: Indices
    end: Indices
    count: Array
    k_t_range: Array
    k_t_mean: Array
    effective_range: Array
    slip: Array
    closed: bool
    reason: str

    @property
    def worst(self) -> int:
        """Number of the cycle with the largest effective range, the last one of equal ones.

        Raises:
            ValueError: if there is none.
        """
        size = self.effective_range
        return int(np.flatnonzero(size >= (1 - SAME_RANGE) * size.max())[-1])

    @property
    def irregular(self) -> bool:
        """True if the cycles differ, those aside in which the history begins and ends."""
        inner = self.effective_range[~self._outermost]
        return len(inner) > 1 and bool(np.ptp(inner) > SAME_RANGE * inner.max())

    @property
    def _outermost(self) -> Bools:
        """(n,) half cycles of first loading, and those that the end of the history cuts off."""
        if self.closed or not len(self.count):
            return np.zeros(len(self.count), dtype=bool)
        ends = (self.start == self.start.min()) | (self.end == self.end.max())
        return np.asarray((self.count < 1) & ends)


@dataclass(frozen=True)
class StationHistory:
    """Position and factors of a station in every state.

    Attributes:
        front: name of its front.
        number: place along the front, from 0.
        position: (T,) along the arc; NaN where there is no contact or it cannot be fitted.
        position_spread: (T,) its error bar.
        k_n: (T,) pressure factor.
        k_n_spread: (T,) its error bar.
        k_t: (T,) factor of the shear along `inward`, counted from the first state with friction,
            or the first one from which on it is known; NaN before and where unknown.
        k_s: (T,) factor of the shear along `along`, counted likewise; zero in the plane.
        k_i: (T,) factor of the normal increments, counted likewise from the first state in contact.
        last: state that single numbers are told of: the last one of the evaluated cycle, or of the
            history without one.
    """

    front: str
    number: int
    position: Array
    position_spread: Array
    k_n: Array
    k_n_spread: Array
    k_t: Array
    k_s: Array
    k_i: Array
    last: int = field(default=-1, kw_only=True)

    @property
    def last_k_n(self) -> tuple[float, float]:
        """K_N in the state `last`, and its error bar."""
        return float(self.k_n[self.last]), float(self.k_n_spread[self.last])

    @property
    def reported_k_n(self) -> float:
        """K_N in the state `last`; NaN if its error bar is unknown or more than half of it."""
        return reported(*self.last_k_n)


@dataclass(frozen=True)
class RangeSpread:
    """Parts of the error bar of a range of K_T, each half the width of a 95 % interval.

    Attributes:
        extraction: half the difference of the ranges that the radii of the interaction integral
            give; 0 if K_T is known in closed form, NaN if nothing can be compared.
        discretisation: difference from the range by fits to tractions, and what steps contribute of
            which one end is unknown.
        steps: how far K_T exceeds the range between the steps, and what the movement of the edge
            within them may change.
    """

    extraction: float
    discretisation: float
    steps: float

    @property
    def total(self) -> float:
        """All parts together; NaN if one is unknown."""
        return math.hypot(self.extraction, self.discretisation, self.steps)


@dataclass(frozen=True, kw_only=True)
class Station(StationHistory):
    """A point of a contact front, evaluated.

    Ranges are those over the evaluated cycle, NaN without one, or where a factor is unknown in one
    of its states. In the plane `position` is that along the arc, (K_T, K_S) is K_T, and a front has
    no curvature and no ends. Between solids `position` is the distance of the front from `point`
    along `frame.inward`, and cycles are counted of K along `k_angle`.

    Attributes:
        frame: in the plane in the last state in which the position is known, of solids before
            deformation.
        point: (3,) place before deformation: in the plane in the same state as `frame`, of solids
            on the front in the reference state; NaN where unknown.
        arc: distance along the front.
        curvature: of the front in the tangent plane, positive where the contact is convex.
        to_end: distance along the front to its nearer end; infinite on a closed front, NaN in the
            plane.
        size: length of an element across the front; 0 without elements.
        depth: half of the width of the contact along `inward`; NaN in the plane.
        length: over which K_N makes the pressure: half-width of the Hertzian contact whose pressure
            falls behind K_N sqrt(s) as fast; NaN in the plane.
        end: whether the station is so close to an end of its front that the fields are not those of
            an edge.
        k_n_moved: K_N in the last state from the movement of the front between two load levels,
            2 dK_I/da; NaN where it is not known, and between dissimilar bodies with friction.
        k_n_moved_spread: error bar of `k_n_moved`.
        k_n_moved_reason: why it is not known, between solids; empty where it is.
        stiffening: relative growth of dP/da with the half-width a in the last state, from the same
            two loads; it tells how long a slip zone may be for the edge description. Of solids that
            of a circle of the half-width `length`: 2/`length`.
        k_t_range: range of K_T.
        k_s_range: range of K_S.
        k_range: range of the vector (K_T, K_S) along `k_angle`.
        k_angle: direction in which that varies most, in degrees from `inward` towards `along`,
            between -90 and 90.
        turning: range across that direction over the one along it.
        k_range_spread: half the width of an interval that is meant to hold `k_range` with 95 %; 0
            if the factors are known in closed form at any time, NaN if nothing can be compared.
        k_range_parts: what that is made of.
        k_t_range_fitted: range of K_T by fits to the tractions of full stick; NaN without them.
        k_i_range: range of K_I.
        cycles: counted in the evaluated cycle, or in the whole history without one.
        slip_zones: one for each half cycle, in time order; if the counted cycles are irregular,
            only those of the worst one.
        dissipation: friction work on this side of the contact in the evaluated cycle, per unit
            thickness; NaN of solids.
    """

    frame: Frame
    point: Array = field(default_factory=lambda: np.full(3, np.nan))
    arc: float = 0.0
    curvature: float = 0.0
    to_end: float = math.nan
    size: float = 0.0
    depth: float = math.nan
    length: float = math.nan
    end: bool = False
    k_n_moved: float
    k_n_moved_spread: float
    k_n_moved_reason: str = ""
    stiffening: float = math.nan
    k_t_range: float
    k_s_range: float = 0.0
    k_range: float
    k_angle: float = 0.0
    turning: float = 0.0
    k_range_spread: float
    k_range_parts: RangeSpread
    k_t_range_fitted: float = math.nan
    k_i_range: float
    cycles: CountedCycles
    slip_zones: tuple[SlipZone, ...]
    dissipation: float = math.nan

    @property
    def reported_range(self) -> float:
        """The range of (K_T, K_S); NaN if its error bar is unknown or more than half of it."""
        return reported(self.k_range, self.k_range_spread)

    @property
    def uncertain(self) -> bool:
        """True if the fits of K_N in the state `last` spread too far for a prediction."""
        k_n, spread = self.last_k_n
        return spread > LARGEST_SPREAD * k_n

    @property
    def uncertain_range(self) -> bool:
        """True if the range of (K_T, K_S) is known to less than a twentieth, or not how well."""
        if not math.isfinite(self.k_range):
            return False
        return not self.k_range_spread <= LARGEST_SPREAD * self.k_range


@dataclass(frozen=True)
class HalfSpaceRatios:
    """Ratios of the factors found around a front to those of half-spaces under the same forces.

    NaN where there is no such force. Means over the stations, by least squares.

    Attributes:
        half_axes: (2,) of the ellipse, the longer one first.
        shear: of (K_T, K_S) to those of the shear force.
        twist: of K_S to that of the moment about the normal; circles only.
        normal: of K_I to that of P.
        pressure: of K_N to that of dP/da, between two loads.
        reason: why there are no ratios, in words; empty if there are.
    """

    half_axes: Array
    shear: float
    twist: float
    normal: float
    pressure: float
    reason: str


NO_RATIOS = HalfSpaceRatios(np.full(2, np.nan), np.nan, np.nan, np.nan, np.nan, "")


@dataclass(frozen=True)
class Front:
    """A boundary curve of a contact area, as its stations along it; at least one.

    Attributes:
        name: in the plane "left" or "right", of solids "front 1" and so on, the longest first.
        stations: along it at an even spacing.
        closed: whether it runs into itself.
        length: of it in the reference state, the last one of the evaluated cycle; NaN in the plane.
        half_space_ratios: its factors against those of half-spaces under the same forces.
    """

    name: str
    stations: tuple[Station, ...]
    closed: bool = False
    length: float = math.nan
    half_space_ratios: HalfSpaceRatios = NO_RATIOS

    @property
    def judged(self) -> tuple[Station, ...]:
        """Stations that are not marked as too near an end."""
        return tuple(station for station in self.stations if not station.end)

    @property
    def worst(self) -> Station | None:
        """Of the stations not too near an end that of the largest |ΔK| known; None without any."""
        known = [each for each in self.judged if np.isfinite(each.reported_range)]
        return max(known, key=lambda each: each.reported_range, default=None)

    def along(self, attribute: str) -> Array:
        """(n,) a number of all stations, by the name of the attribute."""
        return np.array([getattr(station, attribute) for station in self.stations])


def fronts_of(stations: Iterable[Station]) -> tuple[Front, ...]:
    """The fronts that stations belong to, in the order in which they occur."""
    named: dict[str, list[Station]] = {}
    for station in stations:
        named.setdefault(station.front, []).append(station)
    return tuple(Front(name, tuple(each)) for name, each in named.items())


@dataclass(frozen=True, kw_only=True)
class Contact:
    """One contact, evaluated: a surface pair, or one of several patches of it.

    Forces are per unit thickness in the plane; between solids vectors (T, 3) are in the axes of the
    case. Areas are widths in the plane. They belong to the nodes, which count as a whole: areas
    grow in steps of an element. Histories that a backend does not know are (0,).

    Attributes:
        name: that of the pair; with a number in brackets for one of several patches.
        pair: name of the surface pair, the contact in the case.
        fronts: in the plane left and right; between solids the boundary curves of the contact area,
            none where they cannot be told.
        normal_force: (T,) P, integral of the pressure.
        shear_force: (T,) Q along the arc; (T, 3) of solids, integral of the shear traction that
            body 1 exerts on body 2.
        force: (T, d) all that body 1 exerts on body 2; on curved surfaces the pressure has a share
            in every component.
        centre: (T,) middle between the edges along the arc; (T, 3) of solids, centre of pressure;
            NaN where nothing presses.
        moment: (T,) moment of the pressure about `centre`; (T, 3) of solids, moment of all
            tractions on body 2 about it.
        half_width: (T,) of a plane contact, NaN where it has none; (0,) of solids.
        contact_area, stick_area: (T,) of the nodes in contact, and of those of them that stick.
        largest_pressure: (T,) of the means around the nodes.
        work: (T,) friction work in the step to each state.
        effective_tension: (T,) bulk tension that gives half-planes the same mean of K_T over the
            two fronts, counted like K_T; (0,) of solids.
        shear_mismatch: (range of Q that half-planes need for K_T at the two fronts)/(range of Q of
            full stick) - 1 over the cycle: zero if the half-plane description holds; NaN without a
            cycle, and of solids.
        cycle_change: change of the shear over the evaluated cycle relative to f p_max.
        steady: whether that is below the limit; False without a cycle.
        dissipation: friction work in the evaluated cycle, or of all steps without one.
        dissipation_change: relative change of it from the cycle before; NaN if there is none.
        warnings: what a reader must know, in words.
    """

    name: str
    pair: str
    fronts: tuple[Front, ...]
    normal_force: Array
    shear_force: Array
    force: Array = field(default_factory=lambda: np.empty(0))
    centre: Array
    moment: Array
    half_width: Array = field(default_factory=lambda: np.empty(0))
    contact_area: Array = field(default_factory=lambda: np.empty(0))
    stick_area: Array = field(default_factory=lambda: np.empty(0))
    largest_pressure: Array = field(default_factory=lambda: np.empty(0))
    work: Array = field(default_factory=lambda: np.empty(0))
    effective_tension: Array = field(default_factory=lambda: np.empty(0))
    shear_mismatch: float = math.nan
    cycle_change: float
    steady: bool
    dissipation: float
    dissipation_change: float
    warnings: tuple[str, ...]

    @property
    def solid(self) -> bool:
        """True between solids."""
        return self.shear_force.ndim == 2

    @property
    def stations(self) -> tuple[Station, ...]:
        """The stations of all fronts in one row: in the plane the left and the right edge."""
        return tuple(station for front in self.fronts for station in front.stations)
