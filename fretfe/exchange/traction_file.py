# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tractions of any program from a CSV file, with the signs of fretfe."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case.base import SMALLEST
from fretfe.errors import CaseError
from fretfe.exchange.column_names import Columns, Recognised, recognise
from fretfe.exchange.sign import Sign
from fretfe.loads.csv_file import Table, read_table

# Shear across the plane up to this fraction of that in it is none.
NO_SHEAR = 0.01
# A second coordinate that varies by less than this fraction of the first one is constant.
FLAT = 1e-9


@dataclass(frozen=True)
class TractionTable:
    """Tractions along a contact.

    Attributes:
        x: (n,) places along the contact, increasing.
        p: (n,) pressure, positive.
        q, slip: (n,) shear and slip; None without.
        columns: names in the file, by ``x``, ``y``, ``p``, ``q`` and ``slip``.
        notes: what was taken for what, in words.
    """

    x: Array
    p: Array
    q: Array | None
    slip: Array | None
    columns: dict[str, str]
    notes: tuple[str, ...]


def read_tractions(path: Path, columns: Columns, compression: Sign | None = None) -> TractionTable:
    """Read tractions of one state.

    Args:
        path: CSV file with a header.
        columns: names that the user gives.
        compression: sign of a pressure in the file; None if it is positive by its name.

    Raises:
        CaseError: if the file is not as expected, or a sign is not known.
    """
    known = recognise(path, columns)
    _require_one_use(path, known)
    needed = [known.x, known.p, *(each for each in (known.y, known.q, known.slip) if each)]
    table = read_table(path, [*dict.fromkeys(needed), *([known.across] if known.across else [])])
    pressure, sign_notes = _pressure(path, known, table, compression)
    order, order_notes = _order(known, table)
    _require_no_shear_across(path, known, table)

    def column(name: str | None) -> Array | None:
        return None if name is None else table.columns[name][order]

    used = {"x": known.x, "y": known.y, "p": known.p, "q": known.q, "slip": known.slip}
    return TractionTable(
        x=_places(path, known, table, order),
        p=pressure[order],
        q=column(known.q),
        slip=column(known.slip),
        columns={key: name for key, name in used.items() if name is not None},
        notes=(*known.notes, *sign_notes, *order_notes),
    )


def _require_one_use(path: Path, known: Recognised) -> None:
    """No column is two things."""
    used: dict[str, str] = {}
    for key in ("x", "y", "p", "q", "slip"):
        name = getattr(known, key)
        if name in used:
            raise CaseError(
                f"{path}: column {name!r}: expected one quantity in it, found it taken for "
                f"{used[name]} and for {key}"
            )
        if name is not None:
            used[name] = key


def _pressure(
    path: Path, known: Recognised, table: Table, compression: Sign | None
) -> tuple[Array, list[str]]:
    values = table.columns[known.p]
    place = f"{path}: column {known.p!r}"
    if compression is None and not known.sign_known:
        raise CaseError(
            f"{place}: expected a pressure, found a normal stress whose sign is not known: state "
            "it with --compression positive or --compression negative"
        )
    pressure = -values if compression == Sign.NEGATIVE else values
    if len(values) < 2 or pressure.max() <= max(0.0, -pressure.min()):
        raise CaseError(
            f"{place}: expected a positive pressure in two rows or more, found "
            f"{pressure.min():g} to {pressure.max():g} in {len(values)} (is compression negative "
            "in this file? then state it with --compression negative)"
        )
    notes = [f"p is {known.p}, {compression} in compression as stated"] if compression else []
    return pressure, notes


def _order(known: Recognised, table: Table) -> tuple[Indices, list[str]]:
    """(n,) order of the rows along the contact; programs list nodes by their numbers."""
    x = table.columns[known.x]
    rows = np.arange(len(x))
    if known.ordered:
        table.require_increasing(known.x, "position")
        return rows, []
    along = known.x
    if known.y is not None and np.ptp(table.columns[known.y]) > np.ptp(x):
        along = known.y
    order = np.argsort(table.columns[along], kind="stable")
    if bool((order == rows).all()):
        return rows, []
    return order, [f"rows are taken in the order of {along}"]


def _places(path: Path, known: Recognised, table: Table, order: Indices) -> Array:
    """(n,) places along the contact, from the first coordinate of the first row on."""
    x = table.columns[known.x][order]
    if known.y is not None:
        y = table.columns[known.y][order]
        if np.ptp(y) > FLAT * np.ptp(x):
            x = x[0] + np.append(0.0, np.cumsum(np.hypot(np.diff(x), np.diff(y))))
    if (np.diff(x) <= 0).any():
        row = int(np.flatnonzero(np.diff(x) <= 0)[0]) + 1
        table.complain(int(order[row]), known.x, "a place that no other row has")
    if x[-1] - x[0] < SMALLEST:
        raise CaseError(
            f"{path}: column {known.x!r}: expected positions over {SMALLEST:g} or more, found "
            f"{x[-1] - x[0]:g}"
        )
    return np.asarray(x)


def _require_no_shear_across(path: Path, known: Recognised, table: Table) -> None:
    if known.across is None or known.q is None:
        return
    across, along = (np.abs(table.columns[each]).max() for each in (known.across, known.q))
    if across > NO_SHEAR * along:
        raise CaseError(
            f"{path}: column {known.across!r}: expected no shear beside that of {known.q!r} in a "
            f"plane problem, found {across:g} at most beside {along:g}: name the one with --q"
        )
