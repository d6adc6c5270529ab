# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles at an edge that P moves, against plays that forget as soon as the edge has left them."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.evaluate.contacts import StationHistory
from fretfe.evaluate.cycles import count_cycles, worst_cycle

FRICTION = 0.5
NO_CYCLE = np.array([], dtype=np.int64)


def station(k_t: np.ndarray, fall: np.ndarray) -> StationHistory:
    """An edge with K_N = 1 that draws back by what f K_I falls."""
    zero, one = np.zeros(len(k_t)), np.ones(len(k_t))
    k_i, position = -fall / FRICTION, 2 * fall / FRICTION
    return StationHistory("left", 0, position, zero, one, zero, k_t, zero, k_i)


def counted(
    k_t: list[float], fall: list[float], cycle: np.ndarray = NO_CYCLE
) -> set[tuple[float, float, float, float]]:
    """K_T at both reversals, the smaller one first, count and effective range."""
    at_edge = station(np.array(k_t), np.array(fall))
    found = count_cycles(cycle, np.full(len(k_t), FRICTION), at_edge, returns=True)
    assert not found.reason
    ends = np.sort([at_edge.k_t[found.start], at_edge.k_t[found.end]], axis=0).round(9)
    rows = zip(*ends, found.count, found.effective_range.round(9), strict=True)
    return {tuple(float(each) for each in row) for row in rows}


def test_cycles_between_two_unloaded_states() -> None:
    """Shear between start and shutdown: nothing closes the largest range, 40."""
    mission = [0.0, 0, 20, -20, 10, -10, 0, 0]
    unloaded = [90.0, 0, 0, 0, 0, 0, 0, 90]
    inner = {(-20.0, 20.0, 0.5, 40.0), (-20.0, 10.0, 0.5, 30.0), (-10.0, 10.0, 0.5, 20.0)}
    for k_t, fall, cycle in (
        (mission, unloaded, NO_CYCLE),
        (mission, unloaded, np.arange(8)),
        (mission + mission[1:], unloaded + unloaded[1:], np.arange(7, 15)),
    ):
        found = counted(k_t, fall, cycle)
        assert inner <= found
        # What loads and unloads drives no place to and fro.
        assert {row for row in found - inner if row[3] > 0} <= {(-10.0, 0.0, 0.5, 10.0)}


def test_smaller_falls_divide_smaller_cycles_only() -> None:
    """Two blocks with P at a half in between: the deep cycle goes on, the others do not."""
    k_t = [0.0, 30, -5, 5, -5, 0, 0, 5, -5, -30, 30]
    fall = [0.0, 0, 0, 0, 0, 0, 12, 0, 0, 0, 0]
    found = counted(k_t + k_t[1:], fall + fall[1:], np.arange(10, 21))
    assert (-30.0, 30.0, 1.0, 60.0) in found
    # What follows P at a half begins anew; before it nothing closes the way from 5 to -5.
    assert {(-5.0, 5.0, 1.0, 10.0), (-5.0, 5.0, 0.5, 10.0)} & found
    assert not any(row[3] > 12 * 2 for row in found if row[:2] != (-30.0, 30.0))


def test_a_little_movement_of_the_edge_changes_little() -> None:
    random = np.random.default_rng(5)
    k_t = np.append(0.0, random.uniform(-1, 1, 40))
    still = counted(k_t.tolist(), [0.0] * 41)
    moved = counted(k_t.tolist(), (1e-2 * random.uniform(0, 1, 41)).tolist())
    large = [sorted((row[3], row[2]) for row in each if row[3] > 0.1) for each in (still, moved)]
    assert np.array(large[0]) == pytest.approx(np.array(large[1]), abs=0.02)


def longest_by_plays(k_t: np.ndarray, fall: np.ndarray, first: int) -> dict[int, tuple[float, int]]:
    """Length of the longest slip zone forward and backward, 1 and -1, and the state of its end."""
    radius = np.linspace(0, 3, 6001)
    memory, longest = np.full(len(radius), k_t[0]), {1: (0.0, 0), -1: (0.0, 0)}
    for state in range(1, len(k_t)):
        before, now = fall[state - 1], fall[state]
        share = np.clip((before - radius) / (before - now if before > now else 1.0), 0.0, 1.0)
        covered = k_t[state - 1] + share * (k_t[state] - k_t[state - 1])
        memory = np.where((radius >= now) & (radius < before), covered, memory)
        free = radius - now
        for way in (1, -1):
            slips = (free >= 0) & (way * (k_t[state] - memory) > free + 0.02 * np.ptp(k_t))
            length = 2 * free[slips].max(initial=0.0) / FRICTION
            if state > first and length > longest[way][0]:
                longest[way] = length, state
        memory = np.where(
            free < 0, k_t[state], np.clip(memory, k_t[state] - free, k_t[state] + free)
        )
    return longest


@pytest.mark.parametrize("seed", range(12))
def test_zones_of_the_worst_cycle_are_the_longest_of_plays(seed: int) -> None:
    random = np.random.default_rng(seed)
    k_t = np.append(0.0, random.uniform(-1, 1, 60))
    fall = np.repeat(random.uniform(0, 1.5, 21), 3)[:61]
    fall[0] = fall[-1] = 1.5
    k_t[-1] = 0.0
    at_edge, friction = station(k_t, fall), np.full(61, FRICTION)
    cycles = count_cycles(NO_CYCLE, friction, at_edge)
    worst = worst_cycle(cycles, NO_CYCLE, friction, at_edge)
    assert worst is not None
    expected = longest_by_plays(k_t, fall, 0)
    ends = sorted(state for _, state in expected.values())
    assert [end for _, end in worst.half_cycles] == ends
    assert all(start < end for start, end in worst.half_cycles)
