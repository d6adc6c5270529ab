# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coefficients of friction that change with time or along the surface, as a case has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, complaint
from fretfe.case.friction import InFile, OverArc, OverTime
from fretfe.errors import CaseError
from fretfe.loads.csv_file import read_table

# Columns of a file: its coefficients, and what they are over.
COEFFICIENT, PLACES = "friction", ("x", "y", "z")
# A surface or a history may reach this fraction of a table beyond its ends.
BEYOND = 1e-6


@dataclass(frozen=True)
class Varying:
    """A table of coefficients over one of times, arc lengths and places.

    Attributes:
        values: (n,) coefficients.
        times: (n,) times at which they hold, with straight lines between them.
        arc: (n,) arc lengths along the surface, likewise.
        points: (n, 2 or 3) places: a node has the coefficient of the nearest one.
    """

    values: Array
    times: Array | None = None
    arc: Array | None = None
    points: Array | None = None


def varying(case: Case, name: str) -> Varying | None:
    """The table of coefficients of a contact; None for a number.

    Raises:
        CaseError: a file cannot be read, or has other columns or numbers than expected.
    """
    match case.contacts[name].friction:
        case OverTime() as table:
            return Varying(np.array(table.values), times=np.array(table.times))
        case OverArc() as table:
            return Varying(np.array(table.values), arc=np.array(table.arc))
        case InFile() as table:
            try:
                return _in_file(case, table)
            except CaseError as error:
                key = ("contacts", name, "friction", "csv")
                raise CaseError(complaint(case.source, key, str(error))) from None
    return None


def _in_file(case: Case, given: InFile) -> Varying:
    path = case.resolve(given.csv)
    over = ("time", "arc", *PLACES)
    table = read_table(path, (COEFFICIENT,), over, given.separator)
    found = tuple(each for each in over if each in table.columns)
    if found not in (("time",), ("arc",), PLACES[:2], PLACES):
        expected = "a column time, a column arc, or columns x and y (and z)"
        raise CaseError(f"{path}: expected {expected}, found {' and '.join(found) or 'none'}")
    values = table.columns[COEFFICIENT]
    if (wrong := np.flatnonzero(values < 0)).size:
        table.complain(int(wrong[0]), COEFFICIENT, "a coefficient >= 0")
    if len(found) > 1:
        return Varying(values, points=np.column_stack([table.columns[each] for each in found]))
    table.require_increasing(found[0], "value")
    if found == ("time",):
        return Varying(values, times=table.columns["time"])
    return Varying(values, arc=table.columns["arc"])


def require_times(case: Case, end: float) -> None:
    """Check that coefficients over time are given from when friction acts to the end of loading.

    Raises:
        CaseError: with all contacts for which they are not, or whose files cannot be read.
    """
    problems = []
    for name, contact in case.contacts.items():
        try:
            table = varying(case, name)
        except CaseError as error:
            problems.append(str(error))
            continue
        if table is None or table.times is None:
            continue
        first, last = table.times[[0, -1]]
        slack = BEYOND * end
        if first > contact.friction_from + slack or last < end - slack:
            text = (
                f"expected coefficients from {contact.friction_from:g}, from when friction acts, "
                f"to {end:g}, the end of the loading, found times from {first:g} to {last:g}"
            )
            problems.append(complaint(case.source, ("contacts", name, "friction"), text))
    if problems:
        raise CaseError("\n".join(problems))


def coefficients(case: Case, name: str, times: Array) -> Array:
    """(T,) coefficient of a contact that is the same all over its surface.

    Args:
        case: the case.
        name: of the contact.
        times: (T,) at which steps end.
    """
    contact, table = case.contacts[name], varying(case, name)
    value: Any = contact.friction
    if table is not None and table.times is not None:
        value = np.interp(times, table.times, table.values)
    return np.where(times > contact.friction_from, value, 0.0)
