# SPDX-License-Identifier: LGPL-3.0-or-later
"""Names that finite-element programs give to contact output, and what their numbers mean.

Names are compared without case, units in brackets, spaces and punctuation.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fretfe.errors import CaseError
from fretfe.loads.csv_file import possible_headers

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
