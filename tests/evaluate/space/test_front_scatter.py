# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error bars of stations against their scatter along the front, with noise of known size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.solid_runs import stationed_sphere

from fretfe._typing import Array
from fretfe.evaluate.contacts import RangeSpread, Station
from fretfe.evaluate.space.front_scatter import scatter_ratio, with_scatter

COUNT, STATES = 40, 200
ANGLE = 2 * np.pi * np.arange(COUNT) / COUNT
TRUTH = 1 + 0.1 * np.cos(2 * ANGLE)
# Standard deviation of noise whose 95 % interval has the half-width BAR.
BAR, SIGMA = 0.0196, 0.01


def noise() -> Array:
    return SIGMA * np.random.default_rng(43).normal(size=(STATES, COUNT))


def held(error: Array, bars: Array) -> float:
    return float(np.mean(np.abs(error) <= bars))


@pytest.mark.parametrize(("larger", "grown"), [(0.3, 1.0), (1.0, 1.02), (3.0, 3.0)])
@pytest.mark.parametrize("closed", [True, False])
def test_bars_grow_by_as_much_as_the_scatter_exceeds_them(
    larger: float, grown: float, closed: bool
) -> None:
    bars = np.full((STATES, COUNT), BAR)
    ratio = scatter_ratio(TRUTH + larger * noise(), bars, closed)
    assert np.median(ratio) == pytest.approx(grown, rel=0.06)
    assert held(larger * noise(), bars * ratio) >= 0.95
    # Bars of a third of what they should be hold 49 %.
    assert larger < 3 or held(larger * noise(), bars) < 0.55


def test_what_is_not_known_neither_counts_nor_spoils_the_rest() -> None:
    values, bars = TRUTH + 3 * noise(), np.full((STATES, COUNT), BAR)
    values[:, 5], bars[:, 20] = np.nan, np.inf
    ratio = scatter_ratio(values, bars, closed=True)
    assert np.isfinite(ratio).all()
    assert np.median(ratio) == pytest.approx(3.0, rel=0.1)
    np.testing.assert_array_equal(scatter_ratio(np.nan * values, bars, closed=True), 1.0)
    few = slice(0, 12)
    np.testing.assert_array_equal(scatter_ratio(values[:, few], bars[:, few], closed=True), 1.0)


def ellipse(ratio: float) -> tuple[tuple[Station, ...], float]:
    """Stations around an ellipse with K_N of Hertz's pressure, bars of 2.5 %, and its length."""
    t = np.linspace(0, 2 * np.pi, 20001)
    arc = np.append(0.0, np.cumsum(np.hypot(ratio * np.diff(np.cos(t)), np.diff(np.sin(t)))))
    t = np.interp(np.arange(COUNT) / COUNT * arc[-1], arc, t)
    k_n = np.sqrt(2 * np.hypot(np.cos(t) / ratio, np.sin(t)))
    curvature = ratio / np.hypot(ratio * np.sin(t), np.cos(t)) ** 3
    (contact,) = stationed_sphere().contacts
    station, parts = contact.fronts[0].stations[0], RangeSpread(0.0, 0.03, 0.0)
    return tuple(
        replace(
            station, k_n=np.full(3, own), k_n_spread=np.full(3, 0.025 * own), curvature=bend,
            end=False, k_range=1.0, k_range_spread=0.03, k_range_parts=parts,
        )
        for own, bend in zip(k_n, curvature, strict=True)
    ), float(arc[-1])  # fmt: skip


@pytest.mark.parametrize("ratio", [1.0, 1.5, 2.0, 3.0, 5.0])
@pytest.mark.parametrize("width", [0.1, 0.5])
def test_what_ellipses_truly_vary_by_is_no_scatter(ratio: float, width: float) -> None:
    stations, length = ellipse(ratio)
    found = with_scatter(stations, True, [width] * COUNT, length)
    for before, after in zip(stations, found, strict=True):
        np.testing.assert_array_equal(after.k_n_spread, before.k_n_spread)
        assert after.k_range_spread == before.k_range_spread


@pytest.mark.parametrize("width", [0.1, 0.4])
def test_scatter_widens_bars_of_k_n_in_its_state_and_of_ranges(width: float) -> None:
    """K_N alternates by 10 % in the last state; ranges by 9 % with bars of 3 %."""
    stations, length = ellipse(1.0)

    def ragged(station: Station, sign: int) -> Station:
        k_n = station.k_n * [1, 1, 1 + 0.1 * sign]
        return replace(station, k_n=k_n, k_range=1 + 0.09 * sign)

    signs = [(-1) ** number for number in range(COUNT)]
    rough = tuple(map(ragged, stations, signs))
    found = with_scatter(rough, True, [width] * COUNT, length)
    # Differences of order m of alternating numbers are 2^m, over the root of the sum of squared
    # binomial coefficients: least with m = 2, 4/sqrt(6) times the amplitude.
    alternating = 4 / np.sqrt(6) * 1.96
    for before, after in zip(rough, found, strict=True):
        grown = after.k_n_spread / before.k_n_spread
        assert grown == pytest.approx([1, 1, alternating * 0.1 / 0.025], rel=0.01)
        assert after.k_range_spread == pytest.approx(alternating * 0.09, rel=1e-9)
        assert after.k_range_parts.total == after.k_range_spread
        assert after.k_range_parts.extraction == 0.0
