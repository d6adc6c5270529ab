# SPDX-License-Identifier: LGPL-3.0-or-later
"""Geometry of Gmsh cells: orientation, inversion, exterior facets, angles, lengths and areas.

Cells are arrays (m, k) of indices into points (n, d), in Gmsh node order: corners, then the middles
of the edges, of the faces and of the cell. Facets are the edges of plane cells and the faces of
solid ones. They run with the body on their left in the plane, and counter-clockwise seen from
outside in space.
"""

from __future__ import annotations

import functools
from itertools import product

import numpy as np

from fretfe._typing import Array, Bools, Indices

# Reference coordinates of the corners.
_SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1))
_PLACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "line": ((-1,), (1,)),
    "triangle": ((0, 0), (1, 0), (0, 1)),
    "quadrilateral": _SQUARE,
    "tetrahedron": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "hexahedron": tuple((x, y, z) for z in (-1, 1) for x, y in _SQUARE),
}
CORNERS = {cell: len(places) for cell, places in _PLACES.items()}
PLURALS = {
    "triangle": "triangles",
    "quadrilateral": "quadrilaterals",
    "tetrahedron": "tetrahedra",
    "hexahedron": "hexahedra",
}
SIMPLICES = ("line", "triangle", "tetrahedron")
# The corners around each node that order 2 adds.
MIDDLES: dict[str, tuple[tuple[int, ...], ...]] = {
    "line": ((0, 1),),
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quadrilateral": ((0, 1), (1, 2), (2, 3), (3, 0), (0, 1, 2, 3)),
    "tetrahedron": ((0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3)),
    "hexahedron": (
        *((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3)),
        *((2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)),
        *((0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7)),
        tuple(range(8)),
    ),
}
# Corners of the facets, seen from outside the cell.
FACETS: dict[str, tuple[tuple[int, ...], ...]] = {
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quadrilateral": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetrahedron": ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)),
    "hexahedron": MIDDLES["hexahedron"][12:18],
}
FACET_SHAPES = {
    "triangle": "line",
    "quadrilateral": "line",
    "tetrahedron": "triangle",
    "hexahedron": "quadrilateral",
}
# Gauss points along each direction of a facet for its length or area.
GAUSS_POINTS = 3


def reference_nodes(cell: str, order: int) -> Array:
    """(k, d) reference coordinates of the nodes."""
    corners = np.array(_PLACES[cell], dtype=float)
    added = [corners[list(around)].mean(axis=0) for around in MIDDLES[cell]]
    return np.vstack([corners, *added]) if order == 2 else corners


def jacobian_determinants(points: Array, cells: Indices, cell: str, order: int) -> Array:
    """Determinant of the map from the reference cell at each node of each cell: (m, k)."""
    slopes = _slopes(cell, order, reference_nodes(cell, order))
    jacobian = np.einsum("qak,mkd->mqad", slopes, points[cells], optimize=True)
    xi, eta = jacobian[..., 0, :], jacobian[..., 1, :]
    if jacobian.shape[2] == 2:
        return xi[..., 0] * eta[..., 1] - xi[..., 1] * eta[..., 0]
    return np.sum(np.cross(xi, eta) * jacobian[..., 2, :], axis=-1)


def _slopes(cell: str, order: int, at: Array) -> Array:
    """Gradients (q, d, k) of the k Lagrange functions at places (q, d), from monomials."""
    powers = _powers(cell, order)
    columns = [
        powers[:, axis] * _monomials(at, np.maximum(powers - np.eye(at.shape[1])[axis], 0))
        for axis in range(at.shape[1])
    ]
    return np.stack([column @ _coefficients(cell, order) for column in columns], axis=1)


@functools.cache
def _coefficients(cell: str, order: int) -> Array:
    """(k, k) coefficients of the Lagrange functions (columns) of the monomials (rows)."""
    return np.linalg.inv(_monomials(reference_nodes(cell, order), _powers(cell, order)))


def _powers(cell: str, order: int) -> Array:
    """(k, d) powers of the reference coordinates in the monomials of a cell."""
    powers = np.array(list(product(range(order + 1), repeat=len(_PLACES[cell][0]))), dtype=float)
    return powers[powers.sum(axis=1) <= order] if cell in SIMPLICES else powers


def _monomials(at: Array, powers: Array) -> Array:
    """(q, k) monomials at places (q, d)."""
    return np.prod(at[:, None] ** powers, axis=2)


def positive_cells(points: Array, cells: Indices, cell: str, order: int) -> tuple[Indices, Indices]:
    """The cells with their nodes reversed where they ran backwards, and the indices of bad cells.

    Plane cells run counter-clockwise then. A cell is bad when its Jacobian determinant changes sign
    or vanishes at one of its nodes: no numbering of its nodes makes it a valid element.
    """
    determinants = jacobian_determinants(points, cells, cell, order)
    backwards = determinants.sum(axis=1) < 0
    bad = np.where(backwards, -determinants.max(axis=1), determinants.min(axis=1)) <= 0
    reversed_cells = cells[:, reversal(cell, order)]
    return np.where(backwards[:, None], reversed_cells, cells), np.flatnonzero(bad)


@functools.cache
def reversal(cell: str, order: int) -> Indices:
    """(k,) the nodes of a cell in the order of its mirror image, or of a facet from behind."""
    nodes = reference_nodes(cell, order)
    mirrored = nodes.copy()
    mirrored[:, [0, 1]] = nodes[:, [1, 0]]
    return np.linalg.norm(mirrored[:, None] - nodes, axis=2).argmin(axis=1)


def facet_node_count(cell: str, order: int) -> int:
    """Number of nodes of each facet of a cell."""
    return int(_facet_places(cell, order).shape[1])


def directed_facets(cells: Indices, cell: str, order: int) -> Indices:
    """All facets (m * facets, k) of the cells as these run round them, in Gmsh node order."""
    places = _facet_places(cell, order)
    return cells[:, places].reshape(-1, places.shape[1])


@functools.cache
def _facet_places(cell: str, order: int) -> Indices:
    """(facets, k) places of the nodes of each facet among those of its cell."""
    rows = [list(corners) for corners in FACETS[cell]]
    if order == 2:
        numbers = {frozenset(around): i for i, around in enumerate(MIDDLES[cell], CORNERS[cell])}
        middles = MIDDLES[FACET_SHAPES[cell]]
        for row, corners in zip(rows, FACETS[cell], strict=True):
            row += [numbers[frozenset(corners[i] for i in around)] for around in middles]
    return np.array(rows)


def exterior_facets(facets: Indices, shape: str) -> tuple[Indices, Indices]:
    """Facets (f, k) that only one cell has, and corners of those that are run along twice.

    In a valid mesh two neighbours run along their common facet in opposite senses, so the second
    array is empty; it is not where cells overlap or fold over.
    """
    corners = facets[:, : CORNERS[shape]]
    if shape == "line":
        forward, back = corners, corners[:, ::-1]
    else:
        # from the smallest number on, a facet is known by it and by its two neighbours
        first = corners.argmin(axis=1)
        rolled = corners[
            np.arange(len(corners))[:, None], (first[:, None] + [0, 1, -1]) % corners.shape[1]
        ]
        forward, back = rolled, rolled[:, [0, 2, 1]]
    forward_keys, back_keys = np.split(row_keys(np.concatenate([forward, back])), 2)
    ordered, places, counts = np.unique(forward_keys, return_index=True, return_counts=True)
    exterior = ~_contains(ordered, back_keys)
    return facets[exterior], corners[places[counts > 1]]


def row_keys(rows: Indices) -> Indices:
    """(n,) one number for each row of indices (n, k), the same for equal rows; sorted like them."""
    count = int(rows.max(initial=0)) + 1
    keys = rows[:, 0].astype(np.int64)
    most = count
    for column in rows.T[1:]:
        if most > np.iinfo(np.int64).max // count:
            # numbers of the rows so far, so that products stay below the largest integer
            keys, most = np.unique(keys, return_inverse=True)[1], len(keys)
        keys = keys * count + column
        most *= count
    return keys


def _contains(ordered: Indices, values: Indices) -> Bools:
    """For each value, whether it occurs in a sorted array."""
    places = np.minimum(np.searchsorted(ordered, values), len(ordered) - 1)
    return ordered[places] == values


def smallest_angle(points: Array, cells: Indices, cell: str) -> float:
    """Smallest corner angle of plane cells, dihedral angle of solid ones, in degrees.

    Edges count as straight; in a hexahedron the angles are those at the ends of each edge.
    """
    corners = points[cells[:, : CORNERS[cell]]]
    arms = corners[:, _neighbours(cell)] - corners[:, :, None]
    if points.shape[1] == 3:
        # normals of the planes through each arm of a corner and the two others
        along, others = arms, np.stack([arms[:, :, [1, 2, 0]], arms[:, :, [2, 0, 1]]])
        first, second = np.cross(along, others)
    else:
        first, second = arms[:, :, 0], arms[:, :, 1]
    lengths = np.linalg.norm(first, axis=-1) * np.linalg.norm(second, axis=-1)
    cosine = np.sum(first * second, axis=-1) / lengths
    return float(np.degrees(np.arccos(np.clip(cosine.max(), -1.0, 1.0))))


@functools.cache
def _neighbours(cell: str) -> Indices:
    """(corners, d) the corners that each corner of a cell has edges to."""
    found: list[list[int]] = [[] for _ in _PLACES[cell]]
    for ends in MIDDLES[cell]:
        if len(ends) == 2:
            found[ends[0]].append(ends[1])
            found[ends[1]].append(ends[0])
    return np.array(found)


def facet_measures(points: Array, facets: Indices) -> Array:
    """Lengths (f,) of facets between points (n, 2), areas of those between points (n, 3).

    Curved ones by three Gauss points along each direction: the error of a length is below 1e-6 for
    an arc of 30 degrees.
    """
    shape, order = facet_kind(points.shape[1], facets.shape[1])
    at, weights = _quadrature(shape)
    tangents = np.einsum("qak,fkd->fqad", _slopes(shape, order, at), points[facets])
    if shape == "line":
        return np.linalg.norm(tangents[:, :, 0], axis=2) @ weights
    normals = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    return np.linalg.norm(normals, axis=2) @ weights


def facet_kind(dimension: int, count: int) -> tuple[str, int]:
    """Shape and order of the facets with a number of nodes, in the plane or in space."""
    if dimension == 2:
        return "line", count - 1
    return {3: ("triangle", 1), 6: ("triangle", 2), 4: ("quadrilateral", 1)}.get(
        count, ("quadrilateral", 2)
    )


@functools.cache
def _quadrature(shape: str) -> tuple[Array, Array]:
    """Gauss points (q, d) and weights (q,) on a reference facet.

    The rule of the triangle is that of the square, folded along one of its sides.
    """
    places, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    if shape == "line":
        return places[:, None], weights
    at = np.array(list(product(places, repeat=2)))
    products = np.outer(weights, weights).ravel()
    if shape == "quadrilateral":
        return at, products
    at = (at + 1) / 2
    height = 1 - at[:, 0]
    return np.stack([at[:, 0], at[:, 1] * height], axis=1), products / 4 * height
