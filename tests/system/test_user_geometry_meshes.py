# SPDX-License-Identifier: LGPL-3.0-or-later
"""One mesh through .msh, .xdmf and .inp: the same results to round-off; and what is refused."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mpi4py import MPI

import gmsh
import meshio
import numpy as np
import pytest
from cases.pad_cases import press, shear
from cases.user_geometry import cad_geometry, case_of, write_cad
from dolfinx.io import XDMFFile

from fretfe.case import parse_case
from fretfe.errors import CaseError, MeshError
from fretfe.fem.backend import BACKEND
from fretfe.mesh.make import write_mesh
from fretfe.mesh.mesh import Mesh
from fretfe.surface.checks import load_mesh

TAGS = {
    "bodies": {"upper": 1, "lower": 2},
    "boundaries": {
        "upper_contact": 3,
        "upper_top": 4,
        "lower_contact": 5,
        "lower_left": 6,
        "lower_right": 7,
        "lower_bottom": 8,
    },
}
NUMBERS: dict[str, Any] = {
    table: {name: {"tag": tag} for name, tag in tags.items()} for table, tags in TAGS.items()
}


def write_files(folder: Path, order: int) -> None:
    """The pad as pad.msh, as pad.inp of Gmsh, as pad.xdmf of meshio and as two of DOLFINx."""
    geometry = cad_geometry(write_cad(folder / "pad.step"), size=0.15, order=order)
    write_mesh(load_mesh(parse_case(case_of(geometry))), folder / "pad.msh")
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(folder / "pad.msh"))
        groups = {
            gmsh.model.getPhysicalName(dim, tag): (dim, tag)
            for dim, tag in gmsh.model.getPhysicalGroups()
        }
        for option in ("SaveGroupsOfNodes", "SaveGroupsOfElements"):
            gmsh.option.setNumber(f"Mesh.{option}", 1)
        gmsh.write(str(folder / "pad.inp"))
        numbers = {groups[n]: t for table in TAGS.values() for n, t in table.items()}
    finally:
        gmsh.finalize()
    mesh = meshio.read(folder / "pad.msh")
    dims = [2 if block.type.startswith("triangle") else 1 for block in mesh.cells]
    tags = [
        np.array([numbers[dim, int(tag)] for tag in found])
        for dim, found in zip(dims, mesh.cell_data["gmsh:physical"], strict=True)
    ]
    meshio.Mesh(mesh.points, mesh.cells, cell_data={"gmsh:physical": tags}).write(
        folder / "pad.xdmf"
    )
    for dim, name in ((2, "cells"), (1, "facets")):
        blocks = [(b.type, b.data) for b, d in zip(mesh.cells, dims, strict=True) if d == dim]
        kept = [np.concatenate([t for t, d in zip(tags, dims, strict=True) if d == dim])]
        cells = [(blocks[0][0], np.concatenate([data for _, data in blocks]))]
        part = meshio.Mesh(mesh.points[:, :2], cells, cell_data={"group": kept})
        # the HDF5 of DOLFINx may have no compression
        part.write(folder / f"{name}.xdmf", compression=None)
    through_dolfinx(folder)


def through_dolfinx(folder: Path) -> None:
    """Read cells.xdmf and facets.xdmf as DOLFINx users do, and write dolfinx.xdmf."""
    with XDMFFile(MPI.COMM_SELF, str(folder / "cells.xdmf"), "r") as file:
        mesh = file.read_mesh(name="Grid")
        cells = file.read_meshtags(mesh, name="Grid")
    mesh.topology.create_connectivity(1, 2)
    with XDMFFile(MPI.COMM_SELF, str(folder / "facets.xdmf"), "r") as file:
        facets = file.read_meshtags(mesh, name="Grid")
    cells.name, facets.name = "bodies", "boundaries"
    with XDMFFile(MPI.COMM_SELF, str(folder / "dolfinx.xdmf"), "w") as file:
        file.write_mesh(mesh)
        file.write_meshtags(cells, mesh.geometry)
        file.write_meshtags(facets, mesh.geometry)
    with XDMFFile(MPI.COMM_SELF, str(folder / "only_facets.xdmf"), "w") as file:
        file.write_meshtags(facets, mesh.geometry)


@pytest.fixture(scope="module", params=[1, 2], ids=["order1", "order2"])
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("meshes")
    write_files(path, request.param)
    return path


FILES: dict[str, dict[str, Any]] = {
    "inp": {"file": "pad.inp"},
    "meshio": {"file": "pad.xdmf", **NUMBERS},
    "meshio-two-files": {"file": "cells.xdmf", "facets": "facets.xdmf", **NUMBERS},
    "dolfinx": {"file": "dolfinx.xdmf", **NUMBERS},
    "dolfinx-two-files": {"file": "dolfinx.xdmf", "facets": "only_facets.xdmf", **NUMBERS},
}


def case_in(folder: Path, geometry: dict[str, Any], **tables: Any) -> Any:
    return parse_case(case_of(geometry, **tables), folder / "case.toml")


def outline(mesh: Mesh) -> dict[str, np.ndarray]:
    """Corners of the facets of each boundary, in an order that does not depend on numbers."""
    return {
        name: np.unique(np.round(body.points[facets[:, :2]].reshape(-1, 4), 9), axis=0)
        for body in mesh.bodies.values()
        for name, facets in body.boundaries.items()
    }


@pytest.mark.parametrize("geometry", FILES.values(), ids=FILES)
def test_all_formats_hold_the_same_mesh(folder: Path, geometry: dict[str, Any]) -> None:
    expected = load_mesh(case_in(folder, {"file": "pad.msh"}))
    found = load_mesh(case_in(folder, geometry))
    assert found.bodies.keys() == expected.bodies.keys()
    for name, body in found.bodies.items():
        same = expected.bodies[name]
        assert (body.cell, body.order, body.cells.shape) == (
            same.cell,
            same.order,
            same.cells.shape,
        )
        # the inp file of Gmsh has 14 digits
        np.testing.assert_allclose(
            np.sort(body.points[body.cells].mean(axis=1), axis=0),
            np.sort(same.points[same.cells].mean(axis=1), axis=0),
            atol=1e-12 * 24,
        )
    outlines = outline(expected)
    # of the sets in an inp file those that the case names are boundaries
    unused = {"lower_left", "lower_right"} if geometry["file"] == "pad.inp" else set()
    assert outline(found).keys() == outlines.keys() - unused
    for name, facets in outline(found).items():
        # rounded to 9 digits, one way or the other
        np.testing.assert_allclose(facets, outlines[name], rtol=0, atol=2e-9)


def results(folder: Path, geometry: dict[str, Any]) -> np.ndarray:
    loads = {"press": press(600.0), "shear": shear(60.0, cycles=1, steps=4)}
    contact = BACKEND.solve(case_in(folder, geometry, loads=loads)).contacts[0]
    return np.array(
        [(e.position[-1], e.k_n[-1], e.k_t_range) for e in contact.stations], dtype=float
    )


def test_all_formats_give_the_same_results(folder: Path) -> None:
    expected = results(folder, {"file": "pad.msh"})
    for geometry in FILES.values():
        # round-off: 1e-16 times the condition of the stiffness, 1e5 or so, and of the fits
        np.testing.assert_allclose(results(folder, geometry), expected, rtol=1e-7)


# --- XDMF ---------------------------------------------------------------------------------------

QUAD8 = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [1, -0.1], [2, 1], [1, 2], [0, 1]], float)


def write_quads(path: Path, points: np.ndarray, **options: Any) -> Path:
    """Two quadrilaterals with a line on two sides of each, second one mirrored and below."""
    count = len(points)
    cells = [(f"quad{count}" if count > 4 else "quad", np.arange(2 * count).reshape(2, count))]
    order = 3 if count > 4 else 2
    sides = np.array([[0, 1, 4], [2, 3, 6]])
    lines = np.vstack([sides, sides + count])[:, :order]
    cells.append(("line3" if order == 3 else "line", lines))
    both = np.vstack([points, points * [1, -1] + [0, -0.5]])
    tags = [np.array([1, 2]), np.array([3, 4, 5, 6])]
    meshio.Mesh(both, cells, cell_data={"tag": tags}).write(path, **options)
    return path


QUADS: dict[str, Any] = {
    "bodies": NUMBERS["bodies"],
    "boundaries": {
        name: {"tag": {"upper_contact": 3, "upper_top": 4, "lower_contact": 5}.get(name, 6)}
        for name in TAGS["boundaries"]
    },
}


@pytest.mark.parametrize("form", ["HDF", "XML"])
@pytest.mark.parametrize("count", [4, 8, 9])
def test_quadrilaterals(tmp_path: Path, count: int, form: str) -> None:
    points = np.vstack([QUAD8, [[1, 0.95]]])[:count]
    path = write_quads(tmp_path / "q.xdmf", points, data_format=form)
    mesh = load_mesh(case_in(tmp_path, {"file": str(path), **QUADS}))
    body = mesh.bodies["upper"]
    assert (body.cell, body.order) == ("quadrilateral", 1 if count == 4 else 2)
    # the middle of the lower side is 0.1 down: half of that in the middle, (Σ mid-sides)/2 - Σ/4;
    # meshio writes XML with 17 digits
    centre = [[1, 0.95]] if count > 4 else np.empty((0, 2))
    np.testing.assert_allclose(body.points[8:], centre, rtol=0, atol=1e-15)
    assert body.boundaries["upper_contact"].shape == (1, 2 if count == 4 else 3)


def xdmf_refusal(path: Path, facets: Path | None = None, **tables: Any) -> str:
    geometry = {"file": str(path), **NUMBERS, **tables}
    if facets is not None:
        geometry["facets"] = str(facets)
    with pytest.raises(MeshError) as caught:
        load_mesh(case_in(path.parent, geometry))
    return str(caught.value)


def test_numbers_that_are_not_in_the_file(folder: Path) -> None:
    bodies = {**NUMBERS["bodies"], "lower": {"tag": 9}}
    message = xdmf_refusal(folder / "pad.xdmf", bodies=bodies)
    assert "geometry.bodies.lower: no cells have the number 9; numbers of cells in" in message
    assert message.endswith("the file: 1, 2")
    boundaries = {**NUMBERS["boundaries"], "upper_top": {"tags": [4, 1]}}
    message = xdmf_refusal(folder / "pad.xdmf", boundaries=boundaries)
    assert message.endswith(
        "upper_top: no facets have the number 1; numbers of facets in the file: 3, 4, 5, 6, 7, 8"
    )


def test_several_numbers_are_one_boundary(folder: Path) -> None:
    boundaries = {**NUMBERS["boundaries"], "lower_left": {"tags": [6, 7]}}
    geometry = {**FILES["meshio"], "boundaries": boundaries}
    found, one = (
        load_mesh(case_in(folder, g)).bodies["lower"] for g in (geometry, FILES["dolfinx"])
    )
    both = len(one.boundaries["lower_left"]) + len(one.boundaries["lower_right"])
    assert len(found.boundaries["lower_left"]) == both


def test_cells_in_no_body(tmp_path: Path) -> None:
    path = write_quads(tmp_path / "q.xdmf", QUAD8[:4])
    bodies = {"upper": {"tag": 1}, "lower": {"tag": 1}}
    message = xdmf_refusal(path, bodies=bodies, boundaries=QUADS["boundaries"])
    assert "but in none are those of number 2" in message


PARTLY_NUMBERED = """<?xml version="1.0"?>
<Xdmf Version="3.0"><Domain><Grid Name="mesh" GridType="Uniform">
<Topology TopologyType="Quadrilateral" NumberOfElements="2">
<DataItem Dimensions="2 4" Format="XML">0 1 2 3  4 5 6 7</DataItem></Topology>
<Geometry GeometryType="XY"><DataItem Dimensions="8 2" Format="XML">
0 0  1 0  1 1  0 1   0 -1  1 -1  1 -.5  0 -.5</DataItem></Geometry></Grid>
<Grid Name="tags" GridType="Uniform"><Topology TopologyType="Quadrilateral" NumberOfElements="1">
<DataItem Dimensions="1 4" Format="XML">0 1 2 3</DataItem></Topology>
<Attribute Name="tags" Center="Cell"><DataItem Format="XML">1</DataItem></Attribute></Grid>
<Grid Name="facets" GridType="Uniform"><Topology TopologyType="Polyline" NumberOfElements="2">
<DataItem Dimensions="2 2" Format="XML">0 1  6 7</DataItem></Topology>
<Attribute Name="facets" Center="Cell"><DataItem Format="XML">3 5</DataItem></Attribute></Grid>
</Domain></Xdmf>
"""


def test_cells_without_a_number(tmp_path: Path) -> None:
    (tmp_path / "m.xdmf").write_text(PARTLY_NUMBERED)
    bodies = {"upper": {"tag": 1}, "lower": {"tag": 1}}
    message = xdmf_refusal(tmp_path / "m.xdmf", bodies=bodies, boundaries=QUADS["boundaries"])
    assert message.endswith("m.xdmf: 1 of the 2 cells have no number")


def test_different_points_for_the_facets(folder: Path, tmp_path: Path) -> None:
    other = write_quads(tmp_path / "q.xdmf", QUAD8[:4])
    message = xdmf_refusal(folder / "cells.xdmf", other)
    assert "expected cells and facets on the same points" in message


def test_a_mesh_without_numbers(folder: Path, tmp_path: Path) -> None:
    mesh = meshio.read(folder / "cells.xdmf")
    meshio.Mesh(mesh.points, mesh.cells).write(tmp_path / "m.xdmf")
    assert "no cells have the number 1; numbers of cells in the file: none" in xdmf_refusal(
        tmp_path / "m.xdmf"
    )


def test_two_kinds_of_numbers(tmp_path: Path) -> None:
    write_quads(tmp_path / "q.xdmf", QUAD8[:4])
    mesh = meshio.read(tmp_path / "q.xdmf")
    mesh.cell_data["other"] = mesh.cell_data["tag"]
    mesh.write(tmp_path / "q.xdmf")
    message = xdmf_refusal(tmp_path / "q.xdmf")
    assert "or one called 'gmsh:physical', found for the mixeds: tag, other" in message


def test_prisms(tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0], [1, 0, 1], [0, 1, 1]])
    meshio.Mesh(points, [("wedge", np.arange(6)[None])]).write(tmp_path / "m.xdmf")
    message = xdmf_refusal(tmp_path / "m.xdmf")
    assert "or tetrahedra or hexahedra and their facets" in message
    assert "'wedge'" in message


def replaced(old: str, new: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        assert old in text
        return text.replace(old, new)

    return change


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda text: "", "expected an XDMF file (XML), found no XML"),
        (lambda text: text[:300], "expected an XDMF file (XML), found no XML"),
        (lambda text: "<VTKFile/>", "found XML of type <VTKFile>"),
        (lambda text: "<Xdmf/>", "expected a grid with a topology, found none"),
        (replaced(".h5:", ".h6:"), "found nothing at"),
        (replaced("h5:/data1", "h5:/data77"), "cannot read '/data77'"),
        (replaced('Format="HDF"', 'Format="Binary"'), "format HDF or XML, found 'Binary'"),
        (replaced('Format="HDF"', 'Format="XML"'), "cannot be read"),
        (replaced("h5:/data1<", "h5:/data0<"), "q.xdmf"),
        (replaced("h5:/data0<", "h5:/data1<"), "expected points with 2 or 3 coordinates"),
        (replaced('"Mixed"', '"Triangle"'), "3 nodes for each triangle"),
        (replaced('"Mixed"', '"Spline"'), "found cells of type 'spline'"),
    ],
    ids=[
        "empty", "cut", "vtk", "no-grid", "no-h5", "no-data", "binary", "no-numbers",
        "no-cells", "no-points", "triangle", "unknown",
    ],
)  # fmt: skip
def test_xdmf_files_that_are_wrong(
    tmp_path: Path, change: Callable[[str], str], expected: str
) -> None:
    path = write_quads(tmp_path / "q.xdmf", QUAD8[:4])
    path.write_text(change(path.read_text()))
    assert expected in xdmf_refusal(path)


def test_an_h5_file_that_is_cut_off(tmp_path: Path) -> None:
    path = write_quads(tmp_path / "q.xdmf", QUAD8[:4])
    content = path.with_suffix(".h5").read_bytes()
    path.with_suffix(".h5").write_bytes(content[: len(content) // 2])
    assert "where the file has its numbers" in xdmf_refusal(path)


def test_a_missing_xdmf_file(tmp_path: Path) -> None:
    path = tmp_path / "none.xdmf"
    message = xdmf_refusal(path)
    assert message.endswith(f"geometry.file: expected a file, found nothing at {path}")


# --- inp ----------------------------------------------------------------------------------------

# Two squares of two elements each, with sets in all the ways that input files have.
DECK = """*HEADING
Pad, ELSET=none of this counts
** a comment
*NODE, NSET=ALL
1, 0., 0.
2, 1., 0.,
3, 2., 0., 0.
4, 0., 1.
5, 1., 1.
6, 2.0D+00, 1.
*NODE
11, 0., -0.5
12, 1., -0.5
13, 2., -0.5
14, 0., -1.5
15, 1., -1.5
16, 2., -1.5
*ELEMENT, TYPE=CPE4, ELSET=EUPPER
1, 1, 2, 5, 4
*ELEMENT, TYPE=CPE4R, ELSET=Eupper
2, 2, 3,
6, 5
*ELEMENT, TYPE=CPS4I
3, 11, 14, 15, 12
4, 12, 15, 16, 13
*ELSET, ELSET=LOWER, GENERATE
3, 4, 1
*NSET, NSET=UPPER_CONTACT
1, 2, 3
*NSET, NSET=BOTTOM_LEFT
14, 15
*NSET, NSET=LOWER_BOTTOM
BOTTOM_LEFT, 16
*NSET, NSET=lower_left, GENERATE
11, 14, 3
*SURFACE, NAME=UPPER_TOP
EUPPER, S3
*SURFACE, NAME=LOWER_CONTACT, TYPE=ELEMENT
3, S4
4, S4
*SURFACE, NAME=LOWER_RIGHT, TYPE=NODE
13
16
*STEP
*NODE PRINT, NSET=ALL
U
*END STEP
"""
MAPPED = {"bodies": {"upper": {"label": "Eupper"}}}


def write_deck(folder: Path, text: str) -> Path:
    path = folder / "pad.inp"
    path.write_text(text)
    return path


def deck_refusal(folder: Path, text: str, **tables: Any) -> str:
    with pytest.raises(MeshError) as caught:
        load_mesh(case_in(folder, {"file": str(write_deck(folder, text)), **MAPPED, **tables}))
    return str(caught.value)


def test_all_kinds_of_sets(tmp_path: Path) -> None:
    write_deck(tmp_path, DECK)
    pulled = {"pull": {**press(), "boundary": "lower_right"}, "press": press()}
    supports = {"left": {"boundary": "lower_left", "fix": ["x"]}} | {
        "base": {"boundary": "lower_bottom", "fix": ["y"]}
    }
    case = case_in(tmp_path, {"file": "pad.inp", **MAPPED}, loads=pulled, supports=supports)
    found = outline(load_mesh(case))
    # facets run with the body on their left
    expected = {
        "upper_contact": [[0, 0, 1, 0], [1, 0, 2, 0]],
        "upper_top": [[1, 1, 0, 1], [2, 1, 1, 1]],
        "lower_contact": [[1, -0.5, 0, -0.5], [2, -0.5, 1, -0.5]],
        "lower_bottom": [[0, -1.5, 1, -1.5], [1, -1.5, 2, -1.5]],
        "lower_left": [[0, -0.5, 0, -1.5]],
        "lower_right": [[2, -1.5, 2, -0.5]],
    }
    assert found.keys() == expected.keys()
    for name, facets in expected.items():
        np.testing.assert_array_equal(found[name], facets)


def test_a_surface_without_sides_is_all_that_is_free(tmp_path: Path) -> None:
    text = DECK.replace("EUPPER, S3\n", "1\n")
    write_deck(tmp_path, text)
    # It goes round the body, contact and all: a pressure may act there, a platen may not.
    pressure = {"type": "traction", "boundary": "upper_top", "direction": "y"}
    loads = {"press": {**pressure, "history": [{"ramp": -1.0, "until": 1.0, "steps": 1}]}}
    case = case_in(tmp_path, {"file": "pad.inp", **MAPPED}, loads=loads)
    found = outline(load_mesh(case))["upper_top"]
    np.testing.assert_array_equal(found, [[0, 0, 1, 0], [0, 1, 0, 0], [1, 1, 0, 1]])


def test_included_files(tmp_path: Path) -> None:
    (tmp_path / "nodes").mkdir()
    head, end = DECK.split("*ELEMENT", 1)
    (tmp_path / "nodes" / "all.inc").write_text(head)
    write_deck(tmp_path, f"*INCLUDE, INPUT=nodes/all.inc\n*ELEMENT{end}")
    assert set(load_mesh(case_in(tmp_path, {"file": "pad.inp", **MAPPED})).bodies) == set(
        TAGS["bodies"]
    )
    message = deck_refusal(tmp_path, "*INCLUDE, INPUT=pad.inp\n")
    assert "pad.inp includes itself" in message


def eight_nodes(kind: str) -> str:
    """Two 8-node elements, their facets given by node sets."""
    lines = ["*NODE"]
    points = np.vstack([QUAD8, QUAD8 * [1, -1] + [0, -0.5]])
    lines += [f"{n}, {x}, {y}" for n, (x, y) in enumerate(points, 1)]
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=UPPER\n1, 1, 2, 3, 4, 5, 6, 7, 8")
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=LOWER\n2, 9, 10, 11, 12, 13, 14, 15, 16")
    sets = {"UPPER_CONTACT": "1, 5, 2", "UPPER_TOP": "3, 4, 7"}
    sets |= {"LOWER_CONTACT": "9, 10, 13", "LOWER_BOTTOM": "11, 12, 15"}
    return "\n".join([*lines, *(f"*NSET, NSET={name}\n{n}" for name, n in sets.items()), ""])


@pytest.mark.parametrize("kind", ["CPE8", "CPE8R", "CPS8", "cps8r", "S8R"])
def test_eight_node_elements_get_a_centre(tmp_path: Path, kind: str) -> None:
    write_deck(tmp_path, eight_nodes(kind))
    body = load_mesh(case_in(tmp_path, {"file": "pad.inp"})).bodies["upper"]
    assert body.cells.shape == (1, 9)
    # the lower side is bent by 0.1 in its middle, the centre by half of that
    np.testing.assert_allclose(body.points[8], [1, 0.95], rtol=0, atol=1e-15)
    np.testing.assert_array_equal(body.boundaries["upper_contact"], [[0, 1, 4]])


def test_corner_nodes_alone_are_no_facet_of_order_2(tmp_path: Path) -> None:
    text = eight_nodes("CPE8").replace("1, 5, 2\n", "1, 2\n")
    message = deck_refusal(tmp_path, text, bodies={})
    assert "but 2 of its 2 nodes are on none, the first is 1 at (0, 0)" in message


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (replaced("*ELEMENT, TYPE=CPS4I", "*ELEMENT, TYPE=CAX4"), "axisymmetric elements (CAX4)"),
        (replaced("*ELEMENT, TYPE=CPS4I", "*ELEMENT, TYPE=C3D6"), "expected 6 nodes, found 4"),
        (replaced("*ELEMENT, TYPE=CPS4I", "*ELEMENT, TYPE=CPE6"), "expected 6 nodes, found 4"),
        (replaced("*ELEMENT, TYPE=CPS4I", "*ELEMENT, TYPE=XYZ4"), "element 3 is of type XYZ4"),
        (replaced("*NODE\n", "*PART, NAME=P\n*NODE\n"), "line 11: expected *END PART after"),
        (replaced("*NODE\n", "*NGEN\n1, 3\n*NODE\n"), "*NGEN is not supported; write out all"),
        (replaced("*NODE\n", "*NODE, SYSTEM=C\n"), "x, y and z, found SYSTEM=CYLINDRICAL"),
        (replaced("GENERATE\n3, 4, 1", "GENERATE\n3, 3, 1"), "but 1 of 4 are in none, 4 for one"),
        (replaced("ELSET=LOWER,", "ELSET=ELOWER,"), "no element set LOWER for the body 'lower'"),
        (replaced("UPPER_CONTACT\n1, 2, 3", "UPPER_CONTACT\n1, 2, 3, 5"), "the first is 5 at (1"),
        (replaced("NSET=UPPER_CONTACT", "NSET=CONTACT"), "node sets: ALL, CONTACT, BOTTOM_LEFT"),
        (replaced("EUPPER, S3", "EUPPER, SPOS"), "expected a side S1, S2, ... or S6, found 'SPOS'"),
        (replaced("EUPPER, S3", "NONE, S3"), "there is no set 'NONE'"),
        (replaced("3, S4\n", "3, S4\n9, S4\n"), "*SURFACE: there is no element 9"),
        (replaced("BOTTOM_LEFT, 16", "LEFT, 16"), "cannot read *NSET: there is no set 'LEFT'"),
        (replaced("*NODE\n11", "*NODE\n1, 1., 0.\n11"), "node 1 is defined twice"),
        (replaced("\n4, 12, 15", "\n3, 12, 15"), "element 3 is defined twice"),
        (replaced("6, 5\n", "6,\n"), "element 2 of type CPE4R: expected 4 nodes, found 3"),
        (replaced("\n4, 12, 15, 16", "\n4, 12, 15, 99"), "has node 99, which is not defined"),
        (replaced("1, 0., 0.\n", "1, zero, 0.\n"), "line 5: cannot read *NODE"),
        (replaced("11, 14, 3", "11, 14, 0"), "cannot read *NSET"),
        (lambda text: "", "with nodes and elements, found 0 nodes and 0 elements"),
        (lambda text: "hello world\n" * 9, "line 1: expected a keyword"),
        (lambda text: text[: len(text) // 2], "pad.inp"),
        (
            lambda text: text[: text.index("16, 13")],
            "element 4 of type CPS4I: expected 4 nodes, found 2",
        ),
        (lambda text: "*INCLUDE, INPUT=none.inc", "none.inc: expected a mesh file, found nothing"),
    ],
)
def test_decks_that_are_wrong(tmp_path: Path, change: Callable[[str], str], expected: str) -> None:
    message = deck_refusal(tmp_path, change(DECK))
    assert expected in message, message


def test_shared_nodes_are_refused(tmp_path: Path) -> None:
    text = DECK.replace("3, 11, 14, 15, 12", "3, 1, 14, 15, 2").replace("4, 12, 15", "4, 2, 15")
    assert "share 2 of their nodes" in deck_refusal(tmp_path, text)


def test_fuzzed_decks(tmp_path: Path) -> None:
    """Whatever happens to a file, the message is one of ours."""
    random = np.random.default_rng(5)
    content = DECK.encode()
    for _ in range(150):
        data = bytearray(content)
        for place in random.integers(len(data), size=3):
            data[place] = random.choice(list(b"0123456789,*=.-\n AZS\xff"))
        (tmp_path / "pad.inp").write_bytes(data)
        try:
            load_mesh(case_in(tmp_path, {"file": "pad.inp", **MAPPED}))
        except MeshError as error:
            assert "pad" in str(error) or "the mesh does not fit" in str(error)


def test_element_sizes_need_a_geometry(folder: Path) -> None:
    for geometry in ({"file": "pad.msh"}, *FILES.values()):
        with pytest.raises(CaseError, match=re.escape("edges.tolerance: expected a geometry that")):
            load_mesh(case_in(folder, geometry), lambda _: None)
