# SPDX-License-Identifier: LGPL-3.0-or-later
"""Hertz pressed with friction from the first load on, then sheared there and back, without a cycle.

While Q grows with P by less than f an edge sticks (Jäger 1998): afterwards the traction is
f (p - p_c) + s p_c, with s = dQ/dP of the pressing, so that Q = f (P - P_c) + s P_c and
d = a - a_c. After a reversal by dQ P_c = P - dQ/(2 f) as long as that is within what has slipped
before; beyond, as if Q had gone there at once.
"""

from __future__ import annotations

import numpy as np
import pytest
from cases import halfplane_problems
from cases.halfplane_problems import LIMIT, LOAD, PRESS_STEPS, problem, solved

# Q over f P: to this, and back to minus 0.433.
TOP = 0.5
THERE, BACK = (0.25, 0.433, TOP), (0.25, 0.0, -0.25, -0.433)


@pytest.mark.parametrize("share", [0.0, 0.3, -0.2])
@pytest.mark.parametrize("mirror", [1, -1])
def test_each_half_cycle_counts_from_where_the_edge_slips(share: float, mirror: int) -> None:
    path = [share, *(each for each in THERE if each > share), *BACK]
    shear = mirror * LIMIT * np.array(path)
    contact = solved(problem(np.full_like(shear, LOAD), shear, frictional_press=True))
    top = PRESS_STEPS + 1 + path.index(TOP)
    last = PRESS_STEPS + len(path)
    # d with P_c.
    stuck, within = (1 - TOP) / (1 - share), 1 - (TOP - BACK[-1]) / 2
    beyond = (1 + BACK[-1]) / (1 + share)
    exact = 1 - np.sqrt([stuck, within if within > stuck else beyond])
    for station in contact.stations:
        there, back = station.slip_zones
        assert (there.end, back.start, back.end) == (top, top, last)
        assert there.start in (PRESS_STEPS, PRESS_STEPS + 1)
        assert there.length == pytest.approx(exact[0], abs=there.spread + 0.004)
        assert back.length == pytest.approx(exact[1], abs=back.spread + 0.004)
        assert [there.prediction, back.prediction] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize(("steps", "elements"), [(3, 300), (10, 300), (5, 600)])
def test_a_zone_is_as_good_as_the_steps_of_the_pressing_around_its_border(
    steps: int, elements: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Shear is locked in anywhere within a step: .1611, .1578 and .1628 for .1548."""
    monkeypatch.setattr(halfplane_problems, "PRESS_STEPS", steps)
    share, shear = 0.3, LIMIT * np.array([0.3, 0.433, TOP, 0.25])
    given = problem(np.full_like(shear, LOAD), shear, frictional_press=True)
    exact = 1 - np.sqrt((1 - TOP) / (1 - share))
    for station in solved(given, elements).stations:
        there = station.slip_zones[0]
        assert there.length == pytest.approx(exact, abs=there.spread)
        assert there.spread < 0.085 * exact


@pytest.mark.parametrize("steps", [4, 12])
@pytest.mark.parametrize("share", [0.33, 0.6, 0.86])
def test_a_border_where_the_edge_has_moved_outward_is_as_good_as_its_step(
    share: float, steps: int
) -> None:
    """Q rises with P by a share of f P, then goes on alone.

    Each flat punch of the load L takes f dL at most, of which that share is used (Jaeger 1998).
    """
    low, high, border = 0.7, 0.95, 0.83
    pressed = np.append(np.linspace(low, high, steps + 1), high)
    shear = share * (pressed - low)
    shear[-1] += (1 - share) * (high - border)
    given = problem(np.append(1.0, pressed) * LOAD, np.append(0.0, shear) * LIMIT)
    exact = np.sqrt(high) - np.sqrt(border)
    for station in solved(given).stations:
        zone = station.slip_zones[-1]
        assert zone.end == len(station.position) - 1
        assert zone.length == pytest.approx(exact, abs=zone.spread)
        assert zone.spread < 2 * (np.sqrt(border + (high - low) / steps) - np.sqrt(border))
