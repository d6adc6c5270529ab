# SPDX-License-Identifier: LGPL-3.0-or-later
"""Unlike bodies whose edge P moves: half cycles as the slip of nodes turns round."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases.pad_cases import PAD, pad

from fretfe._typing import Array
from fretfe.case import parse_case
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.evaluate import evaluate
from fretfe.halfplane import solve_half_planes
from fretfe.history.solution import SLIP, Solution
from fretfe.idealise import idealise

PARAMETERS = {"upper_radius": 50.0, "lower_radius": 0.0, "size": 0.01}
SIZES = {"upper_width": 120.0, "upper_height": 120.0, "lower_width": 120.0, "lower_height": 120.0}
ALUMINIUM, STEEL = {"young": 70e3, "poisson": 0.3}, {"young": 210e3, "poisson": 0.3}


def out_of_phase(steps: int) -> tuple[Solution, Contact]:
    """A cylinder, beta of .2, with P and Q as waves a quarter of a period apart; all substates."""

    def wave(mean: float, amplitude: float, phase: float) -> list[dict[str, object]]:
        turn = {"wave": "sine", "mean": mean, "amplitude": amplitude, "phase": phase}
        start = mean + amplitude * np.sin(np.radians(phase))
        ramp: dict[str, object] = {"ramp": float(start), "until": 1.0, "steps": 4}
        return [ramp, turn | {"period": 1.0, "cycles": 2, "steps_per_cycle": steps}]

    top = {"type": "platen", "boundary": "upper_top", "control": "force"}
    case = pad(
        geometry={"template": "cylinder", "parameters": PARAMETERS | SIZES},
        bodies={"upper": ALUMINIUM, "lower": STEEL},
        contacts={"main": PAD["contacts"]["main"] | {"friction": 0.4, "friction_from": 0.0}},
        loads={
            "press": top | {"direction": "y", "history": wave(-600.0, 100.0, -90.0)},
            "shear": top | {"direction": "x", "history": wave(20.0, 60.0, 0.0)},
        },
    )
    outcome = solve_half_planes(idealise(parse_case(case)), 600)
    (contact,) = evaluate(outcome.solution, outcome.unit_factors)
    return outcome.solution, contact


def longest(solution: Solution, inward: int, position: Array) -> float:
    """Longest way from an edge to what has slipped since slip turned round, in the last cycle.

    What slips only where the edge has not been before has no part in that.
    """
    (history,) = solution.contacts
    arc, (first, last) = history.surface.arc, solution.cycle or (0, 0)
    found, inner, edge, way = 0.0, 0.0, math.inf, 0
    for state in range(first + 1, last + 1):
        slip = np.diff(history.slip[state - 1 : state + 1, :, 0], axis=0)[0]
        s = inward * (arc - position[state])
        own = (s > 0) & (s < 0.5) & (history.status[state] == SLIP)
        size = np.abs(np.where(own, slip, 0.0))
        if not size.max() > 1e-6:  # a hundredth of the largest
            continue
        now = int(np.sign(slip[size.argmax()]))
        place = float((inward * arc)[own & (size > 1e-2 * size.max())].max())
        inner = max(inner, place) if now == way and place > edge else place
        edge, way = inward * float(position[state]), now
        found = max(found, inner - edge)
    return found


@pytest.fixture(scope="module")
def by_nodes() -> list[float]:
    solution, contact = out_of_phase(30)
    return [longest(solution, each.inward, each.position) for each in contact.stations]


@pytest.mark.parametrize("steps", [6, 20, pytest.param(60, marks=pytest.mark.slow)])
def test_zones_are_told_where_they_are_longest(by_nodes: list[float], steps: int) -> None:
    """As far as nodes show, with any steps: .137 to .139; where K_T turns it is .08 to .09."""
    _, contact = out_of_phase(steps)
    for station, truth in zip(contact.stations, by_nodes, strict=True):
        zone = station.longest_zone
        assert zone is not None
        assert zone.resolved
        assert abs(zone.length - truth) < zone.spread + 0.003  # an element there
        assert zone.spread < 0.01 * zone.length
