# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reference facets: nodes, Lagrange functions and quadrature of each shape and degree.

Reference coordinates lie in [0, 1]; a triangle has its corners at (0, 0), (1, 0) and (0, 1). Nodes
are in Gmsh order: corners, middles of the edges, centre of a quadrilateral.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from fretfe._typing import Array, Bools, Indices, Positions

Shape = Literal["interval", "triangle", "quadrilateral"]

# Shape and degree of a facet by the dimension of space and its number of nodes.
KINDS: dict[tuple[int, int], tuple[Shape, int]] = {
    (2, 2): ("interval", 1),
    (2, 3): ("interval", 2),
    (3, 3): ("triangle", 1),
    (3, 6): ("triangle", 2),
    (3, 4): ("quadrilateral", 1),
    (3, 9): ("quadrilateral", 2),
}
CORNERS: dict[Shape, Array] = {
    "interval": np.array([[0.0], [1.0]]),
    "triangle": np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    "quadrilateral": np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
}
# The corners around each node that degree 2 adds.
MIDDLES: dict[Shape, tuple[tuple[int, ...], ...]] = {
    "interval": ((0, 1),),
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quadrilateral": ((0, 1), (1, 2), (2, 3), (3, 0), (0, 1, 2, 3)),
}
# Largest sum of the absolute values of the functions of degree 2 that do not belong to corners.
BULGE: dict[Shape, float] = {"interval": 1.0, "triangle": 4 / 3, "quadrilateral": 1.3844}


def shape_values(shape: Shape, degree: int, at: Array) -> Array:
    """(n, k) Lagrange functions of a degree, 1 or 2, at reference coordinates (n, d - 1)."""
    return _VALUES[shape](degree, at)


def shape_slopes(shape: Shape, degree: int, at: Array) -> Array:
    """(n, d - 1, k) derivatives of `shape_values` along the reference coordinates."""
    return _SLOPES[shape](degree, at)


def reference_nodes(shape: Shape, degree: int) -> Array:
    """(k, d - 1) reference coordinates of the nodes."""
    corners = CORNERS[shape]
    added = [corners[list(around)].mean(axis=0) for around in MIDDLES[shape]]
    return np.vstack([corners, *added]) if degree == 2 else corners


def lattice(shape: Shape, count: int) -> Array:
    """(n, d - 1) evenly spaced reference coordinates, `count` along each edge."""
    points = _grid(shape, np.linspace(0.0, 1.0, count))
    return points[points.sum(axis=1) <= 1.0 + 1e-9] if shape == "triangle" else points


def quadrature(shape: Shape, count: int) -> tuple[Array, Array]:
    """Gauss points (n, d - 1) and weights (n,), exact for polynomials of degree 2 * count - 2.

    The rule of the triangle is that of the square, folded along one of its sides.
    """
    places, line_weights = np.polynomial.legendre.leggauss(count)
    at = _grid(shape, (places + 1) / 2)
    weights = np.prod(_grid(shape, line_weights / 2), axis=1)
    if shape == "triangle":
        height = 1 - at[:, 0]
        return np.stack([at[:, 0], at[:, 1] * height], axis=1), weights * height
    return at, weights


def seven_points() -> tuple[Array, Array]:
    """Points (7, 2) and weights (7,) in a triangle, exact for polynomials of degree 5 (Radon)."""
    root = np.sqrt(15)
    shares = (6 + np.array([-root, root])) / 21
    corners = CORNERS["triangle"]
    centre = corners.mean(axis=0)
    orbits = [centre + (1 - 3 * share) * (corners - centre) for share in shares]
    weights = np.repeat([9 / 40, *(155 + np.array([-root, root])) / 1200], [1, 3, 3]) / 2
    return np.vstack([centre, *orbits]), weights


def _grid(shape: Shape, line: Array) -> Array:
    """(n, d - 1) tensor product of the values on a line with themselves."""
    axes = np.meshgrid(*[line] * CORNERS[shape].shape[1], indexing="ij")
    return np.stack([axis.ravel() for axis in axes], axis=1)


def _interval_values(degree: int, at: Array) -> Array:
    t = at[:, 0]
    values = (
        [1 - t, t] if degree == 1 else [(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)]
    )
    return np.stack(values, axis=1)


def _interval_slopes(degree: int, at: Array) -> Array:
    t = at[:, 0]
    one = np.ones_like(t)
    slopes = [-one, one] if degree == 1 else [4 * t - 3, 4 * t - 1, 4 - 8 * t]
    return np.stack(slopes, axis=1)[:, None]


def _triangle_values(degree: int, at: Array) -> Array:
    """Polynomials in the barycentric coordinates."""
    area = np.column_stack([1 - at.sum(axis=1), at])
    if degree == 1:
        return area
    first, second = np.array(MIDDLES["triangle"]).T
    return np.hstack([area * (2 * area - 1), 4 * area[:, first] * area[:, second]])


def _triangle_slopes(degree: int, at: Array) -> Array:
    slope = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    if degree == 1:
        return np.broadcast_to(slope, (len(at), 2, 3))
    area = _triangle_values(1, at)
    first, second = np.array(MIDDLES["triangle"]).T
    along_edges = area[:, None, first] * slope[:, second] + area[:, None, second] * slope[:, first]
    return np.concatenate([(4 * area[:, None] - 1) * slope, 4 * along_edges], axis=2)


def _quadrilateral_values(degree: int, at: Array) -> Array:
    """Products of the functions of two intervals."""
    i, j = _grid_nodes(degree)
    x, y = (_interval_values(degree, at[:, [axis]]) for axis in (0, 1))
    return np.asarray(x[:, i] * y[:, j])


def _quadrilateral_slopes(degree: int, at: Array) -> Array:
    i, j = _grid_nodes(degree)
    x, y = (_interval_values(degree, at[:, [axis]]) for axis in (0, 1))
    dx, dy = (_interval_slopes(degree, at[:, [axis]])[:, 0] for axis in (0, 1))
    return np.stack([dx[:, i] * y[:, j], x[:, i] * dy[:, j]], axis=1)


def _grid_nodes(degree: int) -> tuple[Positions, Positions]:
    """Nodes of the intervals, at 0, 1 and 1/2, for each node of the quadrilateral."""
    nodes = reference_nodes("quadrilateral", degree)
    i, j = np.where(nodes == 0.5, 2, nodes).astype(np.intp).T
    return i, j


_VALUES: dict[Shape, Callable[[int, Array], Array]] = {
    "interval": _interval_values,
    "triangle": _triangle_values,
    "quadrilateral": _quadrilateral_values,
}
_SLOPES: dict[Shape, Callable[[int, Array], Array]] = {
    "interval": _interval_slopes,
    "triangle": _triangle_slopes,
    "quadrilateral": _quadrilateral_slopes,
}


def facet_edges(corners: Indices) -> Indices:
    """(F * c, 2) ends of the edges of facets with corners (F, c), in the sense of each facet."""
    return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)


def edges_once(corners: Indices) -> Indices:
    """(E, 2) ends of the edges of facets with corners (F, c), each edge once."""
    return np.unique(np.sort(facet_edges(corners), axis=1), axis=0)


def rim_nodes(corners: Indices, count: int) -> Bools:
    """(count,) nodes at the ends of edges that only one of the facets with corners (F, c) has."""
    edges = np.sort(facet_edges(corners), axis=1)
    found, facets = np.unique(edges, axis=0, return_counts=True)
    rim = np.zeros(count, dtype=bool)
    rim[found[facets == 1]] = True
    return rim
