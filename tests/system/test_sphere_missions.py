# SPDX-License-Identifier: LGPL-3.0-or-later
"""Spheres from and to P = 0 with P and Q moving at once, against exact slip zones (Jäger).

Where P and Q make a front stand at P* in first loading or after a reversal, c is the radius under
P*. Ten elements over the radius, ν = 0.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fretfe
from fretfe._typing import Array
from fretfe.case import parse_case
from fretfe.reason import Kind

RADIUS, YOUNG, FRICTION = 100.0, 2e5, 0.4
STATIONS = 24

pytestmark = [pytest.mark.fem, pytest.mark.slow]


def radius(load: float) -> float:
    """Of Hertz's contact, E* = E/2."""
    return float((3 * load * RADIUS / (2 * YOUNG)) ** (1 / 3))


def case(corners: Array, parts: int) -> dict[str, Any]:
    def platen(direction: str, values: Array) -> dict[str, Any]:
        history = [
            {"ramp": float(value), "until": until, "steps": parts}
            for until, value in enumerate(values, start=1)
        ]
        kind = {"type": "platen", "boundary": "upper_top", "control": "force"}
        return {**kind, "direction": direction, "history": history}

    sides = {f"{body}_{side}": 24 for body in ("upper", "lower") for side in ("width", "height")}
    return {
        "geometry": {
            "template": "sphere",
            "parameters": {"radius_x": RADIUS, "size": 0.1, **sides},
        },
        "bodies": {name: {"young": YOUNG, "poisson": 0.0} for name in ("upper", "lower")},
        "contacts": {
            "main": {
                "surface1": "upper_contact",
                "surface2": "lower_contact",
                "friction": FRICTION,
            }
        },
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
        "loads": {"press": platen("y", -corners[:, 0]), "shear": platen("x", corners[:, 1])},
        "edges": {"stations": STATIONS},
        "output": {"fields": "none"},
    }


# P, Q after each second; the longest zone is there at P, where the front was at P*.
OUT_OF_PHASE = [(1300, 0), (900, 250), (1300, -250), (900, 250), (1300, -250), (0, 0)]
IN_PHASE = [(1300, 224), (672, -45), (1300, 224), (0, 0)]
PARTING = [(1300, 0), (1300, -234), (1300, 117), (0, 0)] * 2
# Places that are covered again take f dP, those that slipped back twice as much.
AGAIN = 672 - (269 - FRICTION * 628) / (2 * FRICTION)


@pytest.mark.parametrize(
    ("corners", "at", "stands", "parts"),
    [
        (OUT_OF_PHASE, 900, 900 - 250 / FRICTION, 1),
        (OUT_OF_PHASE, 900, 900 - 250 / FRICTION, 4),
        (IN_PHASE, 1300, AGAIN, 1),
        (IN_PHASE, 1300, AGAIN, 4),
        (PARTING, 1300, 1300 - 234 / FRICTION, 3),
    ],
)
def test_zones_of_missions_from_and_to_zero(
    corners: list[tuple[float, float]], at: float, stands: float, parts: int
) -> None:
    result = fretfe.run(parse_case(case(np.array(corners, dtype=float), parts)))
    (contact,) = result.contacts
    zones = [each.longest_zone for each in contact.stations]
    told = np.array([each.told for each in zones if each is not None])
    exactly = radius(at) - radius(stands)
    assert np.count_nonzero(np.isfinite(told[:, 0])) >= STATIONS - 2
    assert np.median(told[:, 0]) == pytest.approx(exactly, rel=0.04)
    assert np.mean(abs(told[:, 0] - exactly) <= told[:, 1]) >= 0.95
    assert np.median(told[:, 1]) < 0.11 * exactly
    ranges = np.array([each.told_range for each in contact.stations])
    assert np.median(ranges[:, 1] / ranges[:, 0]) < 0.05
    assert np.std(ranges[:, 0]) < 0.02 * np.mean(ranges[:, 0])


def test_stations_whose_k_n_is_unknown_have_no_part_in_plane_problems() -> None:
    """Seven elements over the radius: where P is least few fits know K_N."""
    corners = [(2000, 0), *[(2900, 500), (1600, -300), (2000, 0)] * 2]
    data = case(np.array(corners, dtype=float), 1)
    sides = {f"{body}_{side}": 12 for body in ("upper", "lower") for side in ("width", "height")}
    data["geometry"]["parameters"] = {"radius_x": 50, "contact_x": 1.0, "size": 0.14, **sides}
    data["contacts"]["main"]["friction"] = 0.5
    data["cycle"] = {"start": 4.0, "end": 7.0}
    result = fretfe.run(parse_case(data))
    assert result.failure is None and not any(each.kind is Kind.FAULT for each in result.warnings)
    stations = result.contacts[0].stations
    known = [np.isfinite(each.k_n[each.last]) for each in stations]
    assert 0 < sum(known) < STATIONS
    zones = [each.longest_zone for each in stations]
    local = [zone is not None and np.isfinite(zone.reported_local) for zone in zones]
    assert local == known
    # The loop that closes at P = 1600 slips back to where the front was at 1450, not to the older
    # front behind that, which is four times as far.
    closing = [each.slip_zones[-1].local for each in stations if known[each.number]]
    sphere = radius(1600.0) - radius(1450.0)
    assert np.median(closing) == pytest.approx(sphere * (50 / RADIUS) ** (1 / 3), rel=0.12)
