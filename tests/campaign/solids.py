# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random contacts of solids whose answers are known: what is drawn, and the case that it makes.

Lengths are drawn relative to the half-width a of the contact at the highest load, which of an
ellipse is the shorter half axis, loads relative to what makes it slide. All draws of a number
depend on that number alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from campaign.draw import contact_modulus_of, largest_shear, wave
from scipy.special import ellipe, ellipkm1

# Height and half-width of the bodies over the half-width of the contact; cylinders are cheaper in
# smaller bodies, and long enough for plane strain in the middle.
SPHERE_BODY, CYLINDER_BODY, CYLINDER_LENGTH = 20.0, 16.0, 14.0
STATIONS = 16
PROFILES = ("sphere", "cylinder", "ellipsoid", "sphere", "cylinder")
TOP = {"type": "platen", "boundary": "upper_top", "control": "force"}


@dataclass(frozen=True)
class SolidDraw:
    """One case of the campaign.

    Attributes:
        number: of the case; the seed of its draws.
        profile: "sphere", "ellipsoid" or "cylinder".
        a: half-width of the contact at the highest normal load.
        slope: a over the radius, of ellipsoids the smaller one.
        ratio: of the half axes, the longer one in z; 1 but for ellipsoids.
        young: of both bodies.
        poisson: of both bodies.
        friction: coefficient.
        level: largest |Q|/(f P) of the cycle.
        angle: of Q from x towards z, degrees; 0 for cylinders.
        normal_range: amplitude over mean of the normal load.
        normal_phase: phase of the normal load against the shear force, degrees.
        per_half_width: elements over the half-width.
        steps: load steps in a cycle.
    """

    number: int
    profile: str
    a: float
    slope: float
    ratio: float
    young: float
    poisson: float
    friction: float
    level: float
    angle: float
    normal_range: float
    normal_phase: float
    per_half_width: float
    steps: int


def draw_solid(number: int) -> SolidDraw:
    """The case of a number."""
    random = np.random.default_rng(9000 + number)
    profile = PROFILES[number % len(PROFILES)]
    # What an ellipse of another size does to its stations is no closed form.
    varies = random.random() < 0.4 and profile != "ellipsoid"
    return SolidDraw(
        number=number,
        profile=profile,
        a=10 ** random.uniform(-1.0, 1.0),
        slope=10 ** random.uniform(-2.4, -1.7),
        ratio=float(random.uniform(1.2, 2.0)) if profile == "ellipsoid" else 1.0,
        young=10 ** random.uniform(4.0, 6.0),
        poisson=float(random.choice([0.0, random.uniform(0.1, 0.4)])),
        friction=float(random.uniform(0.2, 1.0)),
        level=float(random.uniform(0.1, 0.8)),
        angle=float(random.uniform(0.0, 90.0)) if profile != "cylinder" else 0.0,
        normal_range=float(random.uniform(0.05, 0.4)) if varies else 0.0,
        normal_phase=float(random.choice([0.0, 45.0, 90.0, 180.0])),
        per_half_width=float(10 ** random.uniform(0.6, 1.15)),
        steps=int(random.choice([8, 12, 16])),
    )


def draw_moving_solid(number: int) -> SolidDraw:
    """The case of a number in which P falls to a small part of its peak within one or two steps."""
    random = np.random.default_rng(7000 + number)
    return replace(
        draw_solid(number),
        profile=("sphere", "cylinder")[number % 2],
        ratio=1.0,
        angle=float(random.uniform(0.0, 90.0)) if number % 2 == 0 else 0.0,
        normal_range=float(random.uniform(0.3, 0.85)),
        normal_phase=float(random.choice([0.0, 45.0, 90.0, 180.0])),
        per_half_width=float(10 ** random.uniform(0.75, 1.0)),
        steps=int(random.choice([4, 6, 8])),
    )


def solid_case(one: SolidDraw) -> dict[str, Any]:
    """The case that a draw makes."""
    mean = peak_force(one) / (1 + one.normal_range)
    amplitude = shear_force(one)
    angle = math.radians(one.angle)
    # Solids take longer to a steady state where the contact area varies.
    turns = (one.steps, 4 if one.normal_range else 2)
    press = wave(-mean, -one.normal_range * mean, one.normal_phase, *turns)
    loads: dict[str, Any] = {"press": {**TOP, "direction": "y", "history": press}}
    for direction, share in (("x", math.cos(angle)), ("z", math.sin(angle))):
        if share:
            history = wave(0.0, share * amplitude, 0.0, *turns)
            loads[f"shear_{direction}"] = {**TOP, "direction": direction, "history": history}
    body = {"young": one.young, "poisson": one.poisson}
    surfaces = {"surface1": "upper_contact", "surface2": "lower_contact"}
    template = "cylinder_finite" if one.profile == "cylinder" else "sphere"
    return {
        "geometry": {"template": template, "parameters": _parameters(one)},
        "bodies": {"upper": body, "lower": body},
        "contacts": {"main": {**surfaces, "friction": one.friction, "friction_from": 1.0}},
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
        "loads": loads,
        "edges": {"stations": STATIONS},
        "output": {"fields": "none"},
    }


def peak_pressure(one: SolidDraw) -> float:
    """Largest pressure at the highest load (Johnson 1985, sections 4.1 and 4.2)."""
    modulus = contact_modulus_of(one.young, one.poisson)
    if one.profile == "cylinder":
        return modulus * one.slope / 2
    if one.ratio == 1:
        return 2 * modulus * one.slope / math.pi
    first, second, factor = _integrals(one.ratio)
    square = one.ratio**-2
    return float(modulus * one.slope / 2 / (factor * (second / square - first)))


def long_radius(one: SolidDraw) -> float:
    """Radius of the upper face in z over a, for an ellipse of the wanted shape."""
    if one.ratio == 1:
        return 1 / one.slope
    first, second, factor = _integrals(one.ratio)
    modulus = contact_modulus_of(one.young, one.poisson)
    return float(modulus / (2 * peak_pressure(one) * factor * (first - second)))


def _integrals(ratio: float) -> tuple[float, float, float]:
    """Complete elliptic integrals K and E of the ellipse, and what both curvatures share."""
    square = ratio**-2
    first, second = float(ellipkm1(square)), float(ellipe(1 - square))
    return first, second, 1 / ((1 - square) * ratio**2)


def peak_force(one: SolidDraw) -> float:
    """Normal load that gives the half-width a; in the middle of a cylinder about this one."""
    if one.profile == "cylinder":
        return math.pi * one.a * peak_pressure(one) / 2 * CYLINDER_LENGTH * one.a
    return 2 * math.pi * one.ratio * one.a**2 * peak_pressure(one) / 3


def shear_force(one: SolidDraw) -> float:
    """Amplitude of Q for which |Q|/(f P) is at most `level` in the cycle."""
    mean = peak_force(one) / (1 + one.normal_range)
    return one.level * one.friction * largest_shear(mean, one.normal_range, one.normal_phase)


def _parameters(one: SolidDraw) -> dict[str, float]:
    a, size = one.a, one.a / one.per_half_width
    wide = (CYLINDER_BODY if one.profile == "cylinder" else SPHERE_BODY) * a
    body = {
        "upper_width": wide,
        "upper_height": wide,
        "lower_width": wide,
        "lower_height": wide,
        "size": size,
        "growth": 0.45,
    }
    if one.profile == "cylinder":
        own = {
            "radius": a / one.slope,
            "length": CYLINDER_LENGTH * a,
            "overhang": 3 * a,
            "zone": 1.6 * a,
            "end_size": 0.5 * a,
            "length_size": 1.5 * a,
        }
    else:
        # Bodies may not be wider than six tenths of the smaller radius of the face.
        own = {
            "radius_x": a / one.slope,
            "radius_z": long_radius(one) * a,
            "contact_x": a,
            "contact_z": one.ratio * a,
        }
    return {**body, **own}
