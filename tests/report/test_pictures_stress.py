# SPDX-License-Identifier: LGPL-3.0-or-later
"""What pictures of stress show: places, colours and scales against other ways to find them."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from cases.drawn import pad_case, write_folder

from fretfe._typing import Array
from fretfe.evaluate.resultants import station_extremes
from fretfe.history.solution import OPEN, SLIP, STICK, ContactHistory, FullStickUnits
from fretfe.report.pictures.fields import BodyField, Grid, find_time, open_fields
from fretfe.report.pictures.looks import (
    EdgePlace,
    colour_limit,
    deformation_scale,
    edge_view,
    round_down,
    round_up,
)
from fretfe.report.pictures.mesh import shares_text, visible_status
from fretfe.report.pictures.panels import View, panels, settle
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.friction import Friction

needs_pyvista = pytest.mark.skipif(
    importlib.util.find_spec("pyvista") is None, reason="PyVista is not installed"
)


def square(size: float = 1.0, **arrays: Array) -> BodyField:
    """Two triangles of order 1 with nodes of their own."""
    corners = size * np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    nodes = corners[[[0, 1, 2], [0, 2, 3]]]
    return BodyField(
        Grid(nodes), **{"displacement": np.zeros((6, 2)), "stress": np.zeros((6, 6)), **arrays}
    )


def test_von_mises_is_that_of_the_whole_tensor() -> None:
    """√(3/2) times the norm of the deviator of the tensor in space."""
    stress = np.random.default_rng(1).normal(size=(6, 6))
    tensor = stress[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    deviator = tensor - np.trace(tensor, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    expected = np.sqrt(1.5) * np.linalg.norm(deviator, axis=(1, 2))
    assert square(stress=stress).von_mises == pytest.approx(expected, rel=1e-12)  # round-off


def test_times_are_found() -> None:
    times = np.array([1 / 3, 2.0])
    assert find_time(times, 2.0) == 1
    assert find_time(times, 1.9) is None
    assert find_time(np.zeros(0), 1.0) is None


def test_the_outline_of_a_body(cycle: Path) -> None:
    """The rectangle's four sides have 16 edges each."""
    body = open_fields(cycle).bodies(1)["upper"]
    middles = body.grid.points[body.grid.outline[:, 1]]
    assert len(middles) == 4 * 16
    distances = np.abs(np.abs(middles - [0, 1]) - [2, 1]).min(axis=1)
    assert distances.max() < 1e-12  # round-off


def test_views_are_turned() -> None:
    """Body 2 faces left: up in the picture is −x, right is +y."""
    view = View(np.array([5.0, 1.0]), np.array([2.0, 1.0]), np.array([-1.0, 0.0]), np.ones(2))
    assert view.local(np.array([4.0, 3.0])) == pytest.approx([1 + 2, 1 + 1])
    box = np.array([[(4.5, 2.9), (4.4, 2.8)], [(4.5, 3.1), (4.4, 3.2)], [(6.1, 1.0), (6.2, 1.0)]])
    assert view.overlaps(box).tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("value", "down", "up"),
    [(1.0, 1, 1), (1.99, 1, 2), (4.3, 2, 4.3), (7e3, 5e3, 7e3), (0.0612, 0.05, 0.062)],
)
def test_round_numbers(value: float, down: float, up: float) -> None:
    assert round_down(value) == pytest.approx(down)
    assert round_up(value) == pytest.approx(up)


def contact(gap: list[list[float]], weights: Array | None = None, **changes: Any) -> ContactHistory:
    count = len(gap[0])
    arc = np.linspace(0.0, 1.0, count)
    surface = ContactSurface(
        arc=arc,
        points=np.stack([arc, 0 * arc], axis=1),
        frames=np.tile(np.array([[0.0, 1.0], [1.0, 0.0]]), (count, 1, 1)),
        weights=np.ones(count) if weights is None else weights,
    )
    values: dict[str, Any] = {
        "gap": np.array(gap),
        "slip": np.zeros((len(gap), count, 1)),
        "status": np.zeros((len(gap), count), dtype=np.int8),
        **changes,
    }
    zeros = np.zeros((len(gap), count, 2))
    mean = values.pop("mean_traction", zeros)
    return ContactHistory(
        name="main",
        pair="main",
        body1="upper",
        body2="lower",
        surface=surface,
        friction=Friction.uniform(np.zeros(len(gap)), count),
        traction=zeros,
        mean_traction=mean,
        dissipation=np.zeros(len(gap)),
        full_stick=FullStickUnits(np.zeros((0, count, 2, 0)), np.full(len(gap), -1)),
        **values,
    )


def test_drawn_displacements_are_seen_and_overlap_little() -> None:
    body = square(10.0, displacement=np.full((6, 2), [0.003, 0.0]))
    # 4 % of 10 over 0.003 is 133.
    assert deformation_scale([body], [], [1]) == 100
    # g0 − s (g0 − g) ≥ −0.03 for g0 = 0.002, g = 0: s ≤ 16; opening elsewhere does not count.
    closing = contact([[0.002, 0.0], [0.0, 0.5]])
    assert deformation_scale([body], [closing], [1]) == 10
    assert deformation_scale([body], [closing], [0]) == 100
    # Displacements that are large already are drawn as they are.
    assert deformation_scale([square(1.0, displacement=np.ones((6, 2)))], [], [1]) == 1


def test_small_elements_do_not_set_the_colours() -> None:
    """A hundred elements of a thousandth of the area have a huge stress: colours end below it."""
    high = [square(0.003, stress=np.full((6, 6), [9e9, 0, 0, 0, 0, 0])) for _ in range(100)]
    low = square(1.0, stress=np.full((6, 6), [100.0, 0, 0, 0, 0, 0]))
    limit, largest = colour_limit([(body, None) for body in [low, *high]], 99.8)
    assert limit == pytest.approx(100.0)
    assert largest > 1e9
    assert colour_limit([(square(), None)], 99.8) == (1.0, 0.0)


def test_panels_count_alike_for_the_last_colour() -> None:
    """A panel a thousand times as wide as another one, which has ten times its stress."""
    large = square(1.0, stress=np.full((6, 6), [100.0, 0, 0, 0, 0, 0]))
    small = square(0.001, stress=np.full((6, 6), [1000.0, 0, 0, 0, 0, 0]))
    views = [View(np.zeros(2), np.full(2, size), np.array([0.0, 1.0])) for size in (1.0, 0.001)]
    limit, _ = colour_limit(list(zip([large, small], views, strict=True)), 98.0)
    assert limit == pytest.approx(1000.0)


def test_edges_are_at_the_origin_on_both_bodies() -> None:
    """Body 1 slid by 0.3, both went down by 0.1, a press fit lifts it by 0.02: none shows."""
    bodies = {
        "upper": square(displacement=np.full((6, 2), [0.3, -0.08])),
        "lower": square(displacement=np.full((6, 2), [0.01, -0.1])),
    }
    place = EdgePlace("main", "left edge", 1, 1.0, slip=0.02, half_width=5.0, overlap=0.02)
    view, moved = edge_view(contact([[0.0] * 101] * 2), place, bodies)
    for body in moved.values():
        assert view.local(body.deformed(1.0)[1]) == pytest.approx([0.0, 0.0], abs=1e-15)
    # Ten elements of 0.01 are more than three slip zones.
    assert view.half_size == pytest.approx([0.1, 0.08])
    wide, _ = edge_view(
        contact([[0.0] * 101] * 2), EdgePlace("m", "left edge", 1, 1.0, 0.0, 5.0), bodies
    )
    assert wide.half_size[0] == pytest.approx(0.3 * 5.0)


def test_titles_end_before_the_next_panel_and_the_picture() -> None:
    """Low panels in four rows are narrower than what stands above them."""
    figure, axes = panels(8, 0.36, columns=2)
    for each in axes:
        each.set_title("R1, t = 3 s\nspeed = 942\nstick 0.0%, slip 100.0% of the contact")
    settle(figure, axes, 0.36, "Status")
    left, right = (each.get_tightbbox() for each in axes[:2])
    assert left is not None and right is not None
    assert left.x1 < right.x0 and right.x1 < figure.bbox.x1


def test_nodes_at_the_limit_that_do_not_move_stick() -> None:
    """Slip of 1e-15 after sliding by 0.01 is round-off; of 1e-6 it is not."""
    slip = np.array([[0, 0, 0, 0], [0.01, 0.01, 0.01, 0.01], [0.01 + 1e-15, 0.01, 0.010001, 0.01]])
    status = np.array([[OPEN] * 4, [SLIP] * 4, [SLIP, STICK, SLIP, OPEN]], dtype=np.int8)
    changes = {"slip": slip[..., None], "status": status, "mean_traction": np.zeros((3, 4, 2))}
    changes["mean_traction"][1:, :, 0] = 1.0
    surface = contact([[0.0] * 4] * 3, **changes)
    assert visible_status(surface, 2).tolist() == [STICK, STICK, SLIP, OPEN]
    assert visible_status(surface, 1).tolist() == [SLIP] * 4
    assert visible_status(surface, 0).tolist() == [OPEN] * 4
    smooth = contact([[0.0] * 4] * 3, weights=np.arange(4.0), **changes)
    surface = replace(smooth, friction=Friction.uniform(np.full(3, 0.5), 4))
    assert shares_text(surface, 2) == "stick 33.3%, slip 66.7%"
    assert shares_text(surface, 0) == "carries nothing"
    assert shares_text(smooth, 2) == "in contact, without friction"


def test_surfaces_that_touch_without_a_force_do_not_slip() -> None:
    """Unloaded to round-off of P, all nodes at f p = 0: that is no slip of 100 %."""
    slip = np.array([[0.0, 0.0], [0.0, 0.0], [0.01, 0.02]])
    status = np.array([[OPEN] * 2, [STICK] * 2, [SLIP] * 2], dtype=np.int8)
    mean = np.zeros((3, 2, 2))
    mean[:, :, 0] = [[0.0] * 2, [1.0] * 2, [1e-9] * 2]
    surface = contact([[0.0] * 2] * 3, slip=slip[..., None], status=status, mean_traction=mean)
    assert visible_status(surface, 1).tolist() == [STICK] * 2
    assert visible_status(surface, 2).tolist() == [OPEN] * 2
    assert shares_text(surface, 2) == "carries nothing"


WAVE = np.sin(np.linspace(0, 2 * np.pi, 9))


@pytest.mark.parametrize(
    ("k_t", "k_i", "cycle", "expected"),
    [
        ([WAVE], [0 * WAVE], (0, 8), [2, 6]),
        ([-WAVE], [0 * WAVE], (0, 8), [2, 6]),
        ([0.1 * WAVE, np.roll(WAVE, 1)], [0 * WAVE] * 2, (0, 8), [3, 7]),
        ([1e-9 * np.roll(WAVE, 1)], [WAVE], (0, 8), [2, 6]),
        ([WAVE], [0 * WAVE], (4, 8), [4, 6]),
        ([np.append(np.nan, WAVE[1:])], [0 * WAVE], None, [2, 6]),
        ([0 * WAVE], [0 * WAVE], (0, 8), [8]),
        ([np.zeros(1)], [np.zeros(1)], None, [0]),
    ],
    ids="wave,other sign,largest edge,no shear,part,no cycle,constant,no steps".split(","),
)
def test_extremes_of_stations(
    k_t: list[Array], k_i: list[Array], cycle: tuple[int, int] | None, expected: list[int]
) -> None:
    stations: Any = [
        SimpleNamespace(k_along=shear, k_i=normal) for shear, normal in zip(k_t, k_i, strict=True)
    ]
    assert station_extremes(stations, cycle) == expected


@pytest.fixture(scope="module")
def cycle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the fields of all steps."""
    times = [0.5, 1.0, *(1 + np.arange(1, 9) / 4).tolist()]
    return write_folder(tmp_path_factory.mktemp("cycle") / "results", times)


def test_fields_are_those_of_the_extremes_by_default() -> None:
    assert pad_case().output.fields == "extremes"
    assert pad_case(fields="last").output.fields == "last"
