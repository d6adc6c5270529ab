# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-plane problems for tests: Hertz with a = p0 = 1 at P = pi/2, histories from arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.analytic.profiles import Hertz, Profile
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.step_ends import at_step_ends
from fretfe.halfplane import HalfPlaneOutcome, solve_half_planes
from fretfe.idealise import HalfPlaneProblem
from fretfe.loads import History

HERTZ = Hertz(radius=50.0, e_star=100.0)
LOAD, FRICTION = np.pi / 2, 0.5
LIMIT = FRICTION * LOAD
PRESS_STEPS = 5


def problem(
    normal: ArrayLike,
    shear: ArrayLike = 0.0,
    moment: ArrayLike = 0.0,
    tension: ArrayLike = 0.0,
    *,
    profile: Profile = HERTZ,
    friction: float = FRICTION,
    frictional_press: bool = False,
    cycle: int = 0,
) -> HalfPlaneProblem:
    """Loads (n,) after the pad has been pressed on, by the first normal load alone.

    Args:
        normal, shear, moment, tension: loads.
        profile: of the pad.
        friction: coefficient.
        frictional_press: whether friction acts meanwhile too; the other loads then rise with the
            normal load.
        cycle: number of steps of the evaluated cycle, the last ones; 0 for none.
    """
    loads = np.broadcast_arrays(*np.atleast_1d(normal, shear, moment, tension))
    ramp = np.linspace(0.0, 1.0, PRESS_STEPS + 1)
    others = ramp if frictional_press else 0.0 * ramp
    p, q, m, s = (
        np.concatenate([factor * load[0], load]).astype(float)
        for factor, load in zip((ramp, others, others, others), loads, strict=True)
    )
    count = len(p)
    coefficient = np.full(count, friction)
    if not frictional_press:
        coefficient[: PRESS_STEPS + 1] = 0.0
    evaluated = (count - 1 - cycle, count - 1) if cycle else None
    history = History(("loads",), np.arange(count) / 1.0, np.zeros((count, 1)), evaluated)
    return HalfPlaneProblem("main", "pad", "block", profile, history, coefficient, p, q, m, s)


def loop(steps: int = 60, cycles: int = 3) -> Array:
    """(steps * cycles + 1,) angles of whole cycles."""
    return np.linspace(0.0, 2 * np.pi * cycles, steps * cycles + 1)


def started(values: Array) -> Array:
    """A loop with a ramp from zero to its first value, after the press."""
    return np.concatenate([np.linspace(0.0, 1.0, 7)[:-1] * values[0], values])


def solved(
    given: HalfPlaneProblem, elements: int = 300, reference_length: float | None = None
) -> Contact:
    return evaluated(solve_half_planes(given, elements), reference_length)


def evaluated(outcome: HalfPlaneOutcome, reference_length: float | None = None) -> Contact:
    assert outcome.failure is None
    units = outcome.unit_factors
    contacts = evaluate(outcome.solution, units, reference_length=reference_length)
    return at_step_ends(outcome.solution, contacts)[1][0]
