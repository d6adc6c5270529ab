# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors between the steps of a cycle."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.evaluate.load_path import LoadPath, excess, load_path

CYCLE = (3, 11)
STATES = np.arange(CYCLE[0], CYCLE[1] + 1)
PARTS = 8
# Two states before the cycle and eight steps in it, with S = 7 places within each step.
TIMES = np.linspace(0.0, 11 / 8, 12)
FINE = np.linspace(0.0, 11 / 8, 11 * PARTS + 1)


def loads(time: np.ndarray) -> np.ndarray:
    """Two waves 45° apart about different means."""
    turn = 2 * np.pi * time
    return np.column_stack([-600 - 300 * np.sin(turn + np.pi / 4), 15 * np.sin(turn)])


def path() -> LoadPath:
    within = loads(FINE)[:-1].reshape(11, PARTS, 2)[:, 1:]
    found = load_path(loads(TIMES), within, CYCLE)
    assert found is not None
    return found


def test_a_factor_linear_in_the_loads_is_exact_between_the_steps() -> None:
    units = np.array([0.03, -1.7])
    fine = path().at(loads(TIMES) @ units, path().times[CYCLE[0] :])
    assert fine == pytest.approx(loads(FINE)[PARTS * CYCLE[0] :] @ units, abs=1e-12)


def test_excess_is_what_the_steps_miss_of_the_extremes() -> None:
    """The sum of two waves has its extremes between the steps."""
    units = np.array([0.03, -1.7])
    factor, everywhere = loads(TIMES) @ units, loads(np.linspace(0, 1, 100001)) @ units
    missed = np.ptp(everywhere) - np.ptp(factor[STATES])
    assert missed > 0.01 * np.ptp(everywhere)
    # Eight parts of a step leave 1/64 of what a step misses.
    assert excess(factor, path()) == pytest.approx(missed, rel=1 / 64)


def test_nothing_is_missed_between_straight_lines() -> None:
    triangle = np.abs(np.linspace(-1, 1, 12))[:, None]
    shares = np.arange(1, PARTS) / PARTS
    within = triangle[:-1, None] + shares[:, None] * np.diff(triangle, axis=0)[:, None]
    assert load_path(triangle, within, CYCLE) is None
    assert load_path(triangle, None, CYCLE) is None
    assert load_path(triangle, within, None) is None
    assert excess(triangle[:, 0], None) == 0.0


def test_an_unknown_state_leaves_the_cycle_unknown() -> None:
    factor = loads(TIMES)[:, 0]
    factor[6] = np.nan
    assert np.isnan(path().at(factor, path().times)).all()
    assert excess(factor, path()) == 0.0
