# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write the meshes of the bodies as one Gmsh file with named groups."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fretfe.errors import OutputError
from fretfe.files import cut_off, disk_reason, replacing
from fretfe.mesh.elements import FACET_SHAPES, NUMBERS
from fretfe.mesh.gmsh import gmsh_model
from fretfe.mesh.mesh import BodyMesh, Mesh

# What a file ends with.
LAST = b"$EndElements\n"


def write_mesh(mesh: Mesh, path: Path) -> None:
    """Write a `.msh` file that `read_mesh` reads back.

    Raises:
        OutputError: if the file does not end in .msh or cannot be written.
    """
    if path.suffix != ".msh":
        raise OutputError(f"{path}: expected a mesh file that ends in .msh, found {path.suffix!r}")
    try:
        with replacing(path, path.suffix) as new:
            _write(mesh, new)
    except OSError as error:
        raise OutputError(f"{path}: cannot write the mesh: {disk_reason(error)}") from error


def _write(mesh: Mesh, new: Path) -> None:
    """Write a file.

    Raises:
        OSError: if it cannot be written, of which Gmsh says nothing.
    """
    with gmsh_model(new) as gmsh:
        first_node = 1
        facet_dimension, boundary = mesh.dimension - 1, 1
        for entity, body in enumerate(mesh.bodies.values(), start=1):
            _add_body(gmsh, body, entity, first_node)
            for name, facets in body.boundaries.items():
                gmsh.model.addDiscreteEntity(facet_dimension, boundary, [])
                gmsh.model.mesh.addElementsByType(
                    boundary,
                    NUMBERS[FACET_SHAPES[body.cell], body.order],
                    [],
                    (facets + first_node).ravel(),
                )
                gmsh.model.addPhysicalGroup(facet_dimension, [boundary], name=name)
                boundary += 1
            first_node += len(body.points)
        gmsh.write(str(new))
        with new.open("rb") as file:
            file.seek(max(new.stat().st_size - len(LAST), 0))
            if file.read() != LAST:
                raise cut_off(new)


def _add_body(gmsh: Any, body: BodyMesh, entity: int, first_node: int) -> None:
    """Nodes and cells of one body as a discrete surface or volume with its name."""
    dimension = body.points.shape[1]
    gmsh.model.addDiscreteEntity(dimension, entity, [])
    points = np.zeros((len(body.points), 3))
    points[:, :dimension] = body.points
    tags = np.arange(first_node, first_node + len(points))
    gmsh.model.mesh.addNodes(dimension, entity, tags, points.ravel())
    number = NUMBERS[body.cell, body.order]
    cells = (body.cells + first_node).ravel()
    gmsh.model.mesh.addElementsByType(entity, number, [], cells)
    gmsh.model.addPhysicalGroup(dimension, [entity], name=body.name)
