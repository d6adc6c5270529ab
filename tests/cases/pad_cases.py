# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases of a pad on a block that half-planes can stand for: as text, and as tables to change."""

from __future__ import annotations

import copy
import itertools
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import tomli_w

# Hertz, R = 50, P = 600, steady shear of 60 = f P/4 from the first reversal on: 20 steps.
HERTZ = """
title = "Cylindrical pad on a flat block"
[geometry]
template = "cylinder"
parameters = { upper_radius = 50, upper_width = 12, lower_radius = 0, lower_width = 12 }
[bodies]
upper = { young = 210e3, poisson = 0.3 }
lower = { young = 210e3, poisson = 0.3 }
[contacts.main]
surface1 = "upper_contact"
surface2 = "lower_contact"
friction = 0.4
friction_from = 1.0
[supports]
base = { boundary = "lower_bottom", fix = ["x", "y"] }
[loads.press]
type = "platen"
boundary = "upper_top"
direction = "y"
control = "force"
history = [{ ramp = -600, until = 1, steps = 4 }]
[loads.shear]
type = "platen"
boundary = "upper_top"
direction = "x"
control = "force"
history = [
  { hold = true, until = 1 },
  { wave = "sine", amplitude = 60, period = 1, cycles = 2, steps_per_cycle = 8 },
]
"""

PAD = {name: table for name, table in tomllib.loads(HERTZ).items() if name != "title"}
STEEL = PAD["bodies"]["upper"]
# Of rough surfaces, as a case has it.
ROUGH = {"pressure": [0.0, 60.0, 600.0], "approach": [0.0, 6e-4, 2e-3], "tangential": 3e5}
TOP = {"type": "platen", "boundary": "upper_top", "control": "force"}
HOLD = {"hold": True, "until": 1.0}
BASE = PAD["supports"]
# One side held, the other pulled: the block slides on its base.
SLIDING = {
    "base": {"boundary": "lower_bottom", "fix": ["y"]},
    "side": {"boundary": "lower_left", "fix": ["x"]},
}


def as_field(
    load: dict[str, Any], folder: Path, size: float, warm: Callable[..., float], dimension: int = 2
) -> dict[str, Any]:
    """A temperature load as the only step of another run, at the corners of a square or cube.

    Temperatures `warm(x, y[, z])` are linear.
    """
    corners = [*itertools.product((-size, size), repeat=dimension)]
    rows = [",".join(map(repr, (*corner, warm(*corner)))) for corner in corners]
    path = folder / "heat.csv"
    path.write_text("\n".join([",".join([*"xyz"[:dimension], "T"]), *rows]) + "\n")
    kept: dict[str, Any] = {key: load[key] for key in ("history", "bodies") if key in load}
    return {"type": "temperature_field", "file": str(path), **kept}


def wave(amplitude: float, phase: float = 0.0, cycles: int = 2, steps: int = 20) -> dict[str, Any]:
    shape = {"wave": "sine", "amplitude": amplitude, "phase": phase, "period": 1.0}
    return {**shape, "cycles": cycles, "steps_per_cycle": steps}


def ramps(values: Sequence[float], steps: int, sign: float = 1.0) -> list[dict[str, Any]]:
    """Straight ramps from 0 through values at t = 1, 2 ..., times a sign."""
    return [
        {"ramp": sign * value, "until": float(until), "steps": steps}
        for until, value in enumerate(values, start=1)
    ]


def press(force: float = 600.0, steps: int = 4) -> dict[str, Any]:
    ramp = {"ramp": -force, "until": 1.0, "steps": steps}
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


def pad(**changed: Any) -> dict[str, Any]:
    """A cylinder of R = 50 on a block, P = 600, Q = 60 sin t; tables may be changed."""
    tables = {**PAD, "loads": {"press": press(), "shear": shear()}, "output": {"fields": "none"}}
    return copy.deepcopy({**tables, **changed})


def cylinder(**parameters: float) -> dict[str, Any]:
    """The geometry of `pad` with other element sizes."""
    own = PAD["geometry"]
    return {**own, "parameters": {**own["parameters"], **parameters}}


def pad_text(**changed: Any) -> str:
    """`pad` as a case file."""
    return tomli_w.dumps(pad(**changed))
