# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error of the cyclic slip length: exact pairs of lengths, expansions, known bounds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from fretfe.analytic.edges import (
    asymptote_error,
    hertz_tension_asymptote_error,
    mixed_asymptote_error,
    slip_length_cyclic,
    tangential_factor,
)
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.profiles import FlatRounded, Hertz, Profile, Wedge, edge_factor_k_n

HERTZ, WEDGE, ROUNDED = Hertz(2.0, 60.0), Wedge(0.1, 60.0), FlatRounded(0.3, 2.0, 60.0)


@pytest.mark.parametrize("profile", [HERTZ, WEDGE, ROUNDED])
@pytest.mark.parametrize("friction", [0.1, 0.8])
@pytest.mark.parametrize("share", [0.01, 0.3, 0.95])
def test_error_of_a_shear_cycle(profile: Profile, friction: float, share: float) -> None:
    contact = PartialSlip(profile, 5.0, friction)
    a, force = contact.half_width, share * friction * 5.0
    k_t_range = 2 * tangential_factor(force, 0.0, a, "left")
    predicted = slip_length_cyclic(k_t_range, edge_factor_k_n(profile, a), friction)
    exact = a - contact.stick_half_width(force)
    found = asymptote_error(profile, a, predicted)
    # Round-off over the smallest slip length, some 1e-3 of a.
    assert found == pytest.approx(predicted / exact - 1, abs=1e-12)


def test_hertz() -> None:
    d, a = np.array([0.01, 0.1, 0.3, 0.49]), np.array([[0.7], [40.0]])
    found = asymptote_error(HERTZ, a, d * a)
    expected = (np.sqrt(1 - 2 * d) - 1) / 2
    assert found == pytest.approx(np.stack([expected] * 2), rel=1e-11)
    # Minus half of the exact length over a.
    assert found[0] == pytest.approx(-d / (1 + found[0]) / 2, rel=1e-11)


def test_wedge_has_no_error() -> None:
    found = asymptote_error(WEDGE, 1.3, 1.3 * np.array([0.01, 0.5, 0.99]))
    assert found == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("flat", [0.5, 0.8, 0.95])
@pytest.mark.parametrize(
    ("exact", "low", "high"), [(0.1, 0.96, 0.97), (0.25, 0.90, 0.93), (0.5, 0.80, 0.86)]
)
def test_flat_and_rounded(flat: float, exact: float, low: float, high: float) -> None:
    # The known bounds belong to the exact length over that of the rounded part, not the predicted.
    profile, length = FlatRounded(flat, 1.0, 1.0), exact * (1 - flat)
    change = profile.load(1.0) - profile.load(1.0 - length)
    predicted = change / profile.load_slope(1.0)
    ratio = 1 + asymptote_error(profile, 1.0, predicted)
    # Two digits.
    assert low - 0.005 <= ratio <= high + 0.005
    assert predicted / ratio == pytest.approx(length, rel=1e-10)


def test_no_slip_has_no_error() -> None:
    assert asymptote_error(HERTZ, 1.0, [0.0, 1e-300]).tolist() == [0.0, 0.0]
    assert hertz_tension_asymptote_error(1.0, [0.0]).tolist() == [0.0]


def test_outside_the_range_of_the_formula() -> None:
    # P(c) = 0 at d = a/2, a, and P(a)/P'(a).
    end = float(ROUNDED.load(1.0) / ROUNDED.load_slope(1.0))
    ends: list[tuple[Profile, float]] = [(HERTZ, 0.5), (WEDGE, 1.0), (ROUNDED, end)]
    found = [asymptote_error(p, 1.0, [d * 0.999, d * 1.001]) for p, d in ends]
    assert np.isnan(found).tolist() == [[False, True]] * 3


# --- tension


@pytest.mark.parametrize("exact", [0.001, 0.074, 0.191, 0.3, 0.6, 0.99])
def test_tension_against_the_condition_of_finite_traction(exact: float) -> None:
    a, friction, c = 1.3, 0.4, 1.3 * (1 - exact)
    peak = float(HERTZ.peak_pressure(a))

    # x^2 = c^2 cos^2 + a^2 sin^2 takes the square roots away from both ends.
    def density(angle: float) -> float:
        x_squared = (c * np.cos(angle)) ** 2 + (a * np.sin(angle)) ** 2
        return (a**2 - c**2) * np.cos(angle) ** 2 / np.sqrt(x_squared)

    integral = peak / a * quad(density, 0.0, np.pi / 2, epsabs=0.0, epsrel=1e-12)[0]
    tension = 8 * friction / np.pi * integral
    k_t_range = 2 * tangential_factor(0.0, tension, a, "left")
    predicted = slip_length_cyclic(k_t_range, edge_factor_k_n(HERTZ, a), friction)
    found = hertz_tension_asymptote_error(a, predicted)
    assert found == pytest.approx(predicted / (exact * a) - 1, abs=1e-10)


@pytest.mark.parametrize(("tension", "exact"), [(0.3, 0.0741), (0.8, 0.1910)])
def test_tension_against_a_numerical_solution(tension: float, exact: float) -> None:
    # Semi-analytical solution with elements, resolved to .005 a; tension over f p0.
    predicted = tension / 4
    found = predicted / (1 + hertz_tension_asymptote_error(1.0, predicted))
    assert found == pytest.approx(exact, abs=0.005)


@pytest.mark.parametrize("profile", [HERTZ, WEDGE, ROUNDED])
def test_without_tension_the_mixed_error_is_that_of_shear(profile: Profile) -> None:
    d = np.array([0.0, 0.01, 0.05])
    found = mixed_asymptote_error(profile, 0.5, d, 0.0)
    assert found == pytest.approx(asymptote_error(profile, 0.5, d), abs=1e-14)


@pytest.mark.parametrize("share", [-0.5, 0.2, 0.5])
def test_a_little_tension_moves_the_stick_zone_of_a_cylinder(share: float) -> None:
    # Nowell and Hills 1987: half-width a sqrt(1 - Q/(f P)), moved by a sigma/(4 f p0).
    a, d = 3.0, np.array([0.01, 0.2, 0.5])
    by_shear, by_tension = (1 - share) * d, share * d
    exact = a - a * np.sqrt(1 - 2 * by_shear / a) + by_tension
    found = mixed_asymptote_error(HERTZ, a, d, share)
    assert found == pytest.approx(d / exact - 1, abs=1e-12)


def test_tension_alone_is_met_to_second_order() -> None:
    d = np.array([0.01, 0.1])
    difference = mixed_asymptote_error(HERTZ, 1.0, d, 1.0) - hertz_tension_asymptote_error(1.0, d)
    # Beyond the first term, about d/4, is another d^2/16.
    assert difference == pytest.approx(-(d**2) / 16, rel=0.05)


def test_the_mixed_error_is_unknown_where_the_contact_slides() -> None:
    assert np.isnan(mixed_asymptote_error(HERTZ, 1.0, 0.7, 0.2))
    assert mixed_asymptote_error(HERTZ, 1.0, 0.0, 0.5) == 0.0


def test_tension_makes_the_prediction_long() -> None:
    d = np.array([0.001, 0.01])
    found = hertz_tension_asymptote_error([[1.0], [5.0]], d * np.array([[1.0], [5.0]]))
    # Next term of the expansion.
    assert found == pytest.approx(np.stack([d / 4] * 2), rel=0.02)
    # Known as 7 to 11 % at about .3.
    assert 0.07 < hertz_tension_asymptote_error(1.0, 0.3) < 0.11


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: asymptote_error(HERTZ, 0, 0.1), r"half_width must lie in \(0, inf\), found 0"),
        (lambda: asymptote_error(HERTZ, 1, -0.1), r"slip_length must lie in \[0, inf\), found -0"),
        (lambda: hertz_tension_asymptote_error(-1, 0), r"half_width must lie in \(0, inf\)"),
        (lambda: hertz_tension_asymptote_error(1, -1), r"slip_length must lie in \[0, inf\)"),
    ],
)
def test_out_of_range(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=message):
        call()
