# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers that the benchmarks compare, read from the results of any backend.

All of them belong to the last state, or to the evaluated cycle, of the first contact. They are NaN
where the backend found none.
"""

from __future__ import annotations

import numpy as np

from fretfe.evaluate.contacts import Contact, Station
from fretfe.quality.comparison import Averaged, Measure
from fretfe.results.model import Result


def _contact(result: Result) -> Contact:
    return result.contacts[0]


def half_width(result: Result) -> float:
    """Half-width of the contact."""
    return float(_contact(result).half_width[-1])


def _last_k_n(station: Station) -> tuple[float, float]:
    return float(station.k_n[station.last]), float(station.k_n_spread[station.last])


# K_N at the end, mean of both edges; of solids of all stations.
k_n = Averaged(lambda result: [_last_k_n(each) for each in _judged(result)])


def k_t(result: Result) -> float:
    """The part of K_T that has opposite signs at the two edges: that of the shear force."""
    left, right = _contact(result).stations
    return float(left.k_t[-1] - right.k_t[-1]) / 2


def dissipation(result: Result) -> float:
    """Friction work in the cycle, or without one of all steps."""
    return float(_contact(result).dissipation)


def position(side: int) -> Measure:
    """Position of an edge."""
    return lambda result: float(_contact(result).stations[side].position[-1])


def k_t_range(side: int) -> Measure:
    """Range of K_T at an edge over the cycle."""

    def found(result: Result) -> list[tuple[float, float]]:
        station = _contact(result).stations[side]
        return [(station.k_t_range, station.k_range_spread)]

    return Averaged(found)


def slip_length(side: int) -> Measure:
    """Length of the last slip zone at an edge."""
    return Averaged(lambda result: [_last_length(_contact(result).stations[side])])


def slipping_k_n(side: int) -> Measure:
    """K_N of an edge when its last slip zone is complete."""

    def measure(result: Result) -> float:
        station = _contact(result).stations[side]
        return float(station.k_n[station.slip_zones[-1].end]) if station.slip_zones else np.nan

    return measure


def _last_length(station: Station) -> tuple[float, float]:
    return _last_zone(station, "length"), _last_zone(station, "spread")


def _last_zone(station: Station, attribute: str) -> float:
    """A number of the last slip zone; NaN without any."""
    return float(getattr(station.slip_zones[-1], attribute)) if station.slip_zones else np.nan


def predicted_length(side: int) -> Measure:
    """Length of the last slip zone at an edge as K_T and K_N predict it."""
    return lambda result: _last_zone(_contact(result).stations[side], "predicted")


# Length of the last slip zones, mean of all stations: in the plane those of both edges.
mean_slip_length = Averaged(
    lambda result: [_last_length(each) for each in _contact(result).stations]
)


def first_slip_length(result: Result) -> float:
    """Length of the slip zones before the last ones, mean of both edges."""
    return float(np.mean([each.slip_zones[-2].length for each in _contact(result).stations]))


def slip_at(x: float) -> Measure:
    """Displacement of body 1 relative to body 2 along a straight surface, from its first end on."""

    def measure(result: Result) -> float:
        contact = result.solution.contacts[0]
        places, slip = contact.surface.points[:, 0].copy(), contact.slip[-1, :, 0]
        # A mean with the weight of a hat function belongs to its centroid.
        places[0] += (places[1] - places[0]) / 3
        end = max(int(np.searchsorted(places, x)), 1)
        slope = (slip[end] - slip[end - 1]) / (places[end] - places[end - 1])
        return float(slip[end] + slope * (x - places[end]))

    return measure


def stick_half_width_ratio(result: Result) -> float:
    """c/a: half-width of the stick zone that the last slip zones leave, in half-widths."""
    return 1 - mean_slip_length(result) / half_width(result)


def stick_centre_ratio(result: Result) -> float:
    """e/a: centre of the same stick zone, in half-widths from the centre of the contact."""
    left, right = (_last_zone(station, "length") for station in _contact(result).stations)
    return (left - right) / (2 * half_width(result))


def stick_border(side: int) -> Measure:
    """Position of the inner end of the last slip zone at an edge."""
    return lambda result: _last_zone(_contact(result).stations[side], "border")


def peak_pressure(result: Result) -> float:
    """Largest pressure."""
    return float(result.solution.contacts[0].mean_traction[-1, :, 0].max())


def shear_at(x: float) -> Measure:
    """Shear at a distance from the centre, mean of both sides."""

    def measure(result: Result) -> float:
        contact = result.solution.contacts[0]
        places = _contact(result).centre[-1] + np.array([-x, x])
        shear = contact.mean_traction[-1, :, 1]
        return float(np.interp(places, contact.surface.arc, shear).mean())

    return measure


def force_ratio(numerator: str, denominator: str) -> Measure:
    """Ratio of the forces of two platen loads."""

    def measure(result: Result) -> float:
        forces = dict(zip(result.solution.coordinates, result.solution.forces[-1], strict=True))
        return float(forces[numerator] / forces[denominator])

    return measure


def front_range(attribute: str) -> Measure:
    """A range of the stations, mean of those that are not too near an end of their front."""
    return Averaged(
        lambda result: [(getattr(each, attribute), each.k_range_spread) for each in _judged(result)]
    )


def front_k_s(result: Result) -> float:
    """K_S of the same stations at the end of the cycle."""
    return float(np.mean([each.k_s[each.last] for each in _judged(result)]))


def _judged(result: Result) -> list[Station]:
    return [station for station in _contact(result).stations if not station.end]


def front_radius(result: Result) -> float:
    """Radius of a round contact about the origin, mean of the stations."""
    radii = [
        float(np.linalg.norm(station.point[[0, 2]]) - station.position[station.last])
        for station in _contact(result).stations
    ]
    return float(np.mean(radii))
