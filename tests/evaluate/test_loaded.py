# SPDX-License-Identifier: LGPL-3.0-or-later
"""States in which a contact is loaded."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.evaluate.loaded import decisive_state, left_out

STATES = np.arange(6)


@pytest.mark.parametrize(
    ("force", "along", "decides"),
    [
        # both extremes of K_T: that with the larger P
        ([0, 80, 100, 90, 95, 100], [0, -5, 0, 5, 0, 0], 3),
        # bodies that touch again: K_T is largest and smallest at hardly any load
        ([0, 20, 100, 60, 30, 0], [0, -5, 0, 1, 5, 0], 2),
        # nothing but P varies
        ([0, 20, 100, 60, 30, 10], [0, 0, 0, 0, 0, 0], 2),
    ],
)
def test_the_state_that_decides(force: list[float], along: list[float], decides: int) -> None:
    found = decisive_state(
        np.array(force, dtype=float), np.array(along, dtype=float), STATES, STATES
    )
    assert found == decides


@pytest.mark.parametrize("share", [0.01, 0.1, 0.4])
def test_the_range_that_is_left_out_of_a_cylinder_pressed_and_sheared_in_proportion(
    share: float,
) -> None:
    """K_T grows with P^(3/4), from P = 0; states from a share of P on are known."""
    force = np.array([0.0, share, 1.0, share, 0.0])
    k_t = force**0.75
    found = left_out((0, 4), np.arange(1, 4), force) * np.ptp(k_t[1:4])
    assert found == pytest.approx(k_t.max() - np.ptp(k_t[1:4]), rel=1e-12)
