# SPDX-License-Identifier: LGPL-3.0-or-later
"""Benchmark B1: cases of fretting cycles on a mesh as `b1_meshes` writes it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

# Of order 1, as a case file beside its mesh pad.msh: 19 steps.
PAD_ON_BLOCK = """
title = "Pad on a block"
[model]
degree = 1
[geometry]
file = "pad.msh"
[bodies.pad]
young = 210e3
poisson = 0.3
[bodies.substrate]
young = 210e3
poisson = 0.3
[contacts.main]
surface1 = "pad_contact"
surface2 = "substrate_contact"
friction = 0.4
[supports.base]
boundary = "substrate_bottom"
fix = ["x", "y"]
[loads.press]
type = "platen"
boundary = "pad_top"
direction = "y"
control = "displacement"
history = [{ ramp = -0.042, until = 1.0, steps = 3 }]
[loads.shear]
type = "platen"
boundary = "pad_top"
direction = "x"
control = "displacement"
history = [
  { hold = true, until = 1.0 },
  { wave = "sine", mean = 0.0, amplitude = 0.01, period = 1.0, cycles = 2, steps_per_cycle = 8 },
]
"""
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
