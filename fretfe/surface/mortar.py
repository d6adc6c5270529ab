# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mortar coupling of two contact surfaces, integrated over their true overlap segments.

The traction on body 2 is τ = Σ φ_i (−p_i n + q_i·t): hat functions φ_i on the facet ends of the
side that carries the multipliers, n the outward normal of body 2, t the tangents (in the plane n
turned clockwise, so that x = t and y = n). Work conjugate to it are the weighted gap
∫ φ_i [(u_1 − u_2)·n + gap] and the weighted tangential displacement ∫ φ_i (u_2 − u_1)·t.

Integrals run over the surface of body 2, whichever side carries the multipliers, at the points of
`fretfe.surface.overlap`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fretfe._typing import Array, Indices
from fretfe.errors import ModelError
from fretfe.mesh.elements import shape_values
from fretfe.surface.overlap import OverlapPoints, overlap_points
from fretfe.surface.surface import Chain, Surface, tangent_frames

# Hats with less than this fraction of their support inside the overlap carry no multiplier.
SMALLEST_SUPPORT = 1e-6


@dataclass(frozen=True)
class Coupling:
    """Coupling operators of one contact pair; N multiplier nodes, d space dimensions.

    Rows of the operators belong to node i and component c (normal, then tangents) at N-row i*d + c.

    Attributes:
        arc: (N,) arc length of the nodes along the multiplier side, along t; empty in space.
        points: (N, d) coordinates of the nodes.
        facets: (F, c) numbers of the nodes at the corners of the facets that have one at each:
            along t in the plane, counter-clockwise seen from outside body 2 in space.
        frames: (N, d, d) rows: outward normal of body 2, then tangents, mean around the nodes.
        weights: (N,) integral of each hat function over the overlap.
        averaging: (N, N) mean of a traction around each node, ∫ φ_i Σ φ_j λ_j / ∫ φ_i.
        gap: (N,) weighted initial gap, ∫ φ_i gap.
        body1, body2: (N*d, n) operators on the surface displacements of each body.
    """

    arc: Array
    points: Array
    facets: Indices
    frames: Array
    weights: Array
    averaging: sparse.csr_matrix
    gap: Array
    body1: sparse.csr_matrix
    body2: sparse.csr_matrix


def couple(
    name: str, surface1: Surface, surface2: Surface, multipliers: str, degree: int
) -> Coupling:
    """Build the coupling of a contact pair.

    Args:
        name: of the contact, for messages.
        surface1: surface of body 1.
        surface2: surface of body 2.
        multipliers: "surface1", "surface2" or "finer": the side that carries the multipliers.
        degree: of the displacement space.

    Raises:
        ModelError: No part of the surfaces lies opposite the other.
    """
    on_first = multipliers == "surface1" or (
        multipliers == "finer" and _facet_size(surface1) <= _facet_size(surface2)
    )
    overlap = overlap_points(surface1, surface2)
    if not len(overlap.weights):
        raise ModelError(
            f"contact {name!r}: surfaces {surface1.name!r} and {surface2.name!r} never face each "
            "other within half their size; expected two boundaries that look at each other. "
            "Check the names, and that the bodies are in their working position."
        )
    return _assemble(overlap, surface1, surface2, on_first, degree)


def _facet_size(surface: Surface) -> float:
    return float(np.median(surface.sizes))


def _assemble(
    overlap: OverlapPoints, surface1: Surface, surface2: Surface, on_first: bool, degree: int
) -> Coupling:
    """Coupling from the points of the overlap and a displacement space of a degree."""
    sides = (
        _Side(surface1, overlap.facet1, overlap.at1),
        _Side(surface2, overlap.facet2, overlap.at2),
    )
    carrier = sides[0 if on_first else 1]
    hats, vertices = carrier.hats()
    tests = hats * overlap.weights[:, None]
    nodes, number = _nodes(carrier.surface, vertices, tests, on_first)
    rows = number[vertices]
    support = _totals(rows, tests, len(nodes))
    mean = np.stack([_totals(rows, tests * x[:, None], len(nodes)) for x in overlap.normals.T], 1)
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    # Frames at the points and at the nodes, with tangents in the same directions.
    frames = tangent_frames(np.vstack([overlap.normals, mean]))
    count, d = overlap.normals.shape
    # The gap opens with u_1 along n; the tangential displacement grows with u_2 along t.
    signs = np.array([1.0, *[-1.0] * (d - 1)])[:, None]
    pieces = _Pieces(overlap)
    directed = tests[:, :, None, None] * (signs * frames[:count])[:, None]
    body1, body2 = (
        pieces.operator(sign * directed, rows, side, degree, len(nodes))
        for sign, side in zip((1.0, -1.0), sides, strict=True)
    )
    return Coupling(
        arc=_arc(carrier.surface, on_first)[nodes] if d == 2 else np.empty(0),
        points=carrier.surface.vertices[nodes],
        facets=_facets(number[carrier.surface.corners], d, on_first),
        frames=frames[count:],
        weights=support,
        averaging=sparse.diags(1 / support).tocsr()
        @ pieces.products(tests, hats, rows, len(nodes)),
        gap=_totals(rows, tests * overlap.gap[:, None], len(nodes)),
        body1=body1,
        body2=body2,
    )


@dataclass(frozen=True)
class _Side:
    """One surface with n points on its facets."""

    surface: Surface
    facet: Indices
    at: Array

    def hats(self) -> tuple[Array, Indices]:
        """(n, c) values of the hat functions at the points, and their vertices."""
        values = shape_values(self.surface.shape, 1, self.at)
        return values, self.surface.corners[self.facet]

    def trace(self, degree: int) -> tuple[Array, Indices]:
        """(n, k) values of the functions of displacement at the points, and their points."""
        values = shape_values(self.surface.shape, degree, self.at)
        return values, self.surface.displacement_facets(degree)[self.facet]


def _nodes(
    carrier: Surface, vertices: Indices, tests: Array, on_first: bool
) -> tuple[Indices, Indices]:
    """(N,) vertices that carry multipliers, and the number of each vertex (v,) among them or -1."""
    support = _totals(vertices, tests, len(carrier.vertices))
    nodes = np.flatnonzero(support > SMALLEST_SUPPORT * carrier.hat_integrals())
    # A chain has its body on the left: only that of body 1 runs in the direction of t.
    if carrier.dimension == 2 and not on_first:
        nodes = nodes[::-1]
    number = np.full(len(carrier.vertices), -1)
    number[nodes] = np.arange(len(nodes))
    return nodes, number


def _arc(carrier: Surface, on_first: bool) -> Array:
    arc = Chain(carrier).arc
    return arc if on_first else -arc


def _facets(corners: Indices, dimension: int, on_first: bool) -> Indices:
    """(F, c) facets whose corners all carry multipliers, in the sense of the contact."""
    facets = corners[np.all(corners >= 0, axis=1)]
    if dimension == 2:
        return facets if on_first else facets[::-1, ::-1]
    return facets[:, ::-1] if on_first else facets


def _totals(rows: Indices, values: Array, count: int) -> Array:
    """(count,) sums of values (n, c) by row (n, c); those of row -1 are left out."""
    return np.bincount(rows.ravel() + 1, values.ravel(), count + 1)[1:]


class _Pieces:
    """Points of an overlap in groups on the same pair of facets, for sums over each group."""

    def __init__(self, overlap: OverlapPoints) -> None:
        pairs = np.stack([overlap.facet1, overlap.facet2])
        changes = np.flatnonzero(np.any(np.diff(pairs, axis=1), axis=0)) + 1
        self._starts = np.array([0, *changes])
        self._counts = np.diff(np.array([*self._starts, len(overlap.weights)]))

    def operator(
        self, directed: Array, rows: Indices, side: _Side, degree: int, nodes: int
    ) -> sparse.csr_matrix:
        """(N*d, m*d) integrals of test functions times displacements of a surface.

        Args:
            directed: (n, c, d, d) hats at the points, times weights and frames.
            rows: (n, c) nodes of the hats, or -1.
            side: the surface and where the points are on it.
            degree: of the displacement.
            nodes: their number, N.
        """
        values, columns = side.trace(degree)
        count, corners, d = directed.shape[:3]
        sums = self._sums(directed.reshape(count, -1), values)
        sums = sums.reshape(len(sums), corners, d, d, -1)
        rows, columns = rows[self._starts], columns[self._starts]
        axes = np.arange(d)
        at_row = rows[:, :, None, None, None] * d + axes[:, None, None]
        at_column = columns[:, None, None, None] * d + axes[:, None]
        shape = nodes * d, len(side.surface.displacement_points(degree)) * d
        return _sparse(sums, at_row, at_column, shape)

    def products(self, tests: Array, hats: Array, rows: Indices, nodes: int) -> sparse.csr_matrix:
        """(N, N) integrals of test functions (n, c) times hats (n, c)."""
        first = rows[self._starts]
        sums = self._sums(tests, hats)
        kept = np.where(first[:, None, :] >= 0, sums, 0.0)
        return _sparse(kept, first[:, :, None], np.maximum(first, 0)[:, None], (nodes, nodes))

    def _sums(self, left: Array, right: Array) -> Array:
        """(p, a, b) sums over each group of the products of (n, a) and (n, b)."""
        sums = np.empty((len(self._counts), left.shape[1], right.shape[1]))
        for count in np.unique(self._counts):
            some = np.flatnonzero(self._counts == count)
            points = self._starts[some, None] + np.arange(count)
            sums[some] = np.swapaxes(left[points], 1, 2) @ right[points]
        return sums


def _sparse(
    values: Array, rows: Indices, columns: Indices, shape: tuple[int, int]
) -> sparse.csr_matrix:
    """Matrix of values summed by row and column; those of negative rows are left out."""
    rows, columns = np.broadcast_to(rows, values.shape), np.broadcast_to(columns, values.shape)
    kept = rows >= 0
    return sparse.csr_matrix((values[kept], (rows[kept], columns[kept])), shape=shape)
