# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coefficients of friction over time and along surfaces."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import PAD, pad

from fretfe._typing import Array
from fretfe.case import Case, case_notes, parse_case
from fretfe.errors import CaseError
from fretfe.loads import build_history
from fretfe.loads.friction import Coefficients, read_coefficients
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.friction import Friction, require_covered


def with_friction(friction: Any, folder: Path = Path()) -> Case:
    main = {**PAD["contacts"]["main"], "friction": friction}
    return parse_case(pad(contacts={"main": main}), source=folder / "pad.toml")


def in_file(folder: Path, text: str) -> Case:
    (folder / "f.csv").write_text(text)
    return with_friction({"csv": "f.csv"}, folder)


def given(case: Case) -> Coefficients:
    return read_coefficients(case, "main")


def surface(points: Any) -> ContactSurface:
    points = np.array(points, dtype=float)
    count = len(points)
    return ContactSurface(points[:, 0], points, np.zeros((count, 2, 2)), np.ones(count))


def fields(case: Case, points: Any, times: Any = (0.5, 2.0)) -> Array:
    require_covered(given(case), surface(points))
    return Friction.of(given(case), np.array(times), surface(points)).at(slice(None))


LINE = [[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]]


def test_over_time_it_is_that_at_the_end_of_each_step() -> None:
    case = with_friction({"times": [0, 1, 3], "values": [0.1, 0.2, 0.6]})
    found = given(case).over(np.array([0.5, 1.0, 2.0, 3.0]))
    assert np.array_equal(found, [0.0, 0.0, 0.4, 0.6])  # none until friction_from
    assert np.array_equal(fields(case, LINE), [[0.0] * 3, [0.4] * 3])


def test_units_in_the_header_are_those_of_the_case(tmp_path: Path) -> None:
    rows = "\n0, .1\n3, .4\n"
    plain = given(in_file(tmp_path, "time,friction" + rows)).over(np.array([1.0, 3.0]))
    units = in_file(tmp_path, "time [s], friction [-]" + rows)
    assert np.array_equal(given(units).over(np.array([1.0, 3.0])), plain)
    other = in_file(tmp_path, "arc [m];friction\n-9;.1\n9;.4\n")
    with pytest.raises(CaseError, match="expected arc in mm, found arc in m"):
        given(other)


def test_over_arc_lengths_there_are_straight_lines() -> None:
    case = with_friction({"arc": [-1, 1], "values": [0.2, 0.6]})
    assert np.allclose(fields(case, LINE), np.array([[0, 0, 0], [0.2, 0.4, 0.6]]), rtol=1e-15)


def test_files_are_over_what_their_columns_are(tmp_path: Path) -> None:
    case = in_file(tmp_path, "time,friction\n0,0.1\n3,0.7\n")
    assert given(case).over(np.array([2.0])) == pytest.approx(0.5)
    case = in_file(tmp_path, "arc;friction\n-1;0,2\n1;0,6\n")
    assert np.allclose(fields(case, LINE)[1], [0.2, 0.4, 0.6])
    case = in_file(tmp_path, "x,y,friction\n-1,0.1,0.2\n0.1,0,0.3\n0.9,0,0.5\n")
    assert np.array_equal(fields(case, LINE)[1], [0.2, 0.3, 0.5])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "friction\n0.3\n",
            "expected a column time, a column pressure, a column temperature, a column arc, or "
            "columns x and y (and z)",
        ),
        ("time,arc,friction\n0,1,0.3\n", "found time and arc"),
        ("time,friction\n0,0.1\n3,-0.7\n", "line 3, column 'friction': expected a coefficient >="),
        ("arc,friction\n0,0.1\n0,0.7\n", "column 'arc': expected a value after 0"),
    ],
)
def test_wrong_files_are_refused_before_meshing(tmp_path: Path, text: str, expected: str) -> None:
    with pytest.raises(CaseError) as error:
        build_history(in_file(tmp_path, text))
    assert expected in str(error.value)
    assert "contacts.main.friction.csv" in str(error.value)


def test_times_cover_the_steps_with_friction() -> None:
    build_history(with_friction({"times": [1, 3], "values": [0.1, 0.2]}))
    with pytest.raises(CaseError, match=r"from 1, .* to 3, the end .* found times from 1 to 2.5"):
        build_history(with_friction({"times": [1, 2.5], "values": [0.1, 0.2]}))


@pytest.mark.parametrize(
    ("text", "points", "expected"),
    [
        ("arc,friction\n-1,0.1\n0.5,0.7\n", LINE, "arc lengths -1 to 1, found them from -1 to 0.5"),
        (
            "x,y,friction\n-1,0,0.2\n-0.5,0,0.3\n0,0,0.5\n",
            LINE,
            r"none nearer to (1, 0) than 1, where points are up to 0.5 apart",
        ),
        (
            "x,y,z,friction\n-1,0,0,0.2\n1,0,0,0.2\n",
            LINE,
            "expected the columns x, y, found x, y, z",
        ),
        ("arc,friction\n-1,0.1\n1,0.7\n", [[0.0, 0.0, 0.0]], "expected places x, y and z"),
    ],
)
def test_a_table_covers_the_surface(tmp_path: Path, text: str, points: Any, expected: str) -> None:
    with pytest.raises(CaseError) as error:
        fields(in_file(tmp_path, text), points)
    assert expected in str(error.value)
    assert "pad.toml: contacts.main.friction:" in str(error.value)


@pytest.mark.parametrize(
    ("friction", "expected"),
    [
        (-0.1, "friction: expected a number >= 0, found -0.1"),
        ("rough", "friction: expected a number, found text 'rough'"),
        ({"time": [0, 1], "values": [0, 1]}, "did you mean 'times'"),
        ({"times": [0, 1], "values": [0.1]}, "expected as many values as times, 2, found 1"),
        ({"arc": [0, 0], "values": [0.1, 0.2]}, "found 0 followed by 0 (items 1 and 2)"),
        ({"arc": [0, 1], "values": [0.1, -0.2]}, "values[item 2]: expected a number >= 0"),
        (
            {"csv": "f.csv", "column": "f"},
            "column: unknown key, expected one of 'csv', 'separator'",
        ),
    ],
)
def test_nonsense_is_refused_with_its_place(friction: Any, expected: str) -> None:
    with pytest.raises(CaseError) as error:
        with_friction(friction)
    assert expected in str(error.value)


def test_more_friction_than_is_measured_is_doubted() -> None:
    assert not case_notes(with_friction(2.0))
    assert "contacts.main.friction: 12 is more" in str(case_notes(with_friction(12.0)))
    table = {"arc": [-3, 3], "values": [0.1, 4]}
    assert "contacts.main.friction: 4 is more" in str(case_notes(with_friction(table)))


def test_states_that_differ_are_found() -> None:
    one = Friction(np.array([[0.1, 0.2], [0.3, 0.3]]), np.array([0, 1, 1, 0]))
    other = Friction(np.array([[0.3, 0.3], [0.1, 0.2]]), np.array([1, 0, 1, 0]))
    assert list(one.differs(other)) == [False, False, True, True]
