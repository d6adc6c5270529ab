# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fits of the pressure behind a front to moments of it, against SciPy and integrals by its rule."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import least_squares

from fretfe._typing import Array
from fretfe.evaluate.space import pressure_fit

COUNT, SPACING = 7, 1.5
POWERS = np.arange(3)


def bump(s: float) -> float:
    """B-spline of third degree about 0."""
    s = abs(s)
    return 2 / 3 - s**2 + s**3 / 2 if s < 1 else max(2 - s, 0.0) ** 3 / 6


def bump_curvature(s: float) -> float:
    step = 1e-4
    return (bump(s + step) - 2 * bump(s) + bump(s - step)) / step**2


def moments(place: float, factors: Array, spread: float, bend: float, exponent: float) -> Array:
    """Moments of p = t^exponent (K_N + ...) behind a front at a place, by adaptive quadrature."""

    def shown(s: float, number: int) -> float:
        t = s - place
        return float(t**exponent * (factors @ t**POWERS) * (1 - bend * s)) * bump(s - number)

    found = []
    for number in range(COUNT):
        begin = max(place, number - 2.0)
        knots = [each for each in range(number - 1, number + 2) if each > begin]
        whole, _ = quad(shown, begin, number + 2, (number,), points=knots, epsabs=1e-12, limit=200)
        found.append(whole + spread * bump_curvature(place - number))
    return np.array(found)


@pytest.mark.parametrize("exponent", [0.5, 0.47])
@pytest.mark.parametrize("bend", [0.0, 0.04])
@pytest.mark.parametrize("place", [-0.25, 0.23])
def test_pressure_that_is_a_series_is_found_again(
    place: float, bend: float, exponent: float
) -> None:
    factors, spread = np.array([3.0, -0.2, 0.01]), -0.05
    exact = moments(place, factors, spread, bend, exponent)
    each = np.array([bend]), np.array([exponent])
    fit = pressure_fit._fit(exact[None], *each, len(POWERS), SPACING)
    np.testing.assert_allclose(fit.values[:, 0], [place, factors[0]], rtol=1e-4)
    np.testing.assert_allclose(fit.slope, factors[1] / factors[0], rtol=2e-3)
    assert fit.misfit[0] < 1e-4  # one for noise as large as is taken for granted


def test_noise_leaves_the_least_squares_and_errors_of_scipy() -> None:
    bend, exponent, factors = 0.03, 0.5, np.array([3.0, -0.2, 0.01])
    noise = np.random.default_rng(3).standard_normal(COUNT)
    measured = moments(0.3, factors, -0.05, bend, exponent) * (1 + 0.002 * noise)
    sigma = pressure_fit.SCATTER / SPACING * measured
    sigma[:2] *= pressure_fit.FIRST / pressure_fit.SCATTER

    def residuals(x: Array) -> Array:
        return (moments(x[0], x[1:-1], x[-1], bend, exponent) - measured) / sigma

    # Differences over round-off of the quadratures would put an error of some percent into `jac`.
    best = least_squares(
        residuals, [0.2, 2.5, 0.0, 0.0, 0.0], x_scale=[0.1, 1.0, 0.1, 0.01, 0.1],
        jac="3-point", diff_step=1e-3,
    )  # fmt: skip
    errors = np.sqrt(np.diag(np.linalg.inv(best.jac.T @ best.jac)))
    each = np.array([bend]), np.array([exponent])
    fit = pressure_fit._fit(measured[None], *each, len(POWERS), SPACING)
    # Three corrections leave a small part of what noise makes uncertain.
    assert np.all(np.abs(fit.values[:, 0] - best.x[:2]) < 0.05 * errors[:2])
    np.testing.assert_allclose(fit.errors[:, 0], errors[:2], rtol=0.03)
    np.testing.assert_allclose(fit.misfit[0], 2 * best.cost / (COUNT - 5), rtol=0.03)
