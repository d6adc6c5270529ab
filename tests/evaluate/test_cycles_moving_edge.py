# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles at an edge that P moves, against plays that forget as soon as the edge has left them."""

from __future__ import annotations

import numpy as np
import pytest
from cases.edge_histories import edge_history

from fretfe.evaluate.contacts import StationHistory
from fretfe.evaluate.cycles import count_cycles
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.edge_slip import HalfCycle

FRICTION = 0.5
NO_CYCLE = np.array([], dtype=np.int64)


def station(k_t: np.ndarray, fall: np.ndarray) -> StationHistory:
    """An edge with K_N = 1 that draws back by what f K_I falls."""
    return edge_history(k_t, -fall / FRICTION)


def counted(k_t: list[float], fall: list[float]) -> set[tuple[float, float, float]]:
    """K_T at both reversals, the smaller one first, and count."""
    at_edge = station(np.array(k_t), np.array(fall))
    found = count_cycles(NO_CYCLE, np.full(len(k_t), FRICTION), at_edge)
    assert not found.reason
    ends = np.sort([at_edge.k_t[found.start], at_edge.k_t[found.end]], axis=0)
    rows = zip(*ends, found.count, strict=True)
    return {(float(low), float(high), float(count)) for low, high, count in rows}


def test_k_t_is_counted_whatever_p_does() -> None:
    """From start to shutdown, and with P at a half while Q returns."""
    k_t = [0.0, 0, 20, -20, 10, 3, -10, 0, 0]
    halves = {(0, 20, 0.5), (-20, 20, 0.5), (-20, 10, 0.5), (-10, 10, 0.5), (-10, 0, 0.5)}
    for fall in ([0.0] * 9, [90.0, 0, 0, 0, 0, 0, 0, 0, 90], [90.0, 0, 0, 50, 0, 50, 50, 0, 90]):
        assert counted(k_t, fall) == halves


def test_pressing_before_the_cycle_is_no_reversal() -> None:
    """P grows without shear; first loading at constant P is no part of the cycles that follow."""
    k_t = divided(np.array([0.0, 0, 30, -12, 20, 0]), 6)
    fall = divided(np.array([60.0, 0, 0, 0, 0, 0]), 6)
    memory = EdgeMemory.of(station(k_t, fall), np.full(31, FRICTION), 30)
    assert memory is not None
    assert [(each.start, each.end) for each in memory.longest((6, 30))] == [(12, 18), (18, 24)]


def test_round_off_is_no_cycle() -> None:
    noise = 1e-14 * np.random.default_rng(1).uniform(-1, 1, 30)
    found = count_cycles(
        NO_CYCLE, np.full(30, FRICTION), station(noise, divided(np.array([60.0, 0]), 29))
    )
    assert found.reason == "nothing varies"


def length_by_plays(k_t: np.ndarray, fall: np.ndarray, half: HalfCycle) -> float:
    """Length of the slip zone of a half cycle from the edge at its end."""
    radius, deepest = np.linspace(0, 3, 6001), 0.0
    memory = np.full(len(radius), k_t[0])
    for state in range(1, half.end + 1):
        before, now = fall[state - 1], fall[state]
        share = np.clip((before - radius) / (before - now if before > now else 1.0), 0.0, 1.0)
        covered = k_t[state - 1] + share * (k_t[state] - k_t[state - 1])
        memory = np.where((radius >= now) & (radius < before), covered, memory)
        free = radius - now
        slips = (free >= 0) & (half.way * (k_t[state] - memory) > free + 1e-9)
        if state > half.start:
            deepest = max(deepest, radius[slips].max(initial=0.0))
        stuck = np.clip(memory, k_t[state] - free, k_t[state] + free)
        memory = np.where(free < 0, k_t[state], stuck)
    return float(2 * (deepest - fall[half.end]) / FRICTION)


def divided(values: np.ndarray, parts: int) -> np.ndarray:
    """The same on straight ways with more states."""
    numbers = np.arange(len(values))
    return np.interp(np.linspace(0, numbers[-1], numbers[-1] * parts + 1), numbers, values)


@pytest.mark.parametrize("parts", [1, 8, 60])
@pytest.mark.parametrize("seed", range(6))
def test_zones_of_the_worst_cycle_are_the_longest_of_plays(seed: int, parts: int) -> None:
    """Whatever the steps: with small ones each place slips little in each of them."""
    random = np.random.default_rng(seed)
    k_t = np.append(0.0, random.uniform(-1, 1, 20))
    fall = np.repeat(random.uniform(0, 1.5, 7), 3)[:21]
    fall[0] = fall[-1] = 1.5
    k_t, fall = divided(k_t, parts), divided(fall, parts)
    memory = EdgeMemory.of(station(k_t, fall), np.full(len(k_t), FRICTION), len(k_t) - 1)
    assert memory is not None
    halves = memory.longest((0, len(k_t) - 1))
    for half in halves:
        assert half.start < half.end
        # Places .0005 apart, of half of f K_N y.
        assert half.length == pytest.approx(length_by_plays(k_t, fall, half), abs=0.01)
    size = max(each.length for each in memory.recurring)
    assert max(each.length for each in halves) >= 0.99 * size
