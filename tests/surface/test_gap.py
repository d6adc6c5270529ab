# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gaps given along surfaces, at the nodes of a contact."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cases.pad_cases import PAD, pad

from fretfe._typing import Array
from fretfe.case import Case, parse_case
from fretfe.errors import CaseError
from fretfe.loads import build_history
from fretfe.loads.over_surface import OverSurface, read_gap
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.gap import gap_at_nodes, gap_missed


def with_gap(folder: Path, text: str) -> Case:
    (folder / "gap.csv").write_text(text)
    main = {**PAD["contacts"]["main"], "gap": "gap.csv"}
    return parse_case(pad(contacts={"main": main}), source=folder / "pad.toml")


def given(case: Case) -> OverSurface:
    found = read_gap(case, "main")
    assert found is not None
    return found


def line(count: int = 41, tilt: float = 0.0) -> ContactSurface:
    """Nodes on a straight line of length 4 about the origin."""
    arc = np.linspace(-2, 2, count)
    along, across = np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
    frames = np.broadcast_to([across, along], (count, 2, 2))
    return ContactSurface(arc, np.outer(arc, along), frames, np.full(count, 4 / count))


def plane(count: int = 13) -> ContactSurface:
    """Nodes on a square with sides of 2."""
    x, z = (each.ravel() for each in np.meshgrid(*[np.linspace(-1, 1, count)] * 2))
    points = np.column_stack([x, 0 * x, z])
    frames = np.broadcast_to([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]], (len(x), 3, 3))
    weights = np.full(len(x), 4 / len(x))
    return ContactSurface(np.zeros(0), points, frames, weights, np.zeros((0, 4), dtype=np.int64))


def rows(columns: str, *values: Array) -> str:
    table = "\n".join(",".join(f"{each:.12g}" for each in row) for row in np.column_stack(values))
    return f"{columns}\n{table}\n"


def test_a_coarse_table_along_the_arc_is_smooth_between_its_places(tmp_path: Path) -> None:
    arc = np.linspace(-2.1, 2.1, 22)
    case = with_gap(tmp_path, rows("arc,gap", arc, arc**2))
    found = gap_at_nodes(given(case), line())
    # Straight lines would be .2^2/4 off.
    assert found == pytest.approx(line().arc ** 2, abs=1e-3)


def test_two_rows_are_a_straight_line(tmp_path: Path) -> None:
    case = with_gap(tmp_path, "arc,gap\n-2,0\n2,1\n")
    assert gap_at_nodes(given(case), line()) == pytest.approx((line().arc + 2) / 4, abs=1e-15)


def test_places_are_taken_along_the_surface(tmp_path: Path) -> None:
    surface = line(tilt=0.7)
    arc = np.linspace(-2.05, 2.05, 83)[np.random.default_rng(1).permutation(83)]
    places = np.outer(arc, [np.cos(0.7), np.sin(0.7)])
    case = with_gap(tmp_path, rows("x,y,gap", places, np.cos(arc) + 1))
    assert gap_at_nodes(given(case), surface) == pytest.approx(np.cos(surface.arc) + 1, abs=1e-4)


def crown(x: Array, z: Array) -> Array:
    return x**2 + 0.5 * z**2 + 0.3 * x * z


@pytest.mark.parametrize("count", [12, 50])  # all points at once, and those around each place
def test_places_over_a_surface_of_solids(tmp_path: Path, count: int) -> None:
    x, z = (each.ravel() for each in np.meshgrid(*[np.linspace(-1.05, 1.05, count)] * 2))
    case = with_gap(tmp_path, rows("x,y,z,gap", x, 0 * x, z, crown(x, z)))
    points = plane().points
    found = gap_at_nodes(given(case), plane())
    assert found == pytest.approx(crown(points[:, 0], points[:, 2]), abs=1e-9)
    wavy = with_gap(tmp_path, rows("x,y,z,gap", x, 0 * x, z, np.sin(3 * x) * np.cos(2 * z)))
    found = gap_at_nodes(given(wavy), plane())
    expected = np.sin(3 * points[:, 0]) * np.cos(2 * points[:, 2])
    assert found == pytest.approx(expected, abs=0.25 / count)


def test_points_on_two_lines_are_no_surface(tmp_path: Path) -> None:
    x, z = (each.ravel() for each in np.meshgrid([-1.0, 0, 1], [-0.5, 0.5]))
    case = with_gap(tmp_path, rows("x,y,z,gap", x, 0 * x, z, x))
    with pytest.raises(CaseError, match="on three lines or more"):
        gap_at_nodes(given(case), plane(3))


def test_waves_that_elements_do_not_have_are_measured(tmp_path: Path) -> None:
    arc = np.linspace(-2, 2, 4001)
    case = with_gap(tmp_path, rows("arc,gap", arc, np.cos(20 * np.pi * arc)))
    # 41 nodes at .1, on the crests of waves of that length: all of the range is missed.
    assert gap_missed(given(case), line()) == pytest.approx(1.0, abs=1e-3)
    assert gap_missed(given(case), line(1601)) < 0.01
    none = np.zeros(41, dtype=bool)
    assert gap_missed(given(case), line(), none) == 0.0
    smooth = with_gap(tmp_path, rows("arc,gap", arc, arc**2))
    assert gap_missed(given(smooth), line()) < 0.001


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("height,arc\n0,1\n", "column 'gap'"),
        ("gap\n0\n", "expected a column arc, or columns x and y (and z), found none"),
        ("arc,x,gap\n0,1,0\n", "found arc and x"),
        ("arc,gap\n1,0\n0,0\n", "column 'arc': expected a value after 1"),
        ("arc,gap\n0,a\n", "line 2, column 'gap'"),
        ("arc,gap\nmm,um\n-2,0\n2,0\n", "expected gap in mm, found gap in um"),
        ("arc,gap [um]\n-2,0\n2,0\n", "expected gap in mm, found gap in um"),
    ],
)
def test_wrong_files_are_refused_before_meshing(tmp_path: Path, text: str, expected: str) -> None:
    with pytest.raises(CaseError) as error:
        build_history(with_gap(tmp_path, text))
    assert "contacts.main.gap: " in str(error.value)
    assert expected in str(error.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("arc,gap\n-1,0\n1,0\n", "over the whole surface, arc lengths -2 to 2, found them from -1"),
        ("x,y,gap\n-2,0,0\n-1.9,0,0\n", "expected points over the whole surface"),
        ("x,y,z,gap\n0,0,0,0\n", "expected the columns x, y, found x, y, z"),
    ],
)
def test_gaps_that_do_not_cover_a_surface_are_refused(
    tmp_path: Path, text: str, expected: str
) -> None:
    with pytest.raises(CaseError) as error:
        gap_at_nodes(given(with_gap(tmp_path, text)), line())
    assert expected in str(error.value)


def test_a_surface_that_turns_far_is_refused(tmp_path: Path) -> None:
    angle = np.linspace(-1.4, 1.4, 30)
    ring = np.column_stack([np.sin(angle), np.cos(angle)])
    frames = np.stack([ring, ring[:, ::-1] * [1, -1]], axis=1)
    surface = ContactSurface(angle, ring, frames, np.full(30, 0.1))
    case = with_gap(tmp_path, rows("x,y,gap", ring, 0 * angle))
    with pytest.raises(CaseError, match="turns farther: divide the contact"):
        gap_at_nodes(given(case), surface)
