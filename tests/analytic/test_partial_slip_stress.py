# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closed-form stress below elliptical tractions against quadrature and textbook values."""

from __future__ import annotations

import numpy as np
import pytest
from reference.elliptical_stress import elliptical_stress
from scipy.integrate import quad

from fretfe._typing import Array
from fretfe.analytic.partial_slip import linear_stress

B, P0, Q0 = 0.8, 3.0, 1.1


def flamant(x: float, depth: float) -> Array:
    """Stress by adding up point forces: each is a radial pressure -(2/pi) F·r/r^2."""

    def component(i: int, j: int, angle: float) -> float:
        # t = b cos(angle) takes the root off the ends.
        t, ellipse = B * np.cos(angle), np.sin(angle)
        r = np.array([x - t, -depth])
        force = np.array([Q0, -P0]) * ellipse
        radial = -2 / np.pi * (force @ r) / (r @ r)
        return float(radial * r[i] * r[j] / (r @ r) * B * np.sin(angle))

    pairs = ((0, 0), (1, 1), (0, 1))
    return np.array(
        [quad(lambda a, i=i, j=j: component(i, j, a), 0, np.pi, limit=400)[0] for i, j in pairs]
    )


@pytest.mark.parametrize("depth", [0.05, 0.4, 2.0])
@pytest.mark.parametrize("x", [-1.3, -0.8, 0.0, 0.3, 0.8])
def test_it_is_the_sum_of_point_forces(x: float, depth: float) -> None:
    # Quadrature reaches 1e-8.
    assert elliptical_stress(x, depth, B, P0, Q0) == pytest.approx(flamant(x, depth), abs=1e-7)


def test_surface_has_the_tractions_and_johnsons_tangential_stress() -> None:
    """sigma_xx is -p by the pressure, and -2 q0 x/b inside by the shear (Johnson, section 7.1)."""
    x = np.linspace(-2, 2, 40)  # none at an end, where a root turns round-off into 1e-8
    p, q = (g * np.sqrt(np.maximum(1 - (x / B) ** 2, 0)) for g in (P0, Q0))
    outside = np.sqrt(np.maximum((x / B) ** 2 - 1, 0))
    by_shear = -2 * Q0 * (x / B - np.sign(x) * outside)
    found = elliptical_stress(x, 0.0, B, P0, Q0)
    expected = np.stack([by_shear - p, -p, q], axis=1)
    assert found == pytest.approx(expected, abs=1e-12)


def test_largest_shear_below_hertz() -> None:
    """0.300 p0 at a depth of 0.786 half-widths (Johnson, section 4.2)."""
    depth = np.linspace(0.01, 2, 2000) * B
    xx, yy, _ = elliptical_stress(0.0, depth, B, 1.0, 0.0).T
    largest = np.abs(xx - yy) / 2
    assert largest.max() == pytest.approx(0.300, abs=5e-4)
    assert depth[largest.argmax()] / B == pytest.approx(0.786, abs=1e-3)


def test_surface_is_the_limit_of_the_depth() -> None:
    x = np.array([-1.0, -0.8, -0.2, 0.5])
    shallow = elliptical_stress(x, 1e-12, B, P0, Q0)
    # At the end of the ellipse it changes with the root of the depth.
    assert shallow == pytest.approx(elliptical_stress(x, 0.0, B, P0, Q0), abs=1e-5)


def test_straight_tractions_approach_an_ellipse() -> None:
    nodes = B * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 801))
    shape = np.sqrt(np.maximum(1 - (nodes / B) ** 2, 0)) * np.array([[1.0], [-2.0]])
    shape[:, [0, -1]] = 0
    x = np.array([-1.3, -0.8, 0.1, 0.79, 2.5])
    for depth in (0.0, 0.02, 0.4, 3.0):
        found = linear_stress(x, np.full(5, depth), nodes, P0 * shape, Q0 * shape)
        exact = elliptical_stress(x, depth, B, P0, Q0)
        assert found[0] == pytest.approx(exact, abs=1e-3 if depth else 2e-2)
        assert found[1] == pytest.approx(-2 * found[0])


def test_a_straight_traction_is_exact() -> None:
    """A triangle of pressure, by quadrature of point forces, and no stress far away."""
    nodes, pressure = np.array([-1.0, 0.2, 1.0]), np.array([[0.0, 2.0, 0.0]])
    t, w = np.polynomial.legendre.leggauss(200)
    pieces = [(low + (high - low) * (1 + t) / 2, w * (high - low) / 2)
              for low, high in ((-1.0, 0.2), (0.2, 1.0))]  # fmt: skip
    at, weights = (np.concatenate(each) for each in zip(*pieces, strict=True))
    force = weights * np.interp(at, nodes, pressure[0])
    r = np.array([0.7 - at, np.full_like(at, -0.3)])
    radial = -2 / np.pi * (-force * r[1]) / np.sum(r**2, axis=0) ** 2
    known = [np.sum(radial * r[i] * r[j]) for i, j in ((0, 0), (1, 1), (0, 1))]
    found = linear_stress([0.7], [0.3], nodes, pressure, 0 * pressure)
    assert found[0, 0] == pytest.approx(known, rel=1e-9)
    assert np.abs(linear_stress([1e5], [1e5], nodes, pressure, pressure)).max() < 1e-4


def test_a_shear_across_the_plane() -> None:
    """By quadrature of line forces F, -F/(π r) away from each; at the surface the traction."""
    nodes, shear = np.array([-1.0, 0.2, 1.0]), np.array([[0.0, 2.0, 0.0]])
    at = np.linspace(-1, 1, 200_001)
    x, depth = np.array([0.7, -1.3, 0.2]), np.array([0.3, 0.1, 0.8])
    found = linear_stress(x, depth, nodes, 0 * shear, 0 * shear, shear)[0, :, 3:]
    for place, below, own in zip(x, depth, found, strict=True):
        r = np.array([-below + 0 * at, place - at])
        radial = -np.interp(at, nodes, shear[0]) / np.pi / np.sum(r**2, axis=0)
        assert own == pytest.approx(np.trapezoid(radial * r, at, axis=1), abs=1e-6)
    surface = linear_stress([-0.4, 0.2, 1.5], [0.0] * 3, nodes, shear, shear, shear)[0, :, 3]
    assert surface == pytest.approx([1, 2, 0], abs=1e-12)
