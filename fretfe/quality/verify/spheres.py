# SPDX-License-Identifier: LGPL-3.0-or-later
"""A sphere on a flat, pressed and sheared back and forth: solids, which only finite elements solve.

A bonded circle of radius a carries Q/(2π a²)/√(1 - r²/a²) (Mindlin 1949), so that the factor of
shear along Q is Q/(2π a² √(2/a)) all around; its singularity and the Hertzian K_N = p0 √(2/a) are
those of the front. In the steady cycle slip reaches inward to a (1 - Q/(f P))^(1/3), with Q the
amplitude: exact where Poisson's ratio is 0.
"""

from __future__ import annotations

import math
from typing import Any

from fretfe.case import Case, parse_case
from fretfe.quality.verify import measures
from fretfe.quality.verify.model import Benchmark, Quantity

RADIUS, YOUNG, FRICTION = 50.0, 2e5, 0.5
# The load of a contact of radius 1: two bodies, no Poisson's ratio, E* = E/2.
FORCE = 2 * YOUNG / (3 * RADIUS)
PEAK = 3 * FORCE / (2 * math.pi)
# Q over f P, and elements over the radius of the contact.
SHARE, ELEMENTS = 0.5, 8
STEPS = 6


def sheared_sphere() -> Benchmark:
    """A sphere on a flat under a cycle of shear force."""
    amplitude = SHARE * FRICTION * FORCE
    turns = [{"ramp": amplitude, "until": 2.0, "steps": STEPS // 2}]
    turns += [{"ramp": (-1) ** k * amplitude, "until": 2.0 + k, "steps": STEPS} for k in (1, 2)]
    shear_range = 2 * amplitude / (2 * math.pi * math.sqrt(2))
    slip, k_n = 1 - (1 - SHARE) ** (1 / 3), PEAK * math.sqrt(2)
    return Benchmark(
        name="sphere, cyclic shear",
        source="Hertz 1882; Cattaneo 1938; Mindlin 1949; Mindlin and Deresiewicz 1953",
        case=_case([{"hold": True, "until": 1.0}, *turns]),
        # Elements of a/8 and bodies 20 a high.
        quantities=(
            Quantity("a", 1.0, 1.0, {"fem": 0.005}, measures.front_radius),
            Quantity("p0", PEAK, PEAK, {"fem": 0.01}, measures.peak_pressure, needs_tractions=True),
            Quantity("K_N", k_n, k_n, {"fem": 0.015}, measures.front_k_n),
            Quantity(
                "ΔK", shear_range, shear_range, {"fem": 0.015}, measures.front_mean("k_range")
            ),
            Quantity("d", slip, 1.0, {"fem": 0.015}, measures.front_slip_length),
        ),
    )


def _case(shear: list[dict[str, Any]]) -> Case:
    def platen(direction: str, history: list[dict[str, Any]]) -> dict[str, Any]:
        kind = {"type": "platen", "boundary": "upper_top", "control": "force"}
        return {**kind, "direction": direction, "history": history}

    parameters = {"radius_x": RADIUS, "contact_x": 1.0, "size": 1 / ELEMENTS}
    return parse_case(
        {
            "geometry": {"template": "sphere", "parameters": parameters},
            "bodies": {name: {"young": YOUNG, "poisson": 0.0} for name in ("upper", "lower")},
            "contacts": {
                "main": {
                    "surface1": "upper_contact",
                    "surface2": "lower_contact",
                    "friction": FRICTION,
                    "friction_from": 1.0,
                }
            },
            "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
            "loads": {
                "press": platen("y", [{"ramp": -FORCE, "until": 1.0, "steps": 2}]),
                "shear": platen("x", shear),
            },
            "edges": {"stations": 12},
            "cycle": {"start": 2.0, "end": 4.0},
            "output": {"fields": "none"},
        }
    )
