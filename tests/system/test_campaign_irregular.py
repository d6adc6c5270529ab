# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random irregular histories by finite elements: error bars hold beside exact numbers.

The seed is that of the week, so that CI judges other cases in time; a failure tells it.
"""

from __future__ import annotations

import pytest
from campaign.extent import by_extent
from campaign.irregular import judge_irregular_elements
from campaign.irregular_tables import require_held


@pytest.mark.slow
def test_histories_of_the_week() -> None:
    require_held(judge_irregular_elements, by_extent(6, 8))
