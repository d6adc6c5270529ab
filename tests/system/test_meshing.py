# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reading Gmsh files: bodies with their own nodes, facets, and the message for each bad mesh."""

from __future__ import annotations

import math
import re
from pathlib import Path

import gmsh
import numpy as np
import pytest
from cases.b1_meshes import RADIUS, ZONE, write_b1
from cases.tiny_meshes import CURVED_QUADRILATERAL, CURVED_TRIANGLE, TWO_SQUARES, TinyMesh

from fretfe.errors import MeshError
from fretfe.mesh.elements import (
    directed_facets,
    exterior_facets,
    facet_measures,
    jacobian_determinants,
)
from fretfe.mesh.gmsh import gmsh_model
from fretfe.mesh.make import read_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh

BOUNDARIES = {
    "pad": {"pad_contact", "pad_top"},
    "substrate": {
        "substrate_contact",
        "substrate_bottom",
        "substrate_left",
        "substrate_right",
    },
}


@pytest.fixture(scope="module", params=[1, 2], ids=["order1", "order2"])
def b1(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Mesh:
    path = tmp_path_factory.mktemp("b1") / "b1.msh"
    write_b1(path, order=request.param, h=0.1, growth=0.3)
    return read_mesh(path)


def area(body: BodyMesh) -> float:
    """From the Jacobian determinants: exact for triangles with straight edges."""
    return float(jacobian_determinants(body.points, body.cells, body.cell, body.order)[:, 0].sum())


def outward(body: BodyMesh, name: str) -> np.ndarray:
    """Normals (f, 2) of the chords on the right of the direction of travel."""
    facets = body.boundaries[name]
    x, y = (body.points[facets[:, 1]] - body.points[facets[:, 0]]).T
    return np.column_stack([y, -x]) / np.hypot(x, y)[:, None]


def test_b1_has_its_bodies_and_boundaries(b1: Mesh) -> None:
    assert {name: set(body.boundaries) for name, body in b1.bodies.items()} == BOUNDARIES


@pytest.mark.parametrize("name", ["pad", "substrate"])
def test_b1_bodies_have_their_own_contiguous_nodes(b1: Mesh, name: str) -> None:
    body = b1.bodies[name]
    np.testing.assert_array_equal(np.unique(body.cells), np.arange(len(body.points)))
    assert (body.name, body.cell, body.points.shape[1]) == (name, "triangle", 2)
    assert body.cells.shape[1] == {1: 3, 2: 6}[body.order]
    assert all(facets.shape[1] == body.order + 1 for facets in body.boundaries.values())


@pytest.mark.parametrize(
    ("body", "name", "normal"),
    [
        ("pad", "pad_top", (0, 1)),
        ("substrate", "substrate_contact", (0, 1)),
        ("substrate", "substrate_bottom", (0, -1)),
        ("substrate", "substrate_left", (-1, 0)),
    ],
)
def test_body_is_on_the_left_of_its_facets(
    b1: Mesh, body: str, name: str, normal: tuple[float, float]
) -> None:
    # straight boundaries on the axes: round-off of coordinates of size 20 divided by facets of 0.1
    np.testing.assert_allclose(outward(b1.bodies[body], name) - np.array(normal), 0.0, atol=1e-12)


def test_b1_arc_length(b1: Mesh) -> None:
    pad = b1.bodies["pad"]
    length = facet_measures(pad.points, pad.boundaries["pad_contact"]).sum()
    # a chord of h is shorter than its arc by (h/R)^2/24 = 1.7e-7; a parabola is far closer
    tolerance = {1: 2e-7, 2: 1e-12}[pad.order]
    assert length == pytest.approx(2 * RADIUS * math.asin(ZONE / RADIUS), rel=tolerance)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_both_formats_give_the_same_mesh(tmp_path: Path, version: float) -> None:
    plain = TWO_SQUARES.write(tmp_path / "plain.msh")
    converted = tmp_path / "converted.msh"
    with gmsh_model(plain) as session:
        session.merge(str(plain))
        session.option.setNumber("Mesh.MshFileVersion", version)
        session.write(str(converted))
    first, second = read_mesh(plain), read_mesh(converted)
    assert first.bodies.keys() == second.bodies.keys() == {"lower", "upper"}
    lower, same = first.bodies["lower"], second.bodies["lower"]
    # Gmsh may number the nodes anew when it converts
    np.testing.assert_array_equal(lower.points[lower.cells], same.points[same.cells])
    np.testing.assert_array_equal(
        lower.points[lower.boundaries["lower_face"]], same.points[same.boundaries["lower_face"]]
    )


def test_a_group_on_two_bodies_is_split(tmp_path: Path) -> None:
    mesh = TWO_SQUARES.add((1, "sides", (2, 3)), (1, "sides", (6, 7)))
    bodies = read_mesh(mesh.write(tmp_path / "m.msh")).bodies
    np.testing.assert_array_equal(bodies["lower"].boundaries["sides"], [[1, 2]])
    np.testing.assert_array_equal(bodies["upper"].boundaries["sides"], [[1, 2]])


def test_clockwise_cells_and_facets_are_turned(tmp_path: Path) -> None:
    mesh = TWO_SQUARES.with_elements(
        (2, "lower", (1, 3, 2)), (2, "lower", (1, 3, 4)), (1, "face", (4, 3))
    )
    lower = read_mesh(mesh.write(tmp_path / "m.msh")).bodies["lower"]
    assert area(lower) == pytest.approx(2.0, rel=1e-15)  # twice the area of the reference cell
    np.testing.assert_array_equal(lower.boundaries["face"], [[2, 3]])


def test_curved_quadrilateral(tmp_path: Path) -> None:
    block = read_mesh(CURVED_QUADRILATERAL.write(tmp_path / "m.msh")).bodies["block"]
    assert (block.cell, block.order) == ("quadrilateral", 2)
    np.testing.assert_array_equal(block.boundaries["face"], [[0, 1, 4]])
    # parabola of sagitta s = 0.1 over 2: the mean of sqrt(1 + (2 s t)^2) over -1 < t < 1, to t^6
    assert facet_measures(block.points, block.boundaries["face"])[0] == pytest.approx(
        2 * (1 + (0.2**2) / 6 - (0.2**4) / 40 + (0.2**6) / 112), rel=1e-6
    )


def test_turned_curved_cells_keep_their_edges(tmp_path: Path) -> None:
    clockwise = CURVED_TRIANGLE.with_elements((9, "block", (1, 3, 2, 6, 5, 4)))
    straight = read_mesh(CURVED_TRIANGLE.write(tmp_path / "a.msh")).bodies["block"]
    turned = read_mesh(clockwise.write(tmp_path / "b.msh")).bodies["block"]
    np.testing.assert_array_equal(turned.cells, straight.cells)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_determinant_of_an_affine_map(cell: str, order: int) -> None:
    tiny = CURVED_TRIANGLE if cell == "triangle" else CURVED_QUADRILATERAL.move(5, 1, 0)
    corners = {"triangle": 3, "quadrilateral": 4}[cell]
    count = corners if order == 1 else len(tiny.nodes)
    matrix = np.array([[2.0, 1.0], [0.5, 3.0]])
    points = np.array(tiny.nodes)[:count, :2] @ matrix.T
    determinants = jacobian_determinants(points, np.arange(count)[None], cell, order)
    # the tiny cells are the reference cells scaled by 2
    np.testing.assert_allclose(determinants, 4 * np.linalg.det(matrix), rtol=1e-13)


def test_exterior_edges_of_b1_are_closed(b1: Mesh) -> None:
    pad = b1.bodies["pad"]
    edges, folded = exterior_facets(directed_facets(pad.cells, pad.cell, pad.order), "line")
    np.testing.assert_array_equal(np.sort(edges[:, 0]), np.sort(edges[:, 1]))
    assert len(folded) == 0


TWO_KINDS = TWO_SQUARES.add((3, "lower", (1, 2, 3, 4)))
CURVED_LINE = TWO_SQUARES.add((8, "curved", (1, 2, 3)))
UNNAMED = TWO_SQUARES.with_elements(*((kind, "", nodes) for kind, _, nodes in TWO_SQUARES.elements))
ONE_UNNAMED = TWO_SQUARES.with_elements((2, "lower", (1, 2, 3)), (2, "", (5, 6, 7)))
TETRAHEDRON = TWO_SQUARES.move(8, 0, 1, 1).add((4, "volume", (5, 6, 7, 8)))
SERENDIPITY = CURVED_QUADRILATERAL.with_elements((16, "block", (1, 2, 3, 4, 5, 6, 7, 8)))
CUBIC = CURVED_QUADRILATERAL.add((21, "block", (1, 2, 3, 4, 5, 6, 7, 8, 9, 1)))
MERGED = TWO_SQUARES.with_elements((2, "lower", (1, 3, 4)), (2, "upper", (4, 3, 7)))
SAME_TWICE = TWO_SQUARES.with_elements((2, "lower", (1, 2, 3)), (2, "upper", (1, 2, 3)))
STRAY = TWO_SQUARES.add((1, "stray", (2, 4)))
BRIDGE = TWO_SQUARES.add((1, "bridge", (3, 6)))
INTERIOR = TWO_SQUARES.add((1, "inside", (1, 3)))
FOLDED = TWO_SQUARES.move(4, 0.9, -0.5)
BOW_TIE = TWO_SQUARES.with_elements((3, "block", (1, 2, 4, 3)))
CURVED_INSIDE_OUT = CURVED_TRIANGLE.move(4, 1, 1.5)


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        pytest.param(UNNAMED, "expected one named physical surface per body", id="no names"),
        pytest.param(ONE_UNNAMED, "every meshed surface in a named physical", id="one unnamed"),
        pytest.param(TETRAHEDRON, "'lower' on the outside of a body, but 2 of its 2", id="3D"),
        pytest.param(TWO_KINDS, "'lower' has elements that overlap", id="mixed"),
        pytest.param(CURVED_LINE, "one mesh order.*boundary 'curved': 2", id="orders"),
        pytest.param(SERENDIPITY, "8-node quadrilaterals; expected 9-node", id="serendipity"),
        pytest.param(CUBIC, r"Gmsh type 21", id="cubic"),
        pytest.param(TWO_SQUARES.move(7, 1, 1, 0.5), "z = 0.*node at \\(1, 1, 0.5\\)", id="z"),
        pytest.param(MERGED, "share 2 of their nodes.*interface was merged", id="merged interface"),
        pytest.param(
            SAME_TWICE, "share 3 of their nodes.*in two physical surfaces", id="same twice"
        ),
        pytest.param(STRAY, "'stray'.*1 of its 1 facets.*\\(1, -1\\) to \\(0, 0\\)", id="stray"),
        pytest.param(BRIDGE, "'bridge'.*not on the outside of any body", id="bridge"),
        pytest.param(INTERIOR, "'inside'.*not on the outside of any body", id="interior"),
        pytest.param(FOLDED, "'lower' has elements that overlap", id="folded"),
        pytest.param(BOW_TIE, "'block' has inverted elements .1 of 1.", id="bow tie"),
        pytest.param(CURVED_INSIDE_OUT, "'block' has inverted elements .1 of 1.", id="inside out"),
    ],
)
def test_bad_mesh(tmp_path: Path, mesh: TinyMesh, message: str) -> None:
    path = mesh.write(tmp_path / "bad.msh")
    with pytest.raises(MeshError, match=f"{re.escape(str(path))}.*{message}"):
        read_mesh(path)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"none\.msh: expected a mesh file, found nothing at"):
        read_mesh(tmp_path / "none.msh")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('SystemCall "touch executed";\n', r"starts with \$MeshFormat, found b'SystemCall"),
        ("", r"starts with \$MeshFormat, found b''"),
        ("$MeshFormat\n9.1 0 8\n$EndMeshFormat\n", "Gmsh reports: Unknown MSH file version"),
        ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n", "Gmsh reports: Could not read"),
    ],
    ids=["script", "empty", "version", "truncated"],
)
def test_unreadable_file(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "bad.msh"
    path.write_text(content)
    with pytest.raises(MeshError, match=message):
        read_mesh(path)


def test_a_session_of_the_caller_survives(tmp_path: Path) -> None:
    path = TWO_SQUARES.write(tmp_path / "m.msh")
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.model.add("mine")
        gmsh.model.geo.addPoint(1.0, 2.0, 0.0, tag=7)
        gmsh.model.geo.synchronize()
        gmsh.model.add("another of mine")
        gmsh.model.setCurrent("mine")
        read_mesh(path)
        assert gmsh.model.getCurrent() == "mine"
        assert gmsh.model.getEntities(0) == [(0, 7)]
    finally:
        gmsh.finalize()


def test_gmsh_is_left_as_found(tmp_path: Path) -> None:
    read_mesh(TWO_SQUARES.write(tmp_path / "m.msh"))
    assert not gmsh.isInitialized()
