# SPDX-License-Identifier: LGPL-3.0-or-later
"""The overlap of two contact surfaces: which facets lie opposite each other, and where.

Integrals run over the surface of body 2, whichever side carries the multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from fretfe._core import _kernels
from fretfe._typing import Array, Bools, Indices, Positions
from fretfe.mesh.elements import BULGE, MIDDLES, quadrature, seven_points
from fretfe.surface.normals import contact_normals
from fretfe.surface.surface import Surface

# Spheres are larger by this fraction: points just beyond the end of a facet count as on it.
MARGIN = 1e-6
# Points and weights of a quadrature.
Rule = tuple[Array, Array]
# Exact for the products of hat, quadratic displacement and geometry on straight facets, and far
# below the discretisation error on curved ones.
GAUSS_POINTS = 5
# The same in parts of quadrilaterals that are triangles: degree 6.
TRIANGLE_POINTS = 4
# Points further apart than this fraction of the shorter surface are never in contact.
SEARCH_FRACTION = 0.5


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


def opposite_candidates(
    near: Surface, normals: Array, far: Surface, reach: float, slack: float = 0.0
) -> Candidates:
    """Facets of `far` that lines along normals of `near` may meet.

    Args:
        near: surface with f facets.
        normals: (f, k, d) unit normals at the nodes of `near`, interpolated in between.
        far: surface that is searched.
        reach: largest distance along the normals, to either side.
        slack: distance by which `far` may move.
    """
    tubes = _tubes(near, normals, reach)
    centres, radii = _spheres(far)
    spheres = centres, radii + slack
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
    from scipy.spatial import cKDTree

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


@dataclass(frozen=True)
class OverlapPoints:
    """Integration points on the overlap: n points of surface 2 and their projections on surface 1.

    Attributes:
        facet1: (n,) facets of surface 1.
        facet2: (n,) facets of surface 2.
        at1: (n, d - 1) reference coordinates on `facet1`.
        at2: (n, d - 1) reference coordinates on `facet2`.
        weights: (n,) arc length or area of surface 2 that a point stands for.
        gap: (n,) distance along the normal, positive where the bodies are apart.
        normals: (n, d) unit contact normals, out of body 2.
    """

    facet1: Indices
    facet2: Indices
    at1: Array
    at2: Array
    weights: Array
    gap: Array
    normals: Array


def overlap_points(surface1: Surface, surface2: Surface) -> OverlapPoints:
    """Integration points on surface 2 and their projections on surface 1.

    There are none where no part of the surfaces lies opposite the other within `search_reach`.
    """
    return overlap_along(contact_normals(surface1, surface2), surface1, surface2)


def overlap_along(
    normals: Array, surface1: Surface, surface2: Surface, known: Candidates | None = None
) -> OverlapPoints:
    """Integration points on surface 2 and their projections on surface 1 along given normals.

    Args:
        normals: (f, k, d) unit normals at the nodes of surface 2.
        surface1: of body 1.
        surface2: of body 2.
        known: facets of surface 1 that may lie opposite those of surface 2; None: look for them.
    """
    if surface1.dimension == 3:
        rules = quadrature("quadrilateral", GAUSS_POINTS), _triangle_rule(surface1, surface2)
        return project(surface2, normals, surface1, *rules, known=known)
    at, weights = quadrature("line", GAUSS_POINTS)
    return project(surface2, normals, surface1, (at[:, 0], weights), known=known)


def project(
    near: Surface, normals: Array, far: Surface, *rules: Rule, known: Candidates | None = None
) -> OverlapPoints:
    """Project points of one surface along normals onto another one.

    Args:
        near: surface 2.
        normals: (f, k, d) unit normals at the nodes of `near`.
        far: surface 1.
        rules: points and weights (q,) of the quadrature: in the plane one rule with points (q,) in
            [0, 1]; in space those on quadrilaterals and on triangles, with points (q, 2).
        known: as of `overlap_along`.
    """
    plane = near.dimension == 2
    reach = search_reach(near, far)
    candidates = known or opposite_candidates(near, normals, far, reach)
    kernel: Any = _kernels.overlap_points if plane else _kernels.overlap_points_in_space
    facet2, facet1, at2, at1, weights, gap, at_points = kernel(
        np.ascontiguousarray(near.nodes),
        np.ascontiguousarray(normals),
        np.ascontiguousarray(far.nodes),
        candidates.starts,
        candidates.facets,
        *chain.from_iterable(rules),
        reach,
    )
    if plane:
        at1, at2 = at1[:, None], at2[:, None]
    return OverlapPoints(facet1, facet2, at1, at2, weights, gap, at_points)


def _triangle_rule(*surfaces: Surface) -> Rule:
    """Points and weights in triangles: hat times displacement is of degree 3 or, on a square, 6."""
    if all(surface.shape == "triangle" for surface in surfaces):
        return seven_points()
    return quadrature("triangle", TRIANGLE_POINTS)


def search_reach(surface1: Surface, surface2: Surface) -> float:
    """Distance beyond which points of two surfaces are never in contact."""
    return SEARCH_FRACTION * min(surface1.extent, surface2.extent)
