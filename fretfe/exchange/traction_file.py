# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tractions of any program from a CSV file, with the signs of fretfe.

Columns may have the names that finite-element programs give to contact output, which say what the
numbers mean. Names are compared without case, units in brackets, spaces and punctuation.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case.base import SMALLEST
from fretfe.errors import CaseError
from fretfe.loads.csv_file import Table, possible_headers, read_table

# One coordinate along the contact; first and second coordinate of a surface in the plane.
PLACES = {"arc", "arclength", "coord", "truedistancealongpath"}
COORDINATES = {"coor1": "coor2", "coord1": "coord2", "coordcoor1": "coordcoor2"}
# Positive in compression by the manuals of Abaqus and CalculiX (CPRESS) and Ansys (CONT, PRES).
PRESSURES = {"cpress", "contpres", "pres", "contactpressure", "pressure"}
# Of either sign, as the program has it.
NORMAL_STRESSES = {"contactnormalstress", "normalstress", "normaltraction"}
# Along the first direction of a surface; the second one has the other name.
SHEARS = {"cshear1": "cshear2", "taur": "taus"}
# Counted from the start of an analysis (Abaqus, CalculiX), and by Ansys without a sign.
SLIPS = {"cslip1", "slide"}
MAGNITUDES = {"sfric", "contsfri", "frictionalstress"}
# Shear across the plane up to this fraction of that in it is none.
NO_SHEAR = 0.01
# A second coordinate that varies by less than this fraction of the first one is constant.
FLAT = 1e-9


@dataclass(frozen=True)
class Columns:
    """Names of columns that a user gives; None for those to be recognised."""

    x: str | None = None
    p: str | None = None
    q: str | None = None
    slip: str | None = None


@dataclass(frozen=True)
class Recognised:
    """Columns of a file and what they hold.

    Attributes:
        x: place along the contact, or first coordinate.
        y: second coordinate; None if there is none.
        p: pressure.
        q: shear; None without.
        across: shear along the other direction, which must vanish; None without.
        slip: slip; None without.
        sign_known: whether p is known to be positive in compression.
        ordered: whether rows must be in the order of x.
        notes: what was taken for what and why, in words.
    """

    x: str
    y: str | None
    p: str
    q: str | None
    across: str | None
    slip: str | None
    sign_known: bool
    ordered: bool
    notes: tuple[str, ...]


def recognise(path: Path, given: Columns) -> Recognised:
    """Find the columns with place, pressure, shear and slip.

    Args:
        path: CSV file.
        given: names that the user gives.

    Raises:
        CaseError: if several columns could be meant.
    """
    for key, name in vars(given).items():
        if name == "":
            raise CaseError(
                f"{path}: expected the name of a column with --{key}, found an empty one"
            )
    headers = possible_headers(path)
    found = [each for header in headers if (each := _in_header(path, header, given))]
    if found:
        return found[0]
    # Reading the file says what is missing.
    x, p = given.x or "x", given.p or "p"
    return Recognised(x, None, p, given.q, None, given.slip, True, True, ())


def plain(name: str) -> str:
    """A name without case, units in brackets and punctuation."""
    return re.sub(r"[^a-z0-9]", "", re.sub(r"\[.*?\]|\(.*?\)", "", name.lower()))


def _in_header(path: Path, header: Sequence[str], given: Columns) -> Recognised | None:
    names = _Names(path, header)
    x = given.x or names.own("x") or names.one(PLACES | set(COORDINATES), "the place", "--x")
    pressures = PRESSURES | NORMAL_STRESSES
    p = given.p or names.own("p") or names.one(pressures, "the pressure", "--p")
    if x is None or p is None or not {x, p} <= set(header):
        return None
    q = given.q or names.own("q") or names.one(set(SHEARS), "the shear", "--q")
    slip = given.slip or names.own("slip")
    y = None if given.x else names.partner(x, COORDINATES)
    across = None if given.q else names.partner(q, SHEARS)
    return Recognised(
        x, y, p, q, across, slip,
        sign_known=plain(p) not in NORMAL_STRESSES,
        ordered=bool(given.x) or plain(x) == "x",
        notes=tuple(_notes(names, x, y, p, q, slip)),
    )  # fmt: skip


@dataclass(frozen=True)
class _Names:
    """The names in a header."""

    path: Path
    header: Sequence[str]

    def own(self, name: str) -> str | None:
        """The column that has a name of ours, perhaps with a unit."""
        exact = [each for each in self.header if each == name]
        return next(iter(exact or [e for e in self.header if plain(e) == name]), None)

    def one(self, known: set[str], what: str, option: str) -> str | None:
        """The only column with one of the known names.

        Raises:
            CaseError: if there are several.
        """
        found = [each for each in self.header if plain(each) in known]
        if len(found) > 1:
            listed = " and ".join(map(repr, found))
            raise CaseError(
                f"{self.path}: line 1: expected one column with {what}, found {listed}: name it "
                f"with {option}"
            )
        return found[0] if found else None

    def partner(self, name: str | None, pairs: dict[str, str]) -> str | None:
        """The column that belongs to another one."""
        wanted = pairs.get(plain(name)) if name else None
        return next((each for each in self.header if plain(each) == wanted), None)


def _notes(
    names: _Names, x: str, y: str | None, p: str, q: str | None, slip: str | None
) -> list[str]:
    notes = []
    if y is not None:
        notes.append(f"x is the arc length along {x} and {y}")
    elif plain(x) != "x":
        notes.append(f"x is {x}")
    if plain(p) in PRESSURES:
        notes.append(f"p is {p}, positive in compression")
    if q is not None and plain(q) in SHEARS:
        notes.append(
            f"q is {q} with its sign: which surface it acts on and where its direction points is "
            "up to the program, and with it the sign of Q; lengths and K_N do not depend on it"
        )
    if q is None:
        notes += [
            f"{each} is not taken for q: it has no sign, so that Q is unknown (name it with --q)"
            for each in names.header
            if plain(each) in MAGNITUDES
        ]
    if slip is None:
        notes += [
            f"{each} is not taken for the slip: it counts from the start of the analysis, which is "
            "right only if the load has not reversed since (then name it with --slip)"
            for each in names.header
            if plain(each) in SLIPS
        ]
    return notes


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
