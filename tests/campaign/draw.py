# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random cases of one contact whose answers are known: what is drawn, and the case that it makes.

Lengths are drawn relative to the half-width a of the contact at the highest load, loads relative to
what makes it slide. All draws of a number depend on that number alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

POISSON = 0.3
MESHES = Path(__file__).parents[2] / "meshes"
# Height and half-width of the bodies over the half-width of the contact: next to half-planes.
BODY = 40.0
PROFILES = ("cylinder", "wedge", "flat_rounded")
TOP = {"type": "platen", "boundary": "upper_top", "control": "force"}


@dataclass(frozen=True)
class Draw:
    """One case of the campaign.

    Attributes:
        number: of the case; the seed of its draws.
        profile: name of a template.
        a: half-width of the contact at the highest normal load.
        shape: a/R of the cylinder, slope of the wedge, or b/a of the flat with rounded ends.
        young: of both bodies.
        friction: coefficient.
        level: largest |Q|/(f P) of the cycle.
        normal_range: amplitude over mean of the normal load.
        normal_phase: phase of the normal load against the shear force, degrees.
        tension: amplitude of the bulk tension over f p0, p0 the mean pressure.
        tension_phase: against the shear force, degrees.
        per_half_width: elements over the half-width, or over the rounded part in contact.
        degree: of the displacements; also the order of the geometry.
        steps: load steps in a cycle.
        quadrilaterals: recombined elements instead of triangles.
    """

    number: int
    profile: str
    a: float
    shape: float
    young: float
    friction: float
    level: float
    normal_range: float
    normal_phase: float
    tension: float
    tension_phase: float
    per_half_width: float
    degree: int
    steps: int
    quadrilaterals: bool


def draw(number: int) -> Draw:
    """The case of a number."""
    random = np.random.default_rng(7000 + number)
    profile = str(random.choice(PROFILES))
    shape = {
        "cylinder": 10 ** random.uniform(-2.6, -1.8),
        "wedge": math.radians(random.uniform(0.3, 1.5)),
        "flat_rounded": random.uniform(0.3, 0.9),
    }[profile]
    varies, pulled = random.random() < 0.3, random.random() < 0.4
    return Draw(
        number=number,
        profile=profile,
        a=10 ** random.uniform(-1.0, 1.0),
        shape=shape,
        young=10 ** random.uniform(4.0, 6.0),
        friction=float(random.uniform(0.2, 1.1)),
        level=float(random.uniform(0.05, 0.85)),
        normal_range=float(random.uniform(0.05, 0.6)) if varies else 0.0,
        normal_phase=float(random.choice([0.0, 45.0, 90.0, 180.0])),
        tension=float(random.uniform(0.1, 0.8)) if pulled else 0.0,
        tension_phase=float(random.choice([0.0, 45.0, 90.0, 180.0])),
        per_half_width=float(10 ** random.uniform(0.5, 1.9)),
        degree=int(random.choice([1, 2], p=[0.3, 0.7])),
        steps=int(random.choice([8, 12, 20, 40])),
        quadrilaterals=bool(random.random() < 0.25),
    )


def case_of(one: Draw, steps: int | None = None) -> dict[str, Any]:
    """The case that a draw makes, with another number of steps in a cycle if wanted."""
    peak = peak_load(one)
    mean = peak / (1 + one.normal_range)
    amplitude = one.level * one.friction * largest_shear(mean, one.normal_range, one.normal_phase)
    normal = wave(-mean, -one.normal_range * mean, one.normal_phase, steps or one.steps)
    shear = wave(0.0, amplitude, 0.0, steps or one.steps)
    loads: dict[str, Any] = {
        "press": {**TOP, "direction": "y", "history": normal},
        "shear": {**TOP, "direction": "x", "history": shear},
    }
    supports: dict[str, Any] = {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}
    if one.tension:
        amplitude = one.tension * one.friction * peak / (2 * one.a)
        history = wave(0.0, amplitude, one.tension_phase, steps or one.steps)
        side = {"type": "traction", "boundary": "lower_right", "direction": "normal"}
        loads["tension"] = {**side, "history": history}
        supports["base"]["fix"] = ["y"]
        supports["side"] = {"boundary": "lower_left", "fix": ["x"]}
    body = {"young": one.young, "poisson": POISSON}
    parameters = _parameters(one)
    return {
        "model": {"degree": one.degree},
        "geometry": {"template": one.profile, "parameters": parameters, "order": one.degree},
        "bodies": {"upper": body, "lower": body},
        "contacts": {
            "main": {
                "surface1": "upper_contact",
                "surface2": "lower_contact",
                "friction": one.friction,
                "friction_from": 1.0,
            }
        },
        "supports": supports,
        "loads": loads,
        "output": {"fields": "none"},
    }


def with_quadrilaterals(case: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The case on quadrilaterals: its template as a script of the user's in a folder."""
    geometry = case["geometry"]
    text = (MESHES / f"{geometry['template']}.geo").read_text(encoding="utf-8")
    script = folder / "quadrilaterals.geo"
    script.write_text(
        f"{text}\nMesh.RecombineAll = 1;\nMesh.RecombinationAlgorithm = 3;\n", encoding="utf-8"
    )
    order = {"order": geometry["order"], "parameters": geometry["parameters"]}
    return {**case, "geometry": {"file": str(script), **order}}


def contact_modulus_of(young: float, poisson: float) -> float:
    """E* of two equal bodies in plane strain."""
    return young / (2 * (1 - poisson**2))


def peak_load(one: Draw) -> float:
    """Normal load that gives the half-width a (theory guide, normal contact)."""
    a, e_star = one.a, contact_modulus_of(one.young, POISSON)
    if one.profile == "cylinder":
        return math.pi * e_star * a * one.shape / 4
    if one.profile == "wedge":
        return e_star * math.tan(one.shape) * a
    angle = math.asin(one.shape)
    return e_star * a**2 / (4 * _rounding(one)) * (math.pi - 2 * angle - math.sin(2 * angle))


def largest_shear(mean: float, normal_range: float, phase: float) -> float:
    """Amplitude of Q = P somewhere in a cycle of P about a mean, its phase in degrees."""
    angle = np.linspace(0.0, 2 * np.pi, 721)
    normal = mean * (1 + normal_range * np.sin(angle + math.radians(phase)))
    return float(np.min(normal / np.maximum(np.abs(np.sin(angle)), 1e-9)))


def element_size(one: Draw) -> float:
    """Element size at the contact edges."""
    rounded = 1 - one.shape if one.profile == "flat_rounded" else 1.0
    return one.a * rounded / one.per_half_width


def _rounding(one: Draw) -> float:
    """Radius of the rounded ends: small slopes at the edge of the contact."""
    return 100.0 * one.a


def _parameters(one: Draw) -> dict[str, float]:
    a, size = one.a, element_size(one)
    body = {
        "upper_width": BODY * a,
        "upper_height": BODY * a,
        "lower_width": BODY * a,
        "lower_height": BODY * a,
        "zone": 1.6 * a,
        "growth": 0.25,
    }
    if one.profile == "cylinder":
        radius = a / one.shape
        own = {"upper_radius": radius, "lower_radius": 0.0, "size": size}
    elif one.profile == "wedge":
        own = {"angle": math.degrees(one.shape), "size": size}
    else:
        own = {
            "flat_half_width": one.shape * a,
            "radius": _rounding(one),
            "edge_size": size,
            "flat_size": max(size, min(3 * size, 0.3 * one.shape * a)),
        }
    return {**body, **own}


def wave(
    mean: float, amplitude: float, phase: float, steps: int, cycles: int = 2
) -> list[dict[str, Any]]:
    """A ramp until time 1 to where a wave starts, then that wave."""
    start = mean + amplitude * math.sin(math.radians(phase))
    ramp: dict[str, Any] = {"ramp": start, "until": 1.0, "steps": 4}
    wave = {"wave": "sine", "mean": mean, "amplitude": amplitude, "phase": phase}
    return [ramp, {**wave, "period": 1.0, "cycles": cycles, "steps_per_cycle": steps}]
