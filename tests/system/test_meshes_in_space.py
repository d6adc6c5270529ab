# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of solid bodies: read, extruded and assembled; volumes and areas against closed forms."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
import ufl
from cases import blocks
from cases.pad_cases import BASE, pad, press
from cases.tiny_meshes import TinyMesh
from dolfinx import fem

from fretfe._typing import Array
from fretfe.case import Solid, parse_case
from fretfe.errors import CaseError, MeshError
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import ElasticBody
from fretfe.materials.material import Material
from fretfe.mesh.elements import (
    KINDS,
    PLURALS,
    facet_measures,
    jacobian_determinants,
    quadrature,
    reversal,
    shape_slopes,
    shape_values,
)
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.gmsh import gmsh_model
from fretfe.mesh.load import grouped_mesh
from fretfe.mesh.make import read_mesh, write_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh, body_unknowns, mesh_summary

CELLS = pytest.mark.parametrize(
    ("cell", "order"), [(cell, order) for cell in ("tetrahedron", "hexahedron") for order in (1, 2)]
)


def round_body(directory: Path, cell: str, order: int, version: float = 4.1) -> BodyMesh:
    """The unit ball of tetrahedra, or a cylinder of radius 1 and length 2 of hexahedra."""
    path = directory / "body.msh"
    with gmsh_model(path):
        if cell == "tetrahedron":
            gmsh.model.occ.addSphere(0, 0, 0, 1)
        else:
            disc = gmsh.model.occ.addDisk(0, 0, 0, 1, 1)
            gmsh.model.occ.extrude([(2, disc)], 0, 0, 2, [2], recombine=True)
            gmsh.option.setNumber("Mesh.RecombineAll", 1)
            gmsh.option.setNumber("Mesh.SubdivisionAlgorithm", 1)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.model.addPhysicalGroup(3, [1], name="body")
        for _, tag in gmsh.model.getEntities(2):
            gmsh.model.addPhysicalGroup(2, [tag], name=f"side{tag}")
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(path))
        for option, value in (("RecombineAll", 0), ("SubdivisionAlgorithm", 0)):
            gmsh.option.setNumber(f"Mesh.{option}", value)
    return read_mesh(path).bodies["body"]


def enclosed(body: BodyMesh) -> float:
    """Volume inside the boundaries, a third of the flux of the position through them."""
    total = 0.0
    for facets in body.boundaries.values():
        shape, degree = KINDS[3, facets.shape[1]]
        at, weights = quadrature(shape, 4)
        nodes = body.points[facets]
        tangents = np.einsum("qak,fkd->fqad", shape_slopes(shape, degree, at), nodes)
        places = np.einsum("qk,fkd->fqd", shape_values(shape, degree, at), nodes)
        flux = np.sum(np.cross(tangents[:, :, 0], tangents[:, :, 1]) * places, axis=2)
        total += float((flux @ weights).sum()) / 3
    return total


def assembled(body: BodyMesh) -> tuple[float, dict[str, float]]:
    """Volume and areas of the boundaries, integrated by DOLFINx."""
    elastic = ElasticBody(MPI.COMM_SELF, body, Material(1.0, 0.3, 0.0, "strain"), body.order)
    one = fem.Constant(elastic.mesh, 1.0)
    ds = ufl.Measure("ds", elastic.mesh, subdomain_data=elastic.facet_tags)
    areas = {
        name: float(fem.assemble_scalar(fem.form(one * ds(numbers))))
        for name, numbers in elastic.groups.items()
    }
    unknowns = 3 * elastic.space.dofmap.index_map.size_global
    assert unknowns == body_unknowns(body, body.order)
    return float(fem.assemble_scalar(fem.form(one * ufl.dx))), areas


@CELLS
def test_assembled_volumes_and_areas_are_those_of_the_mesh(
    tmp_path: Path, cell: str, order: int
) -> None:
    body = round_body(tmp_path, cell, order)
    assert (body.cell, body.order) == (cell, order)
    volume, areas = assembled(body)
    # all of the outside is named, and closed: each facet runs the right way round
    assert volume == pytest.approx(enclosed(body), rel=1e-12)
    for name, area in areas.items():
        # Gauss points on curved facets
        found = facet_measures(body.points, body.boundaries[name]).sum()
        assert area == pytest.approx(found, rel=1e-12 if order == 1 else 1e-5)
    exact, outside = (4 / 3, 4) if cell == "tetrahedron" else (2, 6)
    allowed = {1: 0.05, 2: 4e-4}[order]
    assert volume == pytest.approx(exact * math.pi, rel=allowed)
    assert sum(areas.values()) == pytest.approx(outside * math.pi, rel=allowed)


def test_both_formats_of_gmsh_give_the_same_mesh(tmp_path: Path) -> None:
    old, new = (round_body(tmp_path, "hexahedron", 2, version) for version in (2.2, 4.1))
    assert old.boundaries.keys() == new.boundaries.keys()
    assert enclosed(old) == pytest.approx(enclosed(new), rel=1e-12)


@CELLS
def test_a_mesh_that_is_written_is_read_back(tmp_path: Path, cell: str, order: int) -> None:
    body = round_body(tmp_path, cell, order)
    write_mesh(Mesh({"body": body}), tmp_path / "copy.msh")
    copy = read_mesh(tmp_path / "copy.msh").bodies["body"]
    np.testing.assert_array_equal(copy.points, body.points)
    np.testing.assert_array_equal(copy.cells, body.cells)
    for name, facets in body.boundaries.items():
        np.testing.assert_array_equal(copy.boundaries[name], facets)


def bulged(points: Array) -> Array:
    """A map of the square under which sides become parabolas."""
    x, y = points.T
    return np.column_stack([x + 0.2 * y * (1 - y), y + 0.1 * x * (1 - x)])


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_extruded_sections_fill_the_volume(cell: str, order: int) -> None:
    line = np.linspace(0, 1, 4)
    flat = blocks.block("bar", line, line, cell=cell, order=order, mapping=bulged)
    bar = extrude(Mesh({"bar": flat}), Solid(length=3.0, skew=25.0, layers=2)).bodies["bar"]
    count = {"triangle": 18 * 2 * 3, "quadrilateral": 9 * 2}[cell]
    assert bar.cells.shape[0] == count
    assert jacobian_determinants(bar.points, bar.cells, bar.cell, order).min() > 0
    volume, areas = assembled(bar)
    assert volume == pytest.approx(3.0, rel=1e-12)  # opposite sides bulge alike
    assert enclosed(bar) == pytest.approx(3.0, rel=1e-12)
    assert areas["bar_front"] == pytest.approx(1.0, rel=1e-12)
    assert areas["bar_back"] == pytest.approx(1.0, rel=1e-12)


def test_hexahedra_are_a_tensor_product() -> None:
    line = np.linspace(0, 1, 4)
    flat = blocks.block("bar", line, line, order=2, mapping=bulged)
    bar = extrude(Mesh({"bar": flat}), Solid(length=3.0, skew=0.0, layers=2)).bodies["bar"]
    assert bar.points.shape == (5 * len(flat.points), 3)
    np.testing.assert_array_equal(bar.points[: len(flat.points), :2], flat.points)
    # the middles of the cells of the first layer are those of the section, at a quarter
    np.testing.assert_array_equal(bar.points[bar.cells[:9, 26], :2], flat.points[flat.cells[:, 8]])
    np.testing.assert_allclose(bar.points[bar.cells[:9, 26], 2], 0.75)


def test_tetrahedra_of_long_sweeps_are_as_good_as_their_triangles() -> None:
    points, cells = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), np.array([[0, 1, 2]])
    flat = Mesh({"f": BodyMesh("f", points, cells, "triangle", 1, {})})
    (swept,) = mesh_summary(extrude(flat, Solid(length=1e4, skew=0.0, layers=1)))
    assert swept.smallest_angle == pytest.approx(45.0, abs=0.01)


def test_smallest_angle_of_regular_cells() -> None:
    points = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    regular = BodyMesh("t", points, np.array([[0, 1, 2, 3]]), "tetrahedron", 1, {})
    cube = extrude(
        Mesh({"c": blocks.block("c", [0, 1], [0, 1])}), Solid(length=5.0, skew=0.0, layers=1)
    )
    (tetrahedron,), (brick,) = mesh_summary(Mesh({"t": regular})), mesh_summary(cube)
    assert tetrahedron.smallest_angle == pytest.approx(180 - math.degrees(math.acos(1 / 3)))
    assert brick.smallest_angle == pytest.approx(90)


CORNERS = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
CUBE = TinyMesh(
    nodes=(*CORNERS, *((x, y, z + 2) for x, y, z in CORNERS)),
    elements=(
        (5, "lower", (1, 2, 3, 4, 5, 6, 7, 8)),
        (4, "upper", (9, 10, 11, 13)),
        (3, "lower_top", (8, 7, 6, 5)),
        (2, "upper_base", (9, 10, 11)),
    ),
)


def test_bodies_may_differ_in_their_cells_and_backward_ones_are_turned(tmp_path: Path) -> None:
    mesh = read_mesh(CUBE.write(tmp_path / "m.msh"))
    assert mesh.dimension == 3
    lower, upper = mesh.bodies["lower"], mesh.bodies["upper"]
    assert (lower.cell, upper.cell) == ("hexahedron", "tetrahedron")
    # given from inside, seen from outside
    assert lower.boundaries["lower_top"].tolist() == [[4, 5, 6, 7]]
    assert upper.boundaries["upper_base"].tolist() == [[0, 2, 1]]
    backward = (5, "lower", (5, 6, 7, 8, 1, 2, 3, 4))
    turned = read_mesh(
        CUBE.with_elements(backward, *CUBE.elements[1:]).write(tmp_path / "t.msh")
    ).bodies["lower"]
    assert jacobian_determinants(turned.points, turned.cells, "hexahedron", 1).min() > 0
    assert enclosed(turned) == pytest.approx(enclosed(lower))


@CELLS
def test_reversal_gives_the_mirror_image(cell: str, order: int) -> None:
    there = reversal(cell, order)
    np.testing.assert_array_equal(there[there], np.arange(len(there)))


WITHOUT_VOLUMES = CUBE.with_elements((3, "lower", (1, 2, 6, 5)), (3, "upper", (9, 10, 11, 12)))
INVERTED = CUBE.move(7, 0.2, 0.2, -1.0)
SHARED = CUBE.add((4, "third", (2, 6, 10, 11)))
INSIDE = CUBE.add((4, "upper", (10, 14, 11, 13)), (2, "cut", (10, 11, 13)))
PRISM = CUBE.with_elements((6, "lower", (1, 2, 3, 5, 6, 7)))
PYRAMID = CUBE.with_elements((7, "lower", (1, 2, 3, 4, 5)))
SERENDIPITY = CUBE.with_elements((17, "lower", (*range(1, 17), 1, 2, 3, 4)))
MIXED = CUBE.add((11, "lower", tuple(range(1, 11))))
UNNAMED = CUBE.with_elements((5, "", (1, 2, 3, 4, 5, 6, 7, 8)))
OVERLAPPING = CUBE.add((5, "lower", (1, 2, 3, 4, 5, 6, 7, 8)))
OTHER_FACETS = CUBE.add((2, "half", (5, 6, 7)))


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        pytest.param(WITHOUT_VOLUMES, "Shells are not supported: mesh the volumes", id="shells"),
        pytest.param(INVERTED, r"'lower' has inverted elements .1 of 1.", id="inverted"),
        pytest.param(SHARED, r"share 4 of their nodes.*two physical volumes", id="shared"),
        pytest.param(INSIDE, r"'cut' on the outside of a body.*facet around", id="inside"),
        pytest.param(SERENDIPITY, "20-node hexahedra; expected 27-node ones", id="serendipity"),
        pytest.param(MIXED, "in 2 places, which cannot be divided alike", id="mixed"),
        pytest.param(UNNAMED, "one named physical volume per body, found none", id="no names"),
        pytest.param(OVERLAPPING, "'lower' has elements that overlap", id="overlapping"),
        pytest.param(OTHER_FACETS, "'half' has triangles on body 'lower' of hexahed", id="facets"),
    ],
)
def test_mistakes_have_a_message_of_their_own(tmp_path: Path, mesh: TinyMesh, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        read_mesh(mesh.write(tmp_path / "bad.msh"))


@pytest.mark.parametrize(
    ("mesh", "cells", "volume"), [(PRISM, 3, 1 / 2), (PYRAMID, 2, 1 / 3)], ids=["prism", "pyramid"]
)
def test_prisms_and_pyramids_are_divided(
    tmp_path: Path, mesh: TinyMesh, cells: int, volume: float
) -> None:
    found = read_mesh(mesh.write(tmp_path / "m.msh"))
    lower = found.bodies["lower"]
    assert (lower.cell, len(lower.cells)) == ("tetrahedron", cells)
    volumes = jacobian_determinants(lower.points, lower.cells, "tetrahedron", 1)[:, 0] / 6
    assert volumes.min() > 0 and volumes.sum() == pytest.approx(volume, rel=1e-12)
    assert f"and is divided into {PLURALS['tetrahedron']}" in found.notes[0]


COARSE = {"template": "wedge", "parameters": {"size": 0.25, "growth": 0.5}, "order": 1}
EXTRUDED = {"length": 4.0, "layers": 2}
IN_SPACE = {
    "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
    "loads": {"press": press(steps=1)},
}


def mesh_of(geometry: dict[str, Any], folder: Path = Path(), **tables: Any) -> Mesh:
    tables = pad(geometry=geometry, **(IN_SPACE | tables))
    return grouped_mesh(parse_case(tables, folder / "case.toml"))


def test_templates_and_files_become_solids(tmp_path: Path) -> None:
    flat = mesh_of(COARSE, supports=BASE)
    solid = mesh_of({**COARSE, "solid": EXTRUDED})
    assert (flat.dimension, solid.dimension) == (2, 3)
    assert {"upper_back", "upper_front", "upper_top"} <= solid.bodies["upper"].boundaries.keys()
    write_mesh(flat, tmp_path / "flat.msh")
    write_mesh(solid, tmp_path / "solid.msh")
    again = mesh_of({"file": "flat.msh", "solid": EXTRUDED}, tmp_path)
    for found in (again, mesh_of({"file": "solid.msh"}, tmp_path)):
        for name, body in solid.bodies.items():
            np.testing.assert_allclose(found.bodies[name].points, body.points, atol=1e-12)
            np.testing.assert_array_equal(found.bodies[name].cells, body.cells)
    with pytest.raises(CaseError, match=r"geometry.solid: expected none, as solid.msh has solid"):
        mesh_of({"file": "solid.msh", "solid": EXTRUDED}, tmp_path)


def test_a_solid_cannot_have_the_name_of_an_end_twice(tmp_path: Path) -> None:
    flat = mesh_of(COARSE, supports=BASE)
    body = flat.bodies["upper"]
    body.boundaries["upper_front"] = body.boundaries.pop("upper_top")
    write_mesh(flat, tmp_path / "flat.msh")
    with pytest.raises(CaseError, match="names of the ends, found upper_front"):
        mesh_of({"file": "flat.msh", "solid": EXTRUDED}, tmp_path)


def test_directions_have_as_many_components_as_the_mesh() -> None:
    pulled = {**press(steps=1), "direction": [0.0, 1.0, 0.0]}
    with pytest.raises(CaseError, match=r"2 components .* the mesh is plane, and .geometry.solid."):
        mesh_of(COARSE, supports=BASE, loads={"press": pulled})
    with pytest.raises(CaseError, match="expected 'x' or 'y' on this mesh, found 'z'; the mesh is"):
        mesh_of(COARSE)
    flat = {**press(steps=1), "direction": [0.0, 1.0]}
    with pytest.raises(CaseError, match="3 components on this mesh, found 2; the bodies are solid"):
        mesh_of({**COARSE, "solid": EXTRUDED}, loads={"press": flat})
