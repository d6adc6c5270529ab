# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gaps and layers over the surface of a contact, as the files of a case have them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.case.base import AXES
from fretfe.case.messages import key_path
from fretfe.errors import CaseError
from fretfe.loads.csv_file import Table, read_table


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
    return None if given is None else _read(case, ("contacts", name, "gap"), given, ("gap",))


def read_layer(case: Case, name: str) -> OverSurface | None:
    """Approach per pressure and displacement per shear (n, 2) of a layer that varies, or None.

    Raises:
        CaseError: its file cannot be read, or has other columns or numbers than expected.
    """
    layer = case.contacts[name].layer
    if layer is None or layer.csv is None:
        return None
    key, columns = ("contacts", name, "layer", "csv"), ("normal", "tangential")

    def require_stiffness(table: Table) -> None:
        for column in columns:
            if (wrong := np.flatnonzero(table.columns[column] <= 0)).size:
                table.complain(int(wrong[0]), column, "a stiffness > 0")

    found = _read(case, key, layer.csv, columns, require_stiffness)
    return OverSurface(found.key, 1 / found.values, found.arc, found.points)


def _read(
    case: Case,
    key: tuple[str, ...],
    file: str,
    columns: Sequence[str],
    check: Callable[[Table], None] = lambda _: None,
) -> OverSurface:
    path, over = case.resolve(file), ("arc", *AXES)
    place = f"{case.source}: {key_path(key)}"
    try:
        table = read_table(path, columns, over)
        found = tuple(each for each in over if each in table.columns)
        if found not in (("arc",), AXES[:2], AXES):
            expected = "a column arc, or columns x and y (and z)"
            raise CaseError(f"{path}: expected {expected}, found {' and '.join(found) or 'none'}")
        if found == ("arc",):
            table.require_increasing("arc", "value")
            require_whole(case)
        stiffness = dict.fromkeys(columns, f"{case.units.stress}/{case.units.length}")
        length = dict.fromkeys((*over, "gap"), case.units.length)
        table.require_units(stiffness | length)
        check(table)
    except CaseError as error:
        raise CaseError(f"{place}: {error}") from None
    values = np.column_stack([table.columns[each] for each in columns])
    places = np.column_stack([table.columns[each] for each in found])
    if found == ("arc",):
        return OverSurface(place, values, arc=places[:, 0])
    return OverSurface(place, values, points=places)


def require_whole(case: Case) -> None:
    """Check that arc lengths mean something: not in a part of the bodies.

    Raises:
        CaseError: if they do not.
    """
    if case.geometry.part is not None:
        raise CaseError(
            "expected places x and y in a part of the bodies, whose surfaces have other arc "
            "lengths, found arc lengths"
        )
