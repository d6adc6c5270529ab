# SPDX-License-Identifier: LGPL-3.0-or-later
"""Values given at points: what they are in between and outside, and files that are refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import blocks
import numpy as np
import pytest
from pad_cases import HOLD, STEEL, pad, press

from fretfe._typing import Array
from fretfe.bodies.definition import define_model, require_above_absolute_zero
from fretfe.bodies.point_values import PointValues, read_points
from fretfe.case import check_dimension, load_case, parse_case
from fretfe.case.reading import case_text
from fretfe.errors import CaseError
from fretfe.idealise import obstacles
from fretfe.loads import build_history
from fretfe.mesh.mesh import Mesh

RANDOM = np.random.default_rng(5)


def linear(points: Array) -> Array:
    return np.asarray(3.0 + points @ np.array([2.0, -1.0, 0.5])[: points.shape[1]])


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("dimension", [2, 3])
def test_linear_values_are_met_between_scattered_points(dimension: int, unit: float) -> None:
    corners = np.stack(np.meshgrid(*[[0.0, 1.0]] * dimension), axis=-1).reshape(-1, dimension)
    points = np.concatenate([corners, RANDOM.random((40, dimension))])
    values = PointValues(unit * points, linear(points))
    # corners and sides are on the hull, for which round-off must not count
    places = np.concatenate([corners, corners / 2, RANDOM.random((100, dimension))])
    np.testing.assert_allclose(values.at(unit * places), linear(places), atol=1e-8)
    assert values.outside(unit * places)[1] == pytest.approx(0.0, abs=1e-9)


def test_points_on_a_line_or_plane_count_across_it() -> None:
    line = PointValues(np.array([[3.0, 1.0], [1.0, 1.0], [2.0, 1.0]]), np.array([5.0, 1.0, 2.0]))
    places = np.array([[1.5, -7.0], [2.5, 1.0], [3.02, 9.0]])
    np.testing.assert_allclose(line.at(places), [1.5, 3.5, 5.0])
    assert line.outside(places)[0] == 2
    assert line.outside(places)[1] == pytest.approx(0.02)
    plane = np.array([[0, 0, 1.0], [1, 0, 1.0], [0, 1, 1.0], [1, 1, 1.0]])
    flat = PointValues(plane, linear(plane))
    np.testing.assert_allclose(
        flat.at(np.array([[0.2, 0.3, -4.0]])), linear(np.array([[0.2, 0.3, 1.0]]))
    )
    same = PointValues(np.zeros((1, 3)), np.array([7.0]))
    np.testing.assert_array_equal(same.at(plane), 7.0)
    assert same.outside(1e6 * plane)[1] == 0


def test_outside_of_the_points_the_hull_counts() -> None:
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    values = PointValues(square, square[:, 0])
    places = np.array([[1.0, 1.0], [2.02, 1.0], [1.0, 5.0]])
    np.testing.assert_allclose(values.at(places), [1.0, 2.0, 1.0], rtol=1e-8)
    assert values.outside(places) == (2, pytest.approx(3.0))
    assert values.outside(places[:2]) == (1, pytest.approx(0.02))


def test_read_points(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("node;T;x;y;z\n1;20,5;0;0;1\n2;30;1;0,5;1\n")
    found = read_points(path, 2, "T")
    np.testing.assert_array_equal(found.points, [[0, 0], [1, 0.5]])
    np.testing.assert_array_equal(found.values, [20.5, 30])


BAD_FILES = {
    "empty": ("", "expected a header row with the column names, found an empty file"),
    "no rows": ("x,y,T\n", "expected rows of numbers below the header, found none"),
    "one point": ("x,y,T\n0,0,20\n", "expected at least 2 points, found 1"),
    "column": ("x,y,t\n0,0,1\n", "expected one column 'T', found 'x', 'y', 't'"),
    "two columns": ("x,y,T,T\n0,0,1,1\n", "expected one column 'T'"),
    "nan": ("x,y,T\n0,0,20\n1,0,nan\n", "line 3, column 'T': expected a finite number"),
    "place": ("x,y,T\n0,inf,20\n1,0,3\n", "line 2, column 'y': expected a finite number"),
    "text": ("x,y,T\n0,0,20\n1,0,warm\n", "line 3, column 'T': expected a finite number"),
    "cell": ("x,y,T\n0,0,20\n1,0\n", "line 3, column 'T': expected a finite number, found an"),
    "twice": (
        "x,y,T\n0,0,20\n1,0,3\n0,0,4\n",
        "line 4, column 'x': expected a point of its own, not that of line 2 again, found 0",
    ),
    "cold": ("x,y,T\n-9,-9,-300\n9,9,20\n", "line 2, column 'T': expected a number >= -273.15"),
    "elsewhere": (
        "x,y,T\n0,5,20\n1,5,3\n1,6,4\n",
        "loads.heat: expected points that reach as far as the body 'upper', whose node at (0, 0)",
    ),
}


def warm(**load: Any) -> dict[str, Any]:
    body = {**STEEL, "expansion": 1e-5, "reference_temperature": 20.0}
    own = {"type": "temperature", "history": [{"ramp": 1.0, "until": 1.0, "steps": 2}], **load}
    return pad(bodies={"upper": body, "lower": {**body}}, loads={"press": press(), "heat": own})


def mesh() -> Mesh:
    upper = blocks.block("upper", [0, 1, 2], [0, 1])
    return Mesh({"upper": upper, "lower": blocks.block("lower", [0, 1, 2], [-1, 0])})


@pytest.mark.parametrize(("text", "expected"), BAD_FILES.values(), ids=BAD_FILES)
def test_bad_files(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "t.csv").write_text(text)
    case = parse_case(_named(warm(file="t.csv")), tmp_path / "case.toml")
    with pytest.raises(CaseError, match=re.escape(expected)):
        define_model(case, mesh())


def _named(data: dict[str, Any]) -> dict[str, Any]:
    """The names of the boundaries of `mesh`."""
    contact = {**data["contacts"]["main"], "surface1": "upper_bottom", "surface2": "lower_top"}
    return {**data, "contacts": {"main": contact}}


def test_missing_file_and_folder(tmp_path: Path) -> None:
    for file, found in (("none.csv", "found nothing at"), (".", "found a folder")):
        case = parse_case(_named(warm(file=file)), tmp_path / "case.toml")
        with pytest.raises(CaseError, match=found):
            define_model(case, mesh())


KEYS: dict[str, tuple[dict[str, Any], str]] = {
    "nothing": ({}, "loads.heat: expected exactly one of 'value', 'points', 'file', found none"),
    "both": ({"value": 1.0, "file": "t.csv"}, "found 'value' and 'file'"),
    "cold": ({"value": -274.0}, "loads.heat.value: expected a number >= -273.15, found -274"),
    "nan": ({"value": float("nan")}, "loads.heat.value: expected a finite number"),
    "text": ({"value": "warm"}, "loads.heat.value: expected a number, found text 'warm'"),
    "one": ({"points": [[0, 0]], "values": [1]}, "loads.heat.points: expected"),
    "count": (
        {"points": [[0, 0], [1, 0]], "values": [1]},
        "expected as many values as points, found 2 points and 1 values",
    ),
    "no values": ({"points": [[0, 0], [1, 0]]}, "found 2 points and none values"),
    "alone": ({"value": 1.0, "values": [1]}, "expected 'values' with 'points' only"),
    "mixed": ({"points": [[0, 0], [1, 0, 0]], "values": [1, 2]}, "points of 2 coordinates or of 3"),
    "twice": ({"points": [[0, 0], [0, 0]], "values": [1, 2]}, "expected every point once"),
    "cold point": (
        {"points": [[0, 0], [0, 1]], "values": [1, -500]},
        "loads.heat.values[item 2]: expected a number >= -273.15, found -500",
    ),
    "body": (
        {"value": 1.0, "bodies": ["middle"]},
        "loads.heat.bodies[item 1]: expected one of the bodies 'upper', 'lower', found 'middle'",
    ),
    "no body": ({"value": 1.0, "bodies": []}, "loads.heat.bodies: expected"),
    "unknown": ({"value": 1.0, "direction": "x"}, "loads.heat.direction: unknown key"),
}


@pytest.mark.parametrize(("keys", "expected"), KEYS.values(), ids=KEYS)
def test_bad_keys(keys: dict[str, Any], expected: str) -> None:
    with pytest.raises(CaseError, match=re.escape(expected)):
        parse_case(warm(**keys))


def test_bodies_must_be_able_to_expand() -> None:
    data = warm(value=100.0)
    del data["bodies"]["lower"]["expansion"]
    with pytest.raises(CaseError, match=r"missing: bodies\.lower\.expansion"):
        parse_case(data)
    data["loads"]["heat"]["bodies"] = ["upper"]
    assert parse_case(data).loads["heat"].type == "temperature"
    data["bodies"]["upper"]["reference_temperature"] = -280.0
    with pytest.raises(CaseError, match=r"upper\.reference_temperature: .* \(absolute zero"):
        parse_case(data)


def test_points_must_fit_the_mesh() -> None:
    case = parse_case(warm(points=[[0, 0, 0], [1, 1, 1]], values=[1, 2]))
    with pytest.raises(CaseError, match=r"loads\.heat\.points\[item 1\]: expected 2 components"):
        check_dimension(case, 2)


def test_a_history_below_absolute_zero_is_refused() -> None:
    data = _named(warm(value=100.0))
    data["loads"]["heat"]["history"] = [HOLD, {"ramp": -3.0, "until": 2.0, "steps": 1}]
    case = parse_case(data)
    definition, history = define_model(case, mesh()), build_history(case)
    with pytest.raises(CaseError, match=r"heat\.history: expected temperatures >= .* found -300"):
        data["loads"]["heat"]["history"][1]["ramp"] = -4.0
        cold = parse_case(data)
        require_above_absolute_zero(cold, definition, build_history(cold))
    require_above_absolute_zero(case, definition, history)


def test_files_are_found_from_elsewhere(tmp_path: Path) -> None:
    case = parse_case(warm(file="t.csv"), tmp_path / "case.toml")
    written = tmp_path / "other.toml"
    written.write_text(case_text(case))
    load = load_case(written).loads["heat"]
    assert load.type == "temperature" and load.file == str(tmp_path / "t.csv")


def test_half_planes_have_no_temperature() -> None:
    (reason,) = (each for each in obstacles(parse_case(warm(value=100.0))) if "heat" in each)
    assert reason.endswith("found a temperature (everywhere)")


def test_other_values_are_another_problem(tmp_path: Path) -> None:
    digests = []
    for value in ("20", "21", "20"):
        (tmp_path / "t.csv").write_text(f"x,y,T\n-9,-9,{value}\n9,9,30\n-9,9,30\n9,-9,30\n")
        case = parse_case(_named(warm(file="t.csv")), tmp_path / "case.toml")
        digests.append(define_model(case, mesh()).digest)
    assert digests[0] == digests[2] != digests[1]


def pulled(**keys: Any) -> dict[str, Any]:
    """A pressure on a side of the upper body of `mesh`."""
    own = {
        "type": "traction",
        "boundary": "upper_right",
        "direction": "normal",
        "history": [{"ramp": -5.0, "until": 1.0, "steps": 2}],
        **keys,
    }
    return _named(pad(loads={"press": press(), "p": own}))


TRACTIONS: dict[str, tuple[str, dict[str, Any], str]] = {
    "column": (
        "x,y,p\n0,0,1\n2,1,2\n",
        {},
        "loads.p.file: {}: line 1: expected one column 'value'",
    ),
    "empty": ("", {}, "loads.p.file: {}: expected a header row"),
    "nan": ("x,y,value\n0,0,1\n2,1,nan\n", {}, "line 3, column 'value': expected a finite number"),
    "elsewhere": (
        "x,y,value\n2,0,1\n2,0.5,2\n",
        {},
        "loads.p: expected points that reach as far as the boundary 'upper_right', whose node at "
        "(2, 1) is farther from their middle by 200 %",
    ),
    "both": (
        "",
        {"points": [[2, 0], [2, 1]], "values": [1, 2]},
        "loads.p: expected one of 'points' and 'file', found both",
    ),
}


@pytest.mark.parametrize(("text", "keys", "expected"), TRACTIONS.values(), ids=TRACTIONS)
def test_bad_tractions(tmp_path: Path, text: str, keys: dict[str, Any], expected: str) -> None:
    path = tmp_path / "p.csv"
    path.write_text(text)
    with pytest.raises(CaseError, match=re.escape(expected.format(path))):
        define_model(parse_case(pulled(file="p.csv", **keys), tmp_path / "case.toml"), mesh())


def test_tractions_at_points() -> None:
    data = pulled(points=[[2, 0], [2, 1]], values=[1, 2])
    (load,) = define_model(parse_case(data), mesh()).loads
    assert load.at_points is not None
    np.testing.assert_allclose(load.at_points.at(np.array([[2.0, 0.25]])), 1.25)
    (reason,) = (
        each for each in obstacles(parse_case(pad(loads=data["loads"]))) if "loads.p:" in each
    )
    assert reason.endswith("expected a uniform traction, found values at points")
    with pytest.raises(CaseError, match=r"loads\.p\.value: unknown key"):
        parse_case(pulled(value=3.0))
