# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tractions of any program from a CSV file, with the signs of fretfe.

Of two or three coordinates the place along the contact is the arc length.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case.base import SMALLEST
from fretfe.case.messages import shortened
from fretfe.errors import CaseError
from fretfe.exchange.traction_columns import Columns, Recognised, plain, recognise
from fretfe.exchange.traction_path import order_along
from fretfe.loads.csv_file import Table, read_table, read_texts

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


def read_tractions(path: Path, columns: Columns, compression: str | None = None) -> TractionTable:
    """Read tractions of one state.

    Args:
        path: CSV file with a header.
        columns: names that the user gives.
        compression: "positive" or "negative", the sign of a pressure in the file; None if its name
            says that.

    Raises:
        CaseError: if the file is not as expected, or a sign is not known.
    """
    known = recognise(path, columns)
    _require_one_use(path, known)
    names = (known.x, *known.others, known.p, known.q, known.slip, known.across)
    table = read_table(path, [*dict.fromkeys(name for name in names if name)])
    _require_one_owner(path, known)
    pressure, sign_notes = _pressure(path, known, table, compression)
    place = _place(path, known, table, pressure)
    _require_no_shear_across(path, known, table)

    def column(name: str | None) -> Array | None:
        return None if name is None else table.columns[name][place.order]

    used = {"x": known.x, "p": known.p, "q": known.q, "slip": known.slip}
    used |= dict(zip(("y", "z"), place.others, strict=False))
    units = [f"the row of units is {', '.join(table.units)}: nothing is converted"]
    return TractionTable(
        x=place.x,
        p=pressure[place.order],
        q=column(known.q),
        slip=column(known.slip),
        columns={key: name for key, name in used.items() if name is not None},
        notes=(*place.notes, *known.notes, *sign_notes, *(units if table.units else ())),
    )


def _require_one_use(path: Path, known: Recognised) -> None:
    """No column is two things."""
    used: dict[str, str] = {}
    each = (("x", known.x), ("p", known.p), ("q", known.q), ("slip", known.slip))
    for key, name in (*each, *((f"coordinate {name}", name) for name in known.others)):
        if name in used:
            raise CaseError(
                f"{path}: column {name!r}: expected one quantity in it, found it taken for "
                f"{used[name]} and for {key}"
            )
        if name is not None:
            used[name] = key


def _require_one_owner(path: Path, known: Recognised) -> None:
    """Rows of the two surfaces of a contact lie on one line, but are no tractions along it."""
    if known.owner is None:
        return
    found = dict.fromkeys(read_texts(path, known.owner, (known.x, known.p)))
    if len(found) > 1:
        raise CaseError(
            f"{path}: column {known.owner!r}: expected rows of one body or surface, found "
            f"{', '.join(map(shortened, found))}: leave those of one"
        )


def _pressure(
    path: Path, known: Recognised, table: Table, compression: str | None
) -> tuple[Array, list[str]]:
    values = table.columns[known.p]
    place = f"{path}: column {known.p!r}"
    if compression is None and not known.sign_known:
        raise CaseError(
            f"{place}: expected a pressure, found a normal stress whose sign is not known: state "
            "it with --compression positive or --compression negative"
        )
    pressure = -values if compression == "negative" else values
    if len(values) < 2 or pressure.max() <= max(0.0, -pressure.min()):
        raise CaseError(
            f"{place}: expected a positive pressure in two rows or more, found "
            f"{pressure.min():g} to {pressure.max():g} in {len(values)} (is compression negative "
            "in this file? then state it with --compression negative)"
        )
    notes = [f"p is {known.p}, {compression} in compression as stated"] if compression else []
    return pressure, notes


@dataclass(frozen=True)
class _Place:
    """Places along the contact.

    Attributes:
        order: (n,) of the rows along the contact.
        x: (n,) increasing.
        others: further coordinates that count.
        notes: how the place was found, in words.
    """

    order: Indices
    x: Array
    others: tuple[str, ...]
    notes: tuple[str, ...]


def _place(path: Path, known: Recognised, table: Table, pressure: Array) -> _Place:
    """The rows along the contact; programs list nodes by their numbers."""
    names = (known.x, *known.others)
    extents = [np.ptp(table.columns[name]) for name in names]
    varied = tuple(
        name for name, extent in zip(names, extents, strict=True) if extent > FLAT * max(extents)
    )
    if not known.others or varied in ((), (known.x,)):
        return _along_one(path, known, table)
    points = np.column_stack([table.columns[name] for name in varied])
    listed = f"{', '.join(varied[:-1])} and {varied[-1]}" if len(varied) > 1 else varied[0]
    _, first, count = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    if (again := np.flatnonzero(count[first.ravel()] > 1)).size:
        table.complain(int(again[-1]), varied[0], "a place that no other row has")
    try:
        order = order_along(points, pressure)
    except CaseError as error:
        raise CaseError(
            f"{path}: columns {listed}: {error}: give the rows of one line, or the arc length and "
            "name its column with --x"
        ) from None
    steps = np.linalg.norm(np.diff(points[order], axis=0), axis=1)
    x = table.columns[varied[0]][order[0]] + np.append(0.0, np.cumsum(steps))
    _require_extent(path, listed, x)
    notes = [f"x is the arc length along {listed}"]
    if (order != np.arange(len(order))).any():
        notes.append("rows are taken in the order of their places along the line")
    return _Place(order, x, tuple(name for name in varied if name != known.x), tuple(notes))


def _along_one(path: Path, known: Recognised, table: Table) -> _Place:
    """Rows in the order of one coordinate."""
    x, notes = table.columns[known.x], [] if plain(known.x) == "x" else [f"x is {known.x}"]
    rows = np.arange(len(x))
    if known.ordered:
        table.require_increasing(known.x, "position")
        order = rows
    else:
        order = np.argsort(x, kind="stable")
        if (order != rows).any():
            notes.append(f"rows are taken in the order of {known.x}")
    if (np.diff(x[order]) <= 0).any():
        row = int(np.flatnonzero(np.diff(x[order]) <= 0)[0]) + 1
        table.complain(int(order[row]), known.x, "a place that no other row has")
    _require_extent(path, known.x, x[order])
    return _Place(order, x[order], (), tuple(notes))


def _require_extent(path: Path, name: str, x: Array) -> None:
    if x[-1] - x[0] < SMALLEST:
        raise CaseError(
            f"{path}: column {name!r}: expected positions over {SMALLEST:g} or more, found "
            f"{x[-1] - x[0]:g}"
        )


def _require_no_shear_across(path: Path, known: Recognised, table: Table) -> None:
    if known.across is None or known.q is None:
        return
    across, along = (np.abs(table.columns[each]).max() for each in (known.across, known.q))
    if across > NO_SHEAR * along:
        raise CaseError(
            f"{path}: column {known.across!r}: expected no shear beside that of {known.q!r} in a "
            f"plane problem, found {across:g} at most beside {along:g}: name the one with --q"
        )
