# SPDX-License-Identifier: LGPL-3.0-or-later
"""The plane problem next to one station of solids, beside what the nodes around it do."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.case import Units
from fretfe.errors import CaseError, ModelError, OutputError
from fretfe.evaluate.contacts import Contact, Front, SlipZone, Station
from fretfe.evaluate.edge_tractions import edge_nodes
from fretfe.files import json_value
from fretfe.local.problem import Tractions
from fretfe.report.pictures.panels import save_png
from fretfe.report.theme import BLUE, GREEN, PICTURE_DPI, STYLE, VERMILLION
from fretfe.results.model import Result
from fretfe.results.writer import prepare_other

SIZE = (10.4, 3.6)
NUMBERS, PICTURE = "station.json", "station.png"


@dataclass(frozen=True)
class ZonePair:
    """A slip zone of a half cycle.

    Attributes:
        start, end: times.
        solid, solid_spread: length by the nodes of the solids, and error bar; NaN where not known.
        predicted: by the factors of the station.
        plane, plane_spread: length by the plane problem, and error bar, which holds those of the
            factors; NaN where there is none.
    """

    start: float
    end: float
    solid: float
    solid_spread: float
    predicted: float
    plane: float
    plane_spread: float


@dataclass(frozen=True)
class NodeTractions:
    """Tractions of the solids next to a station, (m,) each; none if they are not kept.

    Attributes:
        time: of the state.
        s: distances of the nodes from the front inward.
        pressure: means around the nodes.
        shear: likewise, along the direction of (K_T, K_S).
    """

    time: float
    s: Array
    pressure: Array
    shear: Array


@dataclass(frozen=True)
class StationModel:
    """A station of solids and its plane problem.

    Attributes:
        contact, front, station: which it is.
        half_width, power: of the plane contact in the last state, and of the gap of its bodies.
        k_angle: direction of (K_T, K_S), in degrees from `inward`.
        turning: range across it over that along it.
        k_n, k_n_spread: K_N in the last state, and error bar.
        k_range, k_range_spread: range of (K_T, K_S) over the cycle, and error bar; NaN without.
        times: (T,) of the states.
        k: (T, 2) K_T and K_S.
        k_i: (T,).
        zones: half cycles, in time order.
        slip: largest slip of the last half cycle by the plane problem.
        work: friction work in the cycle, per length of the front, by it.
        change: of the shear over the last cycle of it, over the swing of the force.
        plane_tractions: of the plane problem at the ends of the last half cycle.
        solid_tractions: of the nodes in the same states.
    """

    contact: str
    front: str
    station: int
    half_width: float
    power: float
    k_angle: float
    turning: float
    k_n: float
    k_n_spread: float
    k_range: float
    k_range_spread: float
    times: Array
    k: Array
    k_i: Array
    zones: tuple[ZonePair, ...]
    slip: float
    work: float
    change: float
    plane_tractions: tuple[Tractions, ...]
    solid_tractions: tuple[NodeTractions, ...]


def run_station(
    result: Result, contact: str, front: int, station: int, output: Path | None
) -> StationModel:
    """Take the plane problem of a station out of the results of solids.

    Args:
        result: of solids, with all of its steps.
        contact: name.
        front: number of the front, from 1.
        station: number of the station along it, from 0.
        output: folder for `station.json` and `station.png`; None writes nothing.

    Raises:
        CaseError: if there is no such contact, front or station, or the folder has results of a
            run.
        OutputError: if the results are not complete, or files cannot be written.
        ModelError: if there is no plane problem for the station.
    """
    chosen_front, chosen = _chosen(_contact(result, contact), front, station)
    if chosen.local.reason:
        raise ModelError(
            f"station {station} of {chosen_front.name}: expected its plane problem, found none: "
            f"{chosen.local.reason}"
        )
    model = _model(result, contact, chosen_front, chosen)
    if output is not None:
        prepare_other(output)
        _write(output, result.case.units, model)
    return model


def _contact(result: Result, name: str) -> Contact:
    where = result.directory or result.case.source
    if not result.solid:
        raise CaseError(f"{where}: expected results of solids, found those of plane bodies")
    if result.failure is not None:
        raise OutputError(f"{where}: expected complete results, found: {result.failure}")
    contacts = {contact.name: contact for contact in result.contacts}
    if name not in contacts:
        raise CaseError(
            f"{where}: expected one of the contacts {', '.join(contacts)}, found {name!r}"
        )
    return contacts[name]


def _chosen(contact: Contact, front: int, station: int) -> tuple[Front, Station]:
    fronts = contact.fronts
    if not fronts:
        raise ModelError(f"contact {contact.name}: expected contact fronts, found none")
    if not 1 <= front <= len(fronts):
        raise CaseError(
            f"contact {contact.name}: expected a front from 1 to {len(fronts)}, found {front}"
        )
    stations = fronts[front - 1].stations
    if not 0 <= station < len(stations):
        raise CaseError(
            f"contact {contact.name}, front {front}: expected a station from 0 to "
            f"{len(stations) - 1}, found {station}"
        )
    return fronts[front - 1], stations[station]


def _model(result: Result, contact: str, front: Front, station: Station) -> StationModel:
    local, times = station.local, result.loads.times
    followed = [zone for zone in station.slip_zones if math.isfinite(zone.local)]
    ends = (followed[-1].start, followed[-1].end)[-len(local.tractions) :] if followed else ()
    return StationModel(
        contact=contact,
        front=front.name,
        station=station.number,
        half_width=local.half_width,
        power=local.power,
        k_angle=station.k_angle,
        turning=station.turning,
        k_n=station.last_k_n[0],
        k_n_spread=station.last_k_n[1],
        k_range=station.k_range,
        k_range_spread=station.k_range_spread,
        times=times,
        k=np.column_stack([station.k_t, station.k_s]),
        k_i=station.k_i,
        zones=tuple(_pair(zone, times) for zone in followed),
        slip=local.slip,
        work=local.work,
        change=local.change,
        plane_tractions=local.tractions,
        solid_tractions=tuple(_nodes(result, contact, front, station, state) for state in ends),
    )


def _pair(zone: SlipZone, times: Array) -> ZonePair:
    return ZonePair(
        start=float(times[zone.start]),
        end=float(times[zone.end]),
        solid=zone.reported_length,
        solid_spread=zone.spread,
        predicted=zone.prediction,
        plane=zone.reported_local,
        plane_spread=zone.local_spread,
    )


def _nodes(
    result: Result, contact: str, front: Front, station: Station, state: int
) -> NodeTractions:
    reach = -station.size, station.local.half_width
    nodes = edge_nodes(result.contact_history(contact), front, station, state, reach)
    time = float(result.loads.times[state])
    try:
        return NodeTractions(time, nodes.s, *nodes.tractions(state))
    except OutputError:
        return NodeTractions(time, *np.empty((3, 0)))


@mpl.rc_context(STYLE)
def draw_station(units: Units, model: StationModel, path: Path) -> None:
    """Draw tractions next to the edge, histories of K, and slip zones, side by side."""
    figure = Figure(figsize=SIZE, dpi=PICTURE_DPI, layout="constrained")
    tractions, histories, zones = figure.subplots(1, 3, width_ratios=(1.5, 1, 1))
    figure.suptitle(f"Station {model.station} of {model.front}, contact {model.contact}")
    _tractions(tractions, model)
    tractions.set_xlabel(f"distance from the front [{units.length}]")
    tractions.set_ylabel(f"traction [{units.stress}]")
    for values, name, colour in zip(
        (*model.k.T, model.k_i), ("K_T", "K_S", "K_I"), (BLUE, VERMILLION, GREEN), strict=True
    ):
        histories.plot(model.times, values, "-", color=colour, label=name)
    histories.set_xlabel(f"time [{units.time}]")
    histories.set_ylabel(f"factors [{units.stress}·√{units.length}]")
    _zones(zones, model)
    zones.set_xlabel(f"end of the half cycle [{units.time}]")
    zones.set_ylabel(f"slip zone [{units.length}]")
    for axes in (tractions, histories, zones):
        axes.legend()
    save_png(figure, path)


def _tractions(axes: Axes, model: StationModel) -> None:
    """Pressure and shear at the end of the last half cycle, nodes as marks."""
    plane, angle = model.plane_tractions[-1], math.radians(model.k_angle)
    shear = plane.shear @ np.array([math.cos(angle), math.sin(angle)])
    axes.plot(plane.s, plane.pressure, "-", color=BLUE, label="p, plane")
    axes.plot(plane.s, shear, "-", color=VERMILLION, label="q, plane")
    if model.solid_tractions:
        solid = model.solid_tractions[-1]
        axes.plot(solid.s, solid.pressure, "o", ms=3, color=BLUE, label="p, solid")
        axes.plot(solid.s, solid.shear, "s", ms=3, color=VERMILLION, label="q, solid")
        axes.set_title(f"t = {solid.time:g}", loc="left")


def _zones(axes: Axes, model: StationModel) -> None:
    ends = [zone.end for zone in model.zones]
    for kind, mark, colour in (("solid", "o", BLUE), ("plane", "x", VERMILLION)):
        spread = np.array([getattr(zone, f"{kind}_spread") for zone in model.zones])
        axes.errorbar(
            ends, [getattr(zone, kind) for zone in model.zones],
            np.where(np.isfinite(spread), spread, 0.0),
            fmt=mark, ms=4, color=colour, label=kind, capsize=2, lw=1.0,
        )  # fmt: skip
    axes.plot(ends, [zone.predicted for zone in model.zones], "_", color=GREEN, label="predicted")
    axes.set_ylim(bottom=0.0)


def _write(folder: Path, units: Units, model: StationModel) -> None:
    """Write numbers and picture.

    Raises:
        OutputError: if that fails.
    """
    try:
        text = json.dumps(json_value(asdict(model)), indent=1, allow_nan=False)
        (folder / NUMBERS).write_text(text + "\n", encoding="utf-8")
        draw_station(units, model, folder / PICTURE)
    except OSError as error:
        raise OutputError(f"{folder}: cannot write the station: {error}") from error
