# SPDX-License-Identifier: LGPL-3.0-or-later
"""Partial slip: equilibrium, the friction law, energy, limits, published numbers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad

from fretfe.analytic.edges import (
    dissipation_per_cycle,
    edge_slip_first_loading,
    slip_length_cyclic,
    tangential_factor,
)
from fretfe.analytic.partial_slip import PartialSlip, hertz_dissipation
from fretfe.analytic.profiles import (
    FlatRounded,
    Hertz,
    Profile,
    Wedge,
    composite_modulus,
    edge_factor_k_n,
)

P, F = 5.0, 0.4
LIMIT = F * P
PROFILES: dict[str, Profile] = {
    "hertz": Hertz(2.0, 60.0),
    "wedge": Wedge(0.1, 60.0),
    "rounded": FlatRounded(0.3, 2.0, 60.0),
}
every_profile = pytest.mark.parametrize("name", list(PROFILES))


def problem(name: str) -> PartialSlip:
    return PartialSlip(PROFILES[name], P, F)


def integral(name: str, traction: Callable[[np.ndarray], np.ndarray]) -> float:
    """Midpoint rule in x = a sin t: good to 1e-7 at square-root kinks, 1e-6 at a logarithm."""
    t = (np.arange(200000) + 0.5) / 200000 * np.pi / 2
    a = problem(name).half_width
    return float(np.sum(traction(a * np.sin(t)) * np.cos(t)) * a * np.pi / 200000)


@every_profile
@pytest.mark.parametrize("share", [-0.9, -0.3, 0.0, 0.5, 1.0])
def test_shear_balances_the_force(name: str, share: float) -> None:
    found = integral(name, lambda x: problem(name).shear(x, share * LIMIT))
    # The accuracy of the rule.
    assert found == pytest.approx(share * LIMIT, abs=1e-5)


@every_profile
@pytest.mark.parametrize("rising", [False, True])
@pytest.mark.parametrize("force", [-0.6, 0.0, 0.45])
def test_cyclic_shear_balances_the_force(name: str, force: float, rising: bool) -> None:
    found = integral(
        name, lambda x: problem(name).cyclic_shear(x, force, 0.6 * LIMIT, rising=rising)
    )
    assert found == pytest.approx(force, abs=1e-5)


@every_profile
@pytest.mark.parametrize("share", [-0.8, 0.35])
def test_friction_law_of_the_first_loading(name: str, share: float) -> None:
    contact, force = problem(name), share * LIMIT
    x = np.linspace(0.01, 0.999, 301) * contact.half_width
    q, bound = contact.shear(x, force), F * contact.profile.pressure(x, contact.half_width)
    slips = x > contact.stick_half_width(force)
    assert q[slips] == pytest.approx(np.sign(share) * bound[slips], rel=1e-12)
    assert (np.abs(q[~slips]) < bound[~slips]).all()


@every_profile
def test_friction_law_after_a_reversal(name: str) -> None:
    contact, peak, force = problem(name), 0.7 * LIMIT, 0.1 * LIMIT
    x = np.linspace(0.01, 0.999, 301) * contact.half_width
    q = contact.cyclic_shear(x, force, peak, rising=False)
    bound = F * contact.profile.pressure(x, contact.half_width)
    slips = x > contact.cyclic_stick_half_width(force, peak, rising=False)
    # Round-off of a difference of two tractions that are equal in the slip zone.
    assert q[slips] == pytest.approx(-bound[slips], rel=1e-11)
    assert (np.abs(q[~slips]) < bound[~slips]).all()


@every_profile
def test_cycle_closes_and_is_symmetric(name: str) -> None:
    contact, peak = problem(name), 0.7 * LIMIT
    x = np.linspace(0.01, 0.999, 50) * contact.half_width
    top = contact.cyclic_shear(x, peak, peak, rising=True)
    assert top == pytest.approx(contact.shear(x, peak), abs=1e-13)
    assert top == pytest.approx(contact.cyclic_shear(x, peak, peak, rising=False), abs=1e-13)
    falling = contact.cyclic_shear(x, 0.2 * LIMIT, peak, rising=False)
    rising = contact.cyclic_shear(x, -0.2 * LIMIT, peak, rising=True)
    assert falling == pytest.approx(-rising, abs=1e-13)


@every_profile
def test_stick_zone_of_the_cycle_is_that_of_the_first_loading(name: str) -> None:
    contact, peak = problem(name), 0.7 * LIMIT
    end = contact.cyclic_stick_half_width(-peak, peak, rising=False)
    assert end == pytest.approx(contact.stick_half_width(peak), rel=1e-14)


def test_cattaneo_mindlin() -> None:
    shares = np.array([0.0, 0.2, 0.5, 0.8, 1.0])
    contact = problem("hertz")
    found = contact.stick_half_width(shares * LIMIT) / contact.half_width
    assert found == pytest.approx(np.sqrt(1 - shares), abs=1e-12)


def test_full_sliding_leaves_the_flat() -> None:
    assert problem("rounded").stick_half_width(LIMIT) == pytest.approx(0.3, rel=1e-12)


def test_two_cylinders() -> None:
    """Yang, Laursen and Meng 2005: R = 8, E = 200, nu = .3, P = 10, Q = .93616, f = .2."""
    profile = Hertz(4.0, composite_modulus(200.0, 0.3, 200.0, 0.3))
    contact = PartialSlip(profile, 10.0, 0.2)
    c = contact.stick_half_width(0.93616)
    assert c == pytest.approx(0.496511, abs=1e-6)
    assert contact.half_width - c == pytest.approx(0.184267, abs=1e-6)
    q = contact.shear([0.0, 0.2, 0.4, 0.55, 0.6], 0.93616)
    assert q == pytest.approx([0.5062, 0.5393, 0.7053, 1.1022, 0.8837], abs=5e-5)


# --- any history


def test_sequence_up_to_the_first_reversal_is_the_first_loading() -> None:
    contact, x = problem("hertz"), np.linspace(-1.2, 1.2, 21)
    expected = contact.shear(x, -0.7 * LIMIT)
    found = contact.shear_after(x, np.array([0.0, -0.2, -0.2, -0.5, -0.7]) * LIMIT)
    assert (found == expected).all()


@every_profile
@pytest.mark.parametrize("peak", [0.7, -0.7])
@pytest.mark.parametrize("rising", [False, True])
def test_steady_cycle_is_a_sequence(name: str, peak: float, rising: bool) -> None:
    contact, x = problem(name), np.linspace(0.01, 1.1, 57) * problem(name).half_width
    end = -0.7 if rising else 0.7
    forces = np.array([peak, -peak, peak, -peak, end, 0.1]) * LIMIT
    expected = contact.cyclic_shear(x, 0.1 * LIMIT, 0.7 * LIMIT, rising=rising)
    assert contact.shear_after(x, forces) == pytest.approx(expected, abs=1e-13)
    stick = contact.cyclic_stick_half_width(0.1 * LIMIT, 0.7 * LIMIT, rising=rising)
    assert contact.stick_half_width_after(forces) == pytest.approx(stick, rel=1e-13)


@pytest.mark.parametrize(
    ("forces", "same"),
    [
        # Closed loops, nested or one after the other, are forgotten.
        ([0.8, -0.2, 0.4, -0.2, 0.1], [0.8, -0.2, 0.1]),
        ([0.8, -0.2, 0.4, 0.0, 0.3, -0.1, 0.5], [0.8, -0.2, 0.5]),
        ([0.8, -0.2, 0.4, 0.1, 0.4, 0.6], [0.8, -0.2, 0.6]),
        # The first loading goes on, in either direction.
        ([0.5, 0.1, 0.3, 0.9], [0.9]),
        ([0.5, -0.3, 0.2, -0.7], [-0.7]),
        ([-0.5, 0.3, -0.2, 0.5, 0.2], [0.5, 0.2]),
        # Waiting and intermediate values do not matter.
        ([0.3, 0.8, 0.8, 0.5, 0.5, -0.2, -0.2, 0.1], [0.8, -0.2, 0.1]),
    ],
)
@every_profile
def test_what_is_wiped_out(name: str, forces: list[float], same: list[float]) -> None:
    contact, x = problem(name), np.linspace(0.01, 1.1, 57) * problem(name).half_width
    found = contact.shear_after(x, np.array(forces) * LIMIT)
    expected = contact.shear_after(x, np.array(same) * LIMIT)
    assert found == pytest.approx(expected, abs=1e-13)
    stick = contact.stick_half_width_after(np.array(same) * LIMIT)
    assert contact.stick_half_width_after(np.array(forces) * LIMIT) == pytest.approx(
        stick, rel=1e-13
    )


@every_profile
def test_traction_is_continuous_where_a_loop_closes(name: str) -> None:
    contact, x = problem(name), np.linspace(0.01, 1.1, 57) * problem(name).half_width
    before, after = (
        contact.shear_after(x, np.array([0.8, -0.2, 0.4, -0.2 + step]) * LIMIT)
        for step in (1e-12, -1e-12)
    )
    # The step, with the slope dq/dQ ~ sqrt(step) next to the edge.
    assert before == pytest.approx(after, abs=1e-5)


HISTORIES = {
    "mean": [0.9, 0.3, 0.9, 0.3, 0.6],
    "spiral": [-0.9, 0.8, -0.6, 0.5, -0.3, 0.2, 0.0],
    "growing": [0.1, -0.2, 0.4, -0.6, 0.95, -0.4],
}
every_history = pytest.mark.parametrize("history", list(HISTORIES))


@every_profile
@every_history
def test_sequence_balances_the_force_within_the_friction_law(name: str, history: str) -> None:
    contact, forces = problem(name), np.array(HISTORIES[history]) * LIMIT
    found = integral(name, lambda x: contact.shear_after(x, forces))
    # The accuracy of the rule, for each of up to seven fields.
    assert found == pytest.approx(forces[-1], abs=5e-5)
    x = np.linspace(0.01, 0.999, 301) * contact.half_width
    q, bound = contact.shear_after(x, forces), F * contact.profile.pressure(x, contact.half_width)
    assert (np.abs(q) <= bound * (1 + 1e-12)).all()
    slips = x > contact.stick_half_width_after(forces)
    # Slip goes on in the direction in which Q changed last.
    direction = np.sign(forces[-1] - forces[-2])
    assert q[slips] == pytest.approx(direction * bound[slips], rel=1e-10)


def test_mean_force_leaves_the_slip_zones_of_the_cycle() -> None:
    contact = problem("hertz")
    found = contact.stick_half_width_after(np.array([0.9, 0.3, 0.9]) * LIMIT)
    # Back at the maximum: the first loading. Just before, half the range.
    assert found == pytest.approx(contact.stick_half_width(0.9 * LIMIT), rel=1e-14)
    before = contact.stick_half_width_after(np.array([0.9, 0.3, 0.9 * (1 - 1e-12)]) * LIMIT)
    assert before == pytest.approx(contact.stick_half_width(0.3 * LIMIT), rel=1e-11)


# --- slip and dissipation


@pytest.mark.parametrize("x", [0.5, 0.7, 0.9, 1.0])
def test_hertz_slip_in_closed_form(x: float) -> None:
    contact = problem("hertz")
    c, at = float(contact.stick_half_width(0.8 * LIMIT)), x * contact.half_width
    # The gap outside a Hertz contact of half-width c, R = 2.
    gap = (at * np.sqrt(at**2 - c**2) - c**2 * np.arccosh(at / c)) / (2 * 2.0)
    assert contact.slip(at, 0.8 * LIMIT) == pytest.approx(F * gap, rel=1e-10)


@every_profile
def test_slip_near_the_border_and_at_the_edge(name: str) -> None:
    contact, force = problem(name), 0.002 * LIMIT
    a, d = contact.half_width, contact.half_width - float(contact.stick_half_width(force))
    edge = edge_slip_first_loading(
        edge_factor_k_n(contact.profile, a), d, F, contact.profile.e_star
    )
    s = np.array([0.0, 0.5, 0.8]) * d
    # Asymptotic in d: relative error of the order of d/(a - b), here 2e-3 at most.
    assert contact.slip(a - s, force) == pytest.approx(edge * (1 - s / d) ** 1.5, rel=5e-3)


def test_slip_follows_the_force_and_vanishes_in_the_stick_zone() -> None:
    contact = problem("hertz")
    x = np.array([-0.95, 0.0, 0.3, 0.95]) * contact.half_width
    forward, backward = contact.slip(x, 0.5 * LIMIT), contact.slip(x, -0.5 * LIMIT)
    assert (forward == -backward).all()
    assert forward[0] == forward[3] > 0
    assert forward[1:3].tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("share", "tolerance"), [(0.05, 1e-10), (0.3, 1e-10), (0.7, 1e-10), (1.0, 1e-6)]
)
def test_dissipation_two_ways(share: float, tolerance: float) -> None:
    contact, hertz = problem("hertz"), Hertz(2.0, 60.0)
    # Friction times slip over the slip zones against the loop integral of Q over the approach.
    closed = hertz_dissipation(hertz, P, F, share * LIMIT)
    # Round-off, divided by u^2 in the closed form. In full sliding c = 0, where the slip has a
    # logarithm that the quadrature resolves to 5e-8.
    assert contact.dissipation(share * LIMIT) == pytest.approx(closed, rel=tolerance)


@every_profile
@pytest.mark.parametrize("share", [0.4, 0.8])
def test_dissipation_is_the_area_of_the_loop(name: str, share: float) -> None:
    contact, peak = problem(name), share * LIMIT

    # Tangential compliance after a reversal is that of a punch of the half-width that sticks:
    # -(2/(pi E*)) ln c plus a constant, which drops out. Two equal halves of the cycle.
    def rate(force: float) -> float:
        stick = contact.cyclic_stick_half_width(force, peak, rising=True)
        return force * float(np.log(stick)) * -2 / (np.pi * 60.0)

    area = 2 * quad(rate, -peak, peak, epsrel=1e-10)[0]
    assert contact.dissipation(peak) == pytest.approx(area, rel=1e-7)


@pytest.mark.parametrize(("length", "ratio"), [(0.05, 0.975), (0.1, 0.949)])
def test_asymptotic_dissipation(length: float, ratio: float) -> None:
    contact = problem("hertz")
    a, share = contact.half_width, 1 - (1 - length) ** 2
    k_n = edge_factor_k_n(contact.profile, a)
    both_edges = 2 * dissipation_per_cycle(k_n, length * a, F, 60.0)
    found = contact.dissipation(share * LIMIT) / both_edges
    # Last digit of the known ratio.
    assert found == pytest.approx(ratio, abs=5e-4)


@pytest.mark.parametrize("share", [0.05, 0.1, 0.2, 0.4])
def test_asymptotic_slip_length_of_hertz_is_low_by_half_its_share(share: float) -> None:
    contact = problem("hertz")
    a = contact.half_width
    factor_range = 2 * tangential_factor(share * LIMIT, 0.0, a, "left")
    law = slip_length_cyclic(factor_range, edge_factor_k_n(contact.profile, a), F)
    exact = a - contact.stick_half_width(share * LIMIT)
    # (a^2 - c^2)/(2a) against a - c: exactly 1 - d/(2a).
    assert law / exact == pytest.approx(1 - exact / (2 * a), rel=1e-12)


@pytest.mark.parametrize("share", [0.1, 0.9])
def test_asymptotic_slip_length_of_the_wedge_is_exact(share: float) -> None:
    contact = problem("wedge")
    a = contact.half_width
    factor_range = 2 * tangential_factor(share * LIMIT, 0.0, a, "left")
    law = slip_length_cyclic(factor_range, edge_factor_k_n(contact.profile, a), F)
    assert law == pytest.approx(a - contact.stick_half_width(share * LIMIT), rel=1e-12)


@pytest.mark.parametrize("flat", [0.5, 0.8, 0.95])
@pytest.mark.parametrize(
    ("length", "low", "high"), [(0.1, 0.96, 0.97), (0.25, 0.90, 0.93), (0.5, 0.80, 0.86)]
)
def test_asymptotic_slip_length_of_flat_and_rounded(
    flat: float, length: float, low: float, high: float
) -> None:
    profile = FlatRounded(flat, 1.0, 1.0)
    load, inner = float(profile.load(1.0)), float(profile.load(1.0 - length * (1 - flat)))
    factor_range = 2 * tangential_factor(load - inner, 0.0, 1.0, "left")
    law = slip_length_cyclic(factor_range, edge_factor_k_n(profile, 1.0), 1.0)
    # Bounds known to two digits.
    assert low - 0.005 <= law / (length * (1 - flat)) <= high + 0.005


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: PartialSlip(Wedge(1, 1), -1, 1), r"normal_force must lie in \(0, inf\), found -1"),
        (lambda: PartialSlip(Wedge(1, 1), 1, 0), r"friction must lie in \(0, inf\), found 0"),
        (lambda: problem("hertz").shear(0, 2.1), r"shear_force must lie in \[-2, 2\], found 2.1"),
        (lambda: problem("hertz").dissipation(3), r"amplitude must lie in \[-2, 2\], found 3"),
        (lambda: problem("hertz").dissipation(-1), r"amplitude must lie in \[0, inf\), found -1"),
        (
            lambda: problem("hertz").cyclic_shear(0, -1.5, 1, rising=True),
            "shear_force must lie within the amplitude 1, found -1.5",
        ),
        (lambda: problem("hertz").shear(0, -3), "found -3: beyond f P the contact slides"),
        (
            lambda: problem("hertz").shear_after(0, [1, 2.5]),
            r"shear_forces must lie in \[-2, 2\], found 2.5: beyond f P the contact slides",
        ),
        (lambda: problem("hertz").shear_after(0, []), r"shape \(T,\), T >= 1, found \(0,\)"),
        (
            lambda: problem("hertz").stick_half_width_after(1.0),
            r"shear_forces must have the shape \(T,\), T >= 1, found \(\)",
        ),
        (
            lambda: hertz_dissipation(Hertz(2, 60), P, F, 2.5),
            r"amplitude must lie in \[0, 2\], found 2.5",
        ),
    ],
)
def test_out_of_range(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=message):
        call()
