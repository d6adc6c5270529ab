# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run the plane problem of a station of solids; write and draw what the two do."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe.case import Units, parse_case
from fretfe.errors import CaseError, ModelError, OutputError
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.report.pictures.panels import save_png
from fretfe.report.theme import BLUE, GREEN, PICTURE_DPI, STYLE, VERMILLION
from fretfe.results.model import Result
from fretfe.results.writer import write_results
from fretfe.runner import Runner
from fretfe.submodel.comparison import StationModel, compare
from fretfe.submodel.equivalent import equivalent, with_bars

SIZE = (10.4, 3.6)
NUMBERS, PICTURE = "station.json", "station.png"


@mpl.rc_context(STYLE)
def draw_station(units: Units, model: StationModel, path: Path) -> None:
    """Draw tractions next to the edge, histories of K, and slip zones, side by side."""
    figure = Figure(figsize=SIZE, dpi=PICTURE_DPI, layout="constrained")
    tractions, histories, zones = figure.subplots(1, 3, width_ratios=(1.5, 1, 1))
    figure.suptitle(f"Station {model.station} of {model.front}, contact {model.contact}")
    _tractions(tractions, model)
    tractions.set_xlabel(f"distance from the front [{units.length}]")
    tractions.set_ylabel(f"traction [{units.stress}]")
    histories.plot(model.times, model.k, "o", ms=3.5, color=BLUE, label="solid")
    histories.plot(model.times, model.plane_k, "-", color=VERMILLION, label="plane")
    histories.set_xlabel(f"time [{units.time}]")
    histories.set_ylabel(f"K − K at the end [{units.stress}·√{units.length}]")
    _zones(zones, model)
    zones.set_xlabel(f"end of the half cycle [{units.time}]")
    zones.set_ylabel(f"slip zone [{units.length}]")
    for axes in (tractions, histories, zones):
        axes.legend()
    save_png(figure, path)


def _tractions(axes: Axes, model: StationModel) -> None:
    solid, plane = model.solid_tractions, model.plane_tractions
    axes.plot(solid.s, solid.pressure, "o", ms=3, color=BLUE, label="p, solid")
    axes.plot(plane.s, plane.pressure, "-", color=BLUE, label="p, plane")
    axes.plot(solid.s, solid.shear, "s", ms=3, color=VERMILLION, label="q, solid")
    axes.plot(plane.s, plane.shear, "-", color=VERMILLION, label="q, plane")
    axes.set_title(f"t = {model.time:g}", loc="left")


def _zones(axes: Axes, model: StationModel) -> None:
    ends = np.array([zone.end for zone in model.zones])
    kinds = (("solid", "o", BLUE), ("plane", "x", VERMILLION), ("predicted", "_", GREEN))
    for kind, mark, colour in kinds:
        spread = np.array([getattr(zone, f"{kind}_spread") for zone in model.zones])
        axes.errorbar(
            ends, [getattr(zone, kind) for zone in model.zones],
            np.where(np.isfinite(spread), spread, 0.0),
            fmt=mark, ms=4, color=colour, label=kind, capsize=2, lw=1.0,
        )  # fmt: skip
    axes.set_ylim(bottom=0.0)


def run_station(
    result: Result, contact: str, front: int, station: int, output: Path | None
) -> StationModel:
    """Solve the plane problem of a station with the backend `halfplane`.

    Args:
        result: of solids, with all of its steps.
        contact: name.
        front: number of the front, from 1.
        station: number of the station along it, from 0.
        output: folder for the results of the plane problem, and `station.json` and `station.png`;
            None writes nothing.

    Raises:
        CaseError: if there is no such contact, front or station, or the folder is that of `result`.
        OutputError: if the results are not complete, or files cannot be written.
        ModelError: if there is no plane problem for the station.
    """
    if output is not None and result.directory and output.resolve() == result.directory.resolve():
        raise CaseError(f"{output}: expected another folder than that of the results of solids")
    chosen_front, chosen = _chosen(_contact(result, contact), front, station)
    history = result.contact_history(contact)
    given = equivalent(result, history, chosen)
    title = f"Plane problem of station {station} of {chosen_front.name}, contact {contact}"
    case = parse_case(given.case(result, history, title), source="the plane problem")
    try:
        plane = Runner.find("halfplane").run(case, output)
    except ModelError as error:
        raise ModelError(f"station {station} of {chosen_front.name}: {error}") from None
    if plane.failure is not None:
        raise plane.failure
    plane = with_bars(plane, given.bars)
    model = compare(result, chosen_front, chosen, given, plane, contact)
    if output is not None:
        # What reads the plane problem afterwards must not take its factors for exact ones.
        write_results(output, plane)
        _write(output, result, model)
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


def _chosen(area: Contact, front: int, station: int) -> tuple[Front, Station]:
    fronts = area.fronts
    if not fronts:
        raise ModelError(f"contact {area.name}: expected contact fronts, found none")
    if not 1 <= front <= len(fronts):
        raise CaseError(
            f"contact {area.name}: expected a front from 1 to {len(fronts)}, found {front}"
        )
    stations = fronts[front - 1].stations
    if not 0 <= station < len(stations):
        raise CaseError(
            f"contact {area.name}, front {front}: expected a station from 0 to "
            f"{len(stations) - 1}, found {station}"
        )
    return fronts[front - 1], stations[station]


def _write(folder: Path, result: Result, model: StationModel) -> None:
    """Write numbers and picture.

    Raises:
        OutputError: if that fails.
    """
    numbers = {name: getattr(model, name) for name in vars(model) if name != "plane"}
    for name in ("solid_tractions", "plane_tractions"):
        numbers[name] = asdict(numbers[name])
    numbers["zones"] = [asdict(zone) for zone in model.zones]
    try:
        text = json.dumps(_plain(numbers), indent=1, allow_nan=False)
        (folder / NUMBERS).write_text(text + "\n", encoding="utf-8")
        draw_station(result.case.units, model, folder / PICTURE)
    except OSError as error:
        raise OutputError(f"{folder}: cannot write the comparison: {error}") from error


def _plain(value: Any) -> Any:
    """Plain types of JSON; null for what does not exist."""
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, list | np.ndarray):
        return [_plain(each) for each in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value
