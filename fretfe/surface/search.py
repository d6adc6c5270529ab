# SPDX-License-Identifier: LGPL-3.0-or-later
"""Search for the facets of one surface that may lie opposite those of another.

A facet meets others along its normals only: within a tube about the line through its centre, which
widens with the distance as its normals spread. Facets of the other surface are put into a tree of
boxes, and only boxes near the tube are opened. Nothing that meets is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices, Positions
from fretfe.surface.reference import BULGE, MIDDLES
from fretfe.surface.surface import Surface

# Spheres are larger by this fraction: points just beyond the end of a facet count as on it.
MARGIN = 1e-6


@dataclass(frozen=True)
class Candidates:
    """Facets of one surface that may lie opposite each of the f facets of another one.

    Attributes:
        starts: (f + 1,) where the candidates of each facet begin, then their number.
        facets: (c,) candidates, those of a facet in ascending order.
    """

    starts: Indices
    facets: Indices


@dataclass(frozen=True)
class _Tubes:
    """Everything within a reach of facets along their normals.

    A point lies at centre + g direction + e with |g| ≤ reach and |e| ≤ radius + |g| spread.
    """

    centres: Array
    directions: Array
    radii: Array
    spreads: Array
    reach: float

    def meet(self, tube: Indices, centres: Array, radii: Array) -> Bools:
        """(n,) tubes `tube` that may contain a point of spheres (n, d), (n,)."""
        seen = centres - self.centres[tube]
        direction, spread = self.directions[tube], self.spreads[tube]
        along = np.sum(seen * direction, axis=1)
        across = np.linalg.norm(seen - along[:, None] * direction, axis=1)
        size = radii + self.radii[tube]
        # |g| differs from |along| by no more than size + |g| spread.
        nearer = np.where(spread <= 0.5, 2 * (np.abs(along) + size), self.reach)
        allowed = size + spread * np.minimum(self.reach, nearer)
        met: Bools = (across <= allowed) & (np.abs(along) <= self.reach + allowed)
        return met


def opposite_candidates(near: Surface, normals: Array, far: Surface, reach: float) -> Candidates:
    """Facets of `far` that lines along normals of `near` may meet.

    Args:
        near: surface with f facets.
        normals: (f, k, d) unit normals at the nodes of `near`, interpolated in between.
        far: surface that is searched.
        reach: largest distance along the normals, to either side.
    """
    tubes = _tubes(near, normals, reach)
    spheres = _spheres(far)
    levels, order = _box_tree(*spheres)
    facet, box = np.arange(len(near.facets)), np.zeros(len(near.facets), dtype=np.int64)
    for centres, radii in levels:
        facet, box = np.repeat(facet, 2), np.stack([2 * box, 2 * box + 1], axis=1).ravel()
        kept = tubes.meet(facet, centres[box], radii[box])
        facet, box = facet[kept], box[kept]
    facet, found = facet[box < len(order)], order[box[box < len(order)]]
    kept = tubes.meet(facet, *(x[found] for x in spheres))
    facet, found = facet[kept], found[kept]
    sorting = np.lexsort([found, facet])
    starts = np.searchsorted(facet[sorting], np.arange(len(near.facets) + 1))
    return Candidates(starts.astype(np.int64), found[sorting].astype(np.int64))


def _tubes(surface: Surface, normals: Array, reach: float) -> _Tubes:
    centres, radii = _spheres(surface)
    directions = normals.mean(axis=1)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    spreads = _farthest(surface, normals - directions[:, None])
    # Unit vectors differ by no more than twice what vectors differ from which they are made.
    return _Tubes(centres, directions, radii, 2 * spreads + MARGIN, reach)


def _spheres(surface: Surface) -> tuple[Array, Array]:
    """Centres (f, d) and radii (f,) of spheres around the facets."""
    nodes = surface.nodes
    centres = nodes.mean(axis=1)
    return centres, (1 + MARGIN) * _farthest(surface, nodes - centres[:, None])


def _farthest(surface: Surface, vectors: Array) -> Array:
    """(f,) bound of the length of vectors interpolated between those at the nodes (f, k, d).

    The longest at the corners, and what the other nodes add to the interpolation between these.
    """
    corners, middles = vectors[:, : surface.corners.shape[1]], MIDDLES[surface.shape]
    farthest = np.linalg.norm(corners, axis=2).max(axis=1)
    if surface.degree == 2:
        straight = np.stack([corners[:, around].mean(axis=1) for around in middles], axis=1)
        bulges = np.linalg.norm(vectors[:, corners.shape[1] :] - straight, axis=2)
        farthest += BULGE[surface.shape] * bulges.max(axis=1)
    return farthest


def _box_tree(centres: Array, radii: Array) -> tuple[list[tuple[Array, Array]], Positions]:
    """Spheres around the boxes of a binary tree with a sphere (f,) in each leaf.

    Returns:
        Centres and radii for each level below the root, and the sphere in each leaf (f,); leaves
        beyond the last one repeat it.
    """
    order: Positions = cKDTree(centres, leafsize=1).indices
    padding = ((0, (1 << (len(order) - 1).bit_length()) - len(order)), (0, 0))
    low = np.pad((centres - radii[:, None])[order], padding, mode="edge")
    high = np.pad((centres + radii[:, None])[order], padding, mode="edge")
    levels = []
    while len(low) > 1:
        levels.append(((low + high) / 2, np.linalg.norm(high - low, axis=1) / 2))
        low = low.reshape(-1, 2, low.shape[1]).min(axis=1)
        high = high.reshape(-1, 2, high.shape[1]).max(axis=1)
    return levels[::-1], order
