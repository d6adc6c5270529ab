# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles counted at an edge under irregular loads, against plays that remember everything."""

from __future__ import annotations

import numpy as np
import pytest
from cases.edge_histories import edge_history

from fretfe.evaluate.contacts import CountedCycles
from fretfe.evaluate.cycles import count_cycles
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.edge_slip import HalfCycle

FRICTION = 0.5
NO_CYCLE = np.array([], dtype=np.int64)


def counted(k_t: np.ndarray, cycle: np.ndarray = NO_CYCLE) -> CountedCycles:
    station = edge_history(np.asarray(k_t, dtype=float))
    friction = np.full(len(k_t), FRICTION)
    memory = EdgeMemory.of(station, friction, len(k_t) - 1)
    return count_cycles(cycle, friction, station, memory)


def memory_of(k_t: np.ndarray) -> EdgeMemory:
    found = EdgeMemory.of(edge_history(k_t), np.full(len(k_t), FRICTION), len(k_t) - 1)
    assert found is not None
    return found


def longest(k_t: np.ndarray, first: int) -> tuple[HalfCycle, ...]:
    return memory_of(k_t).longest((first, len(k_t) - 1))


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
    cycles, halves = counted(k_t, cycle), longest(k_t, 120)
    assert cycles.irregular and cycles.closed
    assert np.all(cycles.count == 1)
    places = np.linspace(0, 10, 20001)
    number = cycles.worst
    assert {each.end % 60 for each in halves} == {
        cycles.start[number] % 60, cycles.end[number] % 60
    }  # fmt: skip
    depth = cycles.k_t_range[number] / FRICTION
    for half in halves:
        assert slip_depths(k_t, half.start, half.end, places) == pytest.approx(depth, abs=1e-3)
        # But for what a loop that closes at the end adds without driving anything.
        assert 0.98 * depth < half.length <= depth * (1 + 1e-9)
    assert slip_depths(k_t, 120, 180, places) == pytest.approx(depth, abs=1e-3)
    # Loops within do not lead farther.
    assert all(memory_of(k_t).outer(halves)[each.end] for each in halves)
    assert cycles.k_t_range[number] == np.ptp(mission)


@pytest.mark.parametrize("seed", range(10))
def test_a_history_that_ends_against_plays(seed: int) -> None:
    k_t = np.append(0.0, np.random.default_rng(seed).uniform(-1, 1, 50))
    cycles, halves = counted(k_t), longest(k_t, 0)
    assert cycles.irregular and not cycles.closed
    for half in halves:
        found = slip_depths(k_t, half.start, half.end, np.linspace(0, 10, 20001))
        assert 0.98 * found - 1e-3 < half.length < found + 1e-3
    assert cycles.k_t_range[cycles.worst] == np.ptp(k_t)


def test_slip_of_counted_cycles_is_that_of_their_own_reversals() -> None:
    mission = [0.0, 1, 0.2, 0.8, -0.4, 0]
    k_t = np.array(mission + mission[1:] + mission[1:])
    cycles = counted(k_t, np.arange(10, 16))
    assert sorted(cycles.k_t_range.tolist()) == pytest.approx([0.6, 1.4])
    assert cycles.slip == pytest.approx(cycles.k_t_range / FRICTION)


def test_regular_cycles_are_no_mission() -> None:
    angle = np.arange(121) * np.pi / 20
    cycles = counted(np.sin(angle), np.arange(80, 121))
    assert cycles.count.tolist() == [1.0]
    assert not cycles.irregular
    # Loading, and whole waves without a cycle.
    for k_t in (np.linspace(0, 1, 5), np.sin(angle), np.array([0.0, 1.0, -1.0])):
        assert not counted(k_t).irregular


@pytest.mark.parametrize(
    ("k_t", "cycle", "reason"),
    [
        ([1.0] * 6, np.arange(2, 6), "nothing varies"),
        ([0.0, 1, np.nan, 1, 0, 1], np.arange(1, 6), "unknown in 1 of 5 states"),
        ([0.0, 1, np.nan, 1, 0, 1], NO_CYCLE, "unknown in 1 of 6 states"),
    ],
)
def test_what_cannot_be_counted(k_t: list[float], cycle: np.ndarray, reason: str) -> None:
    cycles = counted(np.array(k_t), cycle)
    assert reason in cycles.reason
    assert len(cycles.count) == 0
    assert not cycles.irregular


def test_an_unknown_state_before_the_cycle_does_not_matter() -> None:
    k_t = np.array([np.nan, 0, 1, 0.5, 0.8, -1, 0])
    cycles = counted(k_t, np.arange(1, 7))
    assert cycles.k_t_range.tolist() == pytest.approx([0.3, 2.0])
    # What is locked in then is not, and first loading depends on that; what turns back does not.
    lengths = {(each.start, each.end): each.length for each in memory_of(k_t).half_cycles}
    assert np.isnan(lengths[1, 2]) and lengths[4, 5] == pytest.approx(4.0)


def test_plateaus_and_equal_cycles() -> None:
    mission = [0.0, 1, 1, 0, 0, 1, 1, -0.5, -0.5, 0]
    k_t = np.array(mission + mission[1:])
    cycles = counted(k_t, np.arange(9, 19))
    assert sorted(cycles.k_t_range.tolist()) == [1.0, 1.5]
    found = [(each.start, each.end, each.length) for each in longest(k_t, 9)]
    assert found == [(7, 10, pytest.approx(3.0)), (14, 16, pytest.approx(3.0))]


def test_100_000_states() -> None:
    k_t = np.append(0.0, np.random.default_rng(3).uniform(-1, 1, 100_000))
    memory = memory_of(k_t)
    found = count_cycles(NO_CYCLE, np.full(len(k_t), FRICTION), memory.station, memory)
    assert len(found.count) > 30_000
    assert len(memory.longest((0, len(k_t) - 1))) == 2
