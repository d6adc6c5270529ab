# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts, stations and counted cycles as tables, with units and rows, and as an xarray dataset.

Units and meanings are those of the fields of `Contact` and `Station`; a column that is something
else than a field has its own. A new number of a station is a field there and a line here.
"""

from __future__ import annotations

import csv
import importlib
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Units
from fretfe.errors import DependencyError
from fretfe.evaluate.contacts import (
    Contact,
    SlipZone,
    Station,
    StationHistory,
    histories,
    quantities,
)
from fretfe.evaluate.verdicts import longest_verdict, withheld
from fretfe.files import replacing
from fretfe.history.solution import ContactHistory, Solution
from fretfe.loads import History

if TYPE_CHECKING:
    import xarray as xr

CYCLES_FILE = "cycles.csv"
STATIONS_FILE = "stations.csv"
AXES = "xyz"
# Kinds of quantities and their units, plane bodies per unit thickness. Solids differ in some.
UNITS = {
    "": "",
    "length": "{length}",
    "time": "{time}",
    "stress": "{stress}",
    "force": "{force}/{length}",
    "moment": "{force}",
    "work": "{force}·{length}/{length}",
    "work per length": "{force}·{length}/{length}",
    "density": "{force}·{length}/{length}²",
    "stress slip": "{stress}²·{length}",
    "area": "{length}",
    "curvature": "1/{length}",
    "angle": "deg",
    "k_n": "{stress}/√{length}",
    "k_t": "{stress}·√{length}",
}
SOLID_UNITS = UNITS | {
    "force": "{force}",
    "moment": "{force}·{length}",
    "work": "{force}·{length}",
    "area": "{length}²",
}
# Fields along a contact, with what they have besides times and nodes.
NODAL = {
    "traction": "component",
    "mean_traction": "component",
    "slip": "tangent",
    "gap": "",
    "status": "",
    "dissipation": "",
}


def unit(kind: str, units: Units, *, solid: bool, ascii_only: bool = False) -> str:
    """Unit of a kind of quantity; in ASCII as in the header of a file: ``MPa/mm^0.5``."""
    template = (SOLID_UNITS if solid else UNITS)[kind]
    if ascii_only:
        root = template.replace("√{length}", "{length}^0.5")
        template = root.replace("·", "*").replace("²", "^2")
    return template.format(**units.model_dump())


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        name: without its unit.
        kind: of quantity, a key of `UNITS`.
        meaning: in words.
        value: in the row of a station, from its contact and it; None in tables of other things.
    """

    name: str
    kind: str
    meaning: str
    value: Callable[[Contact, Station], Any] | None = None

    def components(self, axes: str) -> list[Column]:
        """The columns of a vector along axes."""
        return [
            Column(f"{self.name}_{axis}", self.kind, f"component {axis} of: {self.meaning}")
            for axis in axes
        ]


def _fields(owner: type, names: Iterable[str]) -> list[Column]:
    """Fields of a contact or a station, with their units and meanings."""
    known = quantities(owner)
    return [Column(name, known[name].kind, known[name].meaning) for name in names]


CONTACTS = _fields(Contact, histories(Contact))
FACTORS = _fields(Station, histories(StationHistory))
HISTORIES = histories(StationHistory)
NUMBERS = quantities(Station)


def _number(name: str, meaning: str = "", read: str = "") -> Column:
    """A number of a station.

    Args:
        name: of the column.
        meaning: in words; empty for that of the field.
        read: attribute to read, of a history in the last state; empty for the field of this name.
    """
    attribute, field = read or name, NUMBERS[name if name in NUMBERS else read]

    def value(_: Contact, station: Station) -> Any:
        found = getattr(station, attribute)
        found = found[station.last] if attribute in HISTORIES else found
        return float(found) if isinstance(found, float) else found

    return Column(name, field.kind, meaning or field.meaning, value)


def _vector(prefix: str, kind: str, meaning: str, attribute: str) -> list[Column]:
    """A vector of a station, by component."""
    read = attrgetter(attribute)

    def component(number: int, axis: str) -> Column:
        return Column(prefix + axis, kind, meaning, lambda _, station: float(read(station)[number]))

    return [component(number, axis) for number, axis in enumerate(AXES)]


def _zone(name: str, meaning: str, attribute: str, place: int) -> Column:
    """A length of one of the last slip zones; NaN without it."""
    return _of_zone(name, meaning, place, lambda _, zone: float(getattr(zone, attribute)))


def _prediction(name: str, meaning: str, place: int) -> Column:
    """Length that the factors predict for one of the last zones; NaN where they are not told."""
    return _of_zone(name, meaning, place, Station.told_prediction)


def _of_zone(
    name: str, meaning: str, place: int, read: Callable[[Station, SlipZone], float]
) -> Column:
    def value(_: Contact, station: Station) -> float:
        zones = station.slip_zones
        return read(station, zones[place]) if len(zones) >= -place else math.nan

    return Column(name, "length", meaning, value)


def _of_longest(
    name: str,
    meaning: str,
    length: Callable[[Station, SlipZone], float],
    read: Callable[[Station, SlipZone], float],
) -> Column:
    """A number of the slip zone of the cycle of which a length is largest; NaN without any."""

    def value(_: Contact, station: Station) -> float:
        zone = station.longest_by(partial(length, station))
        return read(station, zone) if zone else math.nan

    return Column(name, "length", meaning, value)


def _longest(name: str, meaning: str, length: str, spread: str) -> list[Column]:
    """The largest of a length of the slip zones of the cycle, with its error bar."""

    def of(attribute: str) -> Callable[[Station, SlipZone], float]:
        return lambda _, zone: float(getattr(zone, attribute))

    return [
        _of_longest(name, meaning, of(length), of(length)),
        _of_longest(f"{name}_spread", "its error bar", of(length), of(spread)),
    ]


def _half_cycle(number: int, meaning: str) -> list[Column]:
    """Lengths of the first or second of the last two slip zones: found, predicted, local."""
    place = number - 3
    return [
        _zone(f"slip_{number}", meaning, "reported_length", place),
        _zone(f"slip_{number}_spread", "its error bar", "spread", place),
        _prediction(f"predicted_{number}", "what the factors predict for it", place),
        _zone(f"local_{number}", "the same by the plane problem", "reported_local", place),
        _zone(f"local_{number}_spread", "its error bar", "local_spread", place),
    ]


def _edge_of(name: str, place: int) -> Column:
    """Position of the edge from which one of the last slip zones counts; NaN without it."""

    def value(_: Contact, station: Station) -> float:
        zones = station.slip_zones
        return float(station.position[zones[place].end]) if len(zones) >= -place else math.nan

    meaning = f"position of the edge from which slip_{3 + place} counts"
    return Column(name, "length", meaning, value)


CONTACT = Column(
    "contact", "", "name of the contact, or of one of its patches", lambda contact, _: contact.name
)
EDGE = Column("edge", "", "left or right", lambda _, station: station.front)
STATION = (
    CONTACT,
    replace(EDGE, name="front", meaning="name of the front, in the plane left or right"),
    _number("station", "number of the station along the front, from 0; 0 in the plane", "number"),
)
EDGES = (
    CONTACT,
    EDGE,
    _number("position", "of the edge in the last state"),
    Column(
        "half_width",
        "length",
        "of the contact in the last state",
        lambda contact, station: float(contact.half_width[station.last]),
    ),
    _number(
        "k_n", "K_N in the last state; empty if its bar is more than half of it", "reported_k_n"
    ),
    _number("k_n_spread", "error bar of K_N"),
    _number(
        "k_t_range",
        "range of K_T, with displacements along z of (K_T, K_S), over the cycle; empty likewise",
        "reported_range",
    ),
    _number("k_t_range_spread", read="k_range_spread"),
    _number("k_i_range"),
    _number("reference_length"),
    _zone("slip_1", "slip zone of the last but one half cycle", "reported_length", -2),
    _zone("slip_2", "slip zone of the last half cycle", "reported_length", -1),
    _zone("slip_1_spread", "error bar of slip_1", "spread", -2),
    _zone("slip_2_spread", "error bar of slip_2", "spread", -1),
    _edge_of("slip_1_from", -2),
    _edge_of("slip_2_from", -1),
    _prediction("predicted_1", "what the edge factors predict for slip_1; empty without them", -2),
    _prediction("predicted_2", "what the edge factors predict for slip_2; empty without them", -1),
    Column(
        "gross",
        "",
        "whether the whole contact slipped in one of them",
        lambda _, s: any(z.gross for z in s.slip_zones[-2:]),
    ),
    Column(
        "resolved",
        "",
        "whether the mesh resolves both",
        lambda _, s: all(z.resolved for z in s.slip_zones[-2:]),
    ),
    _number("dissipation", read="reported_dissipation"),
    _number("dissipation_spread"),
    Column("steady", "", "whether the cycle is steady", lambda c, _: bool(c.steady)),
    Column("warnings", "", "what a reader must know", lambda c, _: _sentences(c)),
)
STATIONS = (
    *STATION,
    _number("arc"),
    *_vector("", "length", "point of the station before deformation", "point"),
    *_vector("inward_", "", "direction into the contact", "frame.inward"),
    _number("position", "along the arc at the end; of solids from the point, inward"),
    *map(_number, ("position_spread", "curvature", "to_end", "end")),
    _number("element_size", read="size"),
    _number("k_n", "K_N in the last state"),
    *map(_number, ("k_n_spread", "k_n_moved", "k_n_moved_spread", "k_n_moved_reason")),
    _number("k_t", "K_T in the last state"),
    _number("k_s", "K_S in the last state"),
    _number("k_i", "K_I in the last state"),
    *map(_number, ("k_t_range", "k_s_range", "k_i_range", "reference_length")),
    *map(_number, ("k_range", "k_range_spread", "k_angle", "turning")),
    *_longest("slip", "the longest slip zone of the cycle", "reported_length", "spread"),
    _of_longest(
        "predicted",
        "the longest that the factors predict in it; empty without them or without a formula",
        Station.told_prediction,
        Station.told_prediction,
    ),
    *_longest(
        "local",
        "the longest by the plane problem next to the station",
        "reported_local",
        "local_spread",
    ),
    *_half_cycle(1, "slip zone of the last but one half cycle"),
    *_half_cycle(2, "slip zone of the last half cycle"),
    Column(
        "stick_border",
        "length",
        "border of permanent stick by both, from the point, inward",
        lambda _, s: s.stick_border,
    ),
    Column(
        "local_slip",
        "length",
        "largest slip by it, in the last half cycle",
        lambda _, s: s.local.slip,
    ),
    Column("local_work", "work per length", "friction work by it", lambda _, s: s.local.work),
    Column("local_change", "", "its change over the last cycle", lambda _, s: s.local.change),
    Column("local_reason", "", "why it is not solved", lambda _, s: s.local.reason),
    Column(
        "verdict", "", "comparison with what is predicted", lambda _, s: longest_verdict(s).verdict
    ),
    Column("reason", "", "why there is no verdict", lambda _, s: longest_verdict(s).reason),
)
WITHHELD = Column("withheld", "", "why a number is not told", lambda _, each: withheld(each))
CYCLES = (
    *STATION,
    Column("start", "", "state of the first reversal"),
    Column("end", "", "state of the second reversal"),
    Column("start_time", "time", "its time"),
    Column("end_time", "time", "its time"),
    Column("count", "", "1, or 0.5 for a range that nothing closes"),
    Column("k_t_start", "k_t", "K_T at the first reversal; with K_S along k_angle"),
    Column("k_t_end", "k_t", "K_T at the second reversal"),
    Column("k_t_range", "k_t", "difference of the two, positive"),
    Column("k_t_mean", "k_t", "mean of the two"),
    Column("effective_range", "k_t", "the same with K_T - f K_I and K_T + f K_I: what is counted"),
    Column("slip", "length", "slip length by that range"),
    Column("worst", "", "whether it is the worst cycle of its edge"),
)


def _records(contacts: Sequence[Contact], columns: Sequence[Column]) -> list[dict[str, Any]]:
    """A row for each station, by the names of the columns; numbers that do not exist are NaN."""
    return [
        {each.name: each.value(contact, station) for each in columns if each.value is not None}
        for contact in contacts
        for station in contact.stations
    ]


def _sentences(contact: Contact) -> str:
    """All that a reader must know of a contact, in one text."""
    return "; ".join(each.sentence for each in contact.warnings)


def edge_records(contacts: Sequence[Contact]) -> list[dict[str, Any]]:
    """Texts, numbers and truth values of every edge, by name; numbers that do not exist are NaN.

    ``slip_1`` and ``slip_2`` are the lengths of the slip zones of the last two half cycles, in the
    order of time, ``slip_1_spread`` and ``slip_2_spread`` their error bars, ``slip_1_from``
    and ``slip_2_from`` the positions of the edge from which they count, ``predicted_1`` and
    ``predicted_2`` what the edge factors predict for them. With one half cycle only it is the
    second. All spreads are half the width of an interval meant to hold the truth with 95 %; where
    that is more than half of the number, or unknown, there is none.
    """
    return _records(contacts, EDGES)


def station_records(contacts: Sequence[Contact]) -> list[dict[str, Any]]:
    """Texts and numbers of every station, by name; numbers that do not exist are NaN.

    Ranges are those over the evaluated cycle, factors those at its end, or that of the history, the
    slip zone the longer of those of the last two half cycles.
    """
    return _records(contacts, (*STATIONS, WITHHELD))


def solid_records(contacts: Sequence[Contact]) -> list[dict[str, Any]]:
    """Texts, numbers and truth values of every contact of solids in its last state, by name."""
    return [
        {
            "contact": each.name,
            "normal_force": float(each.normal_force[-1]),
            **{
                f"shear_force_{axis}": float(q)
                for axis, q in zip(AXES, each.shear_force[-1], strict=True)
            },
            "contact_area": float(each.contact_area[-1]),
            "stick_area": float(each.stick_area[-1]),
            "largest_pressure": float(each.largest_pressure[-1]),
            "dissipation": each.dissipation,
            "local_dissipation": each.local_dissipation,
            "local_share": each.local_share,
            "steady": each.steady,
            "warnings": _sentences(each),
        }
        for each in contacts
    ]


def cycle_records(contacts: Sequence[Contact], times: Array) -> Iterator[dict[str, Any]]:
    """Texts and numbers of every counted cycle, by name; numbers that do not exist are NaN."""
    names = [each.name for each in CYCLES]
    for contact in contacts:
        for station in contact.stations:
            for row in _cycles(station, times):
                key = (contact.name, station.front, station.number)
                yield dict(zip(names, (*key, *row), strict=True))


def _cycles(station: Station, times: Array) -> Iterator[tuple[Any, ...]]:
    """Rows of the cycles of a station, in the order of `CYCLES`."""
    cycles, angle = station.cycles, math.radians(station.k_angle)
    along = station.k_t * math.cos(angle) + station.k_s * math.sin(angle)
    worst = cycles.worst if len(cycles.count) else None
    numbers = (cycles.k_t_range, cycles.k_t_mean, cycles.effective_range, cycles.slip)
    for number, (start, end) in enumerate(zip(cycles.start, cycles.end, strict=True)):
        yield (
            *(int(start), int(end)),
            *(float(times[start]), float(times[end])),
            float(cycles.count[number]),
            *(float(along[start]), float(along[end])),
            *(float(each[number]) for each in numbers),
            number == worst,
        )


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
        return importlib.import_module(package)
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
