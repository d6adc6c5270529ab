# SPDX-License-Identifier: LGPL-3.0-or-later
"""Place and size of a part of a solved case, and whether the run tells enough for it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import CaseError, OutputError
from fretfe.loads import build_history, told_states
from fretfe.mesh.part import seen
from fretfe.quality.global_run import pressed_nodes
from fretfe.results.field_files import DISPLACEMENTS, FIELDS, FieldReader
from fretfe.results.front_ends import FrontEnd, free_ends
from fretfe.results.model import Result

# Times closer than this, relative to the last one, are the same.
SAME_TIME = 1e-9


def driving_states(result: Result) -> Indices:
    """(n,) states of a run that drive a part: all but those of added cycles on the way."""
    end = float(build_history(result.case).times[-1])
    written = np.searchsorted(result.loads.times, end * (1 + SAME_TIME), side="right") - 1
    return told_states(result.loads, int(written))


def require_fields(result: Result) -> Path:
    """The folder of a result, or a file in it, with displacements of all states that drive a part.

    Raises:
        OutputError: says what is missing.
    """
    where = result.directory
    if result.failure is not None or where is None:
        found = result.failure or "none that were written"
        raise OutputError(
            f"{where or result.case.source}: expected complete results, found {found}"
        )
    remedy = 'run the case with [output] fields = "all"'
    if (own := where / DISPLACEMENTS).is_file():
        return own
    if not (where / FIELDS).is_file():
        raise OutputError(
            f"{where}: expected the displacements of the run ({FIELDS}), found none: {remedy}"
        )
    times = FieldReader(where / FIELDS).times
    wanted = result.loads.times[driving_states(result)]
    near = SAME_TIME * float(wanted[-1])
    missing = [time for time in wanted if not (np.abs(times - time) <= near).any()]
    if missing:
        raise OutputError(
            f"{where / FIELDS}: expected the displacements of all {len(wanted)} states, found none "
            f"of {len(missing)} of them, the first at {missing[0]:g}: {remedy}"
        )
    return where


def _pressed(result: Result, name: str) -> Array:
    """(n, d) nodes of a contact that are under pressure in some state."""
    history = result.contact_history(name)
    return history.surface.points[pressed_nodes([history])]


def place_of(result: Result, around: str, end: FrontEnd | None) -> tuple[str, tuple[float, ...]]:
    """Name of a contact, and the middle of what of it was ever pressed, or a place at its edge.

    Args:
        result: of the whole.
        around: the contact, or one of its edges or stations.
        end: the free end that is meant; None for anything else.

    Raises:
        CaseError: if there is no such place, or a free end of bodies that are not extruded.
    """
    case = result.case
    solid = case.geometry.solid is not None
    if around in [each.name for each in result.contacts]:
        points = _pressed(result, around)
        if not len(points):
            raise CaseError(f"{result.directory}: expected a contact that carries a force, found "
                            f"that {around!r} never does")  # fmt: skip
        points = seen(case, points, 2 if solid else points.shape[1])
        centre = (points.min(axis=0) + points.max(axis=0)) / 2
        return around, _rounded(centre, float(np.ptp(points, axis=0).max()))
    if end is not None:
        if not solid:
            raise CaseError(f"--around: expected the end of extruded bodies, found {around!r} of "
                            "bodies whose elements have no layers")  # fmt: skip
        contact, point = end.contact, end.point
    else:
        try:
            contact, _, station = result.find(around)
        except CaseError as error:
            ends = ", ".join(each.name for each in free_ends(result))
            raise CaseError(f"{error}{f'; free ends: {ends}' if ends else ''}") from None
        point = station.point[: 3 if contact.solid else 2]
    size = float(np.ptp(_pressed(result, contact.name), axis=0).max())
    return contact.name, _rounded(point, size)


def _rounded(place: Array, size: float) -> tuple[float, ...]:
    """Coordinates of a place with as many digits as a length needs that is known to a millionth."""
    digits = 6 - math.floor(math.log10(size))
    return tuple(round(float(each), digits) + 0.0 for each in place)


def reach_of(result: Result, name: str, centre: tuple[float, ...]) -> float:
    """Distance from a place of the farthest node of a contact that was ever pressed."""
    points = seen(result.case, _pressed(result, name), len(centre))
    return float(np.linalg.norm(points - np.array(centre), axis=1).max())


def require_one_contact(
    result: Result, name: str, centre: tuple[float, ...], radius: float
) -> None:
    """Check that no other contact presses within the part: there the cut would open it.

    Raises:
        CaseError: with the largest radius that there may be.
    """
    for other in result.solution.contacts:
        if other.pair == result.contact_history(name).pair:
            continue
        points = _pressed(result, other.name)
        if not len(points):
            continue
        away = np.linalg.norm(seen(result.case, points, len(centre)) - np.array(centre), axis=1)
        if away.min() <= radius:
            raise CaseError(
                f"--radius: expected less than {away.min():.4g}, where contact {other.name!r} "
                f"presses (a part has one contact), found {radius:.4g}"
            )
