# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones that do not grow steadily: inner loops, and loads beyond all that was before."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from cases.edge_histories import edge_history
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, problem, solved

from fretfe._typing import Array
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.growth import Growth, zone_growth

# Q/(f P) at the reversals; the last half cycle is the largest.
PATHS = {
    # The last point goes beyond the first one, from where on slip is that of first loading.
    "beyond": (-0.254, 0.242, -0.05, 0.2, 0.0, 0.1, 0.276),
    "little beyond a loop": (-0.4, 0.3, 0.0, 0.32),
    "steady": (-0.3, 0.3),
}


def grown(shear: Array, start: int, normal: Array | None = None) -> Growth:
    """Growth in the steps from a state on of K_T with f = 1 and K_N = 1."""
    one = np.ones(len(shear))
    memory = EdgeMemory.of(edge_history(shear, normal), one, len(shear) - 1)
    assert memory is not None
    found = zone_growth(memory, start, len(shear) - 1, np.ones(len(shear), dtype=bool))
    assert found is not None
    return found


def growth(k_t: list[float], k_i: list[float] | None = None) -> Growth:
    """That in the last half cycle, from its lowest state on."""
    return grown(np.array(k_t), int(np.argmin(k_t)), None if k_i is None else np.array(k_i))


def test_steady_growth_is_even() -> None:
    found = growth([0.0, -1.0, 0.0, 1.0])
    # The zone of a reversal reaches ΔK_T/(f K_N); (D - y)^(3/2) but for the levels of depth.
    assert found.length == pytest.approx(2.0, abs=0.01)
    assert found.even


def test_first_loading_reaches_twice_as_far() -> None:
    found = growth([0.0, 0.5, 1.0])
    assert found.length == pytest.approx(2.0, abs=0.01)
    assert found.even


def test_slip_beyond_all_that_was_before() -> None:
    """To 1.5 beyond a reversal at -1: up to 1 as after that, then as at first loading."""
    found = growth([0.0, -1.0, 1.0, 1.5])
    assert found.length == pytest.approx(3.0, abs=0.01)
    y = 3.0 * np.array([0.0, 0.2, 0.5, 0.8])
    # Integrals of sqrt(D - y) dK: D = K + 1 up to 2, then D = 2 K.
    first, last = np.maximum(2.0 - y, 0.0) ** 1.5, (3.0 - y) ** 1.5
    exact = (first + (last - first) / 2) ** (2 / 3) / (3.0 - y)
    stretch = found.stretch(y / 3.0)
    np.testing.assert_allclose(stretch / stretch[-1], exact / exact[-1], rtol=5e-3)
    assert not found.even


def test_a_loop_that_closes_makes_the_zone_jump() -> None:
    """The loop from 1 to 0 closes with a zone 1 long; from 2 it then grows as at first loading."""
    found = zone_of_small_loop(1.1)
    assert found.length == pytest.approx(2.2, abs=0.02)
    jump = (found.depth > 1.02) & (found.depth < 1.98)  # give or take a level
    assert not found.rate[jump].any()
    assert found.rate[found.depth < 1.5].sum() == pytest.approx(1.0, abs=0.02)
    assert found.rate[found.depth > 1.5].sum() == pytest.approx(0.1, abs=0.02)


def test_a_loop_that_closes_to_round_off_may_stay_closed() -> None:
    assert zone_of_small_loop(1.0 + 1e-9).length == pytest.approx(1.0, abs=0.02)
    assert zone_of_small_loop(1.0 + 1e-2).length > 1.9


def test_a_cycle_that_closes_but_for_round_off_leaves_its_zone_alone() -> None:
    """P and Q rise and fall together; the first loading reached deeper than the steady cycle."""
    k_t, k_i = np.array([0.0, 1.0, -1.0, 1.0, -1.0]), np.array([0.0, 1.0, -1.0, 1.0, -1.0]) / 2
    found = []
    for missed in (0.0, 1e-15, -1e-15):
        shear = k_t - np.array([0.0, 0.0, 0.0, 0.0, missed])
        found.append(grown(shear, 3, k_i).length)
    # Forward minus backward: 2 - 1, by (11) of the theory from the edge at low P.
    assert found == pytest.approx([1.0] * 3, abs=0.01)


def zone_of_small_loop(top: float) -> Growth:
    """Growth from the lower end of a loop from 0 to 1 within one from -1, up to its other end."""
    return grown(np.array([0.0, -1.0, 1.0, 0.0, top]), 3)


def test_pressing_harder_at_constant_shear_makes_no_slip() -> None:
    found = growth([0.0, 0.0, 0.0], [0.0, 0.5, 1.0])
    assert found.length == 0.0


def path(points: tuple[float, ...], steps: int) -> Array:
    """Q/(f P) from 0 through points, with so many steps to each."""
    ends = np.array([0.0, *points])
    ways = [np.linspace(*pair, steps + 1)[1:] for pair in itertools.pairwise(ends)]
    return np.concatenate([[0.0], *ways])


@pytest.mark.parametrize("steps", [1, 4])
@pytest.mark.parametrize("points", PATHS.values(), ids=PATHS)
def test_border_after_an_irregular_path(points: tuple[float, ...], steps: int) -> None:
    shear = path(points, steps) * LIMIT
    contact = solved(problem(np.full(len(shear), LOAD), shear), elements=100)
    exact = 1.0 - float(PartialSlip(HERTZ, LOAD, FRICTION).stick_half_width_after(shear))
    for station in contact.stations:
        zone = station.slip_zones[-1]
        assert zone.resolved
        # Ciavarella and Jäger. Nodes stand .02 apart there: a fourth of that. The lines through the
        # sum of the slip were up to 6 % off.
        assert zone.length == pytest.approx(exact, abs=0.005)
        assert abs(zone.length - exact) < zone.spread < 0.1 * exact


@pytest.mark.parametrize("size", [1e-13, 1e-11, 1e-9, 1e-7, 1e-5])
def test_loads_that_return_but_for_a_little_have_the_same_zones(size: float) -> None:
    """P and Q in phase, Q beyond f P: loops close, or miss it by parts of the drive."""
    wave = np.sin(np.linspace(0.0, 4 * np.pi, 17))
    noise = size * LIMIT * np.random.default_rng(1).standard_normal(len(wave))

    def zones(shear: Array) -> list[tuple[float, float]]:
        contact = solved(problem(LOAD * (1 + 0.13 * wave), shear, cycle=8), elements=60)
        return [(z.length, z.spread) for each in contact.stations for z in each.slip_zones[-2:]]

    pairs = zip(zones(0.3 * LIMIT * wave), zones(0.3 * LIMIT * wave + noise), strict=True)
    for (exact, spread), (found, _) in pairs:
        assert abs(found - exact) < 0.01 * spread + 10 * size
