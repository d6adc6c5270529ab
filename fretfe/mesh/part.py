# SPDX-License-Identifier: LGPL-3.0-or-later
"""A part of a mesh: the elements near a centre, and the boundaries along which it was cut out."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.case import Case
from fretfe.case.tables import Part, Solid
from fretfe.errors import MeshError
from fretfe.mesh.elements import (
    CORNERS,
    FACET_SHAPES,
    FACETS,
    directed_facets,
    exterior_facets,
    row_keys,
)
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.mesh.pieces import cell_pieces

CUT = "cut"


def cut_name(body: str) -> str:
    """Name of the boundary along which a body was cut."""
    return f"{body}_{CUT}"


def distances(part: Part, points: Array) -> Array:
    """(n,) distance of points (n, d) from the centre of a part, or from its axis along z."""
    centre = np.array(part.centre)
    return np.asarray(np.linalg.norm(points[:, : len(centre)] - centre, axis=1))


def seen(case: Case, points: Array, count: int) -> Array:
    """Points (n, d) of a model by so many coordinates, as the centre of a part has.

    Of extruded bodies two are those of the places at z = 0 that points come from.
    """
    solid = case.geometry.solid
    if solid is not None and count == 2 and points.shape[1] == 3:
        lean = math.tan(math.radians(solid.skew))
        points = points - lean * points[:, 2:] * np.array([1.0, 0.0, 0.0])
    return points[:, :count]


def around_ball(part: Part, solid: Solid) -> Part:
    """A circle at z = 0 whose extrusion has a ball in it; the part itself if it is a circle.

    Planes across z meet a leaning cylinder in circles that move along x as z does.
    """
    if len(part.centre) == 2:
        return part
    lean, (x, y, z) = math.tan(math.radians(solid.skew)), part.centre
    return Part(centre=(x - lean * z, y), radius=(1 + abs(lean)) * part.radius)


def part_of(mesh: Mesh, part: Part, surfaces: Collection[str], *, again: bool = False) -> Mesh:
    """Keep the elements all of whose nodes are near a centre, if they hang together with a contact.

    The result is a mesh of whole elements: its cut boundaries are as jagged as these.

    Args:
        mesh: plane or solid.
        part: centre and distance; with two coordinates solids are cut along z.
        surfaces: names of the contact surfaces. Pieces that have none of their facets are left out,
            and so are bodies without such pieces.
        again: whether the mesh was cut before, so that it may have boundaries `BODY_cut`.

    Returns:
        Bodies whose boundaries have the facets that are left; what was inside before is the
        boundary `BODY_cut`.

    Raises:
        MeshError: nothing is left, or a boundary in the part has the name of a cut already.
    """
    bodies = {}
    for name, body in mesh.bodies.items():
        kept = _kept(body, distances(part, body.points) <= part.radius, surfaces)
        if kept.any():
            bodies[name] = body if kept.all() else _cut_body(body, kept, again=again)
    if not bodies:
        nearest = min(
            distances(part, body.points[body.boundaries[name]].reshape(-1, mesh.dimension)).min()
            for body in mesh.bodies.values()
            for name in body.boundaries
            if name in surfaces
        )
        raise MeshError(
            f"geometry.part.radius: expected elements with a side on a contact surface within it, "
            f"found none within {part.radius:g}; the nearest node of these surfaces is "
            f"{nearest:.4g} away from the centre"
        )
    return replace(mesh, bodies=bodies)


def _kept(body: BodyMesh, near: Bools, surfaces: Collection[str]) -> Bools:
    """(m,) cells with near nodes (n,) only that hang together, by whole facets, with a contact."""
    kept = near[body.cells].all(axis=1)
    touching = np.zeros(len(body.points), dtype=bool)
    corners = CORNERS[body.cell]
    owned = np.zeros(len(body.cells), dtype=bool)
    for name in surfaces:
        facets = body.boundaries.get(name)
        if facets is None:
            continue
        own = facets[:, : CORNERS[FACET_SHAPES[body.cell]]]
        touching[:] = False
        touching[own] = True
        # Few cells have so many corners there, one of whose facets may be one of these.
        there = touching[body.cells[:, :corners]].sum(axis=1) >= own.shape[1]
        rows = np.flatnonzero(kept & there)
        sides = directed_facets(body.cells[rows, :corners], body.cell, 1)
        owned[rows] |= (
            _among(body, sides, own).reshape(len(rows), len(FACETS[body.cell])).any(axis=1)
        )
    numbers = np.flatnonzero(kept)
    if not len(numbers):
        return kept
    pieces = cell_pieces(body.cells[numbers], body.cell)
    kept[numbers] = np.isin(pieces, pieces[owned[numbers]])
    return kept


def _cut_body(body: BodyMesh, kept: Bools, *, again: bool) -> BodyMesh:
    """A body of some of the cells (m,) of another one, with node numbers of its own."""
    outside, cells = _outside(body, body.cells), body.cells[kept]
    left = _outside(body, cells)
    boundaries = {
        name: facets[_among(body, facets, left)] for name, facets in body.boundaries.items()
    }
    boundaries = {name: facets for name, facets in boundaries.items() if len(facets)}
    name, before = cut_name(body.name), []
    if name in boundaries:
        if not again:
            raise MeshError(
                f"geometry.part: expected no boundary called {name!r}, which is where the body is "
                "cut, found one in the mesh of the part"
            )
        before = [boundaries[name]]
    boundaries[name] = np.concatenate([left[~_among(body, left, outside)], *before])
    nodes = np.unique(cells)
    local = np.full(len(body.points), -1)
    local[nodes] = np.arange(len(nodes))
    return replace(
        body,
        points=body.points[nodes],
        cells=local[cells],
        boundaries={name: local[facets] for name, facets in boundaries.items()},
        pieces=int(cell_pieces(cells, body.cell).max()) + 1,
    )


def _outside(body: BodyMesh, cells: Indices) -> Indices:
    """Facets (f, k) that only one of some cells has."""
    facets = directed_facets(cells, body.cell, body.order)
    return exterior_facets(facets, FACET_SHAPES[body.cell])[0]


def _among(body: BodyMesh, facets: Indices, others: Indices) -> Bools:
    """(f,) which facets have the same corners as one of some others."""
    count = CORNERS[FACET_SHAPES[body.cell]]
    corners = np.concatenate([np.sort(each[:, :count], axis=1) for each in (facets, others)])
    own, known = np.split(row_keys(corners), [len(facets)])
    return np.isin(own, known)
