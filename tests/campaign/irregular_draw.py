# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random irregular histories of one contact: what is drawn, its loads, and the case it makes.

P, Q and the bulk tension run independently in straight lines from point to point, with reversals
and inner loops at any place, once after the first loading or as a cycle that repeats. Some of those
that are passed once end without load. Bodies are so large that they are half-planes to a
ten-thousandth. All draws of a number depend on it and a seed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from campaign.draw import PROFILES, TOP

from fretfe._typing import Array
from fretfe.analytic.profiles import FlatRounded, Hertz, Profile, Wedge

# Loads that vary; P is constant without "normal".
VARYING = ("shear", "normal", "bulk", "all")
BODY, POISSON, PRESS_STEPS = 200.0, 0.3, 4
# Slope of the profile at a = 1, or more than that: inclined surfaces make K_T by pressing alone.
SLOPE = 1e-3
# One of so many that are passed once ends without load.
ENDS = 5
# Part of the histories whose meshes refine themselves, and the most that these have.
REFINED, UNKNOWNS = 0.4, 15_000


@dataclass(frozen=True)
class IrregularDraw:
    """One history of one contact, a = 1 at P = 1 times the largest load.

    Attributes:
        number: of the case; the seed of its draws.
        profile: name of a template.
        flat: b/a of the flat with rounded ends.
        young: of both bodies.
        friction: coefficient.
        varying: which loads vary.
        repeats: whether the points are a cycle, which is evaluated; else they are passed once.
        points: (n, 3) P over its maximum, Q/(f P) and sigma0/(f p0), p0 the mean pressure.
        steps: (n,) on the way to each point.
        per_half_width: elements over the half-width, or over the rounded part in contact.
        degree: of the displacements; also the order of the geometry.
        growth: of the elements outside of `zone`.
        zone: part of the surface with the smallest elements, over a.
        tolerance: of a mesh that refines itself in place of one of such elements.
    """

    number: int
    profile: str
    flat: float
    young: float
    friction: float
    varying: str
    repeats: bool
    points: tuple[tuple[float, float, float], ...]
    steps: tuple[int, ...]
    per_half_width: float
    degree: int
    growth: float
    zone: float
    tolerance: float | None

    @property
    def e_star(self) -> float:
        """E* in plane strain."""
        return self.young / (2 * (1 - POISSON**2))

    @property
    def form(self) -> Profile:
        """The profile."""
        if self.profile == "cylinder":
            return Hertz(1 / SLOPE, self.e_star)
        if self.profile == "wedge":
            return Wedge(SLOPE, self.e_star)
        return FlatRounded(self.flat, 1 / SLOPE, self.e_star)

    @property
    def peak(self) -> float:
        """Normal load at which a = 1."""
        return float(self.form.load(1.0))


def draw_irregular(number: int, seed: int) -> IrregularDraw:
    """The history of a number."""
    random = np.random.default_rng([seed, number])
    varying, count = VARYING[number % len(VARYING)], int(random.integers(3, 9))
    shear = _turns(random, count) * random.uniform(0.1, 0.8)
    normal, tension = np.ones(count), np.zeros(count)
    if varying in ("normal", "all"):
        normal = 1 - random.uniform(0.1, 0.7) * random.random(count)
        normal[int(random.integers(count))] = 1.0
    if varying in ("bulk", "all"):
        tension = _turns(random, count) * random.uniform(0.05, 0.5)
        shear *= 0.7
    whole, repeats = random.random() < 0.5, bool(number // len(VARYING) % 2)
    if not repeats and number % ENDS == ENDS - 2:
        normal, shear, tension = (np.append(each, 0.0) for each in (normal, shear, tension))
    return IrregularDraw(
        number=number,
        profile=str(random.choice(PROFILES)),
        flat=float(random.uniform(0.3, 0.9)),
        young=10 ** random.uniform(4.0, 6.0),
        friction=float(random.uniform(0.2, 1.1)),
        varying=varying,
        repeats=repeats,
        points=tuple(map(tuple, np.column_stack([normal, shear, tension]).tolist())),
        steps=tuple(int(each) for each in random.integers(1, 3 if whole else 9, len(normal))),
        per_half_width=float(10 ** random.uniform(0.65, 1.8)),
        degree=int(random.choice([1, 2], p=[0.4, 0.6])),
        growth=float(random.uniform(0.2, 0.45)),
        zone=float(random.uniform(1.15, 1.6)),
        tolerance=10 ** random.uniform(-2.2, -1.0) if random.random() < REFINED else None,
    )


def _turns(random: np.random.Generator, count: int) -> Array:
    """(count,) points between -1 and 1 of which the farthest are 1 or -1 away."""
    turns = random.uniform(-1.0, 1.0, count)
    return np.asarray(turns / np.abs(turns).max())


def loads_of(one: IrregularDraw, parts: int = 1, cycles: int = 2) -> tuple[Array, Array, int]:
    """(n,) times and (n, 3) P, Q and sigma0 from the pressed contact on, and steps of a cycle.

    Args:
        one: the draw.
        parts: into which each step is divided.
        cycles: how often the points are passed if they are a cycle.
    """
    p, share, tension = np.transpose(one.points)
    p, mean = p * one.peak, one.peak / 2
    corners = np.column_stack([p, one.friction * p * share, one.friction * mean * tension])
    rounds = cycles if one.repeats else 1
    path, times = [np.array([p[0], 0.0, 0.0])], [1.0]
    for corner, steps in zip(np.tile(corners, (rounds, 1)), one.steps * rounds, strict=True):
        along = np.linspace(0.0, 1.0, steps * parts + 1)[1:, None]
        path += list(path[-1] + along * (corner - path[-1]))
        times += list(times[-1] + along[:, 0])
    return np.array(times), np.array(path), parts * sum(one.steps) if one.repeats else 0


def irregular_case(one: IrregularDraw) -> dict[str, Any]:
    """The case for finite elements."""
    times, loads, steps = loads_of(one)

    def history(column: int, sign: float) -> list[dict[str, Any]]:
        values = (sign * loads[:, column]).tolist()
        ramp = {"ramp": values[0], "until": 1.0, "steps": PRESS_STEPS}
        return [ramp, {"times": times[1:].tolist(), "values": values[1:]}]

    supports: dict[str, Any] = {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}
    drivers: dict[str, Any] = {
        "press": {**TOP, "direction": "y", "history": history(0, -1.0)},
        "shear": {**TOP, "direction": "x", "history": history(1, 1.0)},
    }
    if np.any(loads[:, 2]):
        side = {"type": "traction", "boundary": "lower_right", "direction": "normal"}
        drivers["tension"] = {**side, "history": history(2, 1.0)}
        supports["base"]["fix"] = ["y"]
        supports["side"] = {"boundary": "lower_left", "fix": ["x"]}
    body = {"young": one.young, "poisson": POISSON}
    contact = {"surface1": "upper_contact", "surface2": "lower_contact"}
    case: dict[str, Any] = {
        "model": {"degree": one.degree},
        "geometry": {
            "template": one.profile,
            "parameters": _parameters(one),
            "order": one.degree,
        },
        "bodies": {"upper": body, "lower": body},
        "contacts": {"main": {**contact, "friction": one.friction, "friction_from": 1.0}},
        "supports": supports,
        "loads": drivers,
        "output": {"fields": "none"},
    }
    if one.tolerance:
        case["edges"] = {"tolerance": one.tolerance, "unknowns": UNKNOWNS}
    if steps:
        case["cycle"] = {"start": float(times[-1 - steps]), "end": float(times[-1])}
    return case


def _parameters(one: IrregularDraw) -> dict[str, float]:
    rounded = 1 - one.flat if one.profile == "flat_rounded" else 1.0
    size = rounded / one.per_half_width
    names = ("upper_width", "upper_height", "lower_width", "lower_height")
    body = {**dict.fromkeys(names, BODY), "zone": one.zone}
    even = {"growth": one.growth, "size": size}
    if one.profile == "cylinder":
        body |= {"upper_radius": 1 / SLOPE, "lower_radius": 0.0}
    elif one.profile == "wedge":
        body |= {"angle": math.degrees(math.atan(SLOPE))}
    else:
        body |= {"flat_half_width": one.flat, "radius": 1 / SLOPE}
        flat_size = max(size, min(3 * size, 0.3 * one.flat))
        even = {"growth": one.growth, "edge_size": size, "flat_size": flat_size}
    return body if one.tolerance else body | even
