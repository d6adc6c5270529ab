# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run the plane problem of a station of solids, and write what the two differ by."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.case import parse_case
from fretfe.edges.area import AreaSummary
from fretfe.edges.solid_fronts import SolidFront, SolidStation
from fretfe.errors import CaseError, ModelError, OutputError
from fretfe.results.model import Result
from fretfe.runner import Runner
from fretfe.submodel.comparison import StationModel, compare
from fretfe.submodel.equivalent import equivalent

NUMBERS, PICTURE = "station.json", "station.png"


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
    chosen_front, chosen = _chosen(_area(result, contact), front, station)
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
    model = compare(result, chosen_front, chosen, given, plane, contact)
    if output is not None:
        _write(output, result, model)
    return model


def _area(result: Result, name: str) -> AreaSummary:
    where = result.directory or result.case.source
    if not result.areas:
        raise CaseError(f"{where}: expected results of solids, found those of plane bodies")
    if result.failure is not None:
        raise OutputError(f"{where}: expected complete results, found: {result.failure}")
    areas = {area.name: area for area in result.areas}
    if name not in areas:
        raise CaseError(f"{where}: expected one of the contacts {', '.join(areas)}, found {name!r}")
    return areas[name]


def _chosen(area: AreaSummary, front: int, station: int) -> tuple[SolidFront, SolidStation]:
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
    from fretfe.submodel.figure import draw_station

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
