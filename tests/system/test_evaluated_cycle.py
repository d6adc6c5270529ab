# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that go on behind the evaluated cycle by as many steps as it has: finite elements."""

from __future__ import annotations

import math
from typing import Any

import pytest
from cases import cycled_sphere
from cases.cycled_sphere import FORCE, FRICTION, LIMIT, SHARE
from cases.pad_cases import HOLD, cylinder, pad, press, shear, wave

import fretfe
from fretfe.case import parse_case
from fretfe.evaluate.contacts import Station
from fretfe.halfplane.solver import solve_half_planes
from fretfe.idealise import idealise
from fretfe.loads import CycleChoice
from fretfe.results.first_lines import cycle_sentences

# Hertz: a = √(4 P R/(π E*)), R = 50, P = 600; range of K_T of ±Q: 2 Q/(π √(2 a)).
HALF_WIDTH = math.sqrt(4 * 600 * 50 * 2 * 0.91 / (math.pi * 210e3))
# Behind two cycles of Q = 60: shut down in 12 steps, and a larger block.
BEHIND: dict[str, list[dict[str, Any]]] = {
    "shut-down": [{"ramp": 30.0, "until": 5.0, "steps": 12}],
    "larger-block": [wave(110.0, cycles=2, steps=8)],
}


@pytest.mark.parametrize("name", BEHIND)
def test_what_follows_the_cycle_is_not_evaluated(name: str) -> None:
    load = {**shear(), "history": [HOLD, wave(60.0, steps=8), *BEHIND[name]]}
    tables = pad(loads={"press": press(), "shear": load}, geometry=cylinder(size=0.06))
    choice = CycleChoice.LAST_PERIOD
    if name == "larger-block":
        tables["cycle"], choice = {"start": 2.0, "end": 3.0}, CycleChoice.GIVEN
    result = fretfe.run(parse_case(tables))
    loads, half_planes = result.loads, solve_half_planes(idealise(parse_case(tables)), elements=60)
    assert loads.cycle is not None and loads.choice is choice
    assert loads.cycle == half_planes.solution.cycle
    assert loads.times[list(loads.cycle)] == pytest.approx([2.0, 3.0])
    exact = 2 * 60 / (math.pi * math.sqrt(2 * HALF_WIDTH))
    for station in result.contacts[0].stations:
        # Finite bodies, and elements of a tenth of the half-width, are good for 2 %.
        assert station.k_t_range == pytest.approx(exact, rel=0.02)
    told = cycle_sentences(result)
    assert told.startswith("Evaluated cycle: t = 2 to 3 s, ")
    assert ("given in [cycle]" in told) == (choice is CycleChoice.GIVEN)
    assert "(steps 13 to 20 of " in told and "behind it do not count" in told


def sphere(down: list[dict[str, Any]]) -> tuple[Station, ...]:
    """Stations of a coarse sphere under a cycle of Q, and then of what follows with Q = 0."""
    load = SHARE * LIMIT
    turns = [{"ramp": (-1) ** k * load, "until": 2.0 + k, "steps": 3} for k in range(3)]
    tables = cycled_sphere.tables(FRICTION, shear=[HOLD, *turns])
    tables["geometry"]["parameters"]["size"] = 0.18
    loads = tables["loads"]
    del loads["twist"]
    loads["press"]["history"] += [{"hold": True, "until": 4.0}, *down]
    loads["shear"]["history"] += [each | {"ramp": 0.0} for each in down]
    result = fretfe.run(
        parse_case(
            tables
            | {
                "cycle": {"start": 2.0, "end": 4.0},
                "edges": {"stations": 12},
                "output": {"fields": "none"},
            },
        )
    )
    return result.contacts[0].stations


@pytest.mark.slow
def test_what_follows_the_cycle_moves_no_front() -> None:
    """K_N by the movement of a solid's front, and all that it decides, are those of the cycle."""
    plain = sphere([])
    followed = sphere([{"ramp": -0.1 * FORCE, "until": 5.0, "steps": 3}])
    moved = [each.k_n_moved for each in plain]
    assert sum(math.isfinite(each) for each in moved) >= 0.9 * len(plain)
    for one, other in zip(plain, followed, strict=True):
        for name in ("k_n_moved", "k_n_moved_spread", "stiffening", "k_range", "k_range_spread"):
            mine, theirs = getattr(one, name), getattr(other, name)
            assert theirs == pytest.approx(mine, rel=1e-9, nan_ok=True), name
        assert other.decisive_k_n == pytest.approx(one.decisive_k_n, rel=1e-9, nan_ok=True)
