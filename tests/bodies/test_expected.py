# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts that loads do not press together, by equilibrium alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases import blocks, sectors

from fretfe.bodies.expected import pulled_off, require_pressed
from fretfe.case import Case, parse_case
from fretfe.errors import ModelError
from fretfe.loads import History, build_history
from fretfe.mesh.mesh import Mesh


def loaded(
    press: list[dict[str, Any]], push: float = 0.0, **tables: Any
) -> tuple[Case, Mesh, History]:
    """A block on a larger one that is held, under a pressure and a push along x."""
    top = {"type": "traction", "boundary": "upper_top"}
    case = parse_case(
        {
            "geometry": {"file": "none.msh"},
            "bodies": {name: {"young": 200.0, "poisson": 0.3} for name in ("upper", "lower")},
            "contacts": {
                "seat": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.5}
            },
            "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
            "loads": {
                "press": {**top, "direction": [0, -1], "history": press},
                "push": {**top, "direction": [1, 0], "history": sectors.ramp(push)},
            },
            **tables,
        }
    )
    upper = blocks.block("upper", [0.0, 0.5, 1.0], [0.0, 0.5])
    lower = blocks.block("lower", [-1.0, 0.0, 1.0, 2.0], [-1.0, 0.0])
    return case, Mesh({"upper": upper, "lower": lower}), build_history(case)


def steps(*ends: float) -> list[dict[str, Any]]:
    return [{"ramp": end, "until": time, "steps": 2} for time, end in enumerate(ends, start=1)]


@pytest.mark.parametrize("push", [0.0, 10.0])
@pytest.mark.parametrize(
    ("end", "found"),
    [(0.0, "found that P is 0 all the time, as nothing"), (-2.0, "apart all the time, by up to 2")],
)
def test_loads_that_never_press(push: float, end: float, found: str) -> None:
    with pytest.raises(ModelError, match=f"contact seat: expected loads that press .*{found}"):
        require_pressed(*loaded(steps(end), push))


def test_loads_that_press_at_some_time_and_pull_off_later() -> None:
    case, mesh, history = loaded(steps(3.0, -1.0))
    require_pressed(case, mesh, history)
    told = [pulled_off(case, mesh, history, state) for state in range(len(history.times))]
    # P is 0, 1.5, 3, 1, -1 by then
    assert [bool(each) for each in told] == [True, False, False, False, True]
    assert told[-1].startswith("By equilibrium P of contact seat is -1 at t = 2: nothing keeps")


def test_a_body_that_a_support_holds_needs_no_pressure() -> None:
    held = {name: {"boundary": f"{name}_right", "fix": ["x", "y"]} for name in ("upper", "lower")}
    case, mesh, history = loaded(steps(0.0), supports=held)
    require_pressed(case, mesh, history)
    assert not np.any([pulled_off(case, mesh, history, state) for state in (0, 1)])
