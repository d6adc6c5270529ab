# SPDX-License-Identifier: LGPL-3.0-or-later
"""A sphere on a flat under cycles of Q; ν = 0, E* = E / 2, contact radius 1, elements of 1/12."""

from __future__ import annotations

from typing import Any

import numpy as np

Data = dict[str, Any]

RADIUS, YOUNG, FRICTION, SHARE = 50.0, 2e5, 0.5, 0.4
FORCE = 2 * YOUNG / (3 * RADIUS)  # a = 1
PEAK = 3 * FORCE / (2 * np.pi)
LIMIT = FRICTION * FORCE
HOLD = [{"hold": True, "until": 1.0}]


def tables(friction: float, *, shear: list[Data] = HOLD) -> Data:
    def platen(direction: str, history: list[Data]) -> Data:
        kind = {"type": "platen", "boundary": "upper_top", "control": "force"}
        return {**kind, "direction": direction, "history": history}

    turn = {"type": "tilt", "boundary": "upper_top", "axis": "y", "centre": [0, 0, 0]}
    return {
        "geometry": {"template": "sphere", "parameters": {"size": 1 / 12}},
        "bodies": {name: {"young": YOUNG, "poisson": 0.0} for name in ("upper", "lower")},
        "contacts": {
            "main": {
                "surface1": "upper_contact",
                "surface2": "lower_contact",
                "friction": friction,
            }
        },
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
        "loads": {
            "press": platen("y", [{"ramp": -FORCE, "until": 1.0, "steps": 1}]),
            "shear": platen("x", shear),
            "twist": {**turn, "control": "moment", "history": HOLD},
        },
    }


def cycles() -> list[Data]:
    """Q to the largest value in four steps, then two cycles of twelve."""
    load = SHARE * LIMIT
    turns = [{"ramp": (-1) ** k * load, "until": 2.0 + k, "steps": 6} for k in range(1, 5)]
    return [*HOLD, {"ramp": load, "until": 2.0, "steps": 4}, *turns]
