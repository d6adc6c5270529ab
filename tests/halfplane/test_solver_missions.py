# SPDX-License-Identifier: LGPL-3.0-or-later
"""Irregular loads that repeat themselves: the worst cycle against exact slip zones."""

from __future__ import annotations

import numpy as np
import pytest
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, problem, solved

from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.paths import rainflow
from fretfe.evaluate.contacts import Contact

COUNT = 24


def mission(seed: int) -> np.ndarray:
    """One repetition in -0.4 … 1; it begins and ends with zero, the last step is tiny."""
    values = np.random.default_rng(seed).uniform(-0.2, 0.8, COUNT)
    values[[7, 15]] = 1.0, -0.4
    values[[0, -2, -1]] = 0.0, 0.01, 0.0
    return values


def twice(values: np.ndarray) -> np.ndarray:
    return np.concatenate([values, values[1:]])


def worst_zones(summary: Contact) -> list[tuple[float, float]]:
    assert all(edge.cycles.irregular and edge.cycles.closed for edge in summary.stations)
    assert all(len(edge.slip_zones) == 2 for edge in summary.stations)
    return [(edge.slip_zones[0].length, edge.slip_zones[1].length) for edge in summary.stations]


def test_worst_cycle_of_a_shear_force() -> None:
    q = 0.3 * LIMIT * mission(1)
    summary = solved(problem(LOAD, twice(q), cycle=COUNT - 1))
    exact = 1 - np.sqrt(1 - np.ptp(q) / (2 * LIMIT))
    for zones in worst_zones(summary):
        assert zones == pytest.approx((exact, exact), abs=0.002)
    assert summary.steady
    # Every counted cycle is a loop of its own.
    reference = PartialSlip(HERTZ, LOAD, FRICTION)
    work = sum(reference.dissipation(size / 2) for size in rainflow(q, repeated=True).range)
    assert summary.dissipation == pytest.approx(work, rel=0.01)


def test_worst_cycle_under_a_varying_normal_load() -> None:
    q, p = 0.3 * LIMIT * mission(2), LOAD * (1 + 0.05 * mission(3))
    summary = solved(problem(twice(p), twice(q), cycle=COUNT - 1))
    # The permanent stick zone is the contact area at this load (Barber, Davies and Hills 2011).
    stuck = (np.min(q + FRICTION * p) - np.max(q - FRICTION * p)) / (2 * FRICTION)
    inner = float(HERTZ.half_width(stuck))
    assert worst_zones(summary)
    for edge in summary.stations:
        for zone in edge.slip_zones:
            assert abs(zone.border) == pytest.approx(inner, abs=0.003)


def test_a_mission_that_is_not_repeated() -> None:
    q = 0.3 * LIMIT * mission(4)
    summary = solved(problem(LOAD, q))
    exact = 1 - np.sqrt(1 - np.ptp(q) / (2 * LIMIT))
    for edge in summary.stations:
        zone = edge.longest_zone
        assert zone is not None and len(edge.slip_zones) == 2
        assert zone.length == pytest.approx(exact, abs=0.002)
        assert zone.prediction == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("steps", [6, 24])
def test_the_longest_zone_does_not_depend_on_the_steps(steps: int) -> None:
    """Q with an inner loop, then P at nine tenths and back; the second block counts.

    Flat punches between both loads are covered anew, without shear; of the others, as Q returned,
    those that are larger than at .75 of P carry -f: they take 2 f, the new ones f (Jaeger 1998).
    """
    p = np.array([1, 1, 1, 1, 1, 0.9, 1])
    q = np.array([0, 0.4, 0.16, 0.4, 0, 0, 0])
    ways = np.linspace(0, 6, 6 * steps + 1)
    load, shear = (twice(np.interp(ways, range(7), each)) for each in (p, q))
    summary = solved(problem(LOAD * load, LIMIT * shear, cycle=6 * steps))
    exact = 1 - np.sqrt(0.9 - (0.4 - 0.1) / 2)
    for edge in summary.stations:
        longest = max(zone.length for zone in edge.evaluated_zones)
        assert longest == pytest.approx(exact, abs=0.004)
