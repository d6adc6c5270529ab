# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mesh of a case: read or made, extruded where asked for, with all groups that it names.

Extruded meshes are straight or skewed. Every triangle becomes a column of prisms, every prism three
tetrahedra. The diagonals on the sides of the prisms rise from the vertex of lower rank to that of
higher rank; a rank that two mirrored vertices share makes neighbours fit and the mesh of a
symmetric template symmetric. Quadrilaterals become hexahedra, a tensor product. The nodes of order
2 lie on the extruded curved edges: no geometry is lost.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import ModuleType

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.case import Case, Geometry, Solid, check_dimension, complaint
from fretfe.case.base import ABAQUS, CAD, GMSH_SCRIPT, XDMF, FileKind, Selector, file_kind
from fretfe.case.tables import Part
from fretfe.errors import CaseError, MeshError
from fretfe.files import file_fault
from fretfe.mesh.cad import cad_model
from fretfe.mesh.contained import raw_mesh_of
from fretfe.mesh.elements import MIDDLES, reference_nodes, reversal
from fretfe.mesh.gmsh import RawMesh
from fretfe.mesh.inp_groups import read_inp
from fretfe.mesh.make import SetSizes, mesh_model, mesh_script, mesh_template, read_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh, check_groups, named_boundaries
from fretfe.mesh.part import around_ball, part_of
from fretfe.mesh.sizing import Sizes, apply_sizes, apply_sizes_on_faces
from fretfe.mesh.split import mesh_from_raw
from fretfe.mesh.templates import Template, find_template, read_template
from fretfe.mesh.xdmf import read_xdmf

# Growth of the element size per distance from the contact surfaces.
GROWTH = 0.2
GROWTH_IN_SPACE = 0.35
FRONT = "front"
BACK = "back"

# The vertices (rank 0, 1 or 2; lower or upper layer) of the three tetrahedra of a prism.
_TETRAHEDRA = (
    ((0, 0), (1, 0), (2, 0), (2, 1)),
    ((0, 0), (1, 0), (2, 1), (1, 1)),
    ((0, 0), (0, 1), (1, 1), (2, 1)),
)
# The same for the two triangles of a quadrilateral on the side of a prism.
_SIDES = (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1)))
# Ends of the edges whose middles follow the vertices, by the number of these.
_EDGES = {3: MIDDLES["triangle"], 4: MIDDLES["tetrahedron"]}
# The shapes of cells and side facets over those of the plane mesh.
_SWEPT = {"triangle": "tetrahedron", "quadrilateral": "hexahedron", "line": "quadrilateral"}


@contextmanager
def naming_case(case: Case) -> Iterator[None]:
    """Put the case file in front of the messages of errors that do not begin with it."""
    try:
        yield
    except (CaseError, MeshError) as error:
        if str(error).startswith(str(case.source)):
            raise
        raise type(error)(f"{case.source}: {error}") from error


def grouped_mesh(case: Case, size: SetSizes | None = None) -> Mesh:
    """Read or make the mesh of a case and check its groups and dimension. Serial.

    Args:
        case: validated case.
        size: sets element sizes of plane bodies in place of those of the geometry, and changes
            those of solids; can be pickled.

    Raises:
        CaseError: if the template or its parameters are not valid, a direction does not fit, a
            script is not trusted, or the geometry has a mesh already and sizes are to be set.
        MeshError: if there is no valid mesh with all the groups that the case names.
    """
    with naming_case(case):
        mesh = made_mesh(case, size)
        check_groups(mesh, case)
        check_dimension(case, mesh.dimension)
    return mesh


def made_mesh(case: Case, size: SetSizes | None = None) -> Mesh:
    """Read or make the mesh of a case, extruded and cut as it says, whatever else it names.

    Arguments and errors are those of `grouped_mesh`.
    """
    mesh, solid, part = _mesh_of_case(case, size), case.geometry.solid, case.geometry.part
    if solid is None:
        return mesh if part is None else _part_of(case, mesh, part)
    if part is None:
        return _extruded_mesh(case, mesh)
    # A circle of a plane mesh that is extruded becomes a cylinder that leans as the bodies do; a
    # ball is within one.
    circle = around_ball(part, solid)
    found = _extruded_mesh(case, _part_of(case, mesh, circle))
    return found if circle is part else _part_of(case, found, part, again=True)


def makes_solids(case: Case) -> bool:
    """True if the geometry of a case that refines itself makes solid bodies.

    Of CAD files those have an element size, that of the first mesh.
    """
    geometry = case.geometry
    if geometry.solid is not None:
        return True
    if geometry.template is not None:
        return find_template(geometry.template).solid
    assert geometry.file is not None
    kind, path = file_kind(geometry.file), case.resolve(geometry.file)
    if kind is GMSH_SCRIPT and case.trust_geo and not file_fault(path):
        return read_template(path).solid
    return kind is CAD and geometry.size is not None


def size_key(case: Case) -> tuple[str, float]:
    """Key of the element size at contact edges, and its value; empty text where there is none."""
    geometry = case.geometry
    if geometry.template is not None:
        template = find_template(geometry.template, length=case.units.length)
    elif geometry.size is not None:
        return "geometry.size", geometry.size
    else:
        assert geometry.file is not None
        path = case.resolve(geometry.file)
        if file_kind(geometry.file) is not GMSH_SCRIPT:
            return "", math.nan
        template = read_template(path)
    sizes = {each.name: each.default for each in template.parameters if each.is_size}
    for name in ("edge_size", "size"):
        if name in sizes:
            value = geometry.parameters.get(name, sizes[name])
            return f"geometry.parameters.{name}", value
    return "", math.nan


def _part_of(case: Case, mesh: Mesh, part: Part, *, again: bool = False) -> Mesh:
    """The part of a mesh around the contacts of a case."""
    if len(part.centre) > mesh.dimension:
        text = f"expected {mesh.dimension} coordinates on this mesh, found {len(part.centre)}"
        raise CaseError(complaint(case.source, ("geometry", "part", "centre"), text))
    surfaces = {name for c in case.contacts.values() for name in (c.surface1, c.surface2)}
    return part_of(mesh, part, surfaces, again=again)


def _extruded_mesh(case: Case, mesh: Mesh) -> Mesh:
    assert case.geometry.solid is not None
    if mesh.dimension == 3:
        source = case.geometry.template or case.geometry.file
        text = f"expected none, as {source} has solid bodies; a plane mesh is extruded"
        raise CaseError(complaint(case.source, ("geometry", "solid"), text))
    taken = {
        name
        for body in mesh.bodies.values()
        for name in (f"{body.name}_{FRONT}", f"{body.name}_{BACK}")
        if any(name in other.boundaries for other in mesh.bodies.values())
    }
    if taken:
        text = (
            f"expected no boundaries with the names of the ends, found {', '.join(sorted(taken))}"
        )
        raise CaseError(complaint(case.source, ("geometry", "solid"), text))
    return extrude(mesh, case.geometry.solid, _sides(case, mesh))


def _sides(case: Case, mesh: Mesh) -> dict[str, SectorSides]:
    """Sides of sectors about an axis along z, by the body that has them."""
    surfaces = {name for c in case.contacts.values() for name in (c.surface1, c.surface2)}
    return {
        name: SectorSides(
            np.array(symmetry.centre[:2]),
            body.points[np.unique(np.concatenate([body.boundaries[each] for each in sides]))],
            body.points[np.unique(np.concatenate([body.boundaries[each] for each in touching]))],
        )
        for symmetry in case.symmetry.values()
        for name, body in mesh.bodies.items()
        if (sides := [s for s in (symmetry.boundary1, symmetry.boundary2) if s in body.boundaries])
        and (touching := surfaces & set(body.boundaries))
        and not any(symmetry.axis[:2])
    }


@dataclass(frozen=True)
class SectorSides:
    """Sides of a sector in the plane that is extruded.

    Sides of a solid that leans would be no images of one another. So they turn about the axis,
    along a helicoid, as fast as the contacts move around it; contacts lean, straight as a broach
    makes them; and what is between them does so in the ratio of the distances.

    Attributes:
        centre: (2,) where the axis is.
        sides: (n, 2) nodes of the sides.
        contacts: (m, 2) nodes of the contact surfaces.
    """

    centre: Array
    sides: Array
    contacts: Array

    def bend(self, points: Array, leaned: Array) -> Array:
        """(n, 2) places in the solid of points (n, 2) that lean by (n,) along x."""
        from scipy.spatial import cKDTree

        away = cKDTree(self.contacts).query(points)[0]
        share = away / (away + cKDTree(self.sides).query(points)[0])
        x, y = (self.contacts - self.centre).mean(axis=0)
        angle = -y / (x**2 + y**2) * leaned
        arms, cosine, sine = points - self.centre, np.cos(angle), np.sin(angle)
        turned = np.column_stack(
            [arms[:, 0] * cosine - arms[:, 1] * sine, arms[:, 0] * sine + arms[:, 1] * cosine]
        )
        straight = points + leaned[:, None] * [1.0, 0.0]
        return np.asarray(straight + share[:, None] * (self.centre + turned - straight))


def _mesh_of_case(case: Case, size: SetSizes | None) -> Mesh:
    geometry = case.geometry
    if geometry.template is None:
        assert geometry.file is not None
        return _mesh_of_file(case, geometry.file, size)
    template = find_template(geometry.template, length=case.units.length)
    if size is not None and not makes_solids(case):
        _refuse_sizes(case, template)
    return mesh_template(template, geometry.parameters, geometry.order, size)


def _refuse_sizes(case: Case, template: Template) -> None:
    """A mesh that refines itself takes no element sizes."""
    given = [each.name for each in template.parameters if each.is_mesh_size]
    given = [name for name in given if name in case.geometry.parameters]
    if given:
        text = f"expected no element sizes together with edges.tolerance, found {', '.join(given)}"
        raise CaseError(complaint(case.source, ("geometry", "parameters"), text))


def _mesh_of_file(case: Case, file: str, size: SetSizes | None) -> Mesh:
    kind, path = file_kind(file), case.resolve(file)
    if size is not None and kind not in (GMSH_SCRIPT, CAD):
        text = f"expected a geometry that can be meshed again, found the mesh {file!r}"
        raise CaseError(complaint(case.source, ("edges", "tolerance"), text))
    if fault := file_fault(path):
        text = f"expected a file, found {fault}"
        raise MeshError(complaint(case.source, ("geometry", "file"), text))
    if kind is GMSH_SCRIPT:
        return _mesh_of_script(case, path, size)
    if kind is CAD:
        return _mesh_of_cad_file(case, path, size)
    if kind is XDMF:
        _require_names(case, XDMF)
        facets = case.resolve(case.geometry.facets) if case.geometry.facets is not None else None
        raw = raw_mesh_of(partial(_read_xdmf, path, facets, case.geometry), path)
        return mesh_from_raw(raw, str(path), case.geometry.merge, mergeable=True)
    if kind is ABAQUS:
        raw = _read_inp(case, path)
        return mesh_from_raw(raw, str(path), case.geometry.merge, mergeable=True)
    return read_mesh(path, case.geometry.merge)


def _mesh_of_script(case: Case, path: Path, size: SetSizes | None) -> Mesh:
    if not case.trust_geo:
        text = (
            f"{path} is a Gmsh script and was not opened: a script can start any program and "
            "write any file (SystemCall, Save). If you know what is in it, add the option "
            "--trust-geo; or mesh it with Gmsh and give the .msh file"
        )
        raise CaseError(complaint(case.source, ("geometry", "file"), text))
    template, given = read_template(path), case.geometry.parameters
    if given and not template.parameters:
        text = (
            f"expected none, as {path} has no DefineConstant block in the form that templates "
            f"have, found {', '.join(given)}"
        )
        raise CaseError(complaint(case.source, ("geometry", "parameters"), text))
    if size is not None and not makes_solids(case):
        _refuse_sizes(case, template)
    return mesh_script(template, given, case.geometry.order, size)


def _mesh_of_cad_file(case: Case, path: Path, size: SetSizes | None) -> Mesh:
    geometry = case.geometry
    _require_names(case, CAD)
    if size is None and geometry.size is None:
        text = f"expected an element size for {path.name}, or edges.tolerance, found none"
        raise CaseError(complaint(case.source, ("geometry", "size"), text))
    set_sizes = partial(_cad_sizes, case, size)
    model = partial(cad_model, path, geometry, case.units.length)
    return mesh_model(model, path, geometry.order, set_sizes, geometry.size or math.inf)


def _cad_sizes(case: Case, size: SetSizes | None, gmsh: ModuleType) -> None:
    """Set even sizes on whole contact surfaces, and then those of a mesh that refines itself.

    Raises:
        CaseError: if such a mesh is plane and has an element size, or is solid and has none.
    """
    geometry, contacts = case.geometry, case.contacts.values()
    solid = geometry.solid is not None or gmsh.model.getDimension() == 3
    if size is not None and solid == (geometry.size is None):
        expected = "that of the first mesh" if solid else "none"
        found = "none" if geometry.size is None else f"{geometry.size:g}"
        text = f"expected {expected} together with edges.tolerance, as the bodies are "
        text += f"{'solid' if solid else 'plane'}, found {found}"
        raise CaseError(complaint(case.source, ("geometry", "size"), text))
    if geometry.size is not None:
        surfaces = [name for each in contacts for name in (each.surface1, each.surface2)]
        _even_sizes(dict.fromkeys(surfaces, geometry.size), gmsh)
    if size is not None:
        size(gmsh)


def _even_sizes(sizes: Mapping[str, float], gmsh: ModuleType) -> None:
    """Set sizes on whole contact surfaces, by their names."""
    if gmsh.model.getDimension() == 3:
        apply_sizes_on_faces(gmsh, sizes, GROWTH_IN_SPACE)
    else:
        apply_sizes(gmsh, Sizes(sizes, GROWTH))


def _read_xdmf(
    path: Path, facets: Path | None, geometry: Geometry, opened: Callable[[], None]
) -> RawMesh:
    raw = read_xdmf(path, facets, geometry.bodies, geometry.boundaries)
    opened()
    return raw


def _read_inp(case: Case, path: Path) -> RawMesh:
    geometry = case.geometry
    bodies = {name: case.bodies.get(name) for name in [*case.bodies, *geometry.bodies]}
    named = [name for _, name in named_boundaries(case)]
    boundaries = dict.fromkeys([*named, *geometry.boundaries])
    return read_inp(path, bodies, boundaries, (geometry.bodies, geometry.boundaries))


def _require_names(case: Case, kind: FileKind) -> None:
    """A file without names of its own needs a selector for every name in the case."""
    uses = [("bodies", f"bodies.{name}", name) for name in case.bodies]
    uses += [("boundaries", key, name) for key, name in named_boundaries(case)]
    tables: dict[str, Mapping[str, Selector]] = {
        "bodies": case.geometry.bodies,
        "boundaries": case.geometry.boundaries,
    }
    missing = {
        complaint(
            case.source,
            ("geometry", table),
            f"expected '{name}', which is {key} and has no name in a {kind.text} unless given here",
        )
        for table, key, name in uses
        if name not in tables[table]
    }
    if missing:
        raise CaseError("\n".join(sorted(missing)))


def extrude(mesh: Mesh, solid: Solid, sectors: Mapping[str, SectorSides] | None = None) -> Mesh:
    """The solid that a plane mesh sweeps along (tan(skew), 0, 1) * length, from z = 0.

    Args:
        mesh: of plane bodies, with cells of order 1 or 2.
        solid: length in the units of the mesh, skew in degrees, number of layers.
        sectors: sides of bodies that turn about an axis.

    Returns:
        Tetrahedra and hexahedra of the same order. The boundaries keep their names; those at the
        ends are called `<body>_back` (z = 0) and `<body>_front` (z = length).
    """
    bodies = {
        name: _extruded_body(body, solid, (sectors or {}).get(name))
        for name, body in mesh.bodies.items()
    }
    return replace(mesh, bodies=bodies)


def _extruded_body(body: BodyMesh, solid: Solid, sector: SectorSides | None) -> BodyMesh:
    """One body; its nodes are those of the plane mesh, level by level (half layers in order 2)."""
    levels = body.order * solid.layers + 1
    z = np.repeat(np.linspace(0.0, solid.length, levels), len(body.points))
    plane = np.tile(body.points, (levels, 1))
    leaned = math.tan(math.radians(solid.skew)) * z
    across = plane + leaned[:, None] * [1.0, 0.0]
    if sector is not None:
        across = sector.bend(plane, leaned)
    points = np.column_stack([across, z])
    columns = (_Prisms if body.cell == "triangle" else _Bricks)(body, solid.layers)
    sides = {name: columns.sides(facets) for name, facets in body.boundaries.items()}
    ends = {
        f"{body.name}_{FRONT}": body.cells + (levels - 1) * len(body.points),
        # from behind, the cells run the other way round
        f"{body.name}_{BACK}": body.cells[:, reversal(body.cell, body.order)],
    }
    cells = columns.cells()
    # a node between the layers on no edge would be left over; there is none in triangles
    assert len(np.unique(cells)) == len(points)
    boundaries = {**sides, **ends}
    return replace(body, points=points, cells=cells, cell=_SWEPT[body.cell], boundaries=boundaries)


class _Bricks:
    """Node numbers of the hexahedra and side facets above quadrilaterals and their edges."""

    def __init__(self, body: BodyMesh, layers: int) -> None:
        self._body = body
        self._layers = layers

    def cells(self) -> Indices:
        """Hexahedra (layers * m, 8 or 27) with positive determinant."""
        return self._swept(self._body.cells, self._body.cell)

    def sides(self, facets: Indices) -> Indices:
        """Quadrilaterals (layers * f, 4 or 9) on the sides above facets, seen from the outside."""
        return self._swept(facets, "line")

    def _swept(self, plane: Indices, shape: str) -> Indices:
        """Cells or facets (n, k) in all layers, each node at its place below and at its level."""
        order, count = self._body.order, len(self._body.points)
        below = reference_nodes(shape, order)
        nodes = reference_nodes(_SWEPT[shape], order)
        places = np.linalg.norm(nodes[:, None, :-1] - below, axis=2).argmin(axis=1)
        levels = np.rint(nodes[:, -1] * order).astype(np.int64)
        one_layer = plane[:, places] + levels * count
        return np.concatenate([one_layer + order * n * count for n in range(self._layers)])


class _Prisms:
    """Node numbers of the tetrahedra and side facets above triangles and their edges."""

    def __init__(self, body: BodyMesh, layers: int) -> None:
        self._body = body
        self._layers = layers
        self._rank = _mirrored_rank(body.points)
        self._middles = _middles(body) if body.order == 2 else np.empty((0, 2), dtype=np.int64)

    def cells(self) -> Indices:
        """Tetrahedra (3 * layers * m, 4 or 10) with positive determinant."""
        triangles, turned = self._ranked(self._body.cells[:, :3])
        cells = np.concatenate([self._nodes(triangles, shape) for shape in _TETRAHEDRA])
        # ranks that run clockwise give the mirror images of the three shapes
        turned = np.tile(turned, len(cells) // len(turned))
        mirrored = cells[:, reversal("tetrahedron", self._body.order)]
        return np.where(turned[:, None], mirrored, cells)

    def sides(self, facets: Indices) -> Indices:
        """Triangles (2 * layers * f, 3 or 6) on the sides above facets, seen from the outside."""
        edges, turned = self._ranked(facets[:, :2])
        triangles = np.concatenate([self._nodes(edges, shape) for shape in _SIDES])
        reversed_triangles = triangles[:, reversal("triangle", self._body.order)]
        turned = np.tile(turned, len(triangles) // len(turned))
        return np.where(turned[:, None], reversed_triangles, triangles)

    def _ranked(self, nodes: Indices) -> tuple[Indices, Bools]:
        """Vertices (n, k) sorted by rank, and whether that is an odd permutation (n,)."""
        order = np.argsort(self._rank[nodes], axis=1)
        turned = np.linalg.det(np.eye(nodes.shape[1])[order]) < 0
        return np.take_along_axis(nodes, order, axis=1), turned

    def _nodes(self, ranked: Indices, shape: tuple[tuple[int, int], ...]) -> Indices:
        """Nodes of one shape in all columns and layers, vertices and then middles of edges."""
        order, count = self._body.order, len(self._body.points)
        places = [(ranked[:, vertex], order * layer) for vertex, layer in shape]
        if order == 2:
            for first, second in _EDGES[len(shape)]:
                level = (places[first][1] + places[second][1]) // 2
                places.append((self._middle(places[first][0], places[second][0]), level))
        one_layer = np.stack([node + level * count for node, level in places], axis=1)
        return np.concatenate([one_layer + order * n * count for n in range(self._layers)])

    def _middle(self, first: Indices, second: Indices) -> Indices:
        """Nodes of the plane mesh in the middle of edges (n,), or the vertex if it is one only."""
        keys = _edge_key(first, second, len(self._body.points))
        place = np.searchsorted(self._middles[:, 0], keys)
        middles: Indices = self._middles[np.minimum(place, len(self._middles) - 1), 1]
        return np.where(first == second, first, middles)


def _mirrored_rank(points: Array) -> Array:
    """Numbers (n,), the same for mirror images in x = 0 but different for neighbours.

    Distance from the axis along a direction in which no mesh has its edges.
    """
    return np.abs(points[:, 0]) * math.cos(1.0) + points[:, 1] * math.sin(1.0)


def _middles(body: BodyMesh) -> Indices:
    """Keys of all edges and their middle nodes, sorted (e, 2)."""
    corners, middles = body.cells[:, :3], body.cells[:, 3:]
    keys = _edge_key(corners, np.roll(corners, -1, axis=1), len(body.points))
    return np.unique(np.column_stack([keys.ravel(), middles.ravel()]), axis=0)


def _edge_key(first: Indices, second: Indices, count: int) -> Indices:
    """One number per edge, the same for both directions."""
    return np.minimum(first, second) * count + np.maximum(first, second)
