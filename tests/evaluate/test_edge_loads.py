# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads of an edge, each increment as if it had one size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.edge_histories import edge_history

from fretfe.evaluate.edge_loads import edge_loads, k_n_by_hold

FORCE = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 0.0])
SHEAR = np.array([0.0, 0.0, 0.2, 0.6, 0.1, 0.0])


@pytest.mark.parametrize("unknown", [[], [1], [1, 2], [4]])
def test_contacts_too_small_to_tell_hold_as_those_beside_them_do(unknown: list[int]) -> None:
    """Of half-planes at one size hold and shear go with P and Q."""
    half_width = np.sqrt(np.where(FORCE > 0, FORCE, np.nan))
    unit = 1 / (np.pi * np.sqrt(2 * half_width))
    units = np.zeros((6, 2, 2))
    units[:, 0, 0] = units[:, 1, 1] = unit
    units[FORCE == 0] = np.nan
    units[unknown] = np.nan
    drivers = np.stack([FORCE, SHEAR], axis=1)
    rough = np.ones(6, dtype=bool)
    found = edge_loads(units, drivers, rough, FORCE, np.array([1.0, 0.0]), 3)
    at = unit[3]
    np.testing.assert_allclose(found.hold, at * FORCE, rtol=1e-12)
    np.testing.assert_allclose(found.shear[:5], at * SHEAR[:5], atol=1e-12)


@pytest.mark.parametrize("few", [[], [1]])
def test_hold_counts_from_where_bodies_touch(few: list[int]) -> None:
    """A cylinder beside tension: what P holds goes with its half-width, by integral of dP/a."""
    force, tension = np.array([0.0, 0.2, 1.0, 0.9, 0.8, 0.9, 0.0]), np.zeros(7)
    tension[3:6] = 0.1, -0.1, 0.1
    half_width = np.sqrt(np.where(force > 0, force, np.nan))
    units = np.zeros((7, 2, 2))
    units[:, 0, 0], units[:, 1, 1] = 1 / np.sqrt(half_width), np.sqrt(half_width)
    units[force == 0] = np.nan
    units[few] = np.nan
    drivers = np.stack([force, tension], axis=1)
    found = edge_loads(units, drivers, np.ones(7, dtype=bool), force, np.array([1.0, 0.0]), 2)
    # By the mean of both ends from the first state on; twice what the first one tells before.
    first = 2 * half_width[1]
    second = first + (1 - force[1]) * (1 / half_width[1] + 1) / 2
    np.testing.assert_allclose(found.hold[1:3], [first, second], rtol=1e-12)
    assert found.hold[6] == 0 and abs(found.hold[4] - found.hold[2]) < 0.2 * found.hold[2]


def test_how_far_drivers_are_apart_is_that_of_the_way_in_any_steps() -> None:
    """Q, then tension, under constant P: a right angle."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]])
    found = []
    for steps in (1, 2, 20):
        at = np.linspace(0.0, 3.0, 3 * steps + 1)
        drivers = np.array([np.interp(at, np.arange(4), each) for each in corners.T]).T
        force = drivers[:, 0]
        units = np.zeros((len(at), 2, 3))
        units[:, 0, 0] = units[:, 1, 1] = units[:, 1, 2] = 1.0
        rough = np.ones(len(at), dtype=bool)
        found.append(
            edge_loads(units, drivers, rough, force, np.array([1.0, 0.0]), len(at) - 1).apart
        )
    np.testing.assert_allclose(found, found[-1], rtol=1e-12)
    # Second moments about the middle of an L, along its axes: 1/12 and 1/3.
    assert found[-1] == pytest.approx(0.5, rel=1e-12)


def test_k_n_goes_with_the_hold_where_fits_hardly_know_it() -> None:
    """A sphere, K_N as P^(1/6): known at most P, hardly at others; what is far from both stays."""
    force = np.array([0.0, 1.0, 0.8, 0.65, 0.5, 0.1, 1.0])
    exact = force ** (1 / 6)
    spread = np.array([np.inf, 0.02, 0.5, 0.03, 0.7, 0.6, 0.02])
    station = replace(
        edge_history(0.0 * force, hold=force),
        k_n=np.array([np.nan, 1.0, 1.2, exact[3], 1.3, 0.3, 1.0]),
        k_n_spread=spread,
    )
    found = k_n_by_hold(station)
    np.testing.assert_allclose(found.k_n[1:5], exact[1:5], rtol=1e-12)
    assert found.k_n[5] == 0.3 and found.k_n_spread[5] == 0.6
    np.testing.assert_array_equal(found.k_n_spread[[1, 3, 6]], spread[[1, 3, 6]])
    # As far as the nearer one differs, and as that is known.
    assert found.k_n_spread[2] == pytest.approx(np.hypot(0.03, exact[2] - exact[3]))
    assert found.k_n_spread[4] == pytest.approx(np.hypot(0.03, exact[3] - exact[4]))
    only = replace(station, k_n_spread=np.where(force == 1, spread, np.inf))
    assert k_n_by_hold(only) is only
