# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles counted at an edge under irregular loads, against plays that remember everything."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.evaluate.contacts import CountedCycles, StationHistory
from fretfe.evaluate.cycles import Worst, count_cycles, worst_cycle

FRICTION = 0.5
NO_CYCLE = np.array([], dtype=np.int64)


def station(k_t: np.ndarray) -> StationHistory:
    """An edge with K_N = 1."""
    zero, one = np.zeros(len(k_t)), np.ones(len(k_t))
    return StationHistory("left", 0, zero, zero, one, zero, k_t, zero, zero)


def counted(k_t: np.ndarray, cycle: np.ndarray = NO_CYCLE) -> tuple[CountedCycles, Worst | None]:
    friction = np.full(len(k_t), FRICTION)
    at_edge = station(np.asarray(k_t, dtype=float))
    found = count_cycles(cycle, friction, at_edge)
    return found, worst_cycle(found, cycle, friction, at_edge)


def slip_depths(k_t: np.ndarray, start: int, end: int, places: np.ndarray) -> float:
    """Deepest place that slips in the steps between two states.

    Each place is a play whose bounds are the friction limits there.
    """
    memory, slipped = np.zeros(len(places)), np.zeros(len(places), dtype=bool)
    bound = FRICTION * places / 2
    for state in range(len(k_t)):
        new = np.clip(memory, k_t[state] - bound, k_t[state] + bound)
        if start < state <= end:
            slipped |= np.abs(new - memory) > 1e-12
        memory = new
    return float(places[slipped].max(initial=0.0))


@pytest.mark.parametrize("seed", range(10))
def test_a_repeated_mission_against_plays(seed: int) -> None:
    mission = np.append(0.0, np.random.default_rng(seed).uniform(-1, 1, 60))
    mission[-1] = 0.0
    k_t = np.concatenate([mission, mission[1:], mission[1:]])
    cycle = np.arange(120, 181)
    cycles, worst = counted(k_t, cycle)
    assert worst is not None
    assert cycles.closed
    assert np.all(cycles.count == 1)
    places = np.linspace(0, 10, 20001)
    number = cycles.worst
    (_, middle), (begin, last) = worst.half_cycles
    assert middle == begin
    assert {last % 60, begin % 60} == {cycles.start[number] % 60, cycles.end[number] % 60}
    depth = cycles.k_t_range[number] / FRICTION
    for start, end in worst.half_cycles:
        assert slip_depths(k_t, start, end, places) == pytest.approx(depth, abs=1e-3)
    assert slip_depths(k_t, 120, 180, places) == pytest.approx(depth, abs=1e-3)
    # The steps on the way from reversal to reversal slip as deep as all of them.
    outer = np.flatnonzero(worst.outer[begin + 1 : last + 1]) + begin + 1
    assert outer[-1] == last
    assert cycles.k_t_range[number] == np.ptp(mission)


@pytest.mark.parametrize("seed", range(10))
def test_a_history_that_ends_against_plays(seed: int) -> None:
    k_t = np.append(0.0, np.random.default_rng(seed).uniform(-1, 1, 50))
    cycles, worst = counted(k_t)
    assert worst is not None
    assert not cycles.closed
    ((start, end),) = worst.half_cycles
    found = slip_depths(k_t, start, end, np.linspace(0, 10, 20001))
    assert worst.predicted == pytest.approx(found, abs=1e-3)
    assert cycles.k_t_range[cycles.worst] == np.ptp(k_t)


def test_regular_cycles_are_no_mission() -> None:
    angle = np.arange(121) * np.pi / 20
    cycles, worst = counted(np.sin(angle), np.arange(80, 121))
    assert cycles.count.tolist() == [1.0]
    assert worst is None
    # Loading, and whole waves without a cycle.
    for k_t in (np.linspace(0, 1, 5), np.sin(angle), np.array([0.0, 1.0, -1.0])):
        assert counted(k_t)[1] is None


@pytest.mark.parametrize(
    ("k_t", "cycle", "reason"),
    [
        ([1.0] * 6, np.arange(2, 6), "nothing varies"),
        ([0.0, 1, np.nan, 1, 0, 1], np.arange(1, 6), "unknown in 1 of 5 states"),
        ([0.0, 1, np.nan, 1, 0, 1], NO_CYCLE, "unknown in 1 of 6 states"),
    ],
)
def test_what_cannot_be_counted(k_t: list[float], cycle: np.ndarray, reason: str) -> None:
    cycles, worst = counted(np.array(k_t), cycle)
    assert reason in cycles.reason
    assert len(cycles.count) == 0
    assert worst is None


def test_an_unknown_state_before_the_cycle_does_not_matter() -> None:
    k_t = np.array([np.nan, 0, 1, 0.5, 0.8, -1, 0])
    cycles, worst = counted(k_t, np.arange(1, 7))
    assert cycles.k_t_range.tolist() == pytest.approx([0.3, 2.0])
    assert worst is not None
    # There is nothing before the cycle that the first half cycle could begin at.
    assert worst.half_cycles == ((2, 5),)


def test_plateaus_and_equal_cycles() -> None:
    mission = [0.0, 1, 1, 0, 0, 1, 1, -0.5, -0.5, 0]
    k_t = np.array(mission + mission[1:])
    cycles, worst = counted(k_t, np.arange(9, 19))
    assert sorted(cycles.k_t_range.tolist()) == [1.0, 1.5]
    assert worst is not None
    assert worst.half_cycles == ((8, 15), (15, 16))


def test_100_000_states() -> None:
    k_t = np.append(0.0, np.random.default_rng(3).uniform(-1, 1, 100_000))
    cycles, worst = counted(k_t)
    assert len(cycles.count) > 30_000
    assert worst is not None
