# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results as tables of numbers and texts, in CSV files that any program reads."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.case import Crystal, Units
from fretfe.errors import CaseError
from fretfe.evaluate.contacts import AreaPatch, Contact
from fretfe.evaluate.stress import StressParameters
from fretfe.files import replacing, writing
from fretfe.history.solution import ContactHistory
from fretfe.results import quantities
from fretfe.results.field_files import in_space
from fretfe.results.model import Result
from fretfe.results.quantities import CONTACT, EDGE, Column, unit
from fretfe.results.tables import cycle_records, station_records
from fretfe.results.writer import prepare_other

Row = Sequence[Any]
# Lists all columns of the other files, with these of its own.
COLUMNS = "columns.csv"
LISTED = ("file", "header", "column", "unit", "meaning")
TABLE_NAME = re.compile(r"[a-z_]+\.csv")
STATE = (
    Column("state", "", "number of the state; 0 is the unloaded one"),
    Column("time", "time", "the clock"),
)
NODE = (
    Column("gap", "length", "mean gap around the node"),
    Column("status", "", "0 open, 1 stuck, 2 slipping in the step to the state"),
    Column("dissipation", "density", "friction work in that step per area"),
)
PLANE_TRACTIONS = (
    CONTACT,
    *STATE,
    Column("x", "length", "place along the contact"),
    Column("p", "stress", "pressure, mean around the node"),
    Column("q", "stress", "shear on body 2, mean around the node"),
    Column("slip", "length", "of body 1 relative to body 2 since state 0"),
    *NODE,
)
# Where plane bodies move along z, too.
TRACTIONS_WITH_Z = (
    *PLANE_TRACTIONS[:6],
    Column("q_z", "stress", "that along z"),
    PLANE_TRACTIONS[6],
    Column("slip_z", "length", "that along z"),
    *NODE,
)
SOLID_TRACTIONS = (
    CONTACT,
    *STATE,
    *(Column(axis, "length", "place of the node before deformation") for axis in "xyz"),
    *(Column(f"normal_{axis}", "", "outward normal of body 2") for axis in "xyz"),
    Column("p", "stress", "pressure, mean around the node"),
    *(Column(f"q_{axis}", "stress", "shear on body 2, mean around the node") for axis in "xyz"),
    *(
        Column(f"slip_{axis}", "length", "of body 1 relative to body 2 since state 0")
        for axis in "xyz"
    ),
    *NODE,
)
PLANE_LOCAL = (
    CONTACT,
    Column("x", "length", "place along the contact"),
    Column("slip_range", "length", "range of the slip in the evaluated cycle"),
    Column("path", "length", "way that slips in it"),
    Column("work", "density", "friction work per area in it"),
    Column("pressed_path", "density", "integral of p |ds| in it: wear after Archard"),
    Column("ruiz", "density", "largest |q| times slip_range"),
)
STRESS = (
    CONTACT,
    Column("body", "", "name of the body"),
    Column("depth", "length", "below the surface of the body; 0 is the surface"),
    Column("x", "length", "place along the contact"),
    Column("largest_tension", "stress", "largest stress along the surface in the cycle"),
    Column("ruiz2", "stress slip", "that, if it is tension, times ruiz of local.csv; surface only"),
    Column("swt", "stress", "Smith-Watson-Topper parameter of the plane where it is largest"),
    Column("shear_strain", "", "largest amplitude of the shear strain on any plane"),
)
SLIP_SYSTEMS = (
    Column("octahedral_shear", "stress", "largest range of the shear stress on {111}<110>"),
    Column("cube_shear", "stress", "largest range of the shear stress on {001}<110>"),
)
FATEMI_SOCIE = Column("fatemi_socie", "", "Fatemi-Socie parameter of the plane where it is largest")
EDGE_STRESS = (
    CONTACT,
    EDGE,
    Column("body", "", "name of the body"),
    Column(
        "largest_tension", "stress", "largest stress along the surface at the edge in the cycle"
    ),
    Column("largest_tension_spread", "stress", "its error bar"),
    Column("reason", "", "why it is not known"),
)
SOLID_LOCAL = (
    CONTACT,
    *(Column(axis, "length", "place of the node before deformation") for axis in "xyz"),
    *PLANE_LOCAL[2:],
)


@dataclass(frozen=True)
class Heading:
    """A column with its unit."""

    name: str
    unit: str
    meaning: str

    @property
    def text(self) -> str:
        """As it stands in the header of a file."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True)
class ExportTable:
    """A table: its file, its columns, its rows in their order."""

    file: str
    headings: Sequence[Heading]
    rows: Iterator[Row]


def export_tables(
    result: Result, fatemi_socie: tuple[float, float] | None = None
) -> Iterator[ExportTable]:
    """All tables of a result that have rows; arguments as for `export_result`."""
    yield _loads(result)
    yield _contacts(result)
    stations = [station for contact in result.contacts for station in contact.stations]
    if stations:
        yield _factors(result)
    if edges := result.edges():
        yield _of_records(result, "edges.csv", quantities.EDGES, edges)
    if points := station_records(result.contacts):
        yield _of_records(result, "stations.csv", quantities.STATIONS, points)
    # Regular loads have one cycle, which edges and stations tell.
    if any(station.cycles.irregular for station in stations):
        yield _of_records(
            result,
            "cycles.csv",
            (*quantities.STATION, *quantities.CYCLES),
            cycle_records(result.contacts, result.loads.times),
        )
    yield _tractions(result)
    if result.solution.keeps(*result.loads.evaluated):
        yield _local(result)
    if result.has_stress or fatemi_socie:
        yield _stress(result, fatemi_socie)
        yield _edge_stress(result)


def _headings(result: Result, names: Sequence[Column]) -> list[Heading]:
    return headings(names, result.case.units, solid=result.solid)


def headings(columns: Iterable[Column], units: Units, *, solid: bool) -> list[Heading]:
    """Give columns the units of a case."""
    return [
        Heading(each.name, unit(each.kind, units, solid=solid, ascii_only=True), each.meaning)
        for each in columns
    ]


def _loads(result: Result) -> ExportTable:
    loads = result.loads
    known, labels = result.case.loads, result.case.units
    units = [known[name].unit(labels).replace("·", "*") for name in loads.channels]
    named = [
        Heading(name, unit, "value of the load of this name")
        for name, unit in zip(loads.channels, units, strict=True)
    ]
    rows = (
        (state, time, *values)
        for state, (time, values) in enumerate(zip(loads.times, loads.values, strict=True))
    )
    return ExportTable("loads.csv", [*_headings(result, STATE), *named], rows)


def _of_records(
    result: Result,
    file: str,
    named: Sequence[Column],
    records: Sequence[Mapping[str, Any]] | Iterator[Mapping[str, Any]],
) -> ExportTable:
    rows = ([record[each.name] for each in named] for record in records)
    return ExportTable(file, _headings(result, named), rows)


def _carriers(contact: Contact) -> Iterator[Contact | AreaPatch]:
    """A contact and the patches of its area."""
    yield contact
    yield from contact.patches


def _contacts(result: Result) -> ExportTable:
    """Histories of contacts and patches of solids, those that they have; vectors by component."""
    named = [each for each in quantities.CONTACTS if getattr(result.contacts[0], each.name).size]
    rows = (
        (each.name, *state)
        for contact in result.contacts
        for each in _carriers(contact)
        for state in _states(
            result,
            # Of a patch not all is known.
            [getattr(each, one.name, np.nan * getattr(contact, one.name)) for one in named],
        )
    )
    axes = "xyz"[: result.contacts[0].force.shape[-1]]
    components = [
        part
        for each in named
        for part in (
            each.components(axes) if getattr(result.contacts[0], each.name).ndim == 2 else (each,)
        )
    ]
    headings = _headings(result, (CONTACT, *STATE, *components))
    return ExportTable("contacts.csv", headings, rows)


def _factors(result: Result) -> ExportTable:
    names = [each.name for each in quantities.FACTORS]
    rows = (
        (contact.name, station.front, station.number, *state)
        for contact in result.contacts
        for station in contact.stations
        for state in _states(result, [getattr(station, name) for name in names])
    )
    return ExportTable(
        "factors.csv", _headings(result, (*quantities.STATION, *STATE, *quantities.FACTORS)), rows
    )


def _states(result: Result, histories: Sequence[Array]) -> Iterator[Row]:
    """Number, time and values of every state; histories (T,) or (T, d)."""
    values = np.column_stack(histories)
    for state, (time, row) in enumerate(zip(result.loads.times, values, strict=True)):
        yield (state, time, *row)


def _tractions(result: Result) -> ExportTable:
    solution = result.solution
    kept = np.arange(len(solution.times)) if solution.kept is None else solution.kept
    solid = result.solid
    plane = PLANE_TRACTIONS if solution.contacts[0].slip.shape[2] == 1 else TRACTIONS_WITH_Z
    named = SOLID_TRACTIONS if solid else plane
    rows = (
        (contact.name, int(state), solution.times[state], *row[:-2], int(row[-2]), row[-1])
        for contact in solution.contacts
        for state in kept
        for row in (_solid_nodes if solid else _plane_nodes)(contact, int(state))
    )
    return ExportTable("tractions.csv", _headings(result, named), rows)


def _local(result: Result) -> ExportTable:
    named = SOLID_LOCAL if result.solid else PLANE_LOCAL
    own = [each.name for each in PLANE_LOCAL[2:]]
    rows = (
        (contact.name, *row)
        for contact in result.solution.contacts
        for found in [result.local_parameters(contact.name)]
        for row in np.column_stack(
            [
                contact.surface.points if result.solid else contact.surface.arc,
                *(getattr(found, name) for name in own),
            ]
        )
    )
    return ExportTable("local.csv", _headings(result, named), rows)


def _stress(result: Result, fatemi_socie: tuple[float, float] | None) -> ExportTable:
    cubic = any(
        isinstance(each, Crystal) and each.elastic.cubic for each in result.case.bodies.values()
    )
    named = [*STRESS, *(SLIP_SYSTEMS if cubic else ()), *([FATEMI_SOCIE] if fatemi_socie else [])]
    # All is computed before the file is made: what is wrong with the numbers is told first.
    found = {
        name: (result.stress_history(name).arc, result.stress_parameters(name, fatemi_socie))
        for name in result.case.contacts
    }
    rows = (
        (contact, body.body, depth, *row)
        for contact, (arc, bodies) in found.items()
        for body in bodies
        for number, depth in enumerate(body.depths)
        for row in _parameters(arc, body, number, cubic)
    )
    return ExportTable("stress.csv", _headings(result, named), rows)


def _parameters(arc: Array, body: StressParameters, number: int, cubic: bool) -> Array:
    """(N, 5 to 8) place and parameters at one of the depths."""
    at_surface = body.depths[number] == 0
    ruiz2 = body.ruiz2 if at_surface else np.full_like(body.ruiz2, np.nan)
    values = [arc, body.largest_tension[number], ruiz2, body.swt[number], body.shear_strain[number]]
    if cubic:
        values += [body.octahedral_shear[number], body.cube_shear[number]]
    if body.fatemi_socie is not None:
        values.append(body.fatemi_socie[number])
    return np.column_stack(values)


def _edge_stress(result: Result) -> ExportTable:
    rows = (
        (each.contact, each.edge, each.body, found.value, found.spread, found.reason)
        for name in result.case.contacts
        for each in result.stress_history(name).edges
        for found in [each.largest]
    )
    return ExportTable("edge_stress.csv", _headings(result, EDGE_STRESS), rows)


def _plane_nodes(contact: ContactHistory, state: int) -> Array:
    """(N, 7 or 9) values of a state, as of `PLANE_TRACTIONS` or `TRACTIONS_WITH_Z`."""
    x = contact.surface.arc
    return np.column_stack(
        [x, contact.mean_traction[state], contact.slip[state], *_scalars(contact, state)]
    )


def _solid_nodes(contact: ContactHistory, state: int) -> Array:
    """(N, 16) values of a state, as of `SOLID_TRACTIONS`."""
    traction, surface = contact.mean_traction[state], contact.surface
    points, normals = surface.points, surface.frames[:, 0]
    shear, slip = (in_space(contact, each) for each in (traction[:, 1:], contact.slip[state]))
    return np.column_stack(
        [points, normals, traction[:, 0], shear, slip, *_scalars(contact, state)]
    )


def _scalars(contact: ContactHistory, state: int) -> tuple[Array, Array, Array]:
    """Gap, status and density of the friction work at the nodes."""
    work, weights = contact.dissipation[state], contact.surface.weights
    density = np.divide(work, weights, out=np.zeros_like(work), where=weights > 0)
    return contact.gap[state], contact.status[state], density


@dataclass(frozen=True)
class Exported:
    """A file that was written, and its number of rows below the header."""

    path: Path
    rows: int


def export_result(
    result: Result,
    folder: Path,
    fatemi_socie: tuple[float, float] | None = None,
    more: Iterable[ExportTable] = (),
) -> tuple[Exported, ...]:
    """Write histories, factors, edges, cycles or stations, and tractions as CSV files.

    Args:
        result: of plane bodies or of solids, complete or not.
        folder: for the files; made if missing. Tables of an earlier export in it are replaced.
        fatemi_socie: k and yield stress of that parameter; None leaves it out.
        more: tables beside these.

    Returns:
        The files; the last one lists their columns.

    Raises:
        CaseError: if the folder holds results of a run, or files of others that would be replaced,
            k is negative or the yield stress not positive.
        OutputError: if a file cannot be written, or there is no stress for that parameter.
    """
    prepare_other(folder)
    exported = [*export_tables(result, fatemi_socie), *more]
    with writing(folder, "the tables"):
        _remove_earlier(folder, [each.file for each in exported])
        named = ((t.file, h.text, h.name, h.unit, h.meaning) for t in exported for h in t.headings)
        # First: what was cut off can be exported again.
        listing = Exported(folder / COLUMNS, _write(folder / COLUMNS, LISTED, named))
        files = [
            Exported(path, _write(path, [heading.text for heading in each.headings], each.rows))
            for each in exported
            for path in [folder / each.file]
        ]
    return (*files, listing)


def _remove_earlier(folder: Path, files: Iterable[str]) -> None:
    """Remove the tables that an earlier export lists: the next one may have others.

    Raises:
        CaseError: if one of the files is of somebody else.
    """
    listed = _listed(folder / COLUMNS)
    for name in files:
        if name not in listed and (folder / name).exists():
            raise CaseError(
                f"{folder / name}: expected a folder in which no export would replace files of "
                f"others, found one that no {COLUMNS} lists"
            )
    for name in listed:
        (folder / name).unlink(missing_ok=True)


def _listed(listing: Path) -> set[str]:
    """The tables that an earlier export lists.

    Raises:
        CaseError: if no export wrote the list.
    """
    if not listing.is_file():
        return set()
    try:
        with listing.open(encoding="utf-8", newline="") as file:
            header, *rows = csv.reader(file)
    except (ValueError, csv.Error):
        header, rows = [], []
    if tuple(header) != LISTED:
        raise CaseError(
            f"{listing}: expected the list of the tables of an earlier export, found something else"
        )
    # Names only: a listing that somebody has changed must not lead elsewhere.
    return {row[0] for row in rows if row and TABLE_NAME.fullmatch(row[0])}


def _write(path: Path, header: Sequence[str], rows: Iterable[Row]) -> int:
    """Write a file, whole or not at all; return the number of rows."""
    count = 0
    with replacing(path) as new, new.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for row in rows:
            writer.writerow(map(_plain, row))
            count += 1
    return count


def _plain(value: Any) -> Any:
    """A cell; empty for numbers that do not exist, 0 or 1 for truth values."""
    if isinstance(value, bool):
        return int(value)
    return "" if isinstance(value, float) and not math.isfinite(value) else value
