# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of a made-up history whose border is known."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from cases.edge_histories import edge_history

from fretfe.analytic._numerics import Side
from fretfe.evaluate.contacts import StationHistory
from fretfe.evaluate.cycles import reversals
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.growth import zone_growth
from fretfe.evaluate.plane.edge_fits import edge_fits
from fretfe.evaluate.plane.section import PlaneFront, plane_front
from fretfe.evaluate.plane.slip import slip_border_of
from fretfe.evaluate.slip import SlipBorder, slip_in_steps, slip_zones
from fretfe.evaluate.warnings import plane_warnings
from fretfe.history.solution import OPEN, SLIP, STICK, ContactHistory, FullStickUnits
from fretfe.reason import Kind
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.friction import Friction

H, EDGE, ZONE = 0.05, 1.02, 0.31
X = np.linspace(-22 * H, 22 * H, 45)
CLOSED = np.abs(X) < EDGE
STATES = 4  # unloaded, pressed, two steps of shear
FRICTION = np.array([0.0, 0.0, 0.5, 0.5])


def history(increments: np.ndarray, x: np.ndarray = X) -> ContactHistory:
    """A solved history with slip increments (2, N) in its last two steps, at nodes x (N,)."""
    closed = np.abs(x) < EDGE
    status = np.where(closed, STICK, OPEN) * np.ones((STATES, 1), int)
    status[2:][increments != 0] = SLIP
    slip = np.cumsum(np.vstack([np.zeros((2, len(x))), increments]), axis=0)[:, :, None]
    traction = np.zeros((STATES, len(x), 2))
    traction[1:, closed, 0] = np.sqrt(EDGE**2 - x[closed] ** 2)
    zero = np.zeros((STATES, len(x)))
    return ContactHistory(
        name="made up",
        pair="made up",
        body1="upper",
        body2="lower",
        surface=ContactSurface(
            arc=x,
            points=np.stack([x, 0 * x], axis=1),
            frames=np.zeros((len(x), 2, 2)),
            weights=np.gradient(x),
        ),
        friction=Friction.uniform(FRICTION, len(x)),
        traction=traction,
        mean_traction=traction,
        gap=zero,
        slip=slip,
        status=status.astype(np.int8),
        dissipation=zero,
        full_stick=FullStickUnits(np.zeros((0, len(x), 2, 0)), np.full(STATES, -1)),
    )


def station(front: PlaneFront, k_t: np.ndarray) -> StationHistory:
    """A station at the edge with K_N = 1."""
    position = np.array([np.nan, *[-front.inward * EDGE] * 3])
    return edge_history(k_t, front=front.name, position=position)


def length(side: Side, increments: np.ndarray, x: np.ndarray = X) -> float:
    contact = history(increments, x)
    front = plane_front(side)
    at_edge = station(front, np.array([0.0, 0.0, 0.5, 1.0]))
    no_cycle = np.array([], dtype=np.int64)
    border = slip_border_of(contact, front, at_edge.position, np.zeros(STATES), 2)
    zones = slip_zones(no_cycle, FRICTION, at_edge, border)
    assert [(zone.start, zone.end, zone.resolved) for zone in zones] == [(1, 3, True)]
    return zones[0].length


def slip_to(zone: float, x: np.ndarray = X) -> np.ndarray:
    """(N,) means of a slip with the power 3/2 over the hat functions of the nodes x (N,) in it."""
    grid = np.concatenate([x[:1] - H, x, x[-1:] + H])
    second = np.maximum(zone - (EDGE - np.abs(grid)), 0.0) ** 3.5 / (2.5 * 3.5)
    means = np.diff(np.diff(second) / np.diff(grid)) * 2 / (grid[2:] - grid[:-2])
    return np.where((EDGE - zone < np.abs(x)) & (np.abs(x) < EDGE), means, 0.0)


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("side", ["left", "right"])
def test_border(side: Side, direction: float) -> None:
    increments = direction * np.array([slip_to(ZONE / 2), slip_to(ZONE) - slip_to(ZONE / 2)])
    # Off by .04 H if the means stood at the nodes, of which a tenth is left.
    assert length(side, increments) == pytest.approx(ZONE, abs=5e-3 * H)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("ratio", [0.9, 1.1])
def test_border_where_elements_grow_along_the_contact(side: Side, ratio: float) -> None:
    """Hat functions have their centres beside the nodes then, by a thirtieth of an element."""
    inward = np.cumsum(ratio ** np.arange(30.0))
    half = np.append(0.0, inward) * (EDGE + H) / inward[-1]
    x = np.concatenate([-half[:0:-1], half])
    place = int(np.searchsorted(half, EDGE - ZONE))
    size = float(half[place] - half[place - 1])
    found = length(side, np.array([0 * x, slip_to(ZONE, x)]), x)
    assert found == pytest.approx(ZONE, abs=0.01 * size)


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("side", ["left", "right"])
def test_slip_left_over_from_the_half_cycle_before_does_not_count(
    side: Side, direction: float
) -> None:
    increments = np.array([0 * X, slip_to(ZONE)])
    inside = np.flatnonzero(CLOSED & (EDGE - np.abs(X) > ZONE))[[0, 1, -2, -1]]
    increments[0, inside] = -0.01 * slip_to(ZONE).max()
    assert length(side, direction * increments) == pytest.approx(ZONE, abs=5e-3 * H)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(
    ("elements", "resolved"), [(0.0005, True), (0.05, False), (0.5, False), (3.0, False)]
)
def test_a_zone_between_the_nodes_is_not_resolved(
    side: Side, elements: float, resolved: bool
) -> None:
    """No node slips, and the edge formula predicts a zone of so many elements."""
    contact = history(np.zeros((2, len(X))))
    front = plane_front(side)
    # K_N = 1, f = 0.5: d = 2 K_T/(f K_N) at first loading
    k_t = np.array([0.0, 0.0, 0.5, 1.0]) * elements * H / 4
    at_edge = station(front, k_t)
    border = slip_border_of(contact, front, at_edge.position, np.zeros(STATES), 2)
    no_cycle = np.array([], dtype=np.int64)
    (zone,) = slip_zones(no_cycle, FRICTION, at_edge, border)
    assert zone.predicted == pytest.approx(elements * H)
    assert (zone.length, zone.resolved, zone.gross) == (0.0, resolved, False)
    # No slip is a length where nodes would show it; else the bar is all that is known.
    assert (zone.hides, zone.uncertain) == (not resolved, not resolved)
    np.testing.assert_equal(zone.reported_length, 0.0 if resolved else np.nan)
    assert resolved or zone.spread >= zone.predicted


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_zone_is_as_good_as_its_edge(side: Side) -> None:
    """An edge that is off by 1.6 elements leaves a zone of three elements open."""
    contact = history(np.array([0 * X, slip_to(3 * H)]))
    front = plane_front(side)
    # K_N = 1, f = 0.5: a zone of three elements is predicted.
    exact = station(front, np.array([0.0, 0.0, 0.5, 1.0]) * 3 * H / 4)
    no_cycle = np.array([], dtype=np.int64)
    border = slip_border_of(contact, front, exact.position, np.zeros(STATES), 2)
    (good,) = slip_zones(no_cycle, FRICTION, exact, border)
    vague = replace(exact, position_spread=np.full(STATES, 1.6 * H))
    (bad,) = slip_zones(no_cycle, FRICTION, vague, border)
    assert (good.resolved, bad.resolved) == (True, False)
    assert bad.length == good.length == pytest.approx(3 * H, abs=good.spread)
    assert bad.spread == pytest.approx(np.hypot(good.spread, 1.6 * H))
    assert np.isnan(bad.reported_length) and good.reported_length == good.length
    # Its bar then reaches what is predicted.
    longer = replace(vague, k_t=2 * vague.k_t, shear=2 * vague.shear)
    (worse,) = slip_zones(no_cycle, FRICTION, longer, border)
    assert worse.spread == pytest.approx(6 * H - worse.length)
    (kept,) = slip_zones(
        no_cycle, FRICTION, replace(exact, k_t=2 * exact.k_t, shear=2 * exact.shear), border
    )
    assert kept.spread == good.spread


@pytest.mark.parametrize("side", ["left", "right"])
def test_slip_that_goes_on_behind_the_first_sticking_node(side: Side) -> None:
    increments = np.array([0 * X, slip_to(ZONE)])
    depth = EDGE - np.abs(X)
    behind = np.flatnonzero(CLOSED & (depth > ZONE + 2 * H) & (depth < ZONE + 5 * H))
    increments[1, behind] = 0.1 * slip_to(ZONE).max()
    contact = history(increments)
    front = plane_front(side)
    at_edge = station(front, np.array([0.0, 0.0, 0.5, 1.0]))
    border = slip_border_of(contact, front, at_edge.position, np.zeros(STATES), 2)
    no_cycle = np.array([], dtype=np.int64)
    (zone,) = slip_zones(no_cycle, FRICTION, at_edge, border)
    assert not zone.resolved
    # The bar reaches the innermost node that slips.
    assert zone.length + zone.spread >= depth[behind].max() - 1e-12


def border_that_is_not_driven(front: PlaneFront, increments: np.ndarray) -> SlipBorder:
    """As P and Q rise together: dK_T < f dK_I."""
    k_i = np.array([0.0, 0.0, 1.0, 0.0])
    at_edge = edge_history(0 * k_i, k_i, front.name, -front.inward * EDGE * np.ones(STATES))
    memory = EdgeMemory.of(at_edge, FRICTION, 3)
    assert memory is not None
    growth = zone_growth(memory, 1, 3, np.ones(STATES, dtype=bool))
    assert growth is not None and growth.nothing
    contact, least = history(increments), np.zeros(STATES)
    return slip_border_of(contact, front, at_edge.position, least, 2, lambda *_: growth)(1, 3)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("slide", "resolved"), [(0.005, True), (0.12, False)])
def test_half_a_contact_that_slides_though_its_edge_drives_none(
    side: Side, slide: float, resolved: bool
) -> None:
    """A dovetail of 40° on its way to a steady cycle: 0 ± .006 or 4.06 of 4.4 by its mesh."""
    front = plane_front(side)
    others = np.where(front.inward * X > 0, slip_to(ZONE), 0.0)
    here = np.where(CLOSED & (front.inward * X < ZONE), slide * others.max(), 0.0)
    border = border_that_is_not_driven(front, np.array([others, here]))
    assert (border.resolved, border.gross) == (resolved, False)
    lowest, highest = border.length - border.spread, border.length + border.spread
    # All that slides, or none.
    assert lowest <= 0.0 and (highest >= EDGE) == (not resolved)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("slide", [1e-3, 1.0])
def test_a_contact_that_slides_is_gross_at_an_edge_that_drives_no_slip(
    side: Side, slide: float
) -> None:
    front = plane_front(side)
    others = np.where(front.inward * X > 0, slip_to(ZONE), 0.0)
    sliding = np.where(CLOSED, slide * others.max(), 0.0)
    assert border_that_is_not_driven(front, np.array([others, sliding])).gross


def test_slip_at_an_edge_that_drives_none_is_not_resolved() -> None:
    """P alone moves it to and fro: nothing is foretold, and what nodes say is in the bar."""
    at_edge = edge_history(np.zeros(4), np.array([0.0, 0.01, 0.0, 0.01]))
    found = SlipBorder(1.3, resolved=True, gross=False, spread=0.001)
    (zone,) = slip_zones(np.arange(1, 4), FRICTION, at_edge, lambda *_: found)
    assert (zone.prediction, zone.resolved) == (0.0, False)
    assert zone.spread >= 1.3


@pytest.mark.parametrize(("sticking", "resolved"), [(2, False), (3, True)])
def test_fewer_than_three_sticking_nodes_are_no_stick_zone(sticking: int, resolved: bool) -> None:
    inside = np.flatnonzero(CLOSED)
    middle = inside[len(inside) // 2 - 1 :][:sticking]
    # Zero at the outer one of three sticking nodes.
    slip = np.where(CLOSED, 1.0, 0.0) * np.maximum(np.abs(X - X[middle].mean()) - H, 0.0) ** 1.5
    slip[middle] = 0.0
    contact = history(np.array([0 * X, slip]))
    front = plane_front("left")
    at_edge = station(front, np.array([0.0, 0.0, 0.5, 1.0]))
    border = slip_border_of(contact, front, at_edge.position, np.zeros(STATES), 2)
    no_cycle = np.array([], dtype=np.int64)
    (zone,) = slip_zones(no_cycle, FRICTION, at_edge, border)
    assert zone.resolved == resolved


def test_what_is_no_slip() -> None:
    # Beside round-off of the solver, what nodes move before they touch.
    contact = history(np.array([0 * X, np.where(CLOSED, 1e-17, 0.0)]))
    least = np.full(STATES, 1e-13)
    assert not slip_in_steps(contact, 2, 3, least).any()
    assert slip_in_steps(contact, 2, 3, 0 * least).any()
    status = np.array(contact.status)
    status[3, CLOSED] = SLIP
    status[2, np.abs(X) > 0.8] = OPEN
    for true in (0.0, 0.1):
        slip = np.array(contact.slip)
        slip[3, :, 0] = slip[2, :, 0] + np.where(np.abs(X) > 0.8, 1.0, true)
        closing = replace(contact, status=status, slip=slip)
        found = slip_in_steps(closing, 2, 3, least)[0, CLOSED, 0]
        assert found == pytest.approx(np.full(np.count_nonzero(CLOSED), true))


@pytest.mark.parametrize("right_end", [X[-1] + H, X[-1] - 4 * H])
def test_no_edge_lies_outside_the_surface(right_end: float) -> None:
    # The contact ends with the bodies on the left, and on the right if it reaches that far.
    contact = history(np.zeros((2, len(X))))
    pressure = np.sqrt(np.maximum(right_end - X, 0.0))
    traction = np.stack([pressure, 0 * X], axis=1) * np.ones((STATES, 1, 1))
    left, right = edge_fits(replace(contact, traction=traction), np.arange(STATES))
    assert np.isnan([left.position, left.k_n]).all()
    if right_end > X[-1]:
        assert np.isnan([right.position, right.k_n]).all()
    else:
        assert right.position == pytest.approx(right_end, abs=0.2 * H)
        assert right.k_n == pytest.approx(1.0, rel=0.02)


REVERSALS = {
    "triangle": ([0, 1, 2, 1, 0, -1, 0], [2, 5, 6]),
    "monotonic": ([0, 1, 2, 3], [3]),
    "a hold is none": ([0, 1, 1, 2], [3]),
    "plateau": ([0, 1, 3, 3, 3, 2], [2, 5]),
    "late start": ([0, 0, 0, 1, 0, 0], [3, 4]),
    "constant": ([2, 2, 2], []),
    "falling first": ([0, -1, -2, 1, 0], [2, 3, 4]),
    "noise": ([0, 1, 1 - 1e-9, 1 + 1e-9, 2, 2 - 1e-9, 0], [4, 6]),
    "noisy plateau": ([0, 1, 1 + 1e-9, 0], [1, 3]),
}


@pytest.mark.parametrize(("values", "expected"), REVERSALS.values(), ids=REVERSALS)
def test_reversals_at_constant_normal_load(values: list[float], expected: list[int]) -> None:
    k_t = np.array(values, dtype=float)
    assert reversals(k_t).tolist() == expected


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("phase", [-60.0, 0.0, 30.0, 90.0])
def test_reversals_under_varying_normal_load(phase: float, sign: float) -> None:
    angle = np.arange(3 * 72 + 1) * np.radians(5)
    k_t, f_k_i = sign * np.sin(angle), 0.4 * np.sin(angle - np.radians(phase))
    at_edge = edge_history(k_t, 2 * f_k_i)
    memory = EdgeMemory.of(at_edge, np.full(len(angle), 0.5), len(angle) - 1)
    assert memory is not None
    # Each direction ends once a cycle, at the extreme of its own signal.
    drives = {1: k_t - f_k_i, -1: -k_t - f_k_i}
    halves = memory.half_cycles
    for half in halves[1:-1]:
        assert drives[half.way][half.turn] > 0.99 * drives[half.way].max()
    assert len(halves) >= 6


def test_bodies_that_have_parted_are_told() -> None:
    contact = history(np.zeros((2, len(X))))
    traction = np.array(contact.traction)
    traction[2:] = 0.0
    parted = replace(
        contact, traction=traction, status=np.zeros_like(contact.status), gap=0.1 + contact.gap
    )
    times = np.arange(float(STATES))
    solution = SimpleNamespace(
        cycle=(2, 3), choice=None, degree=2, step=None, times=times, values=times[:, None],
        loads=SimpleNamespace(open_channels=()),
    )  # fmt: skip
    told, *_ = plane_warnings(solution, parted, (), [np.nan], slides=False)  # type: ignore[arg-type]
    assert told.kind is Kind.PARTED
    assert "do not touch in the evaluated cycle, though they did before: the contact" in told.text
    assert "the smallest gap is 0.1" in told.text


@pytest.mark.parametrize(("fall", "known"), [(1e-6, True), (0.05, False)])
def test_half_cycles_in_which_friction_falls_are_unknown(fall: float, known: bool) -> None:
    """Over pressure the coefficient falls by what shear changes of it: a millionth."""
    at_edge = station(plane_front("left"), np.array([0.0, 0.5, -0.5, 0.5]))
    found = SlipBorder(0.5, resolved=True, gross=False, spread=0.001)
    falls = FRICTION * np.array([1.0, 1.0, 1.0, 1.0 - fall])
    zones = slip_zones(np.arange(1, 4), falls, at_edge, lambda *_: found)
    assert zones[-1].end == 3
    assert [zone.unknown for zone in zones[-1:]] == [not known]
    assert zones[-1].rank == (0.5 if known else np.inf)
