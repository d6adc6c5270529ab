# SPDX-License-Identifier: LGPL-3.0-or-later
"""Penetration of contact surfaces where no points of them were paired before deformation."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.bodies.pairs import Pair
from fretfe.contact.recorder import Recorder
from fretfe.fem.model import Model
from fretfe.results.states import StateArray, blocks
from fretfe.surface.chain import Chain
from fretfe.surface.gap import INTERPENETRATION_PER_FACET
from fretfe.surface.surface import Surface


def farthest_states(model: Model, pair: Pair, recorder: Recorder) -> Indices:
    """States in which the surfaces of a contact are nearest to each other or have slid farthest.

    None of them if all nodes of both surfaces are paired.
    """
    assert model.reduction is not None
    if not any(_unpaired(each).any() for each in (pair.coupling.body1, pair.coupling.body2)):
        return np.array([], dtype=np.int64)
    nodes = model.reduction.interface.contacts[pair.name]
    return _extremes(recorder.relative(nodes))


def unpaired_penetration(model: Model, pair: Pair, moved: Sequence[dict[str, Array]]) -> float:
    """Largest depth to which unpaired nodes of either surface are inside the other one.

    Args:
        model: the bodies; on rank 0.
        pair: the contact.
        moved: displacements of all contact surfaces, by name, in some states.
    """
    coupling, contact = pair.coupling, model.case.contacts[pair.name]
    degree = model.case.model.degree
    first, second = (model.surfaces[name] for name in (contact.surface1, contact.surface2))
    alone1, alone2 = (_unpaired(each) for each in (coupling.body1, coupling.body2))
    deepest = 0.0
    for state in moved:
        places1, places2 = (
            surface.displacement_points(degree) + state[surface.name] for surface in (first, second)
        )
        deepest = max(
            deepest,
            depth(places1[alone1], places2[second.displacement_facets(degree)], second),
            depth(places2[alone2], places1[first.displacement_facets(degree)], first),
        )
    return deepest


def _unpaired(operator: sparse.csr_matrix) -> Bools:
    """(m,) nodes of a surface that no contact integral of an operator (N*d, m*d) refers to."""
    used = np.diff(operator.tocsc().indptr) > 0
    return np.asarray(~used.reshape(-1, 2).any(axis=1))


def _extremes(relative: StateArray) -> Indices:
    """States in which mean gap and mean tangential displacement of (T, N, d) are extreme."""
    parts = blocks(len(relative), math.prod(relative.shape[1:]))
    means = np.concatenate([relative[part].mean(axis=1) for part in parts])
    return np.unique([means.argmin(axis=0), means.argmax(axis=0)])


def depth(points: Array, facets: Array, surface: Surface) -> float:
    """Largest depth of points inside a body, behind its deformed surface.

    Args:
        points: (n, 2).
        facets: (f, k, 2) ends, then middles, of the deformed facets.
        surface: before deformation, for what its mesh does not resolve.
    """
    if not len(points):
        return 0.0
    chords = facets[:, 1] - facets[:, 0]
    lengths = np.linalg.norm(chords, axis=1)
    # The body is on the left of its chain.
    normals = np.stack([chords[:, 1], -chords[:, 0]], axis=1) / lengths[:, None]
    middles = facets[:, 2] if facets.shape[1] > 2 else facets[:, :2].mean(axis=1)
    nearest = cKDTree(middles).query(points)[1]
    seen = points - middles[nearest]
    inside = -np.sum(seen * normals[nearest], axis=1)
    along = np.abs(np.sum(seen * chords[nearest], axis=1)) / lengths[nearest]
    # Beyond an end of the surface there is another boundary, or nothing.
    beside = along <= lengths[nearest]
    allowed = Chain(surface).deviations + INTERPENETRATION_PER_FACET * lengths
    excess = np.where(beside, inside - allowed[nearest], 0.0)
    return float(max(excess.max(), 0.0))
