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
from fretfe.surface.chain import Chain
from fretfe.surface.overlap import OverlapPoints, overlap_points
from fretfe.surface.reference import shape_values
from fretfe.surface.surface import Surface, tangent_frames

# Hats with less than this fraction of their support inside the overlap carry no multiplier.
SMALLEST_SUPPORT = 1e-6


@dataclass(frozen=True)
class Coupling:
    """Coupling operators of one contact pair; N multiplier nodes, d space dimensions.

    Rows of the operators belong to node i and component c (normal, then tangents) at N-row i*d + c.

    Attributes:
        arc: (N,) arc length of the nodes along the multiplier side in the plane, along t.
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
        ModelError: No part of the surfaces lies opposite the other, or they are not in the plane.
    """
    on_first = multipliers == "surface1" or (
        multipliers == "finer" and _facet_size(surface1) <= _facet_size(surface2)
    )
    overlap = overlap_points(surface1, surface2)
    if not len(overlap.weights):
        raise ModelError(
            f"contact {name!r}: surfaces {surface1.name!r} and {surface2.name!r} never face each "
            "other within half their length; expected two boundaries that look at each other. "
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
        (surface1, overlap.facet1, overlap.at1),
        (surface2, overlap.facet2, overlap.at2),
    )
    carrier = surface1 if on_first else surface2
    values = _hats(*sides[0 if on_first else 1])
    hats = values @ sparse.diags(overlap.weights)
    support = hats @ np.ones(len(overlap.weights))
    nodes = np.flatnonzero(support > SMALLEST_SUPPORT * carrier.hat_integrals())
    # A chain has its body on the left: only that of body 1 runs in the direction of t.
    nodes = nodes if on_first else nodes[::-1]
    test, support = hats[nodes], support[nodes]
    mean = test @ overlap.normals
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    # Frames at the points and at the nodes, with tangents in the same directions.
    frames = tangent_frames(np.vstack([overlap.normals, mean]))
    count, d = overlap.normals.shape
    axes = np.moveaxis(frames[:count], 1, 0)
    first, second = (
        _interleave([test @ _trace(axis, *side, degree) for axis in axes]) for side in sides
    )
    # The gap opens with u_1 along n; the tangential displacement grows with u_2 along t.
    signs = sparse.diags(np.tile([1.0, *[-1.0] * (d - 1)], len(nodes)))
    arc = Chain(carrier).arc if on_first else -Chain(carrier).arc
    return Coupling(
        arc=arc[nodes],
        points=carrier.vertices[nodes],
        frames=frames[count:],
        weights=support,
        averaging=(sparse.diags(1 / support) @ test @ values[nodes].T).tocsr(),
        gap=test @ overlap.gap,
        body1=(signs @ first).tocsr(),
        body2=(-signs @ second).tocsr(),
    )


def _hats(surface: Surface, facet: Indices, at: Array) -> sparse.csr_matrix:
    """(v, n) values of the hat functions of the vertices at n points on the facets."""
    values = shape_values(surface.shape, 1, at)
    columns = np.broadcast_to(np.arange(len(at))[:, None], values.shape)
    rows = surface.corners[facet].ravel()
    shape = (len(surface.vertices), len(at))
    return sparse.csr_matrix((values.ravel(), (rows, columns.ravel())), shape=shape)


def _trace(
    direction: Array, surface: Surface, facet: Indices, at: Array, degree: int
) -> sparse.csr_matrix:
    """(n, m * d) matrix: surface displacement along a direction (n, d) at n points."""
    dim = surface.dimension
    nodes = surface.displacement_facets(degree)[facet]
    data = shape_values(surface.shape, degree, at)[:, :, None] * direction[:, None, :]
    columns = nodes[:, :, None] * dim + np.arange(dim)
    rows = np.broadcast_to(np.arange(len(at))[:, None, None], data.shape)
    size = len(surface.displacement_points(degree)) * dim
    return sparse.csr_matrix((data.ravel(), (rows.ravel(), columns.ravel())), shape=(len(at), size))


def _interleave(operators: list[sparse.csr_matrix]) -> sparse.csr_matrix:
    """Stack one operator per component so that the components of a node follow each other."""
    count = operators[0].shape[0]
    order = np.arange(count * len(operators)).reshape(len(operators), count).T.ravel()
    return sparse.vstack(operators).tocsr()[order]
