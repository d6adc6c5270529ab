# SPDX-License-Identifier: LGPL-3.0-or-later
"""Benchmark B1: the case of one fretting cycle on a mesh as `meshes_b1` writes it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

YOUNG, POISSON, FRICTION = 210e3, 0.3, 0.4


def b1_case(mesh: Path, degree: int, friction_from: float, multipliers: str) -> dict[str, Any]:
    steel = {"young": YOUNG, "poisson": POISSON}
    platen = {"type": "platen", "boundary": "pad_top", "control": "displacement"}
    shear = [
        {"hold": True, "until": 5.0},
        {"ramp": 0.012, "until": 15.0, "steps": 10},
        {"ramp": -0.012, "until": 35.0, "steps": 20},
        {"ramp": 0.012, "until": 55.0, "steps": 20},
    ]
    return {
        "model": {"degree": degree},
        "geometry": {"file": str(mesh)},
        "bodies": {"pad": steel, "substrate": steel},
        "contacts": {
            "pad": {
                "surface1": "pad_contact",
                "surface2": "substrate_contact",
                "friction": FRICTION,
                "friction_from": friction_from,
                "multipliers": multipliers,
            }
        },
        "supports": {"base": {"boundary": "substrate_bottom", "fix": ["x", "y"]}},
        "loads": {
            "press": {
                **platen,
                "direction": "y",
                "history": [{"ramp": -0.042, "until": 5.0, "steps": 5}],
            },
            "shear": {**platen, "direction": "x", "history": shear},
        },
        "cycle": {"start": 15.0, "end": 55.0},
        "output": {"fields": "none"},
    }
