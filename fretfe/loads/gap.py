# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gap that a case adds between the surfaces of a contact, as its file has it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.case.base import AXES
from fretfe.case.messages import key_path
from fretfe.errors import CaseError
from fretfe.loads.csv_file import read_table


@dataclass(frozen=True)
class GivenGap:
    """Gap that is added to that of the meshes; smooth between the places of its values.

    Attributes:
        key: file and key that have it, for messages.
        values: (n,) distances of the surfaces where the meshes touch.
        arc: (n,) arc lengths along the surface.
        points: (n, d) places.
    """

    key: str
    values: Array
    arc: Array | None = None
    points: Array | None = None


def read_gap(case: Case, name: str) -> GivenGap | None:
    """The gap that a case gives for a contact, or None.

    Raises:
        CaseError: its file cannot be read, or has other columns than expected.
    """
    given = case.contacts[name].gap
    if given is None:
        return None
    path, over = case.resolve(given), ("arc", *AXES)
    place = f"{case.source}: {key_path(('contacts', name, 'gap'))}"
    try:
        table = read_table(path, ("gap",), over)
        found = tuple(each for each in over if each in table.columns)
        if found not in (("arc",), AXES[:2], AXES):
            expected = "a column arc, or columns x and y (and z)"
            raise CaseError(f"{path}: expected {expected}, found {' and '.join(found) or 'none'}")
        if found == ("arc",):
            table.require_increasing("arc", "value")
    except CaseError as error:
        raise CaseError(f"{place}: {error}") from None
    values, places = table.columns["gap"], [table.columns[each] for each in found]
    if found == ("arc",):
        return GivenGap(place, values, arc=places[0])
    return GivenGap(place, values, points=np.column_stack(places))
