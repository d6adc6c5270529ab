# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random cases with known answers: no number is wrong without a word, and error bars hold."""

from __future__ import annotations

import numpy as np
import pytest
from campaign.judge import QUANTITIES, Judged, judge_case
from campaign.tables import RESOLVED, tables

# The first ones of `python -m campaign`.
COUNT = 36


@pytest.fixture(scope="module")
def judged() -> list[Judged]:
    return [each for number in range(COUNT) for each in judge_case(number)]


@pytest.mark.slow
def test_no_number_is_silently_wrong(judged: list[Judged]) -> None:
    assert [each.text for each in judged if each.verdict == "wrong"] == []


@pytest.mark.slow
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_error_bars_hold_and_are_no_larger_than_needed(judged: list[Judged], quantity: str) -> None:
    given = [e for e in judged if e.quantity == quantity and np.isfinite(e.value)]
    assert len(given) > COUNT / 2
    assert np.mean([each.error <= each.bar for each in given]) >= 0.95
    resolved = [e for e in given if e.draw.per_half_width >= RESOLVED and e.truth]
    bar = np.median([each.bar / each.truth for each in resolved])
    error = np.median([abs(each.value / each.truth - 1) for each in resolved])
    assert bar <= 6 * error


@pytest.mark.slow
def test_meshes_as_they_are_advised_give_numbers(judged: list[Judged]) -> None:
    resolved = [each for each in judged if each.draw.per_half_width >= RESOLVED]
    assert np.mean([np.isfinite(each.value) for each in resolved]) >= 0.9


@pytest.mark.slow
def test_tables(judged: list[Judged]) -> None:
    text = tables(judged)
    assert text.startswith(f"All {COUNT} cases:")
    for quantity in QUANTITIES:
        (row, _) = (line for line in text.splitlines() if line.startswith(f"| {quantity} |"))
        given, right, flagged, wrong = (cell.strip() for cell in row.split("|")[2:6])
        assert int(given.split(" of ")[1]) == int(right) + int(flagged) + int(wrong)
