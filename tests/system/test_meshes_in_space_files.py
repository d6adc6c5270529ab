# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solid meshes in the formats of other programs: the same bodies whatever the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gmsh
import meshio
import numpy as np
import pytest
from cases.pad_cases import pad, press
from dolfinx.io import XDMFFile

from fretfe._typing import Array
from fretfe.case import parse_case
from fretfe.errors import MeshError
from fretfe.fem._compat import MPI
from fretfe.mesh.elements import CORNERS, facet_measures
from fretfe.mesh.gmsh import gmsh_model
from fretfe.mesh.load import grouped_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh

# Numbers of the groups of the Gmsh model, by name.
BODIES = {"upper": 1, "lower": 2}
BOUNDARIES = {"upper_contact": 11, "upper_top": 12, "lower_contact": 13, "lower_bottom": 14}
NUMBERS: dict[str, Any] = {
    "bodies": {name: {"tag": tag} for name, tag in BODIES.items()},
    "boundaries": {name: {"tag": tag} for name, tag in BOUNDARIES.items()},
}
KINDS = ["tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27"]


def write_model(folder: Path, kind: str) -> None:
    """Two cylinders above each other, of radii 1 and 2, as Gmsh's m.msh and m.inp."""
    hexahedra, order = kind.startswith("hex"), 1 if kind in ("tetra", "hexahedron") else 2
    with gmsh_model(folder / "m.msh"):
        for number, (low, radius) in enumerate(((0.0, 1.0), (-2.5, 2.0)), start=1):
            face = 2, gmsh.model.occ.addDisk(0, 0, low, radius, radius)
            made = gmsh.model.occ.extrude([face], 0, 0, 2, [2], recombine=hexahedra)
            gmsh.model.occ.synchronize()
            gmsh.model.addPhysicalGroup(
                3, [made[1][1]], number, name=["upper", "lower"][number - 1]
            )
            ends = [("upper_contact", "upper_top"), ("lower_bottom", "lower_contact")][number - 1]
            for name, end in zip(ends, (face, made[0]), strict=True):
                gmsh.model.addPhysicalGroup(2, [end[1]], BOUNDARIES[name], name=name)
        options = {
            "MeshSizeMax": 1.0,
            "RecombineAll": int(hexahedra),
            "SubdivisionAlgorithm": int(hexahedra),
            "SecondOrderIncomplete": int(kind == "hexahedron20"),
            "SaveGroupsOfNodes": 1,
            "SaveGroupsOfElements": 1,
        }
        before = {name: gmsh.option.getNumber(f"Mesh.{name}") for name in options}
        for name, value in options.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(folder / "m.msh"))
        gmsh.write(str(folder / "m.inp"))
        for name, value in before.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)


def mesh_of(folder: Path, geometry: dict[str, Any]) -> Mesh:
    supports = {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}}
    tables = pad(geometry=geometry, supports=supports, loads={"press": press(steps=1)})
    return grouped_mesh(parse_case(tables, folder / "case.toml"))


def outline(body: BodyMesh) -> dict[str, Array]:
    """Sorted middles of the facets of each boundary."""
    return {
        name: np.unique(np.round(body.points[facets].mean(axis=1), 9), axis=0)
        for name, facets in body.boundaries.items()
    }


def require_alike(found: Mesh, expected: Mesh) -> None:
    assert found.bodies.keys() == expected.bodies.keys()
    for name, body in expected.bodies.items():
        other = found.bodies[name]
        assert (other.cell, other.order) == (body.cell, body.order)
        first, second = (
            np.sort(b.points[b.cells].mean(axis=1).round(9), axis=0) for b in (body, other)
        )
        np.testing.assert_allclose(first, second, atol=1e-8)
        outlines = outline(body), outline(other)
        assert outlines[0].keys() == outlines[1].keys()
        for group, places in outlines[0].items():
            np.testing.assert_allclose(outlines[1][group], places, atol=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_meshio_files(tmp_path: Path, kind: str) -> None:
    write_model(tmp_path, kind)
    mesh = meshio.read(tmp_path / "m.msh")
    assert kind in mesh.cells_dict
    tags = mesh.cell_data["gmsh:physical"]
    meshio.Mesh(mesh.points, mesh.cells, cell_data={"group": tags}).write(tmp_path / "m.xdmf")
    found = mesh_of(tmp_path, {"file": "m.xdmf", **NUMBERS})
    if kind == "hexahedron20":
        assert found.bodies["upper"].cells.shape[1] == 27
        with pytest.raises(MeshError, match="20-node hexahedra; expected 27-node"):
            mesh_of(tmp_path, {"file": "m.msh"})
        write_model(tmp_path, "hexahedron27")
    require_alike(found, mesh_of(tmp_path, {"file": "m.msh"}))


@pytest.mark.parametrize("kind", ["tetra", "tetra10", "hexahedron", "hexahedron27"])
def test_dolfinx_files(tmp_path: Path, kind: str) -> None:
    write_model(tmp_path, kind)
    mesh = meshio.read(tmp_path / "m.msh")
    tags = mesh.cell_data["gmsh:physical"]
    for name, solid in (("cells", True), ("facets", False)):
        parts = [
            (block.type, block.data, tag)
            for block, tag in zip(mesh.cells, tags, strict=True)
            if (block.type == kind) == solid
        ]
        cells = [(parts[0][0], np.concatenate([data for _, data, _ in parts]))]
        numbers = [np.concatenate([tag for *_, tag in parts])]
        part = meshio.Mesh(mesh.points, cells, cell_data={"group": numbers})
        # the HDF5 of DOLFINx may have no compression
        part.write(tmp_path / f"{name}.xdmf", compression=None)
    with XDMFFile(MPI.COMM_SELF, str(tmp_path / "cells.xdmf"), "r") as file:
        read = file.read_mesh(name="Grid")
        bodies = file.read_meshtags(read, name="Grid")
    read.topology.create_connectivity(2, 3)
    with XDMFFile(MPI.COMM_SELF, str(tmp_path / "facets.xdmf"), "r") as file:
        boundaries = file.read_meshtags(read, name="Grid")
    with XDMFFile(MPI.COMM_SELF, str(tmp_path / "dolfinx.xdmf"), "w") as file:
        file.write_mesh(read)
        for each, name in ((bodies, "bodies"), (boundaries, "boundaries")):
            each.name = name
            file.write_meshtags(each, read.geometry)
    expected = mesh_of(tmp_path, {"file": "m.msh"})
    require_alike(mesh_of(tmp_path, {"file": "dolfinx.xdmf", **NUMBERS}), expected)


@pytest.mark.parametrize("kind", ["tetra", "tetra10", "hexahedron", "hexahedron20"])
def test_abaqus_files(tmp_path: Path, kind: str) -> None:
    write_model(tmp_path, kind)
    found = mesh_of(tmp_path, {"file": "m.inp"})
    if kind == "hexahedron20":
        write_model(tmp_path, "hexahedron27")
    require_alike(found, mesh_of(tmp_path, {"file": "m.msh"}))


def test_areas_of_completed_hexahedra(tmp_path: Path) -> None:
    write_model(tmp_path, "hexahedron20")
    upper = mesh_of(tmp_path, {"file": "m.inp"}).bodies["upper"]
    assert len(np.unique(upper.cells[:, : CORNERS["hexahedron"]])) < len(upper.points)
    area = facet_measures(upper.points, upper.boundaries["upper_contact"]).sum()
    assert area == pytest.approx(np.pi, rel=1e-3)
