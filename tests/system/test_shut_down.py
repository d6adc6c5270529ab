# SPDX-License-Identifier: LGPL-3.0-or-later
"""Missions that end without load have the numbers of their largest half cycle, beside half-planes.

Loads fall together on the way down. Where next to nothing is left of them no element tells how
large a flat still is, and what sums under several drivers miss is all that friction could take.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import BASE, SLIDING, STEEL, TOP, pad, ramps

import fretfe
from fretfe.analytic.profiles import FlatRounded
from fretfe.case import parse_case
from fretfe.results.model import Result

FLAT, RADIUS = 0.3, 50.0
E_STAR = STEEL["young"] / (2 * (1 - STEEL["poisson"] ** 2))
WIDE = {f"{body}_{side}": 60.0 for body in ("upper", "lower") for side in ("width", "height")}
FORMS: dict[str, dict[str, Any]] = {
    "cylinder": {"upper_radius": RADIUS, "lower_radius": 0.0},
    "flat_rounded": {"flat_half_width": FLAT, "radius": RADIUS},
    "wedge": {"angle": 0.6},
}


def run(
    form: str,
    normal: Sequence[float],
    shear: Sequence[float],
    tension: Sequence[float],
    friction: float,
    steps: int,
    **cycle: float,
) -> Result:
    """Half-planes under straight ramps from 0 through points at t = 1, 2 ..."""

    loads: dict[str, Any] = {
        "press": {**TOP, "direction": "y", "history": ramps(normal, steps, -1.0)},
        "shear": {**TOP, "direction": "x", "history": ramps(shear, steps)},
    }
    if any(tension):
        pull = {"type": "traction", "boundary": "lower_right", "direction": "normal"}
        loads["bulk"] = {**pull, "history": ramps(tension, steps)}
    data = pad(
        geometry={"template": form, "parameters": FORMS[form] | WIDE},
        supports=SLIDING if any(tension) else BASE,
        loads=loads,
    )
    del data["contacts"]["main"]["friction_from"]
    data["contacts"]["main"]["friction"] = friction
    return fretfe.run(parse_case(data | ({"cycle": cycle} if cycle else {})), backend="halfplane")


@pytest.mark.parametrize("steps", [1, 5])
def test_a_flat_has_the_zone_of_its_largest_load(steps: int) -> None:
    """Of first loading: |Q| = f (P - P of what sticks), and K_T by all outside of that."""
    friction, normal, shear = 0.5, 500.0, 100.0
    points = (normal, normal, normal, 0.0), (0.0, -20.0, shear, 0.0), (0.0, 0.0, 0.0, 0.0)
    result = run("flat_rounded", *points, friction, steps)
    form = FlatRounded(FLAT, RADIUS, E_STAR)
    width, sticks = form.half_width([normal, normal - shear / friction])
    unit = 1 / (np.pi * np.sqrt(2 * width))
    assert result.headline.trust == "trusted"
    for station in result.contacts[0].stations:
        zone = station.longest_zone
        assert zone is not None
        assert abs(zone.length - (width - sticks)) < zone.spread < 0.01 * zone.length
        assert station.equivalent_range == pytest.approx(2 * unit * shear, rel=1e-3)


@pytest.mark.parametrize("residue", [0.0, 1e-13, -1e-13])
def test_round_off_of_loads_is_none(residue: float) -> None:
    normal, shear = 250.0, 60.0
    points = (400.0, normal, residue), (0.0, shear, 0.0), (0.0, 0.0, 0.0)
    result = run("cylinder", *points, 0.4, 3)
    assert result.contacts[0].smallest_normal_force == 0
    unit = 1 / (np.pi * np.sqrt(2 * np.sqrt(4 * normal * RADIUS / (np.pi * E_STAR))))
    for station in result.contacts[0].stations:
        assert station.equivalent_range == pytest.approx(2 * unit * shear, rel=1e-4)


@pytest.mark.parametrize("steps", [1, 15])
def test_several_drivers_leave_nothing_to_slide(steps: int) -> None:
    """With 15 steps a ramp the largest half cycle was lost.

    With 100 steps a ramp shear is f p over .1035 to .1054 at the right edge then, and .1028 slip.
    """
    points = (331.096, 398.071, 532.048, 0.0), (39.541, 16.507, 144.201, 0.0)
    result = run("cylinder", *points, (40.428, 51.964, -56.282, 0.0), 0.8, steps)
    station = result.contacts[0].stations[1]
    zone = station.longest_zone
    assert zone is not None
    assert zone.length == pytest.approx(0.1035, rel=0.02) and zone.spread < 0.02 * zone.length
    assert station.equivalent_range == pytest.approx(92.6, rel=0.005)


@pytest.mark.parametrize("steps", [1, 5])
def test_hold_returns_in_cycles(steps: int) -> None:
    """P and tension, K_I by sums: what was missed a cycle made slip where nothing slips."""
    normal, tension = (396.18, 455.952, 565.337, 414.065), (34.708, 9.62, -18.303, 0.0)
    points = (414.065, *normal, *normal), (0.0,) * 9, (0.0, *tension, *tension)
    result = run("wedge", *points, 0.89, steps, start=5.0, end=9.0)
    for station in result.contacts[0].stations:
        # With 100 steps a ramp 6.438; .02 to .05 of f P act, and steps have to be divided for it.
        assert station.equivalent_range == pytest.approx(6.438, rel=0.004)
        zone = station.longest_zone
        assert zone is not None and result.loads.times[zone.end] == 9.0


@pytest.mark.parametrize("steps", [1, 3])
def test_steps_of_little_shear_are_divided_where_edges_move(steps: int) -> None:
    """Tension alone, 3 % of what friction bears: with one step a ramp the range was 2.06."""
    normal, tension = (298.035, 443.518, 468.391, 366.838), (-57.057, 36.654, 35.233, 0.0)
    points = (366.838, *normal, *normal), (0.0,) * 9, (0.0, *tension, *tension)
    result = run("wedge", *points, 0.71, steps, start=5.0, end=9.0)
    for station in result.contacts[0].stations:
        assert station.equivalent_range == pytest.approx(3.155, rel=0.005)


# Half-planes with 60 steps a ramp: 8.713 and 18.543.
@pytest.mark.parametrize("steps", [1, 2, 15])
@pytest.mark.parametrize(
    ("normal", "tension", "friction", "expected"),
    [
        ((600.0, 600.0, 200.0, 600.0, 0.0), (0.0, 30.0, -30.0, 30.0, 0.0), 0.4, 8.713),
        ((100.0, 600.0, 100.0, 0.0), (-52.0, 57.0, 50.0, 0.0), 0.8, 18.54),
    ],
)
def test_tension_measures_an_edge_alike_in_any_steps(
    normal: tuple[float, ...],
    tension: tuple[float, ...],
    friction: float,
    expected: float,
    steps: int,
) -> None:
    """What P holds beside tension goes with the half-width, from where bodies touch on."""
    nothing = [0.0] * len(normal)
    result = run("cylinder", normal, nothing, tension, friction, steps)
    assert result.headline.trust == "trusted", result.headline.doubts
    for station in result.contacts[0].stations:
        assert station.equivalent_range == pytest.approx(expected, rel=3e-3)


def test_a_zone_that_is_longest_within_a_step_is_not_told_by_a_shorter_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With 8 steps a ramp .063; at the ends of one step .045 and .039."""
    monkeypatch.setitem(FORMS, "flat_rounded", {"flat_half_width": 1.0, "radius": RADIUS})
    points = (400.0, 130.0, 400.0, 130.0, 400.0), (0.0, 20.0, -40.0, 0.0, 60.0)
    result = run("flat_rounded", *points, (3.0, -3.0, 3.0, 3.0, 0.0), 0.4, 1)
    worst = result.headline.worst
    assert worst is not None and worst.zone is not None
    assert worst.name == "main.right" and math.isnan(worst.zone.length)
    assert "the steps do not resolve the slip zone" in result.headline.doubts
    assert "make shorter steps" in worst.zone.reason


@pytest.mark.parametrize("steps", [1, 2])
def test_nodes_alone_tell_no_zone_where_loads_move_with_p(steps: int) -> None:
    """Three drivers out of phase: .34, .24, .28 and .22 with 1, 2, 15 and 40 steps a ramp."""
    normal = (600.0, 200.0, 300.0, 100.0, 400.0, 0.0)
    shear = (42.6142, 54.1662, -18.4934, 8.63038, -11.2602, 0.0)
    tension = (-33.1708, 65.3077, 29.1434, -2.55239, -16.9158, 0.0)
    result = run("flat_rounded", normal, shear, tension, 0.3, steps)
    assert result.headline.trust == "doubted"


@pytest.mark.parametrize("tension", [0.0, 0.001])
def test_that_nothing_slips_is_to_be_trusted_without_a_cycle(tension: float) -> None:
    points = (600.0,) * 4, (0.0,) * 4, (0.0, tension, 0.0, tension)
    result = run("cylinder", *points, 0.4, 2)
    assert result.loads.cycle is None
    assert result.headline.trust == "trusted", result.headline.doubts
    assert "nothing slips" in result.headline.sentences.worst


@pytest.mark.parametrize("steps", [1, 3])
def test_a_zone_that_jumps_as_loads_turn_has_its_bar(steps: int) -> None:
    """P and tension go on in proportion, and back: what was covered then slips in an instant."""
    points = (513.0, 477.0, 749.0, 0.0), (0.0,) * 4, (0.0, 15.0, 32.0, 0.0)
    result = run("cylinder", *points, 0.3, steps)
    assert result.headline.trust == "trusted", result.headline.doubts
    for station in result.contacts[0].stations:
        assert station.equivalent_range == pytest.approx(5.246, rel=3e-3)
        assert station.equivalent_spread < 0.01 * station.equivalent_range


@pytest.mark.parametrize("steps", [3, 15])
def test_no_round_off_of_shear_forces_chooses_a_part_of_a_mission(steps: int) -> None:
    """Tension alone, and a contact that opens: the larger range is after that."""
    points = (600.0, 0.0, 600.0, 500.0, 0.0), (0.0,) * 5, (30.0, 30.0, 0.0, 40.0, 0.0)
    result = run("cylinder", *points, 0.5, steps)
    assert result.headline.larger == ""
    for station in result.contacts[0].stations:
        assert station.equivalent_range == pytest.approx(8.62, rel=3e-3)
