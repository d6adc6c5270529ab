# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact tractions as forces at the nodes of a surface of another model, whose balance is kept.

The force of each node of the contact is spread over the facets around it as its hat function is,
and what is at a place goes to the nodes of the nearest facet by the shape functions there: these
are 1 together, so the force is kept, and they have the place as their centre of gravity, so the
moment is, up to the gap between the surfaces. The rest of the moment is added as the smallest
forces, weighted by the loads of the nodes, that have it and no resultant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.errors import MeshError, OutputError
from fretfe.evaluate.resultants import traction_vectors
from fretfe.history.solution import ContactHistory
from fretfe.mesh.elements import (
    AT_CENTRE,
    KINDS,
    SERENDIPITY_QUADRILATERAL,
    facet_measures,
    nearest_on_facets,
    shape_slopes,
    shape_values,
)
from fretfe.mesh.inp_surfaces import DeckSurface
from fretfe.mesh.mesh import place_text

# Largest distance of a surface from the contact, over the extent of what is in contact.
FARTHEST = 0.05
# What is kept of force and moment.
BALANCE = 1e-10
# Places along a facet of the contact: so many in one of the other surface, these at least and most,
# and in all facets together.
DENSITY = 3.0
FEWEST = 3
MOST = 200
MOST_PLACES = 200_000
# Facets of the other surface that are looked at around each place, by dimension, until its foot is
# within one that is nearer than this part of the size of facets; places at once.
AROUND = {2: 6, 3: 16}
NEAR = 0.1
AT_ONCE = 50_000
# Of reference coordinates.
ROUND_OFF = 1e-9
CENTRE = AT_CENTRE[SERENDIPITY_QUADRILATERAL]


@dataclass(frozen=True)
class NodalForces:
    """Forces at the nodes of a surface.

    Attributes:
        forces: (n, d) on the body, in the plane per unit thickness.
        force: (d,) their sum, as of the contact.
        moment: (1,) or (3,) about the origin, as of the contact.
        imbalance: difference of force or moment from those of the contact, the larger one over the
            sum of all forces, moments over the extent of what is in contact as well.
        added: largest force that was added for the moment, over the largest force.
        distance: largest distance of the surface from what is in contact.
        size: median length of its facets, over the extent of what is in contact.
    """

    forces: Array
    force: Array
    moment: Array
    imbalance: float
    added: float
    distance: float
    size: float


def nodal_forces(
    contact: ContactHistory, state: int, body: str, surface: DeckSurface, factor: float = 1.0
) -> NodalForces:
    """Forces of a contact on the nodes of a surface of another mesh of one of its bodies.

    Args:
        contact: with tractions.
        state: one that is kept.
        body: name of the body on whose surface they act.
        surface: of the other mesh.
        factor: length unit of the other mesh, in that of the results.

    Raises:
        OutputError: if plane bodies move along z.
        MeshError: if the surface is elsewhere, faces the other way, or cannot carry the moment.
    """
    if contact.slip.shape[2] > contact.surface.points.shape[1] - 1:
        raise OutputError(
            f"contact {contact.name}: expected forces in the plane, found shear along z, which the "
            "elements of plane meshes do not take"
        )
    points, sign = surface.points * factor, -1.0 if body == contact.body1 else 1.0
    vectors = traction_vectors(contact, contact.mean_traction[[state]])[0]
    forces = sign * contact.surface.weights[:, None] * vectors
    loaded = np.linalg.norm(forces, axis=1) > 0
    if not loaded.any():
        raise MeshError(f"contact {contact.name}: expected forces, found none in this state")
    near = np.unique(_loaded_facets(contact, loaded))
    extent = float(np.linalg.norm(np.ptp(contact.surface.points[near], axis=0)))
    target = _Target(points, surface, factor)
    places, parts = _spread(contact, forces, loaded, target.size)
    normals = contact.surface.frames[cKDTree(contact.surface.points).query(places)[1], 0]
    mapped = target.distributed(places, parts, sign * normals)
    if mapped.distance > FARTHEST * extent:
        raise MeshError(
            f"expected a surface within {FARTHEST * extent:.3g} of contact {contact.name}, which "
            f"extends over {extent:.3g}, found the place {place_text(mapped.farthest)} "
            f"{mapped.distance:.3g} away from it: is it this surface, in the same position and "
            "unit of length?"
        )
    if mapped.facing < 0:
        raise MeshError(
            f"expected a surface of body '{body}' in contact {contact.name}, found one that faces "
            "the other way: is it that of the other body?"
        )
    return _balanced(contact.surface.points, forces, points, mapped, extent, target.size)


def _loaded_facets(contact: ContactHistory, loaded: Array) -> Indices:
    """(f, k) facets of the contact at nodes with forces; in the plane from node to node."""
    count = len(contact.surface.points)
    facets = contact.surface.facets
    if facets is None:
        facets = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)
    return np.asarray(facets[loaded[facets].any(axis=1)])


def _spread(
    contact: ContactHistory, forces: Array, loaded: Array, size: float
) -> tuple[Array, Array]:
    """Places (q, d) on the contact and the parts (q, d) of its forces there.

    Args:
        contact: the contact.
        forces: (N, d) at its nodes.
        loaded: (N,) nodes with forces.
        size: of the facets of the other surface.
    """
    facets = _loaded_facets(contact, loaded)
    nodes = contact.surface.points[facets]
    shape, order = KINDS[nodes.shape[2], facets.shape[1]]
    own = float(facet_measures(contact.surface.points, facets).max() ** (1 / (nodes.shape[2] - 1)))
    most = (MOST_PLACES / len(facets)) ** (1 / (nodes.shape[2] - 1))
    at = _grid(shape, int(np.clip(np.ceil(DENSITY * own / size), FEWEST, min(MOST, most))))
    hats = shape_values(shape, order, at)
    tangents = np.einsum("qak,fkd->fqad", shape_slopes(shape, order, at), nodes)
    measures = np.linalg.norm(
        tangents[:, :, 0] if shape == "line" else np.cross(tangents[:, :, 0], tangents[:, :, 1]),
        axis=2,
    )
    shares = measures[:, :, None] * hats
    total = np.zeros(len(forces))
    np.add.at(total, facets, shares.sum(axis=1))
    density = forces[facets] / np.where(total > 0, total, 1.0)[facets][:, :, None]
    parts = np.einsum("fqk,fkd->fqd", shares, density)
    places = np.einsum("qk,fkd->fqd", hats, nodes)
    return places.reshape(-1, nodes.shape[2]), parts.reshape(-1, nodes.shape[2])


def _grid(shape: str, count: int) -> Array:
    """Reference coordinates of the centres of equal parts of a facet, `count` along each side."""
    line = (np.arange(count) + 0.5) / count
    if shape == "line":
        return line[:, None]
    if shape == "quadrilateral":
        return np.stack([each.ravel() for each in np.meshgrid(line, line)], axis=1)
    first, second = (each.ravel() for each in np.meshgrid(np.arange(count), np.arange(count)))
    upright = np.stack([first, second], axis=1)[first + second < count] + 1 / 3
    turned = np.stack([first, second], axis=1)[first + second < count - 1] + 2 / 3
    return np.asarray(np.concatenate([upright, turned]) / count)


@dataclass(frozen=True)
class _Mapped:
    """Forces at the nodes, and the lie of the surfaces.

    Attributes:
        forces: (n, d).
        loads: (n,) sums of the sizes of what they consist of.
        distance: largest one of a place from the surface.
        farthest: (d,) that place.
        facing: cosine between the normals of the surfaces, a mean.
    """

    forces: Array
    loads: Array
    distance: float
    farthest: Array
    facing: float


class _Target:
    """Facets that take forces, in blocks of one kind, with nodes in the middle of all squares."""

    def __init__(self, points: Array, surface: DeckSurface, factor: float) -> None:
        self._count = len(points)
        self._points, self._blocks = _completed(points, surface.facets)
        self._first = np.cumsum([0, *map(len, self._blocks)])
        centres = np.concatenate([self._points[facets].mean(axis=1) for facets in self._blocks])
        self._tree = cKDTree(centres)
        outward = centres - factor * np.concatenate(surface.inside)
        normals = np.concatenate([_normals(self._points[facets]) for facets in self._blocks])
        sizes = np.linalg.norm(normals, axis=1)
        if not sizes.min() > 0:
            raise MeshError(
                f"expected facets with a length or area, found one without at "
                f"{place_text(centres[sizes.argmin()])}"
            )
        turned = np.where((normals * outward).sum(axis=1) < 0, -1.0, 1.0)
        self._normals = normals * (turned / sizes)[:, None]
        self.size = float(np.median(sizes)) ** (1 / (points.shape[1] - 1))

    def distributed(self, places: Array, parts: Array, normals: Array) -> _Mapped:
        """Forces at the nodes.

        Args:
            places: (q, d) where forces act.
            parts: (q, d) the forces.
            normals: (q, d) outward normals of the body there.
        """
        forces, loads = np.zeros_like(self._points), np.zeros(len(self._points))
        distances, facing = np.zeros(len(places)), 0.0
        sizes = np.linalg.norm(parts, axis=1)
        for first in range(0, len(places), AT_ONCE):
            rows = slice(first, first + AT_ONCE)
            chosen, distances[rows] = self._nearest(places[rows])
            facing += float(
                sizes[rows] @ np.einsum("qd,qd->q", self._normals[chosen], normals[rows])
            )
            for block, facets in enumerate(self._blocks):
                own = self._of_block(chosen, block)
                nodes = facets[chosen[own] - self._first[block]]
                hats = self._hats(nodes, places[rows][own])
                np.add.at(forces, nodes, hats[:, :, None] * parts[rows][own][:, None])
                np.add.at(loads, nodes, np.abs(hats) * sizes[rows][own][:, None])
        farthest = int(distances.argmax())
        return _Mapped(
            self._without_middles(forces), np.abs(self._without_middles(loads)),
            float(distances[farthest]), places[farthest], facing / float(sizes.sum()),
        )  # fmt: skip

    def _nearest(self, places: Array) -> tuple[Indices, Array]:
        """The facet (q,) nearest to each place (q, d), and its distance (q,)."""
        around = min(AROUND[places.shape[1]], int(self._first[-1]))
        near = self._tree.query(places, k=around)[1].reshape(len(places), around)
        chosen, distances = near[:, 0].copy(), np.full(len(places), np.inf)
        left = np.arange(len(places))
        for facets in near.T:
            away, inside = self._distances(facets[left], places[left])
            better = away < distances[left]
            chosen[left[better]] = facets[left[better]]
            distances[left] = np.minimum(distances[left], away)
            left = left[~inside | (away > NEAR * self.size)]
        return chosen, distances

    def _distances(self, facets: Indices, places: Array) -> tuple[Array, Bools]:
        """Distances (q,) of facets (q,) from places (q, d); True if a foot is within its facet."""
        away, inside = np.empty(len(places)), np.zeros(len(places), dtype=bool)
        for block, nodes_of in enumerate(self._blocks):
            own = self._of_block(facets, block)
            nodes = nodes_of[facets[own] - self._first[block]]
            at = nearest_on_facets(self._points[nodes], places[own])
            shape, order = KINDS[places.shape[1], nodes.shape[1]]
            hats = shape_values(shape, order, at)
            feet = np.einsum("qk,qkd->qd", hats, self._points[nodes])
            away[own] = np.linalg.norm(feet - places[own], axis=1)
            last = at.sum(axis=1) if shape == "triangle" else at.max(axis=1)
            inside[own] = (at.min(axis=1) > 0) & (last < 1 - ROUND_OFF)
        return away, inside

    def _of_block(self, numbers: Indices, block: int) -> Indices:
        """Places of the facets of a block among numbers of facets."""
        return np.flatnonzero((numbers >= self._first[block]) & (numbers < self._first[block + 1]))

    def _hats(self, nodes: Indices, places: Array) -> Array:
        """(q, k) shape functions of facets (q, k) at their nearest places to others (q, d)."""
        shape, order = KINDS[places.shape[1], nodes.shape[1]]
        return shape_values(shape, order, nearest_on_facets(self._points[nodes], places))

    def _without_middles(self, values: Array) -> Array:
        """Values at the nodes of the surface; those in the middle of squares go to their nodes."""
        found, middle = values[: self._count].copy(), self._count
        for facets in self._blocks:
            if facets.shape[1] == 9 and facets[0, 8] >= self._count:
                own = values[middle : middle + len(facets)]
                shares = CENTRE.reshape(-1, *[1] * (values.ndim - 1))
                np.add.at(found, facets[:, :8], own[:, None] * shares)
                middle += len(facets)
        return found


def _completed(points: Array, blocks: tuple[Indices, ...]) -> tuple[Array, list[Indices]]:
    """Points, and facets of which those of eight nodes have a ninth one, where these put it."""
    found, every = list[Indices](), points
    for facets in blocks:
        if facets.shape[1] == len(CENTRE):
            numbers = len(every) + np.arange(len(facets))
            every = np.vstack([every, np.einsum("k,fkd->fd", CENTRE, points[facets])])
            facets = np.column_stack([facets, numbers])
        found.append(facets)
    return every, found


def _normals(nodes: Array) -> Array:
    """(f, d) normals of facets (f, k, d), as long as these are, or large."""
    if nodes.shape[2] == 2:
        along = nodes[:, 1] - nodes[:, 0]
        return np.stack([along[:, 1], -along[:, 0]], axis=1)
    if nodes.shape[1] in (3, 6):
        return np.asarray(np.cross(nodes[:, 1] - nodes[:, 0], nodes[:, 2] - nodes[:, 0]) / 2)
    return np.asarray(np.cross(nodes[:, 2] - nodes[:, 0], nodes[:, 3] - nodes[:, 1]) / 2)


def _balanced(
    nodes: Array, forces: Array, points: Array, mapped: _Mapped, extent: float, size: float
) -> NodalForces:
    """Forces (n, d) at points (n, d) with the resultants of others (N, d) at nodes (N, d)."""
    total = float(np.linalg.norm(forces, axis=1).sum())
    centre = np.average(nodes, axis=0, weights=np.linalg.norm(forces, axis=1))
    expected = _resultants((nodes - centre) / extent, forces)
    arms, found = (points - centre) / extent, mapped.forces.copy()
    motions = _motions(arms)
    matrix = np.einsum("knd,n,lnd->kl", motions, mapped.loads, motions)
    for _ in range(2):  # the second time removes what round-off left
        rest = expected - _resultants(arms, found)
        amplitudes = np.linalg.lstsq(matrix, rest, rcond=1e-12)[0]
        found += mapped.loads[:, None] * np.einsum("k,knd->nd", amplitudes, motions)
    imbalance = float(np.abs(expected - _resultants(arms, found)).max()) / total
    if imbalance > BALANCE:
        raise MeshError(
            "expected a surface whose nodes can carry the moment of the contact, found that "
            f"{imbalance:.1g} of force or moment is left over"
        )
    largest = float(np.linalg.norm(found, axis=1).max())
    added = float(np.linalg.norm(found - mapped.forces, axis=1).max()) / largest
    return NodalForces(
        found, forces.sum(axis=0), _resultants(nodes, forces)[nodes.shape[1] :], imbalance, added,
        mapped.distance, size / extent,
    )  # fmt: skip


def _motions(arms: Array) -> Array:
    """Rigid motions (3 or 6, n, d) at places (n, d): along the axes, about the origin."""
    dimension = arms.shape[1]
    along = [np.broadcast_to(axis, arms.shape) for axis in np.eye(dimension)]
    if dimension == 2:
        return np.stack([*along, np.stack([-arms[:, 1], arms[:, 0]], axis=1)])
    return np.stack([*along, *(np.cross(axis, arms) for axis in np.eye(3))])


def _resultants(arms: Array, forces: Array) -> Array:
    """(3 or 6,) force, then moment about the origin, of forces (n, d) at places (n, d)."""
    return np.asarray(np.einsum("knd,nd->k", _motions(arms), forces))
