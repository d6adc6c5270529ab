# SPDX-License-Identifier: LGPL-3.0-or-later
"""The three parts of the error bar of a range of K_T, each by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, loop, problem, solved, started

from fretfe._typing import Array
from fretfe.analytic.profiles import FlatRounded
from fretfe.evaluate.contacts import RangeSpread
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.factors import FactorHistories
from fretfe.evaluate.load_path import LoadPath, load_path
from fretfe.evaluate.plane.edges import growth_with_edge, unresolved
from fretfe.evaluate.withheld import withheld
from fretfe.history.solution import Factor

T = 9
CYCLE = np.arange(T)
WAVE = np.sin(2 * np.pi * (np.arange(T) / (T - 1) + 1 / 16))
ARC = np.linspace(-2.0, 2.0, 41)
HALF_WIDTH = 1.03


def histories(ways: list[float], fitted: float | None = None) -> FactorHistories:
    """Waves of given amplitudes at two stations, of which the right one has a tenth."""

    def of(amplitude: float) -> Array:
        factors = np.zeros((2, T, 2))
        factors[:, :, Factor.K_T] = amplitude * np.array([[1.0], [0.1]]) * WAVE
        return factors

    return FactorHistories(
        ways=np.array([of(each) for each in ways]),
        fitted=of(fitted) if fitted is not None else None,
        exact=True,
        one_sided=np.zeros((2, T)),
        uneven=np.zeros((2, T)),
        known=np.ones(0, dtype=bool),
        units=np.zeros(0),
    )


def fits(spread: float = 0.0) -> list[EdgeFit]:
    one = np.ones(T)
    return [EdgeFit(side * HALF_WIDTH * one, one, spread * one, one) for side in (-1, 1)]


def spreads(
    each: FactorHistories, spread: float = 0.0, path: LoadPath | None = None
) -> tuple[RangeSpread, ...]:
    parts, direction = unresolved(each, fits(spread), ARC, CYCLE), np.array([1.0, 0.0])
    return tuple(
        each.range_spread(number, direction, parts[number], CYCLE, path) for number in (0, 1)
    )


RANGE = float(np.ptp(WAVE))
# .02 of an element of .1 over twice the half-width, which half-planes leave open.
GRID = 0.002 / (2 * HALF_WIDTH)


def test_extraction_is_half_the_difference_of_the_ways() -> None:
    left, right = spreads(histories([1.0, 1.1, 1.04]))
    assert left.extraction == pytest.approx(0.05 * RANGE)
    assert right.extraction == pytest.approx(0.005 * RANGE)
    mean = (1.0 + 1.1 + 1.04) / 3
    assert left.discretisation == pytest.approx(GRID * mean * RANGE)
    assert left.steps == 0.0


def test_one_way_alone_is_exact_or_has_no_bar() -> None:
    alone = histories([1.0])
    found = spreads(alone)[0]
    assert (found.extraction, found.steps) == (0.0, 0.0)
    assert found.discretisation == pytest.approx(GRID * RANGE)
    assert np.isnan(spreads(replace(alone, exact=False))[0].total)


def test_discretisation_holds_fits_elements_edges_and_half_known_steps() -> None:
    (left, _) = spreads(histories([1.0, 1.0], fitted=0.97))
    assert left.discretisation == pytest.approx(np.hypot(0.03, GRID) * RANGE)
    # .475 of an element of .1 and an edge known to .05, over twice the half-width; at the
    # right station likewise, since its K_T may be a small difference.
    both = spreads(replace(histories([1.0, 1.0]), exact=False), spread=0.05)
    share = np.hypot(0.0475, 0.05) / (2 * HALF_WIDTH)
    assert [each.discretisation for each in both] == pytest.approx([share * RANGE] * 2)


@pytest.mark.parametrize(("step", "counts"), [(0, False), (4, True), (7, False)])
def test_half_known_steps_count_between_the_ends_of_the_range(step: int, counts: bool) -> None:
    """What a step may be wrong by is that of its increment: of no use to a range beside it."""
    wrong = np.zeros((2, T))
    wrong[0, step + 1 :] = 0.01 * RANGE
    found, _ = spreads(replace(histories([1.0, 1.0]), one_sided=wrong))
    assert found.moved == pytest.approx(0.01 * counts * RANGE)
    assert found.discretisation == pytest.approx(GRID * RANGE)


def test_steps_miss_what_lies_between_them() -> None:
    """Eight steps per cycle, the extremes in the middle of two: 1 - cos(22.5°) of the amplitude."""
    fine = np.sin(2 * np.pi * (np.arange(8 * (T - 1) + 1) / (8 * (T - 1)) + 1 / 16))
    within = fine[:-1].reshape(T - 1, 8, 1)[:, 1:]
    path = load_path(WAVE[:, None], within, (0, T - 1))
    (left, right) = spreads(histories([1.0, 1.0]), path=path)
    missed = 2 - RANGE
    assert missed > 0.1
    assert left.steps == pytest.approx(missed, rel=1e-9)
    assert right.steps == pytest.approx(0.1 * missed, rel=1e-9)


def test_the_whole_bar() -> None:
    assert RangeSpread(3.0, 4.0, 12.0).total == pytest.approx(13.0)


def test_a_range_has_no_bar_where_k_n_is_not_known() -> None:
    """A punch with three elements on its rounding; no part that is widened later brings it back."""
    punch = FlatRounded(radius=50.0, flat_half_width=0.7, e_star=100.0)
    shear = started(0.5 * LIMIT * np.sin(loop(8, 2)))
    contact = solved(problem(LOAD, shear, profile=punch, cycle=8), elements=18)
    for station in contact.stations:
        assert np.isfinite(station.decisive_k_n[0]) and np.isnan(station.reported_k_n)
        assert np.isfinite(station.k_range) and np.isnan(station.reported_range)
        assert station.k_range_parts.total == station.k_range_spread == np.inf
        assert (
            "the range of K_T unknown, because it has no error bar (discretisation)"
            in withheld(station).text
        )


def test_growth_of_k_n_is_that_over_the_way_of_the_edge() -> None:
    """ln K_N falls by 3 for each mm along the arc; bars of 1 % at both ends of .2 mm."""
    place = np.array([1.0, 1.1, 1.2])
    k_n = 50 * np.exp(-3 * place)
    growth, bar = growth_with_edge(place, k_n, 0.01 * k_n)
    assert growth == pytest.approx(-3) and bar == pytest.approx(0.01 * 2**0.5 / 0.2)
    assert growth_with_edge(place[[0, 0]], k_n[[0, 0]], k_n[[0, 0]])[1] == np.inf
