# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors of a disc: one side moves as the other one, turned by a full turn over their number.

Statically all sectors do the same (nodal diameter 0), so u(R x) = R u(x) for places x of one side,
R the rotation about the axis by a sector. The side with more nodes follows the other one: its nodes
move as the places of the other side that they are turned images of. Where the meshes of both sides
match, these are nodes; elsewhere displacements are interpolated in the facet that the place is on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.case import Symmetry, complaint
from fretfe.case.model import Key
from fretfe.errors import CaseError
from fretfe.mesh.elements import lattice, nearest_on_facets, shape_values
from fretfe.mesh.mesh import BodyMesh, place_text
from fretfe.surface.surface import SAMPLES, Surface, boundary_surface

# Distances of the turned image of a side from the other side, and places that are one node, over
# the size of the body: mesh files may be rounded to this.
SAME = 1e-6
# Facets whose samples are nearest to a node and that it is looked for on.
NEAREST_SAMPLES = 12


@dataclass(frozen=True)
class Tie:
    """Nodes of one side of a sector that follow those of the other one.

    u(followers) = turn (weights u(leaders)); nodes on the axis move along it only.

    Attributes:
        followers: (s, d) places.
        leaders: (m, d) places, corners of elements first.
        weights: (s, m) shape functions of the leaders' side.
        turn: (d, d) rotation from the leaders' side to the followers'.
        on_axis: (a, d) places of nodes on the axis.
        across: (2, d) unit vectors across the axis.
        centre: (d,) a point on the axis.
        size: of the body.
        source: the side of the leaders, a physical group.
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

    def image(self, values: Array) -> Array:
        """(s, d) vectors at the followers by those (m, d) at the leaders."""
        return np.asarray((self.weights @ values) @ self.turn.T)

    def violation(self, motions: Callable[[Array], Array]) -> Array:
        """(n, k) parts of motions, (m, d, k) at points (m, d), that the tie forbids."""
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

    def passed_on(self, forces: Array) -> Array:
        """(m, d) forces on the leaders that work as those (s, d) on the followers do."""
        return np.asarray(self.weights.T @ (forces @ self.turn))

    def from_axis(self, points: Array) -> Array:
        """(n, 2) places seen from the axis, across it."""
        return np.asarray((points - self.centre) @ self.across.T)

    def circumferential(self, point: Array) -> Array:
        """(d,) unit vector at a point off the axis."""
        x, y = self.from_axis(point[None])[0]
        return np.asarray(np.array([-y, x]) @ self.across / np.hypot(x, y))

    def among(self, own: Array, points: Array) -> Bools:
        """(n,) whether places of the sides (n, d) are among points (m, d)."""
        if not len(points):
            return np.zeros(len(own), dtype=bool)
        return np.asarray(cKDTree(points).query(own)[0] < SAME * self.size)


@dataclass(frozen=True)
class _Place:
    """Places of k nodes on a surface: distances (k,) from it and weights (k, m) of its nodes."""

    distance: Array
    weights: sparse.csr_matrix


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
    best = int(misses[1][0] < misses[0][0])
    distance, where = misses[best]
    if distance > SAME * size:
        text = (
            f"expected sides of the body {mesh.name!r} that are images of one another by a turn of "
            f"360°/{symmetry.sectors} about the axis, found {names[0]!r} turned up to "
            f"{distance:.4g} from {names[1]!r}, at {place_text(where)}: check sectors, centre and "
            "axis, and that both boundaries are whole"
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
    axial = np.linalg.norm((followers - centre) @ across.T, axis=1) < SAME * size
    on_axis, followers = followers[axial], followers[~axial]
    found = _places(centre + (followers - centre) @ turn, leading, degree)
    # Nodes that are images of nodes have their displacements, not nearly so.
    distance, node = cKDTree(leaders).query(centre + (followers - centre) @ turn)
    same = distance < SAME * size
    rows = np.flatnonzero(same)
    exact = sparse.csr_matrix((np.ones(len(rows)), (rows, node[rows])), shape=found.weights.shape)
    weights = (sparse.diags(1.0 - same) @ found.weights + exact).tocsr()
    weights.eliminate_zeros()
    return Tie(followers, leaders, weights, turn, on_axis, across, centre, size, leading.name)


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


def _miss(one: Surface, other: Surface, turn: Array, centre: Array) -> tuple[float, Array]:
    """Largest distance of nodes of one side, turned, from the other or the other way; and where."""
    forth, back = one.points, other.points
    distances = np.concatenate(
        [
            _places(centre + (forth - centre) @ turn.T, other, 1).distance,
            _places(centre + (back - centre) @ turn, one, 1).distance,
        ]
    )
    worst = int(np.argmax(distances))
    return float(distances[worst]), np.concatenate([forth, back])[worst]


def _places(points: Array, surface: Surface, degree: int) -> _Place:
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
    return _Place(distance[rows, best], sparse.csr_matrix(entries, shape=shape))


def _candidates(points: Array, surface: Surface) -> Indices:
    """(n, c) facets that have places near points (n, d)."""
    at = lattice(surface.shape, SAMPLES[surface.shape])
    values = shape_values(surface.shape, surface.degree, at)
    samples = np.einsum("qk,fkd->fqd", values, surface.nodes).reshape(-1, points.shape[1])
    # Samples on edges are there twice, which makes balanced trees slow.
    tree = cKDTree(samples, balanced_tree=False)
    return np.asarray(tree.query(points, k=NEAREST_SAMPLES)[1] // len(at))
