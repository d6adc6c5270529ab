# SPDX-License-Identifier: LGPL-3.0-or-later
"""All that one state of sampled tractions tells, against Cattaneo and Mindlin; a = 1, E* = 1."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest
from cases.edge_contacts import FRICTION, HERTZ, HERTZ_LOAD, K_N_HERTZ, SIGN, hertz
from reference.halfplane_galerkin import graded_nodes, uniform_nodes

from fretfe._typing import Array
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.profiles import FlatRounded, Profile, edge_factor_k_n
from fretfe.evaluate import EdgeAnalysis, Estimate, TractionAnalysis, analyse_tractions


@dataclass(frozen=True)
class Sampled:
    """Point values of exact tractions and slip at a shear force of ``share`` f P."""

    nodes: Array
    share: float = 0.3
    profile: Profile = HERTZ

    @property
    def problem(self) -> PartialSlip:
        return PartialSlip(self.profile, float(self.profile.load(1.0)), FRICTION)

    @property
    def force(self) -> float:
        return self.share * FRICTION * self.problem.normal_force

    @property
    def slip_length(self) -> float:
        return 1 - float(self.problem.stick_half_width(self.force))

    @cached_property
    def exact(self) -> Array:
        """Pressure, shear and slip, (3, n)."""
        x, problem = self.nodes, self.problem
        slip = np.where(np.abs(x) < 1, problem.slip(np.clip(x, -1, 1), self.force), 0.0)
        return np.array([self.profile.pressure(x, 1.0), problem.shear(x, self.force), slip])

    def fields(self, noise: float = 0.0, seed: int = 0) -> tuple[Array, Array, Array]:
        """Return pressure, shear, slip (n,) with noise relative to their peaks, in contact only."""
        scale = noise * np.abs(self.exact).max(axis=1, keepdims=True)
        random = np.random.default_rng(seed).standard_normal(self.exact.shape)
        p, q, slip = self.exact + np.where(np.abs(self.nodes) < 1, scale * random, 0.0)
        return np.maximum(p, 0.0), q, slip

    def analyse(self, noise: float = 0.0, seed: int = 0) -> TractionAnalysis:
        p, q, slip = self.fields(noise, seed)
        return analyse_tractions(self.nodes, p, q, slip, FRICTION)

    def errors(self, edge: EdgeAnalysis) -> list[list[float]]:
        """Return error and bar of K_N (relative), edge and both slip lengths."""
        k_n = float(edge_factor_k_n(self.profile, 1.0))
        truth = (
            (edge.k_n, k_n, k_n),
            (edge.position, SIGN[edge.side], 1.0),
            (edge.slip_from_slip, self.slip_length, 1.0),
            (edge.slip_from_traction, self.slip_length, 1.0),
        )
        return [
            [abs(found.value - exact) / scale, found.spread / scale]
            for found, exact, scale in truth
        ]

    def draws(self, noise: float, count: int) -> tuple[Array, Array]:
        """Return errors and bars, (2 count, 4) each, of both edges."""
        rows = [
            self.errors(edge)
            for seed in range(1000, 1000 + count)
            for edge in self.analyse(noise, seed).edges
        ]
        errors, bars = np.moveaxis(np.array(rows), -1, 0)
        return errors, bars


def close(estimate: Estimate, exact: float, scale: float = 1.0) -> bool:
    return abs(estimate.value - exact) < max(estimate.spread, 1e-3 * scale)


@pytest.mark.parametrize("share", [0.15, 0.3, 0.6, 0.8])
@pytest.mark.parametrize("h", [0.02, 0.01])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_exact_fields(share: float, h: float, sign: float) -> None:
    sampled = Sampled(uniform_nodes(h, 0.3), share)
    p, q, slip = sampled.fields()
    found = analyse_tractions(sampled.nodes, p, sign * q, sign * slip, FRICTION)
    for edge in found.edges:
        assert close(edge.k_n, K_N_HERTZ, K_N_HERTZ)
        assert close(edge.position, SIGN[edge.side])
        assert close(edge.slip_from_slip, sampled.slip_length)
        assert close(edge.slip_from_traction, sampled.slip_length)
        assert abs(edge.slip_from_slip.value - sampled.slip_length) < 0.1 * h
        assert edge.slip_length == edge.slip_from_slip
    # Trapezoidal sums of square roots: h^1.5.
    assert found.resultants.normal_force == pytest.approx(HERTZ_LOAD, rel=2e-3)
    assert found.resultants.shear_force == pytest.approx(sign * sampled.force, rel=5e-3)
    assert found.centre == pytest.approx(0.0, abs=1e-9)
    assert found.remarks == ()


@pytest.mark.parametrize("h", [0.02, 0.01])
def test_error_bars(h: float) -> None:
    errors, bars = Sampled(uniform_nodes(h, 0.3)).draws(0.005, 200)
    assert (np.median(errors, axis=0) < 5e-3).all()
    # A 95 % bound; scatter of 200 draws: 1.5 %.
    assert (np.mean(errors < bars, axis=0) >= 0.95).all()
    # 2.9 for an ideal 95 % bound; the scatter of the median errors is 10 %.
    assert (np.median(bars, axis=0) < 4 * np.median(errors, axis=0)).all()


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.001, 0.005, 0.01])
@pytest.mark.parametrize(
    "sampled",
    [
        Sampled(uniform_nodes(0.01, 0.3), 0.15),
        Sampled(uniform_nodes(0.01, 0.3), 0.6),
        Sampled(graded_nodes(0.005, 0.05, 0.3), 0.3, FlatRounded(0.5, 1.0, 1.0)),
        Sampled(graded_nodes(0.002, 0.05, 0.3), 0.3, FlatRounded(0.8, 1.0, 1.0)),
    ],
    ids=["Hertz, short", "Hertz, long", "flat .5", "flat .8"],
)
def test_error_bars_at_other_noise_and_profiles(sampled: Sampled, noise: float) -> None:
    errors, bars = sampled.draws(noise, 30)
    # Required: 90 %; scatter of 30 draws: 5 %.
    assert (np.mean(errors < bars, axis=0) >= 0.9).all()


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_fields_of_a_discrete_contact(share: float) -> None:
    contact = hertz(0.01, 0.3)
    q, slip, _ = contact.partial_slip(share * FRICTION * HERTZ_LOAD, FRICTION)
    found = analyse_tractions(contact.x, contact.pressure, q, slip, FRICTION)
    for edge in found.edges:
        exact = 1 - np.sqrt(1 - share)
        assert close(edge.slip_from_slip, exact)
        assert close(edge.slip_from_traction, exact)
    assert found.remarks == ()


@pytest.mark.parametrize("share", [0.15, 0.3, 0.6])
@pytest.mark.parametrize("phase", [0.0, 0.3, 0.55, 0.8])
def test_nodal_means(share: float, phase: float) -> None:
    # Means over the hats of a coarse mesh, by the trapezoidal rule on one that is 20 times finer.
    fine = Sampled(uniform_nodes(5e-4, 20 * phase), share)
    hat = 1 - np.abs(np.arange(-20, 21)) / 20
    x = fine.nodes[20:-20:20]
    p, q, slip = (np.convolve(field, hat / hat.sum(), "valid")[::20] for field in fine.exact)
    inside = np.abs(x) < 1
    found = analyse_tractions(x, inside * p, inside * q, inside * slip, FRICTION)
    for edge in found.edges:
        assert close(edge.k_n, K_N_HERTZ, K_N_HERTZ)
        assert close(edge.position, SIGN[edge.side])
        assert close(edge.slip_from_slip, fine.slip_length)
        assert close(edge.slip_from_traction, fine.slip_length)


def test_units_and_place_change_nothing() -> None:
    sampled = Sampled(uniform_nodes(0.02, 0.3))
    p, q, slip = sampled.fields(0.005)
    once = analyse_tractions(sampled.nodes, p, q, slip, FRICTION).edges[0]
    moved = analyse_tractions(30 + 4 * sampled.nodes, 9e5 * p, 9e5 * q, slip / 7, FRICTION).edges[0]
    # Round-off of the positions, magnified by the extrapolation.
    assert moved.k_n.value == pytest.approx(9e5 / 2 * once.k_n.value, rel=1e-6)
    assert moved.k_n.spread == pytest.approx(9e5 / 2 * once.k_n.spread, rel=1e-5)
    for one, other in (
        (once.slip_from_slip, moved.slip_from_slip),
        (once.slip_from_traction, moved.slip_from_traction),
    ):
        assert (other.value, other.spread) == pytest.approx((4 * one.value, 4 * one.spread), 1e-5)


def test_what_is_not_given_is_not_known() -> None:
    sampled = Sampled(uniform_nodes(0.02, 0.3))
    p, q, _ = sampled.fields()
    edge = analyse_tractions(sampled.nodes, p).edges[0]
    assert edge.k_n.known and not edge.slip_length.known
    assert edge.slip_from_slip.remark == "no slip given"
    assert edge.slip_from_traction.remark == "needs q and the friction coefficient"
    assert np.isnan(analyse_tractions(sampled.nodes, p).resultants.shear_force)
    edge = analyse_tractions(sampled.nodes, p, q, friction=FRICTION).edges[0]
    assert edge.slip_length == edge.slip_from_traction


def test_too_few_nodes() -> None:
    x = np.linspace(-1.1, 1.1, 9)
    edge = Sampled(x).analyse().edges[0]
    assert edge.k_n.remark == "7 nodes in contact, 10 are needed"
    assert edge.slip_length.remark == "the position of the edge is not known"
    assert np.isinf(edge.k_n.spread)


def test_rows_that_end_inside_the_contact() -> None:
    sampled = Sampled(uniform_nodes(0.02, 0.3))
    some = sampled.nodes > -0.5
    found = analyse_tractions(sampled.nodes[some], sampled.fields()[0][some])
    left, right = found.edges
    assert "the rows, end inside the contact" in left.position.remark
    assert close(right.position, 1.0)


def test_gross_slip() -> None:
    sampled = Sampled(uniform_nodes(0.02, 0.3))
    p, _, _ = sampled.fields()
    found = analyse_tractions(sampled.nodes, p, FRICTION * p, 1.0 * (p > 0), FRICTION)
    for edge in found.edges:
        assert edge.slip_from_slip.remark == "the whole contact slips"
        assert edge.slip_from_traction.remark == "the whole contact slips"


def test_no_slip() -> None:
    contact = hertz(0.02, 0.3)
    q = 0.1 * contact.pressure
    found = analyse_tractions(contact.x, contact.pressure, q, 0 * q, FRICTION)
    for edge in found.edges:
        assert edge.slip_from_slip.value == 0.0
        assert edge.slip_from_slip.spread < 0.05
        assert edge.slip_from_traction.remark == "|q| = f p at 0 nodes only, 3 are needed"


def test_wrong_friction_shows() -> None:
    sampled = Sampled(uniform_nodes(0.02, 0.3))
    p, q, _ = sampled.fields()
    edge = analyse_tractions(sampled.nodes, p, q, friction=0.8 * FRICTION).edges[0]
    assert edge.slip_from_traction.remark.startswith("|q| exceeds f p by up to")


def test_slip_and_tractions_that_disagree() -> None:
    x = uniform_nodes(0.01, 0.3)
    p, q, _ = Sampled(x, 0.3).fields()
    _, _, slip = Sampled(x, 0.6).fields()
    found = analyse_tractions(x, p, q, slip, FRICTION)
    assert len(found.remarks) == 2
    assert "differ by more than their errors" in found.remarks[0]


def test_two_patches() -> None:
    x = np.linspace(-1.5, 4.5, 601)
    p = HERTZ.pressure(x, 1.0) + HERTZ.pressure(x - 3.0, 0.5)
    found = analyse_tractions(x, p)
    assert found.edges[1].position.value == pytest.approx(1.0, abs=1e-6)
    assert found.remarks[0].startswith("2 separate patches are in contact")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0.0, 1.0, 1.0], [1.0, 1.0, 1.0]), r"differences of x must lie in \(0, inf\), found 0"),
        (([0.0, 1.0], [1.0, np.nan]), "p must lie in .*, found nan"),
        (([0.0, 1.0], [1.0, 1.0, 1.0]), r"p must have the shape \(2,\), that of x, found \(3,\)"),
        (([0.0, 1.0], [0.0, -1.0]), "p must exceed tol = 0 at one node at least, found none"),
        (([0.0], [1.0]), r"x must have the shape \(n,\), n >= 2, found \(1,\)"),
    ],
)
def test_wrong_input(arguments: tuple[list[float], list[float]], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        analyse_tractions(*arguments)
