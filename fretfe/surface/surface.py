# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces: the facets of a boundary as one oriented chain with continuous normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Indices
from fretfe.errors import MeshError
from fretfe.mesh.mesh import BodyMesh

# Facets whose normal turns by less than this angle (radians) are straight.
STRAIGHT = 1e-9
# Normals are looked up at this many places of each facet.
SAMPLES_PER_FACET = 17


@dataclass(frozen=True)
class Surface:
    """An open chain of facets, the body on the left of the direction of travel.

    Attributes:
        name: physical group of the facets.
        body: name of the body that the surface belongs to.
        nodes: (facets, 2 or 3, 2) coordinates, ends first, then the middle of curved facets.
        normals: (facets, 2 or 3, 2) outward unit normals at `nodes`, equal where facets meet.
    """

    name: str
    body: str
    nodes: Array
    normals: Array

    @property
    def vertices(self) -> Array:
        """(facets + 1, 2) coordinates of the facet ends along the chain."""
        return np.vstack([self.nodes[:, 0], self.nodes[-1:, 1]])

    @property
    def lengths(self) -> Array:
        """(facets,) arc lengths."""
        points, weights = np.polynomial.legendre.leggauss(4)
        slopes = shape_slopes(self.nodes.shape[1] - 1, (points + 1) / 2)
        tangents = np.einsum("qk,fkd->fqd", slopes, self.nodes)
        return np.linalg.norm(tangents, axis=2) @ weights / 2

    @property
    def arc(self) -> Array:
        """(facets + 1,) arc length at the facet ends, zero at the middle of the chain."""
        arc = np.concatenate([[0.0], np.cumsum(self.lengths)])
        return arc - arc[-1] / 2

    @property
    def mean_curvature(self) -> float:
        """Turning of the normal, without regard to its sign, per arc length."""
        return float(np.abs(self._turns()).sum() / self.lengths.sum())

    def _turns(self) -> Array:
        """(facets,) angle by which the normal turns over each facet."""
        first, last = self.normals[:, 0], self.normals[:, 1]
        sine = first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0]
        turns = np.arcsin(np.clip(sine, -1.0, 1.0))
        # A straight surface has no curvature, not that of the round-off in its nodes.
        return np.where(np.abs(turns) > STRAIGHT, turns, 0.0)

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """(n, 2) places of the chain nearest to points (n, 2), and unit normals there."""
        sampling = np.linspace(0.0, 1.0, SAMPLES_PER_FACET)
        values = shape_values(self.nodes.shape[1] - 1, sampling)
        places = np.einsum("qk,fkd->fqd", values, self.nodes).reshape(-1, 2)
        normals = np.einsum("qk,fkd->fqd", values, self.normals).reshape(-1, 2)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        found = cKDTree(places).query(points)[1]
        return places[found], normals[found]

    def displacement_points(self, degree: int) -> Array:
        """(n, 2) points of the trace of a Lagrange space: facet ends, then facet middles."""
        if degree == 1:
            return self.vertices
        middle = shape_values(self.nodes.shape[1] - 1, np.array([0.5]))[0]
        return np.vstack([self.vertices, np.einsum("k,fkd->fd", middle, self.nodes)])

    def displacement_facets(self, degree: int) -> Indices:
        """(facets, degree + 1) numbers of each facet's points in `displacement_points`."""
        count = len(self.nodes)
        first = np.arange(count)
        return np.stack([first, first + 1, first + count + 1][: degree + 1], axis=1)


def shape_values(degree: int, t: Array) -> Array:
    """(n, degree + 1) Lagrange functions at reference points `t` in [0, 1]: ends, then middle."""
    if degree == 1:
        return np.stack([1 - t, t], axis=1)
    return np.stack([(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)], axis=1)


def shape_slopes(degree: int, t: Array) -> Array:
    """(n, degree + 1) derivatives of `shape_values` with respect to `t`."""
    if degree == 1:
        return np.stack([-np.ones_like(t), np.ones_like(t)], axis=1)
    return np.stack([4 * t - 3, 4 * t - 1, 4 - 8 * t], axis=1)


def build_surface(mesh: BodyMesh, name: str) -> Surface:
    """Orient and order the facets of boundary `name`.

    Raises:
        MeshError: if the facets do not form one open chain.
    """
    facets = mesh.boundaries[name]  # each with the body on its left
    facets = facets[_chain_order(facets, f"surface {name!r} of body {mesh.name!r}")]
    nodes = mesh.points[facets]
    return Surface(name, mesh.name, nodes, _nodal_normals(nodes))


def _chain_order(facets: Indices, where: str) -> Indices:
    """Order in which the facets follow each other from the chain's first to its last."""
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


def _nodal_normals(nodes: Array) -> Array:
    """(facets, k, 2) outward unit normals at the nodes, averaged where two facets meet."""
    order = nodes.shape[1] - 1
    slopes = shape_slopes(order, np.array([0.0, 1.0, 0.5][: order + 1]))
    tangents = np.einsum("qk,fkd->fqd", slopes, nodes)
    tangents /= np.linalg.norm(tangents, axis=2, keepdims=True)
    shared = tangents[:-1, 1] + tangents[1:, 0]
    tangents[:-1, 1] = tangents[1:, 0] = shared / np.linalg.norm(shared, axis=1, keepdims=True)
    return np.stack([tangents[..., 1], -tangents[..., 0]], axis=2)
