# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies of a plane mesh that are in the same place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.mesh.cell_geometry import directed_facets, exterior_facets
from fretfe.mesh.mesh import BodyMesh, Mesh

# Bodies may overlap by this fraction of the longer facet there: a straight facet on an arc that it
# turns by 45 degrees lies 10 % of its length inside. Contacts are held to less in
# `fretfe.surface.checks`.
TOLERANCE = 0.1
# Places per facet at which the distance to it is looked up first; finer than the tolerance.
PLACES_PER_FACET = 10
# Cells whose centres are looked at: they find bodies in the very same place.
CELLS = 500
# Points whose distance to the boundary is computed exactly.
DEEPEST = 100


@dataclass(frozen=True)
class BodyOverlap:
    """The point (2,) of `body1` that is deepest inside `body2`, and its distance to the outside."""

    body1: str
    body2: str
    point: Array
    depth: float


def body_overlaps(mesh: Mesh) -> list[BodyOverlap]:
    """Find all pairs of bodies that overlap, and the deepest point of each pair."""
    found: dict[frozenset[str], BodyOverlap] = {}
    outlines = {name: _outline(body) for name, body in mesh.bodies.items()}
    for name, other in permutations(mesh.bodies, 2):
        for overlap in _deepest_point(mesh.bodies[name], other, outlines[name], outlines[other]):
            pair = frozenset((name, other))
            if pair not in found or overlap.depth > found[pair].depth:
                found[pair] = overlap
    return list(found.values())


def _outline(body: BodyMesh) -> Array:
    """(m, 2, 2) ends of the straight pieces of the boundary; two for each curved facet."""
    edges, _ = exterior_facets(directed_facets(body.cells, body.cell, body.order), "line")
    if body.order == 2:
        edges = np.concatenate([edges[:, [0, 2]], edges[:, [2, 1]]])
    return body.points[edges]


def _deepest_point(
    body: BodyMesh, other: str, outline: Array, walls: Array
) -> Iterator[BodyOverlap]:
    """The point of a body that is deepest inside another, if it is deeper than the tolerance."""
    centres = body.points[body.cells[:: -(-len(body.cells) // CELLS)]].mean(axis=1)
    points = np.concatenate([outline[:, 0], centres])
    sizes = np.concatenate([_lengths(outline), np.zeros(len(centres))])
    inside = np.flatnonzero(_inside(points, walls))
    if not len(inside):
        return
    estimates = _sampled_distances(points[inside], walls)
    candidates = inside[np.argsort(-estimates, kind="stable")[:DEEPEST]]
    depths, nearest = _distances(points[candidates], walls)
    excess = depths - TOLERANCE * np.maximum(sizes[candidates], _lengths(walls)[nearest])
    if excess.max() > 0:
        deepest = int(np.argmax(excess))
        yield BodyOverlap(body.name, other, points[candidates[deepest]], float(depths[deepest]))


def _inside(points: Array, walls: Array) -> Bools:
    """(n,) points inside closed outlines: a ray along x crosses them oddly often."""
    order = np.argsort(points[:, 1], kind="stable")
    x, y = points[order].T
    lower, upper = np.sort(walls[:, :, 1], axis=1).T
    first, last = np.searchsorted(y, lower), np.searchsorted(y, upper)
    # Each wall with each of the points whose height it spans.
    count = last - first
    wall = np.repeat(np.arange(len(walls)), count)
    point = np.arange(len(wall)) - np.repeat(np.cumsum(count) - count - first, count)
    (x0, y0), (x1, y1) = walls[wall, 0].T, walls[wall, 1].T
    crossed = x0 + (y[point] - y0) / (y1 - y0) * (x1 - x0) > x[point]
    inside = np.zeros(len(points), dtype=bool)
    inside[order] = np.bincount(point[crossed], minlength=len(points)) % 2 == 1
    return inside


def _sampled_distances(points: Array, walls: Array) -> Array:
    """(n,) distances to places on the walls, too large by a part of a wall at most."""
    t = np.linspace(0.0, 1.0, PLACES_PER_FACET + 1)[:, None, None]
    places = ((1 - t) * walls[:, 0] + t * walls[:, 1]).reshape(-1, 2)
    return cKDTree(places).query(points)[0]


def _distances(points: Array, walls: Array) -> tuple[Array, Indices]:
    """(n,) distances of points from the nearest of the walls, and which walls these are."""
    along = walls[:, 1] - walls[:, 0]
    seen = points[:, None] - walls[:, 0]
    t = np.clip(np.sum(seen * along, axis=2) / np.sum(along**2, axis=1), 0.0, 1.0)
    distances = np.linalg.norm(seen - t[..., None] * along, axis=2)
    nearest = distances.argmin(axis=1)
    return distances[np.arange(len(points)), nearest], nearest


def _lengths(walls: Array) -> Array:
    return np.linalg.norm(walls[:, 1] - walls[:, 0], axis=1)
