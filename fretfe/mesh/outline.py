# SPDX-License-Identifier: LGPL-3.0-or-later
"""The outline of a plane body: straight pieces of its boundary, and what they enclose."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.mesh.cell_geometry import directed_facets, exterior_facets
from fretfe.mesh.mesh import BodyMesh

# Places per piece at which the distance to it is looked up first.
PLACES_PER_PIECE = 10


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
        """(n,) points inside: a ray along x crosses the outline oddly often."""
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
