# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge formulas: against the stuck tractions, each other, and a semi-analytical solution."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from fretfe.analytic._numerics import Side
from fretfe.analytic.edges import (
    dissipation_per_cycle,
    edge_advance,
    edge_slip_first_loading,
    effective_bulk_tension,
    factor_range_phase_shifted,
    normal_increment_factor,
    shear_force_from_factors,
    shear_force_mismatch,
    slip_length_cyclic,
    slip_length_first_loading,
    slip_length_loop,
    slip_lengths_in_phase,
    tangential_factor,
    tension_for_zero_factor,
)
from fretfe.analytic.profiles import Hertz, composite_modulus, edge_factor_k_n

A = 1.7
FROM_LEFT = {"left": 1.0, "right": -1.0}
both_sides = pytest.mark.parametrize("side", ["left", "right"])
ROUND_OFF = 1e-13


@both_sides
def test_shear_force_factor_is_the_limit_of_the_stuck_traction(side: Side) -> None:
    s = 1e-10
    q = 3.0 / (np.pi * np.sqrt(s * (2 * A - s)))
    # The next term is of relative order s/a.
    assert tangential_factor(3.0, 0.0, A, side) == pytest.approx(
        FROM_LEFT[side] * q * np.sqrt(s), rel=1e-9
    )


@both_sides
def test_tension_factor_is_the_limit_of_the_stuck_traction(side: Side) -> None:
    s = 1e-10
    x = -FROM_LEFT[side] * (A - s)
    q = -5.0 * x / (4 * np.sqrt(s * (2 * A - s)))
    assert tangential_factor(0.0, 5.0, A, side) == pytest.approx(
        FROM_LEFT[side] * q * np.sqrt(s), rel=1e-9
    )


def test_tension_on_body_2_pulls_inward_at_both_edges() -> None:
    assert tangential_factor(0.0, 1.0, A, "left") > 0
    assert tangential_factor(0.0, 1.0, A, "right") > 0


@both_sides
def test_sign_of_a_factor_needs_no_ratio(side: Side) -> None:
    # At the left edge K_T > 0 exactly if sigma0 a/4 > -Q/pi, for either sign of Q.
    force = FROM_LEFT[side] * np.array([2.0, 2.0, -2.0, -2.0])
    limit = -FROM_LEFT[side] * 4 * force / (np.pi * A)
    tension = limit * (1 + np.array([0.01, -0.01, 0.01, -0.01]) * np.sign(limit))
    found = tangential_factor(force, tension, A, side)
    assert np.sign(found).tolist() == [1, -1, 1, -1]


@both_sides
def test_tension_for_zero_factor(side: Side) -> None:
    force, a = np.array([2.0, -3.0, 0.0]), np.array([[0.4], [A]])
    limit = tension_for_zero_factor(force, a, side)
    assert limit == pytest.approx(-FROM_LEFT[side] * 4 * force / (np.pi * a), rel=ROUND_OFF)
    assert tangential_factor(force, limit, a, side) == pytest.approx(0.0, abs=ROUND_OFF)
    # A greater tension gives K_T > 0 for either sign of Q.
    assert (tangential_factor(force, limit + 0.01, a, side) > 0).all()
    assert (tangential_factor(force, limit - 0.01, a, side) < 0).all()


@both_sides
@pytest.mark.parametrize(("load", "moment"), [(2.0, 0.0), (0.0, 1.5)])
def test_normal_factor_is_the_limit_of_the_punch(load: float, moment: float, side: Side) -> None:
    def pressure(x: float) -> float:
        return (load + 2 * moment * x / A**2) / (np.pi * np.sqrt(A**2 - x**2))

    centred = quad(lambda t: A * np.cos(t) * A * np.sin(t) * pressure(A * np.sin(t)), -1.57, 1.57)
    # The integrand is cut off 8e-4 before the ends.
    assert centred[0] == pytest.approx(moment, abs=2e-3)
    s = 1e-10
    at_edge = pressure(-FROM_LEFT[side] * (A - s)) * np.sqrt(s)
    # Rounding of a - s loses the last digits of s: 1e-16/1e-10.
    assert normal_increment_factor(load, moment, A, side) == pytest.approx(at_edge, rel=1e-5)


def test_normal_increment_moves_the_edge() -> None:
    profile, step = Hertz(3.0, 50.0), 1e-6
    a = profile.half_width(4.0)
    increment = normal_increment_factor(step, 0.0, a, "right")
    moved = profile.half_width(4.0 + step) - a
    # First order in the step; the difference of half-widths keeps nine digits.
    assert edge_advance(increment, edge_factor_k_n(profile, a)) == pytest.approx(moved, rel=1e-6)


def test_force_and_tension_come_back_from_the_factors() -> None:
    force, tension = np.array([1.0, -2.0, 0.5]), np.array([0.0, 3.0, -1.0])
    left, right = (tangential_factor(force, tension, A, side) for side in ("left", "right"))
    assert shear_force_from_factors(left, right, A) == pytest.approx(force, rel=ROUND_OFF)
    assert effective_bulk_tension(left, right, A) == pytest.approx(tension, abs=ROUND_OFF)
    assert shear_force_mismatch(left, right, A, force / 1.02) == pytest.approx(0.02, abs=ROUND_OFF)


@both_sides
@pytest.mark.parametrize("phase", [0.0, 0.4, np.pi / 2, 2.5, np.pi])
def test_phase_ellipse_is_the_range_over_the_path(phase: float, side: Side) -> None:
    t = np.linspace(0, 2 * np.pi, 100001)
    path = tangential_factor(7 + 2 * np.cos(t), 3 + 1.5 * np.cos(t - phase), A, side)
    # Sampling misses the extremes by (dt)^2/8 of the amplitude; where it vanishes, by nothing.
    exact = factor_range_phase_shifted(2.0, 1.5, phase, A, side)
    assert exact == pytest.approx(np.ptp(path), abs=1e-8)


def test_first_loading_slips_twice_as_far_as_the_cycle() -> None:
    once = slip_length_first_loading(-0.6, k_n=2.0, friction=0.3)
    assert once == pytest.approx(2.0, rel=ROUND_OFF)
    assert slip_length_cyclic(0.6, k_n=2.0, friction=0.3) == pytest.approx(1.0, rel=ROUND_OFF)


def test_loop_at_constant_load_is_the_cyclic_law_and_needs_no_mean() -> None:
    t = np.linspace(0, 2 * np.pi, 41)
    k_t = np.stack([np.sin(t), 8 + 2 * np.cos(t)])
    found = slip_length_loop(k_t, np.zeros_like(k_t), k_n=[1.0, 2.0], friction=0.5)
    expected = slip_length_cyclic(np.ptp(k_t, axis=1), k_n=[1.0, 2.0], friction=0.5)
    assert found == pytest.approx(expected, rel=ROUND_OFF)


@pytest.mark.parametrize("reference", [0, 10, -1])
def test_loop_end_is_one_material_point(reference: int) -> None:
    t = np.linspace(0, 2 * np.pi, 41)
    k_t, k_i = 2 + np.sin(t), 3 + 0.4 * np.cos(t + 0.3)
    from_start = slip_length_loop(k_t, k_i, k_n=1.5, friction=0.4)
    moved = edge_advance(k_i[reference] - k_i[0], 1.5)
    found = slip_length_loop(k_t, k_i, k_n=1.5, friction=0.4, reference=reference)
    # The edge advances by 2 dK_I/K_N, so the border does not depend on where one starts.
    assert found - from_start == pytest.approx(moved, abs=ROUND_OFF)


@pytest.mark.parametrize("k_t_range", [0.0, 0.05, 0.3])
def test_loop_in_phase(k_t_range: float) -> None:
    k_t, k_i = np.array([0.0, k_t_range]), np.array([0.0, 0.4])
    high, low = slip_lengths_in_phase(k_t_range, 0.4, k_n=2.0, friction=0.5)
    found = [slip_length_loop(k_t, k_i, 2.0, 0.5, reference=state) for state in (1, 0)]
    assert found == pytest.approx([high, low], abs=ROUND_OFF)
    assert (low > 0) == (k_t_range > 0.2)


@pytest.mark.parametrize("phase", [0.0, np.pi / 4, np.pi / 2])
def test_loop_without_tension_is_the_contact_at_the_smallest_safe_load(phase: float) -> None:
    t, f, profile = np.linspace(0, 2 * np.pi, 2001), 0.5, Hertz(1.0, 100.0)
    p, q = 10 + 1e-3 * np.cos(t), 1e-3 * np.cos(t + phase)
    a = profile.half_width(p[0])
    stick = profile.half_width((np.min(q + f * p) - np.max(q - f * p)) / (2 * f))
    k_t = tangential_factor(q, 0.0, a, "left")
    k_i = normal_increment_factor(p, 0.0, a, "left")
    found = slip_length_loop(k_t, k_i, edge_factor_k_n(profile, a), f)
    # First order in the amplitudes, which are 1e-4 of the load.
    assert found == pytest.approx(a - stick, rel=2e-4)


# Semi-analytical half-plane solution, Hertz, E* = 100, a = 1, p0 = 1, f = .5: the slip lengths that
# the asymptotic law gives for it, left and right.
LAW = [
    (0.15, 0.0, 0.0, 0.0750, 0.0750),
    (0.30, 0.0, 0.0, 0.1500, 0.1500),
    (0.0, 0.30, 0.0, 0.0750, 0.0750),
    (0.0, 0.80, 0.0, 0.2000, 0.2000),
    (0.15, 0.30, 0.0, 0.1500, 0.0),
    (0.15, 0.30, np.pi / 4, 0.1386, 0.0574),
    (0.15, 0.30, np.pi / 2, 0.1061, 0.1061),
    (0.30, 0.30, np.pi / 3, 0.1984, 0.1299),
]


@pytest.mark.parametrize(("shear", "tension", "phase", "left", "right"), LAW)
def test_slip_lengths_of_phase_shifted_loads(
    shear: float, tension: float, phase: float, left: float, right: float
) -> None:
    f, profile = 0.5, Hertz(50.0, 100.0)
    load, k_n = float(profile.load(1.0)), float(edge_factor_k_n(profile, 1.0))
    sides: tuple[Side, Side] = ("left", "right")
    ranges = [
        factor_range_phase_shifted(shear * f * load, tension * f, phase, 1.0, side)
        for side in sides
    ]
    found = slip_length_cyclic(ranges, k_n, f)
    # Last digit of the table.
    assert found == pytest.approx([left, right], abs=5e-5)


def test_two_cylinders() -> None:
    """Two cylinders R = 8, E = 200, nu = .3, P = 10, Q = .93616."""
    a = Hertz(4.0, composite_modulus(200.0, 0.3, 200.0, 0.3)).half_width(10.0)
    assert tangential_factor(0.93616, 0.0, a, "left") == pytest.approx(0.255377, rel=2e-6)


def test_dissipation_is_friction_times_slip_over_the_zone() -> None:
    k_n, d, f, e_star = 3.0, 0.2, 0.4, 90.0
    edge = edge_slip_first_loading(k_n, d, f, e_star)

    # Twice the first-loading slip with the cyclic d, two half cycles.
    def density(s: float) -> float:
        return f * k_n * np.sqrt(s) * 2 * edge * (1 - s / d) ** 1.5 * 2

    work = quad(density, 0.0, d, epsrel=1e-11)[0]
    assert dissipation_per_cycle(k_n, d, f, e_star) == pytest.approx(work, rel=1e-10)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: tangential_factor(1, 0, -1, "left"),
            r"half_width must lie in \(0, inf\), found -1",
        ),
        (lambda: tangential_factor(1, 0, 1, "up"), "side must be 'left' or 'right', found 'up'"),  # type: ignore[arg-type]
        (
            lambda: tension_for_zero_factor(1, 0, "left"),
            r"half_width must lie in \(0, inf\), found",
        ),
        (lambda: shear_force_mismatch(1, 1, 1, 0), "shear_force must not be zero"),
        (lambda: slip_length_cyclic(-1, 1, 1), r"k_t_range must lie in \[0, inf\), found -1"),
        (lambda: slip_length_cyclic(1, 0, 1), r"k_n must lie in \(0, inf\), found 0"),
        (lambda: slip_length_first_loading(1, 1, 0), r"friction must lie in \(0, inf\), found 0"),
        (lambda: slip_lengths_in_phase(1, -2, 1, 1), r"k_i_range must lie in \[0, inf\), found -2"),
        (lambda: dissipation_per_cycle(1, -0.1, 1, 1), r"slip_length must lie in \[0, inf\)"),
        (lambda: edge_slip_first_loading(1, 1, 1, 0), r"e_star must lie in \(0, inf\), found 0"),
        (lambda: edge_advance(1, 0), r"k_n must lie in \(0, inf\), found 0"),
    ],
)
def test_out_of_range(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=message):
        call()
