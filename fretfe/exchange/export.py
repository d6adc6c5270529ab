# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write a result as CSV files that any program reads."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fretfe.errors import CaseError, OutputError
from fretfe.exchange.tables import ExportTable, Row, export_tables
from fretfe.results.files import disk_reason, replacing
from fretfe.results.model import Result
from fretfe.results.writer import prepare_other

# Lists all columns of the other files, with these of its own.
COLUMNS = "columns.csv"
LISTED = ("file", "header", "column", "unit", "meaning")
TABLE_NAME = re.compile(r"[a-z_]+\.csv")


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
