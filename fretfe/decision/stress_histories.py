# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories of the whole stress tensor below edges and stations, for other fatigue programs.

At places on rays from the edge, as cracks start there, through the evaluated cycle: from its
outermost place and, where it moves, from that at which the surface is pulled most. S11 is along
the surface, inward; S22 along the outward normal; S33 along z, of solids along the front; shears
are those of the tensor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Body, isotropic
from fretfe.decision.distances import elastic_strain
from fretfe.decision.field import (
    WITHIN_ELEMENT,
    EdgeField,
    edge_field,
    edgeless,
    error_of_tractions,
)
from fretfe.decision.station_field import BothFields, station_fields
from fretfe.decision.worst_places import error_weights
from fretfe.errors import CaseError
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.critical_planes import fatemi_socie, find_critical, smith_watson_topper
from fretfe.exchange.export import FATEMI_SOCIE, STATE, STRESS, ExportTable, headings
from fretfe.files import replacing, writing
from fretfe.results.hdf5_file import new_hdf5, store
from fretfe.results.model import Result
from fretfe.results.quantities import CONTACT, EDGE, Column

FILE = "edge_histories"
TENSOR_NAMES = ("S11", "S22", "S33", "S12", "S13", "S23")
HISTORY_COLUMNS = (
    CONTACT,
    replace(EDGE, meaning="left or right; of solids the front and the number of the station"),
    Column("body", "", "name of the body"),
    Column("angle", "angle", "of the ray from the inward normal, positive under the contact"),
    Column("start", "length", "of the ray, inward from the outermost place of the edge"),
    Column("distance", "length", "along the ray"),
    *STATE,
    *(Column(name, "stress", "component of the stress there") for name in TENSOR_NAMES),
)
SWT, SHEAR = STRESS[-2:]
PARAMETER_COLUMNS = (
    *HISTORY_COLUMNS[:6],
    Column("stress_spread", "stress", "error bar of the stress"),
    SWT,
    Column("swt_spread", "stress", "error bar of swt"),
    SHEAR,
)


@dataclass(frozen=True)
class EdgeHistory:
    """Stress below one edge in one body.

    Attributes:
        contact, edge, body: their names; of a contact without edges only its own.
        angles, distances: (M,) of the places, in degrees and units of length.
        starts: (M,) of their rays, inward from the outermost place of the edge.
        states: (n,) their numbers.
        times: (n,).
        stress: (n, M, 6) `TENSOR_NAMES`.
        reason: why there is none; empty if all places are known.
        spreads: (M,) error bars of the stress there.
    """

    contact: str
    edge: str
    body: str
    angles: Array
    starts: Array
    distances: Array
    states: Indices
    times: Array
    stress: Array
    reason: str
    spreads: Array


def edge_histories(
    result: Result, distances: Sequence[float], angles: Sequence[float] = (0.0,)
) -> tuple[EdgeHistory, ...]:
    """Stress at distances from edges, and from the stations of solids, through the evaluated cycle.

    Args:
        result: of half-planes, or with `[output] stress_depths`.
        distances: along the rays, not negative.
        angles: of the rays, from -80 to 80 degrees.

    Raises:
        CaseError: if a number is outside of these, or no stress is known as far away.
    """
    if not all(math.isfinite(each) and each >= 0 for each in distances):
        raise CaseError("--depth: expected finite numbers, not negative, found others")
    if not all(-80 <= each <= 80 for each in angles):
        raise CaseError("--angle: expected degrees from -80 to 80, found others")
    both = tuple(dict.fromkeys(angles)), tuple(dict.fromkeys(distances))
    turns, steps = (each.ravel() for each in np.meshgrid(*both, indexing="ij"))
    fields = list(_fields(result))
    reaches = [
        field.reach(float(each))
        for _, _, field in fields
        if isinstance(field, EdgeField)
        for each in np.radians(both[0])
    ]
    if reaches and max(reaches) < max(distances, default=0.0):
        most = 0.9999 * max(reaches)  # however it is rounded
        raise CaseError(
            f"--depth: expected at most {most:.5g} {result.case.units.length}, to which "
            f"the stress is known, found {max(distances):g}"
        )
    lost = [(each.name, reason) for each in result.contacts if (reason := edgeless(each))]
    return (
        *(_unknown((name, "", ""), reason) for name, reason in lost),
        *(
            _unknown(name, field)
            if isinstance(field, str)
            else _history(result, name, (station, field), turns, steps)
            for name, station, field in fields
        ),
    )


def _fields(result: Result) -> Iterator[tuple[tuple[str, str, str], Station, EdgeField | str]]:
    """Stress at all edges and stations in both bodies: names, station, and what is known."""
    for contact in result.contacts:
        pair = next(each for each in result.solution.contacts if each.pair == contact.pair)
        own = station_fields(result, contact) if result.solid else _edges(result, contact)
        for station, fields in own:
            edge = f"{station.front}.{station.number}" if result.solid else station.front
            for body, field in zip((pair.body1, pair.body2), fields, strict=True):
                yield (contact.name, edge, body), station, field


def _edges(result: Result, contact: Contact) -> Iterator[tuple[Station, BothFields]]:
    for station in contact.edges:
        yield station, (
            edge_field(result, contact, station, 0), edge_field(result, contact, station, 1)
        )  # fmt: skip


def _unknown(name: tuple[str, str, str], reason: str) -> EdgeHistory:
    none, states = np.zeros(0), np.zeros(0, dtype=np.int64)
    return EdgeHistory(*name, none, none, none, states, none, np.zeros((0, 0, 6)), reason, none)


def _history(
    result: Result,
    name: tuple[str, str, str],
    at: tuple[Station, EdgeField],
    turns: Array,
    steps: Array,
) -> EdgeHistory:
    """Stress at angles and distances (M,) from all starts, as far as it is known."""
    station, field = at
    parts, reasons = [], []
    for own in field.starts:
        reach = np.array([own.reach(float(each)) for each in np.radians(turns)])
        near, far = steps < own.finest, steps > reach
        reasons += [(near, f"places within an element of the edge, {own.finest:.3g}, are unknown")]
        reasons += [(far, f"stress is known to {reach.min():.3g} only: places beyond are left out")]
        inside = ~near & ~far
        parts.append((turns[inside], np.full(inside.sum(), own.start), steps[inside]))
    angles, starts, distances = map(np.concatenate, zip(*parts, strict=True))
    rays = np.radians(angles)
    points = np.stack([np.sin(rays), -np.cos(rays)], axis=1) * distances[:, None]
    points[:, 0] += starts
    stress = np.zeros((len(field.states), len(points), 6))
    values = field.stress(points)[..., [0, 1, 2, 3, -1, -2][: 6 if result.solid else 4]]
    stress[..., : values.shape[-1]] = values
    times = np.asarray(result.loads.times)[field.states]
    return EdgeHistory(
        *name, angles, starts, distances, field.states, times, stress,
        "; ".join(dict.fromkeys(text for places, text in reasons if places.any())),
        _spreads(field, station, distances, stress),
    )  # fmt: skip


def _spreads(field: EdgeField, station: Station, distances: Array, stress: Array) -> Array:
    """(M,) error bars: of the factors of the edge, of elements next to it, of what bodies add."""
    within = np.where(distances < field.size, WITHIN_ELEMENT, 0.0)
    relative = np.hypot(error_of_tractions(station), within)
    largest = np.abs(stress).max(axis=(0, 2), initial=0.0)
    return np.hypot(relative * largest, field.smooth.spread)


def history_table(result: Result, histories: Sequence[EdgeHistory]) -> ExportTable:
    """A row for each place and state."""
    rows = (
        (each.contact, each.edge, each.body, *at, state, time, *stress)
        for each in histories
        for place, at in enumerate(zip(each.angles, each.starts, each.distances, strict=True))
        for state, time, stress in zip(each.states, each.times, each.stress[:, place], strict=True)
    )
    return ExportTable(
        f"{FILE}.csv", headings(HISTORY_COLUMNS, result.case.units, solid=False), rows
    )


def parameter_table(
    result: Result, histories: Sequence[EdgeHistory], numbers: tuple[float, float] | None = None
) -> ExportTable:
    """A row for each place: parameters on critical planes, as of `StressParameters`.

    Args:
        result: of isotropic bodies.
        histories: of it.
        numbers: k and yield stress of Fatemi and Socie, if they are known.

    Raises:
        CaseError: as for `fatemi_socie`.
    """
    # Without the normal stress there is nothing to be weighted by the yield stress.
    parameters = [smith_watson_topper, fatemi_socie(0.0, 1.0)]
    parameters += [fatemi_socie(*numbers)] if numbers else []
    rows = []
    for each in histories:
        body = isotropic(result.case.bodies[each.body]) if len(each.distances) else None
        if body is None:
            continue
        stress = each.stress[..., [0, 1, 2, 3, 5, 4]]
        strain = elastic_strain(stress, body)
        values = [find_critical(stress, strain, parameter).value for parameter in parameters]
        values.insert(1, _swt_spreads(stress, strain, each.spreads, body))
        name = each.contact, each.edge, each.body
        places = zip(each.angles, each.starts, each.distances, each.spreads, *values, strict=True)
        rows += [(*name, *place) for place in places]
    columns = (*PARAMETER_COLUMNS, *([FATEMI_SOCIE] if numbers else []))
    named = headings(columns, result.case.units, solid=False)
    return ExportTable("edge_parameters.csv", named, iter(rows))


def _swt_spreads(stress: Array, strain: Array, spreads: Array, body: Body) -> Array:
    """(M,) error bars of σ_max ε_a by those of the stress; where nothing pulls, what they allow."""
    found = find_critical(stress, strain, smith_watson_topper)
    product = body.young * found.value
    # Of √(σ_max E ε_a) it is the bar of the stress times a weight.
    half = error_weights(stress, found.normal, product) * spreads * np.sqrt(product)
    pulled = stress.copy()
    pulled[..., :3] += spreads[:, None]
    most = find_critical(pulled, strain, smith_watson_topper).value
    return np.where(found.value > 0, 2 * half / body.young, most)


def write_histories(result: Result, histories: Sequence[EdgeHistory], folder: Path) -> Path:
    """Write the same as HDF5, a group for each edge and body, into a folder that exists.

    Raises:
        OutputError: if the file cannot be written.
    """
    path = folder / f"{FILE}.h5"
    schema = {"name": "fretfe-edge-histories", "version": 1}
    with writing(folder, "the histories"), replacing(path) as new, new_hdf5(new, schema) as file:
        file.attrs.update({
            "length": result.case.units.length,
            "stress": result.case.units.stress,
            "components": list(TENSOR_NAMES),
        })  # fmt: skip
        for number, each in enumerate(histories):
            group = file.create_group(f"edge_{number}")
            for name in ("contact", "edge", "body", "reason"):
                group.attrs[name] = getattr(each, name)
            for name in ("angles", "starts", "distances", "states", "times", "stress"):
                store(group, name, getattr(each, name))
    return path
