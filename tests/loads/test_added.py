# SPDX-License-Identifier: LGPL-3.0-or-later
"""The evaluated cycle stays where the case puts it, whatever follows; it moves with added ones."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import pad

from fretfe.case import Case, parse_case
from fretfe.loads import (
    AddedCycles,
    CycleChoice,
    History,
    build_history,
    cycle_words,
    most_added,
    told_states,
)

TABLES = tomllib.loads("""
    geometry.file = "m.msh"
    bodies.a = { young = 1.0, poisson = 0.3 }
    bodies.b = { young = 1.0, poisson = 0.3 }
    contacts.c = { surface1 = "s1", surface2 = "s2", friction = 0.3 }
    """)
SEEDS = range(150)


@dataclass
class Drawn:
    """A case, and the cycle (from, to) that is evaluated."""

    case: Case
    cycle: tuple[float, float]
    choice: CycleChoice


def draw(seed: int) -> Drawn:
    """One to three loads of ramps, holds, tables and waves of whole periods, in any order.

    All start at zero and all times are halves: waves run on a mean of 0 from where ramps end.
    """
    random = np.random.default_rng(seed)
    period = float(random.integers(1, 4))
    loads: dict[str, Any] = {}
    waves: list[tuple[float, float]] = []
    for number in range(random.integers(1, 4)):
        segments: list[dict[str, Any]] = []
        time, wavy = 0.0, number == 0
        for kind in random.permutation(["ramp", "wave", "hold", "wave", "points"]):
            until = time + float(random.integers(1, 5)) * period
            steps = int(until - time) * int(random.integers(1, 5))
            if kind == "wave" and (wavy or random.random() < 0.5):
                cycles = int(random.integers(1, 4))
                own = period if wavy or random.random() < 0.7 else period / 2
                segments.append({"ramp": 0.0, "until": time + period, "steps": 2})
                segments.append({
                    "wave": "sine", "amplitude": 1.0, "period": own, "cycles": cycles,
                    "steps_per_cycle": int(random.choice([4, 6, 8, 12])),
                })  # fmt: skip
                time += period + cycles * own
                waves.append((own, time))
                wavy = False
            elif kind == "points" and segments:
                times = [time + share * period for share in (0.5, 1.0)]
                segments.append({"times": times, "values": random.normal(size=2).tolist()})
                time = times[-1]
            elif kind in ("ramp", "hold"):
                value = {"hold": True} if kind == "hold" else {"ramp": float(random.normal())}
                segments.append({**value, "until": until, "steps": steps})
                time = until
        kind = {"type": "traction", "boundary": f"s{number}", "direction": "x"}
        loads[f"l{number}"] = {**kind, "history": segments}
    data = {**TABLES, "loads": loads}
    slowest, end = max(waves)
    if random.random() < 0.5:
        # From any step on to any that is a period later.
        clock = build_history(parse_case({**data, "loads": _quiet(loads)})).times
        starts = [each for each in clock if np.abs(clock - each - period).min() < 1e-9]
        start = float(random.choice(starts))
        cycle = (start, start + period)
        data["cycle"] = {"start": cycle[0], "end": cycle[1]}
        return Drawn(parse_case(data), cycle, CycleChoice.GIVEN)
    case = parse_case({**data, "loads": _quiet(loads)})
    return Drawn(case, (end - slowest, end), CycleChoice.LAST_PERIOD)


def _quiet(loads: dict[str, Any]) -> dict[str, Any]:
    """The same with values that change by waves only: a default cycle has to be closed."""

    def segment(each: dict[str, Any]) -> dict[str, Any]:
        if "ramp" in each:
            return {**each, "ramp": 0.0}
        return {**each, "values": [0.0, 0.0]} if "values" in each else each

    return {
        name: {**load, "history": [segment(each) for each in load["history"]]}
        for name, load in loads.items()
    }


def evaluated(history: History) -> tuple[float, float]:
    assert history.cycle is not None
    first, last = history.times[list(history.cycle)]
    return float(first), float(last)


def clocks(history: History, seed: int) -> Iterator[History]:
    """The loads, and the same with some steps in parts."""
    yield history
    random = np.random.default_rng(seed)
    parts = np.append(1, random.integers(1, 4, size=len(history.times) - 1))
    steps = np.repeat(np.arange(len(parts)), parts)
    shares = np.concatenate([np.arange(1, n + 1) / n for n in parts])
    yield history.divided(steps, shares)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_cycle_is_that_of_the_case_however_the_loads_go_on(dimension: int) -> None:
    """As half-planes have it, which take the loads as they are written."""
    given = 0
    for seed in SEEDS:
        drawn = draw(seed)
        written = build_history(drawn.case)
        cycles = AddedCycles(written, most_added(drawn.case, written, dimension))
        for history in (*clocks(written, seed), *clocks(cycles.solved(cycles.written), seed)):
            assert evaluated(history) == pytest.approx(drawn.cycle, abs=1e-9), seed
            assert history.choice is drawn.choice, seed
        given += drawn.choice is CycleChoice.GIVEN
    assert 0.3 < given / len(SEEDS) < 0.7


def test_of_added_cycles_the_last_whole_one_counts() -> None:
    """But for one that begins with extrapolated slip: every third one."""
    found = 0
    for seed in SEEDS:
        drawn = draw(seed)
        written = build_history(drawn.case)
        cycles = AddedCycles(written, most_added(drawn.case, written, 3))
        length = drawn.cycle[1] - drawn.cycle[0]
        for added, end in enumerate(cycles.ends):
            later = added - (added in (2, 5, 8, 11, 14, 17))
            for step in {end, end + cycles.period // 2}:
                history = cycles.solved(step)
                moved = np.array(drawn.cycle) + later * length
                assert evaluated(history) == pytest.approx(moved, abs=1e-9), (seed, added)
                assert history.choice is (CycleChoice.ADDED if later else drawn.choice)
                assert len(history.times) == min(step, len(cycles.longest.times) - 1) + 1
            found += added
    assert found


@pytest.mark.parametrize(
    ("start", "end"),
    # First, in the middle, last, over two blocks, one step long, all of it.
    [(1, 2), (2, 3), (4, 5), (2, 4), (2.125, 2.25), (0, 5)],
)
def test_a_cycle_that_is_given_is_the_one(start: float, end: float) -> None:
    """Of waves of 8 steps, whatever repeats itself behind it."""
    history = [
        {"ramp": 0.0, "until": 1.0, "steps": 8},
        *({"wave": "sine", "amplitude": size, "period": 1.0, "cycles": 2, "steps_per_cycle": 8}
          for size in (50.0, 120.0)),
    ]  # fmt: skip
    load = {"type": "traction", "boundary": "s", "direction": "x", "history": history}
    data = {**TABLES, "loads": {"l": load}, "cycle": {"start": start, "end": end}}
    if end - start < 1:
        load["history"] = [{"ramp": 1.0, "until": 5.0, "steps": 40}]
    written = build_history(parse_case(data))
    found = AddedCycles(written, 0).solved(len(written.times) - 1)
    assert evaluated(found) == pytest.approx((start, end), abs=1e-9)
    assert found.choice is CycleChoice.GIVEN


def test_added_cycles_on_the_way_do_not_count() -> None:
    """Two waves of four steps behind a ramp of two; of three added ones the last is evaluated."""
    ramp = {"ramp": 0.0, "until": 1.0, "steps": 2}
    wave = {"wave": "sine", "amplitude": 1.0, "period": 1.0, "cycles": 2, "steps_per_cycle": 4}
    load = {"type": "traction", "boundary": "s", "direction": "x", "history": [ramp, wave]}
    written = build_history(parse_case({**TABLES, "loads": {"l": load}}))
    last = len(written.times) - 1
    assert last == 10
    np.testing.assert_array_equal(told_states(written, last), range(1, 11))
    solved = written.prolonged(3).until(22, 3)
    assert solved.cycle == (18, 22)
    np.testing.assert_array_equal(told_states(solved, last), [*range(1, 11), *range(18, 23)])


@pytest.mark.parametrize(
    ("ends", "told"), [(0.0, ""), (3e-10, ""), (0.5, ", without a return of loads.b,")]
)
def test_a_given_cycle_says_which_loads_drift(ends: float, told: str) -> None:
    """A part of a mission need not return; what round-off of a file leaves is no drift."""
    turns = [{"times": [1.0, 2.0, 3.0, 4.0], "values": [0.0, 1.0, ends, ends]}]
    tables = {**pad(), "cycle": {"start": 1.0, "end": 3.0}}
    base = tables["loads"]["press"]
    tables["loads"] = {"a": base, "b": {**base, "direction": "x", "history": turns}}
    words = cycle_words(build_history(parse_case(tables)), "s")
    assert words.startswith("t = 1 to 3 s, given in [cycle]" + told)
    assert told or words.endswith("[cycle]")
