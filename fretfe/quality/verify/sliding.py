# SPDX-License-Identifier: LGPL-3.0-or-later
"""A block that slides up a wedge: the ratio of the forces that push and press it.

All of the contact slips, so Coulomb's law and equilibrium alone give the ratio,
(tan alpha + f)/(1 - f tan alpha), whatever the elastic bodies do.
"""

from __future__ import annotations

from pathlib import Path

from fretfe.case import Case, parse_case
from fretfe.quality.verify import measures
from fretfe.quality.verify.cases import HOLD, press, ramp
from fretfe.quality.verify.model import Benchmark, Quantity

MESH = Path(__file__).with_name("sliding_wedge.msh")
SLOPE, FRICTION = 0.1, 0.3
# The force gives a mean pressure of 0.25 % of E: elastic displacements are a few thousandths of the
# length, and the push makes all of the contact slip.
YOUNG, FORCE, PUSH = 200e3, 1000.0, 0.02


def sliding_wedge() -> Benchmark:
    """A block on a wedge, pressed down with a force and pushed uphill."""
    ratio = (SLOPE + FRICTION) / (1 - FRICTION * SLOPE)
    # Exact in any discretisation: equilibrium is met to the accuracy of the solver.
    tolerances = {"fem": 1e-6}
    measure = measures.force_ratio("push", "press")
    return Benchmark(
        name="sliding wedge block",
        source="NAFEMS CGS-4 (Feng and Prinja 2001)",
        case=_case(),
        quantities=(Quantity("H/V", ratio, ratio, tolerances, measure, needs_tractions=True),),
    )


def _case() -> Case:
    body = {"young": YOUNG, "poisson": 0.3}
    platen = {"type": "platen", "boundary": "upper_top"}
    return parse_case(
        {
            "geometry": {"file": MESH.name},
            "bodies": {"upper": body, "lower": body},
            "contacts": {
                "main": {
                    "surface1": "upper_contact",
                    "surface2": "lower_contact",
                    "friction": FRICTION,
                }
            },
            "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
            "loads": {
                "press": {
                    **platen,
                    "direction": [0.0, -1.0],
                    "control": "force",
                    "history": [press(FORCE)],
                },
                "push": {
                    **platen,
                    "direction": "x",
                    "control": "displacement",
                    "history": [HOLD, ramp(PUSH, 8)],
                },
            },
            "output": {"fields": "none"},
        },
        source=MESH.with_name("sliding_wedge.toml"),
    )
