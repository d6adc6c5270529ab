# SPDX-License-Identifier: LGPL-3.0-or-later
"""Values given at points: what they are in between and outside, and files that are refused."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.pad_cases import HOLD, STEEL, pad, press

from fretfe._typing import Array
from fretfe.bodies.definition import define_model, require_possible
from fretfe.bodies.loads.spread import Force, Traction
from fretfe.bodies.point_values import PointValues, read_points
from fretfe.case import TemperatureLoad, check_dimension, load_case, parse_case
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
    found = read_points(path, 2, ["T"], {})
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
        require_possible(cold, definition, build_history(cold))
    require_possible(case, definition, history)


def test_files_are_found_from_elsewhere(tmp_path: Path) -> None:
    case = parse_case(warm(file="t.csv"), tmp_path / "case.toml")
    written = tmp_path / "other.toml"
    written.write_text(case_text(case))
    load = load_case(written).loads["heat"]
    assert isinstance(load, TemperatureLoad) and load.file == str(tmp_path / "t.csv")


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
    assert isinstance(load, Traction) and load.factors is not None
    np.testing.assert_allclose(load.factors.at(np.array([[2.0, 0.25]])), 1.25)
    (reason,) = (
        each for each in obstacles(parse_case(pad(loads=data["loads"]))) if "loads.p:" in each
    )
    assert reason.endswith("expected a uniform traction, found values at points")
    with pytest.raises(CaseError, match=r"loads\.p\.value: unknown key"):
        parse_case(pulled(value=3.0))


def moved(**keys: Any) -> dict[str, Any]:
    """A shape of the right side of the upper body of `mesh`, on x = 2."""
    history = [{"ramp": 5.0, "until": 1.0, "steps": 2}]
    own = {"type": "shape", "boundary": "upper_right", "history": history, **keys}
    return _named(pad(loads={"press": press(), "mode": own}))


SHAPES: dict[str, tuple[str, str]] = {
    "column": ("x,y,ux,vy\n2,0,1,1\n2,1,2,1\n", "line 1: expected one column 'uy', found 'x',"),
    "no rows": ("# none\nx,y,ux,uy\n", "expected rows of numbers below the header, found none"),
    "all skipped": ("#x,y,ux,uy\n#2,0,1,1\n", "expected a header row"),
    "nan": ("# c\nx,y,ux,uy\n2,0,1,1\n2,1,nan,1\n", "line 4, column 'ux': expected a finite"),
    "twice": ("x,y,ux,uy\n2,0,1,1\n2,0,1,2\n", "line 3, column 'x': expected a point of its own"),
    "elsewhere": (
        "x,y,ux,uy\n0,0,1,1\n2,0.5,0,1\n1,1,1,1\n",
        "loads.mode: expected points that reach as far as the boundary 'upper_right', whose node",
    ),
    "another line": (
        "x,y,ux,uy\n1,0,1,1\n1,1,0,1\n",
        "loads.mode: expected points on both sides of the boundary 'upper_right', or on it, found "
        "all of them on one line or plane, from which its node at (2, 0) is away by 100 % of",
    ),
    "nearly twice": (
        "x,y,ux,uy\n2,0,1,1\n2,1,0,1\n2,1.0000000000001,5,5\n",
        "loads.mode: expected points of their own, found (2, 1) twice, up to round-off",
    ),
    "at rest": (
        "x,y,ux,uy\n2,0,0,0\n2,1,0,0\n",
        "loads.mode: expected a shape that moves the boundary 'upper_right', found no displacement",
    ),
    "metres": (
        "x,y,ux,uy\n0.002,0,1,1\n0.002,0.001,0,1\n",
        "found all of them on one line or plane",
    ),
}


@pytest.mark.parametrize(("text", "expected"), SHAPES.values(), ids=SHAPES)
def test_bad_shapes(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "p.csv").write_text(text)
    with pytest.raises(CaseError, match=re.escape(expected)):
        define_model(parse_case(moved(file="p.csv"), tmp_path / "case.toml"), mesh())


SHAPE_KEYS: dict[str, tuple[dict[str, Any], str]] = {
    "nothing": ({}, "loads.mode: expected one of 'points' and 'file', found none"),
    "components": (
        {"points": [[2, 0], [2, 1]], "values": [[1, 1], [1, 1, 1]]},
        "loads.mode: expected displacements with 2 components, as the points have, found 3",
    ),
    "numbers": ({"points": [[2, 0], [2, 1]], "values": [1, 2]}, "loads.mode.values[item 1]"),
    "factor": ({"file": "p.csv", "factor": 0}, "loads.mode.factor: expected a number > 0"),
    "direction": ({"file": "p.csv", "direction": "x"}, "loads.mode.direction: unknown key"),
    "platen": (
        {"file": "p.csv", "boundary": "upper_top"},
        "loads.mode.boundary: expected a boundary that is not a platen, found 'upper_top'",
    ),
    "contact": (
        {"file": "p.csv", "boundary": "lower_top"},
        "loads.mode.boundary: expected a boundary that is no contact surface, found 'lower_top'",
    ),
}


@pytest.mark.parametrize(("keys", "expected"), SHAPE_KEYS.values(), ids=SHAPE_KEYS)
def test_bad_keys_of_shapes(keys: dict[str, Any], expected: str) -> None:
    with pytest.raises(CaseError, match=re.escape(expected)):
        parse_case(moved(**keys))


def test_a_shape_moves_all_components() -> None:
    data = moved(file="p.csv")
    data["supports"]["side"] = {"boundary": "upper_right", "fix": ["y"]}
    with pytest.raises(CaseError, match=r"mode\.boundary: expected a free component, found 'y' of"):
        parse_case(data)


def push(**keys: Any) -> dict[str, Any]:
    history = [{"ramp": 5.0, "until": 1.0, "steps": 2}]
    own = {"type": "force", "boundary": "upper_right", "direction": "x", "history": history}
    return _named(pad(loads={"press": press(), "f": {**own, **keys}}))


def test_forces() -> None:
    (load,) = define_model(parse_case(push(centre=[2.1, 0.5], radius=0.2)), mesh()).loads
    assert load == Force("f", "upper_right", (1.0, 0.0), (2.1, 0.5), 0.2)
    # Next to the middle of the facet, but not so that points of integration must be within it.
    far = parse_case(push(centre=[2.2, 0.5], radius=0.1))
    with pytest.raises(
        CaseError, match=r"loads\.f\.radius: expected at least 0\.26, .* well within it, found 0\.1"
    ):
        define_model(far, mesh())
    with pytest.raises(
        CaseError, match="expected 'centre' and 'radius', or none of them, found 'c"
    ):
        parse_case(push(centre=[2.1, 0.5]))
    with pytest.raises(CaseError, match=r"loads\.f\.radius: expected a number > 0"):
        parse_case(push(centre=[2.1, 0.5], radius=0))
    with pytest.raises(CaseError, match=r"loads\.f\.centre: expected 2 components on this mesh"):
        check_dimension(parse_case(push(centre=[2, 0.5, 0], radius=1)), 2)


def test_points_of_a_grid() -> None:
    """Eight of them on one sphere, everywhere, of which Qhull alone makes minutes of merging."""
    lines = np.linspace(0, 1, 60)
    points = np.stack(np.meshgrid(lines[:10], lines, lines, indexing="ij"), axis=-1).reshape(-1, 3)
    places = points.min(axis=0) + np.ptp(points, axis=0) * np.random.default_rng(0).random((500, 3))
    places[0] = points[-1]
    slopes = np.array([1.0, 2.0, -3.0])
    begin = time.process_time()
    found = PointValues(points, points @ slopes).at(places)
    assert time.process_time() - begin < 20.0
    np.testing.assert_allclose(found, places @ slopes, atol=1e-7)
    assert np.median(np.abs(found - places @ slopes)) < 1e-13
