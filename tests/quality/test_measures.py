# SPDX-License-Identifier: LGPL-3.0-or-later
"""Means of numbers with error bars, and the bars that stand beside them."""

from __future__ import annotations

import math

import pytest

from fretfe.backends.halfplane import BACKEND
from fretfe.quality.comparison import Averaged, Quantity, compare
from fretfe.quality.cycles import LAGGING, loop_case, slip_lengths


def test_a_mean_has_the_mean_of_the_bars() -> None:
    measure = Averaged(lambda _: [(1.0, 0.1), (3.0, 0.3)])
    result = BACKEND.solve(loop_case(LAGGING))
    row = compare(
        "mean", Quantity("K_N", 2.0, 2.0, {"halfplane": 0.1}, measure), "halfplane", result
    )
    assert row.computed == 2.0 and row.spread == pytest.approx(0.2)
    plain = Quantity("a", 1.0, 1.0, {"halfplane": 0.1}, lambda _: 1.0)
    assert compare("plain", plain, "halfplane", result).spread is None
    for side, quantity in enumerate(slip_lengths(LAGGING)):
        found = compare("d", quantity, "halfplane", result).spread
        zone = result.contacts[0].stations[side].slip_zones[-1]
        assert found == (zone.spread if math.isfinite(zone.spread) else None)
