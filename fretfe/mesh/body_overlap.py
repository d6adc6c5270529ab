# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies of a mesh that are in the same place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from fretfe._typing import Array
from fretfe.mesh.closed_surface import ClosedSurface
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.mesh.outline import Outline

# Bodies may overlap by this fraction of the longer facet there: a straight facet on an arc that it
# turns by 45 degrees lies 10 % of its length inside. Contacts are held to less in
# `fretfe.surface.checks`.
TOLERANCE = 0.1
# Cells whose centres are looked at: they find bodies in the very same place.
CELLS = 500
# Points whose distance to the boundary is computed exactly.
DEEPEST = 100


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
