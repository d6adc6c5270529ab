# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge position and K_N from pressures with known answers, and their error bars; a = 1, E* = 1."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
import pytest
from cases.edge_contacts import (
    HERTZ,
    K_N_HERTZ,
    SIGN,
    both_sides,
    both_sizes,
    fitted,
    flat_rounded,
    hertz,
    phases,
)
from reference.halfplane_galerkin import graded_nodes, uniform_nodes

from fretfe._typing import Array
from fretfe.analytic._numerics import Side
from fretfe.analytic.profiles import FlatRounded, Hertz, Profile, Wedge, edge_factor_k_n


def projected(nodes: Array, function_of: Hertz) -> Array:
    """L2 projection of the Hertz pressure on the hats of the nodes inside the contact."""
    inside = np.flatnonzero(np.abs(nodes) < 1.0)
    h = np.diff(nodes)
    points, weights = np.polynomial.legendre.leggauss(40)
    # Many points per element keep the quadrature error at the square-root edge below 1e-4 of p.
    at = nodes[:-1, None] + h[:, None] * (points + 1) / 2
    share = function_of.pressure(at, 1.0) * weights * h[:, None] / 2
    right = np.zeros(nodes.size)
    right[:-1] += (share * (1 - points) / 2).sum(axis=1)
    right[1:] += (share * (1 + points) / 2).sum(axis=1)
    mass = np.zeros((nodes.size, nodes.size))
    rows = np.arange(h.size)
    mass[rows, rows] += h / 3
    mass[rows + 1, rows + 1] += h / 3
    mass[rows, rows + 1] = mass[rows + 1, rows] = h / 6
    p = np.zeros(nodes.size)
    p[inside] = np.linalg.solve(mass[np.ix_(inside, inside)], right[inside])
    return p


@both_sides
@both_sizes
@phases
def test_hertz_edge_and_k_n(h: float, phase: float, side: Side) -> None:
    contact = hertz(h, phase)
    fit = fitted(contact.x, contact.pressure, side)
    # Measured: K_N .03 %, edge .02 h at most. Required: .2 % and .1 h.
    assert fit.k_n == pytest.approx(K_N_HERTZ, rel=1e-3)
    assert fit.position == pytest.approx(SIGN[side], abs=0.05 * h)


@both_sides
@both_sizes
@phases
def test_hertz_sampled_at_the_nodes(h: float, phase: float, side: Side) -> None:
    x = uniform_nodes(h, phase)
    fit = fitted(x, HERTZ.pressure(x, 1.0), side)
    # The cubic is exact for Hertz: round-off, magnified by the extrapolation to the edge.
    assert fit.k_n == pytest.approx(K_N_HERTZ, rel=1e-9)
    assert fit.position == pytest.approx(SIGN[side], abs=1e-9)


@both_sides
@both_sizes
@phases
def test_hertz_projected_on_the_hats(h: float, phase: float, side: Side) -> None:
    x = uniform_nodes(h, phase)
    fit = fitted(x, projected(x, HERTZ), side)
    # Nodal values of the projection oscillate more next to the edge than those of a contact.
    assert fit.k_n == pytest.approx(K_N_HERTZ, rel=2e-3)
    assert fit.position == pytest.approx(SIGN[side], abs=0.1 * h)


@both_sides
@pytest.mark.parametrize("flat", [0.5, 0.8, 0.95])
@pytest.mark.parametrize(("relative_h", "tolerance"), [(0.02, 1e-2), (0.01, 5e-3)])
@pytest.mark.parametrize("phase", [0.0, 0.5])
def test_flat_and_rounded(
    flat: float, relative_h: float, tolerance: float, phase: float, side: Side
) -> None:
    contact = flat_rounded(flat, relative_h, phase)
    fit = fitted(contact.x, contact.pressure, side)
    # The square-root zone ends at a - b: 50 or 100 elements. Measured .6 % and .2 %, edge .08 h.
    assert fit.k_n == pytest.approx(
        float(edge_factor_k_n(FlatRounded(flat, 1, 1), 1.0)), rel=tolerance
    )
    assert fit.position == pytest.approx(SIGN[side], abs=0.1 * relative_h * (1 - flat))


@dataclass(frozen=True)
class Sampled:
    """Nodal values of an exact pressure; a = 1."""

    nodes: Array
    profile: Profile

    @property
    def k_n(self) -> float:
        return float(edge_factor_k_n(self.profile, 1.0))

    def draws(self, noise: float, count: int) -> tuple[Array, Array, Array, Array]:
        """Return errors and bars, (2 count,) each, of K_N (relative) and edge, at both sides."""
        exact = self.profile.pressure(self.nodes, 1.0)
        # The pressure of the wedge has no peak.
        peak = 1.0 if isinstance(self.profile, Wedge) else float(exact.max())
        noisy = [
            exact + noise * peak * np.random.default_rng(seed).standard_normal(self.nodes.size)
            for seed in range(1000, 1000 + count)
        ]
        p = np.where(exact > 0, np.maximum(noisy, 0.0), 0.0)
        left, right = fitted(self.nodes, p, "left"), fitted(self.nodes, p, "right")
        k_n = np.concatenate([left.k_n, right.k_n]) / self.k_n
        bar = np.concatenate([left.spread_k_n, right.spread_k_n]) / self.k_n
        shift = np.concatenate([left.position + 1, right.position - 1])
        bar_of_shift = np.concatenate([left.spread_position, right.spread_position])
        return np.abs(k_n - 1), bar, np.abs(shift), bar_of_shift


# Slope pi: the pressure of the wedge is arcosh(1/x).
WEDGE = Wedge(np.pi, 1.0)
SAMPLED = {
    "Hertz .02": Sampled(uniform_nodes(0.02, 0.3), HERTZ),
    "Hertz .015": Sampled(uniform_nodes(0.015, 0.3), HERTZ),
    "Hertz .01": Sampled(uniform_nodes(0.01, 0.3), HERTZ),
    "flat .5, 50": Sampled(graded_nodes(0.01, 0.05, 0.3), FlatRounded(0.5, 1.0, 1.0)),
    "flat .5, 100": Sampled(graded_nodes(0.005, 0.05, 0.3), FlatRounded(0.5, 1.0, 1.0)),
    "flat .8, 50": Sampled(graded_nodes(0.004, 0.05, 0.3), FlatRounded(0.8, 1.0, 1.0)),
    "flat .8, 100": Sampled(graded_nodes(0.002, 0.05, 0.3), FlatRounded(0.8, 1.0, 1.0)),
    "wedge .02": Sampled(uniform_nodes(0.02, 0.3), WEDGE),
    "wedge .01": Sampled(uniform_nodes(0.01, 0.3), WEDGE),
}


@pytest.mark.parametrize("name", ["Hertz .02", "Hertz .015", "Hertz .01"])
def test_error_bars_hold_the_truth_and_mean_something(name: str) -> None:
    error, bar, shift, bar_of_shift = SAMPLED[name].draws(0.005, 200)
    assert np.median(error) < 5e-3
    assert np.median(shift) < 5e-3
    # A 95 % bound; scatter of 200 draws: 1.5 %.
    assert np.mean(error < bar) >= 0.95
    assert np.mean(shift < bar_of_shift) >= 0.95
    # 2.9 for an ideal 95 % bound; the median error of 200 draws scatters by 10 %.
    assert np.median(bar) < 4 * np.median(error)
    assert np.median(bar_of_shift) < 4 * np.median(shift)


@pytest.mark.parametrize("noise", [0.001, 0.005, 0.01])
@pytest.mark.parametrize("name", SAMPLED)
def test_error_bars_hold_the_truth_at_other_noise_and_profiles(name: str, noise: float) -> None:
    error, bar, shift, bar_of_shift = SAMPLED[name].draws(noise, 100)
    # Required: 90 %; scatter of 100 draws: 3 %. Systematic errors of the series count here.
    assert np.mean(error < bar) >= 0.9
    assert np.mean(shift < bar_of_shift) >= 0.9


@both_sides
@pytest.mark.parametrize("name", SAMPLED)
def test_exact_pressures_are_within_the_bars(name: str, side: Side) -> None:
    sampled = SAMPLED[name]
    fit = fitted(sampled.nodes, sampled.profile.pressure(sampled.nodes, 1.0), side)
    assert abs(fit.k_n - sampled.k_n) < max(float(fit.spread_k_n), 1e-3 * sampled.k_n)
    assert abs(fit.position - SIGN[side]) < max(float(fit.spread_position), 1e-3)


def test_noise_in_proportion_to_the_pressure() -> None:
    sampled = SAMPLED["Hertz .01"]
    exact = sampled.profile.pressure(sampled.nodes, 1.0)
    random = np.random.default_rng(5).standard_normal((200, sampled.nodes.size))
    fit = fitted(sampled.nodes, exact * (1 + 0.005 * random), "left")
    error = np.abs(fit.k_n - sampled.k_n)
    assert np.mean(error < fit.spread_k_n) >= 0.95
    # Noise is taken as equal at all nodes, which is too much next to the edge: 5.2 measured.
    assert np.median(fit.spread_k_n) < 7 * np.median(error)


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.55, 0.8])
@pytest.mark.parametrize("flat", [0.5, 0.8, 0.95])
@pytest.mark.parametrize(
    ("elements", "tolerance"),
    # Elements at the edge over the rounded part, that grow inward: 8, 13, 18, 24 in all. Measured,
    # both sides: 9.3, 1.2, .4, .3 %; in the median 2, 1, .3, .05 %.
    [(12, 0.1), (25, 0.03), (50, 6e-3), (100, 5e-3)],
)
def test_coarse_meshes_are_within_the_bars(
    elements: int, tolerance: float, flat: float, phase: float
) -> None:
    contact = flat_rounded(flat, 1 / elements, phase)
    k_n = float(edge_factor_k_n(FlatRounded(flat, 1.0, 1.0), 1.0))
    fit = fitted(contact.x, contact.pressure, "left", solved=True)
    assert abs(fit.k_n - k_n) < min(float(fit.spread_k_n), tolerance * k_n)
    assert abs(fit.position + 1) < fit.spread_position
    # Bars are no excuse: at most 8, 1.2 and .33 % for 25, 50 and 100 elements; 12 may be too few.
    assert elements == 12 or fit.spread_k_n < 90 / elements**2 * k_n


@pytest.mark.parametrize("name", ["Hertz .01", "wedge .01"])
def test_bars_of_solved_pressures_shrink_with_the_elements(name: str) -> None:
    """No jump and no floor: elements of half the size have about a quarter of the bar."""
    fine = SAMPLED[name]
    p = fine.profile.pressure(fine.nodes, 1.0)
    bars = [
        float(fitted(fine.nodes[::step], p[::step], "left", solved=True).spread_k_n)
        for step in (1, 2, 4)
    ]
    ratios = np.divide(bars[1:], bars[:-1])
    # Measured: 3.8 and 3.8, 5 and 4.
    assert ((ratios > 3) & (ratios < 6)).all()


def test_far_positions_and_other_units_change_nothing() -> None:
    contact = hertz(0.02, 0.3)
    near = fitted(contact.x, contact.pressure, "left")
    far = fitted(40.0 + 1e-3 * contact.x, 1e6 * contact.pressure, "left")
    # Round-off of the positions: 40/1e-3 times 1e-16, magnified by the extrapolation.
    assert (far.position - 40.0) / 1e-3 == pytest.approx(near.position, abs=1e-6)
    assert far.k_n == pytest.approx(near.k_n * 1e6 / np.sqrt(1e-3), rel=1e-6)


def test_too_few_nodes_give_nan_and_no_confidence() -> None:
    x = np.linspace(-1.1, 1.1, 9)
    fit = fitted(x, HERTZ.pressure(x, 1.0), "left")
    assert np.isnan([fit.position, fit.k_n]).all()
    assert np.isinf([fit.spread_position, fit.spread_k_n]).all()


def test_many_states_at_once() -> None:
    coarse, fine = hertz(0.02, 0.3), FlatRounded(0.5, 1.0, 1.0)
    # Of different size and place: windows of one state are too long for another.
    p = np.array([coarse.pressure, fine.pressure(4 * coarse.x - 1, 1.0)])
    together = fitted(coarse.x, p[:, None], "right")
    one, other = (fitted(coarse.x, state, "right") for state in p)
    assert together.k_n.shape == (2, 1)
    # Nothing but the order of the sums may differ.
    alone = np.transpose([astuple(one), astuple(other)])[..., None]
    np.testing.assert_allclose(astuple(together), alone, rtol=1e-9)


def test_a_flat_pressure_has_no_edge() -> None:
    fit = fitted(np.arange(40.0), np.ones(40), "left")
    assert np.isnan([fit.position, fit.k_n]).all()
