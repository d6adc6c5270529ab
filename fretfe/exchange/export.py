# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write a result as CSV files that any program reads."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fretfe.errors import OutputError
from fretfe.exchange.tables import ExportTable, Row, export_tables
from fretfe.results.files import disk_reason, replacing
from fretfe.results.model import Result
from fretfe.results.writer import prepare_other

# Lists all columns of the other files.
COLUMNS = "columns.csv"


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
        CaseError: if the folder holds results of a run, k is negative or the yield stress not
            positive.
        OutputError: if a file cannot be written, or there is no stress for that parameter.
    """
    prepare_other(folder)
    tables = list(export_tables(result, fatemi_socie))
    try:
        _remove_earlier(folder)
        files = [
            Exported(folder / each.file, _write(folder / each.file, _header(each), each.rows))
            for each in tables
        ]
        named = ((t.file, h.text, h.name, h.unit, h.meaning) for t in tables for h in t.headings)
        header = ("file", "header", "column", "unit", "meaning")
        files.append(Exported(folder / COLUMNS, _write(folder / COLUMNS, header, named)))
    except OSError as error:
        raise OutputError(f"{folder}: cannot write the tables: {disk_reason(error)}") from error
    return tuple(files)


def _remove_earlier(folder: Path) -> None:
    """Remove the tables that an earlier export lists: the next one may have others."""
    listing = folder / COLUMNS
    if not listing.is_file():
        return
    with listing.open(encoding="utf-8", newline="") as file:
        names = {row.get("file") or "" for row in csv.DictReader(file)}
    # Names only: a listing that somebody has changed must not lead elsewhere.
    for name in names:
        if name.endswith(".csv") and Path(name).name == name:
            (folder / name).unlink(missing_ok=True)
    listing.unlink()


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
