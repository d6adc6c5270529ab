# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gaps and layers over the surface of a contact, as the files of a case have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.case.base import AXES
from fretfe.case.messages import key_path
from fretfe.errors import CaseError
from fretfe.loads.csv_file import Table, read_table

# Columns with places.
OVER = ("arc", *AXES)


@dataclass(frozen=True)
class OverSurface:
    """Numbers at places of a surface.

    Attributes:
        key: file and key that have them, for messages.
        values: (n, k) numbers.
        arc: (n,) arc lengths along the surface.
        points: (n, d) places.
    """

    key: str
    values: Array
    arc: Array | None = None
    points: Array | None = None


def read_gap(case: Case, name: str) -> OverSurface | None:
    """The gap (n, 1) that a case adds to that of the meshes of a contact, or None.

    Raises:
        CaseError: its file cannot be read, or has other columns than expected.
    """
    given = case.contacts[name].gap
    if given is None:
        return None
    return _read(case, ("contacts", name, "gap"), given, {"gap": case.units.length})


def read_layer(case: Case, name: str) -> OverSurface | None:
    """Approach per pressure and displacement per shear (n, 2) of a layer that varies, or None.

    Raises:
        CaseError: its file cannot be read, or has other columns or numbers than expected.
    """
    layer = case.contacts[name].layer
    if layer is None or layer.csv is None:
        return None
    key = "contacts", name, "layer", "csv"
    unit = f"{case.units.stress}/{case.units.length}"
    found = _read(case, key, layer.csv, {"normal": unit, "tangential": unit}, positive=True)
    return OverSurface(found.key, 1 / found.values, found.arc, found.points)


def _read(
    case: Case, key: tuple[str, ...], file: str, units: Mapping[str, str], *, positive: bool = False
) -> OverSurface:
    """Columns of a file, by name with their units, over arc lengths or places."""
    place = f"{case.source}: {key_path(key)}"
    try:
        table = read_table(case.resolve(file), tuple(units), OVER)
        found = places_in(table)
        table.require_units({**units, **dict.fromkeys(found, case.units.length)})
        for column in units if positive else ():
            if (wrong := np.flatnonzero(table.columns[column] <= 0)).size:
                table.complain(int(wrong[0]), column, "a stiffness > 0")
        if found == ("arc",):
            table.require_increasing("arc", "value")
    except CaseError as error:
        raise CaseError(f"{place}: {error}") from None
    values, places = (
        np.column_stack([table.columns[each] for each in names]) for names in (units, found)
    )
    if found == ("arc",):
        require_whole(case, place)
        return OverSurface(place, values, arc=places[:, 0])
    return OverSurface(place, values, points=places)


def places_in(table: Table, other: Sequence[str] = ()) -> tuple[str, ...]:
    """Columns that say where numbers of a table hold: arc, coordinates, or another one alone.

    Raises:
        CaseError: there are none of these, or several.
    """
    alone = (*other, "arc")
    found = tuple(each for each in (*other, *OVER) if each in table.columns)
    if found not in (*((each,) for each in alone), AXES[:2], AXES):
        expected = f"{', '.join(f'a column {each}' for each in alone)}, or columns x and y (and z)"
        there = " and ".join(found) or "none"
        raise CaseError(f"{table.path}: expected {expected}, found {there}")
    return found


def require_whole(case: Case, place: str) -> None:
    """Check that arc lengths mean something: not in a part of the bodies.

    Args:
        case: of the bodies.
        place: file and key that have them.

    Raises:
        CaseError: if they do not.
    """
    if case.geometry.part is not None:
        raise CaseError(
            f"{place}: expected places x and y in a part of the bodies, whose surfaces have other "
            "arc lengths, found arc lengths"
        )
