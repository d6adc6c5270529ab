# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane meshes swept to solid ones.

Extruded meshes are straight or skewed. Every triangle becomes a column of prisms, every prism three
tetrahedra. The diagonals on the sides of the prisms rise from the vertex of lower rank to that of
higher rank; a rank that two mirrored vertices share makes neighbours fit and the mesh of a
symmetric template symmetric. Quadrilaterals become hexahedra, a tensor product. The nodes of order
2 lie on the extruded curved edges: no geometry is lost.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.case import Solid
from fretfe.mesh.elements import MIDDLES, reference_nodes, reversal
from fretfe.mesh.mesh import BodyMesh, Mesh

FRONT = "front"
BACK = "back"

# The vertices (rank 0, 1 or 2; lower or upper layer) of the three tetrahedra of a prism.
TETRAHEDRA = (
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
# Growth of the layers per distance from a free end: each is 1.4 times as thick as the one before.
_GROWTH = math.log(1.4)

# Whether the extrusion ends freely at z = 0 and at its length.
Ends = tuple[bool, bool]


@dataclass(frozen=True)
class SectorSides:
    """Sides of a sector in the plane that is extruded.

    Sides of a solid that leans would be no images of one another. So they turn about the axis,
    along a helicoid, as fast as the contacts move around it; contacts lean, straight as a broach
    makes them; and what is between them does so in the ratio of the distances.

    Attributes:
        centre: (2,) where the axis is.
        sides: (n, 2) nodes of the sides.
        contacts: (m, 2) nodes of the contact surfaces.
    """

    centre: Array
    sides: Array
    contacts: Array

    def bend(self, points: Array, leaned: Array) -> Array:
        """(n, 2) places in the solid of points (n, 2) that lean by (n,) along x."""
        from scipy.spatial import cKDTree

        away = cKDTree(self.contacts).query(points)[0]
        share = away / (away + cKDTree(self.sides).query(points)[0])
        x, y = (self.contacts - self.centre).mean(axis=0)
        angle = -y / (x**2 + y**2) * leaned
        arms, cosine, sine = points - self.centre, np.cos(angle), np.sin(angle)
        turned = np.column_stack(
            [arms[:, 0] * cosine - arms[:, 1] * sine, arms[:, 0] * sine + arms[:, 1] * cosine]
        )
        straight = points + leaned[:, None] * [1.0, 0.0]
        return np.asarray(straight + share[:, None] * (self.centre + turned - straight))


def extrude(
    mesh: Mesh,
    solid: Solid,
    sectors: Mapping[str, SectorSides] | None = None,
    free: Ends = (True, True),
) -> Mesh:
    """The solid that a plane mesh sweeps along (tan(skew), 0, 1) * length, from z = 0.

    Args:
        mesh: of plane bodies, with cells of order 1 or 2.
        solid: length in the units of the mesh, skew in degrees, number of layers, thickness of
            those at free ends, and which bodies are shorter.
        sectors: sides of bodies that turn about an axis.
        free: ends at which layers may be thinner.

    Returns:
        Tetrahedra and hexahedra of the same order. The boundaries keep their names; those at the
        ends are called `<body>_back` (where z is least) and `<body>_front`.
    """
    faces, lean, bodies = layer_faces(solid, free, tuple(mesh.bodies)), math.radians(solid.skew), {}
    for name, body in mesh.bodies.items():
        start, end = solid.span(name)
        own = faces[(faces >= start) & (faces <= end)]
        bodies[name] = _extruded_body(body, own, lean, (sectors or {}).get(name))
    return replace(mesh, bodies=bodies)


def layer_faces(solid: Solid, free: Ends, bodies: Collection[str] = ()) -> Array:
    """(n + 1,) places of the faces of n layers along z, from 0 to the length.

    Layers are `end_size` thick or less on both sides of a place where a body ends and another one
    goes on, and at free ends that two bodies share. Each is at most 1.4 times as thick as the one
    nearer to the end, up to the length over `layers`.

    Args:
        solid: as of `extrude`.
        free: likewise.
        bodies: names of all.
    """
    spans = [solid.span(name) for name in bodies]
    cuts = sorted({0.0, solid.length}.union(*spans))
    thin = [True] * len(cuts)
    for place, end in ((0, 0), (-1, 1)):
        alone = solid.spans and sum(span[end] == cuts[place] for span in spans) < 2
        thin[place] = free[end] and not alone
    pieces = [
        first + _graded(second - first, solid, ends)[1:]
        for (first, second), ends in zip(pairwise(cuts), pairwise(thin), strict=True)
    ]
    for piece, cut in zip(pieces, cuts[1:], strict=True):
        piece[-1] = cut
    return np.concatenate([[0.0], *pieces])


def _graded(length: float, solid: Solid, thin: Ends) -> Array:
    """(n + 1,) faces of layers over a length, from 0, thin at some of its ends."""
    largest = solid.length / solid.layers
    if solid.end_size is None or solid.end_size >= largest or not any(thin):
        return np.linspace(0.0, length, math.ceil(length / largest - 1e-9) + 1)
    # The size along z is first + _GROWTH * distance, the integral of one over it numbers layers:
    # the first ends at `end_size`.
    first = solid.end_size * _GROWTH / math.expm1(_GROWTH)
    graded = math.log(largest / first) / _GROWTH
    evenly = (largest - first) / _GROWTH

    def number(distance: float) -> float:
        if distance < evenly:
            return math.log1p(_GROWTH * distance / first) / _GROWTH
        return graded + (distance - evenly) / largest

    def distance(number: Array) -> Array:
        near = first * np.expm1(_GROWTH * np.minimum(number, graded)) / _GROWTH
        return np.asarray(near + largest * np.maximum(number - graded, 0.0))

    both = all(thin)
    count = 2 * number(length / 2) if both else number(length)
    layers = max(math.ceil(count - 1e-9), 1)
    numbers = np.linspace(0.0, count, layers + 1)
    if both:
        half = distance(np.minimum(numbers, numbers[::-1]))
        return np.where(numbers < count / 2, half, length - half)
    faces = distance(numbers) * (length / distance(numbers[-1:]))
    return faces if thin[0] else length - faces[::-1]


def _extruded_body(
    body: BodyMesh, faces: Array, lean: float, sector: SectorSides | None
) -> BodyMesh:
    """One body; its nodes are those of the plane mesh, level by level (half layers in order 2)."""
    layers, order = len(faces) - 1, body.order
    levels = order * layers + 1
    heights = np.interp(np.arange(levels) / order, np.arange(layers + 1), faces)
    z = np.repeat(heights, len(body.points))
    plane = np.tile(body.points, (levels, 1))
    leaned = math.tan(lean) * z
    across = plane + leaned[:, None] * [1.0, 0.0]
    if sector is not None:
        across = sector.bend(plane, leaned)
    points = np.column_stack([across, z])
    columns = (_Prisms if body.cell == "triangle" else _Bricks)(body, layers)
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
        cells = np.concatenate([self._nodes(triangles, shape) for shape in TETRAHEDRA])
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
