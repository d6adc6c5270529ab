# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mesh of a case: read or made, extruded where asked for, with all groups that it names."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from types import ModuleType

import numpy as np

from fretfe.case import Case, Geometry, check_dimension, complaint
from fretfe.case.base import ABAQUS, CAD, GMSH_SCRIPT, XDMF, FileKind, Selector, file_kind
from fretfe.case.tables import Part
from fretfe.environment import machine_memory
from fretfe.errors import CaseError, MeshError
from fretfe.files import file_fault
from fretfe.mesh.cad import cad_model
from fretfe.mesh.contained import arrays_of, raw_mesh_of
from fretfe.mesh.extrusion import BACK, FRONT, TETRAHEDRA, Ends, SectorSides, extrude
from fretfe.mesh.gmsh import RawMesh
from fretfe.mesh.inp_demands import Uses
from fretfe.mesh.inp_groups import label_of, read_inp
from fretfe.mesh.make import SetSizes, mesh_model, mesh_script, mesh_template, read_mesh
from fretfe.mesh.mesh import Mesh, check_groups, named_boundaries
from fretfe.mesh.part import around_ball, cut_name, part_of
from fretfe.mesh.sections import Sweep, section_model, sweep_arrays, sweep_of_arrays
from fretfe.mesh.sizing import Sizes, apply_fine_sizes, apply_sizes, apply_sizes_on_faces
from fretfe.mesh.split import mesh_from_raw
from fretfe.mesh.templates import Template, find_template, read_template
from fretfe.mesh.xdmf import read_xdmf

# Growth of the element size per distance from the contact surfaces.
GROWTH = 0.2
GROWTH_IN_SPACE = 0.35
# Elements along the shorter surface of a contact of bodies that are swept, but for finer places.
ALONG_SWEPT = 16


@contextmanager
def naming_case(case: Case) -> Iterator[None]:
    """Put the case file in front of the messages of errors that do not begin with it."""
    try:
        yield
    except (CaseError, MeshError) as error:
        if str(error).startswith(str(case.source)):
            raise
        raise type(error)(f"{case.source}: {error}") from error


def grouped_mesh(case: Case, size: SetSizes | None = None, *, section: bool = False) -> Mesh:
    """Read or make the mesh of a case and check its groups and dimension. Serial.

    Args:
        case: validated case.
        size: sets element sizes of plane bodies in place of those of the geometry, and changes
            those of solids; can be pickled.
        section: whether it is plane, that of the section which solids of a CAD file sweep.

    Raises:
        CaseError: if the template or its parameters are not valid, a direction does not fit, a
            script is not trusted, or the geometry has a mesh already and sizes are to be set.
        MeshError: if there is no valid mesh with all the groups that the case names.
    """
    with naming_case(case):
        mesh = made_mesh(case, size, section=section)
        check_groups(mesh, case)
        check_dimension(case, mesh.dimension)
    return mesh


def made_mesh(case: Case, size: SetSizes | None = None, *, section: bool = False) -> Mesh:
    """Read or make the mesh of a case, extruded and cut as it says, whatever else it names.

    Arguments and errors are those of `grouped_mesh`.
    """
    mesh, solid, part = _mesh_of_case(case, size), case.geometry.solid, case.geometry.part
    if solid is None:
        sweep = None if section else sweep_of(case)
        mesh = mesh if sweep is None else sweep.swept(mesh)
        return mesh if part is None else _part_of(case, mesh, part)
    if part is None:
        return _extruded_mesh(case, mesh)
    # A circle of a plane mesh that is extruded becomes a cylinder that leans as the bodies do; a
    # ball is within one.
    circle = around_ball(part, solid)
    found = _extruded_mesh(case, _part_of(case, mesh, circle))
    return found if circle is part else _part_of(case, found, part, again=True)


def sweep_of(case: Case) -> Sweep | None:
    """The sweep of plane sections that makes the bodies of a case; None if they are made otherwise.

    Raises:
        CaseError: as for `grouped_mesh`, of a CAD file.
    """
    return section_of(case) if case.geometry.size is None else None


def section_of(case: Case) -> Sweep | None:
    """The sweep that bodies of a case are, also if they are meshed as they stand."""
    solid, file = case.geometry.solid, case.geometry.file
    if solid is not None:
        return Sweep(np.zeros(3), np.eye(3), solid, {})
    if file is None or file_kind(file) is not CAD:
        return None
    found = _cad_sweep(case, case.resolve(file))
    return found if isinstance(found, Sweep) else None


def _cad_sweep(case: Case, path: Path) -> Sweep | str:
    """The sweep of the bodies of a CAD file, or why there is none."""
    if fault := file_fault(path):
        return f"found {fault}"
    geometry, changed = case.geometry.model_dump_json(exclude_unset=True), path.stat().st_mtime_ns
    return _found_sweep(path, geometry, case.units.length, case.surface_names, changed)


@lru_cache(maxsize=8)
def _found_sweep(
    path: Path, geometry: str, length: str, surfaces: frozenset[str], _changed: int
) -> Sweep | str:
    own = Geometry.model_validate_json(geometry)
    try:
        return sweep_of_arrays(arrays_of(partial(sweep_arrays, path, own, length, surfaces), path))
    except (CaseError, MeshError) as error:
        return str(error)


def makes_solids(case: Case) -> bool:
    """True if the geometry of a case that refines itself makes solid bodies.

    Of CAD files those have sections, or an element size, that of the first mesh.
    """
    geometry = case.geometry
    if geometry.solid is not None or sweep_of(case) is not None:
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
    surfaces = case.surface_names
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
    if unknown := case.geometry.solid.spans.keys() - mesh.bodies.keys():
        found, known = (", ".join(sorted(each)) for each in (unknown, mesh.bodies))
        text = f"expected spans of the bodies {known}, found one of {found}"
        raise CaseError(complaint(case.source, ("geometry", "solid", "spans"), text))
    _require_room(case, mesh, case.geometry.solid.layers)
    return extrude(mesh, case.geometry.solid, _sides(case, mesh), _free_ends(case, mesh))


def _require_room(case: Case, mesh: Mesh, layers: int) -> None:
    """Check that a plane mesh makes no more solid elements than fit, before they are made.

    Raises:
        MeshError: if they do not.
    """
    from fretfe.mesh.cost import least_memory

    memory = machine_memory()
    cells = sum(len(body.cells) for body in mesh.bodies.values())
    elements = len(TETRAHEDRA) * cells * layers
    if memory is not None and (needed := least_memory(elements, 3)) > memory:
        text = (
            f"expected layers that fit into the memory of this machine ({memory / 2**30:.0f} GB), "
            f"found {layers} on {cells} elements of the plane mesh, which take "
            f"{needed / 2**30:.0f} GB or more: take fewer layers, or larger elements in the plane"
        )
        raise MeshError(complaint(case.source, ("geometry", "solid", "layers"), text))


def _free_ends(case: Case, mesh: Mesh) -> Ends:
    """True for each end of the extrusion, z = 0 and its length, that is a corner of the contacts.

    Where a support holds both bodies along z their mirror images go on behind the end: without a
    corner, unless the bodies lean.
    """
    assert case.geometry.solid is not None
    if case.geometry.solid.skew:
        return True, True
    held = {each.boundary for each in case.supports.values() if each.holds_along_z}
    ends = [[f"{name}_{end}" in held for name in mesh.bodies] for end in (BACK, FRONT)]
    return not all(ends[0]), not all(ends[1])


def _sides(case: Case, mesh: Mesh) -> dict[str, SectorSides]:
    """Sides of sectors about an axis along z, by the body that has them."""
    surfaces = case.surface_names
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
    tied = {each for tie in case.ties.values() for each in (tie.boundary1, tie.boundary2)}
    if kind is GMSH_SCRIPT:
        return _mesh_of_script(case, path, size)
    if kind is CAD:
        return _mesh_of_cad_file(case, path, size)
    if kind is XDMF:
        _require_names(case, XDMF)
        facets = case.resolve(case.geometry.facets) if case.geometry.facets is not None else None
        raw = raw_mesh_of(partial(_read_xdmf, path, facets, case.geometry), path)
        return mesh_from_raw(raw, str(path), case.geometry.merge, mergeable=True, tied=tied)
    if kind is ABAQUS:
        raw = _read_inp(case, path)
        return mesh_from_raw(raw, str(path), case.geometry.merge, mergeable=True, tied=tied)
    return read_mesh(path, case.geometry.merge, tied)


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
    length = case.units.length
    model = partial(cad_model, path, geometry, length)
    if (sweep := sweep_of(case)) is not None:
        section = partial(section_model, path, geometry, length, sweep)
        sizes = partial(_section_sizes, case, size)
        drawn = model if geometry.solid else section
        return mesh_model(drawn, path, geometry.order, sizes, math.inf)
    why = str(_cad_sweep(case, path)) if geometry.size is None else ""
    set_sizes = partial(_cad_sizes, case, size, why)
    return mesh_model(model, path, geometry.order, set_sizes, geometry.size or math.inf)


def _section_sizes(case: Case, size: SetSizes | None, gmsh: ModuleType) -> None:
    """Set sizes of sections that are swept, and then those of a mesh that refines itself."""
    contacts = [(each.surface1, each.surface2) for each in case.contacts.values()]
    apply_fine_sizes(contacts, GROWTH_IN_SPACE, (), ALONG_SWEPT, gmsh)
    if size is not None:
        size(gmsh)


def _cad_sizes(case: Case, size: SetSizes | None, why: str, gmsh: ModuleType) -> None:
    """Set even sizes on whole contact surfaces, and then those of a mesh that refines itself.

    Raises:
        CaseError: if such a mesh is plane and has an element size, or if solids without a section,
            for whatever reason, have none.
    """
    geometry, contacts = case.geometry, case.contacts.values()
    solid = geometry.solid is not None or gmsh.model.getDimension() == 3
    if geometry.size is None and (solid or size is None):
        text = "expected an element size (with edges.tolerance that of the first mesh), found none"
        text += f", and the bodies sweep no section: {why}" if solid else ""
        raise CaseError(complaint(case.source, ("geometry", "size"), text))
    if size is not None and not solid and geometry.size is not None:
        text = "expected none together with edges.tolerance, as the bodies are plane, found "
        text += f"{geometry.size:g}"
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
    made = {f"{name}_{end}" for name in bodies for end in (FRONT, BACK) if geometry.solid}
    made |= {cut_name(name) for name in bodies if geometry.part}
    named = [name for _, name in named_boundaries(case) if name not in made]
    boundaries = dict.fromkeys([*named, *geometry.boundaries])
    part = geometry.part
    if part is not None and geometry.solid is not None:
        part = around_ball(part, geometry.solid)
    selectors = (geometry.bodies, geometry.boundaries)
    return read_inp(path, bodies, boundaries, selectors, _uses(case), part)


def _uses(case: Case) -> Uses:
    """Uses of the boundaries of a deck in a case, by their names there."""
    label = partial(label_of, selectors=case.geometry.boundaries)
    led = [support.boundary for support in case.supports.values()]
    led += [load.on for load in case.loads.values() if load.rigid or load.moves]
    return Uses(
        [(label(tie.boundary1), label(tie.boundary2)) for tie in case.ties.values()],
        {(label(each.boundary1), label(each.boundary2)): each.sectors
         for each in case.symmetry.values()},
        {label(name) for name in led},
        {name: key for key, name in named_boundaries(case)},
    )  # fmt: skip


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
