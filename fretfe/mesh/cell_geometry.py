# SPDX-License-Identifier: LGPL-3.0-or-later
"""Geometry of plane Gmsh cells: orientation, inversion, exterior edges, corner angles.

Cells are arrays (m, k) of indices into points (n, 2), in Gmsh node order: corners, then the middles
of the edges (0, 1), (1, 2), ..., then the centre (9-node quadrilateral).
"""

from __future__ import annotations

import functools

import numpy as np

from fretfe._typing import Array, Bools, Indices

CORNERS = {"triangle": 3, "quadrilateral": 4}

_NODES: dict[str, list[tuple[float, float]]] = {
    "triangle": [(0, 0), (1, 0), (0, 1), (0.5, 0), (0.5, 0.5), (0, 0.5)],
    "quadrilateral": [(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0), (0, 0)],
}
_NODE_COUNTS = {
    ("triangle", 1): 3,
    ("triangle", 2): 6,
    ("quadrilateral", 1): 4,
    ("quadrilateral", 2): 9,
}
_REVERSED = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3], 4: [0, 3, 2, 1], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}


def jacobian_determinants(points: Array, cells: Indices, cell: str, order: int) -> Array:
    """Determinant of the map from the reference cell at each node of each cell: (m, k)."""
    jacobian = np.einsum(
        "qak,mkd->mqad", _gradients_at_nodes(cell, order), points[cells], optimize=True
    )
    xi, eta = jacobian[..., 0, :], jacobian[..., 1, :]
    return xi[..., 0] * eta[..., 1] - xi[..., 1] * eta[..., 0]


@functools.cache
def _gradients_at_nodes(cell: str, order: int) -> Array:
    """Gradients (q, 2, k) of the k Lagrange functions at the q = k nodes, from monomials."""
    nodes = np.array(_NODES[cell][: _NODE_COUNTS[cell, order]], dtype=float)
    total = order if cell == "triangle" else 2 * order
    powers = np.array(
        [(i, j) for i in range(order + 1) for j in range(order + 1) if i + j <= total], dtype=float
    )
    i, j = powers.T
    x, y = nodes[:, :1], nodes[:, 1:]
    coefficients = np.linalg.inv(x**i * y**j)
    d_x = i * x ** np.maximum(i - 1, 0) * y**j
    d_y = j * x**i * y ** np.maximum(j - 1, 0)
    return np.stack([d_x @ coefficients, d_y @ coefficients], axis=1)


def counter_clockwise(
    points: Array, cells: Indices, cell: str, order: int
) -> tuple[Indices, Indices]:
    """The cells with their nodes reversed where they ran clockwise, and the indices of bad cells.

    A cell is bad when its Jacobian determinant changes sign or vanishes at one of its nodes: no
    numbering of its nodes makes it a valid element.
    """
    determinants = jacobian_determinants(points, cells, cell, order)
    clockwise = determinants.sum(axis=1) < 0
    bad = np.where(clockwise, -determinants.max(axis=1), determinants.min(axis=1)) <= 0
    reversed_cells = cells[:, _REVERSED[cells.shape[1]]]
    return np.where(clockwise[:, None], reversed_cells, cells), np.flatnonzero(bad)


def directed_edges(cells: Indices, cell: str, order: int) -> Indices:
    """All edges (m * corners, order + 1) as the cells run round them: end, end[, middle]."""
    corners = CORNERS[cell]
    columns = [cells[:, :corners], np.roll(cells[:, :corners], -1, axis=1)]
    if order == 2:
        columns.append(cells[:, corners : 2 * corners])
    return np.stack(columns, axis=2).reshape(-1, order + 1)


def exterior_edges(edges: Indices) -> tuple[Indices, Indices]:
    """Edges (f, order + 1) that only one cell has, and the edges that are run along twice.

    In a valid mesh of counter-clockwise cells two neighbours run along their common edge in
    opposite directions, so the second array is empty; it is not where cells overlap or fold over.
    """
    first, second = edges[:, 0], edges[:, 1]
    count = int(edges.max()) + 1
    keys = first * count + second
    ordered = np.sort(keys)
    repeated = ordered[1:][ordered[1:] == ordered[:-1]]
    exterior = ~_contains(ordered, second * count + first)
    return edges[exterior], np.stack(np.divmod(np.unique(repeated), count), axis=1)


def _contains(ordered: Indices, values: Indices) -> Bools:
    """For each value, whether it occurs in a sorted array."""
    places = np.minimum(np.searchsorted(ordered, values), len(ordered) - 1)
    return ordered[places] == values


def smallest_angle(points: Array, cells: Indices, cell: str) -> float:
    """Smallest corner angle in degrees, between the chords of the edges."""
    corners = points[cells[:, : CORNERS[cell]]]
    ahead = np.roll(corners, -1, axis=1) - corners
    behind = np.roll(corners, 1, axis=1) - corners
    cosine = np.sum(ahead * behind, axis=2) / (
        np.linalg.norm(ahead, axis=2) * np.linalg.norm(behind, axis=2)
    )
    return float(np.degrees(np.arccos(np.clip(cosine.max(), -1.0, 1.0))))
