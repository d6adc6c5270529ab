# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that are possible each for itself, and not together."""

from __future__ import annotations

from typing import Any

import pytest
from cases import blocks
from cases.pad_cases import pad, press

from fretfe.bodies.definition import define_model, require_possible
from fretfe.case import parse_case
from fretfe.errors import CaseError
from fretfe.loads import build_history
from fretfe.mesh.mesh import Mesh


def heat(until: float = 1.0, **keys: Any) -> dict[str, Any]:
    return {"type": "temperature", "history": [{"ramp": 1.0, "until": until, "steps": 1}], **keys}


def require(**loads: dict[str, Any]) -> None:
    """Check loads of bodies with a reference temperature of 20 degrees."""
    data = pad(loads={"press": press(), **loads})
    contact = {**data["contacts"]["main"], "surface1": "upper_bottom", "surface2": "lower_top"}
    warm = {"expansion": 1e-5, "reference_temperature": 20.0, "density": 8e-9}
    bodies = {name: {**body, **warm} for name, body in data["bodies"].items()}
    case = parse_case({**data, "contacts": {"main": contact}, "bodies": bodies})
    upper = blocks.block("upper", [0, 0.5, 1], [0, 1])
    mesh = Mesh({"upper": upper, "lower": blocks.block("lower", [0, 1, 2], [-1, 0])})
    require_possible(case, define_model(case, mesh), build_history(case))


def test_temperatures_below_absolute_zero_by_two_loads_together() -> None:
    """20 - 150 - 150 = -280 degrees; each alone gives -130."""
    cold = heat(value=-130.0)
    require(one=cold)
    require(one=cold, other=heat(value=-120.0))
    expected = r"found -280 in the body 'lower' at time 2 by one and other together, .* from 20$"
    with pytest.raises(CaseError, match=expected):
        require(one={**cold, "bodies": ["lower"]}, other=heat(2.0, value=-130.0))


def test_temperatures_of_other_bodies_do_not_add_up() -> None:
    cold = heat(value=-200.0)
    require(one={**cold, "bodies": ["lower"]}, other={**cold, "bodies": ["upper"]})


def test_temperatures_at_points_are_added_at_each_of_them() -> None:
    """Cold on the left by one load and on the right by the other is not cold anywhere by both."""
    sides = [[0, 0], [2, 0]]
    left, right = ([[*point] for point in sides] for _ in range(2))
    require(one=heat(points=left, values=[-250, 20]), other=heat(points=right, values=[20, -250]))
    with pytest.raises(CaseError, match="found -520 in the body"):
        require(one=heat(points=left, values=[-250, 20]), other=heat(value=-250.0))


def test_two_speeds_at_once_are_refused() -> None:
    """Forces would add up to those of the root of the sum of squares, not of the sum."""
    spin = {"type": "rotation", "centre": [0, 0]}
    ramp = {"ramp": 5.0, "until": 1.0, "steps": 1}
    first = [ramp, {"ramp": 0.0, "until": 2.0, "steps": 1}]
    one = {**spin, "history": first}
    later = [{"hold": True, "until": 2.0, "steps": 2}, {"ramp": 7.0, "until": 3.0, "steps": 1}]
    require(one=one, other={**spin, "history": later})
    with pytest.raises(CaseError, match=r"rotation at a time, found one and other at time 0\.25: "):
        require(one=one, other={**spin, "history": [ramp]})
