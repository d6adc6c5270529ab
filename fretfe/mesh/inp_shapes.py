# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elements of Abaqus and CalculiX: their sides, and what is left of one that has a node twice."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass

from fretfe.mesh.elements import (
    CORNERS,
    FACETS,
    MIDDLES,
    SHAPES,
    SOLID_SHAPES,
    VTK_MIDDLES,
    nodes_of_facets,
)

# Corners of the sides S1, S2, ... of each shape.
SIDES = {
    "triangle": FACETS["triangle"],
    "quadrilateral": FACETS["quadrilateral"],
    "tetrahedron": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": (
        *((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)),
        *((1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    ),
    "prism": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "pyramid": ((0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)),
}
# Shapes of solids by their corners, sides with three corners and sides with four.
_SOLIDS = {(4, 4, 0): "tetrahedron", (5, 4, 1): "pyramid", (6, 2, 3): "prism"}


@dataclass(frozen=True)
class Facet:
    """A side of an element, by number; its nodes are corners, then middles of edges."""

    element: int
    side: int
    nodes: tuple[int, ...]
    corners: frozenset[int]


def sides(number: int, nodes: tuple[int, ...], dimension: int) -> list[Facet]:
    """Sides S1, S2, ... of an element; one whose corners fall together is none."""
    shape = _shape(len(nodes), dimension)
    if len(set(nodes)) == len(nodes):
        places = _places_of_sides(shape, len(nodes))
        return [
            Facet(
                number,
                side,
                tuple(nodes[place] for place in facet),
                frozenset(nodes[corner] for corner in corners),
            )
            for side, (facet, corners) in enumerate(zip(places, SIDES[shape], strict=True), start=1)
        ]
    middles = _middles(nodes, shape)
    return [
        Facet(number, side, (*corners, *_between(corners, middles)), frozenset(corners))
        for side, corners in _sides_left(nodes, shape).items()
    ]


def without_double_nodes(nodes: tuple[int, ...], dimension: int) -> tuple[int, ...]:
    """Nodes of the element that is left where an element has a node twice.

    A quadrilateral becomes a triangle, a hexahedron a prism, a pyramid or a tetrahedron, as Ansys
    writes them.

    Raises:
        ValueError: nothing of a known shape is left.
    """
    if len(set(nodes)) == len(nodes):
        return nodes
    shape = _shape(len(nodes), dimension)
    corners = tuple(dict.fromkeys(nodes[: CORNERS[shape]]))
    if dimension == 2:
        left, kind = corners, "triangle" if len(corners) == 3 else None
    else:
        faces = list(_sides_left(nodes, shape).values())
        triangles: list[tuple[int, ...]] = [face for face in faces if len(face) == 3]
        kind = _SOLIDS.get((len(corners), len(triangles), len(faces) - len(triangles)))
        left = _ordered(corners, triangles, faces) if kind else ()
    if kind is None:
        twice = next(node for node in nodes if nodes.count(node) > 1)
        raise ValueError(f"has node {twice} twice, and is neither triangle nor wedge, pyramid or "
                         "tetrahedron without it")  # fmt: skip
    middles = _middles(nodes, shape)
    around = (MIDDLES if dimension == 2 else VTK_MIDDLES)[kind]
    edges = [frozenset(left[end] for end in ends) for ends in around if len(ends) == 2]
    return (*left, *(middles[edge] for edge in edges if middles))


def _shape(count: int, dimension: int) -> str:
    return SOLID_SHAPES[count] if dimension == 3 else SHAPES[dimension, count]


@functools.cache
def _places_of_sides(shape: str, count: int) -> list[tuple[int, ...]]:
    """Places of the nodes of each side; Abaqus has none within faces of solids."""
    return nodes_of_facets(shape, count, SIDES[shape], _around(shape))


def _around(shape: str) -> tuple[tuple[int, ...], ...]:
    """Corners around each node that follows the corners."""
    return VTK_MIDDLES[shape] if shape in VTK_MIDDLES else MIDDLES[shape]


def _middles(nodes: tuple[int, ...], shape: str) -> dict[frozenset[int], int]:
    """Nodes in the middle of the edges that are left, by their ends.

    Raises:
        ValueError: two edges that fall together have different ones.
    """
    found: dict[frozenset[int], int] = {}
    for ends, node in zip(_around(shape), nodes[CORNERS[shape] :], strict=False):
        edge = frozenset(nodes[end] for end in ends)
        if len(ends) == len(edge) == 2 and found.setdefault(edge, node) != node:
            raise ValueError(f"has nodes {found[edge]} and {node} on one edge")
    return found


def _between(corners: tuple[int, ...], middles: Mapping[frozenset[int], int]) -> list[int]:
    """Nodes in the middle of the edges of a side, if there are any."""
    ahead = corners[1:] if len(corners) == 2 else (*corners[1:], corners[0])
    edges = (frozenset(pair) for pair in zip(corners, ahead, strict=False))
    return [middles[edge] for edge in edges] if middles else []


def _sides_left(nodes: tuple[int, ...], shape: str) -> dict[int, tuple[int, ...]]:
    """Corners of the sides that are left, by number: lines have two, faces three or more."""
    fewest = 2 if shape in ("triangle", "quadrilateral") else 3
    found = {
        side: tuple(dict.fromkeys(nodes[corner] for corner in corners))
        for side, corners in enumerate(SIDES[shape], start=1)
    }
    return {side: corners for side, corners in found.items() if len(corners) >= fewest}


def _ordered(
    corners: tuple[int, ...], triangles: list[tuple[int, ...]], faces: list[tuple[int, ...]]
) -> tuple[int, ...]:
    """Corners of a tetrahedron, pyramid or prism in the order of its own kind."""
    quadrilaterals = [face for face in faces if len(face) == 4]
    if len(corners) < 6:
        base = quadrilaterals[0] if quadrilaterals else triangles[0]
        return (*base, *(node for node in corners if node not in base))
    base, top = triangles
    edges = {
        frozenset((face[place], face[place - 1])) for face in quadrilaterals for place in range(4)
    }
    return (
        *base,
        *(next(each for each in top if frozenset((each, node)) in edges) for node in base),
    )
