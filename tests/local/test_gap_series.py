# SPDX-License-Identifier: LGPL-3.0-or-later
"""The part of a pressure that a gap makes, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.local.gap_series import GapSeries

X: Array = np.linspace(-2.0, 2.0, 401)


def series(gap: Array, pressure: Array) -> GapSeries:
    return GapSeries.of(X, gap, (np.abs(X) < 1)[None], pressure[None])


def shape(made: GapSeries, at: Array) -> Array:
    return made.over(np.array([[-1.0], [1.0]]), at[None])[0]


def test_a_fourth_power_has_the_second_term_of_the_series() -> None:
    """E* x^4 in place of the gap: p = r (1 + 2 z^2), of which the force has 3/2 r."""
    root = np.sqrt(np.maximum(1 - X**2, 0.0))
    z = np.linspace(-1.0, 1.0, 9)
    found = shape(series(X**4, root * (1 + 2 * X**2)), z)
    # The trapezoidal rule of the force, with 200 nodes: 3e-4.
    np.testing.assert_allclose(found, (2 + 4 * z**2) / 3, rtol=1e-3)


def test_parabolas_have_no_part_of_their_own_whatever_their_moment() -> None:
    pressure = np.sqrt(np.maximum(1 - X**2, 0.0)) * (1 + 0.3 * X)
    found = shape(series(X**2, pressure), np.linspace(-2.0, 2.0, 9))
    np.testing.assert_allclose(found, 1.0, rtol=1e-9)


def test_a_patch_beside_bends_the_pressure() -> None:
    """A line load F at c has the slope F 2/(pi (x - c)): more pressure falls to the far side."""
    pressure = np.sqrt(np.maximum(1 - X**2, 0.0))
    pressure[X > 1.5] = 1.0
    near, far = shape(series(0 * X, pressure), np.array([0.9, -0.9]))
    assert near != pytest.approx(far, rel=0.01)
