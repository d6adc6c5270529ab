# SPDX-License-Identifier: LGPL-3.0-or-later
"""A mission of straight ramps tells the same however these are divided into steps.

Bodies are pressed to P/3 without shear and to P with three quarters of what friction takes, and
unloaded to nothing in proportion, which takes two thirds of that back: what is left makes places
beyond P/3 slip on, and most of them where P is 2/3.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, problem, solved

from fretfe.analytic.profiles import Wedge
from fretfe.evaluate.contacts import Station
from fretfe.evaluate.evaluate import evaluate
from fretfe.halfplane import solve_half_planes

CORNERS = np.array([[1 / 3, 0], [1, 0.5], [0, 0], [1 / 3, 0], [1, 0.5], [0, 0]])
# Slip zone where it is longest: the edge is at 2/3 of P, its inner end where that was at 1/3.
LONGEST = HERTZ.half_width(2 / 3 * LOAD) - HERTZ.half_width(LOAD / 3)
# Twice f K_I of what the edge stands on there: K_I of P is P over pi sqrt(2 a).
RANGE = 2 * FRICTION * LOAD / 3 / (math.pi * math.sqrt(2 * HERTZ.half_width(2 / 3 * LOAD)))
WEDGE = Wedge(slope=1e-3, e_star=1e5)
# P over that of a half-width of 1, and Q over what friction takes then.
PARTING = np.array([[0.97, -0.44], [0.71, -0.79], [0.32, 0.46], [0, 0], [0.53, -0.75], [1, -0.87]])


def edges_after(parts: int, tension: float = 0.0) -> tuple[Station, ...]:
    """Edges after the mission, twice, with some steps a ramp."""
    numbers = np.arange(len(CORNERS))
    places = np.linspace(0, numbers[-1], numbers[-1] * parts + 1)
    p, q = (np.interp(places, numbers, each) for each in CORNERS.T)
    given = problem(
        p * LOAD, q * LIMIT, 0.0, q * tension, frictional_press=True, cycle=3 * parts
    )  # fmt: skip
    return tuple(solved(given).stations)


@pytest.mark.parametrize("parts", [1, 2, 7])
def test_the_longest_zone_of_a_ramp_that_no_step_ends_with(parts: int) -> None:
    for edge in edges_after(parts):
        # A sixteenth of a sixteenth of P, and half of that as ranges turn round.
        assert edge.equivalent_range == pytest.approx(RANGE, rel=3e-3)
        zone = edge.longest_zone
        assert zone is not None
        # The root of nodes that is found is off by 1 % of the zone.
        assert zone.length < 1.01 * LONGEST < zone.length + zone.spread + 0.02 * LONGEST
        assert zone.spread < 0.06 * LONGEST


def test_with_tension_too() -> None:
    found = [[each.equivalent_range for each in edges_after(n, 0.2)] for n in (2, 3, 8)]
    assert found[0] == pytest.approx(found[2], rel=5e-3)
    assert found[1] == pytest.approx(found[2], rel=5e-3)
    assert found[0][0] != pytest.approx(found[0][1], rel=0.1)


@pytest.mark.parametrize("parts", [1, 5])
def test_cycles_in_proportion_slip_nowhere(parts: int) -> None:
    """Nodes that close within a step slip a little: no mesh has to resolve that."""
    loads = np.array([2, 1, 3, 1, 3]) / 3
    p = np.interp(np.linspace(0, 4, 4 * parts + 1), range(5), loads)
    given = problem(p * LOAD, p * LIMIT / 2, frictional_press=True, cycle=2 * parts)
    for edge in solved(given).stations:
        assert edge.equivalent_range == pytest.approx(0.0, abs=1e-9)
        zone = edge.longest_zone
        assert zone is not None
        assert (zone.length, zone.resolved) == (0.0, True)
        assert zone.spread < 0.02


@pytest.mark.parametrize("parts", [2, 30, 60])
def test_wedges_part_through_states_of_a_single_node(parts: int) -> None:
    numbers = np.arange(len(PARTING))
    places = np.linspace(0, numbers[-1], numbers[-1] * parts + 1)
    p, share = PARTING.T
    p, q = (np.interp(places, numbers, each) for each in (p, FRICTION * share * p))
    loads = WEDGE.e_star * WEDGE.slope * np.array([p, q])
    outcome = solve_half_planes(problem(*loads, profile=WEDGE))
    assert outcome.failure is None
    (contact,) = outcome.solution.contacts
    forces = contact.mean_traction[-1].T @ contact.surface.weights
    assert forces == pytest.approx(loads[:, -1], rel=1e-6)
    edges = evaluate(outcome.solution, outcome.unit_factors)[0].stations
    assert all(np.isfinite(zone.length) for edge in edges for zone in edge.slip_zones[-1:])
