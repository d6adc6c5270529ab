# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a Gmsh model or a mesh file to one mesh per body, checked.

The functions are serial: they are called on one process. Lengths are in the units of the mesh.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from types import ModuleType

from fretfe.errors import MeshError
from fretfe.geometry.gmsh_model import gmsh_model, raw_mesh, script_model
from fretfe.geometry.templates import Template
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.split import mesh_from_raw

# Sets the element sizes of the current Gmsh model.
SetSizes = Callable[[ModuleType], None]


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read a Gmsh file (.msh, format 2.2 or 4.1) whose physical groups have names.

    Raises:
        MeshError: The file is missing or unreadable, or the mesh in it is not a set of separate
            plane or solid bodies with valid elements.
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
        gmsh.model.mesh.generate(gmsh.model.getDimension())
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
