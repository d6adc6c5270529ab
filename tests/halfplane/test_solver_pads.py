# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pads on blocks whose loads, or friction, change before or after what is evaluated."""

from __future__ import annotations

from typing import Any

import pytest
from cases.pad_cases import HOLD, PAD, TOP, pad, shear

import fretfe
from fretfe.case import parse_case
from fretfe.evaluate.verdicts import longest_verdict
from fretfe.reason import Kind
from fretfe.verdict import Verdict


@pytest.mark.parametrize("later", [[], [{"ramp": -60.0, "until": 4.0, "steps": 5}]])
def test_what_follows_the_cycle_does_not_change_how_edges_move(later: list[dict[str, Any]]) -> None:
    """A cylinder has (d2P/da2)/(dP/da) = 1/a: 1/.5754 under 600, and 1/.182 under 60."""
    press = [
        {"ramp": -600.0, "until": 1.0, "steps": 4},
        {"hold": True, "until": 3.0},
        *later,
    ]
    loads = {"press": {**TOP, "direction": "y", "history": press}, "shear": shear(60.0)}
    result = fretfe.run(parse_case(pad(loads=loads)), backend="halfplane")
    for station in result.contacts[0].stations:
        assert station.stiffening == pytest.approx(1 / 0.5754, rel=2e-3)


def test_friction_that_falls_leaves_a_slip_zone_unknown_to_factors() -> None:
    """Points slip as f falls from .6 to .25, though Q stays: d is .243, and not that under .6."""
    friction = {"times": [0, 2, 3], "values": [0.6, 0.6, 0.25]}
    main = {**PAD["contacts"]["main"], "friction": friction}
    press = [{"ramp": -600.0, "until": 1.0, "steps": 4}, {"hold": True, "until": 3.0, "steps": 5}]
    loads = {
        "press": {**TOP, "direction": "y", "history": press},
        "shear": {
            **TOP,
            "direction": "x",
            "history": [HOLD, {"ramp": 100.0, "until": 2.0, "steps": 10}],
        },
    }
    case = parse_case(pad(contacts={"main": main}, loads=loads))
    (contact,) = fretfe.run(case, backend="halfplane").contacts
    for station in contact.stations:
        (zone,) = station.slip_zones
        assert zone.unknown and station.longest_zone is zone
        assert longest_verdict(station).verdict is Verdict.UNKNOWN
        assert "coefficient falls" in longest_verdict(station).reason
    assert Kind.FRICTION_VARIES in {each.kind for each in contact.warnings}


def test_pressing_without_friction_does_not_hide_that_there_is_some() -> None:
    unload = [
        {"ramp": -600.0, "until": 1.0, "steps": 4},
        {"hold": True, "until": 2.0},
        {"ramp": -400.0, "until": 3.0, "steps": 10},
    ]
    slide = [HOLD, {"ramp": 150.0, "until": 2.0, "steps": 10}]
    loads = {
        "press": {**TOP, "direction": "y", "history": unload},
        "shear": {**TOP, "direction": "x", "history": slide},
    }
    (contact,) = fretfe.run(parse_case(pad(loads=loads)), backend="halfplane").contacts
    assert [station.friction for station in contact.stations] == [0.4, 0.4]
