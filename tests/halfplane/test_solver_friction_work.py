# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction work of nodes while P and Q go up and down together, against the loop in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, loop, problem, solved, started

from fretfe._typing import Array
from fretfe.analytic.partial_slip import hertz_dissipation
from fretfe.evaluate.contacts import Contact


def approach(load: Array | float) -> Array:
    """Normal approach by P but for what is in proportion: dδ/dP = -2 ln a/(π E*), a ~ √P."""
    return np.asarray(-load * (np.log(load) - 1) / (np.pi * HERTZ.e_star))


def loop_area(swing: float, share: float) -> float:
    """∮ Q du of P = P0 (1 ± swing) and Q = ± share f P0 in step, more than f dP.

    By Jäger: on the way up Q = f (P - 2 P1 + P*) + Q*, and u = f (δ - 2 δ1 + δ*), with P1 from the
    smallest P to P* = (P_max + P_min)/2 - ΔQ/(2 f), the permanent stick zone; on the way down
    Q = -f (P - 2 P2 + P*) + Q*, and so is u.
    """
    low, high, change = LOAD * (1 - swing), LOAD * (1 + swing), 2 * share * LIMIT
    stick = (low + high) / 2 - change / (2 * FRICTION)
    middle = FRICTION * (low - stick) - change / 2
    up = np.linspace(0, 1, 20001)
    normal, shear = low + (high - low) * up, change * (up - 0.5)
    area = 0.0
    for sense, p, q in ((1, normal, shear), (-1, normal[::-1], shear[::-1])):
        border = (p + stick - sense * (q - middle) / FRICTION) / 2
        u = sense * FRICTION * (approach(p) - 2 * approach(border) + approach(stick))
        area += float(np.sum((q[1:] + q[:-1]) / 2 * np.diff(u)))
    return area


def solved_lines(swing: float, share: float, steps: int) -> Contact:
    """Straight lines from one extreme to the other."""
    way = 2 / np.pi * np.arcsin(np.cos(loop(steps, 2)))
    normal, shear = LOAD * (1 + swing * way), np.append(np.arange(0, 1, 0.25), way)
    normal = np.append(np.full(4, normal[0]), normal)
    return solved(problem(normal, share * LIMIT * shear, cycle=steps), elements=100)


def test_the_loop_at_constant_load_is_that_of_the_closed_form() -> None:
    exact = float(hertz_dissipation(HERTZ, LOAD, FRICTION, 0.4 * LIMIT))
    assert loop_area(1e-6, 0.4) == pytest.approx(exact, rel=1e-4)
    # However few steps there are: f p is the same all the way.
    assert solved_lines(0.0, 0.4, 2).dissipation == pytest.approx(exact, rel=3e-3)


@pytest.mark.parametrize(
    ("share", "steps", "tolerance"),
    # P goes from .935 to 1.065 of its mean, in one step, and in four and ten. With the shear at the
    # end of each step: +66, +4 and +1 %; +37 % at the larger share. The mesh: -2 %. In one step
    # nodes that the edge passes over do most of the work, at a pressure that is only estimated.
    [(0.15, 2, 0.13), (0.15, 8, 0.05), (0.15, 20, 0.03), (0.2, 2, 0.09)],
)
def test_normal_load_that_varies(share: float, steps: int, tolerance: float) -> None:
    assert solved_lines(0.065, share, steps).dissipation == pytest.approx(
        loop_area(0.065, share), rel=tolerance
    )


# At constant P the mesh is all there is, the more so the shorter the slip zones; else the pressure
# on the way, most of all in two steps, where the work is 35 % low at the smallest share.
@pytest.mark.parametrize(
    ("swing", "share"),
    [(0.0, 0.02), (0.0, 0.1), (0.0, 0.5), (0.065, 0.1), (0.065, 0.15), (0.065, 0.5), (0.3, 0.5)],
)
@pytest.mark.parametrize("steps", [2, 8])
def test_the_error_bar_holds(swing: float, share: float, steps: int) -> None:
    summary, exact = solved_lines(swing, share, steps), loop_area(swing or 1e-6, share)
    assert abs(summary.dissipation - exact) < summary.dissipation_spread < 0.6 * exact
    edges = [each.dissipation_spread for each in summary.stations]
    assert sum(edges) == pytest.approx(summary.dissipation_spread)


def test_work_that_may_be_all_error_is_not_told() -> None:
    summary = solved_lines(0.065, 0.1, 2)
    assert summary.reported_dissipation == summary.dissipation
    vague = replace(summary, dissipation_spread=1.01 * summary.dissipation)
    assert np.isnan(vague.reported_dissipation)


def test_work_of_nodes_that_do_not_slip_is_unknown() -> None:
    """Elements an eighth of the half-width long see nothing of a slip zone a hundredth of it."""
    shear = started(0.02 * LIMIT * np.sin(loop(8, 2)))
    summary = solved(problem(LOAD, shear, cycle=8), elements=32)
    assert summary.dissipation == 0.0
    assert np.isnan(summary.reported_dissipation)
    assert all(np.isnan(each.reported_dissipation) for each in summary.stations)
