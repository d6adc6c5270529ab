# SPDX-License-Identifier: LGPL-3.0-or-later
"""Laboratory tests from a CSV file: edge factors, lives, run-outs; units stand in the header."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.case import Units
from fretfe.errors import CaseError
from fretfe.loads.csv_file import Table, possible_headers, read_table

PLAIN = ("life", "runout", "friction", "young", "poisson")
FACTORS = ("k_n", "dk_t")
# K_N √l0/σ0 and ΔK_T/(σ0 √l0), with the stress σ0 and the length l0.
RATIOS = ("k_n_ratio", "dk_t_ratio", "stress", "length")
# Units of the columns that have one.
UNITS = {
    "k_n": "{stress}/{length}^0.5",
    "dk_t": "{stress}*{length}^0.5",
    "young": "{stress}",
    "stress": "{stress}",
    "length": "{length}",
}
# What may stand in brackets behind the name of another column: it has no unit.
NO_UNITS = ("", "-", "1", "cycle", "cycles")
FORMAT = "see docs/strength.md"


@dataclass(frozen=True)
class StrengthTests:
    """Tests, n of them; factors in the units that are given.

    Attributes:
        path: of the file.
        units: of lengths and stresses.
        k_n, k_t_range: (n,) K_N and ΔK_T at the edge where the specimen failed or could have.
        life: (n,) cycles to failure, or to the end of the test.
        runout: (n,) whether the test ended without failure.
        friction: (n,) coefficient.
        young, poisson: (n,) of the specimen.
    """

    path: Path
    units: Units
    k_n: Array
    k_t_range: Array
    life: Array
    runout: Bools
    friction: Array
    young: Array
    poisson: Array


def read_tests(path: Path, units: Units) -> StrengthTests:
    """Read tests.

    Args:
        path: CSV file with a header whose names have their units in brackets.
        units: of the results that the tests are compared with; others are refused.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    headers = possible_headers(path)
    known = {*PLAIN, *FACTORS, *RATIOS}
    header = max(headers, key=lambda names: len(known & {_split(name)[0] for name in names}))
    columns = _columns(path, header, units)
    table = read_table(path, list(columns.values()))
    values = {name: table.columns[column] for name, column in columns.items()}
    _require_positive(table, columns, set(values) - {"runout", "poisson"})
    _require_poisson(table, columns["poisson"])
    k_n, k_t_range = _factors(values)
    return StrengthTests(
        path=path,
        units=units,
        k_n=k_n,
        k_t_range=k_t_range,
        life=values["life"],
        runout=_truth(table, columns["runout"]),
        friction=values["friction"],
        young=values["young"],
        poisson=values["poisson"],
    )


def same_unit(one: str, two: str) -> bool:
    """True if two units are written alike but for roots, products and spaces."""
    return _unit(one) == _unit(two)


def _unit(text: str) -> str:
    text = re.sub(r"√\(?([^\s)·*/]+)\)?|sqrt\(([^)]*)\)", r"\1\2^0.5", text)
    return re.sub(r"[\s·*]+", "*", text.strip()).replace("^(1/2)", "^0.5").replace("**", "^")


def _split(name: str) -> tuple[str, str | None]:
    """Name and unit of a column; None without a unit."""
    found = re.fullmatch(r"\s*([^\[\]]*?)\s*(?:\[(.*)\])?\s*", name)
    return (found[1].lower(), found[2]) if found else (name, None)


def _columns(path: Path, header: Iterable[str], units: Units) -> dict[str, str]:
    """Columns of the file by their names without units."""
    found: dict[str, tuple[str, str | None]] = {}
    for column in header:
        name, unit = _split(column)
        if name in found:
            raise CaseError(f"{path}: line 1: expected one column {name!r}, found two")
        found[name] = (column, unit)
    kinds = [each for each in (FACTORS, RATIOS) if set(each[:2]) & set(found)]
    if len(kinds) != 1:
        raise CaseError(
            f"{path}: line 1: expected either k_n and dk_t or k_n_ratio and dk_t_ratio, found "
            f"{'both' if kinds else ', '.join(map(repr, found)) or 'nothing'} ({FORMAT})"
        )
    wanted = (*kinds[0], *PLAIN)
    for name in wanted:
        if name not in found:
            listed = ", ".join(map(repr, found))
            raise CaseError(
                f"{path}: line 1: expected a column {name!r}, found {listed} ({FORMAT})"
            )
        _require_unit(path, name, found[name][1], units)
    return {name: found[name][0] for name in wanted}


def _require_unit(path: Path, name: str, unit: str | None, units: Units) -> None:
    if name not in UNITS:
        if unit is not None and unit.strip() not in NO_UNITS:
            raise CaseError(
                f"{path}: line 1, column {name!r}: expected no unit, found [{unit}]: numbers are "
                "never converted"
            )
        return
    expected = UNITS[name].format(**units.model_dump())
    if unit is None or not same_unit(unit, expected):
        found = "none" if unit is None else f"[{unit}]"
        raise CaseError(
            f"{path}: line 1, column {name!r}: expected the unit of the results, [{expected}], "
            f"found {found}: numbers are never converted"
        )


def _factors(values: dict[str, Array]) -> tuple[Array, Array]:
    if "k_n" in values:
        return values["k_n"], values["dk_t"]
    stress, root = values["stress"], np.sqrt(values["length"])
    return values["k_n_ratio"] * stress / root, values["dk_t_ratio"] * stress * root


def _require_positive(table: Table, columns: dict[str, str], names: set[str]) -> None:
    for name in names:
        wrong = np.flatnonzero(table.columns[columns[name]] <= 0)
        if wrong.size:
            table.complain(int(wrong[0]), columns[name], "a number > 0")


def _require_poisson(table: Table, column: str) -> None:
    values = table.columns[column]
    wrong = np.flatnonzero((values <= -1) | (values >= 0.5))
    if wrong.size:
        table.complain(int(wrong[0]), column, "a number > -1 and < 0.5")


def _truth(table: Table, column: str) -> Bools:
    values = table.columns[column]
    wrong = np.flatnonzero((values != 0) & (values != 1))
    if wrong.size:
        table.complain(int(wrong[0]), column, "1 for a run-out or 0 for a failure")
    return np.asarray(values == 1)
