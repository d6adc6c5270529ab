# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts, stations and counted cycles as tables, with units and rows, and as an xarray dataset.

Units and meanings are those of the fields of `Contact` and `Station`; a column that is something
else than a field has its own. A new number of a station is a field there, and nothing here.
"""

from __future__ import annotations

import csv
import importlib
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Units
from fretfe.errors import DependencyError
from fretfe.evaluate.contacts import (
    Contact,
    LocalProblem,
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


def axis_label(name: str, units: Units, *, solid: bool) -> str:
    """Symbol and unit of a number of a station or a contact: ``K_N [MPa/√mm]``."""
    declared = {**quantities(Contact), **NUMBERS}[name]
    return f"{declared.symbol} [{unit(declared.kind, units, solid=solid)}]"


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        name: without its unit.
        kind: of quantity, a key of `UNITS`.
        meaning: in words.
        value: in the row of a station, from its contact and it; of contacts, from the contact and
            None; of cycles of a station, from it and the times; None in tables of other things.
        field: of a station that it shows; empty if it is something else.
    """

    name: str
    kind: str
    meaning: str
    value: Callable[[Any, Any], Any] | None = None
    field: str = ""

    def components(self, axes: str) -> list[Column]:
        """The columns of a vector along axes."""
        return [self._component(place, axis) for place, axis in enumerate(axes)]

    def _component(self, place: int, axis: str) -> Column:
        meaning, value = f"component {axis} of: {self.meaning}", self.value
        name = f"{self.name}_{axis}".removeprefix("_")
        if value is None:
            return Column(name, self.kind, meaning)
        return replace(
            self, name=name, meaning=meaning, value=lambda *row: float(value(*row)[place])
        )


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

    return Column(name, field.kind, meaning or field.meaning, value, attribute)


def _local(name: str) -> Column:
    """A number of the plane problem next to a station."""
    declared = quantities(LocalProblem)[name]
    return Column(
        f"local_{name}",
        declared.kind,
        declared.meaning,
        lambda _, station: getattr(station.local, name),
    )


def _last(name: str) -> Column:
    """A number of a contact, of a history in the last state."""

    def value(contact: Contact, _: None) -> Any:
        found = getattr(contact, name)
        found = found[-1] if isinstance(found, np.ndarray) else found
        return float(found) if np.ndim(found) == 0 and isinstance(found, np.floating) else found

    return replace(_fields(Contact, [name])[0], value=value)


@dataclass(frozen=True)
class ZoneLength:
    """A length of the slip zones of a station, with a column for each half cycle.

    Attributes:
        stem, end: of the name, with the number of the half cycle between them: slip_1_spread.
        meaning: in words, with places for "longest ", for the half cycle, and for the name before
            `end`.
        read: the length.
        by: the one by which the longest zone is found; None for itself.
    """

    stem: str
    end: str
    meaning: str
    read: Callable[[Station, SlipZone], float]
    by: ZoneLength | None = None

    def of_half_cycle(self, number: int) -> Column:
        """Of the first or second of the last two zones; NaN without it."""

        def value(_: Contact, station: Station) -> float:
            zones: list[SlipZone | None] = [None, None, *station.slip_zones]
            zone = zones[number - 3]
            return float(self.read(station, zone)) if zone else math.nan

        which = "last but one" if number == 1 else "last"
        return self._column(f"{self.stem}_{number}", "", f"of the {which} half cycle", value)

    def of_longest(self) -> Column:
        """Of the zone of the cycle of which the length is largest; NaN without any."""
        by = self.by or self

        def value(_: Contact, station: Station) -> float:
            zone = station.longest_by(partial(by.read, station))
            return float(self.read(station, zone)) if zone else math.nan

        return self._column(self.stem, "longest ", "of the cycle", value)

    def _column(self, stem: str, longest: str, of: str, value: Callable[..., float]) -> Column:
        return Column(stem + self.end, "length", self.meaning.format(longest, of, stem), value)


SLIP = ZoneLength("slip", "", "{}slip zone {}", lambda _, zone: zone.reported_length)
SLIP_SPREAD = ZoneLength("slip", "_spread", "error bar of {2}", lambda _, zone: zone.spread, SLIP)
SLIP_FROM = ZoneLength(
    "slip",
    "_from",
    "position of the edge from which {2} counts",
    lambda station, zone: station.position[zone.end],
    SLIP,
)
PREDICTED = ZoneLength(
    "predicted",
    "",
    "{}slip zone {} by the factors; empty without them or without a formula",
    Station.told_prediction,
)
LOCAL = ZoneLength(
    "local", "", "{}slip zone {} by the plane problem", lambda _, zone: zone.reported_local
)
LOCAL_SPREAD = ZoneLength(
    "local", "_spread", "error bar of {2}", lambda _, zone: zone.local_spread, LOCAL
)
CONTACT = Column(
    "contact", "", "name of the contact, or of one of its patches", lambda contact, _: contact.name
)
STEADY = Column("steady", "", "whether the cycle is steady", lambda c, _: bool(c.steady))
WARNINGS = Column(
    "warnings",
    "",
    "what a reader must know",
    lambda contact, _: "; ".join(each.sentence for each in contact.warnings),
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
    *map(_number, ("k_i_range", "reference_length")),
    *(
        each.of_half_cycle(number)
        for each in (SLIP, SLIP_SPREAD, SLIP_FROM, PREDICTED)
        for number in (1, 2)
    ),
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
    STEADY,
    WARNINGS,
)
STATION_LENGTHS = (SLIP, SLIP_SPREAD, PREDICTED, LOCAL, LOCAL_SPREAD)
CHOSEN = (
    *STATION,
    _number("arc"),
    *Column(
        "", "length", NUMBERS["point"].meaning, lambda _, station: station.point, "point"
    ).components(AXES),
    *Column(
        "inward", "", "direction into the contact", lambda _, station: station.frame.inward
    ).components(AXES),
    _number("position", "along the arc at the end; of solids from the point, inward"),
    *map(_number, ("position_spread", "curvature", "to_end", "end")),
    _number("element_size", read="size"),
    _number("k_n", "K_N in the last state"),
    *map(_number, ("k_n_spread", "k_n_moved", "k_n_moved_spread", "k_n_moved_reason")),
    *(_number(name, f"{NUMBERS[name].symbol} in the last state") for name in ("k_t", "k_s", "k_i")),
    *map(_number, ("k_t_range", "k_s_range", "k_i_range", "reference_length")),
    *map(_number, ("k_range", "k_range_spread", "k_angle", "turning")),
    *(each.of_longest() for each in STATION_LENGTHS),
    *(each.of_half_cycle(number) for number in (1, 2) for each in STATION_LENGTHS),
    _number("stick_border"),
    *map(_local, ("slip", "work", "change", "reason")),
    Column(
        "verdict", "", "comparison with what is predicted", lambda _, s: longest_verdict(s).verdict
    ),
    Column("reason", "", "why there is no verdict", lambda _, s: longest_verdict(s).reason),
    Column("withheld", "", "why a number is not told", lambda _, each: withheld(each)),
)
# All that a station has: a new number of it is a column without further ado.
STATIONS = (
    *CHOSEN,
    *map(_number, (name for name in NUMBERS if name not in {each.field for each in CHOSEN})),
)
SOLIDS = (
    CONTACT,
    _last("normal_force"),
    *_last("shear_force").components(AXES),
    *map(
        _last,
        (
            "contact_area",
            "stick_area",
            "largest_pressure",
            "dissipation",
            "local_dissipation",
            "local_share",
            "steady",
        ),
    ),
    WARNINGS,
)
CYCLES = (
    Column("start", "", "state of the first reversal", lambda s, _: s.cycles.start),
    Column("end", "", "state of the second reversal", lambda s, _: s.cycles.end),
    Column("start_time", "time", "its time", lambda s, times: times[s.cycles.start]),
    Column("end_time", "time", "its time", lambda s, times: times[s.cycles.end]),
    Column("count", "", "1, or 0.5 for a range that nothing closes", lambda s, _: s.cycles.count),
    Column(
        "k_t_start",
        "k_t",
        "K_T at the first reversal; with K_S along k_angle",
        lambda s, _: s.k_along[s.cycles.start],
    ),
    Column(
        "k_t_end",
        "k_t",
        "K_T at the second reversal; with K_S along k_angle",
        lambda s, _: s.k_along[s.cycles.end],
    ),
    Column("k_t_range", "k_t", "difference of the two, positive", lambda s, _: s.cycles.k_t_range),
    Column("k_t_mean", "k_t", "mean of the two", lambda s, _: s.cycles.k_t_mean),
    Column(
        "effective_range",
        "k_t",
        "the same with K_T - f K_I and K_T + f K_I: what is counted",
        lambda s, _: s.cycles.effective_range,
    ),
    Column("slip", "length", "slip length by that range", lambda s, _: s.cycles.slip),
    Column(
        "worst",
        "",
        "whether it is the worst cycle of its edge",
        lambda s, _: np.arange(len(s.cycles.count)) == s.cycles.worst,
    ),
)


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
        counted = _records([(station, times)], CYCLES)[0] if len(station.cycles.count) else {}
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
