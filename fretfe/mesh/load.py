# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mesh of a case: read or made, with all the groups that the case names."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import ModuleType

from fretfe.case import Case, Geometry, check_dimension, complaint
from fretfe.case.selectors import ABAQUS, CAD, GMSH_SCRIPT, XDMF, FileKind, Selector, file_kind
from fretfe.errors import CaseError, MeshError
from fretfe.files import file_fault
from fretfe.mesh.cad import cad_model
from fretfe.mesh.contained import raw_mesh_of
from fretfe.mesh.extrude import BACK, FRONT, extrude
from fretfe.mesh.gmsh import RawMesh
from fretfe.mesh.groups import check_groups, named_boundaries
from fretfe.mesh.inp_groups import read_inp
from fretfe.mesh.make import SetSizes, mesh_model, mesh_script, mesh_template, read_mesh
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.sizing import Sizes, apply_sizes, apply_sizes_on_faces
from fretfe.mesh.split import mesh_from_raw
from fretfe.mesh.templates import Template, find_template, read_template
from fretfe.mesh.xdmf import read_xdmf

# Growth of the element size per distance from the contact surfaces.
GROWTH, GROWTH_IN_SPACE = 0.2, 0.35


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
        size: sets element sizes in place of those of the geometry; can be pickled.

    Raises:
        CaseError: if the template or its parameters are not valid, a direction does not fit, a
            script is not trusted, or the geometry has a mesh already and sizes are to be set.
        MeshError: if there is no valid mesh with all the groups that the case names.
    """
    with naming_case(case):
        mesh = _mesh_of_case(case, None if size is None else partial(_in_the_plane, case, size))
        if case.geometry.solid is not None:
            mesh = _extruded(case, mesh)
        check_groups(mesh, case)
        check_dimension(case, mesh.dimension)
    return mesh


def _in_the_plane(case: Case, size: SetSizes, gmsh: ModuleType) -> None:
    """Set the sizes of a mesh that refines itself, or raise an error where the bodies are solid."""
    if gmsh.model.getDimension() == 3 or case.geometry.solid is not None:
        text = (
            "expected none, as the bodies are solid and come from a file; of solids only the "
            "meshes of templates refine themselves; give smaller elements instead"
        )
        raise CaseError(complaint(case.source, ("edges", "tolerance"), text))
    size(gmsh)


def _extruded(case: Case, mesh: Mesh) -> Mesh:
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
    return extrude(mesh, case.geometry.solid)


def _mesh_of_case(case: Case, size: SetSizes | None) -> Mesh:
    geometry = case.geometry
    if geometry.template is None:
        assert geometry.file is not None
        return _mesh_of_file(case, geometry.file, size)
    template = find_template(geometry.template, length=case.units.length)
    if size is not None:
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
        raw = raw_mesh_of(_reading_xdmf(case, path), path)
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
    if size is not None:
        _refuse_sizes(case, template)
    return mesh_script(template, given, case.geometry.order, size)


def _mesh_of_cad_file(case: Case, path: Path, size: SetSizes | None) -> Mesh:
    geometry = case.geometry
    _require_names(case, CAD)
    if (size is None) == (geometry.size is None):
        found = "none" if size is None else f"{geometry.size:g} together with edges.tolerance"
        text = f"expected an element size for {path.name}, or edges.tolerance, found {found}"
        raise CaseError(complaint(case.source, ("geometry", "size"), text))
    if size is None:
        contacts = case.contacts.values()
        surfaces = [name for each in contacts for name in (each.surface1, each.surface2)]
        size = partial(_even_sizes, dict.fromkeys(surfaces, geometry.size or 0.0))
    model = partial(cad_model, path, geometry, case.units.length)
    return mesh_model(model, path, geometry.order, size, geometry.size or math.inf)


def _even_sizes(sizes: Mapping[str, float], gmsh: ModuleType) -> None:
    """Set sizes on whole contact surfaces, by their names."""
    if gmsh.model.getDimension() == 3:
        apply_sizes_on_faces(gmsh, sizes, GROWTH_IN_SPACE)
    else:
        apply_sizes(gmsh, Sizes(sizes, GROWTH))


def _reading_xdmf(case: Case, path: Path) -> Callable[[Callable[[], None]], RawMesh]:
    geometry = case.geometry
    _require_names(case, XDMF)
    facets = case.resolve(geometry.facets) if geometry.facets is not None else None
    return partial(_read_xdmf, path, facets, geometry)


def _read_xdmf(
    path: Path, facets: Path | None, geometry: Geometry, opened: Callable[[], None]
) -> RawMesh:
    raw = read_xdmf(path, facets, geometry.bodies, geometry.boundaries)
    opened()
    return raw


def _read_inp(case: Case, path: Path) -> RawMesh:
    geometry = case.geometry
    bodies = dict.fromkeys([*case.bodies, *geometry.bodies])
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
