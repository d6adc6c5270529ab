# SPDX-License-Identifier: LGPL-3.0-or-later
"""Columns of tractions by the names that finite-element programs give to contact output.

The names say what the numbers mean. They are compared without case, units, spaces and punctuation,
names of paths and surfaces.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from fretfe.errors import CaseError
from fretfe.loads.csv_file import is_unit, possible_headers

# The place along the contact; and its coordinates, as Abaqus, Ansys, MOOSE and ParaView call them.
PLACES = {"arc", "arclength", "coord", "truedistancealongpath"}
COORDINATES = (
    *(tuple(f"{name}{axis}" for axis in "123") for name in ("coor", "coord", "coordcoor")),
    *(
        tuple(f"{axis}{name}" for axis in "xyz")
        for name in ("", "location", "coordinate", "coord", "coor", "position")
    ),
    *(
        tuple(f"{name}{axis}" for axis in axes)
        for name in ("points", "coordinates", "coords")
        for axes in ("012", "xyz")
    ),
)
# Columns that tell the rows of one body or surface from those of others.
OWNERS = {"instance", "instancename", "partinstance", "partinstancename", "surface", "surfacename"}
# Names of Abaqus that those of surfaces may follow.
FOLLOWED = {"cpress", "cshear1", "cshear2", "cslip1", "cslip2"}
# Positive in compression by the manuals of Abaqus and CalculiX (CPRESS) and Ansys (CONT, PRES).
PRESSURES = {"cpress", "contpres", "pres", "contactpressure", "pressure"}
# Of either sign, as the program has it.
NORMAL_STRESSES = {"contactnormalstress", "normalstress", "normaltraction"}
# Along the first direction of a surface; the second one has the other name.
SHEARS = {"cshear1": "cshear2", "taur": "taus"}
# Counted from the start of an analysis (Abaqus, CalculiX), and by Ansys without a sign.
SLIPS = {"cslip1", "slide"}
MAGNITUDES = {"sfric", "contsfri", "frictionalstress"}


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
        others: second and third coordinates, if there are any.
        p: pressure.
        q: shear; None without.
        across: shear along the other direction, which must vanish; None without.
        slip: slip; None without.
        sign_known: whether p is known to be positive in compression.
        ordered: whether rows must be in the order of x.
        notes: what was taken for what and why, in words.
        owner: names of bodies or surfaces; None without.
    """

    x: str
    others: tuple[str, ...]
    p: str
    q: str | None
    across: str | None
    slip: str | None
    sign_known: bool
    ordered: bool
    notes: tuple[str, ...]
    owner: str | None = None


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
    _refuse_header(path, headers, given)


def _refuse_header(path: Path, headers: Sequence[Sequence[str]], given: Columns) -> NoReturn:
    """Say which column is missing, and how it could be called."""
    # Spaces stand within names, too.
    header = max(headers[:-1] or headers, key=len)
    names = _Names(path, header)
    place = given.x in header if given.x else any(names.places())
    option = "p" if place else "x"
    known = (
        f"{', '.join(sorted(PRESSURES | NORMAL_STRESSES))}"
        if place
        else ("x and y, arc length, COORD, COOR1, X Location, Points_0 and the like")
    )
    named = vars(given)[option]
    hint = "" if named else f"; names that are known: {known}; name another one with --{option}"
    raise CaseError(
        f"{path}: line 1: expected one column {named or option!r}, found "
        f"{', '.join(map(repr, header))}{hint}"
    )


def plain(name: str) -> str:
    """A name without case, units, names of paths in quotes, surfaces and punctuation."""
    return _parts(name)[0]


def _parts(name: str) -> tuple[str, str]:
    """The variable in a column, and the surfaces or the like that its name ends with."""
    text = re.sub(r"\[.*?\]|\(.*?\)|'.*?'", "", name.lower()).strip()
    head, *rest = text.split(maxsplit=1)[:2] or [""]
    if _bare(head) in FOLLOWED and rest:
        return _bare(head), rest[0]
    # as in "x_mm", "p / MPa"
    first, _, last = re.sub(r"[\s_/,]+", " ", text).rpartition(" ")
    unit = len(last) > 1 and is_unit(last) and not last.isdigit()
    return _bare(first.removesuffix(" in") if first and unit else text), ""


def _bare(text: str) -> str:
    return re.sub(r"[^a-z0-9]", "", text)


def _in_header(path: Path, header: Sequence[str], given: Columns) -> Recognised | None:
    names = _Names(path, header)
    places = [given.x] if given.x else names.places()
    p = given.p or names.own("p") or names.one(PRESSURES | NORMAL_STRESSES, "the pressure", "--p")
    if not places or p is None or not {places[0], p} <= set(header):
        return None
    x, *others = places
    surfaces = _parts(p)[1]
    q = given.q or names.own("q") or names.one(set(SHEARS), "the shear", "--q", surfaces)
    slip = given.slip or names.own("slip")
    across = (
        None if given.q or not q else names.one({SHEARS.get(plain(q), "")}, "it", "--q", surfaces)
    )
    return Recognised(
        x, tuple(others), p, q, across, slip,
        sign_known=plain(p) not in NORMAL_STRESSES,
        ordered=bool(given.x) or (plain(x) == "x" and not others),
        notes=tuple(_notes(names, p, q, slip)),
        owner=next((each for each in header if plain(each) in OWNERS), None),
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

    def places(self) -> list[str]:
        """The column with the place along the contact, or those with its coordinates.

        Raises:
            CaseError: if several could be meant.
        """
        found = []
        for family in COORDINATES:
            columns = [each for each in map(self.own, family) if each is not None]
            if columns and plain(columns[0]) == family[0]:
                found.append(columns)
        if (arc := self.one(PLACES, "the place", "--x")) and all(
            len(columns) > 1 for columns in found
        ):
            return [arc]
        if (own := self.own("x")) and [own] in found:
            return [own]
        firsts = [*([arc] if arc else []), *(columns[0] for columns in found)]
        if len(firsts) > 1:
            self._refuse(firsts, "the place", "--x")
        return found[0] if found else []

    def one(self, known: set[str], what: str, option: str, surfaces: str = "") -> str | None:
        """The only column with one of the known names, of some surfaces if there are several.

        Raises:
            CaseError: if there are several.
        """
        found = [each for each in self.header if plain(each) in known]
        found = [each for each in found if _parts(each)[1] == surfaces] or found
        if len(found) > 1:
            self._refuse(found, what, option)
        return found[0] if found else None

    def _refuse(self, found: Sequence[str], what: str, option: str) -> NoReturn:
        listed = " and ".join(map(repr, found))
        raise CaseError(
            f"{self.path}: line 1: expected one column with {what}, found {listed}: name it "
            f"with {option}"
        )


def _notes(names: _Names, p: str, q: str | None, slip: str | None) -> list[str]:
    notes = []
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
