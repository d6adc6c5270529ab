# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces of solids that overlap or look away are refused, and no others."""

from __future__ import annotations

import numpy as np
import pytest
from cases import blocks

from fretfe._typing import Array
from fretfe.case import Case, Solid, parse_case
from fretfe.errors import MeshError
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh
from fretfe.surface.checks import check_contacts


def case(first: str = "upper_bottom", second: str = "lower_top") -> Case:
    steel = {"young": 2e5, "poisson": 0.3}
    contact = {"surface1": first, "surface2": second, "friction": 0.3}
    bodies = {"upper": steel, "lower": steel}
    data = {"geometry": {"file": "m.msh"}, "bodies": bodies, "contacts": {"main": contact}}
    return parse_case(data)


def solids(x: float = 0.0, y: float = 0.0) -> Mesh:
    """The upper block, moved by (x, y), above the wider lower one; both 1 deep."""

    def moved(points: Array) -> Array:
        return points + np.array([x, y])

    upper = blocks.block("upper", *[np.linspace(0, 1, 5)] * 2, cell="triangle", mapping=moved)
    lower = blocks.block("lower", np.linspace(-0.5, 1.5, 9), np.linspace(-1, 0, 5), cell="triangle")
    plane = Mesh({"upper": upper, "lower": lower})
    return extrude(plane, Solid(length=1.0, skew=0.0, layers=3))


# The last one: less than 1 % of the size of a facet, which the mesh does not resolve.
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.0, 0.3), (0.7, 0.0), (0.0, -0.0018)])
@pytest.mark.parametrize("names", [("upper_bottom", "lower_top"), ("lower_top", "upper_bottom")])
def test_surfaces_that_can_close(place: tuple[float, float], names: tuple[str, str]) -> None:
    check_contacts(solids(*place), case(*names))


@pytest.mark.parametrize("names", [("upper_bottom", "lower_top"), ("lower_top", "upper_bottom")])
def test_overlap_is_told_with_amount_and_place(names: tuple[str, str]) -> None:
    message = r"contacts\.main.* by up to 0\.0125 mm at \(.*\), over an area of 1 mm²; expected"
    with pytest.raises(MeshError, match=message):
        check_contacts(solids(y=-0.0125), case(*names))


@pytest.mark.parametrize(
    ("mesh", "names", "message"),
    [
        pytest.param(
            solids(),
            ("upper_top", "lower_top"),
            r"face the wrong way: where they are nearest, 1 mm apart.*\(0, 1, 0\) and \(0, 1, 0\)",
            id="back",
        ),
        pytest.param(
            solids(y=5.0),
            ("upper_bottom", "lower_top"),
            r"too far apart: nearest 5 mm apart.* less than 0\.5 mm, half the root of the area of",
            id="far",
        ),
        pytest.param(
            solids(x=1.6, y=0.1), ("upper_bottom", "lower_top"), "pass by each other", id="beside"
        ),
    ],
)
def test_surfaces_that_cannot_meet(mesh: Mesh, names: tuple[str, str], message: str) -> None:
    with pytest.raises(MeshError, match=message):
        check_contacts(mesh, case(*names))
