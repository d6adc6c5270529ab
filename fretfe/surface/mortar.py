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

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.errors import ModelError
from fretfe.mesh.elements import reversal, shape_values
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.normals import contact_normals
from fretfe.surface.overlap import (
    Candidates,
    OverlapPoints,
    opposite_candidates,
    overlap_along,
    search_reach,
)
from fretfe.surface.surface import (
    Chain,
    Surface,
    bend,
    curvatures,
    mean_curvature,
    rim_edges,
    tangent_frames,
)

# Not loaded by whoever loads this module: until Gmsh begins SciPy would take a third of the time.
if TYPE_CHECKING:
    from scipy import sparse

# Bodies end at the same place if their ends are that close, over an element at them.
SAME_END = 0.1
# Hats with less than this fraction of their support inside the overlap carry no multiplier.
SMALLEST_SUPPORT = 1e-6
# Part of the support of a hat by which curved surfaces that slide change it.
WHOLE = 0.01
# Hats over a surface (v,), height (v,) of that and normal (v, d) over these.
Heights = tuple[Array, Array, Array]
# Part of the largest curvature of a surface below which it is flat.
FLAT = 0.01
# Radians: a surface whose normals turn by less is flat, but for the round-off in its nodes.
SMALLEST_BEND = 1e-3


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
        slid: the gap once bodies have slid; None if that stays as it is: next to a surface that
            is flat all over, and between arcs, whose shape is the same everywhere.
    """

    surface: ContactSurface
    averaging: sparse.csr_matrix
    gap: Array
    body1: sparse.csr_matrix
    body2: sparse.csr_matrix
    slid: SlidGap | None = None


@dataclass(frozen=True)
class SlidGap:
    """The gap between two surfaces with flats and roundings one of which has slid along the other.

    Pairs of opposite points stay pairs, and their operators know of a sliding no more than its part
    along the contact normal. What the profiles open or close beyond that is told here: where each
    body has a rounding, the flat between them becomes shorter or longer. Both bodies move past
    places midway, each by its part of the sliding.

    Attributes:
        surface1, surface2: of the bodies, in place.
        normals: (f, k, d) unit normals of the contact at the nodes of surface 2.
        share: of the sliding that body 2 does, the other way.
        products: (N, v) integrals of hats of the N nodes times those of surface 2.
        frames: (N, c, c) of the nodes, for displacements of c components.
    """

    surface1: Surface
    surface2: Surface
    normals: Array
    share: float
    products: sparse.csr_matrix
    frames: Array

    def opened(self, displacement: Array, force: Array) -> Array:
        """(N,) gap that sliding opens beyond its part along the normal, times the support.

        Args:
            displacement: (N, c - 1) of body 2 relative to body 1 along the tangents.
            force: (N,) by pressure: bodies have slid by the mean of what it presses together.
        """
        pressed = np.maximum(force, 0.0)
        shares = pressed / pressed.sum() if pressed.any() else np.full(len(force), 1 / len(force))
        along = np.einsum("n,na,nad->d", shares, displacement, self.frames[:, 1:])
        sliding = -along[: self.surface1.dimension]
        # Farther than opposite points are looked for nothing is followed.
        farthest = search_reach(self.surface1, self.surface2)
        sliding *= min(1.0, farthest / max(float(np.linalg.norm(sliding)), 1e-300))
        first = self._risen(0, (1 - self.share) * sliding)
        return np.asarray(self.products @ (first - self._risen(1, -self.share * sliding)))

    @cached_property
    def _nearby(self) -> float:
        """Sliding up to which opposite facets are looked for once: that takes most of the time."""
        return search_reach(self.surface1, self.surface2) / 16

    @cached_property
    def _sides(self) -> tuple[tuple[Surface, Heights, Candidates], ...]:
        """Both surfaces, surface 2 seen from its body, heights in place, and opposite facets."""
        near, found = self.surface2, []
        turned = near.facets[:, reversal(near.shape, near.degree)]
        for far in (self.surface1, replace(near, facets=turned)):
            reach = search_reach(far, near), self._nearby
            candidates = opposite_candidates(near, self.normals, far, *reach)
            found.append((far, self._heights(far, None), candidates))
        return tuple(found)

    def _risen(self, number: int, sliding: Array) -> Array:
        """(v,) height above the vertices of surface 2 by which one of both rises as it slides."""
        from scipy import sparse
        from scipy.sparse.linalg import spsolve
        from scipy.spatial import cKDTree

        far, (before, initial, pull), nearby = self._sides[number]
        known = nearby if np.linalg.norm(sliding) <= self._nearby else None
        support, height, _ = self._heights(replace(far, points=far.points + sliding), known)
        products = self.surface2.hat_products
        full = products.sum(axis=1)
        whole = np.flatnonzero(np.minimum(before, support) > (1 - WHOLE) * full)
        if not len(whole):
            return np.zeros(len(height))
        # Next to the end of the other surface as at the nearest node all of whose hat is met.
        vertices = self.surface2.vertices
        nearest = cKDTree(vertices[whole]).query(vertices)[1]
        spread = sparse.eye_array(len(whole), format="csr")[nearest]
        mean = height[whole] / support[whole] - (initial + pull @ sliding)[whole] / before[whole]
        # The mean with a hat belongs to its middle, which is no node where elements are uneven:
        # taken for the value there, what the surface rises would become a pressure.
        whole_products = (products[whole] @ spread).tocsc()
        return np.asarray(spread @ spsolve(whole_products, full[whole] * mean))

    def _heights(self, far: Surface, known: Candidates | None) -> Heights:
        """Hats of surface 2 over another one (v,), height (v,) and normal (v, d) over these."""
        overlap = overlap_along(self.normals, far, self.surface2, known)
        hats, vertices = _Side(self.surface2, overlap.facet2, overlap.at2).hats()
        tests, count = hats * overlap.weights[:, None], len(self.surface2.vertices)
        parts = (np.ones(len(overlap.gap)), overlap.gap, *overlap.normals.T)
        sums = [_totals(vertices, tests * part[:, None], count) for part in parts]
        return sums[0], sums[1], np.stack(sums[2:], axis=1)


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
    normals = contact_normals(surface1, surface2)
    overlap = overlap_along(normals, surface1, surface2)
    if not len(overlap.weights):
        raise ModelError(
            f"contact {name!r}: surfaces {surface1.name!r} and {surface2.name!r} never face each "
            "other within half their size; expected two boundaries that look at each other. "
            "Check the names, and that the bodies are in their working position."
        )
    size = components or surface1.dimension
    coupling, rows, tests = _assemble(overlap, surface1, surface2, on_first, degree, size)
    if not (_partly_flat(surface1) and _partly_flat(surface2)):
        return coupling
    first, second = (mean_curvature(surface) for surface in (surface1, surface2))
    hats, vertices = _Side(surface2, overlap.facet2, overlap.at2).hats()
    products = _sparse(
        tests[:, :, None] * hats[:, None],
        rows[:, :, None],
        vertices[:, None],
        (len(coupling.gap), len(surface2.vertices)),
    )
    slid = SlidGap(
        surface1=surface1,
        surface2=surface2,
        normals=normals,
        share=first / (first + second),
        products=products,
        frames=coupling.surface.frames,
    )
    return replace(coupling, slid=slid)


def _partly_flat(surface: Surface) -> bool:
    """True if a surface has flat and rounded parts."""
    found = curvatures(surface)
    return bool(bend(surface) > SMALLEST_BEND and found.min() < FLAT * found.max())


def _facet_size(surface: Surface) -> float:
    return float(np.median(surface.sizes))


def _assemble(
    overlap: OverlapPoints,
    surface1: Surface,
    surface2: Surface,
    on_first: bool,
    degree: int,
    components: int,
) -> tuple[Coupling, Indices, Array]:
    """Coupling from the points of the overlap; nodes (n, c) and weighted hats (n, c) at these."""
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
    coupling = Coupling(
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
    return coupling, rows, tests


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
    nodes = np.flatnonzero(support > SMALLEST_SUPPORT * carrier.hat_products.sum(axis=1))
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
