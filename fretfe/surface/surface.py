# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces: boundary meshes of bodies, in the plane as open chains; their curvature."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array, Bools, Indices, Positions
from fretfe.errors import MeshError, ModelError
from fretfe.mesh.elements import (
    CORNERS,
    FACET_SHAPES,
    KINDS,
    MIDDLES,
    directed_facets,
    exterior_facets,
    lattice,
    quadrature,
    reference_nodes,
    row_keys,
    shape_slopes,
    shape_values,
)
from fretfe.mesh.mesh import BodyMesh

# Not loaded by whoever loads this module: until Gmsh begins SciPy would take a third of the time.
if TYPE_CHECKING:
    from scipy import sparse

# Facets whose normal turns by less than this angle (radians) are straight.
STRAIGHT = 1e-9
# Cosine of the angle between facets from which a body has an edge between them: 30 degrees, more
# than from one element to the next along a rounding.
SHARP = 0.866
# Gauss points along each direction of a facet for its measure.
GAUSS_POINTS = 4
# Places along each edge of a facet at which the nearest one is looked up.
SAMPLES: dict[str, int] = {"line": 17, "triangle": 9, "quadrilateral": 17}
# Corners at the ends of the sides along each reference direction.
SIDES = {
    "triangle": (((0, 1),), ((0, 2),)),
    "quadrilateral": (((0, 1), (3, 2)), ((0, 3), (1, 2))),
}
# Largest distance of a flat facet from a sphere over that of the longest of its edges.
MIDDLE_TO_EDGE = {"triangle": 4 / 3, "quadrilateral": 1.0}


@dataclass(frozen=True)
class Chain:
    """View of a plane surface as a curve of f facets, the body on the left of the direction.

    Attributes:
        surface: in the plane.

    Raises:
        ModelError: The surface is not in the plane.
    """

    surface: Surface

    def __post_init__(self) -> None:
        """Refuse surfaces in space."""
        if self.surface.dimension != 2:
            raise ModelError(
                f"surface {self.surface.name!r} of body {self.surface.body!r}: expected a curve in"
                " the plane, which has an arc length, found a surface in space."
            )

    @property
    def arc(self) -> Array:
        """(f + 1,) arc length at the facet ends, zero at the middle of the chain."""
        arc = np.concatenate([[0.0], np.cumsum(self.surface.measures)])
        return arc - arc[-1] / 2

    @property
    def mean_curvature(self) -> float:
        """Turning of the normal, without regard to its sign, per arc length."""
        return float(np.abs(self._turns()).sum() / self.surface.measures.sum())

    def _turns(self) -> Array:
        """(f,) angle by which the normal turns over each facet."""
        sine = _cross(self.surface.normals[:, 0], self.surface.normals[:, 1])
        turns = np.arcsin(np.clip(sine, -1.0, 1.0))
        # A straight surface has no curvature, not that of the round-off in its nodes.
        return np.where(np.abs(turns) > STRAIGHT, turns, 0.0)

    @property
    def curvatures(self) -> Array:
        """(f,) largest curvature of each facet, without sign; 0 for straight surfaces.

        Curved facets: |x' × x''|/|x'|³ at the nodes. Straight facets: the angle between two of them
        over the distance of their middles, the larger at both ends.
        """
        curvatures = self._inside() if self.surface.degree == 2 else self._between()
        # The round-off in the nodes of a straight surface is no curvature.
        return np.where(curvatures * self.surface.measures > STRAIGHT, curvatures, 0.0)

    def _inside(self) -> Array:
        nodes = self.surface.nodes
        slopes = shape_slopes("line", 2, np.array([[0.0], [0.5], [1.0]]))[:, 0]
        first = np.einsum("qk,fkd->fqd", slopes, nodes)
        second = 4 * (nodes[:, :1] + nodes[:, 1:2] - 2 * nodes[:, 2:])
        return (np.abs(_cross(first, second)) / np.linalg.norm(first, axis=2) ** 3).max(axis=1)

    def _between(self) -> Array:
        chords = np.diff(self.surface.vertices, axis=0)
        before, after = chords[:-1], chords[1:]
        turns = np.abs(np.arctan2(_cross(before, after), np.sum(before * after, axis=1)))
        lengths = self.surface.measures
        at_ends = np.concatenate([[0.0], 2 * turns / (lengths[:-1] + lengths[1:]), [0.0]])
        return np.maximum(at_ends[:-1], at_ends[1:])

    @property
    def deviations(self) -> Array:
        """(f,) distance of each facet from the smooth curve through its nodes.

        A facet of length h turns by the angle θ = h/R. Straight: the sagitta hθ/8 of an arc.
        Curved: hθ³/512, the deviation of a parabola through both ends and the middle of
        an arc at a quarter of its length. Both are the first terms of series, wrong by less than
        7 % for θ < 30°.
        """
        lengths = self.surface.measures
        turns = lengths * self.curvatures
        return lengths * (turns / 8 if self.surface.degree == 1 else turns**3 / 512)


def _cross(first: Array, second: Array) -> Array:
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def chain_order(facets: Indices, where: str) -> Indices:
    """Order (f,) in which facets (f, 2 or 3) follow each other from the first end to the last.

    Args:
        facets: node numbers, ends first.
        where: what they belong to, for messages.

    Raises:
        MeshError: The facets do not form one open chain.
    """
    by_start = {int(start): i for i, start in enumerate(facets[:, 0])}
    firsts = np.setdiff1d(facets[:, 0], facets[:, 1])
    order = [by_start[int(first)] for first in firsts[:1]]
    for _ in facets[1:]:
        following = by_start.get(int(facets[order[-1], 1])) if order else None
        if following is None:
            break
        order.append(following)
    if len(set(order)) != len(facets):
        pieces = {0: "a closed curve", 1: "an open and a closed curve"}
        kind = pieces.get(len(firsts), f"{len(firsts)} separate pieces")
        raise MeshError(
            f"{where}: a contact surface must be one open curve, but its facets form {kind}. "
            "Give each piece a physical group and a contact of its own."
        )
    return np.array(order)


@dataclass(frozen=True)
class Surface:
    """Boundary mesh of f facets of one shape and degree, in d dimensions.

    In the plane the facets follow each other along an open chain; see `fretfe.surface.surface`.

    Attributes:
        name: physical group of the facets.
        body: name of the body that the surface belongs to.
        points: (n, d) coordinates, corners of facets first.
        facets: (f, k) numbers of each facet's points in Gmsh order, corners first. They run so
            that the body is on the left in the plane, counter-clockwise seen from outside in space.
        shape: of the facets.
        degree: of the facets, 1 or 2.
        normals: (f, k, d) outward unit normals at `nodes`, equal where facets meet.
        ends: (e, 2) corners at the edges of the rim where the body ends: where its own surface goes
            on around a convex edge. At others it goes on smoothly. None in the plane.
    """

    name: str
    body: str
    points: Array
    facets: Indices
    shape: str
    degree: int
    normals: Array
    ends: Indices = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))

    @property
    def dimension(self) -> int:
        """Number of coordinates, d."""
        return self.points.shape[1]

    @property
    def nodes(self) -> Array:
        """(f, k, d) coordinates of the nodes of each facet."""
        return self.points[self.facets]

    @property
    def corners(self) -> Indices:
        """(f, c) numbers of each facet's corners."""
        return self.facets[:, : CORNERS[self.shape]]

    @property
    def vertices(self) -> Array:
        """(v, d) coordinates of the corners of all facets."""
        return self.points[: self.corners.max() + 1]

    @cached_property
    def measures(self) -> Array:
        """(f,) arc lengths or areas of the facets."""
        at, weights = quadrature(self.shape, GAUSS_POINTS)
        return self._densities(at) @ weights

    @property
    def sizes(self) -> Array:
        """(f,) lengths of the facets, or roots of their areas."""
        return self.measures ** (1 / (self.dimension - 1))

    def integration_points(self, count: int) -> tuple[Array, Array]:
        """(n, d) Gauss points of all facets, and outward normals (n, d) as long as their areas."""
        at, weights = quadrature(self.shape, count)
        values = shape_values(self.shape, self.degree, at)
        places = np.einsum("qk,fkd->fqd", values, self.nodes)
        vectors = normal_vectors(self.nodes, self.shape, self.degree, at) * weights[:, None]
        return places.reshape(-1, self.dimension), vectors.reshape(-1, self.dimension)

    @property
    def extent(self) -> float:
        """Length of the whole surface, or the root of its area."""
        return float(self.measures.sum() ** (1 / (self.dimension - 1)))

    @cached_property
    def hat_products(self) -> sparse.csr_array:
        """(v, v) integrals of products of the hat functions over the whole surface."""
        from scipy import sparse

        at, weights = quadrature(self.shape, GAUSS_POINTS)
        values = shape_values(self.shape, 1, at)
        shares = np.einsum("fq,q,qc,qd->fcd", self._densities(at), weights, values, values)
        rows = np.broadcast_to(self.corners[:, :, None], shares.shape)
        places = rows.ravel(), rows.swapaxes(1, 2).ravel()
        return sparse.csr_array((shares.ravel(), places), shape=(len(self.vertices),) * 2)

    def _densities(self, at: Array) -> Array:
        """(f, q) measure of the facets per measure of the reference at coordinates (q, d - 1)."""
        return np.linalg.norm(normal_vectors(self.nodes, self.shape, self.degree, at), axis=2)

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Sampled places (m, d) of the surface nearest to points (m, d), and unit normals there."""
        at = lattice(self.shape, SAMPLES[self.shape])
        values = shape_values(self.shape, self.degree, at)
        places = np.einsum("qk,fkd->fqd", values, self.nodes).reshape(-1, self.dimension)
        # Places on edges are there twice, which makes balanced trees slow.
        # Imported where it is needed: reports of plane contacts do without, a fifth of a second.
        from scipy.spatial import cKDTree

        tree = cKDTree(places, balanced_tree=self.dimension == 2)
        found = tree.query(points)[1]
        facet, sample = np.divmod(found, len(at))
        normals = np.einsum("mk,mkd->md", values[sample], self.normals[facet])
        return places[found], normals / np.linalg.norm(normals, axis=1, keepdims=True)

    def displacement_points(self, degree: int) -> Array:
        """(m, d) points of the trace of a Lagrange space of a degree, 1 or 2; vertices first."""
        if degree == 1:
            return self.vertices
        if self.degree == 2:
            return self.points
        facets = self.displacement_facets(2)
        points = np.empty((facets.max() + 1, self.dimension))
        values = shape_values(self.shape, 1, reference_nodes(self.shape, 2))
        points[facets] = np.einsum("qk,fkd->fqd", values, self.nodes)
        return points

    def displacement_facets(self, degree: int) -> Indices:
        """(f, k) numbers of each facet's points in `displacement_points`."""
        if degree == 1:
            return self.corners
        return self.facets if self.degree == 2 else _with_middles(self.corners, self.shape)


def perpendicular(vectors: Array) -> Array:
    """(..., d) vectors normal to d - 1 tangents (..., d - 1, d), as long as they are wide.

    The tangent turned clockwise in the plane, the cross product of both in space.
    """
    if vectors.shape[-1] == 2:
        x, y = vectors[..., 0, 0], vectors[..., 0, 1]
        return np.stack([y, -x], axis=-1)
    return np.cross(vectors[..., 0, :], vectors[..., 1, :])


def tangent_frames(normals: Array) -> Array:
    """(n, d, d) rows: unit normal (n, d), then unit tangents that vary as smoothly as it does.

    In the plane the tangent is the normal turned clockwise. In space the first one is n × e for the
    coordinate axis e that is farthest from all of the normals, z if there are several: that of the
    plane where normals have no component along z. The second one is n × t.
    """
    if normals.shape[1] == 2:
        return np.stack([normals, perpendicular(normals[:, None])], axis=1)
    alignment = np.abs(normals).max(axis=0)[::-1]
    axis = np.eye(3)[::-1][np.argmin(alignment.round(9))]
    first = np.cross(normals, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([normals, first, np.cross(normals, first)], axis=1)


def build_surface(mesh: BodyMesh, name: str) -> Surface:
    """Surface of boundary `name`, numbered along its chain in the plane.

    Raises:
        MeshError: The facets do not form one open chain, or those of a solid have no common
            orientation.
    """
    facets = mesh.boundaries[name]  # each with the body on its left
    shape = KINDS[mesh.points.shape[1], facets.shape[1]][0]
    where = f"surface {name!r} of body {mesh.name!r}"
    if shape == "line":
        facets = facets[chain_order(facets, where)]
    else:
        _require_orientation(facets[:, : CORNERS[shape]], where)
    return _surface(mesh, name, facets)


def boundary_surface(mesh: BodyMesh, name: str) -> Surface:
    """Surface of boundary `name`, in the plane of any number of curves, open or closed."""
    return _surface(mesh, name, mesh.boundaries[name])


def _surface(mesh: BodyMesh, name: str, facets: Indices) -> Surface:
    shape, degree = KINDS[mesh.points.shape[1], facets.shape[1]]
    nodes, corners = mesh.points[facets], facets[:, : CORNERS[shape]]
    numbers, facets = _renumbered(facets, CORNERS[shape])
    normals = _nodal_normals(nodes, facets, shape, degree)
    points = mesh.points[numbers]
    if shape == "line":
        return Surface(name, mesh.name, points, facets, shape, degree, normals)
    own = np.empty(len(mesh.points), dtype=np.int64)
    own[numbers] = np.arange(len(numbers))
    ends = own[_ends(mesh, corners)]
    return Surface(name, mesh.name, points, facets, shape, degree, normals, ends)


def _ends(mesh: BodyMesh, corners: Indices) -> Indices:
    """(e, 2) nodes at the edges of the rim of facets with corners (f, c) where a solid ends."""
    rim = rim_edges(corners)
    near = np.zeros(len(mesh.points), dtype=bool)
    near[rim] = True
    # Both facets at an edge belong to cells with both of its ends.
    beside = near[mesh.cells[:, : CORNERS[mesh.cell]]].sum(axis=1) > 1
    facets = directed_facets(mesh.cells[beside], mesh.cell, mesh.order)
    shape = FACET_SHAPES[mesh.cell]
    outside = exterior_facets(facets, shape)[0][:, : CORNERS[shape]]
    keys = row_keys(np.sort(np.concatenate([rim, facet_edges(outside)]), axis=1))
    rim_keys, edge_keys = np.split(keys, [len(rim)])
    order = np.argsort(edge_keys, kind="stable")
    first = np.searchsorted(edge_keys[order], rim_keys)
    last = np.searchsorted(edge_keys[order], rim_keys, side="right")
    met = last - first == 2
    one, other = (order[first[met] + place] // CORNERS[shape] for place in (0, 1))
    places = mesh.points[outside]
    normals = np.cross(places[:, 1] - places[:, 0], places[:, -1] - places[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    below = _dot(places[other].mean(axis=1) - places[one].mean(axis=1), normals[one]) < 0
    return rim[met][below & (_dot(normals[one], normals[other]) < SHARP)]


def _require_orientation(corners: Indices, where: str) -> None:
    """Refuse neighbours (f, c) that run along their common edge in the same direction."""
    edges = facet_edges(corners)
    repeated = len(edges) - len(np.unique(edges, axis=0))
    if repeated:
        raise MeshError(
            f"{where}: expected facets that all run counter-clockwise seen from outside the body,"
            f" but at {repeated} edges two neighbours run in opposite senses."
        )


def _renumbered(facets: Indices, corners: int) -> tuple[Indices, Indices]:
    """Nodes (n,) in the order in which facets name them, corners first; facets in those numbers."""
    numbers = np.concatenate([_first_seen(facets[:, :corners]), _first_seen(facets[:, corners:])])
    own = np.empty(facets.max() + 1, dtype=np.int64)
    own[numbers] = np.arange(len(numbers))
    return numbers, own[facets]


def _first_seen(values: Indices) -> Indices:
    found, first = np.unique(values, return_index=True)
    return found[np.argsort(first)]


def _with_middles(corners: Indices, shape: str) -> Indices:
    """(f, k) numbers of the nodes of degree 2 of facets with corners (f, c); neighbours share."""
    # each middle is known by the corners around it, -1 where it has fewer than others
    keys = np.full((len(corners), len(MIDDLES[shape]), max(map(len, MIDDLES[shape]))), -1)
    for number, around in enumerate(MIDDLES[shape]):
        keys[:, number, : len(around)] = np.sort(corners[:, around], axis=1)
    same = np.unique(keys.reshape(-1, keys.shape[2]), axis=0, return_inverse=True)[1]
    middles = _renumbered(same.reshape(len(corners), -1), keys.shape[1])[1]
    return np.concatenate([corners, corners.max() + 1 + middles], axis=1)


def normal_vectors(nodes: Array, shape: str, degree: int, at: Array) -> Array:
    """(f, q, d) outward normals at coordinates (q, d - 1), as long as the facet is stretched."""
    slopes = shape_slopes(shape, degree, at)
    return perpendicular(np.einsum("qak,fkd->fqad", slopes, nodes))


def _nodal_normals(nodes: Array, facets: Indices, shape: str, degree: int) -> Array:
    """(f, k, d) outward unit normals at the nodes, averaged where facets meet."""
    own = normal_vectors(nodes, shape, degree, reference_nodes(shape, degree))
    own /= np.linalg.norm(own, axis=2, keepdims=True)
    total = np.zeros((facets.max() + 1, nodes.shape[2]))
    np.add.at(total, facets, own)
    mean = total / np.linalg.norm(total, axis=1, keepdims=True)
    shared = np.bincount(facets.ravel()) > 1
    return np.where(shared[facets, None], mean[facets], own)


def mean_curvature(surface: Surface) -> float:
    """Mean size of the curvature: turning of the normal, without sign, per length.

    In space the root of the sum of the squares of both principal curvatures.
    """
    if surface.dimension == 2:
        return Chain(surface).mean_curvature
    (a, b), (turn_a, turn_b) = _along_sides(surface)
    # |W| dA for the gradient W of the normal that maps a onto turn_a and b onto turn_b
    squares = _dot(turn_a, turn_a) * _dot(b, b) + _dot(turn_b, turn_b) * _dot(a, a)
    squares -= 2 * _dot(turn_a, turn_b) * _dot(a, b)
    share = 0.5 if surface.shape == "triangle" else 1.0
    turning = share * np.sqrt(np.maximum(squares, 0.0))
    return float(turning.sum() / surface.measures.sum())


def _along_sides(surface: Surface) -> tuple[list[Array], list[Array]]:
    """Mean sides of each facet along both reference directions, and how the normal turns there."""
    pairs = [np.array(ends) for ends in SIDES[surface.shape]]
    sides = [np.diff(surface.nodes[:, ends], axis=2)[:, :, 0].mean(axis=1) for ends in pairs]
    turns = [
        _turns(surface.normals[:, ends[:, 0]], surface.normals[:, ends[:, 1]]).mean(axis=1)
        for ends in pairs
    ]
    return sides, turns


def bend(surface: Surface) -> float:
    """Largest angle between a normal and the mean one, to first order."""
    normals = surface.normals.reshape(-1, surface.dimension)
    mean = normals.mean(axis=0)
    return float(np.linalg.norm(normals - mean / np.linalg.norm(mean), axis=1).max())


def curvatures(surface: Surface) -> Array:
    """(f,) largest curvature of each facet, without sign; 0 for flat surfaces."""
    if surface.dimension == 2:
        return Chain(surface).curvatures
    lengths, turns = _between_corners(surface)
    return (turns / lengths).max(axis=1)


def facet_turns(surface: Surface) -> Array:
    """(f,) largest angle by which the normal turns over each facet; 0 for flat surfaces."""
    if surface.dimension == 2:
        return curvatures(surface) * surface.sizes
    return _between_corners(surface)[1].max(axis=1)


def deviations(surface: Surface) -> Array:
    """(f,) distance of each facet from the smooth surface through its nodes.

    First terms of series for an arc of length h that turns by θ: hθ/8 and, curved, hθ³/512; see
    `Chain.deviations`.
    """
    if surface.dimension == 2:
        return Chain(surface).deviations
    lengths, turns = _between_corners(surface)
    if surface.degree == 1:
        turns *= _missing_at_rim(surface)
    parts = lengths * (turns / 8 if surface.degree == 1 else turns**3 / 512)
    return MIDDLE_TO_EDGE[surface.shape] * parts.max(axis=1)


def _between_corners(surface: Surface) -> tuple[Array, Array]:
    """(f, p) distances of all pairs of corners of each facet, angles between the normals there."""
    first, second = _pairs(surface)
    lengths = np.linalg.norm(surface.nodes[:, first] - surface.nodes[:, second], axis=2)
    turns = np.linalg.norm(_turns(surface.normals[:, first], surface.normals[:, second]), axis=2)
    return lengths, turns


def _pairs(surface: Surface) -> Positions:
    """(2, p) all pairs of corners of a facet."""
    return np.array(list(combinations(range(surface.corners.shape[1]), 2))).T


def _missing_at_rim(surface: Surface) -> Array:
    """(f, p) upper bound of the turning between pairs of corners over what the normals show.

    At the rim of a surface of flat facets the normal is that of one side: of the turning between
    there and a corner inside up to a half is missing.
    """
    first, second = _pairs(surface)
    at_rim = rim_nodes(surface.corners, len(surface.vertices))[surface.corners]
    return np.where(at_rim[:, first] != at_rim[:, second], 2.0, 1.0)


def _turns(before: Array, after: Array) -> Array:
    """(..., 3) changes of unit normals, as long as the angle between them; 0 if it is round-off."""
    change = after - before
    distance = np.linalg.norm(change, axis=-1, keepdims=True)
    sine = np.linalg.norm(np.cross(before, after), axis=-1, keepdims=True)
    angle = np.arcsin(np.clip(sine, 0.0, 1.0))
    scale = np.divide(angle, distance, out=np.zeros_like(angle), where=angle > STRAIGHT)
    return np.asarray(scale * change)


def _dot(first: Array, second: Array) -> Array:
    return np.asarray(np.sum(first * second, axis=-1))


def facet_edges(corners: Indices) -> Indices:
    """(F * c, 2) ends of the edges of facets with corners (F, c), in the sense of each facet."""
    return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)


def edges_once(corners: Indices) -> Indices:
    """(E, 2) ends of the edges of facets with corners (F, c), each edge once."""
    return np.unique(np.sort(facet_edges(corners), axis=1), axis=0)


def rim_edges(corners: Indices) -> Indices:
    """(E, 2) ends of the edges that only one of the facets with corners (F, c) has."""
    edges = np.sort(facet_edges(corners), axis=1)
    found, facets = np.unique(edges, axis=0, return_counts=True)
    return found[facets == 1]


def rim_nodes(corners: Indices, count: int) -> Bools:
    """(count,) nodes at the ends of edges that only one of the facets with corners (F, c) has."""
    rim = np.zeros(count, dtype=bool)
    rim[rim_edges(corners)] = True
    return rim
