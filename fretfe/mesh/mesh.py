# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a Gmsh model or a mesh file to one mesh per body, checked.

The functions are serial: they are called on one process. Lengths are in the units of the mesh.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import MeshError
from fretfe.geometry.gmsh_model import (
    CELL_TYPES,
    LINE_ORDERS,
    SERENDIPITY_QUADRILATERAL,
    ElementBlock,
    RawMesh,
    gmsh_model,
    raw_mesh,
    script_model,
)
from fretfe.geometry.templates import Template
from fretfe.mesh.cell_geometry import (
    counter_clockwise,
    directed_edges,
    exterior_edges,
)

# Out-of-plane coordinates below this fraction of the size of the mesh are round-off.
PLANE_TOLERANCE = 1e-9

# Sets the element sizes of the current Gmsh model.
SetSizes = Callable[[ModuleType], None]


@dataclass(frozen=True)
class BodyMesh:
    """The mesh of one body, with its own node numbers.

    Attributes:
        name: Physical surface group.
        points: (n, 2) coordinates; (n, 3) of a solid.
        cells: (m, k) node indices, counter-clockwise, in Gmsh node order.
        cell: "triangle" or "quadrilateral"; "tetrahedron" of a solid.
        order: 1, or 2 (6-node triangles, 9-node quadrilaterals; edges may be curved).
        boundaries: Facets (f, order + 1) by physical curve group: end, end[, middle]. The body is
            on the left of a facet that is walked from its first to its second end. Of a solid
            triangles (f, 3 or 6) that run counter-clockwise seen from the outside.
    """

    name: str
    points: Array
    cells: Indices
    cell: str
    order: int
    boundaries: dict[str, Indices]


@dataclass(frozen=True)
class Mesh:
    """Bodies by name; no two of them share a node."""

    bodies: dict[str, BodyMesh]

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return next(iter(self.bodies.values())).points.shape[1]


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read a Gmsh file (.msh, format 2.2 or 4.1) whose physical groups have names.

    Raises:
        MeshError: The file is missing or unreadable, or the mesh in it is not a set of separate
            plane bodies with valid elements.
    """
    path = Path(path)
    _require_gmsh_file(path)
    with gmsh_model(path) as gmsh:
        gmsh.merge(str(path))
        raw = raw_mesh(gmsh, path)
    return mesh_from_raw(raw, str(path))


def mesh_template(
    template: Template,
    parameters: Mapping[str, float],
    order: int,
    size: SetSizes | None = None,
) -> Mesh:
    """Mesh a geometry template with elements of order 1 or 2 (curved edges).

    Args:
        template: What to mesh.
        parameters: Values that differ from the defaults of the template.
        order: Polynomial order of the elements.
        size: Sets element sizes in place of those of the template.

    Raises:
        CaseError: A parameter is unknown, out of range or at odds with another.
        MeshError: Gmsh cannot mesh the geometry, or the mesh is not valid.
    """
    model = script_model(template, parameters)
    return mesh_model(model, template.path, order, size, f"template '{template.name}'")


def mesh_model(
    model: AbstractContextManager[ModuleType],
    path: Path,
    order: int,
    size: SetSizes | None,
    source: str,
) -> Mesh:
    """Mesh a Gmsh model whose physical groups have names.

    Args:
        model: Opens and closes the model.
        path: File that it comes from.
        order: Polynomial order of the elements.
        size: Sets element sizes in place of those of the model.
        source: What the model is called in messages.

    Raises:
        MeshError: Gmsh cannot mesh the geometry, or the mesh is not valid.
    """
    with model as gmsh:
        if size is not None:
            size(gmsh)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        raw = raw_mesh(gmsh, path)
    return mesh_from_raw(raw, source)


def _require_gmsh_file(path: Path) -> None:
    """Gmsh executes a file that is not a mesh as a script: only a mesh may get that far."""
    try:
        with path.open("rb") as file:
            start = file.read(200)
    except OSError as error:
        raise MeshError(f"{path}: cannot read the mesh file: {error.strerror}") from error
    if not start.lstrip().startswith((b"$MeshFormat", b"$Comments")):
        raise MeshError(
            f"{path}: expected a Gmsh mesh file (.msh) that starts with $MeshFormat,"
            f" found {start[:20]!r}"
        )


@dataclass(frozen=True)
class _Cells:
    """Cells (m, k) of one body before it has its own node numbers."""

    cell: str
    order: int
    nodes: Indices


def mesh_from_raw(raw: RawMesh, source: str) -> Mesh:
    """Split a mesh into bodies with their own node numbers and boundaries.

    Raises:
        MeshError: It is not a set of separate plane bodies with valid elements.
    """
    cells = {name: _cells(name, blocks, source) for name, blocks in raw.surfaces.items()}
    _require_one_order(raw, cells, source)
    owner = _node_owners(raw, cells, source)
    # number of each node within its body
    local = np.full(len(raw.points), -1)
    for number in range(len(cells)):
        local[owner == number] = np.arange(np.count_nonzero(owner == number))
    facets = _boundaries_of_bodies(raw, owner, source)
    bodies = {}
    for number, (name, part) in enumerate(cells.items()):
        points = _plane_points(name, raw.points[owner == number], source)
        bodies[name] = _body(
            name,
            points,
            replace(part, nodes=local[part.nodes]),
            source,
            {group: local[lines] for group, lines in facets[number].items()},
        )
    return Mesh(bodies)


def _cells(name: str, blocks: list[ElementBlock], source: str) -> _Cells:
    """The elements of a physical surface as one array of one kind."""
    types = {block.gmsh_type for block in blocks}
    if SERENDIPITY_QUADRILATERAL in types:
        raise MeshError(
            f"{source}: body '{name}' has 8-node quadrilaterals; expected 9-node ones"
            " (Gmsh: Mesh.SecondOrderIncomplete = 0)"
        )
    if unknown := types - CELL_TYPES.keys():
        raise MeshError(
            f"{source}: body '{name}' has elements of Gmsh type {sorted(unknown)}; expected"
            " triangles with 3 or 6 nodes or quadrilaterals with 4 or 9"
        )
    kinds = sorted({CELL_TYPES[kind] for kind in types})
    if len(kinds) > 1:
        found = " and ".join(f"{cell}s of order {order}" for cell, order in kinds)
        raise MeshError(f"{source}: body '{name}' mixes {found}; expected one kind per body")
    return _Cells(*kinds[0], np.concatenate([block.nodes for block in blocks]))


def _require_one_order(raw: RawMesh, cells: Mapping[str, _Cells], source: str) -> None:
    """All bodies and boundary lines must be of the same polynomial order."""
    orders = {f"body '{name}'": part.order for name, part in cells.items()}
    for name, blocks in raw.curves.items():
        for block in blocks:
            orders[f"boundary '{name}'"] = LINE_ORDERS.get(block.gmsh_type, 3)
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
            raise MeshError(
                f"{source}: bodies '{other}' and '{names[number]}' share {len(shared)} of their"
                f" nodes, the first at {_coordinates(raw.points[shared[0]])}; each body needs a"
                " mesh of its own. Either a surface is in two physical surfaces, or the interface"
                " was merged: give each body its own points and curves there (in Gmsh no Coherence,"
                " BooleanFragments or Mesh > Remove duplicate nodes)"
            )
        owner[nodes] = number
    return owner


def _plane_points(name: str, points: Array, source: str) -> Array:
    """The x and y of points (n, 3) that lie in the plane z = 0."""
    height = np.abs(points[:, 2])
    if height.max() > PLANE_TOLERANCE * np.ptp(points, axis=0).max():
        raise MeshError(
            f"{source}: expected a mesh in the plane z = 0, but body '{name}' has a node at"
            f" {_coordinates(points[height.argmax()])}"
        )
    return np.ascontiguousarray(points[:, :2])


def _boundaries_of_bodies(raw: RawMesh, owner: Indices, source: str) -> list[dict[str, Indices]]:
    """The lines (f, order + 1) of each physical curve, split by the body that has their nodes."""
    facets: list[dict[str, Indices]] = [{} for _ in range(owner.max() + 1)]
    for name, blocks in raw.curves.items():
        lines = np.concatenate([block.nodes for block in blocks])
        bodies = owner[lines]
        stray = (bodies < 0).any(axis=1) | (bodies != bodies[:, :1]).any(axis=1)
        _refuse_facets(name, raw.points, lines[stray], len(lines), source)
        for number in np.unique(bodies):
            facets[number][name] = lines[bodies[:, 0] == number]
    return facets


def _body(
    name: str,
    points: Array,
    cells: _Cells,
    source: str,
    facets: Mapping[str, Indices],
) -> BodyMesh:
    """Check the cells, turn them counter-clockwise, and turn the facets with them."""
    nodes, bad = counter_clockwise(points, cells.nodes, cells.cell, cells.order)
    if len(bad):
        raise MeshError(
            f"{source}: body '{name}' has inverted elements ({len(bad)} of {len(nodes)}), the"
            f" first at {_coordinates(points[nodes[bad[0]]].mean(axis=0))}"
        )
    edges, folded = exterior_edges(directed_edges(nodes, cells.cell, cells.order))
    if len(folded):
        raise MeshError(
            f"{source}: body '{name}' has elements that overlap, the first at the edge from"
            f" {_coordinates(points[folded[0, 0]])} to {_coordinates(points[folded[0, 1]])}"
        )
    boundaries = {
        group: _exterior_facets(group, points, edges, lines, source)
        for group, lines in facets.items()
    }
    return BodyMesh(name, points, nodes, cells.cell, cells.order, boundaries)


def _exterior_facets(
    group: str,
    points: Array,
    edges: Indices,
    lines: Indices,
    source: str,
) -> Indices:
    """The exterior edges of a body that lines coincide with, in the order of the lines."""
    keys = _edge_keys(edges, len(points))
    order = np.argsort(keys)
    wanted = _edge_keys(lines, len(points))
    places = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)]
    _refuse_facets(group, points, lines[keys[places] != wanted], len(lines), source)
    _, first = np.unique(places, return_index=True)
    return edges[places[np.sort(first)]]


def _edge_keys(edges: Indices, node_count: int) -> Indices:
    """One number per edge, the same for both directions."""
    return edges[:, :2].min(axis=1) * node_count + edges[:, :2].max(axis=1)


def _refuse_facets(group: str, points: Array, bad: Indices, count: int, source: str) -> None:
    """Raise if there are facets that no body has on its outside."""
    if len(bad):
        raise MeshError(
            f"{source}: expected boundary '{group}' on the outside of a body, but {len(bad)} of its"
            f" {count} facets are not exterior edges of any body, the first from"
            f" {_coordinates(points[bad[0, 0]])} to {_coordinates(points[bad[0, 1]])}"
        )


def _coordinates(point: Array) -> str:
    return f"({', '.join(f'{value:.6g}' for value in point)})"
