# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane problems next to edges of unlike bodies against half-planes with coupling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.halfplane_problems import HERTZ, LOAD, loop, problem, solved, started

from fretfe._typing import Array
from fretfe.analytic.edges import oscillation, sliding_exponent
from fretfe.evaluate.factors import factors_at, whole_factor
from fretfe.evaluate.plane.slip import slip_border
from fretfe.evaluate.space.local import FAINT, MEAN_LENGTH
from fretfe.local.batches import solve_edges
from fretfe.local.half_planes import Contacts
from fretfe.local.problem import EdgeHistories, EdgeSlip

STEPS, HALF_WIDTH = 16, float(HERTZ.half_width(LOAD))
K_N = 2 * LOAD / (np.pi * HALF_WIDTH) * np.sqrt(2 / HALF_WIDTH)
UNIT = 1 / (np.pi * np.sqrt(2 * HALF_WIDTH))


def edges(
    beta: float,
    friction: float,
    shears: Array,
    angle: float = 0.0,
    antiplane: float = 1.0,
    cycle: int = STEPS,
) -> list[EdgeSlip]:
    """The edges of contacts under shears (S, T), as from the left edge inward."""
    k = UNIT * np.insert(shears, 0, 0.0, axis=1)
    last, count = k.shape[1] - 1, len(k)
    direction = np.tile([np.cos(angle), np.sin(angle)], (count, 1))
    halves = ((last - cycle, last - cycle // 2), (last - cycle // 2, last))
    given = EdgeHistories(
        contacts=Contacts(*(each * np.ones(count) for each in (HALF_WIDTH, K_N, 2.0))),
        k=k[..., None] * direction[:, None],
        k_i=0 * k,
        locked=np.zeros((len(k), 2)),
        direction=direction,
        zone=np.full(count, 0.05),
        halves=(halves,) * count,
        counted=np.ones_like(k, dtype=bool),
        friction=np.full(count, friction),
        behind=(None,) * count,
        modulus=HERTZ.e_star * np.ones(count),
        tangential=np.tile(np.diag([1.0, antiplane]), (count, 1, 1)),
        cycle=(last - cycle, last),
        dundurs=beta,
    )
    return solve_edges(given)


def lengths(found: EdgeSlip) -> list[float]:
    assert not found.reason
    borders = [
        slip_border(each.s, each.slip, each.slip > FAINT * each.slip.max())
        for each in found.profiles.values()
    ]
    assert all(border.resolved for border in borders)
    return [border.length for border in borders]


def shear(friction: float, mean: float = 0.3, swing: float = 0.15) -> Array:
    return started(friction * LOAD * (mean + swing * np.cos(loop(STEPS, 2))))


@pytest.mark.parametrize(
    ("beta", "friction"),
    [
        (-0.07, 0.3),
        pytest.param(0.07, 0.8, marks=pytest.mark.slow),
        pytest.param(0.2, 0.8, marks=pytest.mark.slow),
        pytest.param(-0.2, 0.3, marks=pytest.mark.slow),
    ],
)
def test_slip_zones_are_those_of_half_planes(beta: float, friction: float) -> None:
    """Both edges, both directions: 1 %, .35 % at most is found; without beta it is 5 to 60 %."""
    loads = shear(friction)
    given = problem(LOAD, loads, friction=friction, cycle=STEPS)
    contact = solved(replace(given, dundurs=beta, guided=True))
    found = edges(beta, friction, np.array([loads, -loads]))
    for station, edge in zip(contact.stations, found, strict=True):
        exact = [zone.length for zone in station.slip_zones[-2:]]
        assert lengths(edge) == pytest.approx(exact, rel=0.01)


def test_no_beta_is_the_limit() -> None:
    loads = shear(0.5)[None]
    (similar,), (nearly,) = (edges(beta, 0.5, loads) for beta in (0.0, 1e-10))
    for one, other in zip(similar.profiles.values(), nearly.profiles.values(), strict=True):
        # Of unlike bodies the middle of the contact has a node of its own.
        inner = np.interp(other.s, one.s, one.slip)
        np.testing.assert_allclose(other.slip, inner, atol=1e-8 * one.slip.max())
    assert lengths(nearly) == pytest.approx(lengths(similar), rel=1e-8)
    assert nearly.work == pytest.approx(similar.work, rel=1e-8)


def law(beta: float, friction: float, angle: float) -> Array:
    """Lengths of backward and forward slip by f d K_N(d) = dK +- f dK_I, dQ = .3 f P."""
    found, cosine = [], np.cos(angle)
    swing = UNIT * 0.3 * friction * LOAD
    whole = np.cosh(np.pi * oscillation(beta)) * 1j * swing * cosine
    at_one = whole * np.exp(-1j * oscillation(beta) * np.log(2 * HALF_WIDTH))
    for sign in (-1, 1):
        length = 0.05
        k_n = K_N * MEAN_LENGTH ** (0.5 - sliding_exponent(beta, sign * friction * cosine))
        for _ in range(20):
            factors = np.array([at_one.real, at_one.imag, swing * np.sin(angle)])
            k_i, *k = factors_at(factors, beta, length)
            length = float((np.hypot(*k) + sign * friction * k_i) / (friction * k_n))
        found.append(length)
    return np.array(found)


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.0, np.pi / 2])
def test_vector_of_factors_with_beta(angle: float) -> None:
    """Between in-plane shear and shear along the edge, where beta counts no more, to first order.

    Without the formula's own error d/(2a) 0.7 f |beta| cos(angle) is left at most, of which up to
    .55 is found.
    """
    beta, friction = 0.07, 0.8
    loads = shear(friction, mean=0.0)[None]
    exact = np.array(lengths(edges(beta, friction, loads, angle)[0]))
    first_order = exact * (1 - exact / (2 * HALF_WIDTH))
    error = np.abs(law(beta, friction, angle) / first_order - 1)
    assert error.max() < 0.7 * friction * beta * np.cos(angle) + 0.005
    similar = lengths(edges(0.0, friction, loads, angle)[0])
    if angle == np.pi / 2:
        assert exact == pytest.approx(similar, rel=2e-3)
    else:
        assert np.ptp(exact) > friction * beta * np.cos(angle) * np.mean(similar)


def test_factors_are_found_again_at_another_length() -> None:
    beta, length, wanted = 0.2, 0.03, 2.0
    at_one = np.array([[0.3, -1.2], [2.0, 0.1]])
    k_i, k_t = factors_at(at_one, beta, length).T
    whole = (at_one @ [1, 1j]) * np.exp(1j * oscillation(beta) * np.log(wanted))
    assert whole_factor(k_i, k_t, beta, length, wanted) == pytest.approx(whole)
