# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones found and predicted, and steady cycles, against known answers; a = 1, E* = 1."""

from __future__ import annotations

import numpy as np
import pytest
from cases.edge_contacts import (
    FRICTION,
    HERTZ,
    HERTZ_LOAD,
    SIGN,
    both_sides,
    both_sizes,
    fitted,
    hertz,
    phases,
)
from reference.halfplane_galerkin import uniform_nodes

from fretfe._typing import Array, Bools
from fretfe.analytic._numerics import Side
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.evaluate.plane.section import plane_front
from fretfe.evaluate.plane.slip import slip_border
from fretfe.evaluate.slip import SlipBorder


def border_at(x: Array, slip: Array, slipping: Bools, edge: float, side: Side) -> SlipBorder:
    """The border at one front; arrays (n,) along the arc."""
    front = plane_front(side)
    return slip_border(front.distances(x, edge), front.from_front(slip), front.from_front(slipping))


@both_sides
@both_sizes
@phases
@pytest.mark.parametrize("share", [0.15, 0.3, 0.6])
def test_slip_border_of_a_discrete_contact(
    h: float, phase: float, share: float, side: Side
) -> None:
    contact = hertz(h, phase)
    _, slip, slipping = contact.partial_slip(share * FRICTION * HERTZ_LOAD, FRICTION)
    inside = contact.touching
    border = border_at(
        contact.x[inside],
        slip[inside],
        slipping[inside],
        float(fitted(contact.x, contact.pressure, side).position),
        side,
    )
    # Cattaneo and Mindlin. Measured .1 h at most where at least three nodes slip.
    assert border.resolved
    assert border.length == pytest.approx(1 - np.sqrt(1 - share), abs=0.15 * h)


@both_sides
@both_sizes
@phases
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_slip_border_of_the_exact_field(h: float, phase: float, noise: float, side: Side) -> None:
    problem = PartialSlip(HERTZ, HERTZ_LOAD, FRICTION)
    x = uniform_nodes(h, phase)
    x = x[np.abs(x) < 1.0]
    slip = problem.slip(x, 0.4 * FRICTION * HERTZ_LOAD)
    disturbed = slip * (1 + noise * np.random.default_rng(7).standard_normal(x.size))
    border = border_at(x, disturbed, slip > 0, SIGN[side], side)
    # The straight line through four nodes is h/50 off; .5 % noise adds about h/50.
    assert border.length == pytest.approx(1 - np.sqrt(0.6), abs=0.1 * h)


def test_round_off_of_sticking_nodes_is_no_noise() -> None:
    problem = PartialSlip(HERTZ, HERTZ_LOAD, FRICTION)
    x = uniform_nodes(0.02, 0.3)
    x = x[np.abs(x) < 1.0]
    slip = problem.slip(x, 0.4 * FRICTION * HERTZ_LOAD)
    disturbed = np.where(slip > 0, slip, 1e-12 * slip.max())
    exact = border_at(x, slip, slip > 0, -1.0, "left")
    assert border_at(x, disturbed, slip > 0, -1.0, "left") == exact
    coarse = border_at(x, np.where(slip > 0, slip, 1e-3 * slip.max()), slip > 0, -1.0, "left")
    assert coarse != exact


def test_slip_in_the_negative_direction() -> None:
    x = np.linspace(-0.99, 0.99, 100)
    slip = PartialSlip(HERTZ, HERTZ_LOAD, FRICTION).slip(x, 0.4 * FRICTION * HERTZ_LOAD)
    forward = border_at(x, slip, slip > 0, -1.0, "left")
    assert border_at(x, -slip, slip > 0, -1.0, "left") == forward


def pattern(statuses: str) -> tuple[Array, Array, Bools]:
    """Nodes 0, 1, ... of which those with an s slip by 1 each."""
    slipping = np.array([status == "s" for status in statuses])
    return np.arange(float(slipping.size)), slipping.astype(float), slipping


@both_sides
def test_no_slip(side: Side) -> None:
    border = border_at(*pattern("......"), edge=2.5 + 3 * SIGN[side], side=side)
    assert (border.length, border.resolved, border.gross) == (0.0, True, False)


@pytest.mark.parametrize("statuses", ["ssssss", ".sssss"])
def test_gross_slip(statuses: str) -> None:
    border = border_at(*pattern(statuses), edge=-0.5, side="left")
    assert np.isnan(border.length)
    assert border.gross


@pytest.mark.parametrize(("statuses", "length"), [("s.....", 1.0), (".s....", 2.0)])
def test_a_zone_of_too_few_nodes_is_flagged(statuses: str, length: float) -> None:
    border = border_at(*pattern(statuses), edge=-0.5, side="left")
    # Half an element inside the last slipping node.
    assert border.length == length
    assert not border.resolved


def test_a_line_through_three_nodes_of_less_slip_outside_has_a_bar_that_says_so() -> None:
    """The outer node came into contact late: two nodes and three give different borders."""
    s = np.array([0.0038, 0.0137, 0.0236, 0.0335, 0.0434, 0.0533])
    slip = np.array([2.386e-3, 2.018e-3, 1.171e-3, 2.7e-4, 0.0, 0.0]) ** 1.5
    border = slip_border(s, slip, slip > 0)
    assert abs(border.length - 0.0365) < border.spread < 0.01
    even = slip_border(s, np.maximum(0.0365 - s, 0.0) ** 1.5, slip > 0)
    assert abs(even.length - 0.0365) < 1e-12
    assert even.spread < border.spread / 2


def test_slip_that_does_not_fall_inward_is_flagged() -> None:
    border = border_at(*pattern("ssss.."), edge=-0.5, side="left")
    assert (border.length, border.resolved) == (4.0, False)


def test_only_the_zone_at_the_edge_counts() -> None:
    border = border_at(*pattern("..ss.."), edge=-0.5, side="left")
    assert border.length == 0.0
