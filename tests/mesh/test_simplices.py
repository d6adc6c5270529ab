# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies of several shapes are divided so that neighbours fit, whatever their nodes are called."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe._typing import Array, Indices
from fretfe.errors import MeshError
from fretfe.mesh import simplices
from fretfe.mesh.elements import (
    CORNERS,
    MIDDLES,
    directed_facets,
    exterior_facets,
    jacobian_determinants,
)
from fretfe.mesh.gmsh import ElementBlock, RawMesh
from fretfe.mesh.split import mesh_from_raw

RANDOM = np.random.default_rng(3)
TYPES = {
    1: {"tetrahedron": 4, "hexahedron": 5, "prism": 6, "pyramid": 7},
    2: {"tetrahedron": 11, "hexahedron": 12, "prism": 13, "pyramid": 14},
}
# Gmsh types of faces by their number of nodes.
FACES = {3: 2, 4: 3, 6: 9, 9: 10}
# Corners of a cube: as one hexahedron, two prisms, or six pyramids around the middle.
CUBE = (0, 1, 2, 3, 4, 5, 6, 7)
PRISMS = ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))
PYRAMIDS = (
    *((0, 1, 2, 3, 8), (4, 7, 6, 5, 8), (0, 4, 5, 1, 8)),
    *((1, 5, 6, 2, 8), (2, 6, 7, 3, 8), (3, 7, 4, 0, 8)),
)
PLACES = np.array(
    [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))] + [[0.5] * 3]
)


class Nodes:
    """Numbers of places, given in a random order that the caller cannot know."""

    def __init__(self, bent: float) -> None:
        self.numbers: dict[tuple[float, ...], int] = {}
        self.bent = bent

    def number(self, place: Array) -> int:
        return self.numbers.setdefault(tuple(np.round(place, 9)), len(self.numbers))

    def shuffled(self) -> tuple[Array, Indices]:
        """Coordinates, a little bent, and the new number of each node."""
        places = np.array(list(self.numbers))
        places[:, 2] += self.bent * np.sin(2 * places[:, 0] + places[:, 1])
        new = RANDOM.permutation(len(places))
        points = np.empty_like(places)
        points[new] = places
        return points, new


def mixed_box(order: int, bent: float) -> RawMesh:
    """2 x 2 x 2 cubes: of hexahedra, prisms and pyramids in turns; the top is a boundary."""
    nodes = Nodes(bent)
    cells: dict[str, list[list[int]]] = {}
    top: dict[int, list[list[int]]] = {}
    for count, origin in enumerate(np.ndindex(2, 2, 2)):
        shape, kinds = (("hexahedron", (CUBE,)), ("prism", PRISMS), ("pyramid", PYRAMIDS))[
            (count + origin[2]) % 3
        ]
        for corners in kinds:
            places = PLACES[list(corners)] + origin
            if order == 2:
                middles = [places[list(ends)].mean(axis=0) for ends in MIDDLES[shape]]
                places = np.vstack([places, middles])
            cells.setdefault(shape, []).append([nodes.number(place) for place in places])
        if origin[2] == 1:
            halves = shape == "prism"
            for around in ([4, 5, 6], [4, 6, 7]) if halves else ([4, 5, 6, 7],):
                face = PLACES[around] + origin
                if order == 2:
                    ends = MIDDLES["triangle" if halves else "quadrilateral"]
                    face = np.vstack([face, [face[list(each)].mean(axis=0) for each in ends]])
                top.setdefault(len(face), []).append([nodes.number(place) for place in face])
    points, new = nodes.shuffled()
    body = [ElementBlock(TYPES[order][shape], new[np.array(c)]) for shape, c in cells.items()]
    faces = [ElementBlock(FACES[count], new[np.array(found)]) for count, found in top.items()]
    return RawMesh(points, 3, {"box": body}, {"top": faces})


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("bent", [0.0, 0.1], ids=["straight", "bent"])
@pytest.mark.parametrize("draw", range(3))
def test_neighbours_fit(order: int, bent: float, draw: int) -> None:
    mesh = mesh_from_raw(mixed_box(order, bent), "box")
    box = mesh.bodies["box"]
    assert (box.cell, box.order, box.pieces) == ("tetrahedron", order, 1)
    determinants = jacobian_determinants(box.points, box.cells, "tetrahedron", order)
    assert determinants.min() > 0
    # four squares on each of six sides, two triangles in each: none is left inside
    outside, folded = exterior_facets(directed_facets(box.cells, box.cell, order), "triangle")
    assert (len(outside), len(folded), len(box.boundaries["top"])) == (48, 0, 8)
    if not bent:
        # exact: the Jacobian is constant in straight cells
        assert determinants[:, 0].sum() / 6 == pytest.approx(8.0, rel=1e-12)
        corners = box.boundaries["top"][:, : CORNERS["triangle"]]
        np.testing.assert_array_equal(box.points[corners][:, :, 2], 2.0)
    stiff = ", which are stiffer in order 1" if order == 1 else ""
    assert f"and is divided into tetrahedra{stiff}" in mesh.notes[0]


@pytest.mark.parametrize("order", [1, 2])
def test_quadrilaterals_are_halved_along_the_shorter_diagonal(order: int) -> None:
    corners = np.array([[0, 0, 0], [2, 0, 0], [3, 1, 0], [1, 1, 0], [4.0, 0, 0]])
    cells = {3: [0, 1, 2, 3], 2: [1, 4, 2]}
    points, blocks = corners, [ElementBlock(k, np.array([c])) for k, c in cells.items()]
    if order == 2:
        ends = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 1, 2, 3), (1, 4), (4, 2)]
        points = np.vstack([corners, [corners[list(each)].mean(axis=0) for each in ends]])
        full = {10: [*cells[3], 5, 6, 7, 8, 9], 9: [*cells[2], 10, 11, 6]}
        blocks = [ElementBlock(k, np.array([c])) for k, c in full.items()]
    body = mesh_from_raw(RawMesh(points, 2, {"b": blocks}, {}), "b").bodies["b"]
    triangles = {frozenset(cell[:3].tolist()) for cell in body.cells}
    # 1-3 is √2 long, 0-2 √10
    assert triangles == {frozenset(each) for each in ((0, 1, 3), (1, 2, 3), (1, 2, 4))}
    determinants = jacobian_determinants(body.points, body.cells, "triangle", order)
    assert determinants[:, 0].sum() / 2 == pytest.approx(3.0, rel=1e-12)


def test_faces_that_cannot_be_divided_alike_are_refused() -> None:
    """Diagonals 0-5, 1-6, 2-7 and 3-4 around a hexahedron: none begins at a lowest node."""
    around = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
    with pytest.raises(MeshError, match="in 4 places, which cannot be divided alike"):
        simplices._rank(np.arange(8), around, "box")
    ranks = np.arange(8)
    simplices._rank(ranks, around[:3], "box")
    assert set(ranks[around[:3]].argmin(axis=1).tolist()) <= {0, 2}
