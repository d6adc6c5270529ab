# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of solids: surfaces in a plane, stress on skin and cuts."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.solid_runs import (
    RADIUS,
    Surface,
    block,
    contact,
    element_nodes,
    field_values,
    histories,
    solid_result,
    sphere,
    surface,
    write_solid,
)
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation

from fretfe._typing import Array
from fretfe.errors import ConvergenceError
from fretfe.evaluate.evaluate import evaluate
from fretfe.history.solution import OPEN, SLIP, STICK
from fretfe.report.page.html import render
from fretfe.report.pictures.fields import FACES, BodyField, Grid, section
from fretfe.report.pictures.fields import surface as linear_pieces
from fretfe.report.pictures.folder import make_pictures
from fretfe.report.pictures.looks import _cut, _whole, cell_volumes, plan_pictures
from fretfe.report.pictures.panels import SpaceView, pixels
from fretfe.report.pictures.surfaces import (
    FILLS,
    draw_surface,
    lay_out,
)
from fretfe.report.pictures.unroll import Unrolled, unroll
from fretfe.results.model import Result
from fretfe.results.tables import NODAL
from fretfe.results.writer import PICTURE_LIST, PICTURES, write_results

EXTREMES = [24, 32]


@pytest.fixture(scope="module")
def result() -> Result:
    return solid_result()


def unrolled(shape: Surface) -> Unrolled:
    radius = np.linalg.norm(shape.plane, axis=1)
    return unroll(contact(shape, "main", histories(radius, np.array([0.1, 0.2]))))


def turned(shape: Surface, turn: Rotation) -> Surface:
    return replace(shape, points=turn.apply(shape.points), normals=turn.apply(shape.normals))


@pytest.mark.parametrize("bend", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (20.0, -50.0, 70.0)])
def test_a_surface_that_bends_one_way_keeps_its_lengths(
    bend: float, angles: tuple[float, ...]
) -> None:
    turn = Rotation.from_euler("xyz", angles, degrees=True)
    shape = turned(surface(bend=bend, count=12), turn)
    found = unrolled(shape)
    np.testing.assert_allclose(pdist(found.places), pdist(shape.plane), atol=1e-9)
    assert ("unrolled" in found.how) == (bend > 0)
    # The picture is no mirror image: n, and the axes to the right and up, are right-handed.
    crosses = np.cross(found.axes[:, 0], found.axes[:, 1])
    np.testing.assert_allclose(crosses, shape.normals, atol=1e-12 + 0.2 * (bend == 0))


def test_vectors_along_the_surface_keep_their_lengths() -> None:
    shape = surface(bend=0.9)
    found = unrolled(shape)
    angle = 0.9 * shape.plane[:, 0]
    tangent = np.stack([np.cos(angle), -np.sin(angle), 0 * angle], axis=1)
    along = np.einsum("nad,nd->na", found.axes, tangent)
    np.testing.assert_allclose(along, np.tile([1.0, 0.0], (len(angle), 1)), atol=1e-12)
    np.testing.assert_allclose(found.directions, [[1, 0, 0], [0, 0, -1]], atol=1e-12)


def test_a_surface_that_bends_both_ways_is_projected() -> None:
    found = unrolled(sphere(radius=3.0))
    assert "projected: on its slopes lengths appear up to 29% shorter" in found.how
    shape = sphere(radius=3.0)
    np.testing.assert_allclose(found.places, shape.plane * [1, -1], atol=1e-9)


def test_a_quarter_turn_is_no_mirror_image() -> None:
    found = unrolled(surface()).turned()
    assert found.names == ("−z", "−x")
    np.testing.assert_allclose(np.cross(*found.directions), [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(found.places, surface().plane[:, ::-1] * -1, atol=1e-12)


def test_the_longer_side_lies_across() -> None:
    long = surface()
    stretched = replace(long, points=long.points * [0.2, 1, 1], plane=long.plane * [0.2, 1])
    result = solid_result(shapes={"main": stretched})
    run = replace(
        result,
        root_solution=replace(
            result.solution,
            contacts=(contact(stretched, "main", histories(np.linalg.norm(long.plane, axis=1),
                                                           np.linspace(0.1, 0.6, 36))),),
        ),
    )  # fmt: skip
    sheet = lay_out(run, "main", [20])
    assert sheet.plane.names == ("z", "x")  # up is where x grows
    assert sheet.true_aspect == pytest.approx(0.2, abs=0.02) and sheet.aspect == 0.3
    _, caption = draw_surface(run, "main", [20])
    assert "The axes have different scales." in caption


@dataclass(frozen=True)
class Drawn:
    """A picture of a contact at the load extremes."""

    figure: Figure
    caption: str
    image: Array


@pytest.fixture(scope="module")
def picture(result: Result) -> Drawn:
    figure, caption = draw_surface(result, "main", EXTREMES)
    return Drawn(figure, caption, np.asarray(pixels(figure)) / 255)


def colours_at(picture: Drawn, places: Array) -> Array:
    """(panels, n, 3) colours at places (n, 2) of the surface."""
    image, found = picture.image, []
    for axes in picture.figure.axes[:4]:
        columns, rows = axes.transData.transform(places).T
        found.append(image[(len(image) - rows).astype(int), columns.astype(int)])
    return np.array(found)


def test_colours_are_those_of_pressure_and_status(picture: Drawn) -> None:
    # Between the arrows, at radii of 0, .55, .85, and open.
    places = np.array([[0.0, 0.0], [0.4, 0.345], [0.37, 0.765], [0.93, 0.93]])
    first, _, status, _ = colours_at(picture, places)
    # 12 colours of 25 MPa each
    bands = (np.array([300.0, 254.7, 158.0]) // 25).clip(max=11)
    expected = colormaps["viridis"](bands / 11)[:, :3]
    assert first[:3] == pytest.approx(expected, abs=0.01)
    kinds = (STICK, STICK, SLIP, OPEN)
    assert status == pytest.approx(np.array([to_rgb(FILLS[kind]) for kind in kinds]), abs=0.01)


def test_arrows_are_those_of_the_shear(result: Result, picture: Drawn) -> None:
    sheet = lay_out(result, "main", EXTREMES)
    sign = float(np.sign(sheet.plane.directions[0, 0]))
    for state in EXTREMES:
        shear = sheet.shear_at(state)
        np.testing.assert_allclose(
            sign * shear[:, 0],
            result.contact_history("main").mean_traction[state, :, 1],
            atol=1e-9,
        )
        np.testing.assert_allclose(shear[:, 1], 0, atol=1e-9)
    drawn = picture.figure.axes[0].collections[-1]
    arrows = drawn.U  # type: ignore[attr-defined]
    # π/4 of 12 × 8 places less those next to the edge, and a few without shear
    assert 0.55 * 96 < len(arrows) < 0.9 * 96
    assert (sign * arrows).min() > 0 and f"the longest {sheet.shear:.0f} MPa" in picture.caption


def test_contact_ends_where_its_edge_is(picture: Drawn) -> None:
    """Nodes and facets of .083: the edge is found within one of them."""
    angle = np.linspace(0.1, 2 * np.pi, 9)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inside, outside = (colours_at(picture, circle * r)[2] for r in (RADIUS - 0.1, RADIUS + 0.01))
    grey = np.ptp(inside, axis=1) < 0.01
    assert not grey.any() and (np.ptp(outside[:1], axis=1) < 0.01).all()


@pytest.mark.parametrize("count", sorted(FACES))
def test_faces_are_those_of_vtk(count: int) -> None:
    vtk = pytest.importorskip("vtk")
    solids = {4: "Tetra", 8: "Hexahedron", 10: "QuadraticTetra", 20: "QuadraticHexahedron"}
    cell = getattr(vtk, f"vtk{solids.get(count, 'TriQuadraticHexahedron')}")()
    for node in range(count):
        cell.GetPointIds().SetId(node, node)
    faces = set()
    for number in range(cell.GetNumberOfFaces()):
        ids = cell.GetFace(number).GetPointIds()
        faces.add(frozenset(ids.GetId(i) for i in range(ids.GetNumberOfIds())))
    assert {frozenset(face) for face in FACES[count]} == faces


def field(tetrahedra: bool, count: int = 4) -> BodyField:
    nodes = element_nodes(block((0, 0, 0), (1, 2, 3), count), tetrahedra=tetrahedra)
    grid = Grid(nodes)
    stress = np.zeros((len(grid.points), 6))
    stress[:, 0] = 10 + grid.points[:, 2]
    return BodyField(grid, np.zeros_like(grid.points), stress)


@pytest.mark.parametrize("tetrahedra", [False, True])
def test_skin_and_cut_of_a_box(tetrahedra: bool) -> None:
    pytest.importorskip("pyvista")
    body = field(tetrahedra)
    assert linear_pieces(body, 1.0).area == pytest.approx(22.0)
    middle, cut = np.array([0.4, 1.0, 1.5]), np.array([1.0, 0.0, 0.0])
    view = SpaceView(middle, cut, np.array([0.0, 1.0, 0.0]), np.ones(2), cut)
    plane = section(body, 1.0, view)
    assert plane.area == pytest.approx(6.0)
    np.testing.assert_allclose(plane.points[:, 0], 0.4, atol=1e-6)
    np.testing.assert_allclose(plane["stress"], 10 + plane.points[:, 2], rtol=1e-5)


def test_volumes_of_cells() -> None:
    body = block((0, 0, 0), (1, 2, 3), 4)
    boxes = element_nodes(body, tetrahedra=False)
    parts = element_nodes(body, tetrahedra=True)[:, :4]
    assert cell_volumes(boxes) == pytest.approx(6 / 64)
    assert cell_volumes(parts).sum() == pytest.approx(6.0)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("pyvista")
    folder = write_solid(tmp_path_factory.mktemp("solids") / "results")
    make_pictures(folder)
    missing = listed(folder)["missing"]
    if missing and "OpenGL" in missing[0]["reason"]:
        pytest.skip(missing[0]["reason"])
    return folder


def listed(folder: Path) -> dict[str, Any]:
    return dict(json.loads((folder / PICTURES / PICTURE_LIST).read_text("utf-8")))


def test_everything_is_drawn_and_listed(drawn: Path) -> None:
    content = listed(drawn)
    assert content["missing"] == []
    assert [each["file"] for each in content["pictures"]] == ["stress.png", "contact.png"]
    for each in content["pictures"]:
        with Image.open(drawn / PICTURES / each["file"]) as image:
            assert image.size == (each["width"], each["height"])
    caption = content["pictures"][0]["caption"]
    assert "through its largest pressure at (0, 0, 0) mm and across z" in caption


@pytest.mark.parametrize(("turn", "upright"), [(1.0, 1), (-1.0, 0)])
def test_flanks_press_a_blade_up(result: Result, turn: float, upright: int) -> None:
    """Two flanks at 60 degrees to y, mirror images, or facing one another as on a plate."""
    contact = result.contact_history("main")
    surface, count = contact.surface, len(contact.surface.points)
    x, y = np.sin(np.pi / 3), np.cos(np.pi / 3)
    frame = np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])
    mirrored = np.array([[-x, turn * y, 0.0], [y, turn * x, 0.0], [0.0, 0.0, 1.0]])
    flanks = [
        replace(contact, surface=replace(surface, frames=np.broadcast_to(each, (count, 3, 3))))
        for each in (frame, mirrored)
    ]
    view = _whole(contact.surface.points, flanks)
    assert np.abs(view.up).argmax() == upright and view.up[upright] > 0


def test_cut_shows_the_stress_below_the_contact(drawn: Path) -> None:
    """The middle of the lower panels is the place of the largest pressure."""
    with Image.open(drawn / PICTURES / "stress.png") as image:
        colours = np.asarray(image.convert("RGB")) / 255
    _, stress = field_values(np.zeros(3), 2.25)
    limit = 300.0
    expected = colormaps["viridis"](-stress[1] / limit)[:3]
    height, width = colours.shape[:2]
    area = colours[int(0.72 * height) : int(0.8 * height), int(0.15 * width) : int(0.3 * width)]
    assert np.abs(area - expected).max(axis=2).min() < 0.02


def test_cut_stays_inside_a_contact_whose_pressure_is_largest_at_an_end(result: Result) -> None:
    history = result.contact_history("main")
    assert history.surface.points is not None
    whole = _whole(history.surface.points, [history])
    state = int(history.mean_traction[:, :, 0].max(axis=1).argmax())
    normal = _cut(history.surface.points, history, state, whole).cut
    assert normal is not None
    across = history.surface.points @ normal
    for end in (across.argmin(), across.argmax()):
        tractions = np.array(history.mean_traction)
        tractions[state, end, 0] = 1e6
        loaded = replace(history, mean_traction=tractions)
        view = _cut(history.surface.points, loaded, state, whole)
        assert view.cut is not None and np.allclose(view.cut, normal)
        assert across.min() < view.centre @ normal < across.max()


def test_a_run_without_steps_has_what_there_is(result: Result, tmp_path: Path) -> None:
    solution, loads = result.solution, result.loads
    first = slice(0, 1)
    history = result.contact_history("main")
    states: dict[str, Any] = {
        field.name: getattr(history, field.name)[first]
        for field in fields(history)
        if field.name in NODAL
    }
    states["friction"] = history.friction.picked(first)
    loads = replace(loads, times=loads.times[first], values=loads.values[first], cycle=None)
    names = ("times", "values", "amplitudes", "forces", "driver_values", "iterations", "parts")
    short = replace(
        solution,
        contacts=(replace(history, **states),),
        cycle=None,
        fallbacks=solution.fallbacks[first],
        certificates={name: values[first] for name, values in solution.certificates.items()},
        **{name: getattr(solution, name)[first] for name in names},
    )
    failed = ConvergenceError("step 1 has no solution")
    run = replace(
        result, root_solution=short, loads=loads, contacts=evaluate(short), failure=failed
    )
    write_results(tmp_path, run)
    make_pictures(tmp_path)
    assert [each["file"] for each in listed(tmp_path)["pictures"]] == ["contact.png"]
    assert "step 1 has no solution" in render(tmp_path)


def test_each_contact_has_a_picture() -> None:
    shapes = {name: surface() for name in ("left", "right")}
    planned = plan_pictures(solid_result(shapes=shapes))
    assert [each.file for each in planned if each.kind == "surface"] == [
        "contact_1.png",
        "contact_2.png",
    ]
