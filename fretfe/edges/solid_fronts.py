# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts of contacts between solids as an evaluation tells of them: stations along a curve.

T is the number of states; lengths and stresses are in the units of the case.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.edges.front import LARGEST_SPREAD, Frame, RangeSpread, SlipZone, StationHistory, told


@dataclass(frozen=True)
class SolidStation(StationHistory):
    """A point of a front of a solid contact, evaluated.

    `position` is the distance of the front from `point` along the station's `inward`; ranges are
    those over the evaluated cycle, NaN without one.

    Attributes:
        point: (3,) on the front in the reference state, before deformation.
        frame: there.
        arc: distance along the front.
        curvature: of the front in the tangent plane, positive where the contact is convex.
        to_end: distance along the front to its nearer end; infinite on a closed front.
        size: length of an element across the front.
        depth: half of the width of the contact along `inward`.
        length: over which K_N makes the pressure: half-width of the Hertzian contact whose pressure
            falls behind K_N sqrt(s) as fast.
        end: whether the station is so close to an end of its front that the fields are not those of
            an edge.
        k_n_moved: K_N in the last state from the movement of the front between two loads,
            2 dK_I/da; NaN where it is not known.
        k_n_moved_spread: its error bar.
        k_n_moved_reason: why it is not known; empty where it is.
        k_t_range: range of K_T.
        k_s_range: range of K_S.
        k_range: range of the vector (K_T, K_S) along `k_angle`.
        k_angle: direction in which that varies most, in degrees from `inward` towards `along`,
            between -90 and 90.
        turning: range across that direction over the one along it.
        k_range_spread: half the width of an interval that is meant to hold `k_range` with 95 %.
        k_range_parts: what that is made of.
        k_i_range: range of K_I.
        slip_zones: one for each half cycle, in time order.
    """

    point: Array
    frame: Frame
    arc: float
    curvature: float
    to_end: float
    size: float
    depth: float
    length: float
    end: bool
    k_n_moved: float
    k_n_moved_spread: float
    k_n_moved_reason: str
    k_t_range: float
    k_s_range: float
    k_range: float
    k_angle: float
    turning: float
    k_range_spread: float
    k_range_parts: RangeSpread
    k_i_range: float
    slip_zones: tuple[SlipZone, ...]

    @property
    def told_k_n(self) -> float:
        """K_N in the last state; NaN if its error bar is unknown or more than half of it."""
        return told(float(self.k_n[-1]), float(self.k_n_spread[-1]))

    @property
    def told_range(self) -> float:
        """The range of (K_T, K_S); NaN if its error bar is unknown or more than half of it."""
        return told(self.k_range, self.k_range_spread)

    @property
    def uncertain(self) -> bool:
        """True if the fits of K_N at the last state spread too far for a prediction."""
        return not self.k_n_spread[-1] <= LARGEST_SPREAD * self.k_n[-1]


@dataclass(frozen=True)
class Closure:
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


@dataclass(frozen=True)
class SolidFront:
    """A boundary curve of the contact area of two solids.

    Attributes:
        name: "front 1" and so on, the longest first.
        closed: whether it runs into itself.
        length: of it in the reference state, the last one of the evaluated cycle.
        closure: its factors against those of half-spaces under the same forces.
        stations: along it at an even spacing.
    """

    name: str
    closed: bool
    length: float
    closure: Closure
    stations: tuple[SolidStation, ...]

    @property
    def judged(self) -> tuple[SolidStation, ...]:
        """Stations that are not marked as too near an end."""
        return tuple(station for station in self.stations if not station.end)

    @property
    def worst(self) -> SolidStation | None:
        """Of the stations not too near an end that of the largest |ΔK| known; None without any."""
        known = [each for each in self.judged if np.isfinite(each.told_range)]
        return max(known, key=lambda each: each.told_range, default=None)

    def along(self, attribute: str) -> Array:
        """(n,) a number of all stations, by the name of the attribute."""
        return np.array([getattr(station, attribute) for station in self.stations])
