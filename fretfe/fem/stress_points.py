# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of a body at points within its elements, as a sparse operator on its displacements."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import fem
from scipy import sparse

from fretfe._typing import Array, Bools, Indices
from fretfe.bodies.body import Material
from fretfe.fem._compat import cells_around
from fretfe.fem.elasticity import COMPONENTS, ElasticBody

# Of a plane body: xx, yy, zz, xy, which is what `ElasticBody.element_stresses` has.
IN_PLANE = ((0, 0), (1, 1), (2, 2), (0, 1))
# Reference coordinates may leave an element by this much; bounding boxes grow by this part.
TOLERANCE = 1e-8
NEWTON_STEPS = 12


class StressPoints:
    """Stress at those of some points that lie in this rank's elements.

    Args:
        elastic: the body.
        points: (m, d) places, the same on all ranks of the body.

    Attributes:
        found: (f,) numbers of the points that this rank has.
    """

    def __init__(self, elastic: ElasticBody, points: Array) -> None:
        self._pairs = IN_PLANE if elastic.gdim == 2 else COMPONENTS
        cells, reference, self.found = _locate(elastic, points)
        self._operator = _operator(elastic, cells, reference, self._pairs)

    def stress(self, displacement: fem.Function) -> Array:
        """(f, 4 or 6) stress xx, yy, zz, xy, yz, xz of a displacement, that of the element."""
        values = self._operator @ displacement.x.array
        return np.asarray(values.reshape(len(self.found), len(self._pairs)))


def _locate(elastic: ElasticBody, points: Array) -> tuple[Indices, Array, Indices]:
    """Own elements (f,), reference coordinates (f, d) in them, and numbers (f,) of points."""
    mesh, space = elastic.mesh, _geometry(elastic)
    dim = mesh.topology.dim
    own = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
    extent = float(np.nanmax(np.abs(points), initial=0.0))
    places = np.zeros((len(points), 3))
    places[:, :dim] = points
    cells, numbers = cells_around(mesh, own, places, TOLERANCE * extent)
    nodes = space.tabulate_dof_coordinates()[space.dofmap.list[cells], :dim]
    reference = _pulled_back(space, nodes, points[numbers])
    inside = np.flatnonzero(_inside(elastic, reference))
    # A point on the border of elements is in the first of them.
    found, first = np.unique(numbers[inside], return_index=True)
    chosen = inside[first]
    return cells[chosen].astype(np.int64), reference[chosen], found


def _geometry(elastic: ElasticBody) -> Any:
    """The space in which the places of a body's elements lie."""
    if elastic.order == elastic.degree:
        return elastic.space
    return fem.functionspace(elastic.mesh, ("Lagrange", elastic.order, (elastic.gdim,)))


def _tabulated(space: Any, at: Array) -> tuple[Array, Array]:
    """(n, k) basis functions and their slopes (n, k, d) at reference coordinates (n, d)."""
    if not len(at):
        count = space.element.basix_element.dim
        return np.zeros((0, count)), np.zeros((0, count, at.shape[1]))
    table = space.element.basix_element.tabulate(1, np.ascontiguousarray(at))[..., 0]
    return table[0], np.moveaxis(table[1:], 0, 2)


def _pulled_back(space: Any, nodes: Array, points: Array) -> Array:
    """(n, d) reference coordinates of points (n, d) in elements with nodes (n, k, d), by Newton."""
    at = np.full(points.shape, 1 / (points.shape[1] + 1))
    for _ in range(NEWTON_STEPS):
        values, slopes = _tabulated(space, at)
        missing = points - np.einsum("nk,nkd->nd", values, nodes)
        jacobians = np.einsum("nkd,nke->nde", nodes, slopes)
        # Elements that a point only seems to be in: what is far outside stays there.
        step = np.clip(np.linalg.solve(jacobians, missing[..., None])[..., 0], -1.0, 1.0)
        at = at + step
        if np.abs(step).max(initial=0.0) < TOLERANCE**2:
            break
    return np.asarray(at)


def _inside(elastic: ElasticBody, at: Array) -> Bools:
    """(n,) whether reference coordinates lie in the element."""
    low = (at >= -TOLERANCE).all(axis=1)
    simplex = elastic.mesh.topology.cell_name() in ("triangle", "tetrahedron")
    high = at.sum(axis=1) if simplex else at.max(axis=1, initial=0.0)
    return np.asarray(low & (high <= 1 + TOLERANCE))


def _operator(
    elastic: ElasticBody, cells: Indices, at: Array, pairs: tuple[tuple[int, int], ...]
) -> sparse.csr_matrix:
    """(f * c, n) stress at the points from all displacements of this rank."""
    space, dim = _geometry(elastic), elastic.gdim
    nodes = space.tabulate_dof_coordinates()[space.dofmap.list[cells], :dim]
    jacobians = np.einsum("nkd,nke->nde", nodes, _tabulated(space, at)[1])
    slopes = np.einsum("nke,ned->nkd", _tabulated(elastic.space, at)[1], np.linalg.inv(jacobians))
    rows = np.stack([_row(elastic.material, slopes, pair) for pair in pairs], axis=1)
    unknowns = elastic.space.dofmap.list[cells][..., None] * dim + np.arange(dim)
    count, width = len(cells) * len(pairs), unknowns.shape[1] * dim
    columns = np.repeat(unknowns.reshape(len(cells), width), len(pairs), axis=0)
    indptr = np.arange(count + 1) * width
    shape = count, len(elastic.space.tabulate_dof_coordinates()) * dim
    return sparse.csr_matrix((rows.ravel(), columns.ravel(), indptr), shape=shape)


def _row(material: Material, slopes: Array, pair: tuple[int, int]) -> Array:
    """(n, k, d) factors of a stress component from slopes (n, k, d): Hooke's law."""
    i, j = pair
    row = np.zeros_like(slopes)
    if i == j and not (material.plane == "stress" and i >= slopes.shape[2]):
        row += material.first_lame * slopes
    if max(i, j) < slopes.shape[2]:
        row[..., i] += material.shear_modulus * slopes[..., j]
        row[..., j] += material.shear_modulus * slopes[..., i]
    return row
