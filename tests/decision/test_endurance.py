# SPDX-License-Identifier: LGPL-3.0-or-later
"""Crossland and Dang Van against the tests they are made of, balls against brute force, means."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from fretfe._typing import Array
from fretfe.decision.endurance import (
    Distance,
    ShearAndPressure,
    crossland,
    dang_van,
    distance_points,
    smallest_ball,
)

TENSION, TORSION = 300.0, 190.0
CROSSLAND = ShearAndPressure.crossland(TENSION, TORSION)
DANG_VAN = ShearAndPressure.dang_van(TENSION, TORSION)
CYCLE = np.sin(2 * np.pi * np.arange(40) / 40)


def history(**components: Array) -> Array:
    """(n, 1, 6) of histories by name."""
    found = np.zeros((len(CYCLE), 1, 6))
    for name, values in components.items():
        found[:, 0, ("xx", "yy", "zz", "xy", "yz", "xz").index(name)] = values
    return found


@pytest.mark.parametrize("judge", [crossland, dang_van])
def test_the_limits_themselves_are_just_endured(judge: object) -> None:
    law = CROSSLAND if judge is crossland else DANG_VAN
    assert callable(judge)
    assert judge(history(xx=TENSION * CYCLE), law) == pytest.approx(1, rel=1e-4)
    assert judge(history(yz=TORSION * CYCLE), law) == pytest.approx(1, rel=1e-4)
    # A steady shear changes neither, a steady tension does by its hydrostatic part.
    assert judge(history(yz=TORSION * CYCLE, xy=90 + 0 * CYCLE), law) == pytest.approx(1, rel=1e-4)
    pulled = judge(history(yz=TORSION * CYCLE, xx=60 + 0 * CYCLE), law)
    assert pulled == pytest.approx(1 + law.weight * 20 / TORSION, rel=1e-4)


def test_tension_and_torsion_out_of_phase() -> None:
    """Crossland's ball: the ellipse of the deviator has the larger of both half axes."""
    shifted = history(xx=TENSION * CYCLE, xy=0.5 * TORSION * np.roll(CYCLE, 10))
    assert crossland(shifted, CROSSLAND) == pytest.approx(1, rel=1e-3)
    in_phase = history(xx=TENSION * CYCLE, xy=0.5 * TORSION * CYCLE)
    shear = np.hypot(TENSION / np.sqrt(3), 0.5 * TORSION)
    known = (shear + CROSSLAND.weight * TENSION / 3) / TORSION
    assert crossland(in_phase, CROSSLAND) == pytest.approx(known, rel=1e-4)


def test_balls_are_the_smallest_ones() -> None:
    ways = np.random.default_rng(2).normal(size=(30, 8, 6)) * np.array([3, 1, 1, 2, 1, 0.1])
    middles, radii = smallest_ball(ways)
    for way, middle, radius in zip(ways.swapaxes(0, 1), middles, radii, strict=True):

        def reach(at: Array, way: Array = way) -> float:
            return float(np.linalg.norm(way - at, axis=1).max())

        assert radius == pytest.approx(reach(middle))
        best = minimize(reach, way.mean(axis=0), method="Powell", options={"maxiter": 10_000})
        assert radius <= best.fun * (1 + 1e-4)
    one = smallest_ball(np.ones((3, 2, 6)))
    assert one[1] == pytest.approx([0, 0]) and (one[0] == 1).all()


def test_two_places_have_the_middle_between_them() -> None:
    middle, radius = smallest_ball(np.array([[[1.0, 2, 3]], [[3.0, 2, -1]], [[2.0, 2, 1]]]))
    assert middle[0] == pytest.approx([2, 2, 1]) and radius[0] == pytest.approx(np.sqrt(5))


@pytest.mark.parametrize(
    ("method", "mean"), [("point", 0.5), ("line", 1.0), ("area", 4 / 3 / np.pi)]
)
def test_means_of_the_depth(method: Distance, mean: float) -> None:
    """The middle of a half disc is 4 L/(3 π) deep."""
    points, weights = distance_points(method, 0.2)
    assert weights.sum() == pytest.approx(1)
    assert points.T @ weights == pytest.approx([0, -0.2 * mean], abs=1e-4 * 0.2)
    assert (points[:, 1] < 0).all() and np.linalg.norm(points, axis=1).max() < 0.4
