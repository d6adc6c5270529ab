# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases of a pad on a block as tables, to change in a test."""

from __future__ import annotations

from typing import Any

STEEL = {"young": 210e3, "poisson": 0.3}
TOP = {"type": "platen", "boundary": "upper_top", "control": "force"}
HOLD = {"hold": True, "until": 1.0}
BASE = {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}
# One side held, the other pulled: the block slides on its base.
SLIDING = {
    "base": {"boundary": "lower_bottom", "fix": ["y"]},
    "side": {"boundary": "lower_left", "fix": ["x"]},
}


def wave(amplitude: float, phase: float = 0.0, cycles: int = 2, steps: int = 20) -> dict[str, Any]:
    shape = {"wave": "sine", "amplitude": amplitude, "phase": phase, "period": 1.0}
    return {**shape, "cycles": cycles, "steps_per_cycle": steps}


def press(force: float = 600.0) -> dict[str, Any]:
    ramp = {"ramp": -force, "until": 1.0, "steps": 4}
    return {**TOP, "direction": "y", "history": [ramp]}


def shear(amplitude: float = 60.0, **options: Any) -> dict[str, Any]:
    return {**TOP, "direction": "x", "history": [HOLD, wave(amplitude, **options)]}


def pull(amplitude: float, boundary: str = "lower_right", **options: Any) -> dict[str, Any]:
    return {
        "type": "traction",
        "boundary": boundary,
        "direction": "normal",
        "history": [HOLD, wave(amplitude, **options)],
    }


def pad(**tables: Any) -> dict[str, Any]:
    """A cylinder of R = 50 on a block, P = 600, Q = 60 sin t; tables replace those of the case."""
    return {
        "geometry": {
            "template": "cylinder",
            "parameters": {
                "upper_radius": 50.0,
                "upper_width": 12.0,
                "lower_radius": 0.0,
                "lower_width": 12.0,
            },
        },
        "bodies": {"upper": STEEL, "lower": STEEL},
        "contacts": {
            "main": {
                "surface1": "upper_contact",
                "surface2": "lower_contact",
                "friction": 0.4,
                "friction_from": 1.0,
            }
        },
        "supports": BASE,
        "loads": {"press": press(), "shear": shear()},
        "output": {"fields": "none"},
        **tables,
    }
