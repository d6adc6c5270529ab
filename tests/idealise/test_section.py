# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case of a section: what acts on solids, by the axes of their plane and per length."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import pad

from fretfe.case import Case, Solid, parse_case
from fretfe.errors import CaseError
from fretfe.idealise.section import section_case
from fretfe.mesh.sections import Sweep

# The plane x' = y, y' = z is swept along x, from -3 to 7 with the upper body from -1.
AXES = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
SOLID = Solid(length=10.0, layers=5, spans={"upper": (2.0, 10.0)})
SWEEP = Sweep(np.array([-3.0, 0.0, 0.0]), AXES, SOLID, {})
RAMP = [{"ramp": -1.0, "until": 1.0, "steps": 1}]
HELD = {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}}
PRESS = {"type": "platen", "boundary": "upper_top", "control": "force", "history": RAMP}


def solids(supports: dict[str, Any] = HELD, **loads: dict[str, Any]) -> Case:
    given = {"press": PRESS | {"direction": "z"}, **loads}
    geometry = {"template": "cylinder", "parameters": {}}
    edges = {"tolerance": 0.1, "stations": 20}
    tables = {"geometry": geometry, "supports": supports, "loads": given, "edges": edges}
    return parse_case(pad(cycle={"more": 3}, **tables))


def test_forces_are_per_shared_length_along_the_axes_of_the_plane() -> None:
    pull = {"type": "traction", "boundary": "lower_left", "history": RAMP, "direction": [0, -3, 4]}
    found = section_case(solids(pull=pull), SWEEP)
    assert found.model.thickness == 8.0
    assert found.loads["press"].along == "y"
    assert found.loads["pull"].along == pytest.approx((-0.6, 0.8), abs=1e-6)
    assert found.supports["base"].fix == ("x", "y")
    assert found.edges.tolerance == 0.1
    assert found.cycle.more is None  # those are for solids alone


def test_places_and_axes_are_those_of_the_plane() -> None:
    tilt = {"type": "tilt", "boundary": "upper_top", "control": "moment", "history": RAMP}
    found = section_case(solids(tilt=tilt | {"axis": "x", "centre": [1.0, 2.0, 3.0]}), SWEEP)
    (place,) = found.loads["tilt"].places.values()
    assert place == pytest.approx((2.0, 3.0))
    assert found.loads["tilt"].about == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("support", "fix", "direction"),
    [
        ({"fix": ["x"]}, None, None),
        ({"fix": ["x", "z"]}, ("y",), None),
        ({"direction": [0.0, 0.0, -1.0]}, ("y",), None),
        ({"direction": [0.0, 3.0, 4.0]}, (), (0.6, 0.8)),
    ],
)
def test_supports_hold_in_the_plane(
    support: dict[str, Any], fix: tuple[str, ...] | None, direction: tuple[float, float] | None
) -> None:
    found = section_case(solids(HELD | {"more": {"boundary": "lower_left", **support}}), SWEEP)
    if fix is None:
        assert "more" not in found.supports
        return
    assert found.supports["more"].fix == fix
    assert found.supports["more"].direction == (direction and pytest.approx(direction, abs=1e-6))


def test_supports_along_two_lines_askew_are_none_of_a_plane_case() -> None:
    turned = np.array([[0.0, 0.6, 0.8], [0.0, -0.8, 0.6], [1.0, 0.0, 0.0]])
    with pytest.raises(CaseError, match=r"supports\.more\.fix"):
        section_case(
            solids(HELD | {"more": {"boundary": "lower_left", "fix": ["y", "z"]}}),
            replace(SWEEP, axes=turned),
        )


def test_a_force_along_the_sweep_moves_the_section_that_way_and_what_holds_it_stays() -> None:
    drag = {"type": "traction", "boundary": "upper_left", "history": RAMP, "direction": "x"}
    found = section_case(solids(drag=drag), SWEEP)
    assert found.loads["drag"].along == "z"
    assert set(found.supports["base"].fix) == {"x", "y", "z"}
    assert found.components(2) == 3
