# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts of a contact, their stations, and what an evaluation tells of them.

A front is a boundary curve of the contact area, a station a point of it with a frame. A plane
contact has two fronts, "left" and "right", of one station each: its edges. T is the number of
states; lengths, stresses and forces are in the units of the case, forces per unit thickness.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools, Indices

# Error bar of K_N or of the range of K_T, relative to it, from which it is marked as uncertain.
LARGEST_SPREAD = 0.05
# Error bar, relative to its number, beyond which tables show no number.
NO_NUMBER = 0.5
# Counted cycles whose ranges differ by less than this fraction are the same cycle.
SAME_RANGE = 1e-3


def told(value: float, spread: float) -> float:
    """A number with its error bar; NaN if the bar is unknown or more than half of the number."""
    return float(value) if spread <= NO_NUMBER * abs(value) else math.nan


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

    @property
    def told_length(self) -> float:
        """The length, unless its error bar is unknown or more than half of it: then NaN."""
        return told(self.length, self.spread)

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


@dataclass(frozen=True)
class RangeSpread:
    """Parts of the error bar of a range of K_T, each half the width of a 95 % interval.

    Attributes:
        extraction: half the difference of the ranges that the radii of the interaction integral
            give; 0 if K_T is known in closed form, NaN if nothing can be compared.
        discretisation: difference from the range by fits to tractions, and what steps contribute of
            which one end is unknown.
        steps: how far K_T exceeds the range between the steps.
    """

    extraction: float
    discretisation: float
    steps: float

    @property
    def total(self) -> float:
        """All parts together; NaN if one is unknown."""
        return math.hypot(self.extraction, self.discretisation, self.steps)


@dataclass(frozen=True)
class Station(StationHistory):
    """A point of a contact front, evaluated.

    Attributes:
        frame: in the last state in which the position is known.
        k_n_moved: K_N in the last state from the movement of the front between two load levels,
            2 dK_I/da; NaN without them, and between dissimilar bodies with friction.
        k_n_moved_spread: error bar of `k_n_moved`.
        stiffening: relative growth of dP/da with the half-width a in the last state, from the same
            two loads; it tells how long a slip zone may be for the edge description.
        k_t_range: range of K_T over the evaluated cycle; NaN without one, or if K_T is unknown in
            one of its states.
        k_t_range_spread: half the width of an interval that is meant to hold it with 95 %; 0 if
            K_T is known in closed form at any time, NaN if nothing can be compared.
        k_t_range_parts: what that is made of.
        k_t_range_fitted: range of K_T by fits to the tractions of full stick; NaN without them.
        k_i_range: range of K_I.
        cycles: counted in the evaluated cycle, or in the whole history without one.
        slip_zones: one for each half cycle, in time order; if the counted cycles are irregular,
            only those of the worst one.
        dissipation: friction work on this side of the contact in the evaluated cycle, per unit
            thickness.
    """

    frame: Frame
    k_n_moved: float
    k_n_moved_spread: float
    stiffening: float
    k_t_range: float
    k_t_range_spread: float
    k_t_range_parts: RangeSpread
    k_t_range_fitted: float
    k_i_range: float
    cycles: CountedCycles
    slip_zones: tuple[SlipZone, ...]
    dissipation: float

    @property
    def told_k_n(self) -> float:
        """K_N in the last state; NaN if its error bar is unknown or more than half of it."""
        return told(float(self.k_n[-1]), float(self.k_n_spread[-1]))

    @property
    def told_range(self) -> float:
        """The range of K_T; NaN if its error bar is unknown or more than half of it."""
        return told(self.k_t_range, self.k_t_range_spread)

    @property
    def uncertain(self) -> bool:
        """True if the fits of K_N at the last state spread too far for a prediction."""
        return bool(self.k_n_spread[-1] > LARGEST_SPREAD * self.k_n[-1])

    @property
    def uncertain_range(self) -> bool:
        """True if the range of K_T is known to less than a twentieth, or not known how well."""
        if not math.isfinite(self.k_t_range):
            return False
        return not self.k_t_range_spread <= LARGEST_SPREAD * self.k_t_range


@dataclass(frozen=True)
class Front:
    """A boundary curve of a contact area, as its stations along it; at least one."""

    stations: tuple[Station, ...]

    @property
    def name(self) -> str:
        """The name of the front; in the plane "left" or "right"."""
        return self.stations[0].front


def fronts_of(stations: Iterable[Station]) -> tuple[Front, ...]:
    """The fronts that stations belong to, in the order in which they occur."""
    named: dict[str, list[Station]] = {}
    for station in stations:
        named.setdefault(station.front, []).append(station)
    return tuple(Front(tuple(each)) for each in named.values())


@dataclass(frozen=True)
class ContactSummary:
    """One contact, evaluated: a surface pair, or one of several patches of it.

    Attributes:
        name: that of the pair; with a number in brackets for one of several patches.
        pair: name of the surface pair, the contact in the case.
        fronts: in the plane left and right.
        normal_force, shear_force: (T,) P and Q per unit thickness.
        moment: (T,) moment of the pressure about the centre of the contact.
        centre, half_width: (T,) of the contact, NaN where it has none.
        effective_tension: (T,) bulk tension that gives half-planes the same mean of K_T over the
            two fronts, counted like K_T.
        shear_mismatch: (range of Q that half-planes need for K_T at the two fronts)/(range of Q of
            full stick) - 1 over the cycle: zero if the half-plane description holds; NaN without a
            cycle.
        cycle_change: change of the shear over the evaluated cycle relative to f p_max.
        steady: whether that is below the limit; False without a cycle.
        dissipation: friction work in the evaluated cycle, per unit thickness.
        dissipation_change: relative change of it from the cycle before; NaN if there is none.
        warnings: what a reader must know, in words.
    """

    name: str
    pair: str
    fronts: tuple[Front, ...]
    normal_force: Array
    shear_force: Array
    moment: Array
    centre: Array
    half_width: Array
    effective_tension: Array
    shear_mismatch: float
    cycle_change: float
    steady: bool
    dissipation: float
    dissipation_change: float
    warnings: tuple[str, ...]

    @property
    def stations(self) -> tuple[Station, ...]:
        """The stations of all fronts in one row: in the plane the left and the right edge."""
        return tuple(station for front in self.fronts for station in front.stations)
