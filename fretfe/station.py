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
from fretfe.evaluate.edge_tractions import HalfCycleEnd, half_cycle_ends
from fretfe.files import json_value, replace_text
from fretfe.report.figures.edges import draw_half_cycle
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
class StationModel:
    """A station of solids and its plane problem.

    Attributes:
        name: of the station, CONTACT.FRONT.STATION.
        size: of an element across the front.
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
        ends: tractions at the ends of the last half cycle; none where that has no plane problem.
    """

    name: str
    size: float
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
    ends: tuple[HalfCycleEnd, ...]


def run_station(result: Result, name: str, output: Path | None) -> StationModel:
    """Take the plane problem of a station out of the results of solids.

    Args:
        result: of solids, with all of its steps.
        name: CONTACT.FRONT.STATION, as for `Result.find`.
        output: folder for `station.json` and `station.png`; None writes nothing.

    Raises:
        CaseError: if there is no such station, or the folder has results of a run.
        OutputError: if the results are not complete, or files cannot be written.
        ModelError: if there is no plane problem for the station.
    """
    if not result.solid:
        where = result.directory or result.case.source
        raise CaseError(f"{where}: expected results of solids, found those of plane bodies")
    contact, front, station = result.find(name)
    if station.local.reason:
        raise ModelError(
            f"station {contact.name_of(station)}: expected its plane problem, found none: "
            f"{station.local.reason}"
        )
    model = _model(result, contact, front, station)
    if output is not None:
        prepare_other(output)
        _write(output, result.case.units, model)
    return model


def _model(result: Result, contact: Contact, front: Front, station: Station) -> StationModel:
    local, times = station.local, result.loads.times
    history = result.contact_history(contact.name)
    return StationModel(
        name=contact.name_of(station),
        size=station.size,
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
        zones=tuple(_pair(zone, times) for zone in station.slip_zones if math.isfinite(zone.local)),
        slip=local.slip,
        work=local.work,
        change=local.change,
        ends=half_cycle_ends(history, front, station, times),
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


@mpl.rc_context(STYLE)
def draw_station(units: Units, model: StationModel, path: Path) -> None:
    """Draw tractions next to the edge, histories of K, and slip zones, side by side."""
    figure = Figure(figsize=SIZE, dpi=PICTURE_DPI, layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=(1.5, 1, 1))
    histories, zones = (figure.add_subplot(grid[:, column]) for column in (1, 2))
    figure.suptitle(f"Station {model.name}")
    if model.ends:
        pressure = figure.add_subplot(grid[0, 0])
        shear = figure.add_subplot(grid[1, 0], sharex=pressure)
        draw_half_cycle(pressure, shear, model.ends, model.size, units)
        pressure.tick_params(labelbottom=False)
    for values, name, colour in zip(
        (*model.k.T, model.k_i), ("K_T", "K_S", "K_I"), (BLUE, VERMILLION, GREEN), strict=True
    ):
        histories.plot(model.times, values, "-", color=colour, label=name)
    histories.set_xlabel(f"time [{units.time}]")
    histories.set_ylabel(f"factors [{units.stress}·√{units.length}]")
    _zones(zones, model)
    zones.set_xlabel(f"end of the half cycle [{units.time}]")
    zones.set_ylabel(f"slip zone [{units.length}]")
    for axes in (histories, zones):
        axes.legend()
    save_png(figure, path)


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
        replace_text(folder / NUMBERS, text + "\n")
        draw_station(units, model, folder / PICTURE)
    except OSError as error:
        raise OutputError(f"{folder}: cannot write the station: {error}") from error
