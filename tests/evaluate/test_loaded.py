# SPDX-License-Identifier: LGPL-3.0-or-later
"""States in which a contact is loaded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, problem

from fretfe._typing import Array
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.increments import UnitFactors
from fretfe.evaluate.loaded import decisive_state, left_out, whole_sliding
from fretfe.halfplane import solve_half_planes
from fretfe.history.solution import OPEN, SLIP, ContactHistory, Solution

STATES = np.arange(6)
APPROACH = 0.01  # of the half-planes under LOAD, a^2/(2 R)


@pytest.mark.parametrize(
    ("force", "along", "decides"),
    [
        # both extremes of K_T: that with the larger P
        ([0, 80, 100, 90, 95, 100], [0, -5, 0, 5, 0, 0], 3),
        # bodies that touch again: K_T is largest and smallest at hardly any load
        ([0, 20, 100, 60, 30, 0], [0, -5, 0, 1, 5, 0], 2),
        # nothing but P varies
        ([0, 20, 100, 60, 30, 10], [0, 0, 0, 0, 0, 0], 2),
    ],
)
def test_the_state_that_decides(force: list[float], along: list[float], decides: int) -> None:
    found = decisive_state(
        np.array(force, dtype=float), np.array(along, dtype=float), STATES, STATES
    )
    assert found == decides


@pytest.mark.parametrize("share", [0.01, 0.1, 0.4])
def test_the_range_that_is_left_out_of_a_cylinder_pressed_and_sheared_in_proportion(
    share: float,
) -> None:
    """K_T grows with P^(3/4), from P = 0; states from a share of P on are known."""
    force = np.array([0.0, share, 1.0, share, 0.0])
    k_t = force**0.75
    found = left_out((0, 4), np.arange(1, 4), force) * np.ptp(k_t[1:4])
    assert found == pytest.approx(k_t.max() - np.ptp(k_t[1:4]), rel=1e-12)


@pytest.mark.parametrize(
    ("part", "slip", "counts"),
    [(1e-4, 6e-9, False), (1e-4, 1e-3, True), (1.0, 6e-9, True)],
)
def test_sliding_of_next_to_nothing_is_none(part: float, slip: float, counts: bool) -> None:
    """Two nodes slip under a part of P, and that is all there is in the cycle."""
    steps = LIMIT * np.array([0.0, 0.1, 0.2])
    solution = solve_half_planes(problem(np.full_like(steps, LOAD), steps), 60).solution
    (contact,) = solution.contacts
    status, moved, traction, gap = (
        np.array(each)
        for each in (contact.status, contact.slip, contact.mean_traction, contact.gap)
    )
    two, last = [30, 31], len(status) - 1
    status[last] = OPEN
    status[last, two] = SLIP
    moved[last] = moved[last - 1] + slip
    traction[last] *= part
    gap[last] = APPROACH
    found = replace(contact, status=status, slip=moved, mean_traction=traction, gap=gap)
    # of the cycle all slides in the second of two steps
    times = solution.times[last - 2 :]
    share, reach = whole_sliding(replace(solution, cycle=(last - 2, last)), found)
    expected = (times[2] - times[1]) / (times[2] - times[0]), slip
    assert (share, reach) == pytest.approx(expected if counts else (0.0, 0.0), rel=1e-9)


def test_a_last_state_too_small_for_factors_costs_no_range() -> None:
    """Q goes through half of its limit at constant P; at the end the bodies part with Q = 0."""
    shear = np.append(LIMIT * np.array([0.0, 0.5, 0.1, 0.4]), np.zeros(8))
    normal = LOAD * np.append(np.ones(4), np.geomspace(1.0, 0.1, 8))
    outcome = solve_half_planes(problem(normal, shear, frictional_press=True), 300)
    (contact,) = outcome.solution.contacts
    fewer, small = _parting(contact, nodes=9), len(contact.traction) - 2

    def units(solution: Solution, contact: ContactHistory, positions: Array) -> UnitFactors:
        found = outcome.unit_factors(solution, contact, positions)
        main = [np.array(each) for each in found.main]
        for each in main:
            each[small] = np.nan
        return replace(found, main=main)

    whole = replace(outcome.solution, contacts=(fewer,), cycle=(0, small + 1))
    (found,) = evaluate(whole, units)
    exact = 0.5 * LIMIT / (np.pi * np.sqrt(2.0))
    for edge in found.stations:
        assert np.isfinite(edge.k_t).all()
        assert abs(edge.k_range - exact) < edge.k_range_spread < 0.02 * exact


def _parting(contact: ContactHistory, nodes: int) -> ContactHistory:
    """A contact of so many nodes in its last state but one, and of none in the last one."""
    arc = contact.surface.arc
    half_width = np.sort(np.abs(arc))[nodes]
    pressure = half_width * np.sqrt(np.maximum(1 - (arc / half_width) ** 2, 0.0))
    traction, mean, status = (
        np.array(each) for each in (contact.traction, contact.mean_traction, contact.status)
    )
    for each in (traction, mean):
        each[-2:] = 0.0
        each[-2, :, 0] = pressure
    status[-2, pressure == 0] = status[-1] = OPEN
    return replace(contact, traction=traction, mean_traction=mean, status=status)
