# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bars of K_N and of the edge hold closed forms, for contacts of many sizes on many meshes."""

from __future__ import annotations

import numpy as np
import pytest
from cases.halfplane_problems import HERTZ, PRESS_STEPS, problem, solved

from fretfe._typing import Array
from fretfe.analytic.profiles import FlatRounded, Profile, Wedge, edge_factor_k_n

# Loads that stay, or a cycle in which edges travel over elements of one size.
STATES = 24
CYCLE = 8
PROFILES: dict[str, Profile] = {
    "Hertz": HERTZ,
    "wedge": Wedge(np.pi / 100, 100.0),
    "flat": FlatRounded(0.6, 50.0, 100.0),
}
# What bars of K_N may be in the median: bars are no excuse.
LARGEST = {"Hertz": 5e-4, "wedge": 3e-4, "flat": 3e-3}
both_histories = pytest.mark.parametrize("cyclic", [False, True])


def draw(profile: Profile, cyclic: bool, seed: int) -> tuple[Array, Array, Array, Array]:
    """(T,) relative errors and bars of K_N, and (T,) errors and bars of an edge over a."""
    random = np.random.default_rng([20, seed])
    peak = float(profile.load(1.0))
    # Without a cycle meshes are made for the last load; the contacts before it fit it by chance.
    loads = peak * random.uniform(0.3, 1.0, STATES) if cyclic else np.full(1, peak)
    elements = int(random.integers(80, 400))
    given = problem(loads, profile=profile, cycle=CYCLE if cyclic else 0)
    station = solved(given, elements).stations[seed % 2]
    last = slice(PRESS_STEPS + 1, None) if cyclic else slice(PRESS_STEPS, None)
    a = np.asarray(profile.half_width(np.broadcast_to(given.normal_force, (len(station.k_n),))))
    a = a[last]
    exact = np.asarray(edge_factor_k_n(profile, a))
    error = np.abs(station.k_n[last] / exact - 1)
    shift = np.abs(np.abs(station.position[last]) / a - 1)
    return error, station.k_n_spread[last] / exact, shift, station.position_spread[last] / a


@both_histories
@pytest.mark.parametrize("name", PROFILES)
def test_bars_hold_the_exact_numbers(name: str, cyclic: bool) -> None:
    draws = [draw(PROFILES[name], cyclic, seed) for seed in range(2 if cyclic else 4)]
    error, bar, shift, bar_of_shift = map(np.concatenate, zip(*draws, strict=True))
    assert np.mean(error <= bar) >= 0.95
    assert np.mean(shift <= bar_of_shift) >= 0.95
    assert np.median(bar) < LARGEST[name]
    assert np.median(bar_of_shift) < 15 * np.median(shift)
