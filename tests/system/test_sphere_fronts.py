# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors and slip zones along the front of a sphere, against closed forms; ν = 0."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from cases.cycled_sphere import FRICTION, LIMIT, PEAK, SHARE, STICK, cycles, tables

from fretfe._typing import Array
from fretfe.evaluate.contacts import Front, Station
from fretfe.results.model import Result

pytestmark = pytest.mark.slow

K_N = PEAK * np.sqrt(2)
# ΔK of a bonded circle under the range of Q.
RANGE = 2 * SHARE * LIMIT / (2 * np.pi * np.sqrt(2))


@pytest.fixture(scope="module")
def front(solved: Callable[[dict[str, Any]], Result]) -> Front:
    case = tables(FRICTION, shear=cycles()) | {"cycle": {"start": 4.0, "end": 6.0}}
    (area,) = solved(case).contacts
    (front,) = area.fronts
    return front


def of_stations(front: Front, number: Callable[[Station], float]) -> Array:
    return np.array([number(station) for station in front.stations])


def angles(front: Front) -> Array:
    points = np.array([station.point for station in front.stations])
    return np.arctan2(-points[:, 2], points[:, 0])


def test_front_is_the_circle_of_hertz(front: Front) -> None:
    assert front.closed and len(front.judged) == 40
    points = np.array([station.point for station in front.stations])
    radii = np.linalg.norm(points[:, [0, 2]], axis=1)
    assert np.abs(radii - 1).max() < 0.004
    assert abs(radii.mean() - 1) < 0.001


def test_k_n(front: Front) -> None:
    found = of_stations(front, lambda station: station.k_n[-1]) / K_N - 1
    spread = of_stations(front, lambda station: station.k_n_spread[-1]) / K_N
    assert np.abs(found).max() < 0.015
    assert abs(found.mean()) < 0.004
    assert np.mean(np.abs(found) < spread) > 0.95


def test_k_n_by_the_movement_of_the_front(front: Front) -> None:
    """Loads 5 % apart to either side move the front by .4 of an element; no fit to the pressure."""
    found = front.along("k_n_moved") / K_N - 1
    spread = front.along("k_n_moved_spread") / K_N
    assert abs(found.mean()) < 0.015
    assert np.abs(found).max() < 0.07
    assert np.mean(np.abs(found) < spread) > 0.95
    assert spread.max() < 0.17


def test_half_spaces(front: Front) -> None:
    """The forces that factors and front need are those of the contact, but for finite bodies."""
    found = front.half_space_ratios
    assert found.reason == ""
    assert found.half_axes == pytest.approx([1.0, 1.0], abs=0.004)
    assert found.shear == pytest.approx(1.0, abs=0.02)
    assert found.normal == pytest.approx(1.0, abs=0.02)
    assert found.pressure == pytest.approx(1.0, abs=0.02)
    assert np.isnan(found.twist)


def test_factors_of_full_stick(front: Front) -> None:
    """K_T = -K cos θ, K_S = K sin θ for a force along +x on body 2, θ about y from x.

    The platen pulls body 1 along x with the force of the case, and body 1 body 2.
    """
    theta = angles(front)
    count = len(front.stations[0].k_t)
    first = count - 13  # with the largest Q; six steps later it is the smallest one
    for name, exact in (("k_t", -np.cos(theta)), ("k_s", np.sin(theta))):
        histories = np.array([getattr(station, name) for station in front.stations])
        change = (histories[:, first + 6] - histories[:, first]) / -RANGE
        assert np.abs(change - exact).max() < 0.03
        assert float(change @ exact / (exact @ exact)) == pytest.approx(1.0, abs=0.01)


def test_range_of_the_vector(front: Front) -> None:
    found = front.along("k_range") / RANGE - 1
    assert abs(found.mean()) < 0.01
    assert np.abs(found).max() < 0.035
    spread = front.along("k_range_spread") / RANGE
    assert np.mean(np.abs(found) < spread) > 0.9
    assert np.median(spread) < 0.04
    assert front.along("turning").max() < 1e-6


def test_slip_zones(front: Front) -> None:
    """Widths within .01 a of Cattaneo's and Mindlin's; too wide for a verdict on the formulas."""
    zones = [station.slip_zones[-1] for station in front.stations]
    length = np.array([zone.length for zone in zones])
    assert all(zone.resolved and not zone.gross for zone in zones)
    assert np.abs(length - (1 - STICK)).max() < 0.014  # .0127
    predicted = np.array([zone.prediction for zone in zones])
    first_order = RANGE / (FRICTION * K_N)
    assert np.abs(predicted / first_order - 1).max() < 0.08
