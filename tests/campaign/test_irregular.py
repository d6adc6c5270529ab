# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random irregular histories: error bars hold beside exact numbers.

The seed is that of the week, so that CI judges other cases in time; a failure tells it.
"""

from __future__ import annotations

import pytest
from campaign.extent import by_extent
from campaign.irregular import judge_irregular, judge_irregular_elements
from campaign.irregular_tables import require_held


@pytest.mark.slow
def test_histories_of_the_week() -> None:
    require_held(judge_irregular, by_extent(8, 12))


@pytest.mark.parametrize("number", [9, 97])
def test_borders_behind_an_edge_that_moves(number: int) -> None:
    # P falls while they slip: bars held .49 of the error of a wedge in one step, .79 of a cylinder.
    found = [each for each in judge_irregular(number, 43001) if each.quantity == "d"]
    zones = [each for each in found if each.truth > 0.05]
    assert len(zones) == 4
    assert all(each.error <= each.bar < 0.1 * each.truth for each in zones)


@pytest.mark.fem
def test_range_between_areas_of_few_nodes() -> None:
    # Areas of a wedge that have too few nodes for fits lie between those of two integrals: K_T of
    # a unit of Q between them was 5 % high.
    found = [each for each in judge_irregular_elements(21, 190041) if each.quantity == "ΔK_T"]
    assert len(found) == 2
    assert all(abs(each.value / each.truth - 1) < 0.01 for each in found)
