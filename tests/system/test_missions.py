# SPDX-License-Identifier: LGPL-3.0-or-later
"""Missions that begin and end without load have the numbers of their largest load.

Each is solved as far as its largest load, too: with the same states there K_N, the place of the
edge and K_T are the same, and only what the way down adds is another.
"""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fretfe
from fretfe.case import parse_case
from fretfe.caution import grouped
from fretfe.loads import CycleChoice
from fretfe.reason import Kind
from fretfe.report.page.tables import contact_table
from fretfe.report.texts import number
from fretfe.results.model import Result

DEMOS = Path(__file__).parents[2] / "demos"
# Template, its larger elements, and the largest value of its load.
CASES = {
    "dovetail": ({"edge_size": 0.008}, 3900.0),
    "firtree": ({"edge_size": 0.006, "groove_radius": 1.6, "flank_size": 0.2}, 5000.0),
    "sector": ({"edge_size": 0.008}, 780.0),
}
STEPS = 8
# Loads of a mission, as parts of the largest one, and the same with a cycle at high load.
ONCE = (1.0, 0.0)
WITH_CYCLES = (1.0, 0.6, 0.9, 0.6, 0.9, 0.6)


@cache
def mission(
    name: str,
    parts: tuple[float, ...],
    friction: float = 0.0,
    cycle: tuple[float, ...] = (),
    steps: int = STEPS,
) -> Result:
    """A template under ramps to parts of its largest load, one after the other."""
    data: dict[str, Any] = tomllib.loads((DEMOS / f"{name}.toml").read_text("utf-8"))
    sizes, largest = CASES[name]
    data["geometry"]["parameters"].update(sizes)
    (load,) = data["loads"].values()
    load["history"] = [
        {"ramp": part * largest, "until": float(time), "steps": steps}
        for time, part in enumerate(parts, start=1)
    ]
    data["output"] = {"fields": "none"}
    if friction:
        for contact in data["contacts"].values():
            contact["friction"] = friction
    if cycle:
        data["cycle"] = {"start": cycle[0], "end": cycle[1]}
    return fretfe.run(parse_case(data))


NAMES = [
    "dovetail",
    pytest.param("firtree", marks=pytest.mark.slow),
    pytest.param("sector", marks=pytest.mark.slow),
]


@pytest.mark.parametrize("name", NAMES)
def test_k_n_is_that_of_the_largest_load_without_the_way_down(name: str) -> None:
    whole, up = mission(name, ONCE), mission(name, ONCE[:1])
    assert whole.loads.choice is CycleChoice.MISSION and up.loads.cycle is None
    assert whole.failure is None and len(grouped(whole.warnings)) <= 6
    for one, two in zip(whole.contacts, up.contacts, strict=True):
        assert one.steady  # nothing is left of what was before without any load
        for mine, theirs in zip(one.stations, two.stations, strict=True):
            assert mine.decisive == theirs.decisive == STEPS
            assert mine.decisive_k_n[0] == pytest.approx(theirs.decisive_k_n[0], rel=1e-8)
            assert mine.position[STEPS] == pytest.approx(theirs.position[STEPS], rel=1e-8)
            assert mine.decisive_k_n[1] <= 1.01 * theirs.decisive_k_n[1]


def test_ramps_of_one_step_know_where_flanks_jam() -> None:
    """On the way down they stick, Q turns, and they slide back: nothing of it is left at its end.

    Steps that are given are divided at the same places.
    """
    once, often = mission("dovetail", ONCE, steps=1), mission("dovetail", ONCE)
    for one, two in zip(once.contacts, often.contacts, strict=True):
        for force in ("normal_force", "shear_force"):
            for end in ("smallest", "largest"):
                mine, theirs = (getattr(each, f"{end}_{force}") for each in (one, two))
                assert mine == pytest.approx(theirs, abs=0.01 * two.largest_normal_force)
        assert one.smallest_shear_force < 0 < one.largest_shear_force
        assert one.dissipation == pytest.approx(two.dissipation, rel=0.05)
        for mine, theirs in zip(one.stations, two.stations, strict=True):
            if np.isfinite(theirs.reported_range):
                bar = np.hypot(mine.k_range_spread, theirs.k_range_spread)
                assert abs(mine.k_range - theirs.k_range) < bar


@pytest.mark.parametrize("name", NAMES)
def test_range_of_k_t_is_that_of_the_way_up(name: str) -> None:
    """Full stick knows no history: all of K_T goes with the load, and comes back with it."""
    whole, up = mission(name, ONCE), mission(name, ONCE[:1], cycle=(0.0, 1.0))
    known = 0
    for one, two in zip(whole.contacts, up.contacts, strict=True):
        for mine, theirs in zip(one.stations, two.stations, strict=True):
            if np.isfinite(mine.reported_range):
                known += 1
                bar = np.hypot(mine.k_range_spread, theirs.k_range_spread)
                assert abs(mine.k_range - theirs.k_range) < bar
    assert known >= len(whole.contacts)


def test_flanks_that_slide_say_how_far_and_how_long() -> None:
    result = mission("dovetail", ONCE)
    for contact in result.contacts:
        assert all(station.slip_zones[-1].gross for station in contact.stations)
        # All the way up, as the pull makes Q = f P at once, and at the end of the way down.
        assert 0.5 <= contact.sliding_share < 0.8
        bound = 0.6 * contact.normal_force.max() * contact.sliding_range
        assert 0.3 * bound < contact.dissipation < bound
    told = result.headline.sentences.sliding
    assert told.startswith("Slide as a whole in the cycle: 2 of 2 contacts, farthest ")
    cells = set(contact_table(result).columns[-1].cells)
    assert cells == {number(each.sliding_range, 3) for each in result.contacts}
    kinds = {group.kind for group in grouped(result.warnings)}
    assert Kind.GROSS_SLIP in kinds and Kind.NOT_RESOLVED not in kinds


def test_a_given_cycle_is_the_same_with_and_without_the_way_down() -> None:
    """From .6 to .9 of the largest pull and back, with and without a run-down to nothing."""
    plain = mission("dovetail", WITH_CYCLES, cycle=(4.0, 6.0))
    down = mission("dovetail", (*WITH_CYCLES, 0.0), cycle=(4.0, 6.0))
    for one, two in zip(plain.contacts, down.contacts, strict=True):
        for mine, theirs in zip(one.stations, two.stations, strict=True):
            assert mine.decisive == theirs.decisive == 5 * STEPS
            assert theirs.decisive_k_n[0] == pytest.approx(mine.decisive_k_n[0], rel=1e-8)
            assert theirs.k_range == pytest.approx(mine.k_range, rel=1e-6)
            for zone, other in zip(mine.slip_zones[-2:], theirs.slip_zones[-2:], strict=True):
                assert zone.gross == other.gross
                assert zone.gross or other.length == pytest.approx(zone.length, rel=1e-5)


def test_the_whole_mission_is_the_worst_of_its_cycles() -> None:
    """Small cycles at high load lie within the one from nothing to the largest load and back."""
    result = mission("dovetail", (*WITH_CYCLES, 0.0))
    once = mission("dovetail", ONCE)
    for one, two in zip(result.contacts, once.contacts, strict=True):
        for mine, theirs in zip(one.stations, two.stations, strict=True):
            assert mine.cycles.closed and mine.decisive == STEPS
            largest = mine.cycles.k_t_range[mine.cycles.worst]
            assert largest == pytest.approx(theirs.k_range, rel=0.02)
            assert theirs.decisive_k_n[0] == pytest.approx(mine.decisive_k_n[0], rel=1e-8)


def test_contact_that_is_lost_in_between_is_evaluated_where_it_is() -> None:
    """Two flights in one given cycle: the last one has the numbers of one flight alone."""
    twice = mission("dovetail", (*ONCE, *ONCE), cycle=(0.0, 4.0))
    once = mission("dovetail", ONCE)
    for one, two in zip(twice.contacts, once.contacts, strict=True):
        for mine, theirs in zip(one.stations, two.stations, strict=True):
            assert mine.decisive == 3 * STEPS
            assert mine.decisive_k_n[0] == pytest.approx(theirs.decisive_k_n[0], rel=1e-6)
            assert abs(mine.k_range - theirs.k_range) < np.hypot(
                mine.k_range_spread, theirs.k_range_spread
            )


def test_a_flank_that_stays_jammed_has_the_numbers_of_the_largest_load() -> None:
    """With f = 1 the root stays in its slot: P is left where nothing pulls any more."""
    whole, up = (mission("dovetail", parts, friction=1.0) for parts in (ONCE, ONCE[:1]))
    for one, two in zip(whole.contacts, up.contacts, strict=True):
        assert one.normal_force[-1] > 1e-3 * one.normal_force.max() and not one.steady
        for mine, theirs in zip(one.stations, two.stations, strict=True):
            assert mine.decisive == STEPS
            assert mine.decisive_k_n[0] == pytest.approx(theirs.decisive_k_n[0], rel=1e-8)
