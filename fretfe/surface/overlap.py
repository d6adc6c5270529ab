# SPDX-License-Identifier: LGPL-3.0-or-later
"""Overlap of two contact surfaces: where their facets lie opposite each other.

The two are compared along the contact normals. These are the normals of both surfaces, each
weighted with the curvature of the other. This matters where surfaces slide far or press deep: a
rounded profile that slides along a flat keeps its gap if the normals are those of the flat, but not
if they are its own, which turn by δ/R over a slide δ; and two equal cylinders touch in the plane
between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._core import _kernels
from fretfe._typing import Array, Indices
from fretfe.surface.curvature import mean_curvature
from fretfe.surface.reference import quadrature, seven_points
from fretfe.surface.search import opposite_candidates
from fretfe.surface.surface import Surface

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
    normals = contact_normals(surface1, surface2)
    if surface1.dimension == 3:
        square = quadrature("quadrilateral", GAUSS_POINTS)
        return project_in_space(
            surface2, normals, surface1, square, _triangle_rule(surface1, surface2)
        )
    at, weights = quadrature("interval", GAUSS_POINTS)
    return project(surface2, normals, surface1, (at[:, 0], weights))


def project(near: Surface, normals: Array, far: Surface, rule: Rule) -> OverlapPoints:
    """Project points of one plane surface along normals onto another one.

    Args:
        near: surface 2.
        normals: (f, k, 2) unit normals at the nodes of `near`.
        far: surface 1.
        rule: points (q,) in [0, 1] and weights (q,) of the quadrature on each segment.
    """
    reach = search_reach(near, far)
    candidates = opposite_candidates(near, normals, far, reach)
    facet2, facet1, xi, eta, weights, gap, at_points = _kernels.overlap_points(
        np.ascontiguousarray(near.nodes),
        np.ascontiguousarray(normals),
        np.ascontiguousarray(far.nodes),
        candidates.starts,
        candidates.facets,
        *rule,
        reach,
    )
    return OverlapPoints(facet1, facet2, eta[:, None], xi[:, None], weights, gap, at_points)


def project_in_space(
    near: Surface, normals: Array, far: Surface, square: Rule, triangle: Rule
) -> OverlapPoints:
    """Project points of one surface in space along normals onto another one.

    Args:
        near: surface 2.
        normals: (f, k, 3) unit normals at the nodes of `near`.
        far: surface 1.
        square: points (q, 2) in [0, 1]² and weights (q,) of the quadrature on quadrilaterals.
        triangle: points and weights of the quadrature on triangles.
    """
    reach = search_reach(near, far)
    candidates = opposite_candidates(near, normals, far, reach)
    facet2, facet1, at2, at1, weights, gap, at_points = _kernels.overlap_points_in_space(
        np.ascontiguousarray(near.nodes),
        np.ascontiguousarray(normals),
        np.ascontiguousarray(far.nodes),
        candidates.starts,
        candidates.facets,
        *square,
        *triangle,
        reach,
    )
    return OverlapPoints(facet1, facet2, at1, at2, weights, gap, at_points)


def _triangle_rule(*surfaces: Surface) -> Rule:
    """Points and weights in triangles: hat times displacement is of degree 3 or, on a square, 6."""
    if all(surface.shape == "triangle" for surface in surfaces):
        return seven_points()
    return quadrature("triangle", TRIANGLE_POINTS)


def search_reach(surface1: Surface, surface2: Surface) -> float:
    """Distance beyond which points of two surfaces are never in contact."""
    return SEARCH_FRACTION * min(surface1.extent, surface2.extent)


def contact_normals(surface1: Surface, surface2: Surface) -> Array:
    """(f, k, d) unit normals of the contact at the nodes of surface 2, out of body 2.

    The normal of each surface counts with the mean curvature of the other: a flat against a
    rounded surface gives the normal of the flat, equal cylinders the direction between their
    axes, conforming surfaces their common normal.
    """
    curvature1, curvature2 = mean_curvature(surface1), mean_curvature(surface2)
    if curvature2 == 0:
        return surface2.normals
    opposite = surface1.nearest(surface2.points)[1][surface2.facets]
    normals = curvature1 * surface2.normals - curvature2 * opposite
    return normals / np.linalg.norm(normals, axis=2, keepdims=True)
