# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers at the free end of a front, of rows of nodes whose values are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.quality.end_rows import Rows
from fretfe.quality.ends import Level, number_at
from fretfe.results.end_answers import Compared, Meeting


def rows(distance: Array, values: Array) -> Rows:
    """Rows with a friction work per length, and nothing else that a test reads."""
    return Rows(distance, values, *(np.zeros(len(distance)) for _ in range(5)))


def level(size: float, power: float, error: float = 0.0) -> Rows:
    """Rows to 2.4 that grow towards the end like distance^-power, finite on it, with an error."""
    distance = np.arange(0.0, 2.4 + size / 2, size)
    return rows(distance, (1 + error) * np.maximum(distance, size / 2) ** -power)


def test_a_power_is_found_with_its_bar() -> None:
    found = number_at("work", level(0.05, 0.3), level(0.1, 0.3), 0.6)
    assert found.exponent == pytest.approx(0.3, abs=1e-9)
    assert found.grows and found.exponent_spread < 1e-8
    # The mean of x^-.3 over .6 is .6^-.3/.7; the integral of the first element is what errs.
    exact = 0.6**-0.3 / 0.7
    assert 0.9 * found.mean_spread < abs(found.mean - exact) < found.mean_spread < 0.05 * exact
    assert found.largest == pytest.approx(0.025**-0.3)


def test_what_does_not_grow_has_a_largest_value() -> None:
    falls = number_at("work", level(0.05, -0.5), level(0.1, -0.5), 0.6)
    assert not falls.grows and falls.largest == pytest.approx(math.sqrt(0.6))
    # The levels have other powers: neither is known.
    vague = number_at("work", level(0.05, 0.1), level(0.1, -0.1), 0.6)
    assert not vague.grows


def test_bars_are_what_levels_differ_by() -> None:
    found = number_at("work", level(0.05, -0.5), level(0.1, -0.5, error=0.1), 0.6)
    assert found.largest_spread == pytest.approx(0.1 * math.sqrt(0.6))
    assert found.mean_spread == pytest.approx(0.1 * found.mean, rel=0.2)


def test_rows_do_not_tell_the_power_of_a_stress() -> None:
    """As next to the end of a shorter body, whose pressure has no largest value."""

    def pressed(size: float, pressure: float) -> Rows:
        few = rows(np.array([0.0, size, 2 * size]), np.full(3, pressure, dtype=np.float64))
        return replace(few, pressure=few.work)

    fine, coarse = (pressed(size, size**-0.3) for size in (0.1, 0.2))
    found = number_at("pressure", fine, coarse, 0.2)
    assert found.grows and math.isnan(found.exponent)
    # The mean errs by no more than h^.5.
    assert found.mean_spread == pytest.approx((found.mean - 0.2**-0.3) / (2**0.5 - 1))
    assert not number_at("pressure", fine, pressed(0.2, 1.01 * 0.1**-0.3), 0.2).grows
    many, fewer = (
        replace(each, pressure=each.work) for each in (level(0.05, 0.1), level(0.1, 0.1))
    )
    found = number_at("pressure", many, fewer, 0.6)
    assert found.grows and math.isnan(found.exponent)
    for name in ("shear", "work"):
        nothing = number_at(name, fine, coarse, 0.2)
        assert math.isnan(nothing.exponent) and not nothing.grows


def test_a_power_that_bends_has_it_in_its_bar() -> None:
    """1 + .5/distance^.5 from afar grows by less than near the end."""
    fine, coarse = (level(size, 0.0) for size in (0.05, 0.1))
    fine, coarse = (
        replace(each, work=1 + 0.5 / np.sqrt(np.maximum(each.distance, 0.02)))
        for each in (fine, coarse)
    )
    found = number_at("work", fine, coarse, 0.6)
    # Between .05 and .35, the middle of the logarithms of the distances to 2.4.
    nearer = math.log((1 + 0.5 / 0.05**0.5) / (1 + 0.5 / 0.35**0.5)) / math.log(7)
    assert found.exponent + 0.9 * found.exponent_spread < nearer
    assert nearer < found.exponent + 1.3 * found.exponent_spread


@pytest.mark.parametrize(
    ("part", "k_n", "agrees"),
    [
        (104.0, 2352.0, False),
        (104.0, 2400.0, True),
        (104.0, math.nan, True),
        (107.0, 2491.0, False),
    ],
)
def test_a_meeting_counts_both_bars_of_both_factors(part: float, k_n: float, agrees: bool) -> None:
    numbers = Compared(100.0, 3.0, part, 4.0), Compared(2491.0, 64.0, k_n, 73.0)
    assert Meeting("main.1.3", 0.5, *numbers).agrees is agrees


def known(size: float, places: Array, error: float) -> Level:
    """|ΔK| = 100 distance^-.15 at some places, wrong by an error in proportion to the elements."""
    k_range = 100.0 * places**-0.15 * (1 + error * size)
    k_n = 10.0 + error * (size / 0.05) ** 2 * np.ones_like(places)
    half = np.full(len(places), 0.5)
    return Level(level(size, 0.0), places, k_range, half, k_n, 0.0 * half)


@pytest.mark.parametrize("error", [0.0, 0.6, -0.6])
def test_bars_of_ranges_hold_errors_of_first_order(error: float) -> None:
    fine = known(0.05, np.linspace(0.2, 1.0, 9), error)
    coarse = known(0.1, np.linspace(0.25, 1.2, 20), error)
    found = fine.with_bars(coarse)
    # The coarser one has no station as near to the end as .2.
    np.testing.assert_allclose(found.distance, fine.distance[1:])
    wrong = np.abs(found.k_range - 100.0 * found.distance**-0.15)
    assert (wrong <= found.k_range_spread).all()
    np.testing.assert_allclose(found.k_n_spread, np.abs(found.k_n - 10.0), atol=1e-12)
    # Between its stations the coarser |ΔK| is that of a chord.
    np.testing.assert_allclose(found.k_range_spread, np.hypot(0.5, wrong), atol=0.3)


def test_without_stations_there_are_no_ranges() -> None:
    none = Level(level(0.1, 0.0), *np.zeros((5, 0)))
    assert not len(known(0.05, np.linspace(0.2, 1.0, 9), 0.0).with_bars(none).distance)
    assert not len(none.with_bars(none).distance)
