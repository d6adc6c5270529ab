# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks of the directions in a case against the dimension of its mesh."""

from __future__ import annotations

from collections.abc import Iterator

from fretfe.case.base import AXES
from fretfe.case.channels import RotationLoad, TiltLoad
from fretfe.case.checks import Key, Problem
from fretfe.case.messages import complaint
from fretfe.case.model import Case
from fretfe.errors import CaseError

# Added to a complaint about a direction.
PLANE = "; the mesh is plane, and [geometry.solid] would extrude it"
SOLID = "; the bodies are solid"


def check_dimension(case: Case, dimension: int) -> None:
    """Check that every direction of the case exists in the space of the mesh.

    Args:
        case: the case.
        dimension: number of coordinates of the mesh, 2 or 3.

    Raises:
        CaseError: an axis or a vector does not fit; all of them are listed.
    """
    lines = [complaint(case.source, *problem) for problem in _misfits(case, dimension)]
    if lines:
        raise CaseError("\n".join(lines))


def _misfits(case: Case, dimension: int) -> Iterator[Problem]:
    if dimension == 3:
        yield from _plane_only(case)
    for key, direction in _directions(case):
        axes = AXES[:dimension]
        if isinstance(direction, str):
            if direction in AXES and direction not in axes:
                expected = " or ".join(map(repr, axes))
                text = f"expected {expected} on this mesh, found {direction!r}{PLANE}"
                yield Problem(key, text)
        elif len(direction) != dimension:
            text = f"expected {dimension} components on this mesh, found {len(direction)}"
            yield Problem(key, text + (PLANE if dimension == 2 else SOLID))
    for name, load in case.loads.items():
        if isinstance(load, RotationLoad | TiltLoad) and not _is_axis(load.axis, dimension):
            expected = "[0, 0, 1] or [0, 0, -1]" if dimension == 2 else "3 components"
            found = repr(load.axis) if isinstance(load.axis, str) else str(list(load.axis))
            yield Problem(("loads", name, "axis"), f"expected {expected}, found {found}")


def _plane_only(case: Case) -> Iterator[Problem]:
    """Keys that mean nothing, or nothing yet, on a mesh of solids."""
    if case.model.plane != "strain":
        yield Problem(("model", "plane"), "expected no plane state on a mesh of solids")
    if case.model.thickness != 1:
        found = f"{case.model.thickness:g}"
        yield Problem(("model", "thickness"), f"expected 1 on a mesh of solids, found {found}")
    if case.edges.tolerance is not None:
        yield Problem(
            ("edges", "tolerance"),
            "expected a plane mesh, because a mesh of solids cannot be refined here; leave the "
            "tolerance out and set the element sizes of the geometry",
        )


def _is_axis(axis: str | tuple[float, ...], dimension: int) -> bool:
    """True if bodies can turn about an axis: in the plane about z only."""
    if isinstance(axis, str):
        return dimension == 3 or axis == "z"
    return len(axis) == 3 and (dimension == 3 or axis[:2] == (0, 0))


def _directions(case: Case) -> Iterator[tuple[Key, str | tuple[float, ...]]]:
    for name, support in case.supports.items():
        yield from ((("supports", name, "fix", i), axis) for i, axis in enumerate(support.fix))
        if support.direction is not None:
            yield ("supports", name, "direction"), support.direction
    for name, load in case.loads.items():
        if isinstance(load, RotationLoad | TiltLoad):
            yield ("loads", name, "centre"), load.centre
        else:
            yield ("loads", name, "direction"), load.direction
