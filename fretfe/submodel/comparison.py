# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones and tractions at a station of solids beside those of the plane problem, with bars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.errors import OutputError
from fretfe.evaluate.contacts import Front, Station
from fretfe.evaluate.edge_tractions import edge_nodes
from fretfe.results.model import Result
from fretfe.submodel.equivalent import Equivalent

# Half-widths from the front inward within which tractions are shown, in the plane a little outside
# it too.
DEPTH, NEXT_TO = 1.0, 0.02


@dataclass(frozen=True)
class ZonePair:
    """A slip zone of a half cycle, in solids and in the plane.

    Attributes:
        start, end: times.
        solid, solid_spread: length found in solids, and error bar; NaN where not known.
        predicted, predicted_spread: by the factors of the station, and error bar by theirs.
        plane, plane_spread: length found in the plane, and error bar, which holds those of the
            factors of the station; NaN where there is none.
    """

    start: float
    end: float
    solid: float
    solid_spread: float
    predicted: float
    predicted_spread: float
    plane: float
    plane_spread: float


@dataclass(frozen=True)
class Tractions:
    """Pressure and shear over the distance s inward from the edge, (m,) each."""

    s: Array
    pressure: Array
    shear: Array


@dataclass(frozen=True)
class StationModel:
    """A station of solids and its plane problem.

    Attributes:
        contact, front, station: which it is.
        half_width: of the plane contact in the last state.
        radius, radius_spread: of its cylinder, and error bar by that of K_N.
        normal_force, normal_force_spread: P in the last state, likewise.
        k_angle: direction of (K_T, K_S) that stands for K_T, in degrees from `inward`.
        turning: range across it over that along it, which the plane leaves out.
        k_n, k_n_spread: K_N of the station in the last state, and error bar.
        plane_k_n: K_N of the plane problem, whose error bar is the same.
        k_range, k_range_spread: range of (K_T, K_S) over the cycle, and error bar; NaN without.
        k_mismatch: largest difference of the histories of K over its range.
        k_i_mismatch: the same of K_I over the larger one of both ranges.
        times: (n,) states taken over.
        k, plane_k: (n,) histories of K, from the last state.
        zones: half cycles, in time order.
        time: of the tractions.
        solid_tractions: around the station, shear along the direction of K; empty if not kept.
        plane_tractions: at the edge of the plane problem.
        plane: the results of the plane problem.
    """

    contact: str
    front: str
    station: int
    half_width: float
    radius: float
    radius_spread: float
    normal_force: float
    normal_force_spread: float
    k_angle: float
    turning: float
    k_n: float
    k_n_spread: float
    plane_k_n: float
    k_range: float
    k_range_spread: float
    k_mismatch: float
    k_i_mismatch: float
    times: Array
    k: Array
    plane_k: Array
    zones: tuple[ZonePair, ...]
    time: float
    solid_tractions: Tractions
    plane_tractions: Tractions
    plane: Result


def compare(
    solid: Result, front: Front, station: Station, given: Equivalent, plane: Result,
    name: str,
) -> StationModel:  # fmt: skip
    """Compare a station of the contact `name` with its plane problem."""
    left = plane.contacts[0].fronts[0]
    (edge,), depth = left.stations, DEPTH * given.half_width
    here, there = given.states, given.plane_states
    k, plane_k = (each - each[-1] for each in (given.k, edge.k_t[there]))
    k_i, plane_k_i = (each - each[-1] for each in (given.k_i, edge.k_i[there]))
    size = float(np.ptp(k[1:]))
    last = int(here[-1])
    return StationModel(
        contact=name,
        front=front.name,
        station=station.number,
        half_width=given.half_width,
        radius=given.radius,
        radius_spread=given.bars.k_n * given.radius,
        normal_force=float(given.normal_force[-1]),
        normal_force_spread=given.bars.k_n * float(given.normal_force[-1]),
        k_angle=station.k_angle,
        turning=station.turning,
        k_n=float(station.k_n[last]),
        k_n_spread=float(station.k_n_spread[last]),
        plane_k_n=float(edge.k_n[there[-1]]),
        k_range=station.k_range,
        k_range_spread=station.k_range_spread,
        k_mismatch=float(np.abs(k - plane_k)[1:].max() / size),
        k_i_mismatch=float(np.abs(k_i - plane_k_i)[1:].max() / max(size, float(np.ptp(k_i[1:])))),
        times=solid.loads.times[here],
        k=k,
        plane_k=plane_k,
        zones=_zones(solid, station, edge, given),
        time=float(solid.loads.times[last]),
        solid_tractions=_tractions(solid, name, front, station, last, (-station.size, depth)),
        plane_tractions=_tractions(
            plane, name, left, edge, int(there[-1]), (-NEXT_TO * given.half_width, depth)
        ),
        plane=plane,
    )


def _zones(
    solid: Result, station: Station, edge: Station, given: Equivalent
) -> tuple[ZonePair, ...]:
    """Half cycles between the same states."""
    shift = int(given.states[0] - given.plane_states[0])
    first = int(given.states[0])
    plane = {(max(zone.start + shift, first), zone.end + shift): zone for zone in edge.slip_zones}
    times = solid.loads.times
    return tuple(
        ZonePair(
            start=float(times[zone.start]),
            end=float(times[zone.end]),
            solid=zone.reported_length,
            solid_spread=zone.spread,
            predicted=zone.prediction,
            predicted_spread=given.bars.slip * zone.prediction,
            plane=twin.reported_length if twin else np.nan,
            plane_spread=twin.spread if twin else np.nan,
        )
        for zone, twin in (
            (each, plane.get((max(each.start, first), each.end)))
            for each in station.slip_zones
            if each.end > first
        )
    )


def _tractions(
    result: Result, contact: str, front: Front, station: Station, state: int,
    reach: tuple[float, float],
) -> Tractions:  # fmt: skip
    """Means around the nodes next to a station; none if those of the state are not kept."""
    nodes = edge_nodes(result.contact_history(contact), front, station, state, reach)
    try:
        return Tractions(nodes.s, *nodes.tractions(state))
    except OutputError:
        return Tractions(*np.empty((3, 0)))
