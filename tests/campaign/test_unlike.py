# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random pairs of unlike bodies: error bars hold beside half-planes three times as fine."""

from __future__ import annotations

import numpy as np
import pytest
from campaign.extent import by_extent
from campaign.judge import Judged
from campaign.unlike import UNLIKE_QUANTITIES, judge_moving_unlike, judge_unlike


def held(judged: list[Judged], quantity: str) -> float:
    """Share of the numbers with a bar that are within it; of predictions those with a verdict."""
    given = [e for e in judged if e.quantity == quantity and np.isfinite(e.value) and e.bar > 0]
    return float(np.mean([each.error <= each.bar for each in given]))


def test_one_pair() -> None:
    judged = judge_unlike(0)
    assert len(judged) == 12
    assert [each.text for each in judged if each.verdict != "right"] == []


@pytest.mark.slow
def test_error_bars_of_pairs_hold() -> None:
    """Of those after the first, which has a test of its own."""
    judged = [each for number in range(1, by_extent(3, 60)) for each in judge_unlike(number)]
    for quantity in UNLIKE_QUANTITIES:
        assert held(judged, quantity) >= 0.95, quantity


@pytest.mark.slow
def test_bars_hold_with_few_steps_as_p_moves_the_edges() -> None:
    """A third of the zones were outside when all places counted that slip had passed."""
    judged = [each for number in range(by_extent(2, 40)) for each in judge_moving_unlike(number)]
    assert held(judged, "d") >= 0.9
