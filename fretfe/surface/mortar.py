# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mortar coupling of two contact surfaces, integrated over their true overlap segments.

The traction on body 2 is τ = Σ φ_i (−p_i n + q_i·t): hat functions φ_i on the facet ends of the
side that carries the multipliers, n the outward normal of body 2, t the tangents (in the plane n
turned clockwise, so that x = t and y = n). Work conjugate to it are the weighted gap
∫ φ_i [(u_1 − u_2)·n + gap] and the weighted tangential displacement ∫ φ_i (u_2 − u_1)·t.

Integrals run over the surface of body 2, whichever side carries the multipliers. The normals are
those of both surfaces, each weighted with the curvature of the other (`contact_normals`). This
matters where surfaces slide far or press deep: a rounded profile that slides along a flat keeps
its gap if the normals are those of the flat, but not if they are its own, which turn by δ/R over
a slide δ; and two equal cylinders touch in the plane between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fretfe._core import _kernels
from fretfe._typing import Array, Indices
from fretfe.errors import ModelError
from fretfe.surface.surface import Surface, shape_values

# Exact for the products of hat, quadratic displacement and geometry on straight facets, and far
# below the discretisation error on curved ones.
GAUSS_POINTS = 5
# Points further apart than this fraction of the shorter surface are never in contact.
SEARCH_FRACTION = 0.5
# Hats with less than this fraction of their support inside the overlap carry no multiplier.
SMALLEST_SUPPORT = 1e-6


@dataclass(frozen=True)
class Coupling:
    """Coupling operators of one contact pair; N multiplier nodes, d space dimensions.

    Rows of the operators belong to node i and component c (normal, then tangents) at N-row i*d + c.

    Attributes:
        arc: (N,) arc length of the nodes along the multiplier side, in the direction of t.
        points: (N, d) coordinates of the nodes.
        frames: (N, d, d) rows: outward normal of body 2, then tangents, mean around the nodes.
        weights: (N,) integral of each hat function over the overlap.
        averaging: (N, N) mean of a traction around each node, ∫ φ_i Σ φ_j λ_j / ∫ φ_i.
        gap: (N,) weighted initial gap, ∫ φ_i gap.
        body1, body2: (N*d, n) operators on the surface displacements of each body.
    """

    arc: Array
    points: Array
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
        ModelError: if no part of the surfaces faces the other.
    """
    on_first = multipliers == "surface1" or (
        multipliers == "finer" and _facet_size(surface1) <= _facet_size(surface2)
    )
    pairs = facing_points(surface1, surface2)
    if not len(pairs["weight"]):
        raise ModelError(
            f"contact {name!r}: surfaces {surface1.name!r} and {surface2.name!r} never face each "
            "other within half their length; expected two boundaries that look at each other. "
            "Check the names, and that the bodies are in their working position."
        )
    return _assemble(pairs, surface1, surface2, on_first, degree)


def _facet_size(surface: Surface) -> float:
    return float(np.median(surface.lengths))


def facing_points(surface1: Surface, surface2: Surface) -> dict[str, Array]:
    """Integration points on the surface of body 2 and their projections on that of body 1.

    Empty where no part of the surfaces faces the other within `search_reach`.
    """
    points, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    return _kernels.overlap_points(
        np.ascontiguousarray(surface2.nodes),
        np.ascontiguousarray(contact_normals(surface1, surface2)),
        np.ascontiguousarray(surface1.nodes),
        (points + 1) / 2,
        weights / 2,
        search_reach(surface1, surface2),
    )


def search_reach(surface1: Surface, surface2: Surface) -> float:
    """Distance beyond which points of two surfaces are never in contact."""
    return float(SEARCH_FRACTION * min(surface1.lengths.sum(), surface2.lengths.sum()))


def contact_normals(surface1: Surface, surface2: Surface) -> Array:
    """(facets, k, 2) unit normals of the contact at the nodes of surface 2, out of body 2.

    The normal of each surface counts with the mean curvature of the other: a flat against a
    rounded surface gives the normal of the flat, equal cylinders the direction between their
    axes, conforming surfaces their common normal.
    """
    curvature1, curvature2 = surface1.mean_curvature, surface2.mean_curvature
    if curvature2 == 0:
        return surface2.normals
    opposite = surface1.nearest(surface2.nodes.reshape(-1, 2))[1]
    normals = curvature1 * surface2.normals - curvature2 * opposite.reshape(surface2.normals.shape)
    return normals / np.linalg.norm(normals, axis=2, keepdims=True)


def _assemble(
    pairs: dict[str, Array], surface1: Surface, surface2: Surface, on_first: bool, degree: int
) -> Coupling:
    """Coupling from integration points on the surface of body 2 and their projections."""
    places = [
        (pairs["other_facet"].astype(np.int64), pairs["eta"]),
        (pairs["facet"].astype(np.int64), pairs["xi"]),
    ]
    carrier, place = (surface1, places[0]) if on_first else (surface2, places[1])
    values = _hats(*place, len(carrier.nodes) + 1)
    hats = values @ sparse.diags(pairs["weight"])
    support = hats @ np.ones(len(pairs["weight"]))
    nodes = np.flatnonzero(support > SMALLEST_SUPPORT * _hat_integrals(carrier))
    # A chain has its body on the left: only that of body 1 runs in the direction of t.
    nodes = nodes if on_first else nodes[::-1]
    test, support = hats[nodes], support[nodes]
    normals = np.stack([pairs["normal_x"], pairs["normal_y"]], axis=1)
    axes = np.moveaxis(_frames(normals), 1, 0)  # normal, tangents at the points
    first, second = (
        _interleave([test @ _trace(axis, surface, *at, degree) for axis in axes])
        for surface, at in zip((surface1, surface2), places, strict=True)
    )
    # The gap opens with u_1 along n; the tangential displacement grows with u_2 along t.
    signs = sparse.diags(np.tile([1.0, *[-1.0] * (normals.shape[1] - 1)], len(nodes)))
    mean = test @ normals
    return Coupling(
        arc=(carrier.arc if on_first else -carrier.arc)[nodes],
        points=carrier.vertices[nodes],
        frames=_frames(mean / np.linalg.norm(mean, axis=1, keepdims=True)),
        weights=support,
        averaging=(sparse.diags(1 / support) @ test @ values[nodes].T).tocsr(),
        gap=test @ pairs["gap"],
        body1=(signs @ first).tocsr(),
        body2=(-signs @ second).tocsr(),
    )


def _hats(facet: Indices, t: Array, count: int) -> sparse.csr_matrix:
    """(count, points) values of the hat functions at points on the facets."""
    rows = np.stack([facet, facet + 1], axis=1).ravel()
    columns = np.repeat(np.arange(len(t)), 2)
    return sparse.csr_matrix((shape_values(1, t).ravel(), (rows, columns)), (count, len(t)))


def _trace(
    direction: Array, surface: Surface, facet: Indices, t: Array, degree: int
) -> sparse.csr_matrix:
    """(points, n) matrix: surface displacement along a direction (points, d) at the points."""
    dim = direction.shape[1]
    nodes = surface.displacement_facets(degree)[facet]
    data = shape_values(degree, t)[:, :, None] * direction[:, None, :]
    columns = nodes[:, :, None] * dim + np.arange(dim)
    rows = np.broadcast_to(np.arange(len(t))[:, None, None], data.shape)
    size = len(surface.displacement_points(degree)) * dim
    return sparse.csr_matrix((data.ravel(), (rows.ravel(), columns.ravel())), shape=(len(t), size))


def _interleave(operators: list[sparse.csr_matrix]) -> sparse.csr_matrix:
    """Stack one operator per component so that the components of a node follow each other."""
    count = operators[0].shape[0]
    order = np.arange(count * len(operators)).reshape(len(operators), count).T.ravel()
    return sparse.vstack(operators).tocsr()[order]


def _hat_integrals(surface: Surface) -> Array:
    """(facets + 1,) integrals of the hat functions over the whole surface."""
    halves = surface.lengths / 2
    return np.concatenate([halves, [0.0]]) + np.concatenate([[0.0], halves])


def _frames(normals: Array) -> Array:
    """(n, 2, 2) rows: normal, and tangent = normal turned clockwise."""
    return np.stack([normals, np.stack([normals[:, 1], -normals[:, 0]], axis=1)], axis=1)
