# SPDX-License-Identifier: LGPL-3.0-or-later
"""Patch tests: uniform stress and rigid motions pass through non-matching interfaces unchanged.

All exact solutions lie in the spaces, so that only round-off remains: 1e-10 of the pressure or, for
rigid motions, of Young's modulus.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import Run, ramp, run

from fretfe._typing import Array
from fretfe.mesh.mesh import BodyMesh

ANGLE = 37.0
WIDTH, PRESSURE = 2.0, 3.0
EXACT = 1e-10

KINDS = [("triangle", 1), ("triangle", 2), ("quadrilateral", 1), ("quadrilateral", 2)]
ELEMENTS = pytest.mark.parametrize(("cell", "degree"), KINDS)
# Those of one kind on two ranks too.
SHARED_ELEMENTS = pytest.mark.parametrize(
    ("cell", "degree"), [pytest.param("triangle", 2, marks=pytest.mark.mpi), *KINDS[::2], KINDS[3]]
)
SIDES = pytest.mark.parametrize("side", ["surface1", "surface2"])


def turned_blocks(angle: float, cell: str, order: int = 1) -> tuple[BodyMesh, BodyMesh]:
    """Two rectangles with a flat interface, turned together."""
    turn = blocks.rotated(angle)
    x1, x2 = blocks.graded(0.0, WIDTH, 4), blocks.graded(0.0, WIDTH, 7, 0.8)
    upper = blocks.block("upper", x1, [0.0, 0.3, 0.8], cell=cell, order=order, mapping=turn)
    lower = blocks.block("lower", x2, [-1.0, -0.4, 0.0], cell=cell, order=order, mapping=turn)
    return upper, lower


def split_box(angle: float, cell: str) -> tuple[BodyMesh, BodyMesh]:
    """An upright box [0, 2] x [-1.5, 1.5] cut by an inclined interface."""
    slope = np.tan(np.radians(angle))

    def lower_map(points: Array) -> Array:
        height = 1.5 + slope * (points[:, 0] - WIDTH / 2)
        return np.stack([points[:, 0], -1.5 + points[:, 1] * height], axis=1)

    def upper_map(points: Array) -> Array:
        height = 1.5 - slope * (points[:, 0] - WIDTH / 2)
        return np.stack([points[:, 0], 1.5 - (1 - points[:, 1]) * height], axis=1)

    x1, x2 = blocks.graded(0.0, WIDTH, 4), blocks.graded(0.0, WIDTH, 7, 0.8)
    y = [0.0, 0.4, 1.0]
    upper = blocks.block("upper", x1, y, cell=cell, mapping=upper_map)
    lower = blocks.block("lower", x2, y, cell=cell, mapping=lower_map)
    return upper, lower


def make_case(side: str, degree: int, friction: float, **tables: Any) -> dict[str, Any]:
    bodies = {"upper": {"young": 200.0, "poisson": 0.3}, "lower": {"young": 70.0, "poisson": 0.2}}
    contact = {
        "surface1": "upper_bottom",
        "surface2": "lower_top",
        "friction": friction,
        "multipliers": side,
    }
    model = {"plane": "strain", "degree": degree}
    return {"model": model, "bodies": bodies, "contacts": {"main": contact}, **tables}


def side_pressures(ratio1: float, ratio2: float) -> dict[str, Any]:
    """Pressure on the sides that keeps a pressed body from becoming wider."""
    return {
        f"{body}_{side}": {
            "type": "traction",
            "boundary": f"{body}_{side}",
            "direction": "normal",
            "history": ramp(-ratio * PRESSURE),
        }
        for body, ratio in (("upper", ratio1), ("lower", ratio2))
        for side in ("left", "right")
    }


def platen(name: str, direction: Any, control: str, value: float) -> dict[str, Any]:
    return {
        "type": "platen",
        "boundary": name,
        "direction": direction,
        "control": control,
        "history": ramp(value),
    }


def top_load(kind: str, direction: Array) -> dict[str, Any]:
    if kind == "platen":
        return platen("upper_top", direction.tolist(), "force", PRESSURE * WIDTH)
    return {
        "type": "traction",
        "boundary": "upper_top",
        "direction": "normal",
        "history": ramp(-PRESSURE),
    }


BASE = {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}


def assert_uniform(solved: Run, pressure: float, shear: float, stress: dict[str, Array]) -> None:
    """Nodal tractions, and the stress everywhere in both bodies, at the last step."""
    expected = np.broadcast_to([pressure, shear], solved.tractions[-1].shape)
    np.testing.assert_allclose(solved.tractions[-1], expected, rtol=0, atol=EXACT * pressure)
    np.testing.assert_allclose(solved.tractions[0], expected / 2, rtol=0, atol=EXACT * pressure)
    found = solved.stress(len(solved.steps) - 2 if solved.steps else 1)
    for body in found:  # those of this rank
        assert_stress(found[body], stress[body], EXACT * pressure)


def assert_stress(found: Array, expected: Array, tolerance: float) -> None:
    expected = np.broadcast_to(expected, found.shape)
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance)


@SIDES
@ELEMENTS
@pytest.mark.parametrize("angle", [0.0, ANGLE], ids=["flat", "inclined"])
@pytest.mark.parametrize(
    ("load", "friction"), [("platen", 0.0), ("platen", 0.4), ("traction", 0.4)]
)
def test_constant_pressure(
    load: str, friction: float, angle: float, cell: str, degree: int, side: str
) -> None:
    """Bodies of different materials, each kept from becoming wider by pressure on its sides."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    normal, tangent = np.array([-s, c]), np.array([c, s])
    ratios = {"upper": 0.3 / 0.7, "lower": 0.2 / 0.8}
    loads = {"press": top_load(load, -normal), **side_pressures(*ratios.values())}
    solved = run(
        make_case(side, degree, friction, supports=BASE, loads=loads),
        *turned_blocks(angle, cell),
    )
    stress = {
        body: -PRESSURE * (np.outer(normal, normal) + ratio * np.outer(tangent, tangent))
        for body, ratio in ratios.items()
    }
    assert_uniform(solved, PRESSURE, 0.0, stress)


@SIDES
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("degree", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_constant_pressure_on_meshes_of_order_2(degree: int, cell: str, side: str) -> None:
    """The same facets with a middle node."""
    ratios = {"upper": 0.3 / 0.7, "lower": 0.2 / 0.8}
    loads = {
        "press": top_load("platen", np.array([0.0, -1.0])),
        **side_pressures(*ratios.values()),
    }
    solved = run(
        make_case(side, degree, 0.4, supports=BASE, loads=loads), *turned_blocks(0, cell, 2)
    )
    stress = {body: -PRESSURE * np.diag([ratio, 1.0]) for body, ratio in ratios.items()}
    assert_uniform(solved, PRESSURE, 0.0, stress)


@SIDES
@SHARED_ELEMENTS
@pytest.mark.parametrize("angle", [ANGLE, -ANGLE])
@pytest.mark.parametrize("load", ["platen", "traction"])
def test_constant_pressure_and_shear_inside_the_cone(
    load: str, angle: float, cell: str, degree: int, side: str
) -> None:
    """An inclined stuck interface does not disturb a box that is pressed from above."""
    ratio = 0.3 / 0.7
    stress = -PRESSURE * np.diag([ratio, 1.0])
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    normal, tangent = np.array([-s, c]), np.array([c, s])
    pressure, shear = -normal @ stress @ normal, tangent @ stress @ normal
    loads = {"press": top_load(load, np.array([0.0, -1.0])), **side_pressures(ratio, ratio)}
    data = make_case(side, degree, 1.2 * abs(shear) / pressure, supports=BASE, loads=loads)
    data["bodies"]["lower"] = data["bodies"]["upper"]
    solved = run(data, *split_box(angle, cell))
    assert abs(shear) > 0.3 * pressure
    assert np.sign(shear) == -np.sign(angle)
    assert_uniform(solved, pressure, shear, {"upper": stress, "lower": stress})


def translation(kind: str) -> dict[str, Any]:
    """Both bodies moved by (0.03, -0.02): tops and bottoms, all components."""
    loads = {}
    for boundary in ("upper_top", "lower_bottom"):
        for axis, value in (("x", 0.03), ("y", -0.02)):
            load = platen(boundary, axis, "displacement", value)
            if kind == "displacement":
                load = {**load, "type": "displacement"}
                del load["control"]
            loads[f"{boundary}_{axis}"] = load
    return loads


def rotation(angle: float) -> dict[str, Any]:
    """Infinitesimal rotation about the origin: a vertical side moves by angle * x along y, a
    horizontal one by -angle * y along x."""
    motions = {
        ("upper_left", "y"): 0.0,
        ("upper_right", "y"): angle * WIDTH,
        ("lower_left", "y"): 0.0,
        ("lower_right", "y"): angle * WIDTH,
        ("upper_top", "x"): -angle * 1.5,
        ("lower_bottom", "x"): angle * 1.5,
    }
    return {
        f"{boundary}_{axis}": {
            "type": "displacement",
            "boundary": boundary,
            "direction": axis,
            "history": ramp(value),
        }
        for (boundary, axis), value in motions.items()
    }


@SIDES
@ELEMENTS
@pytest.mark.parametrize(
    "loads",
    [translation("platen"), translation("displacement"), rotation(0.01)],
    ids=["platens", "displacements", "rotation"],
)
@pytest.mark.parametrize("angle", [0.0, ANGLE], ids=["flat", "inclined"])
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_rigid_motion_of_both_bodies_gives_no_traction(
    friction: float, angle: float, loads: dict[str, Any], cell: str, degree: int, side: str
) -> None:
    solved = run(make_case(side, degree, friction, loads=loads), *split_box(angle, cell))
    np.testing.assert_allclose(solved.tractions, 0.0, atol=EXACT * 200.0)
    found = solved.stress(1)
    if "upper" in found:  # on this rank
        assert_stress(found["upper"], np.zeros((2, 2)), EXACT * 200.0)


@SHARED_ELEMENTS
def test_rigid_motion_keeps_the_tractions_of_pressed_bodies(cell: str, degree: int) -> None:
    """Press and shear by displacements (not uniform), then move everything together."""
    hold = {"hold": True, "until": 1.0}
    segments = {
        ("upper_top", "x"): ([{"ramp": 0.006, "until": 1.0, "steps": 3}], 0.006),
        ("upper_top", "y"): ([{"ramp": -0.02, "until": 1.0, "steps": 3}], -0.02),
        ("lower_bottom", "x"): ([hold], 0.0),
        ("lower_bottom", "y"): ([hold], 0.0),
    }
    move = {"x": 0.3, "y": -0.2}
    loads = {
        f"{boundary}_{axis}": {
            **platen(boundary, axis, "displacement", 0.0),
            "history": [*first, {"ramp": value + move[axis], "until": 2.0, "steps": 3}],
        }
        for (boundary, axis), (first, value) in segments.items()
    }
    solved = run(make_case("finer", degree, 0.4, loads=loads), *split_box(ANGLE, cell))
    pressed, moved = solved.tractions[2], solved.tractions[-1]
    scale = np.abs(pressed).max()
    assert scale > 0.5
    # Displacements ten times those of the contact: one digit of round-off is lost.
    np.testing.assert_allclose(moved, pressed, rtol=0, atol=EXACT * scale)


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("direction", "guide", "label"),
    [
        ([0.0, -1.0], [1.0, 0.0], "upper_top guide x"),
        ([0.6, -0.8], [0.8, 0.6], "upper_top guide (0.8, 0.6)"),
    ],
    ids=["axis", "slanted"],
)
def test_loaded_platen_is_guided(direction: list[float], guide: list[float], label: str) -> None:
    """It moves along its load only and does not turn; the guide takes the force across."""
    force = 4.0
    load = platen("upper_top", direction, "force", force)
    data = make_case("finer", 2, 1.5, supports=BASE, loads={"press": load})
    solved = run(data, *turned_blocks(0.0, "triangle"))
    last = {name: values[-1] for name, values in solved.forces.items()}
    assert set(last) == {"press", label, "base x", "base y"}
    assert last["press"] == pytest.approx(force, rel=1e-12)
    on_platen = force * np.array(direction) + last[label] * np.array(guide)
    on_base = np.array([last["base x"], last["base y"]])
    np.testing.assert_allclose(on_platen, -on_base, rtol=0, atol=EXACT * force)
    motion = solved.displacement(1, "upper", lambda x: np.isclose(x[1], 0.8))
    assert np.abs(motion @ direction).min(initial=1.0) > 1e-3
    np.testing.assert_allclose(motion @ guide, 0.0, atol=EXACT)
    np.testing.assert_allclose(motion, motion[:1] + 0 * motion, rtol=0, atol=EXACT)
