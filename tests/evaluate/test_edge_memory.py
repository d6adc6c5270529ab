# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where an edge slips if it draws back, covers places anew and shears them meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, PRESS_STEPS, problem, solved

from fretfe.evaluate.contacts import StationHistory
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.friction_behind import FrictionBehind

STEPS = 4


def d(edge: float, border: float) -> float:
    """Slip zone of a cylinder from its edge at one load to the half-width of another.

    With Q spread over the loads from 0 to P, as the pressure is over flat punches, each carries f
    at most (Jaeger 1998): the border is where punches that are larger have taken the change of Q.
    """
    return float(np.sqrt(edge) - np.sqrt(border))


# P and Q at the turns, over P and f P, and end and length of each zone, in ways from turn to turn.
HISTORIES: dict[str, tuple[list[tuple[float, float]], list[tuple[float, float]]]] = {
    # Punches from .7 to .95 carry -.6 f, and take 1.6 f each as Q turns.
    "sheared as it is covered": (
        [(1, 0), (0.7, 0), (0.95, -0.15), (0.95, -0.05)],
        [(3, d(0.95, 0.95 - 0.1 / 1.6))],
    ),
    "slip on new places does not come to that before": (
        [(1, 0), (1, 0.3), (1.3, 0.3), (1.3, 0.35)],
        [(1, d(1, 0.7)), (3, d(1.3, 1.25))],
    ),
    "slip on new places comes to that before": (
        [(1, 0), (1, 0.3), (1.1, 0.3), (1.1, 0.5)],
        [(3, d(1.1, 0.6))],
    ),
    "the last half cycle is not complete": (
        [(1, 0), (1, 0.5), (1, 0.2)],
        [(1, d(1, 0.5)), (2, d(1, 0.85))],
    ),
    # What they lose as P falls others take over.
    "P alone falls over places that are sheared": (
        [(1, 0), (1, 0.3), (0.8, 0.3)],
        [(2, d(0.8, 0.5))],
    ),
    # The longest zone each way. Punches from .923 to 1 come back with f and take .077; others turn.
    "both fall, and the way turns meanwhile": (
        [(1, 0), (0.923, -0.216), (1, 0.006), (0.714, -0.188), (0.851, -0.093), (0.8, -0.01)],
        [(1, d(0.923, 0.923 - 0.216)), (2, d(1, 0.923 - (0.222 - 0.077) / 2))],
    ),
}


@pytest.mark.parametrize("name", HISTORIES)
def test_zones_without_a_cycle(name: str) -> None:
    turns, expected = HISTORIES[name]
    ways = np.linspace(0.0, len(turns) - 1, STEPS * (len(turns) - 1) + 1)
    p, q = (np.interp(ways, range(len(turns)), each) for each in np.transpose(turns))
    for station in solved(problem(LOAD * p, LIMIT * q), 150).stations:
        ends = [(zone.end - PRESS_STEPS - 1) / STEPS for zone in station.slip_zones]
        assert ends == [end for end, _ in expected]
        for zone, (_, length) in zip(station.slip_zones, expected, strict=True):
            assert zone.length == pytest.approx(length, abs=zone.spread)
            assert zone.spread < 0.25 * length


# P and Q at states of a cylinder with a = 1 at P = 1 and f = .5, its f if that varies; ways of the
# half cycles, and loads P of the edges whose places their zones reach to.
FOLLOWED: dict[str, tuple[list[float], list[float], list[float], list[int], list[float]]] = {
    "steady": ([0, 1, 1, 1, 1], [0, 0, 0.15, -0.15, 0.15], [], [1, -1, 1], [0.7, 0.7, 0.7]),
    "loops": (
        [0, 1, 1, 1, 1, 1, 1], [0, 0, 0.2, -0.2, 0.1, -0.1, 0.2], [],
        [1, -1, 1, -1, 1], [0.6, 0.6, 0.7, 0.8, 0.6],
    ),
    "P and Q": (
        [0, 1, 0.6, 1.2, 0.8, 1], [0, 0.2, 0.05, 0.05, -0.2, 0.1], [], [-1, 1], [2 / 7, 0.6]
    ),
    "in proportion": (
        [0, 1, 1, 1, 1], [0, 0.15, 0.25, 0.05, 0.25], [], [1, -1, 1], [5 / 7, 0.8, 0.8]
    ),
    "farther in than any known place": ([0, 0.3, 1, 1], [0, 0, 0, 0.45], [], [1], [0.1]),
    "opened": ([0, 1, 1, 0, 1, 1], [0, 0, 0.2, 0, 0, 0.2], [], [1, 1], [0.6, 0.6]),
    "f falls": ([0, 1, 1, 1, 1], [0, 0, 0.15, 0.15, 0.15], [0, 0.5, 0.5, 0.4, 0.2], [1], [0.25]),
    "f rises": (
        [0, 1, 1, 1, 1, 1], [0, 0, 0.2, 0.2, -0.2, 0.2], [0, 0.3, 0.3, 0.6, 0.6, 0.6],
        [1, -1, 1], [1 / 3, 5 / 9, 2 / 3],
    ),
    "a loop that is open": ([0, 1, 1, 1, 1], [0, 0, 0.3, 0.15, 0.3 - 1e-9], [], [1, -1, 1],
                            [0.4, 0.85, 0.85]),
    "a loop that closes": ([0, 1, 1, 1, 1], [0, 0, 0.3, 0.15, 0.3 + 1e-9], [], [1, -1, 1],
                           [0.4, 0.85, 0.85]),
    "a loop that is passed": ([0, 1, 1, 1, 1], [0, 0, 0.3, 0.15, 0.31], [], [1, -1, 1],
                              [0.4, 0.85, 0.38]),
}  # fmt: skip


def cylinder(
    p: list[float],
    q: list[float],
    friction: list[float],
    behind: FrictionBehind | None = None,
) -> EdgeMemory:
    """The left edge of a cylinder whose half-width is the root of P."""
    load, shear = np.array(p), np.array(q)
    a, zero = np.sqrt(load), np.zeros(len(load))
    unit = 1 / np.sqrt(np.maximum(a, 1e-9))
    k_n = 4 * unit * a  # 2 u dP/da
    history = StationHistory(
        "left", 0, -a, zero, k_n, zero, k_t=shear, k_s=zero, k_i=load, hold=load, shear=shear,
        unit=unit, slid=zero, friction_behind=behind or FrictionBehind(),
    )  # fmt: skip
    coefficient = np.array(friction) if friction else np.full(len(load), 0.5)
    found = EdgeMemory.of(history, coefficient, len(load) - 1, half_width=float(a[-1]), exact=True)
    assert found is not None
    return found


@pytest.mark.parametrize("name", FOLLOWED)
def test_fronts_of_half_cycles_are_exact(name: str) -> None:
    p, q, friction, ways, loads = FOLLOWED[name]
    halves = cylinder(p, q, friction).half_cycles
    assert [each.way for each in halves] == ways
    assert [each.front for each in halves] == pytest.approx(loads, abs=1e-8)
    for half in halves:
        exact = np.sqrt(p[half.end]) - np.sqrt(half.front)
        assert half.length == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("power", [1.0, 2.0, 3.0])
def test_places_below_the_known_one_go_by_a_power_down_to_the_middle(power: float) -> None:
    """A wedge, a cylinder and a sphere whose half-width a is 1 at the only known state."""
    history = replace(
        cylinder([0, 1, 1], [0, 0, 0.1], []).station, k_n=np.array([0, 2 * power, 2 * power])
    )
    memory = EdgeMemory.of(history, np.full(3, 0.5), 2, stiffening=power - 1, half_width=1.0)
    assert memory is not None
    for a in (0.9, 0.5, 0.1):
        assert memory.length(2, a**power) == pytest.approx(1 - a, rel=1e-9)
    assert np.isnan(memory.length(2, 0.0))


@pytest.mark.parametrize("states", [1, 2, 9])
def test_places_do_not_depend_on_what_sliding_has_left_of_the_hold(states: int) -> None:
    """Increments of the hold miss what slides; how it changes over places they tell all the same.

    Of one place the growth of dP/da tells how that goes on, 1/a here.
    """
    loads = np.linspace(1.0, 0.3, states)[::-1]
    station = cylinder([0, *loads, 1], [0.0] * (states + 1) + [0.1], []).station
    shifted = replace(station, hold=np.where(station.hold > 0, station.hold + 0.7, 0.0))
    memory = EdgeMemory.of(shifted, np.full(states + 2, 0.5), states + 1, stiffening=1.0)
    assert memory is not None
    for place in (0.9, 0.7, 0.4):
        assert memory.length(states + 1, 0.7 + place**2) == pytest.approx(1 - place, rel=1e-9)


# f over that at the edge, at distances from it over the half-width.
FIELDS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "rises inward": lambda y: 1 + 2 * y,
    "falls inward": lambda y: 1 - 0.6 * y,
    "over pressure": lambda y: 1 - 0.5 * np.sqrt(np.clip(1 - (1 - y) ** 2, 0, 1)),
    "a coating that ends": lambda y: np.interp(y, [0.1, 0.12], [1.0, 1.8]),
}


def held(field: Callable[[np.ndarray], np.ndarray], c: float) -> float:
    """Q with which a cylinder, P = a = 1, f = .5 at its edges, sticks from -c to c.

    Without a singular shear there Q = 2 int_c^1 f p t/sqrt(t^2 - c^2) dt (Muskhelishvili 1953).
    """
    angle = (np.arange(2000) + 0.5) * np.pi / 4000
    t = np.sqrt(c**2 + (1 - c**2) * np.sin(angle) ** 2)
    return float((1 - c**2) * 2 * np.mean(0.5 * field(1 - t) * np.cos(angle) ** 2))


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize("c", [0.97, 0.9, 0.7])
def test_friction_that_varies_behind_an_edge(name: str, c: float) -> None:
    """First loading, and cycles that take twice of what that does."""
    field, y = FIELDS[name], np.linspace(0.0, 1.0, 1001)
    q = held(field, c)
    memory = cylinder([0, 1, 1, 1, 1], [0, 0, q, -q, q], [], FrictionBehind(y - 1, field(y)))
    assert [each.way for each in memory.half_cycles] == [1, -1, 1]
    for half in memory.half_cycles:
        # Of the table of holds, and of its points where a coating ends.
        assert half.length == pytest.approx(1 - c, rel=5e-3)
        assert memory.equivalent_range(half) == pytest.approx(2 * q, rel=1e-9)


@pytest.mark.parametrize("steps", [1, 7, 50])
def test_the_number_of_steps_does_not_matter(steps: int) -> None:
    """To round-off: P and Q in proportion, then Q, and both at once."""
    corners = np.array([(0.0, 0.0), (1.0, 0.15), (1.0, 0.25), (0.7, -0.1), (1.1, 0.2), (0.9, 0.05)])
    at = np.linspace(0, len(corners) - 1, steps * (len(corners) - 1) + 1)
    p, q = (np.interp(at, np.arange(len(corners)), each) for each in corners.T)
    fine, coarse = (
        cylinder(list(p), list(q), []),
        cylinder(corners[:, 0].tolist(), corners[:, 1].tolist(), []),
    )
    np.testing.assert_allclose(
        fine.slip.locked[np.diff(fine.slip.locked[:, 1], prepend=9.0) != 0][-3:],
        coarse.slip.locked[-3:],
        atol=1e-12,
    )  # fmt: skip


def test_all_of_a_contact_slips_and_turns() -> None:
    """Where nothing is left to take the whole contact slides; then it all turns round."""
    first, second = cylinder([0, 1, 1, 1], [0, 0, 0.6, 0.4], []).half_cycles
    assert np.isnan(first.length)
    assert (second.way, second.front) == (-1, pytest.approx(0.8))


def test_the_zone_before_a_contact_slides_with_little_of_its_load() -> None:
    """Q and P fall: the largest zone counts, not that all slips before the bodies part."""
    p = [0, 1, 1, 0.6, 0.3, 0.1, 0.02]
    (half,) = cylinder(p, [0, 0, 0.2, 0.12, 0.06, 0.02, 0.015], []).half_cycles
    assert (half.end, half.length) == (2, pytest.approx(1 - np.sqrt(0.6)))
    (sliding,) = cylinder([*p[:3], 0.9], [0, 0, 0.2, 0.46], []).half_cycles
    assert np.isnan(sliding.length)


def test_loops_of_p_and_q_leave_equal_zones() -> None:
    angle = np.linspace(0.0, 40 * np.pi, 20 * 24 + 1)
    p = [0.0, *(1 + 0.3 * np.cos(angle))]
    q = [0.0, *(0.125 * np.cos(angle - np.pi / 4))]
    lengths = [each.length for each in cylinder(p, q, []).half_cycles][2:-2]
    # Zones of one way are equal to round-off from the second loop on.
    assert np.ptp(lengths[::2]) < 1e-12 and np.ptp(lengths[1::2]) < 1e-12


def test_what_was_before_the_factors_are_known_is_not_told() -> None:
    """Fronts that reach it have no length."""
    memory = cylinder([0, 0.5, 1, 1, 1, 1], [0, 0.1, 0.1, 0.3, -0.1, -0.2], [])
    hold = np.where(np.arange(6) < 2, np.nan, memory.station.hold)
    late = EdgeMemory.of(replace(memory.station, hold=hold), np.full(6, 0.5), 5)
    assert late is not None
    # First loading depends on it, what turns back within does not, what goes beyond does again.
    assert np.isnan([each.length for each in late.half_cycles]).tolist() == [True, True]
    within = EdgeMemory.of(replace(memory.station, hold=hold), np.full(6, 0.5), 4)
    assert within is not None
    assert np.isnan([each.length for each in within.half_cycles]).tolist() == [True, False]
