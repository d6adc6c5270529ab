# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a case says about directions, against the dimension of its mesh."""

from __future__ import annotations

from collections.abc import Iterator

from fretfe.case.base import AXES
from fretfe.case.channels import RotationLoad
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
        if isinstance(load, RotationLoad) and (
            len(load.axis) != 3 or (dimension == 2 and (load.axis[0], load.axis[1]) != (0, 0))
        ):
            expected = "[0, 0, 1] or [0, 0, -1]" if dimension == 2 else "3 components"
            yield Problem(("loads", name, "axis"), f"expected {expected}, found {list(load.axis)}")


def _directions(case: Case) -> Iterator[tuple[Key, str | tuple[float, ...]]]:
    for name, support in case.supports.items():
        yield from ((("supports", name, "fix", i), axis) for i, axis in enumerate(support.fix))
    for name, load in case.loads.items():
        if isinstance(load, RotationLoad):
            yield ("loads", name, "centre"), load.centre
        else:
            yield ("loads", name, "direction"), load.direction
