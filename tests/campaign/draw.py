# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random cases of one contact whose answers are known: what is drawn, and the case that it makes.

Lengths are drawn relative to the half-width a of the contact at the highest load, loads relative to
what makes it slide. All draws of a number depend on that number alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

POISSON = 0.3
MESHES = Path(__file__).parents[2] / "meshes"
# Height and half-width of the bodies over the half-width of the contact: next to half-planes.
BODY = 40.0
PROFILES = ("cylinder", "wedge", "flat_rounded")
# Kinds of histories: waves; or P down to a fiftieth of its maximum within single steps, missions
# from CSV files, a cycle in the middle, and few steps in a cycle with all loads out of phase.
WAVES, SWEPT, MISSION, MIDDLE, PHASES = "waves", "swept", "mission", "middle", "phases"
MOVING = (SWEPT, MISSION, MIDDLE, PHASES)
# Repetitions of the points of a cycle.
SWEPT_CYCLES, MISSION_CYCLES = 3, 2
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
        kind: of the history.
        points: P over its maximum and Q/(f P) at the points of a cycle, `steps` of them and the
            first one once more, with straight lines between; none for waves.
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
    kind: str = WAVES
    points: tuple[tuple[float, float], ...] = ()


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


def draw_moving(number: int) -> Draw:
    """The case of a number, with a history of each other kind in turn."""
    random = np.random.default_rng(8000 + number)
    kind = MOVING[number % len(MOVING)]
    size = 10 ** random.uniform(1.0, 1.9)
    one = replace(draw(number), kind=kind, per_half_width=float(size))
    if kind == PHASES:
        return replace(
            one,
            steps=int(random.integers(7, 13)),
            normal_range=float(random.uniform(0.1, 0.6)),
            normal_phase=float(random.uniform(0.0, 360.0)),
            tension=float(random.uniform(0.1, 0.8)),
            tension_phase=float(random.uniform(0.0, 360.0)),
        )
    if kind == MIDDLE:
        return one
    steps = int(random.integers(2, 9) if kind == SWEPT else random.integers(15, 50))
    normal, shear = random.uniform(0.02, 1.0, steps), random.uniform(-1.0, 1.0, steps)
    if kind == SWEPT:
        normal[steps // 2] = 10 ** random.uniform(-1.7, -0.7)
    elif random.random() < 0.5:
        normal[:] = 1.0
    # A cycle begins and ends at the highest load, where the mesh is as fine as was drawn.
    normal[0], shear[0] = 1.0, 0.0
    points = [(float(p), float(one.level * q)) for p, q in zip(normal, shear, strict=True)]
    return replace(one, steps=steps, points=(*points, points[0]), normal_range=0.0, tension=0.0)


def case_of(one: Draw, steps: int | None = None) -> dict[str, Any]:
    """The case that a draw makes, with another number of steps in a cycle if wanted."""
    peak = peak_load(one)
    normal, shear = _histories(one, steps or one.steps)
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
        **_cycle(one),
    }


def _histories(one: Draw, steps: int) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Of P and Q, with so many steps in a cycle."""
    if one.points:
        return _through_points(one, steps)
    mean = peak_load(one) / (1 + one.normal_range)
    amplitude = one.level * one.friction * largest_shear(mean, one.normal_range, one.normal_phase)
    normal = wave(-mean, -one.normal_range * mean, one.normal_phase, steps)
    shear = wave(0.0, amplitude, 0.0, steps)
    if one.kind == MIDDLE:
        # Two smaller cycles about the same means follow.
        for history, size in ((normal, 0.5), (shear, 0.6)):
            final = {**history[1], "amplitude": size * history[1]["amplitude"]}
            start = final["mean"] + final["amplitude"] * math.sin(math.radians(final["phase"]))
            history += [{"ramp": start, "until": 4.0, "steps": 2}, final]
    return normal, shear


def _through_points(one: Draw, steps: int) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """A ramp until time 1, then straight lines between points, again and again."""
    cycles = SWEPT_CYCLES if one.kind == SWEPT else MISSION_CYCLES
    parts = max(steps // one.steps, 1)
    times = np.arange(parts * one.steps * cycles + 1) / (parts * one.steps)
    values = _points(one)
    at = np.linspace(0.0, 1.0, one.steps + 1)
    histories = []
    for each in values.T:
        along = np.interp(times % 1.0, at, each).tolist()
        ramp = {"ramp": along[0], "until": 1.0, "steps": 4}
        histories.append([ramp, {"times": (1 + times[1:]).tolist(), "values": along[1:]}])
    return histories[0], histories[1]


def _points(one: Draw) -> np.ndarray:
    """(n + 1, 2) vertical and horizontal force at the points of a cycle."""
    normal, share = np.transpose(one.points) * np.array([[peak_load(one)], [one.friction]])
    return np.column_stack([-normal, share * normal])


def _cycle(one: Draw) -> dict[str, Any]:
    if one.kind == MIDDLE:
        return {"cycle": {"start": 2.0, "end": 3.0}}
    if not one.points:
        return {}
    end = 1.0 + (SWEPT_CYCLES if one.kind == SWEPT else MISSION_CYCLES)
    return {"cycle": {"start": end - 1, "end": end}}


def with_mission(case: dict[str, Any], one: Draw, folder: Path) -> dict[str, Any]:
    """The case with the points of its cycle from a CSV file in a folder, which is repeated."""
    file = folder / "mission.csv"
    rows = np.column_stack([1 + np.linspace(0.0, 1.0, one.steps + 1), _points(one)])
    np.savetxt(file, rows, fmt="%.17g", delimiter=",", header="time,normal,shear", comments="")
    loads = dict(case["loads"])
    for name, column in (("press", "normal"), ("shear", "shear")):
        ramp = loads[name]["history"][0]
        csv = {"csv": str(file), "time": "time", "value": column, "repeat": MISSION_CYCLES}
        loads[name] = {**loads[name], "history": [ramp, csv]}
    return {key: value for key, value in case.items() if key != "cycle"} | {"loads": loads}


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


def edge_slope(one: Draw) -> float:
    """Slope of the profile at the edge of the contact at the highest load."""
    return (1 - one.shape) * one.a / _rounding(one) if one.profile == "flat_rounded" else one.shape


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
