# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles in which P and Q are out of phase: loops of slip that close just where older slip ended.

P rises by `RISE` without shear, Q rises, P falls, Q falls. Places that P covers take f dP, those
that have slipped back before 2 f dP: forward slip comes to `FRONT` while P is largest. As P falls,
it goes on to just where slip comes backward; round-off must not choose what is told.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, problem, solved

import fretfe
from fretfe.case import parse_case

RISE, SHEAR = 0.25, 0.3
CORNERS = np.array([[1 - RISE, 0], [1, 0], [1, SHEAR], [1 - RISE, SHEAR], [1 - RISE, 0]])
FRONT = (1 - RISE - (SHEAR - RISE) / 2) * LOAD
LONGEST = HERTZ.half_width(LOAD) - HERTZ.half_width(FRONT)
RANGE = 2 * FRICTION * (LOAD - FRONT) / (math.pi * math.sqrt(2 * HERTZ.half_width(LOAD)))


@pytest.mark.parametrize("parts", [1, 5, 12])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_loops_that_close_at_an_older_front(parts: int, way: float) -> None:
    numbers = np.arange(4 * 3 + 1)
    places = np.linspace(0, numbers[-1], numbers[-1] * parts + 1)
    corners = np.vstack([CORNERS[:1], *[CORNERS[1:]] * 3])
    p, q = (np.interp(places, numbers, each) for each in corners.T)
    given = problem(p * LOAD, way * q * LIMIT, cycle=4 * parts)
    for edge in solved(given).stations:
        assert edge.equivalent_range == pytest.approx(RANGE, rel=1e-3)
        zone = edge.longest_zone
        assert zone is not None
        assert zone.length == pytest.approx(LONGEST, abs=zone.spread)
        assert zone.prediction == pytest.approx(LONGEST, rel=3e-3)
        assert zone.spread < 0.02 * LONGEST


def waves(steps: int) -> dict[str, Any]:
    """P = 600 + 200 cos, Q = 60 + 60 sin on a cylinder, a quarter of a turn apart."""
    top = {"type": "platen", "boundary": "upper_top", "control": "force"}
    wave = {"wave": "sine", "period": 1, "cycles": 3, "steps_per_cycle": steps}
    press = [
        {"ramp": -800.0, "until": 1, "steps": 5},
        wave | {"amplitude": 200, "mean": -600, "phase": 270},
    ]
    shear = [
        {"ramp": 60.0, "until": 1, "steps": 5},
        wave | {"amplitude": 60, "mean": 60, "phase": 0},
    ]
    sizes = dict.fromkeys(("upper_width", "upper_height", "lower_width", "lower_height"), 120)
    body = {"young": 210e3, "poisson": 0.3}
    contact = {"surface1": "upper_contact", "surface2": "lower_contact", "friction": 0.4}
    return {
        "geometry": {
            "template": "cylinder",
            "parameters": {"upper_radius": 50, "lower_radius": 0, "size": 0.01, **sizes},
        },
        "bodies": {"upper": body, "lower": body},
        "contacts": {"main": contact},
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
        "loads": {
            "press": {**top, "direction": "y", "history": press},
            "shear": {**top, "direction": "x", "history": shear},
        },
    }


def test_waves_out_of_phase_tell_the_same_with_any_steps() -> None:
    """By superposition with 3 000 states a cycle: d .1168 at the longest, f K_N d 54.36 then."""
    for steps in (5, 16):
        result = fretfe.run(parse_case(waves(steps)), backend="halfplane")
        for edge in result.contacts[0].stations:
            assert edge.equivalent_range == pytest.approx(54.36, rel=2e-3)
            zone = edge.longest_zone
            assert zone is not None
            assert zone.length == pytest.approx(0.1168, abs=zone.spread + 0.0001)
            assert zone.spread < 0.03 * zone.length
