# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors of a disc: one side moves as the other one, turned by a full turn over their number.

Parts of a body that are bonded are tied in the same way, without a turn (`bonds`).

Statically all sectors do the same (nodal diameter 0), so u(R x) = R u(x) for places x of one side,
R the rotation about the axis by a sector. The side with more nodes follows the other one: its nodes
that are images of nodes move as these, the others so that both sides differ by nothing that
multipliers on the following side would feel (mortar: Bernardi, Maday and Patera 1994):

    ∫ ψ_i (u_s − R u_m) = 0,    ψ_i = φ_i + Σ_r T_ri φ_r

with the shape functions φ_i of these nodes. Nodes r that are given, because they are images of
nodes or are where a side ends and something else may act, have no ψ: theirs are shared by others so
that the ψ still add up to 1, and to linear functions where enough nodes are near.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.case import Symmetry, complaint
from fretfe.case.model import Key
from fretfe.errors import CaseError
from fretfe.mesh.elements import (
    lattice,
    nearest_on_facets,
    quadrature,
    reference_nodes,
    shape_values,
)
from fretfe.mesh.mesh import BodyMesh, place_text
from fretfe.surface.overlap import GAUSS_POINTS, project
from fretfe.surface.surface import (
    SAMPLES,
    Surface,
    boundary_surface,
    facet_edges,
    rim_edges,
)

# Distances of the turned image of a side from the other side, and places that are one node, over
# the size of the body: mesh files may be rounded to this.
SAME = 1e-6
# Facets whose samples are nearest to a node and that it is looked for on.
NEAREST_SAMPLES = 12
# Weights below this are left out.
NEGLIGIBLE = 1e-13


@dataclass(frozen=True)
class Tie:
    """Nodes of one side of a sector that follow those of the other one.

    u(followers) = turn (weights u(leaders)); nodes on the axis move along it only.

    Attributes:
        followers: (s, d) places.
        leaders: (m, d) places, corners of elements first.
        weights: (s, m) displacements of followers, not yet turned, by those of leaders.
        turn: (c, c) rotation of displacements from the leaders' side to the followers'.
        on_axis: (a, d) places of nodes on the axis.
        across: (2, c) unit vectors across the axis.
        centre: (d,) a point on the axis.
        size: of the body.
        source: the side of the leaders, a physical group.
        groups: of followers and of leaders, physical groups, where both are in the same place.
    """

    followers: Array
    leaders: Array
    weights: sparse.csr_matrix
    turn: Array
    on_axis: Array
    across: Array
    centre: Array
    size: float
    source: str
    groups: tuple[tuple[str, ...], tuple[str, ...]] = ((), ())

    def image(self, values: Array) -> Array:
        """(s, c) vectors at the followers by those (m, c) at the leaders."""
        return np.asarray((self.weights @ values) @ self.turn.T)

    def violation(self, motions: Callable[[Array], Array]) -> Array:
        """(n, k) parts of motions, (m, c, k) at points (m, d), that the tie forbids."""
        leading = np.moveaxis(motions(self.leaders), 2, 0)
        wanted = np.stack([self.image(each) for each in leading], axis=2)
        across = np.einsum("ad,ndk->nak", self.across, motions(self.on_axis))
        count = len(leading)
        return np.concatenate(
            [
                (motions(self.followers) - wanted).reshape(-1, count),
                across.reshape(-1, count),
            ]
        )

    def mismatch(self, field: Callable[[Array], Array]) -> float:
        """Largest part of a tensor field that differs at the sides, over its size there.

        Args:
            field: (n, 3, 3) at places (n, d).
        """
        turn, size = np.eye(3), len(self.turn)
        turn[:size, :size] = self.turn
        leading, following = field(self.leaders), field(self.followers)
        image = (self.weights @ leading.reshape(-1, 9)).reshape(-1, 3, 3)
        largest = max(np.abs(leading).max(), np.abs(following).max())
        return float(np.abs(following - turn @ image @ turn.T).max() / (largest or 1.0))

    def passed_on(self, forces: Array) -> Array:
        """(m, c) forces on the leaders that work as those (s, c) on the followers do."""
        return np.asarray(self.weights.T @ (forces @ self.turn))

    def moving(self, components: int) -> Tie:
        """The same tie of displacements with 3 components, of plane bodies the third along z."""
        more = components - len(self.turn)
        if not more:
            return self
        turn = np.eye(components)
        turn[:-more, :-more] = self.turn
        return replace(self, turn=turn, across=np.pad(self.across, ((0, 0), (0, more))))

    def from_axis(self, points: Array) -> Array:
        """(n, 2) places seen from the axis, across it."""
        size = points.shape[1]
        return np.asarray((points - self.centre) @ self.across[:, :size].T)

    def radial(self, points: Array) -> Array:
        """(n, c) unit vectors away from the axis at points (n, d); zero on the axis."""
        arms = self.from_axis(points)
        length = np.linalg.norm(arms, axis=1, keepdims=True)
        length[length < SAME * self.size] = np.inf
        return np.asarray(arms / length @ self.across)

    def tangential(self, points: Array) -> Array:
        """(n, c) unit vectors about the axis at points (n, d); zero on the axis."""
        x, y = self.across
        return np.asarray(self.radial(points) @ (np.outer(x, y) - np.outer(y, x)))

    def among(self, own: Array, points: Array) -> Bools:
        """(n,) whether places of the sides (n, d) are among points (m, d)."""
        if not len(points):
            return np.zeros(len(own), dtype=bool)
        return np.asarray(cKDTree(points).query(own)[0] < SAME * self.size)


@dataclass(frozen=True)
class _Place:
    """Places of k nodes on a surface: distances (k,) from it, facets (k,), weights (k, m)."""

    distance: Array
    facets: Indices
    weights: sparse.csr_matrix


@dataclass(frozen=True)
class _Miss:
    """The place of a side that is farthest from the turned other one.

    Attributes:
        excess: its distance less what curved facets explain.
        distance: from the other side.
        place: (d,) it, not turned.
        forth: whether it is of the first side.
    """

    excess: float
    distance: float
    place: Array
    forth: bool


def tie_sides(symmetry: Symmetry, key: Key, source: Path, mesh: BodyMesh, degree: int) -> Tie:
    """Tie the sides of a sector on one body.

    Args:
        symmetry: sides, axis and number of sectors.
        key: of the table in the case file, for messages.
        source: the case file, for messages.
        mesh: of the body, with both sides.
        degree: of the displacements.

    Raises:
        CaseError: if the sides are not images of one another.
    """
    gdim = mesh.points.shape[1]
    names = (symmetry.boundary1, symmetry.boundary2)
    sides = [boundary_surface(mesh, name) for name in names]
    size = float(np.ptp(mesh.points, axis=0).max())
    across, centre = _across(symmetry, gdim), np.array(symmetry.centre)
    if len(sides[0].displacement_points(degree)) > len(sides[1].displacement_points(degree)):
        sides, names = sides[::-1], names[::-1]
    turns = [_rotation(across, sign * 2 * np.pi / symmetry.sectors, gdim) for sign in (1.0, -1.0)]
    misses = [_miss(sides[0], sides[1], turn, centre) for turn in turns]
    best = int(misses[1].excess < misses[0].excess)
    if misses[best].excess > SAME * size:
        raise CaseError(
            complaint(source, key, _no_images(mesh.name, symmetry, names, misses[best]))
        )
    if symmetry.sectors > 2 and _along(sides[0], centre, across, (1.0, -1.0)[best]) > 0:
        # A half and its complement are the same.
        text = (
            f"expected a sector of 360°/{symmetry.sectors} between the sides of the body "
            f"{mesh.name!r}, found one of {360 - 360 / symmetry.sectors:.6g}°, which overlaps its "
            "neighbours: check sectors, and which side of the cuts was kept"
        )
        raise CaseError(complaint(source, key, text))
    return _tied(sides[0], sides[1], turns[best], across, centre, size, degree)


def _tied(
    leading: Surface,
    following: Surface,
    turn: Array,
    across: Array,
    centre: Array,
    size: float,
    degree: int,
) -> Tie:
    leaders, followers = (each.displacement_points(degree) for each in (leading, following))
    image = replace(leading, points=centre + (leading.points - centre) @ turn.T)
    axial = np.linalg.norm((followers - centre) @ across.T, axis=1) < SAME * size
    weights = Mortar(following, image, degree, SAME * size).weights()
    return Tie(
        followers[~axial],
        leaders,
        weights[~axial],
        turn,
        followers[axial],
        across,
        centre,
        size,
        leading.name,
    )


class Mortar:
    """Displacements of a side by those of a surface at the same place.

    Args:
        side: that follows.
        image: of the side that leads, turned to the place of the other one.
        degree: of the displacements.
        same: distance up to which places are one.
        held: (s,) nodes that move as the place of the image does; without them those where the side
            ends. Nodes of both in one place are one, too: all of them, or, where nodes are held,
            none.
    """

    def __init__(
        self,
        side: Surface,
        image: Surface,
        degree: int,
        same: float,
        held: Bools | None = None,
    ) -> None:
        self._side, self._image, self._degree = side, image, degree
        points = side.displacement_points(degree)
        distance, node = cKDTree(image.displacement_points(degree)).query(points)
        self._matched = distance < same
        self._shape = len(points), len(image.displacement_points(degree))
        rows = self._matched.copy()
        if held is None:
            rows[_end_nodes(side, degree)] = True
        elif not (rows.all() and rows.sum() == self._shape[1]):
            self._matched &= held
            rows = held
        self._given = rows
        placed = sparse.csr_matrix((0, self._shape[1]))
        if rows.any():
            placed = places_on(points[rows], image, degree).weights
        exact = sparse.csr_matrix(
            (np.ones(self._matched.sum()), (np.flatnonzero(self._matched), node[self._matched])),
            shape=self._shape,
        )
        spread = sparse.eye(len(points), format="csr")[:, np.flatnonzero(rows)]
        self._pinned = sparse.diags(1.0 - self._matched) @ spread @ placed + exact

    def weights(self) -> sparse.csr_matrix:
        """(s, m) displacements of the side by those of the image."""
        weights = self._pinned
        if not self._given.all():
            free = np.flatnonzero(~self._given)
            own, other = (self._tests()[free] @ each for each in self._products())
            asked = (other - own @ self._pinned).toarray()
            solved = splu(own[:, free].tocsc()).solve(asked)
            solved[np.abs(solved) < NEGLIGIBLE] = 0.0
            spread = sparse.eye(len(self._given), format="csr")[:, free]
            weights = weights + spread @ sparse.csr_matrix(solved)
        weights = weights.tocsr()
        weights.eliminate_zeros()
        return weights

    def _products(self) -> Iterator[sparse.csr_matrix]:
        """(s, s) and (s, m) integrals of functions of the side times those of both."""
        side, image, degree = self._side, self._image, self._degree
        line, weights = quadrature("line", GAUSS_POINTS)
        in_space = [quadrature(each, GAUSS_POINTS) for each in ("quadrilateral", "triangle")]
        rules = in_space if side.dimension == 3 else [(line[:, 0], weights)]
        points = project(side, side.normals, image, *rules)
        rows = side.displacement_facets(degree)[points.facet2]
        tests = shape_values(side.shape, degree, points.at2) * points.weights[:, None]
        for surface, facet, at in (
            (side, points.facet2, points.at2),
            (image, points.facet1, points.at1),
        ):
            columns = surface.displacement_facets(degree)[facet]
            values = tests[:, :, None] * shape_values(surface.shape, degree, at)[:, None]
            places = np.broadcast_arrays(rows[:, :, None], columns[:, None])
            yield sparse.csr_matrix(
                (values.ravel(), tuple(each.ravel() for each in places)),
                shape=(len(self._given), len(surface.displacement_points(degree))),
            )

    def _tests(self) -> sparse.csr_matrix:
        """(s, s) functions of nodes that test functions are sums of; none of given nodes."""
        facets = self._side.displacement_facets(self._degree)
        given, at = self._given[facets], reference_nodes(self._side.shape, self._degree)
        lent, count = np.zeros((*facets.shape, facets.shape[1])), np.zeros(len(self._given))
        for pattern in np.unique(given, axis=0):
            where = (given == pattern).all(axis=1)
            lent[where] = _shares(pattern, at)
        lending = given & ~given.all(axis=1, keepdims=True)
        np.add.at(count, facets[lending], 1.0)
        lent /= np.maximum(count, 1.0)[facets][:, :, None]
        places = np.broadcast_arrays(facets[:, None, :], facets[:, :, None])
        whole = sparse.csr_matrix((lent.ravel(), tuple(each.ravel() for each in places)))
        return whole + sparse.diags((~self._given).astype(float))


def _shares(given: Bools, at: Array) -> Array:
    """(k, k) what the other nodes (columns) of a facet get of the functions of given ones (rows).

    Linear functions of the values at the others are so as far as these tell, constants always.
    """
    shares = np.zeros((len(at), len(at)))
    if given.any() and not given.all():
        basis = np.column_stack([np.ones(len(at)), at])
        if np.linalg.matrix_rank(basis[~given]) < basis.shape[1]:
            basis = basis[:, :1]
        shares[np.ix_(given, ~given)] = basis[given] @ np.linalg.pinv(basis[~given])
    return shares


def _end_nodes(side: Surface, degree: int) -> Indices:
    """Numbers of the nodes where a side ends."""
    facets, corners = side.displacement_facets(degree), side.corners
    if side.dimension == 2:
        return np.flatnonzero(np.bincount(corners.ravel()) == 1)
    rim = np.sort(rim_edges(corners), axis=1)
    found = [rim.ravel()]
    if degree == 2:
        edges = np.sort(facet_edges(corners), axis=1)
        ending = np.isin(edges @ [len(side.vertices), 1], rim @ [len(side.vertices), 1])
        count = corners.shape[1]
        found.append(facets[:, count : 2 * count].ravel()[ending])
    return np.unique(np.concatenate(found))


def _across(symmetry: Symmetry, gdim: int) -> Array:
    """(2, d) unit vectors across the axis."""
    if gdim == 2:
        return np.eye(2)
    axis = np.array(symmetry.axis)
    return np.linalg.svd(axis[None])[2][1:]


def _rotation(across: Array, angle: float, gdim: int) -> Array:
    """(d, d) rotation in the plane of two unit vectors."""
    c, s = np.cos(angle), np.sin(angle)
    inside = np.array([[c - 1, -s], [s, c - 1]])
    return np.asarray(np.eye(gdim) + across.T @ inside @ across)


def _no_images(body: str, symmetry: Symmetry, names: tuple[str, str], miss: _Miss) -> str:
    own, other = names if miss.forth else names[::-1]
    return (
        f"expected sides of the body {body!r} that are images of one another by a turn of "
        f"360°/{symmetry.sectors} about the axis, found {own!r} at {place_text(miss.place)}, "
        f"turned, {miss.distance:.4g} from {other!r}: check sectors, centre and axis, and that "
        f"{other!r} is whole there"
    )


def _miss(one: Surface, other: Surface, turn: Array, centre: Array) -> _Miss:
    """The place of a side that is farthest from the other one, turned, beyond what facets may be.

    Nodes and middles of facets: of a side where a facet is missing all nodes may be there.
    """
    found = []
    for forth, own, others, by in ((True, one, other, turn), (False, other, one, turn.T)):
        at = quadrature(own.shape, 1)[0]
        middles = np.einsum("qk,fkd->fqd", shape_values(own.shape, own.degree, at), own.nodes)
        points = np.concatenate([own.points, middles[:, 0]])
        place = places_on(centre + (points - centre) @ by.T, others, 1)
        bent = np.zeros(len(own.points))
        np.maximum.at(bent, own.facets, bends(own)[:, None])
        allowed = np.concatenate([bent, bends(own)]) + bends(others)[place.facets]
        worst = int(np.argmax(place.distance - allowed))
        distance = float(place.distance[worst])
        found.append(_Miss(distance - float(allowed[worst]), distance, points[worst], forth))
    return max(found, key=lambda each: each.excess)


def bends(surface: Surface) -> Array:
    """(f,) distances from a smooth surface that facets of other nodes on it may have.

    An arc of length h that turns by θ is hθ/8 from its chord and hθ³/512 from a parabola, as in
    `Chain.deviations`; where the next facet turns by Δθ more, a parabola is another
    h Δθ/(72 √3) from the curve (remainder of quadratic interpolation). Twice that here: normals at
    the rim turn half as far. Facets that turn by more than half a radian are taken for corners,
    where nodes must be the same.
    """
    corners = surface.corners
    count = corners.shape[1]
    normals, places = surface.normals[:, :count], surface.nodes[:, :count]
    turns = np.arccos(np.clip(normals @ normals.swapaxes(1, 2), -1, 1)).max(axis=(1, 2))
    apart = np.linalg.norm(places[:, :, None] - places[:, None], axis=3).max(axis=(1, 2))
    most, least = np.zeros(len(surface.vertices)), np.full(len(surface.vertices), np.inf)
    np.maximum.at(most, corners, turns[:, None])
    np.minimum.at(least, corners, turns[:, None])
    steps = (most - least)[corners].max(axis=1)
    parts = turns / 8 if surface.degree == 1 else turns**3 / 512 + steps / (72 * np.sqrt(3))
    return np.where(turns < 0.5, 2 * apart * parts, 0.0)


def _along(side: Surface, centre: Array, across: Array, sense: float) -> float:
    """Integral over a side of its outward normal times the velocity of a turn about the axis.

    Negative where the body lies ahead of the side: its sheets count as they cover a half plane
    through the axis, however it is curved.
    """
    places, vectors = side.integration_points(GAUSS_POINTS)
    x, y = across @ (places - centre).T
    return float(np.vdot(vectors, sense * np.column_stack([-y, x]) @ across))


def places_on(points: Array, surface: Surface, degree: int) -> _Place:
    """The places of a surface nearest to points (n, d), for displacements of a degree."""
    facets = _candidates(points, surface)
    count = facets.shape[1]
    targets = np.repeat(points, count, axis=0)
    at = nearest_on_facets(surface.nodes[facets.ravel()], targets)
    values = shape_values(surface.shape, surface.degree, at)
    feet = np.einsum("nk,nkd->nd", values, surface.nodes[facets.ravel()])
    distance = np.linalg.norm(feet - targets, axis=1).reshape(-1, count)
    rows = np.arange(len(points))
    best = distance.argmin(axis=1)
    nodes = surface.displacement_facets(degree)[facets[rows, best]]
    shares = shape_values(surface.shape, degree, at.reshape(len(points), count, -1)[rows, best])
    shares[np.abs(shares) < SAME] = 0.0
    shares /= shares.sum(axis=1, keepdims=True)
    shape = len(points), len(surface.displacement_points(degree))
    entries = shares.ravel(), (np.repeat(rows, nodes.shape[1]), nodes.ravel())
    return _Place(distance[rows, best], facets[rows, best], sparse.csr_matrix(entries, shape=shape))


def _candidates(points: Array, surface: Surface) -> Indices:
    """(n, c) facets that have places near points (n, d)."""
    at = lattice(surface.shape, SAMPLES[surface.shape])
    values = shape_values(surface.shape, surface.degree, at)
    samples = np.einsum("qk,fkd->fqd", values, surface.nodes).reshape(-1, points.shape[1])
    # Samples on edges are there twice, which makes balanced trees slow.
    tree = cKDTree(samples, balanced_tree=False)
    return np.asarray(tree.query(points, k=NEAREST_SAMPLES)[1] // len(at))
