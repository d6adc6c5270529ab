# SPDX-License-Identifier: LGPL-3.0-or-later
"""Columns of a CSV file with a header row."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array
from fretfe.errors import CaseError


@dataclass(frozen=True)
class Table:
    """Columns (n,) by name, n >= 1, and the line of the file that each row stands in."""

    path: Path
    columns: dict[str, Array]
    lines: tuple[int, ...]

    def require_increasing(self, name: str, what: str) -> None:
        """Check that a column increases strictly; `what` it holds is for the message.

        Raises:
            CaseError: file, line and column of the first value that is not larger than the last.
        """
        values = self.columns[name]
        wrong = np.flatnonzero(np.diff(values) <= 0)
        if wrong.size:
            row = int(wrong[0]) + 1
            self.complain(row, name, f"a {what} after {values[row - 1]:g}")

    def complain(self, row: int, name: str, expected: str) -> None:
        """Raise the error that says what was expected of a value.

        Raises:
            CaseError: always.
        """
        place = f"{self.path}: line {self.lines[row]}, column {name!r}"
        raise CaseError(f"{place}: expected {expected}, found {self.columns[name][row]:g}")


def read_table(path: Path, names: Sequence[str], optional: Sequence[str] = ()) -> Table:
    """Read columns of finite numbers.

    Args:
        path: comma-separated file, UTF-8, with a header row; empty lines are skipped.
        names: of the columns.
        optional: names of columns that are read if the file has them.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    rows = _rows(path)
    header = [name.strip() for name in rows[0][1]]
    wanted = [*names, *(name for name in optional if name in header)]
    places = [_column(path, header, name) for name in wanted]
    if len(rows) == 1:
        raise CaseError(f"{path}: expected rows of numbers below the header, found none")
    data = np.array([[_number(path, *row, header, place) for place in places] for row in rows[1:]])
    columns = dict(zip(wanted, data.T, strict=True))
    return Table(path, columns, tuple(line for line, _ in rows[1:]))


def read_columns(path: Path, time: str, value: str) -> tuple[Array, Array]:
    """Read a column of times, not negative and strictly increasing, and a column of values.

    Args:
        path: as for `read_table`.
        time: name of the column with the times.
        value: name of the column with the values.

    Returns:
        times (n,) and values (n,), n >= 1.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    table = read_table(path, (time, value))
    times = table.columns[time]
    negative = np.flatnonzero(times < 0)
    if negative.size:
        table.complain(int(negative[0]), time, "a time >= 0")
    table.require_increasing(time, "time")
    return times, table.columns[value]


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Line number and cells of every line that is not empty, the header first."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file, skipinitialspace=True)
            rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except OSError as error:
        raise CaseError(f"{path}: expected a CSV file, found none ({error.strerror})") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise CaseError(f"{path}: expected a CSV file (UTF-8 text), found: {error}") from None
    if not rows:
        raise CaseError(f"{path}: expected a header row with the column names, found an empty file")
    return rows


def _column(path: Path, names: list[str], name: str) -> int:
    if names.count(name) == 1:
        return names.index(name)
    found = ", ".join(map(repr, names))
    hint = " (cells are separated by commas)" if ";" in found or "\\t" in found else ""
    raise CaseError(f"{path}: line 1: expected one column {name!r}, found {found}{hint}")


def _number(path: Path, line: int, cells: list[str], names: list[str], column: int) -> float:
    cell = cells[column].strip() if column < len(cells) else ""
    try:
        number = float(cell)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        found = repr(cell) if cell else "an empty cell"
        place = f"{path}: line {line}, column {names[column]!r}"
        raise CaseError(f"{place}: expected a finite number, found {found}")
    return number
