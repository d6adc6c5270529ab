# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mortar coupling of two contact surfaces, integrated over their true overlap segments.

The traction on body 2 is τ = Σ φ_i (−p_i n + q_i·t): hat functions φ_i on the facet ends of the
side that carries the multipliers, n the outward normal of body 2, t the tangents (in the plane n
turned clockwise, so that x = t and y = n). Work conjugate to it are the weighted gap
∫ φ_i [(u_1 − u_2)·n + gap] and the weighted tangential displacement ∫ φ_i (u_2 − u_1)·t.

Integrals run over the surface of body 2, whichever side carries the multipliers, at the points of
`overlap_points`: these say which facets lie opposite each other, and where.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from fretfe._core import _kernels
from fretfe._typing import Array, Bools, Indices, Positions
from fretfe.errors import ModelError
from fretfe.mesh.elements import BULGE, MIDDLES, quadrature, seven_points, shape_values
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.normals import contact_normals
from fretfe.surface.surface import Chain, Surface, rim_edges, tangent_frames

# Not loaded by whoever loads this module: until Gmsh begins SciPy would take a third of the time.
if TYPE_CHECKING:
    from scipy import sparse

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
# Bodies end at the same place if their ends are that close, over an element at them.
SAME_END = 0.1
# Hats with less than this fraction of their support inside the overlap carry no multiplier.
SMALLEST_SUPPORT = 1e-6


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
    normals = contact_normals(surface1, surface2)
    if surface1.dimension == 3:
        square = quadrature("quadrilateral", GAUSS_POINTS)
        return project(surface2, normals, surface1, square, _triangle_rule(surface1, surface2))
    at, weights = quadrature("line", GAUSS_POINTS)
    return project(surface2, normals, surface1, (at[:, 0], weights))


def project(near: Surface, normals: Array, far: Surface, *rules: Rule) -> OverlapPoints:
    """Project points of one surface along normals onto another one.

    Args:
        near: surface 2.
        normals: (f, k, d) unit normals at the nodes of `near`.
        far: surface 1.
        rules: points and weights (q,) of the quadrature: in the plane one rule with points (q,) in
            [0, 1]; in space those on quadrilaterals and on triangles, with points (q, 2).
    """
    plane = near.dimension == 2
    reach = search_reach(near, far)
    candidates = opposite_candidates(near, normals, far, reach)
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


@dataclass(frozen=True)
class Coupling:
    """Coupling operators of one contact pair; N multiplier nodes in space of d dimensions.

    Displacements and tractions have d components, between plane bodies that move along z too 3 of
    them, along the normal, the tangent and z. Rows of the operators belong to node i and component
    c at row i*components + c.

    Attributes:
        surface: the nodes; weights are integrals over the overlap, frames means around the nodes,
            facets those that have a node at each corner. Where bodies go on is not known here.
        averaging: (N, N) mean of a traction around each node, ∫ φ_i Σ φ_j λ_j / ∫ φ_i.
        gap: (N,) weighted initial gap, ∫ φ_i gap.
        body1, body2: (N*components, n) operators on the surface displacements of each body.
    """

    surface: ContactSurface
    averaging: sparse.csr_matrix
    gap: Array
    body1: sparse.csr_matrix
    body2: sparse.csr_matrix


def couple(
    name: str,
    surface1: Surface,
    surface2: Surface,
    multipliers: str,
    degree: int,
    components: int | None = None,
) -> Coupling:
    """Build the coupling of a contact pair.

    Args:
        name: of the contact, for messages.
        surface1: surface of body 1.
        surface2: surface of body 2.
        multipliers: "surface1", "surface2" or "finer": the side that carries the multipliers.
        degree: of the displacement space.
        components: of the displacement; without it as many as the surfaces have coordinates.

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
    size = components or surface1.dimension
    return _assemble(overlap, surface1, surface2, on_first, degree, size)


def _facet_size(surface: Surface) -> float:
    return float(np.median(surface.sizes))


def _assemble(
    overlap: OverlapPoints,
    surface1: Surface,
    surface2: Surface,
    on_first: bool,
    degree: int,
    components: int,
) -> Coupling:
    """Coupling from the points of the overlap and a displacement space of a degree."""
    from scipy import sparse

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
    frames = _with_across(tangent_frames(np.vstack([overlap.normals, mean])), components)
    count, d = overlap.normals.shape
    # The gap opens with u_1 along n; the tangential displacement grows with u_2 along t.
    signs = np.array([1.0, *[-1.0] * (components - 1)])[:, None]
    pieces = _Pieces(overlap)
    directed = tests[:, :, None, None] * (signs * frames[:count])[:, None]
    body1, body2 = (
        pieces.operator(sign * directed, rows, side, degree, len(nodes))
        for sign, side in zip((1.0, -1.0), sides, strict=True)
    )
    free = (
        _free(carrier.surface, sides[on_first].surface, nodes, mean, np.sqrt(support))
        if d == 3
        else None
    )
    return Coupling(
        surface=ContactSurface(
            arc=_arc(carrier.surface, on_first)[nodes] if d == 2 else np.empty(0),
            points=carrier.surface.vertices[nodes],
            frames=frames[count:],
            weights=support,
            facets=_facets(number[carrier.surface.corners], on_first) if d == 3 else None,
            free=free,
        ),
        averaging=sparse.diags(1 / support).tocsr()
        @ pieces.products(tests, hats, rows, len(nodes)),
        gap=_totals(rows, tests * overlap.gap[:, None], len(nodes)),
        body1=body1,
        body2=body2,
    )


def _with_across(frames: Array, components: int) -> Array:
    """Frames (n, d, d) of so many components: in the plane the third one is along z."""
    more = components - frames.shape[1]
    if not more:
        return frames
    wider = np.zeros((len(frames), components, components))
    wider[:, :-more, :-more], wider[:, -1, -1] = frames, 1.0
    return wider


def _free(carrier: Surface, other: Surface, nodes: Indices, normals: Array, sizes: Array) -> Bools:
    """(N,) nodes of a surface at which its body and the opposite one end, seen along normals.

    Args:
        carrier: the surface.
        other: the opposite one.
        nodes: (N,) vertices of the surface.
        normals: (N, d) unit normals of the contact.
        sizes: (N,) of elements around the nodes.
    """
    count, free = len(carrier.vertices), np.zeros(len(nodes), dtype=bool)
    all_edges = np.bincount(rim_edges(carrier.corners).ravel(), minlength=count)
    ending = np.bincount(carrier.ends.ravel(), minlength=count)
    reach, segments = search_reach(carrier, other), other.vertices[other.ends]
    # A node belongs to the end of its body if all edges of the rim there do.
    for row in np.flatnonzero(((ending > 0) & (ending == all_edges))[nodes]):
        start, end = np.moveaxis(segments - carrier.vertices[nodes[row]], 1, 0)
        normal = normals[row]
        apart, along = (each - (each @ normal)[:, None] * normal for each in (start, end - start))
        share = -np.sum(along * apart, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-300)
        share = np.clip(share, 0.0, 1.0)[:, None]
        aside = np.linalg.norm(apart + share * along, axis=1)
        height = np.abs((start + share * (end - start)) @ normal)
        free[row] = np.any((aside <= SAME_END * sizes[row]) & (height <= reach))
    return free


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


def _facets(corners: Indices, on_first: bool) -> Indices:
    """(F, c) facets whose corners all carry multipliers, in the sense of the contact."""
    facets = corners[np.all(corners >= 0, axis=1)]
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
        """(N*d, m*d) integrals of test functions times displacements of d components of a surface.

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
    from scipy import sparse

    rows, columns = np.broadcast_to(rows, values.shape), np.broadcast_to(columns, values.shape)
    kept = rows >= 0
    return sparse.csr_matrix((values[kept], (rows[kept], columns[kept])), shape=shape)
