# SPDX-License-Identifier: LGPL-3.0-or-later
"""The picture of a mesh: nothing in it overlaps, whatever the bodies and names are."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness.small_files import small_files
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.text import Text
from numpy.typing import NDArray

from fretfe._typing import Array
from fretfe.case import Case, parse_case
from fretfe.errors import OutputError
from fretfe.mesh.make import write_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.report.pictures.mesh import (
    CURVE_PIECES,
    boundary_curves,
    cell_outlines,
    draw_mesh,
    spread,
    write_mesh_picture,
)
from fretfe.report.theme import FILE_DPI

STEEL = {"young": 2e5, "poisson": 0.3}


def element(
    points: Array, boundaries: dict[str, NDArray[np.int64]], name: str = "body"
) -> BodyMesh:
    """A quadrilateral with its corners in their order."""
    return BodyMesh(name, points, np.array([[0, 1, 2, 3]]), "quadrilateral", 1, boundaries)


def square(name: str, x: float, y: float, size: float = 1.0) -> BodyMesh:
    """One element whose four sides are boundaries."""
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    sides = ("bottom", "right", "top", "left")
    boundaries = {f"{name}_{s}": np.array([[i, (i + 1) % 4]]) for i, s in enumerate(sides)}
    return element(size * corners + [x, y], boundaries, name)


def pairs(count: int, suffix: str = "", scale: float = 1.0) -> tuple[Case, dict[str, BodyMesh]]:
    """`count` contacts side by side, each of two squares."""
    bodies: dict[str, BodyMesh] = {}
    contacts: dict[str, Any] = {}
    for i in range(count):
        upper, lower = f"upper{i}{suffix}", f"lower{i}{suffix}"
        bodies[upper] = square(upper, 1.2 * i * scale, 0.0, scale)
        bodies[lower] = square(lower, 1.2 * i * scale, -scale, scale)
        contacts[f"contact{i}"] = {
            "surface1": f"{upper}_bottom",
            "surface2": f"{lower}_top",
            "friction": 0.3,
        }
    tables = {"geometry": {"file": "m.msh"}, "bodies": dict.fromkeys(bodies, STEEL)}
    return parse_case({"title": "A title", **tables, "contacts": contacts}), bodies


def texts(figure: Figure) -> list[Text]:
    """All texts that are drawn; ticks outside the limits are not."""
    hidden = set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
                hidden |= {tick.label2} | (
                    {tick.label1} if not low <= tick.get_loc() <= high else set()
                )
    return [t for t in figure.findobj(Text) if t.get_visible() and t.get_text() and t not in hidden]


@pytest.mark.parametrize(
    ("count", "suffix", "scale"),
    [
        pytest.param(1, "", 1.0, id="one"),
        pytest.param(2, "", 1e-3, id="two small ones"),
        pytest.param(8, "", 123.4, id="eight"),
        pytest.param(3, "_with_a_very_long_name", 1.0, id="long names"),
    ],
)
def test_no_two_texts_overlap(count: int, suffix: str, scale: float) -> None:
    case, bodies = pairs(count, suffix, scale)
    figure = draw_mesh(case, bodies)
    figure.draw_without_rendering()
    found = texts(figure)
    # Of the texts alone: that of an annotation has its line too.
    boxes = [Text.get_window_extent(text) for text in found]
    for (text, box), (other, second) in itertools.combinations(zip(found, boxes, strict=True), 2):
        assert not box.overlaps(second), (text.get_text(), other.get_text())
    # Nothing is cut off.
    for text, box in zip(found, boxes, strict=True):
        assert figure.bbox.contains(*box.min) and figure.bbox.contains(*box.max), text.get_text()
    # Every boundary has its name in the picture, every contact its panel.
    words = [text.get_text() for text in found]
    for body in bodies.values():
        assert all(words.count(name) == 1 for name in body.boundaries)
    assert all(any(w.startswith(f"{name}\n") for w in words) for name in case.contacts)
    assert sum(word == "x [mm]" for word in words) == count + 1


def test_picture_is_written_without_a_display(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for variable in ("DISPLAY", "WAYLAND_DISPLAY", "MPLBACKEND"):
        monkeypatch.delenv(variable, raising=False)
    case, bodies = pairs(2)
    write_mesh_picture(tmp_path / "mesh.png", case, bodies)
    pixels = imread(tmp_path / "mesh.png")
    width, height = draw_mesh(case, bodies).get_size_inches()
    # Sizes are cut to whole pixels.
    assert np.allclose(pixels.shape[:2], [FILE_DPI * height, FILE_DPI * width], atol=1)
    # Both surfaces are to be seen: their colours, in the middle of a line, are not mixed.
    for colour in ("0072B2", "E69F00"):
        wanted = np.array([int(colour[i : i + 2], 16) for i in (0, 2, 4)]) / 255
        assert (np.abs(pixels[..., :3] - wanted).max(axis=2) < 0.01).any()


@pytest.mark.pictures
def test_a_mesh_and_its_picture_that_do_not_fit_are_told(tmp_path: Path) -> None:
    """Gmsh says nothing; what was there before stays."""
    pytest.importorskip("gmsh")
    case, bodies = pairs(2)
    mesh = Mesh(bodies)
    files = {
        "mesh.msh": lambda path: write_mesh(mesh, path),
        "mesh.png": lambda path: write_mesh_picture(path, case, bodies),
    }
    for name, write in files.items():
        path = tmp_path / name
        path.write_text("before")
        with (
            small_files(500),
            pytest.raises(OutputError, match=rf"{name}: cannot write the (mesh|picture): .*large"),
        ):
            write(path)
        assert path.read_text() == "before"
    assert sorted(each.name for each in tmp_path.iterdir()) == sorted(files)


def test_scales_are_equal_in_x_and_y() -> None:
    case, bodies = pairs(3)
    figure = draw_mesh(case, bodies)
    for axes in figure.axes:
        box = axes.get_window_extent()
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        assert box.width / (right - left) == pytest.approx(box.height / (high - low))


def test_all_of_the_mesh_is_in_the_picture_of_the_bodies() -> None:
    case, bodies = pairs(3, "_with_a_long_name")
    axes = draw_mesh(case, bodies).axes[0]
    points = np.concatenate([body.points for body in bodies.values()])
    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    assert (points > low).all() and (points < high).all()


def sector(radius: float = 2.0) -> BodyMesh:
    """A triangle of order 2 whose first side is an arc of 40 degrees about the origin."""
    angles = np.radians([-20.0, 20.0, 0.0])
    first, last, middle = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    tip = np.array([0.5, 0.0])
    points = np.array([first, last, tip, middle, (last + tip) / 2, (tip + first) / 2])
    facets = {"arc": np.array([[0, 1, 3]]), "sides": np.array([[2, 0, 5], [1, 2, 4]])}
    return BodyMesh("sector", points, np.array([[0, 1, 2, 3, 4, 5]]), "triangle", 2, facets)


def test_curved_edges_are_drawn_curved() -> None:
    straight, curved = cell_outlines(sector())[0]
    assert len(straight) == 0 and curved.shape == (1, 3 * CURVE_PIECES, 2)
    # A parabola leaves an arc of 40 degrees by R θ⁴/512 = 5e-4 R.
    arc = curved[0, : CURVE_PIECES + 1]
    assert np.allclose(np.linalg.norm(arc, axis=1), 2.0, atol=1e-3)
    (curve,) = boundary_curves(sector(), "arc")
    assert np.allclose(curve, arc)


def test_straight_cells_are_drawn_from_corner_to_corner() -> None:
    body = square("s", 0.0, 0.0)
    (outlines,), boxes = cell_outlines(body)
    assert np.array_equal(outlines[0], body.points[:4])
    assert np.array_equal(boxes[0], [[0, 0], [1, 1]])


def test_boundaries_are_chained() -> None:
    """In any order of the facets, over a closed curve too, and piece by piece."""
    points = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    groups = {
        "open": np.array([[2, 3], [0, 1], [1, 2]]),
        "closed": np.array([[2, 3], [0, 1], [3, 0], [1, 2]]),
        "pieces": np.array([[2, 3], [0, 1]]),
    }
    body = element(points, groups)
    (curve,) = boundary_curves(body, "open")
    assert np.array_equal(curve, points)
    (loop,) = boundary_curves(body, "closed")
    assert len(loop) == 5 and np.array_equal(loop[0], loop[-1])
    assert [len(piece) for piece in boundary_curves(body, "pieces")] == [2, 2]


@pytest.mark.parametrize(
    ("wanted", "expected"),
    [
        ([], []),
        ([2.0, 5.0], [2.0, 5.0]),
        ([2.0, 2.0, 2.5], [2.0, 3.0, 4.0]),
        ([-3.0, 9.8, 9.9], [1.0, 8.0, 9.0]),
    ],
    ids=["none", "far", "near", "at the ends"],
)
def test_names_keep_their_distance(wanted: list[float], expected: list[float]) -> None:
    assert spread(np.array(wanted), 1.0, 1.0, 9.0).tolist() == expected
