# SPDX-License-Identifier: LGPL-3.0-or-later
"""The cases of the benchmarks: pads that are pressed, sheared and pulled, on the templates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fretfe.case import Case, parse_case

Segments = Sequence[Mapping[str, Any]]
# Steps in which a pad is pressed on, without friction.
PRESS_STEPS = 4
HOLD = {"hold": True, "until": 1.0}


@dataclass(frozen=True)
class Pad:
    """A pad on a block, or on a second pad.

    Attributes:
        template: "cylinder", "wedge" or "flat_rounded".
        parameters: of the template.
        friction: coefficient f.
        young: Young's moduli of the upper and the lower body.
        poisson: Poisson's ratio of both.
        thickness: of both.
    """

    template: str
    parameters: Mapping[str, float]
    friction: float
    young: tuple[float, float]
    poisson: float
    thickness: float = 1.0


def press(force: float, steps: int = PRESS_STEPS) -> dict[str, Any]:
    """A ramp until time 1."""
    return {"ramp": force, "until": 1.0, "steps": steps}


def ramp(value: float, steps: int) -> dict[str, Any]:
    """A ramp from time 1 to time 2."""
    return {"ramp": value, "until": 2.0, "steps": steps}


def wave(amplitude: float, *, mean: float = 0.0, phase: float = 0.0, steps: int) -> dict[str, Any]:
    """Three cycles of a sine from time 1 on; the phase in degrees, so many steps in a cycle."""
    shape = {"wave": "sine", "mean": mean, "amplitude": amplitude, "phase": phase, "period": 1.0}
    return {**shape, "cycles": 3, "steps_per_cycle": steps}


def pad_case(pad: Pad, *, normal: Segments, shear: Segments = (), tension: Segments = ()) -> Case:
    """A pad whose top is a platen; friction acts from time 1 on.

    Args:
        pad: bodies and friction.
        normal: history of the force that presses the pad on, for the whole thickness.
        shear: history of the force along x; none for a platen that is held.
        tension: history of the bulk tension in the block, which is held on its left side.
    """
    platen = {"type": "platen", "boundary": "upper_top", "control": "force"}
    loads: dict[str, Any] = {"press": {**platen, "direction": [0.0, -1.0], "history": normal}}
    if shear:
        loads["shear"] = {**platen, "direction": "x", "history": shear}
    if tension:
        pull = {"type": "traction", "boundary": "lower_right", "direction": "normal"}
        loads["tension"] = {**pull, "history": tension}
        # Half-planes carry half of Q away to either side. The block of height H would carry all of
        # it to the left: the same, and a uniform tension of Q/(2H), which this takes away.
        share = -1 / (2 * pad.thickness * pad.parameters["lower_height"])
        loads["balance"] = {**pull, "history": [_scaled(segment, share) for segment in shear]}
    return parse_case({**_tables(pad, pulled=bool(tension)), "loads": loads})


def rocking_case(pad: Pad, *, pressure: Segments, shear: Segments) -> Case:
    """A pad whose top is free to turn, loaded by uniform tractions there."""
    traction = {"type": "traction", "boundary": "upper_top"}
    loads = {
        "press": {**traction, "direction": [0.0, -1.0], "history": pressure},
        "shear": {**traction, "direction": "x", "history": shear},
    }
    return parse_case({**_tables(pad, pulled=False), "loads": loads})


def _scaled(segment: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """A segment with all its load values multiplied."""
    values = ("ramp", "mean", "amplitude")
    return {key: value * factor if key in values else value for key, value in segment.items()}


def _tables(pad: Pad, *, pulled: bool) -> dict[str, Any]:
    upper, lower = ({"young": young, "poisson": pad.poisson} for young in pad.young)
    supports = {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}
    if pulled:
        supports = {
            "base": {"boundary": "lower_bottom", "fix": ["y"]},
            "left": {"boundary": "lower_left", "fix": ["x"]},
        }
    return {
        "model": {"thickness": pad.thickness},
        "geometry": {"template": pad.template, "parameters": dict(pad.parameters)},
        "bodies": {"upper": upper, "lower": lower},
        "contacts": {
            "main": {
                "surface1": "upper_contact",
                "surface2": "lower_contact",
                "friction": pad.friction,
                "friction_from": 1.0,
            }
        },
        "supports": supports,
        "output": {"fields": "none"},
    }
