# SPDX-License-Identifier: LGPL-3.0-or-later
"""Blocks of shear between which P falls: wherever the cycle begins or ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, evaluated, problem

from fretfe._typing import Array
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.loaded import with_own_cycle
from fretfe.halfplane import solve_half_planes

# P falls to a twentieth, Q goes to .5 and back to -.25 of its limit at full P.
STEPS = 4
P_BLOCK, Q_BLOCK = np.array([1.0, 1.0, 1.0, 0.05]), np.array([0.0, 0.5, -0.25, 0.0])
BLOCK = 4 * STEPS


def blocks(count: int) -> tuple[Array, Array]:
    """P and Q of some equal blocks, from P at its least on."""
    corners = np.arange(4 * count + 1)
    fine = np.linspace(0, 4 * count, BLOCK * count + 1)
    p, q = (
        np.append(first, np.tile(each, count)) for first, each in ((0.05, P_BLOCK), (0, Q_BLOCK))
    )
    return LOAD * np.interp(fine, corners, p), LIMIT * np.interp(fine, corners, q)


def contact(count: int, first: int, last: int) -> Contact:
    """The contact in the cycle from one state to another, counted in blocks of steps."""
    outcome = solve_half_planes(problem(*blocks(count)), 300)
    ends = outcome.solution.ends[-1 - BLOCK * count :]
    cycle = (int(ends[first]), int(ends[last]))
    return evaluated(replace(outcome, solution=replace(outcome.solution, cycle=cycle)))


@pytest.mark.parametrize(
    ("first", "length"), [(2, 1), (2.25, 1), (2.5, 1), (2.75, 1), (1, 2), (1.5, 2)]
)
def test_wherever_the_cycle_begins(first: float, length: int) -> None:
    """dK_T of Q at full P; slip as if from nothing, and back by half of the swing."""
    begin = round(first * BLOCK)
    found = contact(4, begin, begin + length * BLOCK)
    exact = 0.75 * LIMIT / (np.pi * np.sqrt(2.0))
    for edge in found.stations:
        assert abs(edge.k_range - exact) < 0.01 * exact
        lengths = sorted(zone.length for zone in edge.evaluated_zones)[-1 - length :: length]
        # Jaeger: forward as if from nothing, 1 - sqrt(1 - Q/fP); back by half of the swing
        expected = [1 - np.sqrt(1 - 0.75 / 2), 1 - np.sqrt(1 - 0.5)]
        np.testing.assert_allclose(lengths, expected, rtol=0.05)


def test_of_several_loaded_parts_that_with_the_largest_swing_of_q_counts() -> None:
    """The bodies part between three blocks, of which the middle one has the largest Q."""
    p, q = blocks(3)
    outcome = solve_half_planes(problem(p, q), 100)
    solution, (pair,) = outcome.solution, outcome.solution.contacts
    ends = solution.ends[-1 - 3 * BLOCK :]
    traction, mean = (np.array(each) for each in (pair.traction, pair.mean_traction))
    apart = ends[[BLOCK, 2 * BLOCK]]
    for each in (traction, mean):
        each[apart] = 0.0
        each[: apart[0], :, 1] *= 0.5
        each[apart[1] :, :, 1] *= 0.5
    pair = replace(pair, traction=traction, mean_traction=mean)
    whole = replace(solution, contacts=(pair,), cycle=(int(ends[0]), int(ends[-1])))
    assert with_own_cycle(whole, pair).cycle == (apart[0] + 1, apart[1] - 1)
