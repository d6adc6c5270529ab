# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of a made-up history whose border is known."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.edges import Side
from fretfe.evaluate.slip_zones import slip_zones
from fretfe.solution import OPEN, SLIP, STICK, BondedUnits, ContactHistory, Solution

H, EDGE, ZONE = 0.05, 1.02, 0.31
X = np.linspace(-22 * H, 22 * H, 45)
CLOSED = np.abs(X) < EDGE
STATES = 4  # unloaded, pressed, two steps of shear


def history(increments: np.ndarray) -> tuple[Solution, ContactHistory]:
    """A solved history with slip increments (2, N) in its last two steps."""
    status = np.where(CLOSED, STICK, OPEN) * np.ones((STATES, 1), int)
    status[2:][increments != 0] = SLIP
    slip = np.cumsum(np.vstack([np.zeros((2, len(X))), increments]), axis=0)[:, :, None]
    traction = np.zeros((STATES, len(X), 2))
    traction[1:, CLOSED, 0] = np.sqrt(EDGE**2 - X[CLOSED] ** 2)
    zero = np.zeros((STATES, len(X)))
    contact = ContactHistory(
        name="made up",
        body1="upper",
        body2="lower",
        arc=X,
        points=np.stack([X, 0 * X], axis=1),
        frames=np.zeros((len(X), 2, 2)),
        weights=np.full(len(X), H),
        friction=np.array([0.0, 0.0, 0.5, 0.5]),
        traction=traction,
        mean_traction=traction,
        gap=zero,
        slip=slip,
        status=status.astype(np.int8),
        dissipation=zero,
        bonded=BondedUnits(np.zeros((0, len(X), 2, 0)), np.full(STATES, -1)),
    )
    none = np.zeros((STATES, 0))
    count = np.zeros(STATES, int)
    solution = Solution(
        2,
        np.arange(4.0),
        (),
        none,
        None,
        (),
        none,
        none,
        (),
        none,
        (contact,),
        count,
        count,
        count,
        {},
    )
    return solution, contact


def length(side: Side, increments: np.ndarray) -> float:
    solution, contact = history(increments)
    sign = -1.0 if side == "left" else 1.0
    position = np.array([np.nan, *[sign * EDGE] * 3])
    k_t = np.array([0.0, 0.0, 0.5, 1.0])
    zones = slip_zones(solution, contact, side, position, np.ones(4), k_t, np.zeros(4))
    assert [(zone.start, zone.end, zone.resolved) for zone in zones] == [(1, 3, True)]
    return zones[0].length


def slip_to(zone: float) -> np.ndarray:
    depth = np.where(CLOSED, zone - (EDGE - np.abs(X)), 0.0)
    return np.maximum(depth, 0.0) ** 1.5


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("side", ["left", "right"])
def test_border(side: Side, direction: float) -> None:
    increments = direction * np.array([slip_to(ZONE / 2), slip_to(ZONE) - slip_to(ZONE / 2)])
    # slip^(2/3) is exactly linear
    assert length(side, increments) == pytest.approx(ZONE, abs=1e-9)


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("side", ["left", "right"])
def test_slip_left_over_from_the_half_cycle_before_does_not_count(
    side: Side, direction: float
) -> None:
    increments = np.array([0 * X, slip_to(ZONE)])
    inside = np.flatnonzero(CLOSED & (EDGE - np.abs(X) > ZONE))[[0, 1, -2, -1]]
    increments[0, inside] = -0.01 * slip_to(ZONE).max()
    assert length(side, direction * increments) == pytest.approx(ZONE, abs=1e-9)
