# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies of a mesh that are in the same place, by their outlines or their closed surfaces.

SciPy is imported by the functions that need it: until Gmsh begins it would take most of the time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.mesh.elements import CORNERS, FACET_SHAPES, MIDDLES, directed_facets, exterior_facets
from fretfe.mesh.mesh import BodyMesh, Mesh

# Places per piece at which the distance to it is looked up first.
PLACES_PER_PIECE = 10
# Triangles of a curved facet, by its number of nodes in Gmsh node order, and of a flat one.
_TRIANGLES: dict[int, tuple[tuple[int, int, int], ...]] = {
    3: ((0, 1, 2),),
    4: ((0, 1, 2), (0, 2, 3)),
    6: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    9: (
        *((0, 4, 8), (0, 8, 7), (4, 1, 5), (4, 5, 8)),
        *((8, 5, 2), (8, 2, 6), (7, 8, 6), (7, 6, 3)),
    ),
}
# Nearest triangles, by their centres, whose distance is looked up first.
NEIGHBOURS = 24
# Nodes of a flat facet are off the places that its corners give them by this fraction of its size.
FLAT = 1e-6
# A turn by about a degree takes rays along an axis off the edges and faces of usual bodies.
_SLANT = (0.0171, -0.0123, 0.0089)
# Bodies may overlap by this fraction of the longer facet there: a straight facet on an arc that it
# turns by 45 degrees lies 10 % of its length inside. Contacts are held to less in
# `fretfe.surface.checks`.
TOLERANCE = 0.1
# Cells whose centres are looked at: they find bodies in the very same place.
CELLS = 500
# Points whose distance to the boundary is computed exactly.
DEEPEST = 100


class Outline:
    """The straight pieces of the boundary of a plane body; two for each curved facet.

    Attributes:
        walls: (m, 2, 2) their ends.
        sizes: (m,) their lengths.
        points: (m, 2) where they begin.
        point_sizes: (m,) their lengths.
    """

    def __init__(self, body: BodyMesh) -> None:
        edges, _ = exterior_facets(directed_facets(body.cells, body.cell, body.order), "line")
        if body.order == 2:
            edges = np.concatenate([edges[:, [0, 2]], edges[:, [2, 1]]])
        self.walls: Array = body.points[edges]
        self.points: Array = self.walls[:, 0]
        self.sizes: Array = np.linalg.norm(self.walls[:, 1] - self.walls[:, 0], axis=1)
        self.point_sizes = self.sizes

    def inside(self, points: Array) -> Bools:
        """(n,) points inside: a ray along x crosses the outline an odd number of times."""
        order = np.argsort(points[:, 1], kind="stable")
        x, y = points[order].T
        lower, upper = np.sort(self.walls[:, :, 1], axis=1).T
        first, last = np.searchsorted(y, lower), np.searchsorted(y, upper)
        # Each wall with each of the points whose height it spans.
        count = last - first
        wall = np.repeat(np.arange(len(self.walls)), count)
        point = np.arange(len(wall)) - np.repeat(np.cumsum(count) - count - first, count)
        (x0, y0), (x1, y1) = self.walls[wall, 0].T, self.walls[wall, 1].T
        crossed = x0 + (y[point] - y0) / (y1 - y0) * (x1 - x0) > x[point]
        inside = np.zeros(len(points), dtype=bool)
        inside[order] = np.bincount(point[crossed], minlength=len(points)) % 2 == 1
        return inside

    def estimate(self, points: Array) -> Array:
        """(n,) distances to places on the walls, too large by a part of a wall at most."""
        from scipy.spatial import cKDTree

        t = np.linspace(0.0, 1.0, PLACES_PER_PIECE + 1)[:, None, None]
        places = ((1 - t) * self.walls[:, 0] + t * self.walls[:, 1]).reshape(-1, 2)
        return np.asarray(cKDTree(places).query(points)[0])

    def distances(self, points: Array) -> tuple[Array, Indices]:
        """(n,) distances of points from the nearest of the walls, and which walls these are."""
        along = self.walls[:, 1] - self.walls[:, 0]
        seen = points[:, None] - self.walls[:, 0]
        t = np.clip(np.sum(seen * along, axis=2) / np.sum(along**2, axis=1), 0.0, 1.0)
        distances = np.linalg.norm(seen - t[..., None] * along, axis=2)
        nearest = distances.argmin(axis=1)
        return distances[np.arange(len(points)), nearest], nearest


class ClosedSurface:
    """The surface of a solid.

    Attributes:
        walls: (m, 3, 3) corners of its triangles; four for each curved one, two or eight for a
            quadrilateral.
        sizes: (m,) their longest edges.
        points: (n, 3) its nodes.
        point_sizes: (n,) longest edge of the triangles around each.
    """

    def __init__(self, body: BodyMesh) -> None:
        shape = FACET_SHAPES[body.cell]
        facets, _ = exterior_facets(directed_facets(body.cells, body.cell, body.order), shape)
        corners = np.concatenate(
            [
                part[:, np.array(_TRIANGLES[part.shape[1]])].reshape(-1, 3)
                for part in _flat_and_curved(body.points, facets, shape)
            ]
        )
        self.walls: Array = body.points[corners]
        edges = np.linalg.norm(np.roll(self.walls, -1, axis=1) - self.walls, axis=2)
        self.sizes: Array = np.maximum(np.maximum(*edges.T[:2]), edges[:, 2])
        nodes, number = np.unique(corners, return_inverse=True)
        self.points: Array = body.points[nodes]
        self.point_sizes: Array = np.zeros(len(nodes))
        np.maximum.at(self.point_sizes, number.ravel(), np.repeat(self.sizes, 3))
        self._centres: Array = self.walls.mean(axis=1)
        reach = np.linalg.norm(self.walls - self._centres[:, None], axis=2)
        self._radii: Array = reach.max(axis=1)

    def inside(self, points: Array) -> Bools:
        """(n,) points inside: a ray crosses the surface an odd number of times."""
        from scipy.spatial.transform import Rotation

        chosen = np.flatnonzero(self._in_box(points))
        turn = Rotation.from_rotvec(_SLANT).as_matrix()[:, self._ray()]
        turned, walls = points[chosen] @ turn, self.walls @ turn
        lines, heights = _lines(walls), _heights(walls)
        crossings = np.zeros(len(chosen), dtype=np.int64)
        for wall, point in _under(turned[:, :2], walls[..., :2]):
            for line in lines:
                hit = _at(line, wall, turned[point]) > 0
                wall, point = wall[hit], point[hit]
            above = _at(heights, wall, turned[point]) > turned[point, 2]
            crossings += np.bincount(point[above], minlength=len(chosen))
        inside = np.zeros(len(points), dtype=bool)
        inside[chosen] = crossings % 2 == 1
        return inside

    def _ray(self) -> list[int]:
        """The axes, that of the rays last: seen along it, the triangles have small boxes."""
        low, high = _boxes(self.walls)
        x, y, z = (high - low).T
        sizes = [np.maximum(*each).sum() for each in ((y, z), (z, x), (x, y))]
        last = int(np.argmin(sizes))
        return [axis for axis in range(3) if axis != last] + [last]

    def _in_box(self, points: Array) -> Bools:
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        return np.asarray(((points > low) & (points < high)).all(axis=1))

    def estimate(self, points: Array) -> Array:
        """(n,) distances from the triangles with the nearest centres; none too small."""
        from scipy.spatial import cKDTree

        count = min(NEIGHBOURS, len(self.walls))
        _, near = cKDTree(self._centres).query(points, k=count)
        near = near.reshape(len(points), count)
        seen = np.broadcast_to(points[:, None], (*near.shape, 3)).reshape(-1, 3)
        distances = _distances(seen, self.walls[near.ravel()])
        return np.asarray(distances.reshape(near.shape).min(axis=1))

    def distances(self, points: Array) -> tuple[Array, Indices]:
        """(n,) distances of points from the nearest triangles, and which triangles these are."""
        from scipy.spatial.distance import cdist

        apart = cdist(points, self._centres)
        point, wall = np.nonzero(apart - self._radii <= apart.min(axis=1)[:, None])
        distances = _distances(points[point], self.walls[wall])
        # The first of each point after this order is its nearest.
        order = np.lexsort([distances, point])
        first = order[np.searchsorted(point[order], np.arange(len(points)))]
        return distances[first], wall[first]


def _boxes(walls: Array) -> tuple[Array, Array]:
    """Smallest and largest coordinates (m, d) of triangles (m, 3, d)."""
    first, second, third = np.moveaxis(walls, 1, 0)
    # Faster than the least along an axis of three.
    low = np.minimum(np.minimum(first, second), third)
    return low, np.maximum(np.maximum(first, second), third)


def _under(points: Array, walls: Array) -> Iterator[tuple[Indices, Indices]]:
    """Triangles (m, 3, 2) and points (n, 2) that may be in them, as pairs of numbers.

    Triangles of about one size are looked up at a time, in squares into which each of them fits: it
    meets four of these at most.
    """
    low, high = _boxes(walls)
    level = np.ceil(np.log2(np.maximum((high - low).max(axis=1), np.finfo(float).tiny)))
    for each in np.unique(level):
        rows = np.flatnonzero(level == each)
        size = 2.0**each
        first = np.floor(low[rows] / size)
        # Two to the left and to the right of all.
        start = first.min(axis=0)
        columns = first[:, 1].max() - start[1] + 3
        squares = np.floor(points / size) - start
        near = np.flatnonzero(((squares >= 0) & (squares < [np.inf, columns])).all(axis=1))
        keys = squares[near] @ [columns, 1.0]
        order = np.argsort(keys, kind="stable")
        near, keys = near[order], keys[order]
        last = np.floor(high[rows] / size)
        for step in product((0.0, 1.0), repeat=2):
            reached = np.flatnonzero((first + step <= last).all(axis=1))
            key = (first[reached] + step - start) @ [columns, 1.0]
            begin, end = (np.searchsorted(keys, key, side) for side in ("left", "right"))
            count = end - begin
            offsets = np.repeat(np.cumsum(count) - count - begin, count)
            yield np.repeat(rows[reached], count), near[np.arange(count.sum()) - offsets]


def _lines(walls: Array) -> Array:
    """(3, 3, m) a, b, c of a x + b y + c for each edge of triangles, positive on their side."""
    x, y, _ = np.moveaxis(walls, 2, 0)
    ahead, behind = np.roll(x, -1, 1), np.roll(y, -1, 1)
    lines = np.stack([y - behind, ahead - x, x * behind - ahead * y])
    return np.asarray((lines * np.sign(lines[2].sum(axis=1))[:, None]).transpose(2, 0, 1))


def _heights(walls: Array) -> Array:
    """(3, m) a, b, c of z = a x + b y + c on triangles."""
    normals = np.cross(walls[:, 1] - walls[:, 0], walls[:, 2] - walls[:, 0])
    across = np.where(normals[:, 2] == 0, np.inf, normals[:, 2])
    offset = np.sum(normals * walls[:, 0], axis=1)
    return np.stack([-normals[:, 0] / across, -normals[:, 1] / across, offset / across])


def _at(affine: Array, wall: Indices, points: Array) -> Array:
    """(n,) affine functions of x and y, those of some triangles, at points."""
    a, b, c = affine[:, wall]
    return np.asarray(a * points[:, 0] + b * points[:, 1] + c)


def _flat_and_curved(points: Array, facets: Indices, shape: str) -> Iterator[Indices]:
    """Corners of the flat facets, and all nodes of the others."""
    corners = facets[:, : CORNERS[shape]]
    if facets.shape[1] == corners.shape[1]:
        yield facets
        return
    middles = [points[corners[:, around]].mean(axis=1) for around in MIDDLES[shape]]
    off = np.abs(points[facets[:, corners.shape[1] :]] - np.stack(middles, axis=1)).max(axis=(1, 2))
    flat = off < FLAT * np.ptp(points[corners], axis=1).max(axis=1)
    yield corners[flat]
    yield facets[~flat]


def _distances(points: Array, walls: Array) -> Array:
    """(n,) distances of points (n, 3) from triangles (n, 3, 3)."""
    along = np.roll(walls, -1, axis=1) - walls
    seen = points[:, None] - walls
    lengths = np.maximum(np.sum(along**2, axis=2), np.finfo(float).tiny)
    t = np.clip(np.sum(seen * along, axis=2) / lengths, 0.0, 1.0)
    from_edges = np.linalg.norm(seen - t[..., None] * along, axis=2).min(axis=1)
    normals = np.cross(along[:, 0], along[:, 1])
    areas = np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
    within = (np.sum(np.cross(along, seen) * normals[:, None], axis=2) >= 0).all(axis=1)
    from_plane = np.abs(np.sum(seen[:, 0] * normals, axis=1)) / areas
    return np.asarray(np.where(within, from_plane, from_edges))


@dataclass(frozen=True)
class BodyOverlap:
    """The point (d,) of `body1` that is deepest inside `body2`, and its distance to the outside."""

    body1: str
    body2: str
    point: Array
    depth: float


def body_overlaps(mesh: Mesh) -> list[BodyOverlap]:
    """Find all pairs of bodies that overlap, and the deepest point of each pair."""
    found: dict[frozenset[str], BodyOverlap] = {}
    kind = Outline if mesh.dimension == 2 else ClosedSurface
    boundaries: dict[str, Outline | ClosedSurface] = {}
    for name, other in permutations(mesh.bodies, 2):
        if not _boxes_overlap(mesh.bodies[name], mesh.bodies[other]):
            continue
        for each in (name, other):
            if each not in boundaries:
                boundaries[each] = kind(mesh.bodies[each])
        for overlap in _deepest_point(
            mesh.bodies[name], other, boundaries[name], boundaries[other]
        ):
            pair = frozenset((name, other))
            if pair not in found or overlap.depth > found[pair].depth:
                found[pair] = overlap
    return list(found.values())


def _boxes_overlap(first: BodyMesh, second: BodyMesh) -> bool:
    """True unless the boxes around two bodies touch at most."""
    low = np.maximum(first.points.min(axis=0), second.points.min(axis=0))
    high = np.minimum(first.points.max(axis=0), second.points.max(axis=0))
    return bool((low < high).all())


def _deepest_point(
    body: BodyMesh,
    other: str,
    own: Outline | ClosedSurface,
    boundary: Outline | ClosedSurface,
) -> Iterator[BodyOverlap]:
    """The point of a body that is deepest inside another, if it is deeper than the tolerance."""
    centres = body.points[body.cells[:: -(-len(body.cells) // CELLS)]].mean(axis=1)
    points = np.concatenate([own.points, centres])
    sizes = np.concatenate([own.point_sizes, np.zeros(len(centres))])
    inside = np.flatnonzero(boundary.inside(points))
    if not len(inside):
        return
    # Estimates are not too small: a point that they do not put too deep is not.
    estimates = boundary.estimate(points[inside]) - TOLERANCE * sizes[inside]
    candidates = inside[
        np.argsort(-estimates, kind="stable")[: min(DEEPEST, int(np.sum(estimates > 0)))]
    ]
    if not len(candidates):
        return
    depths, nearest = boundary.distances(points[candidates])
    excess = depths - TOLERANCE * np.maximum(sizes[candidates], boundary.sizes[nearest])
    if excess.max() > 0:
        deepest = int(np.argmax(excess))
        yield BodyOverlap(body.name, other, points[candidates[deepest]], float(depths[deepest]))
