# SPDX-License-Identifier: LGPL-3.0-or-later
"""Profiles: closed forms against quadrature, inverse pairs, limits, published numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import beta

from fretfe.analytic.edges import normal_increment_factor
from fretfe.analytic.profiles import (
    FlatRounded,
    GeneralProfile,
    Hertz,
    Profile,
    Wedge,
    approach_slope,
    composite_modulus,
    edge_factor_k_n,
)

E_STAR, RADIUS, SLOPE, FLAT = 110.0, 7.0, 0.03, 0.6
HERTZ, WEDGE = Hertz(RADIUS, E_STAR), Wedge(SLOPE, E_STAR)
ROUNDED = FlatRounded(FLAT, RADIUS, E_STAR)
QUADRATURE = {
    "hertz": GeneralProfile(lambda t: t / RADIUS, E_STAR),
    "wedge": GeneralProfile(lambda t: SLOPE, E_STAR, (0.0,)),
    "rounded": GeneralProfile(lambda t: np.maximum(t - FLAT, 0.0) / RADIUS, E_STAR, (FLAT,)),
}
CLOSED: dict[str, Profile] = {"hertz": HERTZ, "wedge": WEDGE, "rounded": ROUNDED}
every_profile = pytest.mark.parametrize("name", list(CLOSED))
half_widths = pytest.mark.parametrize("a", [0.61, 0.8, 1.3])


@every_profile
@half_widths
def test_load_slope_and_k_n_against_quadrature(name: str, a: float) -> None:
    closed, general = CLOSED[name], QUADRATURE[name]
    # Near a = b both lose three digits.
    assert closed.load(a) == pytest.approx(general.load(a), rel=1e-10)
    assert closed.load_slope(a) == pytest.approx(general.load_slope(a), rel=1e-10)
    assert edge_factor_k_n(closed, a) == pytest.approx(edge_factor_k_n(general, a), rel=1e-10)


@every_profile
@half_widths
@pytest.mark.parametrize("share", [0.05, 0.5, 0.9, 0.999])
def test_pressure_against_quadrature(name: str, a: float, share: float) -> None:
    exact = QUADRATURE[name].pressure(share * a, a)
    peak = float(CLOSED[name].pressure(0.05 * a, a))
    assert CLOSED[name].pressure(share * a, a) == pytest.approx(exact, abs=1e-10 * peak)


@every_profile
@half_widths
def test_pressure_carries_the_load(name: str, a: float) -> None:
    half = quad(
        lambda x: float(CLOSED[name].pressure(x, a)), 0.0, a, points=[FLAT], epsrel=1e-11, limit=400
    )[0]
    # The logarithms at the apex and at |x| = b cost the quadrature two digits.
    assert 2 * half == pytest.approx(CLOSED[name].load(a), rel=1e-9)


@every_profile
def test_half_width_inverts_load(name: str) -> None:
    a = np.array([[0.6001, 0.63], [1.0, 50.0]])
    found = CLOSED[name].half_width(CLOSED[name].load(a))
    assert found == pytest.approx(a, rel=1e-10)


@every_profile
def test_load_inverts_half_width(name: str) -> None:
    load = np.geomspace(1e-6, 1e4, 11)
    assert CLOSED[name].load(CLOSED[name].half_width(load)) == pytest.approx(load, rel=1e-8)


@every_profile
def test_general_half_width(name: str) -> None:
    load = np.array([[0.0, 1e-6, 1e-3], [2.0, 400.0, 1e6]])
    found = QUADRATURE[name].half_width(load)
    # The closed half-width next to the flat keeps ten digits.
    assert found == pytest.approx(CLOSED[name].half_width(load), rel=1e-10, abs=1e-14)


def power_gap(power: float) -> GeneralProfile:
    return GeneralProfile(lambda t: power * t ** (power - 1), E_STAR, (0.0,))


@pytest.mark.parametrize("power", [1.2, 1.5, 3.0, 4.0])
def test_power_gaps_in_closed_form(power: float) -> None:
    a = np.array([1e-3, 0.7, 20.0])
    # The integral of sin^n over a right angle is B((n + 1)/2, 1/2)/2.
    load = E_STAR * power * a**power * beta((power + 1) / 2, 0.5) / 2
    profile = power_gap(power)
    assert profile.load(a) == pytest.approx(load, rel=1e-12)
    assert profile.load_slope(a) == pytest.approx(power * load / a, rel=1e-11)
    assert profile.half_width(load) == pytest.approx(a, rel=1e-12)
    assert profile.gap(a) == pytest.approx(a**power, rel=1e-12)
    # At the centre P'(b)/b is a power: p = n P/(pi a (n - 1)).
    peak = power * load / (np.pi * a * (power - 1))
    # The weakest power, 1.2, is almost a corner with its logarithm.
    assert profile.pressure(0.0, a) == pytest.approx(peak, rel=1e-3 if power < 1.5 else 1e-10)


@pytest.mark.parametrize("power", [1.5, 3.0])
def test_pressure_of_power_gaps_is_the_sum_of_punches(power: float) -> None:
    profile, a = power_gap(power), 1.3
    x = np.array([0.001, 0.4, 1.2, 1.2999])

    def punches(at: float) -> float:
        return quad(
            lambda u: float(profile.load_slope(np.hypot(at, u))) / np.hypot(at, u) / np.pi,
            0.0,
            np.sqrt(a**2 - at**2),
            epsrel=1e-11,
            points=[min(at, 0.01)],
        )[0]

    assert profile.pressure(x, a) == pytest.approx([punches(at) for at in x], rel=1e-10)


def test_general_profile_takes_many_values() -> None:
    x, a = np.linspace(-1.5, 1.5, 101)[:, None], np.linspace(0.7, 1.3, 60)
    found = QUADRATURE["rounded"].pressure(x, a)
    exact = ROUNDED.pressure(x, a)
    assert found == pytest.approx(exact, abs=1e-10 * exact.max())


@every_profile
def test_gap_and_its_slope(name: str) -> None:
    x = np.array([-1.3, -0.7, -0.2, 0.0, 0.2, 0.7, 1.3])
    for profile in (CLOSED[name], QUADRATURE[name]):
        gap, slope = profile.gap(x), profile.gap_slope(x)
        assert (gap == gap[::-1]).all() and (slope == -slope[::-1]).all()
        assert gap[3] == slope[3] == 0.0
        # Central difference of a gap that is at most quadratic here.
        step = (profile.gap(x[4:] + 1e-4) - profile.gap(x[4:] - 1e-4)) / 2e-4
        assert slope[4:] == pytest.approx(step, abs=1e-12)
    assert CLOSED[name].gap(x) == pytest.approx(QUADRATURE[name].gap(x), abs=1e-14)


@pytest.mark.parametrize(
    ("profile", "kinks"),
    [(HERTZ, ()), (WEDGE, (0.0,)), (ROUNDED, (FLAT,)), (FlatRounded(0.0, 1.0, 1.0), ())],
)
def test_kinks(profile: Profile, kinks: tuple[float, ...]) -> None:
    assert profile.kinks == kinks


@every_profile
def test_k_n_is_the_limit_of_the_pressure(name: str) -> None:
    a, s = 1.1, 1e-8
    # The next term of p/sqrt(s) is of order s/(a - b).
    expected = CLOSED[name].pressure(a - s, a) / np.sqrt(s)
    assert edge_factor_k_n(CLOSED[name], a) == pytest.approx(expected, rel=1e-6)


@every_profile
def test_no_pressure_outside(name: str) -> None:
    assert CLOSED[name].pressure([-2.0, -0.7, 0.7, 3.0], 0.7).tolist() == [0.0] * 4


@every_profile
def test_pressure_is_even_and_broadcasts(name: str) -> None:
    x, a = np.linspace(0.1, 0.9, 5)[:, None], np.array([0.7, 1.0])
    p = CLOSED[name].pressure(x, a)
    assert p.shape == (5, 2)
    assert (p == CLOSED[name].pressure(-x, a)).all()


def test_flat_and_rounded_without_a_flat_is_hertz() -> None:
    sharp, a, x = FlatRounded(0.0, RADIUS, E_STAR), np.array([0.0, 0.3, 2.0]), 0.2
    assert sharp.load(a) == pytest.approx(HERTZ.load(a), rel=1e-14)
    assert sharp.half_width(HERTZ.load(a)) == pytest.approx(a, rel=1e-13)
    assert sharp.pressure(x, a) == pytest.approx(HERTZ.pressure(x, a), rel=1e-14)
    assert edge_factor_k_n(sharp, 2.0) == pytest.approx(edge_factor_k_n(HERTZ, 2.0), rel=1e-14)


@pytest.mark.parametrize("flat", [1e-2, 1e-4, 1e-6])
def test_flat_and_rounded_tends_to_hertz(flat: float) -> None:
    ratio = edge_factor_k_n(FlatRounded(flat, RADIUS, E_STAR), 1.0) / edge_factor_k_n(HERTZ, 1.0)
    # 1 - 2 phi0/pi with phi0 = b/a.
    assert 1 - ratio == pytest.approx(2 * flat / np.pi, rel=1e-3)


@pytest.mark.parametrize("gap", [1e-2, 1e-3])
def test_flat_and_rounded_tends_to_a_flat_punch(gap: float) -> None:
    profile = FlatRounded(1.0 - gap, RADIUS, E_STAR)
    x = np.array([0.0, 0.3, 0.6])
    punch = profile.load(1.0) / (np.pi * np.sqrt(1 - x**2))
    # Correction of the order of the ratio of shoulder to distance from the edge.
    assert profile.pressure(x, 1.0) == pytest.approx(punch, rel=1.5 * gap)
    # P -> (E*/R) (2 sqrt(2)/3) (a - b)^(3/2) sqrt(a), relative correction (a - b)/a.
    limit = E_STAR / RADIUS * np.sqrt(8) / 3 * gap**1.5
    assert profile.load(1.0) == pytest.approx(limit, rel=gap)


@pytest.mark.parametrize("gap", [2.0**-20, 2.0**-36, 2.0**-52])
def test_loads_next_to_a_flat_have_all_their_digits(gap: float) -> None:
    """1 - gap is exact; the correction of the punch is of the order of the gap."""
    profile = FlatRounded(1.0 - gap, RADIUS, E_STAR)
    limit = E_STAR / RADIUS * np.sqrt(8) / 3 * gap**1.5
    assert profile.load(1.0) == pytest.approx(limit, rel=max(gap, 1e-14))
    assert profile.half_width(profile.load(1.0)) - profile.flat_half_width == pytest.approx(
        gap, rel=1e-6, abs=2.0**-53
    )
    assert edge_factor_k_n(profile, 1.0) == pytest.approx(
        2 / np.pi * E_STAR / RADIUS * np.sqrt(gap), rel=max(gap, 1e-14)
    )


@pytest.mark.parametrize("gap", [1e-2, 1e-3, 1e-4])
def test_k_n_of_a_flat_punch_with_a_short_rounding(gap: float) -> None:
    profile = FlatRounded(1.0 - gap, RADIUS, E_STAR)
    k_n = edge_factor_k_n(profile, 1.0)
    stiffness = E_STAR / RADIUS
    # Relative corrections gap/12 and gap/3.
    assert k_n == pytest.approx(2 / np.pi * stiffness * np.sqrt(gap), rel=gap)
    k_i = normal_increment_factor(profile.load(1.0), 0.0, 1.0, "right")
    local = 2 / np.pi * stiffness ** (2 / 3) * (1.5 * np.pi * k_i) ** (1 / 3)
    assert k_n == pytest.approx(local, rel=gap)


def test_flat_and_rounded_pressure_is_finite_at_the_end_of_the_flat() -> None:
    around = ROUNDED.pressure([FLAT * (1 - 1e-9), FLAT, FLAT * (1 + 1e-9)], 1.0)
    assert around == pytest.approx([around[1]] * 3, rel=1e-6)


def test_no_load_leaves_the_flat() -> None:
    assert ROUNDED.half_width(0.0) == FLAT
    assert ROUNDED.pressure([0.0, 0.3], FLAT).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("distance", [1.0, 1.5, 40.0])
def test_approach_is_the_displacement_from_the_pressure(distance: float) -> None:
    load, step = float(HERTZ.load(1.0)), 1e-5
    point = distance * float(HERTZ.half_width(load + step))

    # (2/(pi E*)) ln|x - t| is the surface displacement by a unit force at t, up to a constant.
    def approach(force: float) -> float:
        a = float(HERTZ.half_width(force))

        def at(angle: float) -> float:
            t = a * np.sin(angle)
            kernel = np.log((point**2 - t**2) / t**2)
            return float(HERTZ.pressure(t, a)) * a * np.cos(angle) * kernel

        return 2 / (np.pi * E_STAR) * quad(at, 0.0, np.pi / 2, epsrel=1e-13, limit=400)[0]

    rate = (approach(load + step) - approach(load - step)) / (2 * step)
    # Six digits are left in the difference; at the edge itself the rate has a root.
    assert approach_slope(1.0, point, E_STAR) == pytest.approx(rate, rel=1e-6, abs=1e-5)


def test_two_cylinders() -> None:
    """Two cylinders R = 8, E = 200, nu = .3, P = 10 (Yang, Laursen and Meng 2005)."""
    profile = Hertz(4.0, composite_modulus(200.0, 0.3, 200.0, 0.3))
    a = profile.half_width(10.0)
    found = [a, profile.peak_pressure(a), edge_factor_k_n(profile, a)]
    # Last digit of the reference.
    assert found == pytest.approx([0.680778, 9.351351, 16.02826], rel=1e-6)


def test_cylinder_on_block() -> None:
    """Steel cylinder on an aluminium block, 35 kN/mm (NAFEMS contact benchmark 1)."""
    profile = Hertz(50.0, composite_modulus(210e3, 0.3, 70e3, 0.3))
    a = profile.half_width(35e3)
    found = [a, profile.peak_pressure(a), edge_factor_k_n(profile, a)]
    assert found == pytest.approx([6.2146, 3585.36, 2033.95], rel=1e-5)


def test_fretting_specimen() -> None:
    """Cylindrical pad on a specimen 4 mm thick, 543 N (Kosec, Slak and Abdel Wahab)."""
    profile = Hertz(10.0, composite_modulus(72.1e3, 0.33, 72.1e3, 0.33))
    a = profile.half_width(543.0 / 4)
    found = [a, profile.peak_pressure(a), edge_factor_k_n(profile, a)]
    assert found == pytest.approx([0.206698, 418.104, 1300.56], rel=5e-6)


def test_each_body_has_its_own_poisson_ratio() -> None:
    # 1/E* = .75/100 + .96/200.
    found = composite_modulus(100.0, 0.5, 200.0, 0.2)
    assert found == pytest.approx(1 / 0.0123, rel=1e-14)


def test_plane_stress_drops_poisson() -> None:
    assert composite_modulus(200.0, 0.3, 100.0, 0.2, "stress") == pytest.approx(200 / 3, rel=1e-15)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Hertz(-1.0, 1.0), r"radius must lie in \(0, inf\), found -1"),
        (lambda: Wedge(0.0, 1.0), r"slope must lie in \(0, inf\), found 0"),
        (
            lambda: FlatRounded(-0.1, 1.0, 1.0),
            r"flat_half_width must lie in \[0, inf\), found -0.1",
        ),
        (lambda: GeneralProfile(abs, 0.0), r"e_star must lie in \(0, inf\), found 0"),
        (lambda: GeneralProfile(abs, 1.0, (-1,)), r"kinks must lie in \[0, inf\), found -1"),
        (lambda: GeneralProfile(np.zeros_like, 1).half_width(1), "load must be reached at some"),
        (lambda: QUADRATURE["hertz"].half_width(-1), r"load must lie in \[0, inf\), found -1"),
        (lambda: approach_slope(1, 0.9, 1), r"distance/half_width must lie in \[1, inf\), found"),
        (lambda: HERTZ.half_width([1.0, -2.0]), r"load must lie in \[0, inf\), found -2"),
        (lambda: ROUNDED.load(0.5), r"half_width must lie in \[0.6, inf\), found 0.5"),
        (lambda: edge_factor_k_n(HERTZ, 0.0), r"half_width must lie in \(0, inf\), found 0"),
        (lambda: HERTZ.load(np.nan), r"half_width must lie in \[0, inf\), found nan"),
        (lambda: composite_modulus(1, 0.6, 1, 0), r"poisson_1 must lie in \[-1, 0.5\], found 0.6"),
        (lambda: composite_modulus(1, 0, 1, 0, "x"), "plane must be 'strain' or 'stress', found"),  # type: ignore[arg-type]
    ],
)
def test_out_of_range(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=message):
        call()
