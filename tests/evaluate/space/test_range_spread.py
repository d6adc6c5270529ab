# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error bars of the ranges of factors at stations of solids, part by part."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from evaluate.space.test_evaluate import STATIONS, grid, hertz, solved

from fretfe.evaluate.factors import FactorHistories
from fretfe.evaluate.space.fronts import FrontTrack, follow_fronts
from fretfe.evaluate.space.range_spread import WITHIN_ELEMENT, unresolved


@pytest.fixture(scope="module")
def circle() -> FrontTrack:
    """A circle of radius 1."""
    solution, contact = solved(*grid(), [hertz(1.0, 1.0)] * 2)
    (track,) = follow_fronts(solution, contact, STATIONS)
    return track


@pytest.mark.parametrize(("size", "cramped"), [(0.05, False), (0.08, False), (0.2, True)])
def test_where_integrals_have_few_elements_the_bar_holds_it(
    circle: FrontTrack, size: float, cramped: bool
) -> None:
    """All ways reach as far there, and agree: at tips of an ellipse, 2.3 elements, 4.4 % off."""
    sectors = tuple(replace(each, size=size) for each in circle.front.sectors)
    fit = replace(circle.fit, place_spread=np.zeros_like(circle.fit.place_spread))
    ways = np.zeros((4, STATIONS, 3, 3))
    ways[:, :, :, 1] = [0.0, 1.0, -1.0]  # K_T of all stations, by all ways
    factors = FactorHistories(
        ways,
        None,
        exact=False,
        one_sided=np.zeros((STATIONS, 3)),
        uneven=np.zeros((STATIONS, 3)),
        known=np.ones(0, dtype=bool),
        units=np.zeros(0),
    )
    front = copy(circle.front)
    front.sectors = sectors
    cycle, direction = np.array([1, 2]), np.array([1.0, 0.0])
    parts = unresolved(factors, front, fit, 0, direction, cycle)
    found = factors.range_spread(0, direction, parts, cycle, None)
    assert found.extraction == found.steps == 0.0
    # Integrals reach .4 of the radius; 4 elements are the shortest of the ways that are compared.
    radius = min(1 / front.frames.curvature[0], *front.depth)
    assert radius == pytest.approx(1.0, rel=0.08)
    few = 0.15 * (size / (0.4 * radius) - 1 / 4) if cramped else 0.0
    expected = 2 * math.hypot(WITHIN_ELEMENT * size / radius, few)
    assert found.discretisation == pytest.approx(expected, rel=0.02)
