# SPDX-License-Identifier: LGPL-3.0-or-later
"""Values given at points, from a case or a CSV file, and what they are in between."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Indices
from fretfe.case import Case
from fretfe.case.base import AXES
from fretfe.errors import CaseError
from fretfe.loads.csv_file import read_table
from fretfe.mesh.mesh import place_text

# Points whose extent across a line or plane is below this fraction of their extent lie on it, and a
# place that is nearer to a surface than this fraction of the extent of the body is on that.
FLAT = 1e-6
# How much farther from the middle of the points than their hull a place may be, over the distance
# of the hull: edges of other meshes cut corners off curved surfaces.
OUTSIDE = 0.02
# Points that are nearer than this part of their extent are one, of which a triangulation takes one
# value only.
SAME = 1e-9
# A place that is farther from all points than so many times their distance from one another lies in
# a hole between them: nodes of a mesh have up to half of it, random points seldom more than twice.
HOLE = 3.0
# More points than these are moved by up to this part of their spacing before they are triangulated;
# elements whose weights that changes by more are slivers.
MANY = 1000
JOGGLE = 1e-6
SLIVER = 1e-2
# Nodes around each place between which values at nodes are linear.
NEAREST = 32


@dataclass(frozen=True)
class PointValues:
    """Values at points, linear in triangles or tetrahedra between them; see `at`.

    Attributes:
        points: (n, d), no two of them the same; one for a value that is the same everywhere.
        values: (n,), or (n, c) vectors.
    """

    points: Array
    values: Array

    def at(self, places: Array) -> Array:
        """(m,) or (m, c) values at places (m, d).

        Points on a line or a plane count for everything across it. A place outside of the points
        has the value of the place on their hull in the direction of their middle.
        """
        axes, own, local = self._flattened(places)
        if len(axes) == 0:
            return np.repeat(self.values[:1], len(places), axis=0)
        if len(axes) == 1:
            order = np.argsort(own[:, 0])
            columns = self.values.reshape(len(own), -1)[order].T
            found = [np.interp(local[:, 0], own[order, 0], column) for column in columns]
            return np.stack(found, axis=1).reshape(len(places), *self.values.shape[1:])
        corners, weights = _simplices(own, local)
        return np.asarray(np.einsum("mk,mk...->m...", weights, self.values[corners]))

    def same(self) -> tuple[int, int] | None:
        """Two points that are nearly in the same place, None if there are none."""
        if len(self.points) < 2:
            return None
        # Imported where it is needed: cases without points do without.
        from scipy.spatial import cKDTree

        distance, nearest = cKDTree(self.points).query(self.points, 2)
        first = int(np.argmin(distance[:, 1]))
        if distance[first, 1] > SAME * np.ptp(self.points, axis=0).max():
            return None
        return first, int(nearest[first, 1])

    def outside(self, places: Array) -> tuple[int, float]:
        """Place (m, d) that is farthest outside of the points, and how far over their extent.

        Zero, or less, where it is inside.
        """
        axes, own, local = self._flattened(places)
        if len(axes) == 0:
            return 0, 0.0
        gauge = _gauge(own, local)
        farthest = int(np.argmax(gauge))
        return farthest, float(gauge[farthest] - 1)

    def beside(self, places: Array) -> tuple[int, float]:
        """Place (m, d) that is farthest from the line or plane of the points, and how far.

        The distance is over their extent; zero if they span the space.
        """
        axes, own, local = self._flattened(places)
        middle = self.points.mean(axis=0)
        away = np.linalg.norm(places - middle - local @ axes, axis=1)
        farthest = int(np.argmax(away))
        return farthest, float(away[farthest] / np.ptp(own, axis=0).max())

    def hole(self, places: Array) -> tuple[int, float, float] | None:
        """Place (m, d) deepest in a hole between points; its distance from them, and theirs there.

        Points around a simplex are as far apart as the longest side of the smallest simplex at each
        of its corners, so that long cells of a mesh are no holes. None without one.
        """
        axes, own, local = self._flattened(places)
        if len(axes) < 2:
            return None
        tree = cKDTree(own)
        away, nearest = tree.query(local)
        far = np.flatnonzero(away > HOLE * tree.query(own, 2)[0][nearest, 1])
        if not far.size:
            return None
        # Imported where it is needed: most points have no hole.
        from scipy.spatial import Delaunay

        mesh = Delaunay(own)
        corners = own[mesh.simplices]
        sides = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3).max(axis=(1, 2))
        apart = np.full(len(own), np.inf)
        np.minimum.at(apart, mesh.simplices, sides[:, None])
        around = mesh.find_simplex(local[far])
        spacing = np.where(around < 0, np.inf, apart[mesh.simplices[around]].max(axis=1))
        deepest = int(np.argmax(away[far] / spacing))
        place = int(far[deepest])
        if away[place] <= HOLE * spacing[deepest]:
            return None
        return place, float(away[place]), float(spacing[deepest])

    def _flattened(self, places: Array) -> tuple[Array, Array, Array]:
        """Directions (r, d) in which the points differ; points and places along them from there.

        Both are seen from the middle of the points.
        """
        middle = self.points.mean(axis=0)
        _, sizes, axes = np.linalg.svd(self.points - middle, full_matrices=False)
        axes = axes[sizes > FLAT * sizes[0]]
        return axes, (self.points - middle) @ axes.T, (places - middle) @ axes.T


@dataclass(frozen=True, eq=False)
class NodalValues:
    """Values at the nodes of a body, linear between those nearest to a place.

    Attributes:
        points: (n, d) the nodes.
        values: (n,) values there.
    """

    points: Array
    values: Array

    def at(self, places: Array) -> Array:
        """(m,) values at places (m, d) in the body, or at its nodes."""
        if not len(places):
            return np.zeros(0)
        tree = cKDTree(self.points)
        distance, nearest = tree.query(places)
        if distance.max() < FLAT * np.ptp(self.points, axis=0).max():
            return np.asarray(self.values[nearest])
        near = np.unique(tree.query(places, min(NEAREST, len(self.points)))[1])
        return PointValues(self.points[near], self.values[near]).at(places)


def _simplices(points: Array, places: Array) -> tuple[Indices, Array]:
    """Points (m, r + 1) of a triangulation around places (m, r), and their weights.

    Grids have many points on one sphere, which cost Qhull minutes: many points are joggled. Weights
    are then corrected to be those of the points where they are, but in slivers, which have hardly
    any volume.
    """
    # Imported where it is needed: cases without points do without.
    from scipy.spatial import Delaunay

    count, size = points.shape
    spacing = np.ptp(points, axis=0) / count ** (1 / size) * (count > MANY)
    joggle = np.random.default_rng(0).uniform(-JOGGLE, JOGGLE, points.shape)
    mesh = Delaunay(points + joggle * spacing)
    chosen = mesh.find_simplex(places)
    if (missing := chosen < 0).any():
        # Next to the hull from inside: round-off would leave it again.
        nearer = np.maximum(_gauge(points, places[missing]), 1) * (1 + 1e-9)
        places = places.copy()
        places[missing] /= nearer[:, None]
        chosen[missing] = mesh.find_simplex(places[missing], tol=10 * JOGGLE)
    corners, inverse = mesh.simplices[chosen], mesh.transform[chosen]

    def local(vectors: Array) -> Array:
        found = np.einsum("mij,mj->mi", inverse[:, :size], vectors)
        return np.column_stack([found, -found.sum(axis=1)])

    weights = local(places - inverse[:, size])
    weights[:, size] += 1
    weights[chosen < 0] = np.nan  # in none
    change = local(places - np.einsum("mk,mkd->md", weights, points[corners]))
    return corners, weights + change * (np.abs(change).max(axis=1) < SLIVER)[:, None]


def _gauge(points: Array, places: Array) -> Array:
    """(m,) distance of places from the middle, 0, of points, over that of their hull there."""
    if points.shape[1] == 1:
        low, high = points.min(), points.max()
        return np.maximum(places[:, 0] / high, places[:, 0] / low)
    from scipy.spatial import ConvexHull

    size = np.abs(points).max()
    # A·x + b = 0 on a facet, b < 0 as 0 is inside.
    *normals, offsets = ConvexHull(points / size).equations.T
    facets = np.unique((np.array(normals) / -offsets).T.round(12), axis=0)
    largest = np.full(len(places), -np.inf)
    for facet in facets:
        np.maximum(largest, places @ facet / size, out=largest)
    return largest


def read_points(
    path: Path,
    dimension: int,
    columns: Sequence[str],
    units: Mapping[str, str],
    least: float = -np.inf,
) -> PointValues:
    """Points and a value, or a vector, at each of them from the columns of a CSV file.

    Args:
        path: of the file; its other columns do not matter, nor do lines that begin with #.
        dimension: number of coordinates, columns x, y and, of solids, z.
        columns: that have the values, one, or one for each component.
        units: in which columns must be, by name, if the file says in which they are.
        least: that they may be.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    axes = AXES[:dimension]
    table = read_table(path, (*axes, *columns))
    table.require_units(units)
    points = np.stack([table.columns[axis] for axis in axes], axis=1)
    if len(points) < 2:
        raise CaseError(f"{path}: expected at least 2 points, found {len(points)}")
    _, first, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[inverse.ravel()] != np.arange(len(points)))
    if again.size:
        row = int(again[0])
        before = table.lines[int(first[inverse.ravel()[row]])]
        table.complain(row, axes[0], f"a point of its own, not that of line {before} again")
    for column in columns:
        low = np.flatnonzero(table.columns[column] < least)
        if low.size:
            table.complain(int(low[0]), column, f"a number >= {least:g}")
    values = np.stack([table.columns[column] for column in columns], axis=1)
    return PointValues(points, values[:, 0] if len(columns) == 1 else values)


def require_points_around(
    case: Case, channel: str, given: PointValues, places: Array, what: str
) -> None:
    """Check that points are all different and reach as far as places (m, d).

    Raises:
        CaseError: names the point that is there twice, or the place that is farthest outside.
    """
    if pair := given.same():
        one, other = (place_text(given.points[each]) for each in sorted(pair))
        raise CaseError(
            f"{case.source}: loads.{channel}: expected points of their own, found "
            f"{one if one == other else f'{one} and {other}'} twice, up to round-off"
        )
    farthest, excess = given.outside(places)
    if excess > OUTSIDE:
        raise CaseError(
            f"{case.source}: loads.{channel}: expected points that reach as far as {what}, whose "
            f"node at {place_text(places[farthest])} is farther from their middle by "
            f"{100 * excess:.3g} % than their outermost ones"
        )


def require_points_beside(
    case: Case, channel: str, given: PointValues, places: Array, what: str
) -> None:
    """Check that places (m, d) lie on the line or plane of points that are all on one.

    Raises:
        CaseError: names the place that is farthest away from it.
    """
    farthest, distance = given.beside(places)
    if distance > OUTSIDE:
        raise CaseError(
            f"{case.source}: loads.{channel}: expected points on both sides of {what}, or on it, "
            f"found all of them on one line or plane, from which its node at "
            f"{place_text(places[farthest])} is away by {100 * distance:.3g} % of their extent"
        )
