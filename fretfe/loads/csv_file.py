# SPDX-License-Identifier: LGPL-3.0-or-later
"""Columns of numbers in a text file with a header row.

Spreadsheets and people put rows around it: `sep=;` of Excel, comments that begin with #, a row of
units below the header. The header itself may be a comment, as NumPy writes it, if only numbers
follow.
"""

from __future__ import annotations

import csv
import math
import re
from array import array
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.case.base import LARGEST
from fretfe.case.messages import shortened
from fretfe.case.units import equal_units
from fretfe.errors import CaseError
from fretfe.files import MOST_ROWS, require_file

# What may stand between cells, by the name that a case gives it.
SEPARATORS = {",": ",", ";": ";", "tab": "\t", "space": " "}
# Bytes of a file that is read at once if it can be.
LARGE = 1_000_000
# First line of a file by Excel that says what stands between cells.
STATED = re.compile(r'"?sep=(.)"?[\s,;]*\Z', re.IGNORECASE)
COMMENT = re.compile(r'\s*"?#')
# Units that a row below the header may have, alone or as factors, with brackets or without.
UNITS = frozenset(
    "m mm cm um µm μm nm in inch ft n kn mn lbf pa kpa mpa gpa bar psi ksi s sec ms min h hz "
    "1/s rpm k c °c degc f °f deg degree degrees ° rad g kg t w j mj mohm - % 1".split()
)
# A name with a unit behind it.
BRACKETED = re.compile(r"(.*\S)\s*\[(.*)\]")
# A name that has brackets at its end, or ends as in "Q / kN" (ISO 80000-1) and "Q in kN".
ENDING = re.compile(r".*\S\s*(?:[\[(]([^\[\]()]*)[\])]|\s(?:/|in)\s+(\S+))")
# Numbers nearer to zero have lost digits: they are remains of something else.
SMALLEST_CELL = 1e-300


# Units of columns by their names, one or several that are the same.
Stated = Mapping[str, str | tuple[str, ...]]


class _NoCells(CaseError):
    """A line has no cells with some delimiter."""


@dataclass(frozen=True)
class Table:
    """Columns (n,) by name, n >= 1, and the line of the file that each row stands in.

    Attributes:
        path: of the file.
        columns: by name.
        lines: of the rows.
        units: cells of a row of units below the header; none without. Nothing is converted.
        stated: by column, the unit in brackets behind its name, or at its end, or in a row below
            the header.
        marked: (n,) rows with a mark in the column that may have one; (0,) if none may.
    """

    path: Path
    columns: dict[str, Array]
    lines: Sequence[int]
    units: tuple[str, ...] = ()
    stated: Mapping[str, str] = field(default_factory=dict)
    marked: Bools = field(default_factory=lambda: np.zeros(0, dtype=bool))

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

    def require_units(self, units: Stated) -> None:
        """Check that columns are in some units; see `require_units`."""
        require_units(self.path, self.stated, units)

    def complain(self, row: int, name: str, expected: str) -> None:
        """Raise the error that says what was expected of a value.

        Raises:
            CaseError: always.
        """
        place = f"{self.path}: line {self.lines[row]}, column {name!r}"
        raise CaseError(f"{place}: expected {expected}, found {self.columns[name][row]:g}")


def require_units(path: Path, stated: Mapping[str, str], units: Stated) -> None:
    """Check that columns are in some units where a file states in which they are.

    Args:
        path: of the file.
        stated: units that it states, by the names of columns.
        units: that are expected, by these names, one or several for each; "1" of pure numbers.

    Raises:
        CaseError: names the first one that is in another unit.
    """
    for name, unit in stated.items():
        expected = units.get(name, unit)
        known = (expected,) if isinstance(expected, str) else expected
        if not any(equal_units(unit, each) for each in known):
            shown = "pure numbers" if expected == "1" else " or ".join(known)
            raise CaseError(f"{path}: expected {name} in {shown}, found {name} in {unit}")


def read_table(
    path: Path,
    names: Sequence[str],
    optional: Sequence[str] = (),
    separator: str | None = None,
    mark: tuple[str, re.Pattern[str]] | None = None,
) -> Table:
    """Read columns of finite numbers.

    Args:
        path: text file, UTF-8, with a header row; empty lines and those that begin with # are
            skipped. Where cells are not separated by commas, numbers may have a decimal comma: all
            or none of them.
        names: of the columns.
        optional: names of columns that are read if the file has them.
        separator: one of `SEPARATORS`; None if the file tells it.
        mark: name of a column, and what may stand beside its numbers.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    delimiter = SEPARATORS[separator] if separator else _told_delimiter(path, names)
    rows = _rows(path, delimiter)
    header, bracketed = _without_units([*map(str.strip, next(rows)[1])], {*names, *optional})
    wanted = [*names, *(name for name in optional if name in header)]
    places = [_column(path, header, name, delimiter) for name in wanted]
    first = next(rows, None)
    units: tuple[str, ...] = ()
    if first is not None and _are_units(first[1]):
        units = tuple(cell.strip() for cell in first[1])
        bracketed |= {name: unit for name, unit in zip(header, units, strict=False) if unit}
        first = next(rows, None)
    if first is None:
        raise CaseError(f"{path}: expected rows of numbers below the header, found none")
    if (
        path.stat().st_size > LARGE
        and not mark
        and (found := _at_once(path, delimiter, first[0], len(header)))
    ):
        values, start = found
        named = dict(zip(wanted, values[places], strict=True))
        return Table(path, named, start, units, bracketed)
    numbers = _Numbers(path, header, decimal_comma=delimiter != ",")
    data, lines, marked = array("d"), array("l"), []
    for line, cells in chain([first], rows):
        _require_cells(path, line, cells, header, delimiter, least=min(len(wanted), 2))
        if len(lines) == MOST_ROWS:
            raise CaseError(
                f"{path}: line {line}: expected at most {MOST_ROWS:,} rows of numbers, found more"
            )
        lines.append(line)
        if mark is not None:
            marked.append(_take_mark(cells, header.index(mark[0]), mark[1]))
        data.extend(numbers.read(line, cells, place) for place in places)
    columns = np.array(data).reshape(len(lines), len(wanted)).T
    named = dict(zip(wanted, columns, strict=True))
    return Table(path, named, lines, units, bracketed, np.array(marked, dtype=bool))


def _without_units(
    header: Sequence[str], names: Collection[str]
) -> tuple[list[str], dict[str, str]]:
    """A header in which no unit in brackets follows one of some names, and units in brackets.

    A name may itself end with its unit.
    """
    plain, units = [], {}
    for cell in header:
        found = BRACKETED.fullmatch(cell)
        if found and cell not in names and found[1] in names:
            units[found[1]] = found[2]
        elif cell in names and (own := ENDING.fullmatch(cell)):
            unit = own[1] or own[2] or ""
            if _is_named_unit(unit):
                units[cell] = unit
        plain.append(found[1] if found and found[1] in units else cell)
    return plain, units


def _take_mark(cells: list[str], place: int, mark: re.Pattern[str]) -> bool:
    """Take what may stand beside a number out of its cell; true if it was there."""
    if place >= len(cells):
        return False
    cells[place], count = mark.subn("", cells[place].strip())
    return count > 0


def _are_units(cells: Sequence[str]) -> bool:
    """True for a row of nothing but units, 1 and - for pure numbers among them."""
    texts = [cell.strip() for cell in cells if cell.strip()]
    return any(map(_is_named_unit, texts)) and all(map(is_unit, texts))


def _is_named_unit(text: str) -> bool:
    """True for a unit that is not that of pure numbers."""
    return re.search("[a-zµμ°%]", text.lower()) is not None and is_unit(text)


def is_unit(text: str) -> bool:
    """True for a unit, perhaps in brackets, or a product or power of units."""
    inner = re.sub(r"[\[\]()<>{}\"']", "", text.strip().lower())
    factors = [each for each in re.split(r"[\s/*·.^]+|-?\d+|[²³]", inner) if each]
    return inner in UNITS or (bool(factors) and UNITS.issuperset(factors))


def is_number(text: str) -> bool:
    """True for a number with a decimal point or comma."""
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def _at_once(path: Path, delimiter: str, first: int, width: int) -> tuple[Array, range] | None:
    """(width, n) all numbers of a large file from a line on; and the lines of its rows.

    It is read twenty times as fast as cell by cell. None if a reader of cells has to say what is
    wrong, or can make something of it.
    """
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        last = max(number for number, line in enumerate(file, 1) if line.strip())
    rest = last - first + 1
    try:
        values = np.loadtxt(
            path, delimiter=delimiter, comments=None, skiprows=first - 1, ndmin=2,
            max_rows=MOST_ROWS + 1, encoding="utf-8-sig",
        )  # fmt: skip
    except (ValueError, OSError):
        return None
    size = np.abs(values)
    usual = (size <= LARGEST) & ((size >= SMALLEST_CELL) | (size == 0))
    if (
        values.shape[1] != width
        or len(values) != rest
        or len(values) > MOST_ROWS
        or not usual.all()
    ):
        return None
    return values.T, range(first, last + 1)


def read_columns(
    path: Path, time: str, value: str, units: Stated, separator: str | None = None
) -> tuple[Array, Array]:
    """Read a column of times, not negative and strictly increasing, and a column of values.

    Args:
        path: as for `read_table`.
        time: name of the column with the times.
        value: name of the column with the values.
        units: in which these columns must be, by name, if the file says in which they are.
        separator: as for `read_table`.

    Returns:
        times (n,) and values (n,), n >= 1.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    table = read_table(path, (time, value), separator=separator)
    table.require_units(units)
    times = table.columns[time]
    negative = np.flatnonzero(times < 0)
    if negative.size:
        table.complain(int(negative[0]), time, "a time >= 0")
    table.require_increasing(time, "time")
    return times, table.columns[value]


def read_texts(path: Path, name: str, names: Sequence[str]) -> list[str]:
    """The cells of a column of a file whose header has some names.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    delimiter = _told_delimiter(path, names)
    rows = _rows(path, delimiter)
    place = _column(path, [each.strip() for each in next(rows)[1]], name, delimiter)
    return [
        cells[place].strip() if place < len(cells) else ""
        for _, cells in rows
        if not _are_units(cells)
    ]


def possible_headers(path: Path) -> list[tuple[str, ...]]:
    """Column names of a file by each of the separators that it might have, the comma first.

    Raises:
        CaseError: if the file cannot be read, with any of them.
    """
    return list(_headers(path).values())


def _headers(path: Path) -> dict[str, tuple[str, ...]]:
    """Column names by the delimiters with which the header can be read, the comma first."""
    found: dict[str, tuple[str, ...]] = {}
    problems: list[CaseError] = []
    stated = _stated_delimiter(path)
    for delimiter in (stated,) if stated else SEPARATORS.values():
        try:
            found[delimiter] = tuple(name.strip() for name in next(_rows(path, delimiter))[1])
        except _NoCells as error:  # names in quotes end at another delimiter
            problems.append(error)
    if not found:
        raise problems[0]
    return found


def _stated_delimiter(path: Path) -> str | None:
    """The delimiter that the first line states; None if it states none."""
    require_file(path, "a CSV file", CaseError)
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            line = next((line for line in file if line.strip()), "")
    except OSError:  # reading its rows says what is wrong
        return None
    found = STATED.match(line.lstrip())
    if found and found[1] not in SEPARATORS.values():
        raise CaseError(
            f"{path}: line 1: expected a separator of {', '.join(map(repr, SEPARATORS))}, found "
            f"{found[1]!r}"
        )
    return found[1] if found else None


def _told_delimiter(path: Path, names: Sequence[str]) -> str:
    """The delimiter with which the header row has all of the names, or else most, or most cells.

    Spaces may stand beside any other delimiter: they are the delimiter only if nothing else is.
    """
    found: dict[tuple[str, ...], str] = {}
    headers = _headers(path)
    for delimiter, header in headers.items():
        if set(names) <= set(_without_units(header, names)[0]) and not (found and delimiter == " "):
            found.setdefault(header, delimiter)
    if len(found) > 1:
        kinds = " and ".join(repr(delimiter) for delimiter in found.values())
        raise CaseError(
            f"{path}: line 1: expected one separator with which the header has the columns "
            f"{', '.join(map(repr, names))}, found {kinds}: name it"
        )

    def likely(delimiter: str) -> tuple[int, bool, bool]:
        header = headers[delimiter]
        known = set(names) & set(_without_units(header, names)[0])
        return len(known), len(header) > 1, delimiter != " "

    return next(iter(found.values()), max(headers, key=likely))


def _rows(path: Path, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of every line that is not empty or a comment, the header first."""
    require_file(path, "a CSV file", CaseError)
    heading: tuple[int, str] | None = None
    empty = True

    def lines(file: Iterable[str]) -> Iterator[str]:
        """Lines without comments, which may have quotes that do not end; but they count."""
        nonlocal heading
        begun = False
        for number, line in enumerate(file, 1):
            if COMMENT.match(line):
                heading = number, line.strip().strip('"').lstrip("# \t")
                yield "\n"
            elif not begun and STATED.match(line.lstrip()):
                yield "\n"
            else:
                yield line
            begun = begun or bool(line.strip())

    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            spaces = delimiter != "\t"
            reader = csv.reader(
                lines(file), delimiter=delimiter, skipinitialspace=spaces, strict=True
            )
            for row in reader:
                if any(cell.strip() for cell in row):
                    if empty and heading is not None and _are_numbers(row):
                        yield from _header_in(*heading, delimiter, len(row))
                    empty = False
                    yield reader.line_num, row
    except OSError as error:
        raise CaseError(f"{path}: expected a CSV file, found none ({error.strerror})") from None
    except UnicodeDecodeError:
        raise CaseError(f"{path}: {_not_text(path)}") from None
    except csv.Error as error:
        place = f"{path}: line {reader.line_num}"
        raise _NoCells(f"{place}: expected cells of a CSV file, found: {error}") from None
    if empty:
        raise CaseError(f"{path}: expected a header row with the column names, found an empty file")


def _are_numbers(cells: Sequence[str]) -> bool:
    return all(is_number(cell) for cell in cells if cell.strip())


def _header_in(
    number: int, comment: str, delimiter: str, count: int
) -> Iterator[tuple[int, list[str]]]:
    """The header in the last comment before the numbers, if it has as many cells."""
    header = next(csv.reader([comment], delimiter=delimiter, skipinitialspace=True), [])
    if len(header) == count:
        yield number, header


def _not_text(path: Path) -> str:
    """Place at which a file is not the text that it should be, in words."""
    try:
        path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        found = f"the byte {error.object[error.start]:#04x}"
    return (
        f"line {line}: expected UTF-8 text, found {found}, as in a file that was saved with "
        "another encoding (latin-1, UTF-16); save it as UTF-8"
    )


def _require_cells(
    path: Path, line: int, cells: list[str], header: list[str], delimiter: str, least: int
) -> None:
    """A decimal comma between commas is one more cell, another separator makes one of all."""
    if len(cells) < least and any(each in cells[0].strip() for each in SEPARATORS.values()):
        raise CaseError(
            f"{path}: line {line}: expected {len(header)} cells with the separator "
            f"{_called(delimiter)}, as in the header, found {shortened(cells[0])!r}"
        )
    if any(cell.strip() for cell in cells[len(header) :]):
        raise CaseError(
            f"{path}: line {line}: expected at most {len(header)} cells, as in the header, found "
            f"{len(cells)} (a decimal comma needs another separator)"
        )


def _called(delimiter: str) -> str:
    """The name that a case gives a delimiter, in quotes."""
    return next(repr(name) for name, each in SEPARATORS.items() if each == delimiter)


def _column(path: Path, names: list[str], name: str, delimiter: str) -> int:
    if names.count(name) == 1:
        return names.index(name)
    found = f"{', '.join(map(repr, names))}, with the separator {_called(delimiter)}"
    others = [each for each, header in _headers(path).items() if name in header]
    if others and name not in names:
        found += f"; it has one with {_called(others[0])}"
    raise CaseError(f"{path}: line 1: expected one column {name!r}, found {found}")


@dataclass
class _Numbers:
    """Reads the cells of a file, whose numbers have one decimal mark.

    Attributes:
        path: of the file.
        header: names of the columns.
        decimal_comma: whether numbers may have one.
        first: by decimal mark, the first number that has it, with its line and column.
    """

    path: Path
    header: list[str]
    decimal_comma: bool
    first: dict[str, str] = field(default_factory=dict)

    def read(self, line: int, cells: list[str], column: int) -> float:
        """The finite number in one cell of a line.

        Raises:
            CaseError: if there is none.
        """
        cell = cells[column].strip() if column < len(cells) else ""
        marks = [mark for mark in ".," if mark in cell]
        if self.decimal_comma and cell.count(",") == 1:
            text = cell.replace(",", ".") if marks == [","] else ""
        else:
            text = cell
        # Python reads 1_000 and the digits of other scripts too; what they mean here is a guess.
        if "_" in text or not text.isascii():
            text = ""
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        place = f"line {line}, column {self.header[column]!r}"
        if not abs(number) <= LARGEST:
            found = repr(shortened(cell)) if cell else "an empty cell"
            expected = (
                "a finite number"
                if abs(number) == math.inf or math.isnan(number)
                else (f"a number from {-LARGEST:g} to {LARGEST:g}")
            )
            raise CaseError(f"{self.path}: {place}: expected {expected}, found {found}")
        if 0 < abs(number) < SMALLEST_CELL:
            raise CaseError(
                f"{self.path}: {place}: expected 0, or a number of {SMALLEST_CELL:g} or more, "
                f"found {shortened(cell)!r}"
            )
        for mark in marks:
            self.first.setdefault(mark, f"{cell!r} in {place}")
        if len(self.first) > 1:
            raise CaseError(
                f"{self.path}: {place}: expected decimal points or decimal commas, found both: "
                + " and ".join(self.first.values())
            )
        return number
