# SPDX-License-Identifier: LGPL-3.0-or-later
"""Width of a contact that the initial gap tells before anything is solved."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from fretfe._typing import Array
from fretfe.analytic.hertz import expected_contact, hertz_half_axes


def paraboloid(k1: float, k2: float, turned: float = 0.4) -> tuple[Array, Array]:
    places = np.random.default_rng(1).uniform(-4.0, 4.0, (4000, 2))
    u, v = places[:, 0], places[:, 1]
    c, s = np.cos(turned), np.sin(turned)
    return places, k1 * (c * u + s * v) ** 2 / 2 + k2 * (c * v - s * u) ** 2 / 2


def test_a_sphere_and_an_ellipsoid() -> None:
    # a³ = 3 P R/(4 E*)
    np.testing.assert_allclose(hertz_half_axes(np.array([0.02, 0.02]), 0.01), 0.375 ** (1 / 3))
    # What p0 sqrt(1 - x²/a² - y²/b²) displaces, from its potential: the curvature along the axis c
    # is 3 P/(2 π E*) ∫ 2 du / ((c² + u²) sqrt((a² + u²)(b² + u²))), 0 < u < ∞.
    for curvatures in ([0.01, 0.05], [0.019, 0.02], [1e-4, 0.02]):
        a, b = hertz_half_axes(np.array(curvatures), 0.01)
        for axis, expected in zip((a, b), curvatures, strict=True):
            integral = quad(_displaced, 0, np.inf, args=(a, b, axis))[0]
            assert 3 * 0.01 / (2 * np.pi) * integral == pytest.approx(expected, rel=1e-5)


def _displaced(u: float, a: float, b: float, axis: float) -> float:
    return float(2 / (axis**2 + u**2) / np.sqrt((a**2 + u**2) * (b**2 + u**2)))


def test_the_width_of_a_paraboloid_and_its_direction() -> None:
    places, gap = paraboloid(0.004, 0.02)
    found = expected_contact(places, gap, 0.01, 0.1)
    (a, width), across = found.half_axes, found.across
    # p0 sqrt(2/b) and p0 sqrt(2/a) at the ends of the half axes.
    assert found.peak == pytest.approx(0.015 / (np.pi * a * width))
    assert found.k_n(width / a**2) == pytest.approx(found.peak * np.sqrt(2 / width))
    assert found.k_n(a / width**2) == pytest.approx(found.peak * np.sqrt(2 / a))
    assert width == pytest.approx(hertz_half_axes(np.array([0.004, 0.02]), 0.01)[1], rel=1e-6)
    assert abs(across @ [-np.sin(0.4), np.cos(0.4)]) == pytest.approx(1.0, abs=1e-9)


def test_a_cylinder_between_its_ends() -> None:
    places, gap = paraboloid(0.0, 0.02, turned=0.0)
    # a² = 4 P R/(π E*) with P per length
    found = expected_contact(places, gap, 0.01, 0.1)
    long, width = found.half_axes
    assert long == np.inf
    # p0 = 2 P/(π a) of P per length.
    assert found.k_n(0.0) == pytest.approx(
        0.02 / 8 / (np.pi * width) * np.sqrt(2 / width), rel=2e-3
    )
    assert width == pytest.approx(np.sqrt(4 * 0.01 / 8 / 0.02 / np.pi), rel=2e-3)


def test_nothing_is_said_where_the_gap_is_no_paraboloid() -> None:
    places, saddle = paraboloid(-0.02, -0.01)
    assert np.isinf(expected_contact(places, saddle, 0.01, 0.1).half_axes).all()
    bumps = 0.01 * (2 - np.cos(3 * places[:, 0]) - np.cos(3 * places[:, 1]))
    assert np.isinf(expected_contact(places, bumps, 0.01, 4.0).half_axes).all()
