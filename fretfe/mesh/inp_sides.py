# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elements of Abaqus and CalculiX that bodies are made of, and their numbered sides."""

from __future__ import annotations

import re
from dataclasses import dataclass

from fretfe.mesh.cell_geometry import CORNERS, MIDDLES
from fretfe.mesh.node_order import VTK_MIDDLES

# Plane strain and plane stress; shells and membranes, which mesh generators write for plane cells.
PLANE = re.compile(r"(?:CPEG|CPE|CPS|M3D|STRI|S)([34689])\w*\Z")
SOLID = re.compile(r"C3D(4|8|10|20)(?!\d)\w*\Z")
LINE = re.compile(r"(?:T2D|T3D|B2|B3)\d\w*\Z")
UNSUPPORTED = {
    "axisymmetric elements": re.compile(r"C?G?AX|SAX|MAX|SFMAX"),
    "prisms": re.compile(r"C3D(?:6|15)(?!\d)|SC6"),
    "pyramids": re.compile(r"C3D(?:5|13)(?!\d)"),
    "volume elements": re.compile(r"C3D(?!(?:4|8|10|20)(?!\d))|SC\d|CSS\d"),
}
# Elements of bodies, and those that may stand for their facets, by dimension.
BODY_ELEMENTS, FACET_ELEMENTS = {2: PLANE, 3: SOLID}, {2: LINE, 3: PLANE}
# Gmsh types by dimension and number of nodes.
CELLS = {2: {3: 2, 4: 3, 6: 9, 8: 16, 9: 10}, 3: {4: 4, 8: 5, 10: 11, 20: 17}}
FACETS = {2: {2: 1, 3: 8}, 3: {3: 2, 4: 3, 6: 9, 8: 16}}
SHAPES = {
    2: {3: "triangle", 6: "triangle"} | dict.fromkeys((4, 8, 9), "quadrilateral"),
    3: {4: "tetrahedron", 10: "tetrahedron", 8: "hexahedron", 20: "hexahedron"},
}
# Corners of the sides S1, S2, ... of each shape.
SIDES = {
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quadrilateral": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetrahedron": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": (
        *((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)),
        *((1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    ),
}


@dataclass(frozen=True)
class Facet:
    """A side of an element, by number; its nodes are corners, then middles of edges."""

    element: int
    side: int
    nodes: tuple[int, ...]
    corners: frozenset[int]


def sides(number: int, nodes: tuple[int, ...], dimension: int) -> list[Facet]:
    """Sides S1, S2, ... of an element."""
    shape = SHAPES[dimension][len(nodes)]
    around = (MIDDLES if dimension == 2 else VTK_MIDDLES)[shape]
    middles = {frozenset(ends): i for i, ends in enumerate(around, CORNERS[shape])}
    found = []
    for side, corners in enumerate(SIDES[shape], start=1):
        facet = [nodes[corner] for corner in corners]
        if len(nodes) > CORNERS[shape]:
            ahead = corners[1:] if len(corners) == 2 else (*corners[1:], corners[0])
            pairs = zip(corners, ahead, strict=False)
            facet += [nodes[middles[frozenset(pair)]] for pair in pairs]
        found.append(Facet(number, side, tuple(facet), frozenset(facet[: len(corners)])))
    return found
