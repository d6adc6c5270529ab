# SPDX-License-Identifier: LGPL-3.0-or-later
"""Thresholds over R, short cracks, arrest and lives against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fretfe.analytic.cracks import EdgeCracks
from fretfe.decision.thresholds import (
    FatigueLimit,
    GrowthLaw,
    Threshold,
    arrest_length,
    critical_length,
    growth_life,
    opening_range,
    short_length,
    short_threshold,
)

# In MPa √m and MPa; lengths in m.
ALLOY = Threshold(np.array([0.0]), np.array([4.2]), 0.5)
LIMIT = FatigueLimit(248.0, 0.0)


def test_the_length_of_short_cracks() -> None:
    assert short_length(ALLOY, LIMIT) == pytest.approx(0.0726e-3, rel=1e-3)
    assert critical_length(ALLOY, LIMIT) == pytest.approx((4.2 / 248) ** 2 / np.pi, rel=1e-9)


def test_limits_at_negative_ratios_count_with_their_tension() -> None:
    reversed_limit = FatigueLimit(496.0, -1.0)
    assert short_length(ALLOY, reversed_limit) == pytest.approx(short_length(ALLOY, LIMIT))
    positive = FatigueLimit(248.0, 0.36)
    assert short_length(ALLOY, positive) == pytest.approx(0.64 * short_length(ALLOY, LIMIT))


def test_walkers_law_from_any_ratio() -> None:
    other = Threshold(np.array([0.36]), np.array([4.2 * 0.8]), 0.5)
    ratios = np.array([0.0, 0.5, 0.75, 1.0, -0.1, np.nan])
    assert ALLOY.at(ratios)[:3] == pytest.approx(4.2 * np.sqrt([1, 0.5, 0.25]))
    assert other.at(ratios)[:3] == pytest.approx(ALLOY.at(ratios)[:3])
    assert np.isnan(ALLOY.at(ratios)[3:]).all()


def test_a_table_is_not_extrapolated() -> None:
    table = Threshold(np.array([-1.0, 0.1, 0.7]), np.array([9.0, 4.0, 2.5]))
    assert table.at(np.array([0.0, 0.1, 0.4, 0.7])) == pytest.approx([4.5, 4.0, 3.25, 2.5])
    assert np.isnan(table.at(np.array([0.71, -0.01]))).all()
    late = Threshold(np.array([0.1, 0.7]), np.array([4.0, 2.5]))
    assert np.isnan(late.at(np.array([0.0])))[0]
    several = Threshold(np.array([-1.0, 0.0, 0.5]), np.array([7.0, 4.0, 3.0]))
    assert several.at(np.array([0.0])) == pytest.approx([4.0])


def test_short_cracks_approach_the_fatigue_limit_and_the_threshold() -> None:
    """Under the range of the limit a crack of no length just grows, F being that of the edge."""
    a0 = short_length(ALLOY, LIMIT)
    lengths = np.array([1e-4 * a0, 1e4 * a0])
    threshold = short_threshold(lengths, ALLOY.at(np.zeros(2)), a0)
    k_1 = 1.12152 * 248 * np.sqrt(np.pi * lengths)
    assert k_1[0] / threshold[0] == pytest.approx(1, rel=1e-3)
    assert threshold[1] == pytest.approx(4.2, rel=1e-3)


def test_faces_keep_their_shift_while_they_are_pressed_together() -> None:
    """From (3, 4) the crack closes at (0, 6), half of the way, and opens at (0, 2)."""
    k_1 = np.array([[3.0, -1.0], [-3.0, -5.0], [1.0, -2.0]])
    k_2 = np.array([[4.0, 9.0], [8.0, 0.0], [0.0, 1.0]])
    found, ratio = opening_range(k_1, k_2)
    assert found == pytest.approx([math.hypot(1, 6), 0.0]) and ratio == pytest.approx([0.0, 0.0])
    found, ratio = opening_range(np.array([[2.0], [4.0]]), np.zeros((2, 1)))
    assert found[0] == 2.0 and ratio[0] == 0.5
    assert np.isnan(opening_range(np.array([[2.0], [np.nan]]), np.zeros((2, 1)))[0]).all()


def test_more_states_on_the_same_way_change_nothing() -> None:
    way = np.random.default_rng(1).normal(0, 10, (2, 12, 40))
    denser = np.stack([np.interp(np.arange(0, 11.1, 0.25), np.arange(12), each)
                       for each in way.swapaxes(1, 2).reshape(-1, 12)])  # fmt: skip
    k_1, k_2 = denser.reshape(2, 40, -1).swapaxes(1, 2)
    for one, other in zip(opening_range(*way), opening_range(k_1, k_2), strict=True):
        assert other == pytest.approx(one, abs=1e-9)


def test_a_crack_that_hardly_opens_has_no_range() -> None:
    """The range falls to zero as pressure rises, without a jump."""
    turns = np.linspace(0, 2 * np.pi, 41)[:, None]
    pressure = np.linspace(0.0, 1.1, 1101)
    found = opening_range(np.sin(turns) - pressure, 3 * np.cos(turns - 0.4) + 0 * pressure)[0]
    assert found[0] > 5 and found[-1] == 0
    assert np.abs(np.diff(found)).max() < 0.3


def test_where_a_crack_stops() -> None:
    lengths = np.array([0.01, 0.1, 1.0, 10.0])
    assert arrest_length(lengths, np.array([4.0, 2.0, 0.5, 3.0])) == pytest.approx(
        0.1 * 10 ** (2 / 3)
    )
    assert arrest_length(lengths, np.array([0.9, 2.0, 3.0, 3.0])) == 0.0
    assert arrest_length(lengths, np.array([1.1, 2.0, 3.0, 3.0])) == math.inf
    assert math.isnan(arrest_length(lengths, np.array([1.1, np.nan, 0.5, 3.0])))


def test_a_crack_under_uniform_tension_never_stops_above_the_limit() -> None:
    """And one below it does not start, whatever its angle to the surface is."""
    cracks, a0 = EdgeCracks.of(np.radians([0.0, 30.0])), short_length(ALLOY, LIMIT)
    lengths = np.geomspace(1e-3 * a0, 100 * a0, 20)
    stress = np.zeros((2, *cracks.points(lengths).shape[:-1], 3))
    stress[1, ..., 0] = 248
    k_1, k_2 = cracks.factors(lengths, stress)
    drive = opening_range(k_1, k_2)[0] / short_threshold(lengths, np.array(4.2), a0)
    assert arrest_length(lengths, 1.01 * drive[0]) == math.inf
    assert arrest_length(lengths, 0.99 * drive[0]) == 0.0
    assert arrest_length(lengths, 1.01 * drive[1]) == 0.0


def test_the_life_by_paris_and_by_its_table() -> None:
    """dc/dN = C (S √(π c))^3, from 0.1 to 4."""
    law = GrowthLaw.paris(1e-8, 3.0, (0.1, 1000.0))
    lengths = np.geomspace(0.05, 5, 30)
    ranges = 20 * np.sqrt(np.pi * lengths)
    known = 2 * (0.1**-0.5 - 4**-0.5) / (1e-8 * (20 * np.sqrt(np.pi)) ** 3)
    assert growth_life(lengths, ranges, law, 0.1, 4.0) == pytest.approx(known, rel=1e-4)
    table = GrowthLaw(np.array([0.1, 10.0, 1000.0]), 1e-8 * np.array([1e-3, 1e3, 1e9]))
    assert growth_life(lengths, ranges, table, 0.1, 4.0) == pytest.approx(known, rel=1e-4)


def test_lives_outside_of_the_data_are_unknown() -> None:
    law = GrowthLaw.paris(1e-8, 3.0, (10.0, 60.0))
    lengths = np.geomspace(0.05, 5, 30)
    ranges = 20 * np.sqrt(np.pi * lengths)
    assert math.isnan(growth_life(lengths, ranges, law, 0.01, 1.0))
    assert math.isnan(growth_life(lengths, ranges, law, 0.1, 6.0))
    assert math.isnan(growth_life(lengths, ranges, law, 0.1, 4.0))
    assert math.isfinite(growth_life(lengths, ranges, law, 0.1, 2.0))
    assert math.isnan(growth_life(lengths, 0 * ranges, law, 0.1, 2.0))
