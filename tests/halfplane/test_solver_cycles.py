# SPDX-License-Identifier: LGPL-3.0-or-later
"""Steady cycles of the half-plane solution against exact and published slip zones."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, loop, problem, solved, started

from fretfe.analytic._numerics import Side
from fretfe.analytic.edges import factor_range_phase_shifted, tangential_factor
from fretfe.analytic.partial_slip import PartialSlip, hertz_dissipation
from fretfe.analytic.paths import PolygonPath, permanent_stick_load
from fretfe.analytic.profiles import FlatRounded, Profile, Wedge
from fretfe.evaluate.contacts import Contact, SlipZone
from fretfe.evaluate.verdicts import judge
from fretfe.halfplane import solve_half_planes
from fretfe.verdict import Verdict

SIDES: tuple[Side, Side] = ("left", "right")
STEPS = 60


def last_zones(summary: Contact) -> list[tuple[float, float]]:
    """Lengths of the last two slip zones at each edge; where nothing slips there is one of 0."""
    zones = [(edge.slip_zones[-2:] + edge.slip_zones[-1:])[:2] for edge in summary.stations]
    return [(first.length, second.length) for first, second in zones]


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.8])
def test_cattaneo_mindlin(ratio: float, direction: float) -> None:
    shear = direction * ratio * LIMIT * np.linspace(0.1, 1.0, 10)
    summary = solved(problem(LOAD, shear))
    stick = [1.0 - edge.slip_zones[-1].length for edge in summary.stations]
    # 0.2 % is what the solution promises; 0.03 % were measured
    assert stick == pytest.approx([np.sqrt(1 - ratio)] * 2, abs=0.001)


def beyond_first_loading(back: float, beyond: float) -> tuple[list[SlipZone], float]:
    """Last slip zones of both edges as Q/(f P) goes 0, -0.3, back, -beyond; their exact length."""
    path = np.interp(np.arange(0.5, 3.1, 0.5), range(4), [0.0, -0.3, back, -beyond])
    edges = solved(problem(LOAD, LIMIT * path)).stations
    return [edge.slip_zones[-1] for edge in edges], 1 - np.sqrt(1 - beyond)


@pytest.mark.parametrize(("back", "beyond"), [(0.27, 0.303), (0.2, 0.304)])
def test_slip_that_passes_the_border_of_the_slip_before(back: float, beyond: float) -> None:
    """Slip falls as two powers of 3/2: the one that ends farther inward is the first loading."""
    zones, exact = beyond_first_loading(back, beyond)
    for zone in zones:
        assert zone.resolved
        assert zone.length == pytest.approx(exact, abs=zone.spread)
        assert zone.spread < 0.021 * exact


@pytest.mark.parametrize(("back", "beyond"), [(0.28, 0.302), (0.29, 0.302), (0.25, 0.303)])
def test_slip_that_goes_just_beyond_a_closing_loop(back: float, beyond: float) -> None:
    """The zone jumps to that of the first loading, where hardly anything slips."""
    zones, exact = beyond_first_loading(back, beyond)
    for zone in zones:
        assert zone.length == pytest.approx(exact, abs=zone.spread)
        assert zone.spread < 0.1 * exact


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.8])
def test_shear_of_cattaneo_mindlin_after_a_reversal(ratio: float) -> None:
    q1 = ratio * LIMIT
    given = problem(LOAD, started(q1 * np.cos(loop(20, 1))[: 20 * 3 // 4 + 1]))
    solution = solve_half_planes(given).solution
    contact = solution.contacts[0]
    reference = PartialSlip(HERTZ, LOAD, FRICTION)
    x = contact.surface.arc
    expected = reference.shear_after(x, [q1, -q1, float(given.shear_force[-1])])
    # The shear has square roots at the borders of the stick zones, each somewhere in an element.
    borders = [reference.stick_half_width(q) for q in (q1, abs(given.shear_force[-1] + q1) / 2)]
    away = np.min([np.abs(np.abs(x) - border) for border in borders], axis=0) > 0.03
    error = np.abs(contact.mean_traction[-1, :, 1] - expected)[away & (np.abs(x) < 0.99)].max()
    assert error < 0.002 * FRICTION


# Steady loops Q = Qa cos t, sigma0 = sa cos(t - phase): Qa/(f P), sa/(f p0), phase, slip zones
# from another semi-analytical solution with a resolution of about 0.005 a. Exact for the fifth on
# the right (Nowell and Hills 1987).
LOOPS = {
    "Q": (0.15, 0.0, 0.0, 0.0781, 0.0781),
    "large Q": (0.30, 0.0, 0.0, 0.1613, 0.1613),
    "tension": (0.0, 0.30, 0.0, 0.0741, 0.0741),
    "large tension": (0.0, 0.80, 0.0, 0.1910, 0.1910),
    "in phase": (0.15, 0.30, 0.0, 0.1501, 1 - np.sqrt(0.85) - 0.075),
    "45 degrees": (0.15, 0.30, 45.0, 0.1393, 0.0556),
    "90 degrees": (0.15, 0.30, 90.0, 0.1090, 0.1043),
    "60 degrees": (0.30, 0.30, 60.0, 0.2098, 0.1393),
}


@pytest.mark.parametrize(("shear", "tension", "phase", "left", "right"), LOOPS.values(), ids=LOOPS)
def test_phase_shifted_loops(
    shear: float, tension: float, phase: float, left: float, right: float
) -> None:
    angle, lag = loop(STEPS), np.radians(phase)
    q, s = shear * LIMIT * np.cos(angle), tension * FRICTION * np.cos(angle - lag)
    summary = solved(problem(LOAD, started(q), 0.0, started(s), cycle=STEPS))
    forward_and_backward = [(left, left), (right, right)]
    for zones, expected in zip(last_zones(summary), forward_and_backward, strict=True):
        assert zones == pytest.approx(expected, abs=0.005)
    assert summary.steady
    for edge, side in zip(summary.stations, SIDES, strict=True):
        ellipse = factor_range_phase_shifted(shear * LIMIT, tension * FRICTION, lag, 1.0, side)
        # the reversals may fall between two of the 60 steps: (pi/60)^2/2 of the range
        assert edge.k_t_range == pytest.approx(float(ellipse), rel=1.5e-3, abs=1e-6)


def test_exact_slip_zones_of_tension_in_proportion() -> None:
    # Nowell and Hills 1987: c = sqrt(1 - Q/(f P)), e = sigma0/(4 f p0); both ranges over 2 f
    angle = loop(24)
    for sign in (1.0, -1.0):
        q, s = 0.3 * LIMIT * np.cos(angle), sign * 0.4 * FRICTION * np.cos(angle)
        summary = solved(problem(LOAD, started(q), 0.0, started(s), cycle=24))
        c, e = np.sqrt(0.7), sign * 0.1
        lengths = [edge.slip_zones[-1].length for edge in summary.stations]
        assert lengths == pytest.approx([1 - c + e, 1 - c - e], abs=0.001)


VARYING = {"constant": (0.0, 0.0), "in phase": (0.25, 0.0)} | {
    f"{angle} degrees": (0.25, float(angle)) for angle in (45, 90, 180)
}


@pytest.mark.parametrize(("swing", "phase"), VARYING.values(), ids=VARYING)
def test_permanent_stick_zone_under_varying_normal_load(swing: float, phase: float) -> None:
    angle = loop(STEPS)
    p = LOAD * (1 + swing * np.cos(angle - np.radians(phase)))
    q = 0.3 * LIMIT * np.cos(angle)
    summary = solved(problem(p, q, frictional_press=True, cycle=STEPS))
    zero = np.zeros(STEPS + 1)
    path = PolygonPath(np.column_stack([p[-STEPS - 1 :], zero, q[-STEPS - 1 :], zero]))
    border = float(HERTZ.half_width(permanent_stick_load(path, FRICTION)))
    for edge, sign in zip(summary.stations, (-1, 1), strict=True):
        for zone in edge.slip_zones[-2:]:
            assert sign * zone.border == pytest.approx(border, rel=1e-3)
            # the load at that area, which the formula gives
            load = float(HERTZ.load(sign * zone.border))
            assert load == pytest.approx(float(permanent_stick_load(path, FRICTION)), rel=2e-3)


def test_an_edge_that_moves_more_than_it_is_sheared_does_not_slip() -> None:
    # dK_T < f dK_I: dQ < f dP here
    angle = loop(80, 3)
    p = LOAD * (1 + 0.25 * np.cos(angle))
    q = 0.1 * LIMIT * np.cos(angle)
    summary = solved(problem(p, q, frictional_press=True, cycle=80))
    # Nodes that close within a step slip a little: 0.2 % of the work at constant load, and a
    # quarter of that with half the steps.
    constant = float(hertz_dissipation(HERTZ, LOAD, FRICTION, 0.1 * LIMIT))
    assert summary.dissipation < 0.004 * constant
    zones = [edge.slip_zones for edge in summary.stations]
    assert [[zone.length for zone in each] for each in zones] == [[0.0], [0.0]]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_zones_count_from_the_edge_before_it_draws_back(sign: float) -> None:
    # P up, Q up and down, P down, which draws the edge back over all that slipped with Q.
    rise, share = np.linspace(0.0, 1.0, 6), 0.5333
    p = LOAD * np.concatenate([0.1 + 0.9 * rise, np.ones(10), 1.0 - 0.9 * rise[1:]])
    q = sign * share * LIMIT * np.concatenate([0 * rise, rise[1:], 1 - rise[1:], 0 * rise[1:]])
    summary = solved(problem(np.append(p, p[1:]), np.append(q, q[1:]), cycle=len(p) - 1), 120)
    exact = 1 - np.sqrt(1 - share / np.array([1.0, 2.0]))
    for edge in summary.stations:
        zones = edge.evaluated_zones
        assert [zone.end - edge.first for zone in zones] == [10, 15]
        for zone, length in zip(zones, exact, strict=True):
            assert zone.length == pytest.approx(length, abs=zone.spread)
            assert zone.spread < 0.03 * length
            assert judge(edge, zone).verdict is Verdict.AGREES


def assert_still(summary: Contact) -> None:
    for edge in summary.stations:
        zone = edge.slip_zones[-1]
        assert (zone.length, zone.prediction, zone.resolved) == (0.0, 0.0, True)
        assert 0 < zone.spread < 0.01
        assert judge(edge, zone).verdict is Verdict.AGREES


@pytest.mark.parametrize("friction_while_pressing", [True, False])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_slip_that_is_round_off_of_the_solver_is_none(
    sign: float, friction_while_pressing: bool
) -> None:
    # dQ/dP = .3 < f, in phase and in opposite phase: some nodes reach f p and slip by 1e-16.
    wave, pressing = np.sin(loop(40, 3)), friction_while_pressing
    p, q = LOAD * (1 + 0.2 * wave), sign * 0.3 * 0.2 * LOAD * wave
    assert_still(solved(problem(p, q, frictional_press=pressing, cycle=40)))


@pytest.mark.parametrize(("swing", "amplitude"), [(0.3, 0.0), (0.0, 1e-9), (0.3, 1e-9)])
def test_what_is_zero_within_the_bar_of_the_solution_is_zero(
    swing: float, amplitude: float
) -> None:
    # P alone, and Q of 1e-9 of P.
    wave = np.sin(loop(16, 2))
    p, q = LOAD * (1 + swing * wave), amplitude * LOAD * wave
    summary = solved(problem(p, q, frictional_press=True, cycle=16), 100)
    assert summary.reported_dissipation == 0.0 <= summary.dissipation_spread < 1e-12
    for edge in summary.stations:
        zone = edge.longest_zone
        assert zone is not None and zone.told[0] == 0.0
        assert judge(edge, zone).verdict is Verdict.AGREES
        range_by_closed_form = float(tangential_factor(2 * amplitude * LOAD, 0.0, 1.0, "left"))
        size, most = edge.told_range
        assert size == 0.0
        # Where P moves the edge what slip follows is less than the range of K_T.
        least = 0.0 if swing else 0.9 * range_by_closed_form
        assert least <= most <= 1.1 * range_by_closed_form + 1e-12
        assert not edge.uncertain_range


@pytest.mark.parametrize("noise", [1e-9, 1e-7])
def test_noise_of_loads_in_phase_slips_nowhere(noise: float) -> None:
    # dQ/dP = .2 f but for noise, that of each cycle its own: .022 +- .040 before.
    wave = np.cos(loop(16, 3))
    p, q = LOAD * (1 + 0.25 * wave), 0.1 * LIMIT * wave
    q += noise * LOAD * np.random.default_rng(5).standard_normal(len(q))
    summary = solved(problem(p, q, frictional_press=True, cycle=16), 100)
    assert summary.reported_dissipation == 0.0 < summary.dissipation_spread < 1e-9
    for edge in summary.stations:
        assert [(zone.length, zone.resolved) for zone in edge.evaluated_zones] == [(0.0, True)]
        assert edge.k_range > 0 == edge.told_range[0]


@pytest.mark.parametrize("share", [0.1, 0.6])
def test_loads_in_proportion_make_no_slip(share: float) -> None:
    # Q/P < f from zero on: what nodes move before they touch is no slip.
    load = LOAD * np.linspace(0.4, 1.0, 4)
    assert_still(solved(problem(load, share * FRICTION * load, frictional_press=True)))


def test_k_t_returns_in_a_steady_cycle_that_counts_whole() -> None:
    # P and Q out of phase: increments on an edge that moves would add up to a tenth of the range.
    angle = loop(12, 3)
    p, q = LOAD * (1 + 0.4 * np.sin(angle)), -0.3 * LIMIT * np.cos(angle)
    summary = solved(problem(p, q, frictional_press=True, cycle=12))
    for edge in summary.stations:
        assert abs(edge.k_t[-1] - edge.k_t[-13]) < 1e-12 * edge.k_t_range
        assert edge.cycles.closed and edge.cycles.count.tolist() == [1.0]
        assert not edge.cycles.irregular


PROFILES: dict[str, Profile] = {
    "wedge": Wedge(0.01, 100.0),
    "flat and rounded, b/a .5": FlatRounded(0.5, 20.0, 100.0),
    "flat and rounded, b/a .9": FlatRounded(0.9, 2.0, 100.0),
}


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_other_profiles(profile: Profile) -> None:
    load = float(profile.load(1.0))
    q = 0.4 * FRICTION * load * np.cos(loop(16, 2))
    summary = solved(problem(load, started(q), profile=profile, cycle=16))
    expected = 1.0 - float(PartialSlip(profile, load, FRICTION).stick_half_width(q.max()))
    scale = 1.0 - max(profile.kinks)
    for zones in last_zones(summary):
        assert zones == pytest.approx((expected, expected), abs=0.002 * scale)


def test_friction_work() -> None:
    q1 = 0.4 * LIMIT
    given = problem(LOAD, started(q1 * np.cos(loop(20, 2))), cycle=20)
    summary = solved(given)
    expected = float(hertz_dissipation(HERTZ, LOAD, FRICTION, q1))
    # At constant P however many steps there are; .02 % is the mesh.
    assert summary.dissipation == pytest.approx(expected, rel=0.001)


def test_shear_factor_counts_both_loads() -> None:
    summary = solved(problem(LOAD, [0.05, 0.1], 0.0, [0.1, 0.2]))
    for edge, side in zip(summary.stations, SIDES, strict=True):
        expected = float(tangential_factor(0.1, 0.2, 1.0, side))
        assert edge.k_t[-1] == pytest.approx(expected, rel=1e-4)


def test_speed() -> None:
    """60 steps with 300 elements take 3 times as long as 60 inverses of order 400, at most 6."""
    given = problem(LOAD, started(0.3 * LIMIT * np.cos(loop(60, 1))), cycle=60)
    matrix = np.random.default_rng(0).normal(size=(400, 400))

    def seconds(work: Callable[[], object]) -> float:
        start = time.process_time()
        work()
        return time.process_time() - start

    def inverses() -> None:
        for _ in range(60):
            np.linalg.solve(matrix, matrix)

    assert any(seconds(lambda: solved(given)) < 6 * seconds(inverses) for _ in range(5))
