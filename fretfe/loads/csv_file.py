# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two columns of a CSV file with a header row."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fretfe.errors import CaseError

Array = NDArray[np.float64]


def read_columns(path: Path, time: str, value: str) -> tuple[Array, Array]:
    """Read a column of times, not negative and strictly increasing, and a column of values.

    Args:
        path: comma-separated file, UTF-8, with a header row; empty lines are skipped.
        time: name of the column with the times.
        value: name of the column with the values.

    Returns:
        times (n,) and values (n,), n >= 1.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    rows = _rows(path)
    names = [name.strip() for name in rows[0][1]]
    columns = [_column(path, names, name) for name in (time, value)]
    if len(rows) == 1:
        raise CaseError(f"{path}: expected rows of numbers below the header, found none")
    data = np.array(
        [[_number(path, *row, names, column) for column in columns] for row in rows[1:]]
    )
    _check_increasing(path, [line for line, _ in rows[1:]], time, data[:, 0])
    return data[:, 0], data[:, 1]


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


def _check_increasing(path: Path, lines: list[int], name: str, times: Array) -> None:
    steps = np.diff(times, prepend=-np.inf)
    wrong = np.flatnonzero((steps <= 0) | (times < 0))
    if not wrong.size:
        return
    row = int(wrong[0])
    expected = "a time >= 0" if times[row] < 0 else f"a time after {times[row - 1]:g}"
    raise CaseError(
        f"{path}: line {lines[row]}, column {name!r}: expected {expected}, found {times[row]:g}"
    )
