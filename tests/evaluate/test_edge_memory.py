# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where an edge slips if it draws back, covers places anew and shears them meanwhile."""

from __future__ import annotations

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, PRESS_STEPS, problem, solved

from fretfe.evaluate.cycles import slip_phases
from fretfe.evaluate.edge_memory import slip_drive

STEPS = 4


def d(edge: float, border: float) -> float:
    """Slip zone of a cylinder from its edge at one load to the half-width of another.

    With Q spread over the loads from 0 to P, as the pressure is over flat punches, each carries f
    at most (Jaeger 1998): the border is where punches that are larger have taken the change of Q.
    """
    return float(np.sqrt(edge) - np.sqrt(border))


# P and Q at the turns, over P and f P, and end and length of each zone, in ways from turn to turn.
HISTORIES: dict[str, tuple[list[tuple[float, float]], list[tuple[float, float]]]] = {
    # Punches from .7 to .95 carry -.6 f, and take 1.6 f each as Q turns.
    "sheared as it is covered": (
        [(1, 0), (0.7, 0), (0.95, -0.15), (0.95, -0.05)],
        [(3, d(0.95, 0.95 - 0.1 / 1.6))],
    ),
    "slip on new places does not come to that before": (
        [(1, 0), (1, 0.3), (1.3, 0.3), (1.3, 0.35)],
        [(1, d(1, 0.7)), (3, d(1.3, 1.25))],
    ),
    "slip on new places comes to that before": (
        [(1, 0), (1, 0.3), (1.1, 0.3), (1.1, 0.5)],
        [(3, d(1.1, 0.6))],
    ),
    "the last half cycle is not complete": (
        [(1, 0), (1, 0.5), (1, 0.2)],
        [(1, d(1, 0.5)), (2, d(1, 0.85))],
    ),
    # What they lose as P falls others take over.
    "P alone falls over places that are sheared": (
        [(1, 0), (1, 0.3), (0.8, 0.3)],
        [(2, d(0.8, 0.5))],
    ),
    # The longest zone each way. Punches from .923 to 1 come back with f and take .077; others turn.
    "both fall, and the way turns meanwhile": (
        [(1, 0), (0.923, -0.216), (1, 0.006), (0.714, -0.188), (0.851, -0.093), (0.8, -0.01)],
        [(1, d(0.923, 0.923 - 0.216)), (2, d(1, 0.923 - (0.222 - 0.077) / 2))],
    ),
}


@pytest.mark.parametrize("name", HISTORIES)
def test_zones_without_a_cycle(name: str) -> None:
    turns, expected = HISTORIES[name]
    ways = np.linspace(0.0, len(turns) - 1, STEPS * (len(turns) - 1) + 1)
    p, q = (np.interp(ways, range(len(turns)), each) for each in np.transpose(turns))
    for station in solved(problem(LOAD * p, LIMIT * q), 150).stations:
        ends = [(zone.end - PRESS_STEPS - 1) / STEPS for zone in station.slip_zones]
        assert ends == [end for end, _ in expected]
        for zone, (_, length) in zip(station.slip_zones, expected, strict=True):
            assert zone.length == pytest.approx(length, abs=zone.spread)
            assert zone.spread < 0.25 * length


def test_at_constant_normal_load_slip_is_driven_by_k_t() -> None:
    k_t = np.array([0.0, 1.0, -0.5, 0.2])
    np.testing.assert_allclose(slip_drive(k_t, 0 * k_t), k_t, atol=1e-15)


def test_an_edge_that_is_pressed_faster_than_sheared_sticks() -> None:
    """There and back with other steps; then Q turns on what it has covered."""
    normal = np.array([1.0, 0.7, 0.8, 0.95, 0.75, 0.7, 0.95, 0.95])
    shear = 0.6 * (normal - 0.7) * np.append(0.0, np.ones(7))
    shear[-1] -= 0.1
    drive = slip_drive(shear, normal)
    np.testing.assert_allclose(drive[:-1], 0.0, atol=1e-12)
    assert drive[-1] == pytest.approx(-0.1)
    ends, directions = slip_phases(drive, shear - normal, shear + normal)
    assert (ends.tolist(), directions.tolist()) == ([7], [-1])
