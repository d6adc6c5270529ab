# SPDX-License-Identifier: LGPL-3.0-or-later
"""A few of the random solids with known answers: no number is wrong without a word."""

from __future__ import annotations

import numpy as np
import pytest
from campaign.judge import Judged
from campaign.judge_solids import SOLID_QUANTITIES, judge_solid
from campaign.tables import RESOLVED_SOLIDS, tables

pytestmark = pytest.mark.slow

# A coarse ellipsoid on which half of the stations are not known, and a sphere;
# `python -m campaign solids` has all.
CASES = (22, 13)


@pytest.fixture(scope="module")
def judged() -> list[Judged]:
    return [each for number in CASES for each in judge_solid(number)]


def test_no_number_of_a_solid_is_silently_wrong(judged: list[Judged]) -> None:
    assert [each.text for each in judged if each.verdict == "wrong"] == []


def test_error_bars_hold(judged: list[Judged]) -> None:
    for quantity in SOLID_QUANTITIES[:-1]:
        given = [e for e in judged if e.quantity == quantity and np.isfinite(e.value)]
        assert len(given) > 16
        assert np.mean([each.error <= each.bar for each in given]) >= 0.95


def test_tables_of_solids(judged: list[Judged]) -> None:
    text = tables(judged, SOLID_QUANTITIES, RESOLVED_SOLIDS)
    assert text.startswith("All 2 cases:") and "| ΔK_S |" in text
