# SPDX-License-Identifier: LGPL-3.0-or-later
"""Extrude a plane mesh to a solid one, straight or skewed.

Every triangle becomes a column of prisms, every prism three tetrahedra. The diagonals on the sides
of the prisms rise from the vertex of lower rank to that of higher rank; a rank that two mirrored
vertices share makes neighbours fit and the mesh of a symmetric template symmetric. Quadrilaterals
become hexahedra, a tensor product. The nodes of order 2 lie on the extruded curved edges: no
geometry is lost.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.case import Solid
from fretfe.mesh.elements import MIDDLES, reference_nodes, reversal
from fretfe.mesh.mesh import BodyMesh, Mesh

FRONT, BACK = "front", "back"

# The vertices (rank 0, 1 or 2; lower or upper layer) of the three tetrahedra of a prism.
_TETRAHEDRA = (
    ((0, 0), (1, 0), (2, 0), (2, 1)),
    ((0, 0), (1, 0), (2, 1), (1, 1)),
    ((0, 0), (0, 1), (1, 1), (2, 1)),
)
# The same for the two triangles of a quadrilateral on the side of a prism.
_SIDES = (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1)))
# Ends of the edges whose middles follow the vertices, by the number of these.
_EDGES = {3: MIDDLES["triangle"], 4: MIDDLES["tetrahedron"]}
# The shapes of cells and side facets over those of the plane mesh.
_SWEPT = {"triangle": "tetrahedron", "quadrilateral": "hexahedron", "line": "quadrilateral"}


def extrude(mesh: Mesh, solid: Solid) -> Mesh:
    """The solid that a plane mesh sweeps along (tan(skew), 0, 1) * length, from z = 0.

    Args:
        mesh: of plane bodies, with cells of order 1 or 2.
        solid: length in the units of the mesh, skew in degrees, number of layers.

    Returns:
        Tetrahedra and hexahedra of the same order. The boundaries keep their names; those at the
        ends are called `<body>_back` (z = 0) and `<body>_front` (z = length).
    """
    bodies = {name: _extruded(body, solid) for name, body in mesh.bodies.items()}
    return replace(mesh, bodies=bodies)


def _extruded(body: BodyMesh, solid: Solid) -> BodyMesh:
    """One body; its nodes are those of the plane mesh, level by level (half layers in order 2)."""
    levels = body.order * solid.layers + 1
    z = np.repeat(np.linspace(0.0, solid.length, levels), len(body.points))
    plane = np.tile(body.points, (levels, 1))
    points = np.column_stack([plane[:, 0] + math.tan(math.radians(solid.skew)) * z, plane[:, 1], z])
    columns = (_Prisms if body.cell == "triangle" else _Bricks)(body, solid.layers)
    sides = {name: columns.sides(facets) for name, facets in body.boundaries.items()}
    ends = {
        f"{body.name}_{FRONT}": body.cells + (levels - 1) * len(body.points),
        # from behind, the cells run the other way round
        f"{body.name}_{BACK}": body.cells[:, reversal(body.cell, body.order)],
    }
    cells = columns.cells()
    # a node between the layers on no edge would be left over; there is none in triangles
    assert len(np.unique(cells)) == len(points)
    boundaries = {**sides, **ends}
    return replace(body, points=points, cells=cells, cell=_SWEPT[body.cell], boundaries=boundaries)


class _Bricks:
    """Node numbers of the hexahedra and side facets above quadrilaterals and their edges."""

    def __init__(self, body: BodyMesh, layers: int) -> None:
        self._body = body
        self._layers = layers

    def cells(self) -> Indices:
        """Hexahedra (layers * m, 8 or 27) with positive determinant."""
        return self._swept(self._body.cells, self._body.cell)

    def sides(self, facets: Indices) -> Indices:
        """Quadrilaterals (layers * f, 4 or 9) on the sides above facets, seen from the outside."""
        return self._swept(facets, "line")

    def _swept(self, plane: Indices, shape: str) -> Indices:
        """Cells or facets (n, k) in all layers, each node at its place below and at its level."""
        order, count = self._body.order, len(self._body.points)
        below = reference_nodes(shape, order)
        nodes = reference_nodes(_SWEPT[shape], order)
        places = np.linalg.norm(nodes[:, None, :-1] - below, axis=2).argmin(axis=1)
        levels = np.rint(nodes[:, -1] * order).astype(np.int64)
        one_layer = plane[:, places] + levels * count
        return np.concatenate([one_layer + order * n * count for n in range(self._layers)])


class _Prisms:
    """Node numbers of the tetrahedra and side facets above triangles and their edges."""

    def __init__(self, body: BodyMesh, layers: int) -> None:
        self._body = body
        self._layers = layers
        self._rank = _mirrored_rank(body.points)
        self._middles = _middles(body) if body.order == 2 else np.empty((0, 2), dtype=np.int64)

    def cells(self) -> Indices:
        """Tetrahedra (3 * layers * m, 4 or 10) with positive determinant."""
        triangles, turned = self._ranked(self._body.cells[:, :3])
        cells = np.concatenate([self._nodes(triangles, shape) for shape in _TETRAHEDRA])
        # ranks that run clockwise give the mirror images of the three shapes
        turned = np.tile(turned, len(cells) // len(turned))
        mirrored = cells[:, reversal("tetrahedron", self._body.order)]
        return np.where(turned[:, None], mirrored, cells)

    def sides(self, facets: Indices) -> Indices:
        """Triangles (2 * layers * f, 3 or 6) on the sides above facets, seen from the outside."""
        edges, turned = self._ranked(facets[:, :2])
        triangles = np.concatenate([self._nodes(edges, shape) for shape in _SIDES])
        reversed_triangles = triangles[:, reversal("triangle", self._body.order)]
        turned = np.tile(turned, len(triangles) // len(turned))
        return np.where(turned[:, None], reversed_triangles, triangles)

    def _ranked(self, nodes: Indices) -> tuple[Indices, Bools]:
        """Vertices (n, k) sorted by rank, and whether that is an odd permutation (n,)."""
        order = np.argsort(self._rank[nodes], axis=1)
        turned = np.linalg.det(np.eye(nodes.shape[1])[order]) < 0
        return np.take_along_axis(nodes, order, axis=1), turned

    def _nodes(self, ranked: Indices, shape: tuple[tuple[int, int], ...]) -> Indices:
        """Nodes of one shape in all columns and layers, vertices and then middles of edges."""
        order, count = self._body.order, len(self._body.points)
        places = [(ranked[:, vertex], order * layer) for vertex, layer in shape]
        if order == 2:
            for first, second in _EDGES[len(shape)]:
                level = (places[first][1] + places[second][1]) // 2
                places.append((self._middle(places[first][0], places[second][0]), level))
        one_layer = np.stack([node + level * count for node, level in places], axis=1)
        return np.concatenate([one_layer + order * n * count for n in range(self._layers)])

    def _middle(self, first: Indices, second: Indices) -> Indices:
        """Nodes of the plane mesh in the middle of edges (n,), or the vertex if it is one only."""
        keys = _edge_key(first, second, len(self._body.points))
        place = np.searchsorted(self._middles[:, 0], keys)
        middles: Indices = self._middles[np.minimum(place, len(self._middles) - 1), 1]
        return np.where(first == second, first, middles)


def _mirrored_rank(points: Array) -> Array:
    """Numbers (n,), the same for mirror images in x = 0 but different for neighbours.

    Distance from the axis along a direction in which no mesh has its edges.
    """
    return np.abs(points[:, 0]) * math.cos(1.0) + points[:, 1] * math.sin(1.0)


def _middles(body: BodyMesh) -> Indices:
    """Keys of all edges and their middle nodes, sorted (e, 2)."""
    corners, middles = body.cells[:, :3], body.cells[:, 3:]
    keys = _edge_key(corners, np.roll(corners, -1, axis=1), len(body.points))
    return np.unique(np.column_stack([keys.ravel(), middles.ravel()]), axis=0)


def _edge_key(first: Indices, second: Indices, count: int) -> Indices:
    """One number per edge, the same for both directions."""
    return np.minimum(first, second) * count + np.maximum(first, second)
