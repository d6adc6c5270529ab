# SPDX-License-Identifier: LGPL-3.0-or-later
"""Split a mesh into its bodies, each with its own node numbers, merged where a case asks for it."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case.base import LARGEST, SMALLEST
from fretfe.errors import MeshError
from fretfe.mesh.elements import (
    CORNERS,
    ELEMENTS,
    FACET_SHAPES,
    PLURALS,
    SERENDIPITY_HEXAHEDRON,
    SERENDIPITY_QUADRILATERAL,
    SHAPE_DIMENSIONS,
    UNSUPPORTED,
    directed_facets,
    exterior_facets,
    positive_cells,
    row_keys,
    shortest_edges,
)
from fretfe.mesh.gmsh import ElementBlock, RawMesh
from fretfe.mesh.mesh import BodyMesh, Mesh, place_text
from fretfe.mesh.orders import of_one_order
from fretfe.mesh.pieces import connected_groups, require_joined
from fretfe.mesh.planes import PLANE_TOLERANCE, upright
from fretfe.mesh.simplices import as_simplices

# Part of the shortest side of an element by which a coordinate may be rounded.
LOST_DIGITS = 1e-7
EXPECTED = {
    2: "triangles with 3 or 6 nodes or quadrilaterals with 4 or 9",
    3: "tetrahedra with 4 or 10 nodes or hexahedra with 8 or 27",
}
SERENDIPITY = {
    SERENDIPITY_QUADRILATERAL: ("8-node quadrilaterals", "9-node ones"),
    SERENDIPITY_HEXAHEDRON: ("20-node hexahedra", "27-node ones"),
}


def merged(raw: RawMesh, tolerance: float, source: str) -> tuple[RawMesh, str]:
    """A mesh without double nodes within its bodies; nodes of different bodies stay apart.

    Args:
        raw: mesh whose bodies share no nodes.
        tolerance: distance up to which nodes are merged, in the unit of the mesh.
        source: file, for messages.

    Returns:
        The mesh, with the boundaries on the nodes that are left, and what was done, in words.

    Raises:
        MeshError: an element would lose a node.
    """
    target = np.arange(len(raw.points))
    counts = []
    for name, blocks in raw.bodies.items():
        nodes = np.unique(np.concatenate([block.nodes.ravel() for block in blocks]))
        target[nodes] = nodes[_representatives(raw, nodes, tolerance)]
        _require_whole(name, blocks, raw, target, source)
        counts.append(f"{np.count_nonzero(target[nodes] != nodes)} of '{name}'")
    note = f"merge = {tolerance:g}: nodes joined with others in the same place: {', '.join(counts)}"
    bodies, boundaries = (
        {
            name: [ElementBlock(block.gmsh_type, target[block.nodes]) for block in blocks]
            for name, blocks in groups.items()
        }
        for groups in (raw.bodies, raw.boundaries)
    )
    return replace(raw, bodies=bodies, boundaries=boundaries), note


def _representatives(raw: RawMesh, nodes: Indices, tolerance: float) -> Indices:
    """(n,) place of the first of all nodes that each of some is merged with."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(raw.points[nodes]).query_pairs(tolerance, output_type="ndarray")
    labels = connected_groups(len(nodes), *pairs.T)
    first = np.unique(labels, return_index=True)[1]
    return np.asarray(first[labels])


def _require_whole(
    name: str, blocks: list[ElementBlock], raw: RawMesh, target: Indices, source: str
) -> None:
    for block in blocks:
        ordered = np.sort(target[block.nodes], axis=1)
        bad = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
        if len(bad):
            place = raw.points[block.nodes[bad[0]]].mean(axis=0)[: raw.dimension]
            raise MeshError(
                f"{source}: geometry.merge: expected a distance smaller than all elements, found "
                f"one at which {len(bad)} elements of body '{name}' lose nodes, the first at "
                f"{place_text(place)}"
            )


@dataclass(frozen=True)
class _Cells:
    """Cells (m, k) of one body before it has its own node numbers."""

    cell: str
    order: int
    nodes: Indices


# Corners of the facets of a boundary (f, c), by their shape.
_Facets = dict[str, Indices]


def mesh_from_raw(
    raw: RawMesh,
    source: str,
    merge: float | None = None,
    *,
    mergeable: bool = False,
    tied: Set[str] = frozenset(),
) -> Mesh:
    """Split a mesh into bodies with their own node numbers and boundaries.

    Args:
        raw: mesh.
        source: of it, for messages.
        merge: distance up to which nodes of a body become one; None merges none.
        mergeable: whether a case could ask for that, for messages.
        tied: boundaries at which bodies hang together although they have no common nodes.

    Raises:
        MeshError: It is not a set of separate plane or solid bodies with valid elements.
    """
    _require_finite(raw.points, source)
    raw = of_one_order(_in_plane(raw))
    if merge is not None:
        _node_owners(raw, _all_cells(as_simplices(raw, source), source), source)
        raw, note = merged(raw, merge, source)
        raw = replace(raw, notes=(*raw.notes, note))
    # after that: how faces are divided depends on their nodes
    raw = as_simplices(raw, source)
    notes = list(raw.notes)
    cells = _all_cells(raw, source)
    _require_one_order(raw, cells, source)
    owner = _node_owners(raw, cells, source)
    # number of each node within its body
    local = np.full(len(raw.points), -1)
    for number in range(len(cells)):
        local[owner == number] = np.arange(np.count_nonzero(owner == number))
    facets = _boundaries_of_bodies(raw, owner, source)
    bodies = {}
    for number, (name, part) in enumerate(cells.items()):
        points = raw.points[owner == number]
        if raw.dimension == 2:
            points = _plane_points(name, points, source)
        bodies[name] = _body(
            name,
            points,
            replace(part, nodes=local[part.nodes]),
            source,
            {
                group: {shape: local[corners] for shape, corners in parts.items()}
                for group, parts in facets[number].items()
            },
            mergeable=mergeable,
            tied=tied,
        )
    notes += [
        f"body '{body.name}' consists of {body.pieces} pieces "
        + ("that are tied" if tied & body.boundaries.keys() else "that do not touch each other")
        for body in bodies.values()
        if body.pieces > 1
    ]
    return Mesh(bodies, tuple(notes))


def _in_plane(raw: RawMesh) -> RawMesh:
    """The mesh with plane bodies in z = 0, where they lie in a plane of their own."""
    if raw.dimension == 3:
        return raw
    nodes = [block.nodes.ravel() for blocks in raw.bodies.values() for block in blocks]
    points, note = upright(raw.points, np.unique(np.concatenate(nodes)))
    return replace(raw, points=points, notes=(*raw.notes, note)) if note else raw


def _all_cells(raw: RawMesh, source: str) -> dict[str, _Cells]:
    return {name: _cells(name, blocks, raw, source) for name, blocks in raw.bodies.items()}


def _require_finite(points: Array, source: str) -> None:
    """Points whose distances, and their squares, are numbers."""
    bad = points[~(np.abs(points) <= LARGEST).all(axis=1)]
    if len(bad):
        raise MeshError(
            f"{source}: expected coordinates from {-LARGEST:g} to {LARGEST:g}, found a node at "
            f"{place_text(bad[0])}"
        )
    extent = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if extent < SMALLEST:
        raise MeshError(
            f"{source}: expected a mesh with an extent of {SMALLEST:g} or more, found {extent:g}"
        )


def _cells(name: str, blocks: list[ElementBlock], raw: RawMesh, source: str) -> _Cells:
    """The elements of a body as one array of one kind."""
    types = {block.gmsh_type for block in blocks}
    for kind, (found, expected) in SERENDIPITY.items():
        if kind in types:
            raise MeshError(
                f"{source}: body '{name}' has {found}; expected {expected}"
                " (Gmsh: Mesh.SecondOrderIncomplete = 0)"
            )
    if unknown := types - ELEMENTS.keys():
        others = sorted(
            {UNSUPPORTED.get(kind, f"elements of Gmsh type {kind}") for kind in unknown}
        )
        raise MeshError(
            f"{source}: body '{name}' has {' and '.join(sorted(others))}, which are not supported;"
            f" expected {EXPECTED[raw.dimension]}"
        )
    # what is left of shapes and orders after they were divided and raised
    ((cell, order),) = {ELEMENTS[kind] for kind in types}
    return _Cells(cell, order, np.concatenate([block.nodes for block in blocks]))


def _require_one_order(raw: RawMesh, cells: Mapping[str, _Cells], source: str) -> None:
    """All bodies and boundaries must be of the same polynomial order."""
    orders = {f"body '{name}'": part.order for name, part in cells.items()}
    for name, blocks in raw.boundaries.items():
        for block in blocks:
            shape, order = ELEMENTS.get(block.gmsh_type, ("", 3))
            known = shape in SHAPE_DIMENSIONS and SHAPE_DIMENSIONS[shape] == raw.dimension - 1
            orders[f"boundary '{name}'"] = order if known else 3
    if len(set(orders.values())) > 1:
        found = ", ".join(f"{what}: {order}" for what, order in orders.items())
        raise MeshError(f"{source}: expected one mesh order, 1 or 2, found {found}")


def _node_owners(raw: RawMesh, cells: Mapping[str, _Cells], source: str) -> Indices:
    """Index of the body that each node belongs to, -1 where none (n,)."""
    owner = np.full(len(raw.points), -1)
    names = list(cells)
    for number, part in enumerate(cells.values()):
        nodes = np.unique(part.nodes)
        shared = nodes[owner[nodes] >= 0]
        if len(shared):
            other = names[owner[shared[0]]]
            group, sides = {2: ("surface", "curves"), 3: ("volume", "surfaces")}[raw.dimension]
            raise MeshError(
                f"{source}: bodies '{other}' and '{names[number]}' share {len(shared)} of their"
                f" nodes, the first at {place_text(raw.points[shared[0]])}; each body needs a"
                f" mesh of its own. Either a {group} is in two physical {group}s, or the interface"
                f" was merged: give each body its own points and {sides} there (in Gmsh no"
                " Coherence, BooleanFragments or Mesh > Remove duplicate nodes)"
            )
        owner[nodes] = number
    return owner


def _plane_points(name: str, points: Array, source: str) -> Array:
    """The x and y of points (n, 3) that lie in the plane z = 0."""
    height = np.abs(points[:, 2])
    if height.max() > PLANE_TOLERANCE * np.ptp(points, axis=0).max():
        raise MeshError(
            f"{source}: expected volumes, or surfaces in the plane z = 0, but the mesh has no"
            f" volumes and body '{name}' has a node at {place_text(points[height.argmax()])}."
            " Shells are not supported: mesh the volumes (in Gmsh Mesh > 3D) and name each in a"
            " physical volume"
        )
    return np.ascontiguousarray(points[:, :2])


def _boundaries_of_bodies(raw: RawMesh, owner: Indices, source: str) -> list[dict[str, _Facets]]:
    """The facets of each boundary, split by the body that has their nodes."""
    found: list[dict[str, dict[str, list[Indices]]]] = [{} for _ in range(owner.max() + 1)]
    for name, blocks in raw.boundaries.items():
        total = sum(len(block.nodes) for block in blocks)
        for block in blocks:
            shape, _ = ELEMENTS[block.gmsh_type]
            corners, bodies = block.nodes[:, : CORNERS[shape]], owner[block.nodes]
            stray = (bodies < 0).any(axis=1) | (bodies != bodies[:, :1]).any(axis=1)
            _refuse_facets(name, raw.points, corners[stray], total, source)
            for number in np.unique(bodies):
                parts = found[number].setdefault(name, {}).setdefault(shape, [])
                parts.append(corners[bodies[:, 0] == number])
    return [
        {
            name: {shape: np.concatenate(parts) for shape, parts in shapes.items()}
            for name, shapes in groups.items()
        }
        for groups in found
    ]


def _body(
    name: str,
    points: Array,
    cells: _Cells,
    source: str,
    boundaries: Mapping[str, _Facets],
    *,
    mergeable: bool,
    tied: Set[str],
) -> BodyMesh:
    """Check the cells, turn them the right way round, and turn the facets with them."""
    nodes, bad = positive_cells(points, cells.nodes, cells.cell, cells.order)
    if len(bad):
        raise MeshError(
            f"{source}: body '{name}' has inverted elements ({len(bad)} of {len(nodes)}), the"
            f" first at {place_text(points[nodes[bad[0]]].mean(axis=0))}"
        )
    shape = FACET_SHAPES[cells.cell]
    outside, folded = exterior_facets(directed_facets(nodes, cells.cell, cells.order), shape)
    if len(folded):
        raise MeshError(
            f"{source}: body '{name}' has elements that overlap, the first at the"
            f" {_facet_text(points[folded[0]])}"
        )
    _require_digits(name, points, outside, shape, source)
    body = BodyMesh(name, points, nodes, cells.cell, cells.order, {})
    found = {}
    for group, parts in boundaries.items():
        if other := parts.keys() - {shape}:
            raise MeshError(
                f"{source}: boundary '{group}' has {PLURALS[other.pop()]} on body '{name}' of"
                f" {PLURALS[cells.cell]}; expected {PLURALS[shape]}, the facets of these"
            )
        found[group] = _matching(group, points, outside, parts[shape], source)
    free = np.ones(len(points), dtype=bool)
    for group in tied & found.keys():
        free[found[group]] = False
    pieces = require_joined(body, outside, source, free, mergeable=mergeable)
    return replace(body, boundaries=found, pieces=pieces)


def _require_digits(name: str, points: Array, outside: Indices, shape: str, source: str) -> None:
    """Far from the origin coordinates have no digits left for the shape of a surface."""
    farthest = np.abs(points).max(axis=0)
    smallest = float(shortest_edges(points, outside, shape).min())
    if np.spacing(farthest.max()) > LOST_DIGITS * smallest:
        raise MeshError(
            f"{source}: body '{name}' has coordinates up to {farthest.max():.6g} and elements of "
            f"{smallest:.3g}: so far from the origin coordinates have too few digits for the shape "
            "of the surfaces. Expected bodies near the origin: move the mesh there"
        )


def _matching(
    group: str,
    points: Array,
    outside: Indices,
    wanted: Indices,
    source: str,
) -> Indices:
    """The exterior facets of a body with the corners that are wanted, in the order of these."""
    corners = np.sort(outside[:, : wanted.shape[1]], axis=1)
    keys, asked = np.split(
        row_keys(np.concatenate([corners, np.sort(wanted, axis=1)])), [len(corners)]
    )
    order = np.argsort(keys)
    places = order[np.minimum(np.searchsorted(keys, asked, sorter=order), len(keys) - 1)]
    _refuse_facets(group, points, wanted[keys[places] != asked], len(wanted), source)
    _, first = np.unique(places, return_index=True)
    return outside[places[np.sort(first)]]


def _refuse_facets(group: str, points: Array, bad: Indices, count: int, source: str) -> None:
    """Raise if there are facets (f, c) that no body has on its outside."""
    if len(bad):
        raise MeshError(
            f"{source}: expected boundary '{group}' on the outside of a body, but {len(bad)} of its"
            f" {count} facets are not on the outside of any body, the first is the"
            f" {_facet_text(points[bad[0]])}"
        )


def _facet_text(corners: Array) -> str:
    """The facet with some corners (c, d) in words."""
    if len(corners) == 2:
        return f"edge from {place_text(corners[0])} to {place_text(corners[1])}"
    return f"facet around {place_text(corners.mean(axis=0))}"
