# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies that part in a wave: K_T counts from where they touch again, beside half-planes.

With P and Q as found, K_T of half-planes is the sum of dQ/(pi sqrt(2 a)) since the last touch, a
that of a cylinder under P; half the difference between the edges knows nothing of finite bodies.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases.pad_cases import PAD, TOP

import fretfe
from fretfe._typing import Array
from fretfe.case import parse_case

RADIUS, E_STAR = 30.0, 210e3 / (2 * (1 - 0.3**2))
SIZES: dict[str, float] = {
    "upper_width": 8,
    "upper_height": 8,
    "lower_width": 16,
    "lower_height": 8,
}
SIZES |= {"upper_radius": RADIUS, "lower_radius": 0, "size": 0.02, "zone": 0.45}
CLOSED = -0.004
PIECES = 2000


def exact_range(normal: Array, shear: Array, states: slice) -> float:
    """Range of K_T in some of the states (T,)."""
    found, k_t = [0.0], 0.0
    for step in range(1, len(normal)):
        p, q = (np.linspace(each[step - 1], each[step], PIECES + 1) for each in (normal, shear))
        a = np.sqrt(4 * (p[1:] + p[:-1]) / 2 * RADIUS / (np.pi * E_STAR))
        before = k_t if normal[step - 1] > 0 else 0.0
        k_t = before + float(np.sum(np.diff(q) / (np.pi * np.sqrt(2 * a)))) if a.any() else 0.0
        k_t = k_t if normal[step] > 0 else 0.0
        found.append(k_t)
    return float(np.ptp(found[states]))


def until(value: float) -> dict[str, float]:
    """A ramp to a displacement."""
    return {"ramp": value, "until": 1.0, "steps": 6}


@pytest.mark.parametrize(
    ("amplitude", "shear", "phase"),
    [(0.006, 0.0005, 0.0), (0.006, 0.0, 90.0), (0.0041, 0.0, 0.0)],
    ids=["in phase", "out of phase", "hardly"],
)
def test_range_of_k_t_is_right_within_its_bar(amplitude: float, shear: float, phase: float) -> None:
    wave = {"wave": "sine", "period": 1.0, "cycles": 2, "steps_per_cycle": 24}
    begin = shear + 0.0005 * np.sin(np.radians(phase))
    loads: dict[str, dict[str, Any]] = {
        name: TOP | {"direction": along, "control": "displacement", "history": [ramp, wave | moves]}
        for name, along, ramp, moves in (
            ("press", "y", until(CLOSED), {"mean": CLOSED, "amplitude": amplitude}),
            ("shear", "x", until(begin), {"mean": shear, "amplitude": 0.0005, "phase": phase}),
        )
    }
    contacts = {"main": PAD["contacts"]["main"] | {"friction": 0.5}}
    del contacts["main"]["friction_from"]
    result = fretfe.run(
        parse_case(
            PAD
            | {
                "geometry": {"template": "cylinder", "parameters": SIZES},
                "contacts": contacts,
                "loads": loads,
                "output": {"fields": "none"},
            }
        )
    )
    (contact,), cycle = result.contacts, result.loads.cycle
    assert cycle is not None and (contact.normal_force[slice(*cycle)] == 0).any()
    exact = exact_range(contact.normal_force, contact.shear_force, slice(cycle[0], cycle[1] + 1))
    ranges = [station.k_range for station in contact.stations]
    bars = [station.k_range_spread for station in contact.stations]
    assert np.mean(ranges) == pytest.approx(exact, abs=float(np.mean(bars)))
    assert max(bars) < 0.35 * exact
