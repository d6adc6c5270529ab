# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a Gmsh model or a mesh file to one mesh per body, checked.

The functions are serial: they are called on one process. Lengths are in the units of the mesh.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from types import ModuleType

from fretfe.errors import MeshError
from fretfe.files import require_file
from fretfe.geometry.gmsh_model import RawMesh, gmsh_model, raw_mesh, script_model
from fretfe.geometry.templates import Template
from fretfe.mesh.contained import MESHING, raw_mesh_of
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.split import mesh_from_raw

# Sets the element sizes of the current Gmsh model.
SetSizes = Callable[[ModuleType], None]
# Opens a Gmsh model, and closes it.
OpenModel = Callable[[], AbstractContextManager[ModuleType]]


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read a Gmsh file (.msh, format 2.2 or 4.1) whose physical groups have names.

    Raises:
        MeshError: The file is missing or unreadable, or the mesh in it is not a set of separate
            plane or solid bodies with valid elements.
    """
    path = Path(path)
    _require_gmsh_file(path)
    return mesh_from_raw(raw_mesh_of(partial(_merged, path), path), str(path))


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
    model = partial(script_model, template, parameters)
    raw = _meshed(model, template.path, order, size, lambda: None)
    return mesh_from_raw(raw, f"template '{template.name}'")


def mesh_script(
    template: Template, parameters: Mapping[str, float], order: int, size: SetSizes | None
) -> Mesh:
    """Mesh a Gmsh script of the user in a process of its own, which the script may end.

    Arguments and errors are those of `mesh_template`.
    """
    model = partial(script_model, template, parameters)
    work = partial(_meshed, model, template.path, order, size)
    # A script may build, and mesh, for long.
    return mesh_from_raw(raw_mesh_of(work, template.path, MESHING), str(template.path))


def mesh_model(model: OpenModel, path: Path, order: int, size: SetSizes) -> Mesh:
    """Mesh the model of a file in a process of its own; its physical groups have names.

    Args:
        model: Opens and closes the model.
        path: File that it comes from.
        order: Polynomial order of the elements.
        size: Sets element sizes.

    Raises:
        MeshError: Gmsh cannot mesh the geometry, or the mesh is not valid.
    """
    raw = raw_mesh_of(partial(_meshed, model, path, order, size), path)
    return mesh_from_raw(raw, str(path))


def _meshed(
    model: OpenModel, path: Path, order: int, size: SetSizes | None, opened: Callable[[], None]
) -> RawMesh:
    with model() as gmsh:
        opened()
        if size is not None:
            size(gmsh)
        gmsh.model.mesh.generate(gmsh.model.getDimension())
        gmsh.model.mesh.setOrder(order)
        return raw_mesh(gmsh, path)


def _merged(path: Path, opened: Callable[[], None]) -> RawMesh:
    with gmsh_model(path) as gmsh:
        gmsh.merge(str(path))
        opened()
        return raw_mesh(gmsh, path)


def _require_gmsh_file(path: Path) -> None:
    """Gmsh executes a file that is not a mesh as a script: only a mesh may get that far."""
    require_file(path, "a mesh file", MeshError)
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
