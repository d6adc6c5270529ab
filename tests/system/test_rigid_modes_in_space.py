# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solids that are not held are told along which direction or about which axis they can move."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases import blocks

from fretfe.bodies.definition import define_model
from fretfe.bodies.rigid_modes import held_model, modes_restrained_by_contact
from fretfe.case import Case, Solid, parse_case
from fretfe.errors import ModelError
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh

Tables = dict[str, Any]


def square(name: str, start: float) -> BodyMesh:
    lines = np.linspace(0, 1, 3), np.linspace(start, start + 1, 3)
    return blocks.block(name, *lines, cell="quadrilateral")


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    """A cube from (0, 0, 0) to (1, 1, 1) on another one."""
    plane = Mesh({"upper": square("upper", 0.0), "lower": square("lower", -1.0)})
    return extrude(plane, Solid(length=1.0, layers=1))


def case(loads: Tables, supports: Tables) -> Case:
    steel = {"young": 2e5, "poisson": 0.3}
    surfaces = {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.3}
    return parse_case(
        {
            "geometry": {"file": "m.msh"},
            "bodies": {"upper": steel, "lower": steel},
            "contacts": {"main": surfaces},
            "loads": loads,
            "supports": supports,
        }
    )


def fix(boundary: str, axes: str) -> Tables:
    return {"boundary": f"upper_{boundary}", "fix": list(axes)}


def roller(boundary: str, degrees: float) -> Tables:
    """Holds along a direction that is turned from x towards y."""
    angle = np.radians(degrees)
    direction = [float(np.cos(angle)), float(np.sin(angle)), 0.0]
    return {"boundary": f"upper_{boundary}", "direction": direction}


def platen(direction: Any, control: str = "force") -> Tables:
    history = [{"ramp": -1.0, "until": 1.0, "steps": 1}]
    load = {"type": "platen", "boundary": "upper_top", "direction": direction}
    return {**load, "control": control, "history": history}


def tilt(axis: Any, centre: tuple[float, ...]) -> Tables:
    load = {"type": "tilt", "boundary": "upper_top", "axis": axis, "centre": list(centre)}
    return {**load, "control": "moment", "history": [{"hold": True, "until": 1.0}]}


DOWN = platen("y", "displacement")


@pytest.mark.parametrize(
    ("loads", "supports", "motion"),
    [
        pytest.param({}, {}, "to move in every direction and to turn", id="nothing"),
        pytest.param({}, {"a": fix("top", "yz")}, "to move along x", id="slide"),
        pytest.param(
            {}, {"a": fix("top", "y")}, "to move along x and z and to turn about y", id="on a plane"
        ),
        pytest.param(
            {},
            {"a": fix("top", "x"), "b": fix("left", "yz")},
            "to turn about z through (0, 1, 0.5)",
            id="hinge",
        ),
        pytest.param(
            {},
            {"a": fix("top", "x"), "b": fix("left", "y")},
            "to move along z and to turn about z through (0, 1, 0.5)",
            id="hinge that slides",
        ),
        pytest.param(
            {},
            {"a": fix("top", "z"), "b": roller("right", 30.0)},
            "to move along (-0.577, 1, 0)",
            id="inclined roller",
        ),
        pytest.param({"p": platen([1, 1, 0])}, {}, "to move along (1, 1, 0)", id="force"),
        pytest.param(
            {"p": platen("y"), "t": tilt("y", (0.5, 0.0, 0.5))},
            {},
            "to move along y and to turn about y through (0.5, 0.5, 0.5)",
            id="force and moment along one axis",
        ),
        pytest.param(
            {"p": platen("y"), "t": tilt("x", (0.0, 3.0, 1.0))},
            {},
            "to move along y and to turn about x",
            id="force and moment",
        ),
        pytest.param(
            {"p": DOWN, "t": tilt([1, 1, 0], (0.5, 1.0, 0.5))},
            {},
            "to turn about (1, 1, 0) through (0.25, 0.75, 0.5)",
            id="inclined axis",
        ),
        pytest.param(
            {"p": DOWN} | {axis: tilt(axis, (1.0, 2.0, 3.0)) for axis in "xyz"},
            {},
            "to turn about every axis through (1, 2, 3)",
            id="ball joint",
        ),
        pytest.param(
            {"p": DOWN, "t": tilt("x", (1.0, 2.0, 3.0)), "u": tilt("z", (0.0, 2.0, 0.0))},
            {},
            "to turn about x and z through (0, 2, 3)",
            id="universal joint",
        ),
        pytest.param(
            {"p": DOWN, "t": tilt("x", (1.0, 2.0, 3.0)), "u": tilt("z", (0.0, 1.0, 0.0))},
            {},
            "to turn about x through (0.5, 2, 3) and about z through (0, 1, 0.5)",
            id="axes apart",
        ),
    ],
)
def test_free_motions_are_told(mesh: Mesh, loads: Tables, supports: Tables, motion: str) -> None:
    free = case(loads, supports)
    found = modes_restrained_by_contact(define_model(free, mesh), mesh)
    assert found["upper"] == motion
    with pytest.raises(ModelError, match="nothing holds 'lower' and 'upper': even if") as caught:
        held_model(free, mesh)
    forced = [name for name, load in loads.items() if load["control"] != "displacement"]
    assert str(caught.value).endswith(f": {', '.join(forced)}." if forced else "rotation.")


def test_a_body_that_holds_the_other_one(mesh: Mesh) -> None:
    definition = held_model(case({}, {"a": fix("top", "xyz")}), mesh)
    assert list(modes_restrained_by_contact(definition, mesh)) == ["lower"]


def test_both_bodies_hold_a_part(mesh: Mesh) -> None:
    """The one is held along y and against turning about x and z, the other one along z."""
    supports = {"a": {"boundary": "lower_bottom", "fix": ["y"]}, "b": fix("top", "z")}
    with pytest.raises(ModelError, match=r"they would be free to move along x\. Expected supports"):
        held_model(case({}, supports), mesh)
