# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solids under a cycle of shear force or twist, which only finite elements solve.

Half-spaces pressed together on a circle or an ellipse, against closed forms, and a plane contact
extruded along z, against the same finite elements in the plane.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ellipe, ellipkm1

from fretfe._typing import Array
from fretfe.case import Case, parse_case
from fretfe.evaluate.contacts import Station
from fretfe.quality import measures
from fretfe.quality.comparison import Benchmark, Measure, Quantity
from fretfe.quality.pads import FACES, HOLD, press, ramp
from fretfe.results.model import Result

YOUNG = 2e5
FRICTION = 0.5
RADIUS = 50.0
# A contact of radius 1 on a sphere: two bodies, no Poisson's ratio, E* = E/2.
SPHERE_FORCE = 2 * YOUNG / (3 * RADIUS)
SPHERE_PEAK = 3 * SPHERE_FORCE / (2 * math.pi)
# Q over f P, elements over the radius of the contact, and steps from one extreme to the other.
SPHERE_SHARE = 0.5
SPHERE_ELEMENTS = 8
SPHERE_STEPS = 6
# M over that at which all of the contact slips, 3 pi f P a/16.
TWIST_SHARE = 0.3
# Half axes of the ellipse along x and z, Poisson's ratio, Q over f P and its angle from x.
SHORT = 1.0
LONG = 1.5
ELLIPSE_POISSON = 0.3
ELLIPSE_SHARE = 0.2
ANGLE = 45.0
# Its elements and bodies. Where the front curves most its radius is SHORT^2/LONG = 0.67: six to
# seven elements. With fewer than six there is no K_N.
ELLIPSE_SIZES = {"size": 0.1, "upper_width": 12.0, "upper_height": 12.0, "growth": 0.5}
STATIONS = 12
# The plane contact: forces per length, length and layers of the solid.
PAD_MESH = Path(__file__).with_name("pad.msh")
PAD_FORCE = 6.0
PAD_SHEAR = 1.5
PAD_LENGTH = 1.0
PAD_LAYERS = 4


def sheared_sphere() -> Benchmark:
    """A sphere on a flat under a cycle of shear force.

    A bonded circle of radius a carries Q/(2π a²)/√(1 - r²/a²) (Mindlin 1949), so that the factor of
    shear along Q is Q/(2π a² √(2/a)) all around; its singularity and the Hertzian K_N = p0 √(2/a)
    are those of the front. In the steady cycle slip reaches inward to a (1 - Q/(f P))^(1/3), with Q
    the amplitude: exact where Poisson's ratio is 0.
    """
    amplitude = SPHERE_SHARE * FRICTION * SPHERE_FORCE
    shear_range = 2 * amplitude / (2 * math.pi * math.sqrt(2))
    slip, k_n = 1 - (1 - SPHERE_SHARE) ** (1 / 3), SPHERE_PEAK * math.sqrt(2)
    shear = {**_platen("force"), "direction": "x", "history": _cycle(amplitude, SPHERE_STEPS)}
    peak = SPHERE_PEAK
    return Benchmark(
        name="sphere, cyclic shear",
        source="Hertz 1882; Cattaneo 1938; Mindlin 1949; Mindlin and Deresiewicz 1953",
        case=_sphere_case("shear", shear),
        # Elements of a/8 and bodies 20 a high.
        quantities=(
            Quantity("a", 1.0, 1.0, {"fem": 0.005}, measures.front_radius),
            Quantity("p0", peak, peak, {"fem": 0.01}, measures.peak_pressure),
            Quantity("K_N", k_n, k_n, {"fem": 0.015}, measures.k_n),
            Quantity(
                "ΔK", shear_range, shear_range, {"fem": 0.015}, measures.front_range("k_range")
            ),
            Quantity("d", slip, 1.0, {"fem": 0.015}, measures.mean_slip_length),
        ),
    )


def cattaneo_sphere() -> Benchmark:
    """Cattaneo's problem in space: a ball on a flat, pressed and sheared once to 7/8 of f P.

    Vollebregt and Kalker's boundary elements (CONTACT) have the largest pressure and the friction
    work; what sticks has half the radius of the contact, (1 - Q/(f P))^(1/3).
    """
    # Shear modulus and Poisson's ratio, f, and the force of a contact of radius 1.
    shear_modulus, poisson, friction, force = 200.0, 0.42, 0.4, 9.1954
    young, amplitude = 2 * shear_modulus * (1 + poisson), 7 / 8 * friction * force
    shear = {**_platen("force"), "direction": "x", "history": [HOLD, ramp(amplitude, 4)]}
    parameters = {"radius_x": RADIUS, "contact_x": 1.0, "size": 1 / SPHERE_ELEMENTS}
    tables = _tables(parameters, poisson, force, {"shear": shear}, young)
    tables["contacts"]["main"]["friction"] = friction
    del tables["cycle"]
    return Benchmark(
        name="Cattaneo in space",
        source="CONTACT (Vollebregt and Kalker), example cattaneo, case 2",
        case=parse_case(tables),
        quantities=(
            Quantity("p0", 4.393, 4.393, {"fem": 0.01}, measures.peak_pressure),
            Quantity("friction work", 2.75e-3, 2.75e-3, {"fem": 0.01}, measures.dissipation),
            Quantity("d", 0.5, 1.0, {"fem": 0.015}, measures.mean_slip_length),
        ),
    )


def twisted_sphere() -> Benchmark:
    """A sphere on a flat under a cycle of twist: pure K_S.

    A bonded circle of radius a carries 3M r/(4π a³ √(a² - r²)) around its axis (Reissner and Sagoci
    1944), which is K_S = -3M/(4π a² √(2a)) all around; K_T is zero. Any Poisson's ratio.
    """
    amplitude = TWIST_SHARE * 3 * math.pi * FRICTION * SPHERE_FORCE / 16
    k_s = -3 * amplitude / (4 * math.pi * math.sqrt(2))
    twist = {"axis": "y", "centre": [0, 0, 0], "history": _cycle(amplitude, 2)}
    k_n, shear_range = SPHERE_PEAK * math.sqrt(2), 2 * abs(k_s)
    # Elements of a/8: means of stations that scatter by 1.5 %.
    bodies = {"fem": 0.01}
    return Benchmark(
        name="sphere, cyclic twist",
        source="Hertz 1882; Reissner and Sagoci 1944; Johnson 1985, section 3.9",
        case=_sphere_case("twist", {**_platen("moment"), **twist, "type": "tilt"}),
        quantities=(
            Quantity("K_N", k_n, k_n, bodies, measures.k_n),
            Quantity("K_S at the end", k_s, abs(k_s), bodies, measures.front_k_s),
            Quantity("ΔK", shear_range, shear_range, bodies, measures.front_range("k_range")),
            Quantity("ΔK_T", 0.0, shear_range, bodies, measures.front_range("k_t_range")),
        ),
    )


def sheared_ellipse() -> Benchmark:
    """An ellipsoid on a flat under a cycle of shear force, askew to both axes.

    At (a cos φ, b sin φ), with g² = cos²φ/a² + sin²φ/b², K_N = p0 √(2g); a bonded ellipse carries
    Q/(2π a b √(1 - x²/a² - z²/b²)) along the force, so that |K| = Q/(2π a b √(2g)). Compared are
    means over stations of what is found over what is known there: of the half of the stations where
    the front is flattest, and of the other half, at the tips.
    """
    e_star = YOUNG / (2 * (1 - ELLIPSE_POISSON**2))
    peak, radius_z = hertz_ellipse(SHORT, LONG, RADIUS, e_star)
    force = 2 * math.pi * SHORT * LONG * peak / 3
    amplitude = ELLIPSE_SHARE * FRICTION * force
    angle = math.radians(ANGLE)
    shear = {
        **_platen("force"),
        "direction": [math.cos(angle), 0.0, math.sin(angle)],
        "history": _cycle(amplitude, 2),
    }
    parameters = {"radius_x": RADIUS, "radius_z": radius_z, "contact_x": SHORT, "contact_z": LONG}
    shear_range = 2 * amplitude / (2 * math.pi * SHORT * LONG)
    numbers: dict[str, tuple[Callable[[Station], float], Callable[[Array], Array]]] = {
        "K_N": (lambda station: station.decisive_k_n[0], lambda g: peak * np.sqrt(2 * g)),
        "ΔK": (lambda station: station.k_range, lambda g: shear_range / np.sqrt(2 * g)),
    }
    return Benchmark(
        name="ellipse, cyclic shear",
        source="Hertz 1882; Mindlin 1949; Johnson 1985, sections 4.2 and 7.2",
        case=_case(parameters | ELLIPSE_SIZES, ELLIPSE_POISSON, force, {"shear": shear}),
        # Elements of b/10: means of stations that scatter by 1 to 2 %, at the tips by 3 %.
        quantities=tuple(
            Quantity(f"{name}/exact, {part}", 1.0, 1.0, {"fem": 0.015}, measure)
            for name, (found, known) in numbers.items()
            for part, measure in (
                ("sides", _ellipse_mean(found, known, tips=False)),
                ("tips", _ellipse_mean(found, known, tips=True)),
            )
        ),
    )


def hertz_ellipse(short: float, long: float, radius: float, e_star: float) -> tuple[float, float]:
    """Largest pressure, and the radius along the long half axis.

    The radius along the short one is given (Johnson 1985, equations 4.25 and 4.26).
    """
    square = (short / long) ** 2
    first, second = float(ellipkm1(square)), float(ellipe(1 - square))
    factor = short / ((1 - square) * long**2)
    peak = e_star / (2 * radius) / (factor * (second / square - first))
    return peak, e_star / (2 * peak * factor * (first - second))


def _ellipse_mean(
    found: Callable[[Station], float], known: Callable[[Array], Array], *, tips: bool
) -> Measure:
    """Mean of found over known numbers of the stations at the tips, or of all others."""

    def measure(result: Result) -> float:
        stations = result.contacts[0].stations
        x, _, z = np.array([station.point for station in stations]).T
        cosine, sine = np.array([z / LONG, x / SHORT]) / np.hypot(z / LONG, x / SHORT)
        g = np.hypot(cosine / LONG, sine / SHORT)
        ratio = np.array([found(station) for station in stations]) / known(g)
        # The front is flattest where g is largest.
        chosen = (g < np.median(g)) == tips
        return float(np.mean(ratio[chosen]))

    return measure


def extruded_pad() -> Benchmark:
    """A pad with a radius on a block, straight along z and held at both ends, against the plane.

    With hexahedra in layers the solution of the plane problem is that of the solid, to round-off:
    friction work and pressure are compared to that. K_N and K_T of a solid come from other fits
    than those of the plane: they agree to the error bars of both.
    """
    exact, fitted = {"fem": 1e-8}, {"fem": 0.015}
    return Benchmark(
        name="extruded pad, cyclic shear",
        source="the same finite elements in the plane",
        case=_pad_case(solid=True),
        twin=_pad_case(solid=False),
        quantities=(
            _same("friction work", measures.dissipation, measures.dissipation, exact),
            _same("p0", measures.peak_pressure, measures.peak_pressure, exact),
            _same("K_N", measures.k_n, measures.k_n, fitted),
            _same(
                "ΔK_T", measures.front_range("k_t_range"), measures.front_range("k_t_range"), fitted
            ),
        ),
    )


def _same(
    name: str, measure: Measure, of_twin: Measure, tolerances: Mapping[str, float]
) -> Quantity:
    """A number that is to be that of the benchmark's twin."""
    return Quantity(name, math.nan, math.nan, tolerances, measure, of_twin)


def _pad_case(*, solid: bool) -> Case:
    body = {"young": 1000.0, "poisson": 0.3}
    supports = {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}
    tables: dict[str, Any] = {}
    if solid:
        tables["solid"] = {"length": PAD_LENGTH, "layers": PAD_LAYERS}
        ends = [f"{name}_{end}" for name in ("upper", "lower") for end in ("front", "back")]
        supports |= {end: {"boundary": end, "fix": ["z"]} for end in ends}
    platen = {**_platen("force"), "direction": "x", "history": _cycle(PAD_SHEAR * PAD_LENGTH, 2)}
    return parse_case(
        {
            "model": {} if solid else {"thickness": PAD_LENGTH},
            "geometry": {"file": PAD_MESH.name, **tables},
            "bodies": {"upper": body, "lower": body},
            "supports": supports,
            "edges": {"stations": STATIONS},
            **_loads(PAD_FORCE * PAD_LENGTH, {"shear": platen}),
        },
        source=PAD_MESH.with_name("pad.toml"),
    )


def _sphere_case(name: str, load: Mapping[str, Any]) -> Case:
    parameters = {"radius_x": RADIUS, "contact_x": 1.0, "size": 1 / SPHERE_ELEMENTS}
    return _case(parameters, 0.0, SPHERE_FORCE, {name: load})


def _case(
    parameters: Mapping[str, float],
    poisson: float,
    force: float,
    loads: Mapping[str, Mapping[str, Any]],
) -> Case:
    return parse_case(_tables(parameters, poisson, force, loads))


def _tables(
    parameters: Mapping[str, float],
    poisson: float,
    force: float,
    loads: Mapping[str, Mapping[str, Any]],
    young: float = YOUNG,
) -> dict[str, Any]:
    """An ellipsoid on a flat that a platen presses on."""
    body = {"young": young, "poisson": poisson}
    return {
        "geometry": {"template": "sphere", "parameters": dict(parameters)},
        "bodies": {"upper": body, "lower": body},
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
        "edges": {"stations": STATIONS},
        **_loads(force, loads),
    }


def _loads(force: float, loads: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The tables of loads, with the force of the platen, of the contact and of the cycle."""
    normal = {**_platen("force"), "direction": "y", "history": [press(-force, 2)]}
    return {
        "contacts": {"main": {**FACES, "friction": FRICTION, "friction_from": 1.0}},
        "loads": {"press": normal, **loads},
        "cycle": {"start": 2.0, "end": 4.0},
        "output": {"fields": "none"},
    }


def _platen(control: str) -> dict[str, Any]:
    return {"type": "platen", "boundary": "upper_top", "control": control}


def _cycle(amplitude: float, steps: int) -> list[dict[str, Any]]:
    """From zero to the amplitude, then one cycle of so many steps from one extreme to the other."""
    turns = [{"ramp": (-1) ** k * amplitude, "until": 2.0 + k, "steps": steps} for k in (1, 2)]
    return [HOLD, ramp(amplitude, steps // 2), *turns]
