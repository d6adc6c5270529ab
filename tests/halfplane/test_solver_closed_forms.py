# SPDX-License-Identifier: LGPL-3.0-or-later
"""The half-plane solution against closed forms, load case by load case."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, loop, problem, solved, started
from reference.closed_forms import ASYMPTOTE, EXACT, MODERATE, solve_closed_form

from fretfe._typing import Array
from fretfe.analytic.profiles import FlatRounded, Wedge
from fretfe.evaluate.contacts import Contact
from fretfe.idealise import HalfPlaneProblem

STEPS = 24
WEDGE, FLAT = Wedge(0.01, 100.0), FlatRounded(0.5, 20.0, 100.0)


def wave(size: float, degrees: float = 0.0) -> Array:
    return size * np.cos(loop(STEPS) - np.radians(degrees))


def steady(normal: Any, shear: Any, tension: Any = 0.0, **options: Any) -> HalfPlaneProblem:
    loads = [started(np.broadcast_to(load, 3 * STEPS + 1)) for load in (shear, tension)]
    normal = np.broadcast_to(normal, 3 * STEPS + 1)
    full = np.concatenate([np.full(6, normal[0]), normal])
    return problem(full, loads[0], 0.0, loads[1], cycle=STEPS, **options)


# Loads, the solution that the slip lengths should come from, and how well they agree with the
# half-plane solution: 0.001 a where both are exact, the error of the asymptote else.
CASES: dict[str, tuple[HalfPlaneProblem, str, float]] = {
    "Q": (steady(LOAD, wave(0.3 * LIMIT)), EXACT, 0.001),
    "Q about a mean": (steady(LOAD, 0.2 * LIMIT + wave(0.3 * LIMIT)), EXACT, 0.001),
    "Q under a constant tension": (
        steady(LOAD, wave(0.3 * LIMIT), 0.3 * FRICTION),
        EXACT,
        0.001,
    ),
    "wedge": (steady(WEDGE.load(1.0), wave(0.2), profile=WEDGE), EXACT, 0.001),
    "flat and rounded": (steady(FLAT.load(1.0), wave(0.3), profile=FLAT), EXACT, 0.001),
    "P in phase": (steady(LOAD + wave(0.25 * LOAD), wave(0.3 * LIMIT)), EXACT, 0.002),
    "P out of phase": (steady(LOAD + wave(0.25 * LOAD, 70), wave(0.3 * LIMIT)), EXACT, 0.002),
    "tension in phase": (
        steady(LOAD, wave(0.3 * LIMIT), wave(0.3 * FRICTION)),
        MODERATE,
        0.001,
    ),
    "tension in opposition": (
        steady(LOAD, wave(0.3 * LIMIT), wave(-0.3 * FRICTION)),
        MODERATE,
        0.001,
    ),
    "tension": (steady(LOAD, 0.0, wave(0.3 * FRICTION)), ASYMPTOTE, 0.002),
    "tension out of phase": (
        steady(LOAD, wave(0.15 * LIMIT), wave(0.3 * FRICTION, 60)),
        ASYMPTOTE,
        0.005,
    ),
    "P and tension": (
        steady(LOAD + wave(0.1 * LOAD), wave(0.2 * LIMIT), wave(0.1 * FRICTION)),
        ASYMPTOTE,
        0.03,
    ),
}


def inner_ends(summary: Contact) -> Array:
    return np.array([[z.border for z in edge.slip_zones[-2:]] for edge in summary.stations])


@pytest.mark.parametrize(("given", "solution", "tolerance"), CASES.values(), ids=CASES)
def test_steady_cycles(given: HalfPlaneProblem, solution: str, tolerance: float) -> None:
    closed, used = solve_closed_form(given)
    numerical = solved(given)
    assert solution in used
    assert inner_ends(closed) == pytest.approx(inner_ends(numerical), abs=tolerance)
    for mine, other in zip(closed.stations, numerical.stations, strict=True):
        assert [(z.start, z.end) for z in mine.slip_zones[-2:]] == [
            (z.start, z.end) for z in other.slip_zones[-2:]
        ]
        assert mine.position[-STEPS:] == pytest.approx(other.position[-STEPS:], abs=1e-3)
        assert mine.k_n[-1] == pytest.approx(other.k_n[-1], rel=5e-3)
        assert mine.k_t == pytest.approx(other.k_t, rel=1e-3, abs=2e-5)
        assert mine.k_i_range == pytest.approx(other.k_i_range, rel=1e-3, abs=1e-6)


FIRST: dict[str, tuple[HalfPlaneProblem, str, float]] = {
    "Q": (problem(LOAD, 0.4 * LIMIT * np.linspace(0.25, 1, 4)), EXACT, 0.001),
    "-Q": (problem(LOAD, -0.4 * LIMIT * np.linspace(0.25, 1, 4)), EXACT, 0.001),
    "Q and tension": (
        problem(LOAD, 0.4 * LIMIT * np.linspace(0.1, 1, 9), 0.0, np.linspace(0.02, 0.2, 9)),
        MODERATE,
        0.001,
    ),
    "-Q and tension": (
        problem(LOAD, -0.4 * LIMIT * np.linspace(0.1, 1, 9), 0.0, np.linspace(0.02, 0.2, 9)),
        MODERATE,
        0.001,
    ),
    "tension": (problem(LOAD, 0.0, 0.0, np.linspace(0.01, 0.1, 9)), ASYMPTOTE, 0.005),
}


@pytest.mark.parametrize(("given", "solution", "tolerance"), FIRST.values(), ids=FIRST)
def test_first_loading(given: HalfPlaneProblem, solution: str, tolerance: float) -> None:
    closed, used = solve_closed_form(given)
    numerical = solved(given)
    assert used == {solution}
    for mine, other in zip(closed.stations, numerical.stations, strict=True):
        length = mine.slip_zones[-1].length
        assert length == pytest.approx(other.slip_zones[-1].length, abs=tolerance)
        assert length > 0.02


def test_moment() -> None:
    given = problem(LOAD, 0.0, 0.2 * LOAD * np.sin(loop(STEPS)), cycle=STEPS)
    closed, _ = solve_closed_form(given)
    numerical = solved(given)
    for mine, other in zip(closed.stations, numerical.stations, strict=True):
        assert mine.position[6:] == pytest.approx(other.position[6:], abs=5e-3)
        assert mine.k_i_range == pytest.approx(other.k_i_range, rel=5e-3)
    assert closed.moment == pytest.approx(numerical.moment, abs=1e-3 * LOAD)
    # Hertz: K_I moves each edge with the contact, 2 dK_I/K_N = range of M/P
    k_n = float(closed.stations[0].k_n[-1])
    assert 2 * closed.stations[0].k_i_range / k_n == pytest.approx(0.4, rel=1e-6)


def test_friction_work() -> None:
    closed, _ = solve_closed_form(steady(LOAD, wave(0.3 * LIMIT)))
    fine = started(0.3 * LIMIT * np.cos(loop(200)))
    numerical = solved(problem(LOAD, fine, cycle=200))
    # first order in the step
    assert closed.dissipation == pytest.approx(numerical.dissipation, rel=0.01)


def test_no_friction_no_slip_zones() -> None:
    closed, used = solve_closed_form(problem(LOAD, friction=0.0))
    assert used == set() and [edge.slip_zones for edge in closed.stations] == [(), ()]
    assert closed.stations[0].k_n[-1] == pytest.approx(np.sqrt(2) * HERTZ.e_star / 100)
