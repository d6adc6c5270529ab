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
from fretfe.errors import CaseError, OutputError
from fretfe.evaluate.stress import StressParameters
from fretfe.exchange import columns
from fretfe.exchange.columns import Column, Heading, headings
from fretfe.files import disk_reason, replacing
from fretfe.history.solution import ContactHistory
from fretfe.report.source import load_unit
from fretfe.results.csv_files import cycle_records, station_records
from fretfe.results.model import Result
from fretfe.results.writer import prepare_other

Row = Sequence[Any]
# Lists all columns of the other files, with these of its own.
COLUMNS = "columns.csv"
LISTED = ("file", "header", "column", "unit", "meaning")
TABLE_NAME = re.compile(r"[a-z_]+\.csv")


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
        yield _of_records(result, "edges.csv", columns.EDGES, edges)
    if points := station_records(result):
        yield _of_records(result, "stations.csv", columns.STATIONS, points)
    # Regular loads have one cycle, which edges and stations tell.
    if any(station.cycles.irregular for station in stations):
        yield _of_records(result, "cycles.csv", columns.CYCLES, cycle_records(result))
    if result.solution is not None:
        yield _tractions(result)
        if result.solution.keeps(*result.loads.evaluated):
            yield _local(result)
    if result.has_stress or fatemi_socie:
        yield _stress(result, fatemi_socie)
        yield _edge_stress(result)


def _headings(result: Result, names: Sequence[Column]) -> list[Heading]:
    return headings(names, result.case.units, solid=result.solid)


def _loads(result: Result) -> ExportTable:
    loads = result.loads
    units = [load_unit(result.case, name).replace("·", "*") for name in loads.channels]
    named = [
        Heading(name, unit, "value of the load of this name")
        for name, unit in zip(loads.channels, units, strict=True)
    ]
    rows = (
        (state, time, *values)
        for state, (time, values) in enumerate(zip(loads.times, loads.values, strict=True))
    )
    return ExportTable("loads.csv", [*_headings(result, columns.STATE), *named], rows)


def _of_records(
    result: Result,
    file: str,
    named: Sequence[Column],
    records: Sequence[Mapping[str, Any]] | Iterator[Mapping[str, Any]],
) -> ExportTable:
    rows = ([record[each.name] for each in named] for record in records)
    return ExportTable(file, _headings(result, named), rows)


def _contacts(result: Result) -> ExportTable:
    """Histories of the contacts, those that they have; vectors by component."""
    named = [each for each in columns.CONTACTS if getattr(result.contacts[0], each.name).size]
    rows = (
        (each.name, *state)
        for each in result.contacts
        for state in _states(result, [getattr(each, column.name) for column in named])
    )
    axes = "xyz"[: result.contacts[0].force.shape[-1]]
    components = [
        part
        for each in named
        for part in (
            each.components(axes) if getattr(result.contacts[0], each.name).ndim == 2 else (each,)
        )
    ]
    headings = _headings(result, (columns.CONTACT, *columns.STATE, *components))
    return ExportTable("contacts.csv", headings, rows)


def _factors(result: Result) -> ExportTable:
    names = [each.name for each in columns.FACTORS[2:]]
    rows = (
        (contact.name, station.front, station.number, *state)
        for contact in result.contacts
        for station in contact.stations
        for state in _states(result, [getattr(station, name) for name in names])
    )
    return ExportTable("factors.csv", _headings(result, (*columns.STATION, *columns.FACTORS)), rows)


def _states(result: Result, histories: Sequence[Array]) -> Iterator[Row]:
    """Number, time and values of every state; histories (T,) or (T, d)."""
    values = np.column_stack(histories)
    for state, (time, row) in enumerate(zip(result.loads.times, values, strict=True)):
        yield (state, time, *row)


def _tractions(result: Result) -> ExportTable:
    solution = result.solution
    assert solution is not None
    kept = np.arange(len(solution.times)) if solution.kept is None else solution.kept
    solid = result.solid
    named = columns.SOLID_TRACTIONS if solid else columns.PLANE_TRACTIONS
    rows = (
        (contact.name, int(state), solution.times[state], *row[:-2], int(row[-2]), row[-1])
        for contact in solution.contacts
        for state in kept
        for row in (_solid_nodes if solid else _plane_nodes)(contact, int(state))
    )
    return ExportTable("tractions.csv", _headings(result, named), rows)


def _local(result: Result) -> ExportTable:
    assert result.solution is not None
    named = columns.SOLID_LOCAL if result.solid else columns.PLANE_LOCAL
    own = [each.name for each in columns.PLANE_LOCAL[2:]]
    rows = (
        (contact.name, *row)
        for contact in result.solution.contacts
        for found in [result.local_parameters(contact.name)]
        for row in np.column_stack(
            [
                contact.points if result.solid else contact.arc,
                *(getattr(found, name) for name in own),
            ]
        )
    )
    return ExportTable("local.csv", _headings(result, named), rows)


def _stress(result: Result, fatemi_socie: tuple[float, float] | None) -> ExportTable:
    named = [*columns.STRESS, *([columns.FATEMI_SOCIE] if fatemi_socie else [])]
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
        for row in _parameters(arc, body, number)
    )
    return ExportTable("stress.csv", _headings(result, named), rows)


def _parameters(arc: Array, body: StressParameters, number: int) -> Array:
    """(N, 5 or 6) place and parameters at one of the depths."""
    at_surface = body.depths[number] == 0
    ruiz2 = body.ruiz2 if at_surface else np.full_like(body.ruiz2, np.nan)
    values = [arc, body.largest_tension[number], ruiz2, body.swt[number], body.shear_strain[number]]
    if body.fatemi_socie is not None:
        values.append(body.fatemi_socie[number])
    return np.column_stack(values)


def _edge_stress(result: Result) -> ExportTable:
    rows = (
        (each.contact, each.edge, each.body, *each.largest, each.reason)
        for name in result.case.contacts
        for each in result.stress_history(name).edges
    )
    return ExportTable("edge_stress.csv", _headings(result, columns.EDGE_STRESS), rows)


def _plane_nodes(contact: ContactHistory, state: int) -> Array:
    """(N, 7) values of a state, as of `columns.PLANE_TRACTIONS`."""
    return np.column_stack(
        [
            contact.arc,
            contact.mean_traction[state],
            contact.slip[state],
            *_scalars(contact, state),
        ]
    )


def _solid_nodes(contact: ContactHistory, state: int) -> Array:
    """(N, 16) values of a state, as of `columns.SOLID_TRACTIONS`."""
    traction, frames = contact.mean_traction[state], contact.frames
    shear = np.einsum("nt,ntd->nd", traction[:, 1:], frames[:, 1:])
    slip = np.einsum("nt,ntd->nd", contact.slip[state], frames[:, 1:])
    return np.column_stack(
        [
            contact.points,
            frames[:, 0],
            traction[:, 0],
            shear,
            slip,
            *_scalars(contact, state),
        ]
    )


def _scalars(contact: ContactHistory, state: int) -> tuple[Array, Array, Array]:
    """Gap, status and density of the friction work at the nodes."""
    work = contact.dissipation[state]
    density = np.divide(work, contact.weights, out=np.zeros_like(work), where=contact.weights > 0)
    return contact.gap[state], contact.status[state], density


@dataclass(frozen=True)
class Exported:
    """A file that was written, and its number of rows below the header."""

    path: Path
    rows: int


def export_result(
    result: Result, folder: Path, fatemi_socie: tuple[float, float] | None = None
) -> tuple[Exported, ...]:
    """Write histories, factors, edges, cycles or stations, and tractions as CSV files.

    Args:
        result: of plane bodies or of solids, complete or not.
        folder: for the files; made if missing. Tables of an earlier export in it are replaced.
        fatemi_socie: k and yield stress of that parameter; None leaves it out.

    Returns:
        The files; the last one lists their columns.

    Raises:
        CaseError: if the folder holds results of a run, or files of others that would be replaced,
            k is negative or the yield stress not positive.
        OutputError: if a file cannot be written, or there is no stress for that parameter.
    """
    prepare_other(folder)
    tables = list(export_tables(result, fatemi_socie))
    try:
        _remove_earlier(folder, [each.file for each in tables])
        named = ((t.file, h.text, h.name, h.unit, h.meaning) for t in tables for h in t.headings)
        # First: what was cut off can be exported again.
        listing = Exported(folder / COLUMNS, _write(folder / COLUMNS, LISTED, named))
        files = [
            Exported(folder / each.file, _write(folder / each.file, _header(each), each.rows))
            for each in tables
        ]
    except OSError as error:
        raise OutputError(f"{folder}: cannot write the tables: {disk_reason(error)}") from error
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


def _header(table: ExportTable) -> Sequence[str]:
    return [each.text for each in table.headings]


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
