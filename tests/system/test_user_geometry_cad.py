# SPDX-License-Identifier: LGPL-3.0-or-later
"""STEP and BREP files: faces and curves by point, label and colour, to edge factors."""

from __future__ import annotations

import math
import re
from functools import partial
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
from cases.pad_cases import press, shear
from cases.user_geometry import (
    BODIES,
    BOUNDARIES,
    HEIGHT,
    RADIUS,
    WIDTH,
    ZONE,
    cad_geometry,
    case_of,
    style,
    write_cad,
)

from fretfe.backends.passes import starting_mesh
from fretfe.case import Selector, parse_case
from fretfe.errors import CaseError, FretfeError, MeshError
from fretfe.fem.backend import BACKEND
from fretfe.mesh.cad import Shapes, cad_model
from fretfe.mesh.elements import facet_measures
from fretfe.mesh.gmsh import gmsh_model
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.sizing import apply_fine_sizes
from fretfe.surface.checks import load_mesh

FORCE = 600.0
# In mm and N, as in pad_cases.
YOUNG, POISSON = 210e3, 0.3
RED, BROWN = "#ff0000", "#804019"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with pad.step, pad.brep, and styled.step with labels and colours."""
    path = tmp_path_factory.mktemp("cad")
    write_cad(path / "pad.brep")
    write_cad(path / "pad.step")
    colours = {1: RED, 4: BROWN, 10: "#00ff00", 7: "#0000ff"}
    style(write_cad(path / "styled.step"), ("Pad", "Block"), colours)
    return path


def mesh_of(geometry: dict[str, Any], **tables: Any) -> Mesh:
    return load_mesh(parse_case(case_of(geometry, **tables)))


def coarse(folder: Path, name: str = "pad.step", **tables: Any) -> dict[str, Any]:
    return cad_geometry(folder / name, size=0.4, **tables)


def boundaries(**changes: Any) -> dict[str, Any]:
    return {"boundaries": {**BOUNDARIES, **changes}}


def bodies(**changes: Any) -> dict[str, Any]:
    return {"bodies": {**BODIES, **changes}}


def refusal(geometry: dict[str, Any], error: type[FretfeError] = MeshError, **tables: Any) -> str:
    with pytest.raises(error) as caught:
        mesh_of(geometry, **tables)
    return str(caught.value)


def assert_same(first: Mesh, second: Mesh) -> None:
    assert first.bodies.keys() == second.bodies.keys()
    for name, body in first.bodies.items():
        np.testing.assert_array_equal(body.points, second.bodies[name].points)
        np.testing.assert_array_equal(body.cells, second.bodies[name].cells)
        assert body.boundaries.keys() == second.bodies[name].boundaries.keys()
        for boundary, facets in body.boundaries.items():
            np.testing.assert_array_equal(facets, second.bodies[name].boundaries[boundary])


def test_a_step_file_gives_the_edge_factors_of_hertz(folder: Path) -> None:
    loads = {"press": press(FORCE), "shear": shear(60.0, cycles=1, steps=4)}
    # 0.0125 is a/46
    case = parse_case(case_of(cad_geometry(folder / "pad.step", size=0.0125), loads=loads))
    contact = BACKEND.solve(case).contacts[0]
    modulus = YOUNG / (2 * (1 - POISSON**2))
    half_width = math.sqrt(4 * FORCE * RADIUS / (math.pi * modulus))
    # p = p0 sqrt(1 - (x/a)^2) ~ p0 sqrt(2/a) sqrt(a - x), with p0 = 2 P/(pi a) (Johnson 1985, 4.2)
    k_n = 2 * FORCE / (math.pi * half_width) * math.sqrt(2 / half_width)
    for edge in contact.stations:
        # half-width to (a/W)^2/4 = 0.06 % for the finite bodies (W = 12) and as much for the mesh;
        # K_N goes with a^(-3/2) at a given force
        assert abs(edge.position[-1]) == pytest.approx(half_width, rel=1e-3)
        assert edge.k_n[-1] == pytest.approx(k_n, rel=2e-3)


def test_lengths_and_places_are_those_of_the_drawing(folder: Path) -> None:
    found = mesh_of(coarse(folder)).bodies
    assert set(found["upper"].boundaries) == {"upper_contact", "upper_top"}
    upper, lower = found["upper"], found["lower"]
    # curves of order 2 are short of an arc by (h/R)^4/2880: round-off
    arc = facet_measures(upper.points, upper.boundaries["upper_contact"]).sum()
    assert arc == pytest.approx(2 * RADIUS * math.asin(ZONE / RADIUS), rel=1e-9)
    top = upper.points[upper.boundaries["upper_top"]]
    # a straight line: round-off of the size of the bodies
    np.testing.assert_allclose(top[..., 1], HEIGHT, rtol=0, atol=1e-12)
    assert facet_measures(lower.points, lower.boundaries["lower_bottom"]).sum() == pytest.approx(
        2 * WIDTH, rel=1e-12
    )


def test_brep_is_the_same_geometry(folder: Path) -> None:
    step, brep = (mesh_of(coarse(folder, name)).bodies for name in ("pad.step", "pad.brep"))
    for name, body in step.items():
        for boundary, facets in body.boundaries.items():
            points, same = body.points[facets], brep[name].points[brep[name].boundaries[boundary]]
            # STEP files have 13 digits
            np.testing.assert_allclose(points, same, rtol=0, atol=1e-10)


def test_labels_and_colours_choose_the_same(folder: Path) -> None:
    names = {
        "bodies": {"upper": {"label": "Pad"}, "lower": {"label": "Block"}},
        "boundaries": {
            **BOUNDARIES,
            "upper_contact": {"color": RED},
            # as 0.502, 0.251, 0.098 in the file, which Gmsh cuts off to 128, 64, 24 or 25
            "upper_top": {"color": BROWN.upper()},
            "lower_contact": {"color": "#00ff00", "body": "lower"},
            "lower_bottom": {"color": "#0000ff"},
        },
    }
    assert_same(mesh_of(coarse(folder)), mesh_of(coarse(folder, "styled.step", **names)))


def test_the_path_of_a_part_is_a_label_too(folder: Path) -> None:
    message = refusal(coarse(folder, "styled.step", **bodies(upper={"label": "Pda"})))
    labels = re.findall(r"faces in the file: (.*)", message)[0].split(", ")
    path = next(label for label in labels if label.endswith("/Pad"))
    same = mesh_of(coarse(folder, "styled.step", **bodies(upper={"label": path})))
    assert_same(mesh_of(coarse(folder)), same)


@pytest.mark.parametrize(("body", "name"), [("upper", "upper_contact"), ("lower", "lower_contact")])
def test_sizes_are_those_asked_for(folder: Path, body: str, name: str) -> None:
    found = mesh_of(cad_geometry(folder / "pad.step", size=0.1)).bodies[body]
    lengths = facet_measures(found.points, found.boundaries[name])
    # a curve has a whole number of elements, 3/0.1; on the way from the middle, where the other
    # surface is near too, to the ends they may grow by the growth of 0.2 a length
    assert lengths.mean() == pytest.approx(0.1, rel=0.04)
    np.testing.assert_allclose(lengths, lengths.mean(), rtol=0.05)


@pytest.mark.parametrize(("label", "factor"), [("mm", 1.0), ("m", 1e-3), ("µm", 1e3)])
def test_lengths_of_step_files_are_converted(folder: Path, label: str, factor: float) -> None:
    scaled = {
        table: {
            name: {
                key: np.multiply(value, factor).tolist() if key.startswith("point") else value
                for key, value in selector.items()
            }
            for name, selector in selectors.items()
        }
        for table, selectors in (("bodies", BODIES), ("boundaries", BOUNDARIES))
    }
    geometry = cad_geometry(folder / "pad.step", size=0.4 * factor, **scaled)
    found = mesh_of(geometry, units={"length": label}).bodies["lower"]
    # STEP has 13 digits
    np.testing.assert_allclose(np.ptp(found.points, axis=0), 24 * factor * np.array([1, 0.5]), 1e-9)


def test_lengths_of_brep_files_are_not(folder: Path) -> None:
    found = mesh_of(coarse(folder, "pad.brep"), units={"length": "furlong"}).bodies["lower"]
    np.testing.assert_allclose(np.ptp(found.points, axis=0), [24, 12], 1e-9)
    message = refusal(coarse(folder), CaseError, units={"length": "furlong"})
    assert "units.length: expected one of um, " in message


@pytest.mark.parametrize(
    ("tables", "expected"),
    [
        (
            boundaries(upper_contact={"point": [0, 0]}),
            r"upper_contact: the point \(0, 0\) does not tell between curve \d+ around \(0, 0\) and"
            r" curve \d+ around \(0, 0\); .* or say which with body = NAME",
        ),
        (
            boundaries(lower_left={"point": [-13, -6]}),
            r"lower_left: the point \(-13, -6\) is 1 away from the nearest curve \(curve \d+ around"
            r" \(-12, -6\)\); expected at most 0.339, 1% of the size",
        ),
        (
            boundaries(lower_left={"point": [-WIDTH, -WIDTH]}),
            r"does not tell between curve \d+ around \(-12, -6\) and curve \d+ around \(0, -12\)",
        ),
        (
            boundaries(more={"point": [WIDTH, -3]}),
            r"geometry.boundaries.more and geometry.boundaries.lower_right are both curve \d+",
        ),
        (
            boundaries(lower_left={"color": "#ff0001"}),
            r"lower_left: no curve has the colour #ff0001; colours of curves in the file: none",
        ),
        (
            boundaries(lower_left={"label": "left"}),
            r"lower_left: no curve has the label 'left'; labels of curves in the file: none",
        ),
        (
            boundaries(lower_left={"point": [-WIDTH, -6], "body": "block"}),
            r"lower_left.body: expected one of upper, lower, found 'block'",
        ),
        (
            bodies(lower={"point": [0, 5]}),
            r"geometry.bodies.lower and geometry.bodies.upper are both face 1 around \(0, 6\)",
        ),
        (
            bodies(lower={"point": [0, -15]}),
            r"lower: the point \(0, -15\) is 3 away from the nearest face \(face 2",
        ),
        (
            bodies(lower={"label": "Block"}),
            r"lower: no face has the label 'Block'; labels of faces in the file: Shapes/",
        ),
    ],
    ids=[
        "touching", "far", "corner", "twice", "colour", "label", "body", "same-face", "outside",
        "no-part",
    ],
)  # fmt: skip
def test_selectors_that_do_not_fit(folder: Path, tables: dict[str, Any], expected: str) -> None:
    assert re.search(expected, refusal(coarse(folder, **tables)))


def test_a_colour_that_nothing_has_lists_the_colours(folder: Path) -> None:
    tables = boundaries(lower_left={"color": "#123456"})
    message = refusal(coarse(folder, "styled.step", **tables))
    assert "colours of curves in the file: #0000ff, #00ff00, #" in message


def test_every_name_needs_a_selector(folder: Path) -> None:
    names = {name: each for name, each in BOUNDARIES.items() if name != "upper_top"}
    message = refusal(coarse(folder, boundaries=names), CaseError)
    assert "geometry.boundaries: expected 'upper_top', which is loads.press.boundary" in message
    message = refusal(coarse(folder, bodies={"upper": BODIES["upper"]}), CaseError)
    assert "geometry.bodies: expected 'lower', which is bodies.lower" in message


def test_plane_files_that_are_extruded_need_no_size(folder: Path) -> None:
    geometry = {key: value for key, value in coarse(folder).items() if key != "size"}
    geometry["solid"] = {"length": 2.0, "layers": 2}
    case = parse_case(case_of(geometry))
    assert case.edges.tolerance == 0.1
    mesh = starting_mesh(case)
    assert mesh.dimension == 3
    assert {*mesh.bodies["upper"].boundaries} >= {"upper_back", "upper_front"}


def test_sizes_come_from_the_case_or_from_refinement(folder: Path) -> None:
    without = {key: value for key, value in coarse(folder).items() if key != "size"}
    assert "geometry.size: expected an element size" in refusal(without, CaseError)
    case = parse_case(case_of(coarse(folder), edges={"tolerance": 0.01}))
    with pytest.raises(
        CaseError, match=r"geometry.size: expected none together .* plane, found 0.4"
    ):
        load_mesh(case, partial(apply_fine_sizes, (), 0.3, (), 40))


def drawn(path: Path, *, split: bool = True) -> Path:
    """Two squares side by side with an edge in common, or not, as a CAD file."""
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("squares")
        occ = gmsh.model.occ
        left, right = occ.addRectangle(-1, 0, 0, 1, 1), occ.addRectangle(0, 0, 0, 1, 1)
        if not split:
            occ.fragment([(2, left)], [(2, right)])
        occ.synchronize()
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


SQUARES: dict[str, Any] = {"upper": {"point": [-0.5, 0.5]}, "lower": {"point": [0.5, 0.5]}}


def test_bodies_with_a_curve_in_common_are_refused(tmp_path: Path) -> None:
    path = drawn(tmp_path / "squares.brep", split=False)
    message = refusal(cad_geometry(path, bodies=SQUARES))
    assert "bodies 'upper' and 'lower' have a curve in common (curve" in message
    assert "around (0, 0.5)); keep them separate" in message


def test_a_face_without_a_name_is_refused(tmp_path: Path) -> None:
    path = drawn(tmp_path / "squares.brep")
    loaded = parse_case(case_of(cad_geometry(path, bodies={"upper": SQUARES["upper"]})))
    message = re.escape("in none is face 2 around (0.5, 0.5)")
    with pytest.raises(MeshError, match=message), cad_model(path, loaded.geometry, "mm"):
        pass


def test_faces_out_of_the_plane_are_refused(tmp_path: Path) -> None:
    path = drawn(tmp_path / "squares.brep")
    # the heights of all vertices, curves and faces are in the matrices and poles of the file
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.translate(gmsh.model.occ.getEntities(2), 0, 0, 0.25)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    message = refusal(cad_geometry(path, bodies=SQUARES))
    assert "but face 1 reaches from z = 0.25 to 0.25; give volumes, or the plane" in message


def cut(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("suffix", ["step", "stp", "brep"])
@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda content: b"", "expected a"),
        (lambda content: b"hello world\n" * 9, r"expected a \w+ file with"),
        (lambda content: content[: len(content) // 2], "the file is not complete"),
        (lambda content: content[:-30], "the file is not complete"),
        (lambda content: content[:250], "the file is not complete"),
    ],
    ids=["empty", "text", "half", "end", "start"],
)
def test_files_that_are_cut_off(
    folder: Path, tmp_path: Path, suffix: str, change: Any, expected: str
) -> None:
    content = (folder / f"pad.{suffix.replace('stp', 'step')}").read_bytes()
    path = cut(tmp_path / f"pad.{suffix}", change(content))
    assert re.search(expected, refusal(cad_geometry(path)))


def test_a_file_of_another_kind(folder: Path, tmp_path: Path) -> None:
    path = cut(tmp_path / "pad.step", (folder / "pad.brep").read_bytes())
    assert "expected a STEP file with ISO-10303-21; at its start" in refusal(cad_geometry(path))
    path = cut(tmp_path / "pad.brep", (folder / "pad.step").read_bytes())
    assert "expected a BREP file with 'CASCADE Topology'" in refusal(cad_geometry(path))


def test_a_step_file_that_makes_no_sense(folder: Path, tmp_path: Path) -> None:
    content = (folder / "pad.step").read_bytes()
    head = content.partition(b"DATA;")[0]
    path = cut(tmp_path / "pad.step", head + b"DATA;\nENDSEC;\nEND-ISO-10303-21;\n")
    assert str(path) in refusal(cad_geometry(path))


def test_a_missing_file(tmp_path: Path) -> None:
    path = tmp_path / "none.step"
    message = refusal(cad_geometry(path))
    assert message.endswith(f"geometry.file: expected a file, found nothing at {path}")


def test_the_ends_of_a_curve_count_where_it_has_no_perpendicular(tmp_path: Path) -> None:
    with gmsh_model(tmp_path / "arc") as session:
        # three quarters of a circle of radius 1, open to the lower right
        session.model.occ.addCircle(0, 0, 0, 1, angle1=0, angle2=1.5 * math.pi)
        session.model.occ.synchronize()
        curves = Shapes(session, tmp_path / "arc.step", 1)
        with pytest.raises(MeshError) as caught:
            curves.select("key", Selector(point=(2.0, -1.0)), curves.shapes)
    # to (1, 0); the only perpendicular goes to the opposite side, 1 + sqrt(5) away
    assert "the point (2, -1) is 1.41 away from the nearest curve" in str(caught.value)
