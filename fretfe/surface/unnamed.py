# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts that the geometry has and the case does not name."""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array
from fretfe.mesh.elements import CORNERS, FACET_SHAPES, directed_facets, exterior_facets
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.checks import FEWEST_ELEMENTS, place


def unnamed_contacts(mesh: Mesh, named: Set[str]) -> Iterator[str]:
    """Places at which two bodies touch, or nearly, outside the named surfaces of contacts."""
    outsides = {name: _outside(body, named) for name, body in mesh.bodies.items()}
    for (name1, first), (name2, second) in combinations(outsides.items(), 2):
        if not (len(first.sizes) and len(second.sizes)):
            continue
        reach = float(np.minimum(first.sizes.max(), second.sizes.max()))
        apart, nearest = cKDTree(second.middles).query(first.middles, distance_upper_bound=reach)
        near = np.flatnonzero(np.isfinite(apart))
        others = nearest[near]
        size = np.minimum(first.sizes[near], second.sizes[others])
        offset = first.middles[near] - second.middles[others]
        gap = np.abs(np.einsum("fd,fd->f", offset, second.normals[others]))
        faces = np.einsum("fd,fd->f", first.normals[near], second.normals[others]) < -0.9
        touching = near[faces & (gap < 0.02 * size)]
        if len(touching) >= FEWEST_ELEMENTS:
            middles = first.middles[touching]
            there = middles[np.argmin(np.linalg.norm(middles - middles.mean(axis=0), axis=1))]
            yield (
                f"bodies {name1!r} and {name2!r} touch around {place(there, 4)}, where the case "
                f"has no contact ({len(touching)} facets): they go through each other there, "
                "unless both surfaces are named in a table [contacts.NAME]"
            )


@dataclass(frozen=True)
class _Outside:
    """Facets around a body: (f, d) middles and outward unit normals, (f,) sizes."""

    middles: Array
    normals: Array
    sizes: Array


def _outside(body: BodyMesh, without: Set[str]) -> _Outside:
    """The facets around a body that are in none of some boundaries."""
    shape = FACET_SHAPES[body.cell]
    facets, _ = exterior_facets(directed_facets(body.cells, body.cell, body.order), shape)
    corners = facets[:, : CORNERS[shape]]
    inside = np.zeros(len(body.points), dtype=bool)
    for name in without & set(body.boundaries):
        inside[body.boundaries[name]] = True
    corners = corners[~inside[corners].all(axis=1)]
    points = body.points[corners]
    if points.shape[2] == 2:
        along = points[:, 1] - points[:, 0]
        normals = np.column_stack([along[:, 1], -along[:, 0]])
    else:
        normals = np.cross(points[:, 1] - points[:, 0], points[:, -1] - points[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    sizes = lengths ** (1 / (points.shape[2] - 1))
    return _Outside(points.mean(axis=1), normals / lengths[:, None], sizes)
