# SPDX-License-Identifier: LGPL-3.0-or-later
"""No slip, and none predicted, is an answer: d = 0 with its bar, which agrees."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, loop, problem, solved

from fretfe.evaluate.contacts import Contact, RangeSpread, Station
from fretfe.evaluate.verdicts import judge, longest_verdict
from fretfe.verdict import Verdict

CYCLE = 12
WAVE = np.sin(loop(CYCLE, cycles=2))
ELEMENTS = 80
# Loads, friction, and the largest length that the formulas predict for an evaluated half cycle.
STILL = {
    "P alone cycles": (problem(LOAD * (1 + 0.1 * WAVE), cycle=CYCLE), 1e-12),
    "P and Q in step, dQ/dP = f/2": (
        problem(LOAD * (1 + 0.1 * WAVE), 0.05 * LIMIT * WAVE, cycle=CYCLE),
        1e-12,
    ),
    "an amplitude of 0": (problem(LOAD, 0.0 * WAVE, cycle=CYCLE), 1e-12),
    "an amplitude of 0 after a shear force": (
        problem(LOAD, np.append(np.linspace(0.06, 0.3, 5), 0.3 + 0.0 * WAVE) * LIMIT, cycle=CYCLE),
        1e-12,
    ),
    "an amplitude of 1e-9": (problem(LOAD, 1e-9 * LIMIT * WAVE, cycle=CYCLE), 1e-8),
    # d = ΔK_T/(f K_N) = a Q/(f P) to first order
    "friction of 1e6": (problem(LOAD, 0.3 * WAVE, friction=1e6, cycle=CYCLE), 1e-6),
    "a mission with scale 0": (problem(LOAD, 0.0 * WAVE), np.inf),
}


@cache
def contact(name: str) -> Contact:
    return solved(STILL[name][0], ELEMENTS)


@pytest.mark.parametrize("name", STILL)
def test_no_slip_agrees_with_none_predicted(name: str) -> None:
    half_width, most = float(contact(name).half_width[-1]), STILL[name][1]
    for station in contact(name).stations:
        verdict, zone = longest_verdict(station), station.longest_zone
        assert zone is not None
        assert verdict.verdict == Verdict.AGREES, verdict.reason
        assert zone.told[0] == 0
        # The first node in contact, some two elements from the edge, and one more.
        assert 0 < zone.told[1] <= 4 * station.size
        assert not zone.prediction > most * half_width


def still_station() -> Station:
    return contact("P and Q in step, dQ/dP = f/2").stations[0]


def judged(station: Station, **zone: Any) -> str:
    return judge(station, replace(station.slip_zones[-1], **zone)).verdict


def test_a_range_that_may_be_anything_leaves_no_slip_open() -> None:
    station = still_station()
    bar = 2 * station.k_range
    vague = replace(station, k_range_spread=bar, k_range_parts=RangeSpread(bar, 0.0, 0.0))
    assert judged(vague) == Verdict.UNKNOWN
    assert judged(replace(vague, k_range_spread=np.nan)) == Verdict.UNKNOWN


def test_no_slip_where_some_is_predicted_is_none_that_agrees() -> None:
    station = still_station()
    zone = station.slip_zones[-1]
    assert judged(station, predicted_loop=2 * zone.spread + station.size) == Verdict.DIFFERS
    # More than nothing, and less than nodes would show: nothing to check.
    assert judged(station, predicted_loop=0.3 * zone.spread) == Verdict.UNKNOWN


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"spread": np.inf}, "no node slips, but that has no error bar"),
        (
            {"spread": np.inf, "resolved": False},
            "no node slips, but a zone of any length may lie between the nodes",
        ),
        (
            {"spread": 0.02, "resolved": False},
            "no node slips, but a zone shorter than 0.02 may lie between the nodes",
        ),
    ],
)
def test_an_infinite_error_bar_is_none(changes: dict[str, Any], reason: str) -> None:
    station = still_station()
    assert station.longest_zone is not None
    assert judge(station, replace(station.longest_zone, **changes)).reason == reason


def test_no_slip_of_a_plane_problem_beside_nodes() -> None:
    station = still_station()
    bar = 1e-3 * station.size
    assert judged(station, local=0.0, local_spread=bar) == Verdict.AGREES
    slipping = {"length": 9 * station.size, "spread": 0.1 * station.size}
    assert judged(station, local=0.0, local_spread=bar, **slipping) == Verdict.DIFFERS
