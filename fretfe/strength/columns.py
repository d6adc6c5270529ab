# SPDX-License-Identifier: LGPL-3.0-or-later
"""Columns of a file of laboratory tests, with the units of their header.

Units of single quantities are converted to those of the results; those of edge factors must be the
same.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from fretfe._typing import Array, Bools
from fretfe.case import Units
from fretfe.case.units import same_unit, unit_size
from fretfe.errors import CaseError
from fretfe.loads.csv_file import Table, possible_headers, read_table, read_texts

FACTORS = ("k_n", "dk_t")
# K_N √l0/σ0 and ΔK_T/(σ0 √l0), with the stress σ0 and the length l0.
RATIOS = ("k_n_ratio", "dk_t_ratio", "stress", "length")
LOAD_COLUMNS = ("p", "q", "bulk")
KINDS = (FACTORS, RATIOS, LOAD_COLUMNS)
RUNOUT = "runout"
ELASTIC = ("young", "poisson")
# Every test has these; the constants of a test with loads may come from a material or a case.
PLAIN = ("life", "friction")
LENGTHS = ("radius", "flat_half_width", "height", "thickness")
# What a table of loads may have besides, as numbers and as texts.
BESIDE_LOADS = (*ELASTIC, *LENGTHS, "phase", "yield")
TEXTS = ("material", "case")
# Other usual names; all are compared in lower case.
SYNONYMS = {"f": "friction", "mu": "friction", "μ": "friction", "e": "young", "nu": "poisson",
            "ν": "poisson"}  # fmt: skip
# Units of the columns that have one.
UNITS = {
    "k_n": "{stress}/{length}^0.5",
    "dk_t": "{stress}*{length}^0.5",
    **dict.fromkeys(("young", "stress", "bulk", "yield"), "{stress}"),
    **dict.fromkeys(("length", *LENGTHS), "{length}"),
    **dict.fromkeys(("p", "q"), "{force}/{length}"),
}
# What may stand in brackets behind the name of another column: it has no unit.
NO_UNITS = ("", "-", "1", "cycle", "cycles")
DEGREES = ("°", "deg", "degree", "degrees")
# Life of a test that ended without failure, where no column says so: >1e7, 1e7+, 1e7 (run-out).
MARK = re.compile(r"^[>≥]\s*|\s*(\+|→|\(?run-?\s?out\)?)$", re.IGNORECASE)
# What is expected of a number other than one above zero.
SIGNS = {
    "q": "an amplitude >= 0",
    "bulk": "an amplitude >= 0 (against Q: a phase of 180)",
    "flat_half_width": "a number >= 0",
}
UNSIGNED = ("phase", "poisson", RUNOUT)


@dataclass(frozen=True)
class Columns:
    """Columns (n,) of a file by their names without units.

    Attributes:
        kind: one of `KINDS`.
        table: the file.
        headers: names of the columns as the file has them.
        values: in the units of the results.
        texts: cells of columns of texts.
        runout: whether a test ended without failure.
        unread: columns of the file that nothing reads.
    """

    kind: tuple[str, ...]
    table: Table
    headers: Mapping[str, str]
    values: dict[str, Array]
    texts: Mapping[str, list[str]]
    runout: Bools
    unread: tuple[str, ...]

    def refuse(self, name: str, wrong: Bools, expected: str) -> None:
        """Complain about the first of the rows (n,) that are wrong."""
        if wrong.any():
            self.table.complain(int(wrong.argmax()), self.headers[name], expected)

    def place(self, row: int, name: str) -> str:
        """File, line and column of a cell, in words."""
        return f"{self.table.path}: line {self.table.lines[row]}, column {self.headers[name]!r}"


def read_columns_of_tests(path: Path, units: Units) -> Columns:
    """Read the columns that tests have.

    Args:
        path: CSV file with a header whose names have their units in brackets.
        units: of the results that the tests are compared with.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    known = {*PLAIN, *FACTORS, *RATIOS, *LOAD_COLUMNS, *BESIDE_LOADS, *TEXTS, RUNOUT}
    headers = possible_headers(path)
    header = max(headers, key=lambda names: len(known & {_split(name)[0] for name in names}))
    found = _named(path, header)
    kind = _kind(path, found)
    wanted = _wanted(path, found, kind)
    texts = [name for name in TEXTS if kind == LOAD_COLUMNS and name in found]
    scales = [_scale(path, name, found, units) for name in wanted]
    names = [found[name][0] for name in wanted]
    mark = None if RUNOUT in found else (found["life"][0], MARK)
    table = read_table(path, names, mark=mark)
    values = {
        name: table.columns[column] * scale
        for name, column, scale in zip(wanted, names, scales, strict=True)
    }
    columns = Columns(
        kind=kind,
        table=table,
        headers={name: column for name, (column, _) in found.items()},
        values=values,
        texts={name: read_texts(path, found[name][0], names) for name in texts},
        runout=table.marked if mark else values[RUNOUT] == 1,
        unread=tuple(column for name, (column, _) in found.items() if name not in wanted + texts),
    )
    _check(columns)
    return columns


def _split(name: str) -> tuple[str, str | None]:
    """Name and unit of a column; None without a unit."""
    found = re.fullmatch(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\])?\s*", name)
    if found is None:
        return name, None
    plain = found[1].lower()
    return SYNONYMS.get(plain, plain), found[2]


def _named(path: Path, header: Iterable[str]) -> dict[str, tuple[str, str | None]]:
    """Columns of the file and their units, by their names."""
    found: dict[str, tuple[str, str | None]] = {}
    for column in header:
        name, unit = _split(column)
        if name in found:
            raise CaseError(f"{path}: line 1: expected one column {name!r}, found two")
        found[name] = (column, unit)
    return found


def _kind(path: Path, found: Iterable[str]) -> tuple[str, ...]:
    """Columns that factors come from: loads, only if the file has no factors itself."""
    kinds = [each for each in KINDS if set(each[:2]) & set(found)]
    if len(kinds) > 1 and LOAD_COLUMNS in kinds:
        kinds.remove(LOAD_COLUMNS)
    if len(kinds) != 1:
        raise CaseError(
            f"{path}: line 1: expected either k_n and dk_t or k_n_ratio and dk_t_ratio, or loads, "
            f"P, Q and bulk, found {'both' if kinds else ', '.join(map(repr, found)) or 'nothing'}"
        )
    return kinds[0]


def _wanted(path: Path, found: Mapping[str, object], kind: tuple[str, ...]) -> list[str]:
    """Names of all columns of numbers that are read."""
    wanted = [*kind, *PLAIN]
    if kind != LOAD_COLUMNS:
        wanted += ELASTIC
    elif "case" not in found:
        wanted += ["radius", *(() if "material" in found else ELASTIC)]
    missing = [
        f"{name!r}{' (0 will do)' if name == 'bulk' else ''}"
        for name in wanted
        if name not in found
    ]
    if missing:
        what = "columns" if len(missing) > 1 else "a column"
        listed = ", ".join(map(repr, found))
        raise CaseError(f"{path}: line 1: expected {what} {', '.join(missing)}, found {listed}")
    if kind == LOAD_COLUMNS:
        twice = {"case": ("radius", "flat_half_width", "height", "material", *ELASTIC),
                 "material": ELASTIC}  # fmt: skip
        for name, others in twice.items():
            both = [each for each in others if name in found and each in found]
            if both:
                raise CaseError(
                    f"{path}: line 1: expected either a column {name!r} or {both[0]!r}, found both"
                )
        wanted += [name for name in BESIDE_LOADS if name in found and name not in wanted]
    return [*wanted, *([RUNOUT] if RUNOUT in found else [])]


def _scale(
    path: Path, name: str, found: Mapping[str, tuple[str, str | None]], units: Units
) -> float:
    """Size of the unit of a column in that of the results."""
    unit = found[name][1]
    place = f"{path}: line 1, column {name!r}"
    if name not in UNITS:
        known = (*NO_UNITS, *(DEGREES if name == "phase" else ()))
        if unit is not None and unit.strip() not in known:
            raise CaseError(f"{place}: expected no unit, found [{unit}]")
        return 1.0
    expected = UNITS[name].format(**units.model_dump())
    whole = name in ("p", "q") and "thickness" in found
    if whole:
        expected = units.force
    if unit is not None and same_unit(unit, expected):
        return 1.0
    size, own = unit_size(unit or ""), unit_size(expected)
    if size and own and size[1] == own[1]:
        return size[0] / own[0]
    shown = "none" if unit is None else f"[{unit}]"
    if name in FACTORS:
        text = f"the unit of the results, [{expected}], found {shown}: it is never converted"
    else:
        text = f"a unit as [{expected}], found {shown}"
    if size and size[1] == "force" and not whole:
        text += "; a force of the whole specimen needs a column 'thickness'"
    raise CaseError(f"{place}: expected {text}")


def _check(columns: Columns) -> None:
    """Complain about the first number that no test can have."""
    for name, given in columns.values.items():
        if name in SIGNS:
            columns.refuse(name, given < 0, SIGNS[name])
        elif name not in UNSIGNED:
            columns.refuse(name, given <= 0, "a number > 0")
    if "poisson" in columns.values:
        poisson = columns.values["poisson"]
        wrong = (poisson <= -1) | (poisson >= 0.5)
        columns.refuse("poisson", wrong, "a number > -1 and < 0.5")
    if RUNOUT in columns.values:
        ended = columns.values[RUNOUT]
        columns.refuse(RUNOUT, (ended != 0) & (ended != 1), "1 for a run-out or 0 for a failure")
    elif not columns.runout.any():
        raise CaseError(
            f"{columns.table.path}: line 1: expected a column 'runout', or marks as in >1e7 in the "
            "column of lives, found neither"
        )
