# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random irregular histories by half-planes: error bars hold beside exact numbers.

The seed is that of the week, so that CI judges other cases in time; a failure tells it.
"""

from __future__ import annotations

import pytest
from campaign.extent import by_extent
from campaign.irregular import judge_irregular
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
