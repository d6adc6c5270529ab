# SPDX-License-Identifier: LGPL-3.0-or-later
"""How much of a campaign, or of a dear test, runs: FRETFE_CAMPAIGN=long is more than CI."""

from __future__ import annotations

import datetime as dt
import os
from typing import TypeVar

import pytest

T = TypeVar("T")
LONG = os.environ.get("FRETFE_CAMPAIGN") == "long"
_YEAR, _WEEK, _ = dt.date.today().isocalendar()
# Of the week, or the one that is given: what fails can be drawn again.
SEED = int(os.environ.get("FRETFE_CAMPAIGN_SEED", 100 * _YEAR + _WEEK))


def by_extent(short: T, long: T) -> T:
    """Return what belongs to the form that runs."""
    return long if LONG else short


def every_so_many_weeks(weeks: int, turn: int) -> pytest.MarkDecorator:
    """Of dear tests of one thing CI runs another one each week, the long form all of them."""
    return pytest.mark.skipif(
        not LONG and SEED % weeks != turn,
        reason=f"CI runs it every {weeks} weeks, FRETFE_CAMPAIGN=long at any time",
    )
