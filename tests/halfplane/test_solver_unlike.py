# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes of unlike materials: pressure and shear depend on each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases import pad_cases
from cases.halfplane_problems import HERTZ, LOAD, evaluated, loop, problem, solved, started
from cases.pad_cases import pad, press
from scipy.optimize import brentq
from scipy.special import ellipkm1

from fretfe._typing import Array
from fretfe.analytic.edges import oscillation, sliding_exponent
from fretfe.backends.halfplane import BACKEND as HALFPLANE
from fretfe.case import parse_case
from fretfe.evaluate.edge_fit import WINDOW
from fretfe.evaluate.plane.edge_fits import edge_fits
from fretfe.evaluate.plane.unit_factors import half_plane_units
from fretfe.evaluate.verdicts import longest_verdict
from fretfe.halfplane import solve_half_planes
from fretfe.halfplane.solver import build_interface
from fretfe.history.solution import SLIP, ContactHistory
from fretfe.idealise import HalfPlaneProblem
from fretfe.local.hat_functions import HatFunctions
from fretfe.verdict import Verdict


def unlike(given: HalfPlaneProblem, beta: float, guided: bool = True) -> HalfPlaneProblem:
    return replace(given, dundurs=beta, guided=guided)


def solve(given: HalfPlaneProblem, elements: int = 300) -> ContactHistory:
    outcome = solve_half_planes(given, elements)
    assert outcome.failure is None
    return outcome.solution.contacts[0]


def test_coupling_is_that_of_uniform_tractions() -> None:
    # Shear q on body 2 opens: dg/dx = (2/E*) beta q.
    hats = HatFunctions(np.linspace(-1.0, 1.0, 41) ** 3)
    opening = hats.coupling() @ np.ones(len(hats.nodes))
    expected = 2 * hats.integrate(lambda x: x)
    # The hats do not add up to one in the outermost elements.
    assert opening[1:-1] == pytest.approx(expected[1:-1], abs=1e-12)
    assert hats.coupling() == pytest.approx(-hats.coupling().T)


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize(("beta", "friction"), [(0.07, 0.3), (0.2, 0.8), (-0.2, 0.8)])
def test_sliding_parabola(beta: float, friction: float, direction: float) -> None:
    """p = (E*/(2R)) sin(pi lambda) (x + (1 - lambda) L)^lambda (lambda L - x)^(1 - lambda).

    Galin's solution for a punch that slides without turning (Johnson 1985, section 2.8 for the
    integral equation), lambda at the left edge.
    """
    shear = direction * friction * LOAD * np.array([0.5, 0.8, 0.95, 0.99, 0.99999])
    contact = solve(unlike(problem(LOAD, shear, friction=friction), beta))
    exponent = sliding_exponent(beta, direction * friction)
    modulus, radius = HERTZ.e_star, HERTZ.radius
    length = np.sqrt(4 * LOAD * radius / (np.pi * modulus * exponent * (1 - exponent)))
    x, pressure = contact.surface.arc, contact.mean_traction[-1, :, 0]
    left, right = (1 - exponent) * length + x, exponent * length - x
    shape = np.maximum(left, 0) ** exponent * np.maximum(right, 0) ** (1 - exponent)
    expected = modulus / (2 * radius) * np.sin(np.pi * exponent) * shape
    inner = np.minimum(left, right) > 0.02
    assert np.abs(pressure - expected)[inner].max() < 2e-3
    assert pressure @ contact.surface.weights == pytest.approx(LOAD, rel=1e-6)


def stick_ratio(contact: ContactHistory) -> float:
    """Half-width of the stick zone over that of the contact, in the last state."""
    status, pressure = np.asarray(contact.status[-1]), contact.traction[-1, :, 0]
    touching = contact.surface.arc[pressure > 0]
    stuck = contact.surface.arc[(pressure > 0) & (status != SLIP)]
    return float(np.ptp(stuck) / np.ptp(touching))


def spence(ratio: float) -> float:
    """c/a of K(c/a)/K(sqrt(1 - (c/a)^2)) = f/beta: normal loading, first order in beta."""

    def excess(stick: float) -> float:
        return float(ellipkm1(1 - stick**2) / ellipkm1(stick**2)) - ratio

    return brentq(excess, 1e-6, 1 - 1e-12)


# The pressing of a parabola is that of flat punches, one after the other, with their ratio: .682 at
# f = beta = .2 by constant tractions over 160 elements of a half punch, coupled both ways.
@pytest.mark.parametrize(
    ("beta", "friction", "expected"),
    [*((0.01, ratio * 0.01, spence(ratio)) for ratio in (0.6, 1.0, 1.6)), (0.2, 0.2, 0.682)],
)
def test_normal_loading_slips_from_the_edges_inward(
    beta: float, friction: float, expected: float
) -> None:
    """The ratio of stick to contact does not change as the load grows (Spence 1975)."""
    # The edges pass one element at a time at most.
    forces = LOAD * np.geomspace(0.1, 1.0, 161)
    given = unlike(problem(forces, friction=friction, frictional_press=True), beta)
    outcome = solve_half_planes(given, 150)
    assert outcome.failure is None
    contact = outcome.solution.contacts[0]
    # The border stands between two nodes at either side, and the edge somewhere in the last step.
    element = float(np.diff(contact.surface.arc).max())
    assert stick_ratio(contact) == pytest.approx(expected, abs=element)
    for station in evaluated(outcome).stations:
        (zone,) = station.slip_zones
        assert zone.resolved and zone.spread < 0.03
        assert zone.length == pytest.approx(1 - expected, abs=zone.spread)
        # Formulas are those of shear.
        assert np.isnan(zone.prediction)


def test_no_beta_changes_nothing() -> None:
    given = problem(LOAD, [0.2, 0.4, 0.1], frictional_press=True)
    before, after = solve(given), solve(unlike(given, 1e-10, guided=False))
    difference: Array = np.abs(after.traction[-1] - before.traction[-1])
    assert difference.max() < 1e-8


def test_the_reaction_holds_a_guided_body() -> None:
    given = unlike(problem(LOAD, [0.3], friction=0.5), 0.2)
    turning = replace(given, guided=False)
    for each, guided in ((given, True), (turning, False)):
        contact = solve(each)
        moment = contact.traction[-1, :, 0] * contact.surface.arc @ contact.surface.weights
        assert (abs(moment) > 0.01 * LOAD) == guided


@pytest.mark.parametrize("guided", [True, False])
@pytest.mark.parametrize("beta", [0.0, 0.07, -0.25])
def test_factors_of_full_stick_are_those_of_the_solution(beta: float, guided: bool) -> None:
    """The traction over cosh(pi epsilon) X is a polynomial of first order in x, X as there."""
    given = unlike(problem(LOAD, [0.1], friction=0.5), beta, guided)
    outcome = solve_half_planes(given)
    contact = outcome.solution.contacts[0]
    fields = contact.full_stick.fields[contact.full_stick.area[-1]]
    touching = fields.any(axis=(1, 2))
    x = contact.surface.arc[touching]
    # Where the edges of the discrete increments stand hardly matters away from them.
    a, middle = (x[-1] - x[0]) / 2, (x[-1] + x[0]) / 2
    epsilon, inner = oscillation(beta), np.abs(x - middle) < 0.8 * a
    at = x[inner] - middle
    wave = ((a + at) / (a - at)) ** (1j * epsilon) / np.sqrt(a**2 - at**2)
    whole = fields[touching][inner, 0] + 1j * fields[touching][inner, 1]
    lines = np.linalg.lstsq(np.column_stack([np.ones_like(at), at]), whole / wave[:, None])[0]
    left, right = lines[0] - a * lines[1], np.conj(lines[0] + a * lines[1])
    expected = np.stack([left, right]) / np.sqrt(2 * a) * (2 * a) ** (-1j * epsilon)
    edges = middle + a * np.array([[-1.0], [1.0]])
    found = outcome.unit_factors(outcome.solution, contact, edges)
    (units,) = found.main
    k = units[0, :, 0] + 1j * units[0, :, 1]
    assert np.abs(k - expected).max() < 5e-3 * np.abs(expected).max()
    assert half_plane_units(edges).shape == (1, 2, 2, 4)


@pytest.mark.parametrize(("beta", "friction"), [(0.07, 0.3), (-0.07, 0.8), (0.2, 0.3)])
def test_slip_zones_are_those_that_the_factors_predict(beta: float, friction: float) -> None:
    limit = friction * LOAD
    shear = started(limit * (0.4 + 0.1 * np.cos(loop(16, 2))))
    given = unlike(problem(LOAD, shear, friction=friction, cycle=16), beta)
    for station in solved(given).stations:
        zone = station.slip_zones[-1]
        # Without (9)'s own error, d/(2a), what is left is of the order of f beta.
        expected = zone.length * (1 - zone.length / 2)
        assert zone.prediction == pytest.approx(expected, rel=0.5 * friction * abs(beta) + 0.005)
        assert longest_verdict(station).verdict == Verdict.AGREES
        assert abs(station.exponent - 0.5) == pytest.approx(
            np.arctan(friction * abs(beta)) / np.pi, rel=1e-3
        )
        assert station.reference_length == pytest.approx(zone.length, rel=0.2)


def test_factors_of_similar_bodies_are_the_limit() -> None:
    shear = started(0.2 * np.cos(loop(8, 2)))
    given = problem(LOAD, shear, cycle=8)
    similar, nearly = (solved(unlike(given, beta)) for beta in (0.0, 1e-10))
    for one, other in zip(similar.stations, nearly.stations, strict=True):
        assert other.k_n == pytest.approx(one.k_n, rel=1e-8, nan_ok=True)
        assert other.k_range == pytest.approx(one.k_range, rel=1e-8)
        assert other.slip_zones[-1].predicted == pytest.approx(
            one.slip_zones[-1].predicted, rel=1e-7
        )


def test_factors_at_a_length_of_choice() -> None:
    """K_N goes with the length to lambda - 1/2, K_I + i K_T turns; slip zones stay."""
    beta, friction, ratio = 0.2, 0.5, 4.0
    shear = started(friction * LOAD * (0.3 + 0.15 * np.cos(loop(8, 2))))
    given = unlike(problem(LOAD, shear, friction=friction, cycle=8), beta)
    own, first, second = (solved(given, 150, length) for length in (None, 0.02, ratio * 0.02))
    for station, one, other in zip(own.stations, first.stations, second.stations, strict=True):
        assert (one.reference_length, other.reference_length) == (0.02, ratio * 0.02)
        assert one.slip_zones == station.slip_zones == other.slip_zones
        power = ratio ** (one.exponent - 0.5)
        assert other.k_n[-1] == pytest.approx(power * one.k_n[-1], rel=1e-12)
        # K_T and K_I are told at different parts of the length.
        parts = np.log(0.25) + 3
        turn = np.exp(1j * oscillation(beta) * np.log(ratio))
        back = np.exp(1j * oscillation(beta) * parts)
        # From (Re at l/e^3, Im at l/4) to the whole number at l/e^3.
        whole, again = (
            each.k_i + 1j * (each.k_t - each.k_i * back.imag) / back.real for each in (one, other)
        )
        known = np.isfinite(whole)
        np.testing.assert_allclose(again[known], (whole * turn)[known], atol=1e-12)


@pytest.mark.parametrize("young", [210e3, 114e3])
def test_notes_tell_which_length(young: float) -> None:
    case = pad(
        edges={"reference_length": 0.02},
        loads={"press": press(), "shear": pad_cases.shear(steps=8)},
    )
    case["bodies"]["upper"] = {"young": young, "poisson": 0.3}
    answer = HALFPLANE.solve(parse_case(case))
    (note, *_) = (each for each in answer.notes if "reference_length" in each)
    assert ("has no effect" in note) == (young == case["bodies"]["lower"]["young"])
    if "no effect" not in note:
        assert "K_N at the length 0.02 (as edges.reference_length)" in note


def test_compliance_is_symmetric_and_positive() -> None:
    given = unlike(problem(LOAD), 0.3)
    hats = HatFunctions(np.sin(np.linspace(-np.pi / 2, np.pi / 2, 33)))
    interface = build_interface(given, hats)
    all_of_it = np.arange(2 * interface.size)
    matrix = interface.compliance.block(all_of_it, all_of_it)
    assert matrix == pytest.approx(matrix.T, abs=1e-15)
    assert np.linalg.eigvalsh(matrix)[0] > 0


@pytest.mark.parametrize(("beta", "friction"), [(0.07, 0.3), (-0.07, 0.8), (0.2, 0.8)])
def test_exponents_of_fits_are_lambda(beta: float, friction: float) -> None:
    """ln p = ln K + lambda ln s + c s at distances s from the edge, after loading one way.

    Next to the edge nodal values alternate; behind a third of the slip zone the power law ends.
    """
    shear = friction * LOAD * np.linspace(0.15, 0.75, 5)
    contact = solve(unlike(problem(LOAD, shear, friction=friction), beta))
    fits = edge_fits(contact, np.arange(len(contact.traction)))
    x, pressure = contact.surface.arc, contact.mean_traction[-1, :, 0]
    for fit, inward in zip(fits, (1.0, -1.0), strict=True):
        s = inward * (x - fit.position[-1])
        near = (s > 0.01) & (s < 0.12)
        terms = np.column_stack([np.ones(near.sum()), np.log(s[near]), s[near]])
        found = np.linalg.lstsq(terms, np.log(pressure[near]))[0][1]
        assert found == pytest.approx(sliding_exponent(beta, inward * friction), abs=0.01)


def test_error_bars_of_edges_hold_with_few_elements_to_a_slip_zone() -> None:
    """Where slip ends shear bends the pressure; fits that reach farther do not see it."""
    zone, wave = 0.12, np.cos(loop(8, 2))
    given = problem(LOAD, started(0.5 * LOAD * (0.2 + zone * wave)), friction=0.5, cycle=8)
    held = []
    for beta in (0.12, -0.2):
        finer, *others = (solve(unlike(given, beta), count) for count in (160, 24, 32, 40, 60))
        reversals = np.array([-5, -1]) + len(finer.traction)
        sliding = float(abs(sliding_exponent(beta, 0.5) - 0.5))
        known = [fit.at(zone, WINDOW, sliding) for fit in edge_fits(finer, reversals)]
        for contact in others:
            fits = [fit.at(zone, WINDOW, sliding) for fit in edge_fits(contact, reversals)]
            for fit, exact in zip(fits, known, strict=True):
                bar = np.hypot(fit.spread_position, exact.spread_position)
                held.append(np.abs(fit.position - exact.position) < bar)
                bar = np.hypot(fit.spread_k_n, exact.spread_k_n)
                held.append(np.abs(fit.k_n - exact.k_n) < bar)
    assert np.mean(held) > 0.95
