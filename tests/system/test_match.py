# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tests for the lower edge of the dovetail, all by finite elements; fewer steps than the demo."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

import fretfe
from fretfe.case import parse_case
from fretfe.matching.casefile import case_tables
from fretfe.matching.match import Match
from fretfe.matching.pads import PadTest
from fretfe.results.model import Result

DEMOS = Path(__file__).parents[2] / "demos"
STEPS, EDGE_SIZE, TOLERANCE = 16, 0.002, 0.02


def fewer_steps(data: dict[str, Any]) -> Any:
    for load in data["loads"].values():
        for segment in load["history"]:
            if "wave" in segment:
                segment["steps_per_cycle"] = STEPS
    return parse_case(data | {"output": {"fields": "none"}})


@pytest.fixture(scope="module")
def match() -> Match:
    data = tomllib.loads((DEMOS / "dovetail.toml").read_text())
    data["geometry"]["parameters"]["edge_size"] = EDGE_SIZE
    component = fretfe.run(fewer_steps(data))
    return fretfe.match_test(component, "left.right", fretfe.load_rig(DEMOS / "rig.toml"))


def best(match: Match, shape: str) -> PadTest:
    (found,) = (each for each in match.shapes if each.shape == shape)
    return found.choices[found.best].test


def solve(match: Match, test: PadTest) -> Result:
    tables = case_tables(test, match.rig, "test")
    return fretfe.run(fewer_steps(tables | {"edges": {"tolerance": TOLERANCE}}))


@pytest.mark.slow
def test_a_flat_pad_stands_for_the_dovetail(match: Match) -> None:
    first = solve(match, best(match, "flat_rounded"))
    (test,) = fretfe.compare_tests(match, [("first", first)]).corrected
    again = solve(match, test)
    (found,) = fretfe.compare_tests(match, [("corrected", again)]).agreements
    own, edge = found.target, found.test
    assert edge.k_n == pytest.approx(own.k_n, rel=0.01)
    assert edge.k_t_range == pytest.approx(own.k_t_range, rel=0.01)
    assert edge.k_i_range == pytest.approx(own.k_i_range, rel=0.01)
    assert edge.longest_slip == pytest.approx(own.longest_slip, rel=0.03)
    # 5 % over two slip zones and the process zone at least.
    assert found.pressure_reach[0].length > 2 * own.longest_slip
    assert found.pressure_reach[0].length > 0.15
    assert found.shear_reach[0].length > 2 * own.longest_slip


@pytest.mark.slow
def test_a_cylinder_keeps_rising_where_the_dovetail_falls(match: Match) -> None:
    result = solve(match, best(match, "cylinder"))
    (found,) = fretfe.compare_tests(match, [("cylinder", result)]).agreements
    assert found.test.k_n == pytest.approx(found.target.k_n, rel=0.01)
    assert found.pressure_reach[0].length < 0.15
    assert "keeps rising" in found.remark
