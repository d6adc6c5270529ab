# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write the meshes of the bodies as one Gmsh file with named groups."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fretfe.errors import OutputError
from fretfe.fem.gmsh_reader import gmsh_model
from fretfe.fem.meshing import BodyMesh, Mesh

CELL_NUMBERS = {
    ("triangle", 1): 2,
    ("triangle", 2): 9,
    ("quadrilateral", 1): 3,
    ("quadrilateral", 2): 10,
}
LINE_NUMBERS = {1: 1, 2: 8}


def write_mesh(mesh: Mesh, path: Path) -> None:
    """Write a `.msh` file that `read_mesh` reads back.

    Raises:
        OutputError: if the file does not end in .msh or cannot be written.
    """
    if path.suffix != ".msh":
        raise OutputError(f"{path}: expected a mesh file that ends in .msh, found {path.suffix!r}")
    with gmsh_model(path) as gmsh:
        first_node = 1
        curve = 1
        for surface, body in enumerate(mesh.bodies.values(), start=1):
            _add_body(gmsh, body, surface, first_node)
            for name, facets in body.boundaries.items():
                gmsh.model.addDiscreteEntity(1, curve, [])
                gmsh.model.mesh.addElementsByType(
                    curve, LINE_NUMBERS[body.order], [], (facets + first_node).ravel()
                )
                gmsh.model.addPhysicalGroup(1, [curve], name=name)
                curve += 1
            first_node += len(body.points)
        gmsh.write(str(path))


def _add_body(gmsh: Any, body: BodyMesh, surface: int, first_node: int) -> None:
    """Nodes and cells of one body as a discrete surface with its name."""
    gmsh.model.addDiscreteEntity(2, surface, [])
    points = np.zeros((len(body.points), 3))
    points[:, : body.points.shape[1]] = body.points
    tags = np.arange(first_node, first_node + len(points))
    gmsh.model.mesh.addNodes(2, surface, tags, points.ravel())
    number = CELL_NUMBERS[body.cell, body.order]
    cells = (body.cells + first_node).ravel()
    gmsh.model.mesh.addElementsByType(surface, number, [], cells)
    gmsh.model.addPhysicalGroup(2, [surface], name=body.name)
