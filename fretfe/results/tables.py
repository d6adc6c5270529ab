# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts, stations and counted cycles as records and files, and as an xarray dataset."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import DependencyError
from fretfe.evaluate.contacts import Contact, Station, StationHistory, histories
from fretfe.files import replacing
from fretfe.history.solution import ContactHistory, Solution
from fretfe.libraries import started
from fretfe.loads import History
from fretfe.results.quantities import AXES, CYCLES, EDGES, SOLIDS, STATION, STATIONS, Column

if TYPE_CHECKING:
    import xarray as xr

CYCLES_FILE = "cycles.csv"
STATIONS_FILE = "stations.csv"
# Fields along a contact, with what they have besides times and nodes.
NODAL = {
    "traction": "component",
    "mean_traction": "component",
    "slip": "tangent",
    "gap": "",
    "status": "",
    "dissipation": "",
}


def _records(rows: Iterable[tuple[Any, Any]], columns: Sequence[Column]) -> list[dict[str, Any]]:
    """A row of each pair by the names of the columns; numbers that do not exist are NaN."""
    return [{each.name: each.value(*row) for each in columns if each.value} for row in rows]


def _stations(contacts: Sequence[Contact]) -> list[tuple[Contact, Station]]:
    return [(contact, station) for contact in contacts for station in contact.stations]


def edge_records(contacts: Sequence[Contact]) -> list[dict[str, Any]]:
    """Texts, numbers and truth values of every edge, by name; numbers that do not exist are NaN.

    ``slip_1`` and ``slip_2`` are the lengths of the slip zones of the last two half cycles, in the
    order of time, ``slip_1_spread`` and ``slip_2_spread`` their error bars, ``slip_1_from``
    and ``slip_2_from`` the positions of the edge from which they count, ``predicted_1`` and
    ``predicted_2`` what the edge factors predict for them. With one half cycle only it is the
    second. All spreads are half the width of an interval meant to hold the truth with 95 %; where
    that is more than half of the number, or unknown, there is none.
    """
    return _records(_stations(contacts), EDGES)


def station_records(contacts: Sequence[Contact]) -> list[dict[str, Any]]:
    """Texts and numbers of every station, by name; numbers that do not exist are NaN.

    Ranges are those over the evaluated cycle, factors those at its end, or that of the history, the
    slip zone the longer of those of the last two half cycles.
    """
    return _records(_stations(contacts), STATIONS)


def solid_records(contacts: Sequence[Contact]) -> list[dict[str, Any]]:
    """Texts, numbers and truth values of every contact of solids in its last state, by name."""
    return _records(((contact, None) for contact in contacts), SOLIDS)


def cycle_records(contacts: Sequence[Contact], times: Array) -> Iterator[dict[str, Any]]:
    """Texts and numbers of every counted cycle, by name; numbers that do not exist are NaN."""
    for contact, station in _stations(contacts):
        key = _records([(contact, station)], STATION)[0]
        counted = _records([(times, station)], CYCLES)[0] if len(station.cycles.count) else {}
        for row in zip(*(each.tolist() for each in counted.values()), strict=True):
            yield key | dict(zip(counted, row, strict=True))


def write_stations(path: Path, contacts: Sequence[Contact]) -> None:
    """Write the stations; without any there is no file."""
    _write(path, station_records(contacts))


def write_cycles(path: Path, contacts: Sequence[Contact], times: Array) -> None:
    """Write the cycles; if the loads are regular there is no file."""
    stations = (station for contact in contacts for station in contact.stations)
    irregular = any(station.cycles.irregular for station in stations)
    _write(path, cycle_records(contacts, times) if irregular else ())


def _write(path: Path, records: Iterable[dict[str, Any]]) -> None:
    """A row for each record; without any there is no file."""
    rows = iter(records)
    first = next(rows, None)
    if first is None:
        path.unlink(missing_ok=True)
        return
    with replacing(path) as new, new.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(first))
        writer.writeheader()
        for row in chain([first], rows):
            writer.writerow({name: _plain(value) for name, value in row.items()})


def _plain(value: Any) -> Any:
    return "" if isinstance(value, float) and not np.isfinite(value) else value


def require(package: str) -> Any:
    """Import an optional package.

    Raises:
        DependencyError: if it is not installed.
    """
    try:
        return started(package)
    except ModuleNotFoundError as error:
        if error.name != package:
            raise
        raise DependencyError(
            f"the Python package {package} is not installed. Install it with "
            f"`pip install {package}` or from your distribution (Debian: python3-{package})"
        ) from None


def make_dataset(
    loads: History, contacts: Sequence[Contact], solution: Solution | None
) -> xr.Dataset:
    """Make a dataset with the dimensions time, load, contact and axis, and nodes by contact.

    Stations of plane contacts have the dimensions contact and edge, those of solids station.
    Ranks other than 0 have no solution.

    Raises:
        DependencyError: if xarray is not installed.
    """
    solid = any(contact.solid for contact in contacts)
    stations, places = _solid_stations(contacts) if solid else _plane_stations(contacts)
    variables = {"loads": (("time", "load"), loads.values), **_histories(contacts), **stations}
    contact_arrays = solution.contacts if solution is not None else ()
    kept = solution.kept if solution is not None else None
    for history in contact_arrays:
        variables |= _contact_fields(history, kept)
    coordinates: dict[str, Any] = {
        "time": loads.times,
        "load": list(loads.channels),
        "contact": [each.name for each in contacts],
        **places,
    }
    if any("axis" in dimensions for dimensions, _ in variables.values()):
        sizes = {len(values[0, 0]) for names, values in variables.values() if names[-1] == "axis"}
        coordinates["axis"] = list(AXES[: max(sizes)])
    if kept is not None:
        coordinates["kept"] = kept
    dataset: xr.Dataset = require("xarray").Dataset(variables, coordinates)
    return dataset


def _histories(contacts: Sequence[Contact]) -> dict[str, Any]:
    """Histories of the contacts, those that they have."""
    variables: dict[str, Any] = {}
    for name in histories(Contact):
        values = np.array([getattr(contact, name) for contact in contacts])
        if values.size:
            variables[name] = (("contact", "time", "axis")[: values.ndim], values)
    return variables


def _plane_stations(contacts: Sequence[Contact]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Histories of the edges of plane contacts, and the coordinate edge."""
    variables: dict[str, Any] = {}
    for name in histories(StationHistory):
        values = [[getattr(edge, name) for edge in contact.stations] for contact in contacts]
        variables[name] = (("contact", "edge", "time"), np.array(values))
    return variables, {"edge": [edge.front for edge in contacts[0].stations] if contacts else []}


def _solid_stations(contacts: Sequence[Contact]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Histories of the stations of solids, and where these are."""
    stations = [(contact.name, each) for contact in contacts for each in contact.stations]
    if not stations:
        return {}, {}
    variables = {
        name: (("station", "time"), np.array([getattr(each, name) for _, each in stations]))
        for name in histories(StationHistory)
    }
    points = np.array([each.point for _, each in stations])
    return variables, {
        "station_contact": ("station", [name for name, _ in stations]),
        "front": ("station", [each.front for _, each in stations]),
        "number": ("station", [each.number for _, each in stations]),
        "arc": ("station", [each.arc for _, each in stations]),
        **{f"station_{axis}": ("station", x) for axis, x in zip(AXES, points.T, strict=True)},
    }


def _contact_fields(contact: ContactHistory, kept: Indices | None) -> dict[str, Any]:
    """Fields along a contact, of the states that are kept; components: normal, then tangents."""
    node = f"{contact.name}.node"
    arrays: dict[str, Any] = {}
    if contact.surface.facets is None:
        arrays[f"{contact.name}.arc"] = (node, contact.surface.arc)
    else:
        for axis, values in zip(AXES, contact.surface.points.T, strict=True):
            arrays[f"{contact.name}.{axis}"] = (node, values)
        arrays[f"{contact.name}.weights"] = (node, contact.surface.weights)
    for name, last in NODAL.items():
        states = "time" if kept is None else "kept"
        dimensions = (states, node, last) if last else (states, node)
        values = getattr(contact, name)[slice(None) if kept is None else kept]
        arrays[f"{contact.name}.{name}"] = (dimensions, values)
    return arrays
