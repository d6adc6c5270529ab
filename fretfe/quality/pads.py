# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pads of the benchmarks: pressed, sheared and pulled on the templates, and their closed forms.

The closed forms are written out here, independent of `fretfe.analytic`: elastically similar
half-planes, all forces per unit thickness. Hertz, wedge: Johnson, Contact Mechanics, 1985,
chapters 4 and 5. Flat with rounded ends: Ciavarella, Hills and Monno, Proc. IMechE C 212, 1998.
Stuck contact under shear force and bulk tension: Hills and Nowell, Mechanics of Fretting Fatigue,
1994.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fretfe.case import Case, parse_case
from fretfe.idealise.bodies import side_tension

Segments = Sequence[Mapping[str, Any]]
# Steps in which a pad is pressed on, without friction.
PRESS_STEPS = 4
HOLD = {"hold": True, "until": 1.0}
FACES = {"surface1": "upper_contact", "surface2": "lower_contact"}


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


def hertz_parameters(radius: float, half_width: float) -> dict[str, float]:
    """A cylindrical pad on a block, in half-widths a: 40 wide, 20 high on one 120 wide, 60 high.

    Elements of 0.02 a. Smaller bodies change a by 0.2 %, the K_T of a bulk tension by 2 %.
    """
    sizes = {"upper_width": 20.0, "upper_height": 20.0, "lower_width": 60.0, "lower_height": 60.0}
    sizes |= {"zone": 1.15, "size": 0.02}
    return {
        "upper_radius": radius,
        "lower_radius": 0.0,
        "growth": 0.2,
        **{name: value * half_width for name, value in sizes.items()},
    }


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
        # Half-planes carry half of Q away to either side. The block would carry all of it to the
        # left: the same, and a tension, which this takes away.
        sizes = pad.parameters["lower_width"], pad.parameters["lower_height"]
        share = -side_tension(*sizes, sliding=True)[0] / pad.thickness
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
        "contacts": {"main": {**FACES, "friction": pad.friction, "friction_from": 1.0}},
        "supports": supports,
        "output": {"fields": "none"},
    }


def hertz_load(half_width: float, radius: float, e_star: float) -> float:
    """P = pi E* a^2/(4R)."""
    return math.pi * e_star * half_width**2 / (4 * radius)


def hertz_k_n(half_width: float, radius: float, e_star: float) -> float:
    """K_N = E*/(2R) sqrt(2a), from p = E*/(2R) sqrt(a^2 - x^2)."""
    return e_star / (2 * radius) * math.sqrt(2 * half_width)


def wedge_load(half_width: float, slope: float, e_star: float) -> float:
    """P = E* alpha a."""
    return e_star * slope * half_width


def wedge_k_n(half_width: float, slope: float, e_star: float) -> float:
    """K_N = (E* alpha/pi) sqrt(2/a), from p = (E* alpha/pi) arcosh(a/|x|)."""
    return e_star * slope / math.pi * math.sqrt(2 / half_width)


def flat_rounded_load(half_width: float, flat: float, radius: float, e_star: float) -> float:
    """P = E* a^2/(4R) (pi - 2 phi - sin 2 phi), sin phi = b/a."""
    phi = math.asin(flat / half_width)
    return e_star * half_width**2 / (4 * radius) * (math.pi - 2 * phi - math.sin(2 * phi))


def flat_rounded_k_n(half_width: float, flat: float, radius: float, e_star: float) -> float:
    """K_N = E*/(2R) sqrt(2a) (1 - 2 phi/pi), sin phi = b/a."""
    phi = math.asin(flat / half_width)
    return hertz_k_n(half_width, radius, e_star) * (1 - 2 * phi / math.pi)


def shear_part(shear_force: float, half_width: float) -> float:
    """K_T of a shear force, Q/(pi sqrt(2a)): the stuck shear is Q/(pi sqrt(a^2 - x^2))."""
    return shear_force / (math.pi * math.sqrt(2 * half_width))


def tension_part(bulk_tension: float, half_width: float) -> float:
    """K_T of a tension, sigma0/4 sqrt(a/2): the stuck shear is -sigma0 x/(4 sqrt(a^2 - x^2))."""
    return bulk_tension / 4 * math.sqrt(half_width / 2)


def k_t_ranges(
    shear_force: float, bulk_tension: float, lag: float, half_width: float
) -> tuple[float, float]:
    """Range of K_T at the left and at the right edge of Qa cos t and sigma_a cos(t - lag).

    K_T = +-A cos t + B cos(t - lag), plus at the left: range 2 sqrt(A^2 + B^2 +- 2AB cos lag).
    """
    a, b = shear_part(shear_force, half_width), tension_part(bulk_tension, half_width)
    product = 2 * a * b * math.cos(lag)
    left, right = a**2 + b**2 + product, a**2 + b**2 - product
    # In phase the two parts may cancel to round-off.
    return 2 * math.sqrt(max(left, 0.0)), 2 * math.sqrt(max(right, 0.0))
