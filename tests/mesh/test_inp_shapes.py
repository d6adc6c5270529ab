# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elements with nodes twice, as Ansys writes prisms, pyramids and tetrahedra."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from fretfe.mesh.elements import SOLID_SHAPES, VTK_MIDDLES, reference_nodes
from fretfe.mesh.inp_shapes import sides, without_double_nodes

# Corners of the unit cube; nodes 10 and on are middles of edges.
PLACES = reference_nodes("hexahedron", 1)
SOLID185 = {
    "prism": (0, 1, 2, 2, 4, 5, 6, 6),
    "prism lying": (0, 1, 2, 3, 4, 4, 7, 7),
    "pyramid": (0, 1, 2, 3, 4, 4, 4, 4),
    "tetrahedron": (0, 1, 2, 2, 4, 4, 4, 4),
}
VOLUMES = {"prism": 1 / 2, "prism lying": 1 / 2, "pyramid": 1 / 3, "tetrahedron": 1 / 6}


def with_middles(corners: tuple[int, ...]) -> tuple[int, ...]:
    """Nodes of order 2; that of an edge without length is its end."""
    numbers: dict[frozenset[int], int] = {}
    middles = []
    for ends in VTK_MIDDLES["hexahedron"][:12]:
        edge = frozenset(corners[end] for end in ends)
        middles.append(
            corners[ends[0]] if len(edge) == 1 else numbers.setdefault(edge, 10 + len(numbers))
        )
    return (*corners, *middles)


def volume(faces: list[tuple[int, ...]]) -> float:
    """Enclosed by faces that are seen from inside, as Abaqus counts them, or outside."""
    total = 0.0
    for face in faces:
        first, *others = (PLACES[node] for node in face)
        for second, third in pairwise(others):
            total += abs(float(first @ np.cross(second, third))) / 6
    return total


@pytest.mark.parametrize("name", SOLID185)
@pytest.mark.parametrize("order", [1, 2])
def test_what_is_left_of_a_hexahedron(name: str, order: int) -> None:
    nodes = SOLID185[name] if order == 1 else with_middles(SOLID185[name])
    left = without_double_nodes(nodes, 3)
    shape = SOLID_SHAPES[len(left)]
    assert shape == name.split()[0] and len(set(left)) == len(left)
    corners = left[: {"prism": 6, "pyramid": 5, "tetrahedron": 4}[shape]]
    # the origin is a corner, so that cones over the faces fill the solid
    own = sides(1, corners, 3)
    assert volume([facet.nodes for facet in own]) == pytest.approx(VOLUMES[name])
    # sides keep the numbers of the hexahedron and have no node twice
    facets = sides(1, nodes, 3)
    assert {facet.corners for facet in facets} == {facet.corners for facet in own}
    assert all(len(set(facet.nodes)) == len(facet.nodes) for facet in facets)
    if order == 2:
        whole = {frozenset(facet.nodes) for facet in sides(1, left, 3)}
        assert {frozenset(facet.nodes) for facet in facets} == whole


def test_quadrilaterals_become_triangles() -> None:
    assert without_double_nodes((1, 2, 3, 3), 2) == (1, 2, 3)
    assert without_double_nodes((1, 2, 3, 3, 12, 23, 3, 31), 2) == (1, 2, 3, 12, 23, 31)
    assert [(each.side, each.nodes) for each in sides(7, (1, 2, 3, 3, 12, 23, 3, 31), 2)] == [
        (1, (1, 2, 12)), (2, (2, 3, 23)), (4, (3, 1, 31)),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("nodes", "dimension", "message"),
    [
        ((1, 2, 2, 2), 2, "has node 2 twice"),
        ((0, 1, 2, 2, 4, 5, 6, 7), 3, "has node 2 twice"),
        ((1, 2, 3, 3, 12, 23, 33, 31, 9), 2, ""),
    ],
)
def test_nothing_of_a_known_shape_is_left(
    nodes: tuple[int, ...], dimension: int, message: str
) -> None:
    if not message:  # a node inside goes with the quadrilateral
        assert without_double_nodes(nodes, dimension) == (1, 2, 3, 12, 23, 31)
        return
    with pytest.raises(ValueError, match=message):
        without_double_nodes(nodes, dimension)


def test_edges_that_fall_together_have_one_node() -> None:
    nodes = list(with_middles(SOLID185["prism"]))
    nodes[19] = 99  # the middle of 3-7, which is that of 2-6
    with pytest.raises(ValueError, match=r"has nodes .* and 99 on one edge"):
        without_double_nodes(tuple(nodes), 3)
