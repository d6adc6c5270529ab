# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case of a test: a pad of finite size on a flat specimen, as `fretfe run` takes it."""

from __future__ import annotations

import cmath
import math
from typing import Any

import tomli_w

from fretfe.analytic.profiles import FlatRounded, Wedge
from fretfe.idealise.bodies import side_tension
from fretfe.matching.pads import PadTest
from fretfe.matching.rig import Rig

# By it a file is known as one that may be replaced.
FIRST_LINE = "# A laboratory test, written by fretfe match."
# Widest pad over its radius, as the templates need it, and surface that may touch beyond a flat,
# over the largest contact beyond it.
WIDEST_PAD = 0.9
ZONE = 1.6
# Largest change of any value from mesh to mesh.
TOLERANCE = 0.005
PRESSING = 4
CYCLES = 3
STEPS = 40
HOLD = {"hold": True, "until": 1.0}
TOP = {"type": "platen", "boundary": "upper_top", "control": "force"}


def case_tables(test: PadTest, rig: Rig, title: str) -> dict[str, Any]:
    """The tables of the case.

    The specimen lies clamped on its base; with a bulk stress it slides on it, is held at its left
    end and pulled at the right one. The pad is pressed on without friction, then the loads cycle,
    P and Q in step.
    """
    bulk = test.factors.bulk_range > 0
    return {
        "title": title,
        "units": rig.units.model_dump(),
        "geometry": _geometry(test, rig),
        "edges": {"tolerance": TOLERANCE},
        "bodies": {
            "upper": {"young": rig.pad.young, "poisson": rig.pad.poisson},
            "lower": {"young": rig.specimen.young, "poisson": rig.specimen.poisson},
        },
        "contacts": {
            "pad": {
                "surface1": "upper_contact", "surface2": "lower_contact",
                "friction": test.factors.friction, "friction_from": 1.0,
            },
        },
        "supports": _supports(bulk),
        "loads": {
            "press": TOP | {
                "direction": "y",
                "history": [
                    {"ramp": -test.normal_force, "until": 1.0, "steps": PRESSING},
                    *_wave(-test.normal_amplitude, mean=-test.normal_force),
                ],
            },
            "shear": TOP | {
                "direction": "x",
                "history": [HOLD, *_wave(test.shear_amplitude)],
            },
            # The line of Q passes through the contact: what its arm does is taken back.
            "level": {
                "type": "tilt", "boundary": "upper_top", "control": "moment",
                "centre": [0.0, rig.pad.height],
                "history": [HOLD, *_wave(test.shear_amplitude * rig.pad.height)],
            },
            **({"bulk": _bulk(test, rig)} if bulk else {}),
        },
    }  # fmt: skip


def case_file(test: PadTest, rig: Rig, title: str) -> str:
    """The text of the case file."""
    return f"{FIRST_LINE}\n{tomli_w.dumps(case_tables(test, rig, title))}"


def pad_half_width(test: PadTest, rig: Rig) -> float:
    """Half of the width of the pad: that of the rig, or less if the radius is short."""
    beyond = WIDEST_PAD * getattr(test.profile, "radius", math.inf)
    return min(rig.pad.half_width, max(test.profile.kinks, default=0.0) + beyond)


def _geometry(test: PadTest, rig: Rig) -> dict[str, Any]:
    profile, start = test.profile, max(test.profile.kinks, default=0.0)
    width = pad_half_width(test, rig)
    zone = start + ZONE * (test.widest - start)
    sizes = {
        "upper_width": width,
        "upper_height": rig.pad.height,
        "lower_width": rig.specimen.half_width,
        "lower_height": rig.specimen.thickness,
        "zone": min(zone, 0.9 * min(width, rig.specimen.half_width)),
    }
    if isinstance(profile, Wedge):
        shape = {"angle": math.degrees(math.atan(profile.slope))}
        return {"template": "wedge", "parameters": shape | sizes}
    if isinstance(profile, FlatRounded):
        shape = {"flat_half_width": profile.flat_half_width, "radius": profile.radius}
        return {"template": "flat_rounded", "parameters": shape | sizes}
    shape = {"upper_radius": getattr(profile, "radius", math.nan), "lower_radius": 0.0}
    return {"template": "cylinder", "parameters": shape | sizes}


def _supports(bulk: bool) -> dict[str, Any]:
    if not bulk:
        return {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}
    return {
        "base": {"boundary": "lower_bottom", "fix": ["y"]},
        "end": {"boundary": "lower_left", "fix": ["x"]},
    }


def _wave(amplitude: float, mean: float = 0.0, phase: float = 0.0) -> list[dict[str, Any]]:
    if amplitude == 0:
        return []
    return [{
        "wave": "sine", "mean": mean, "amplitude": amplitude, "phase": phase, "period": 1.0,
        "cycles": CYCLES, "steps_per_cycle": STEPS,
    }]  # fmt: skip


def _bulk(test: PadTest, rig: Rig) -> dict[str, Any]:
    """Traction on the free end: the held one carries Q besides, which counts as tension in part."""
    given, specimen = test.factors, rig.specimen
    carried, _ = side_tension(specimen.half_width, specimen.thickness, sliding=True)
    wave = given.bulk_range / 2 * cmath.exp(-1j * given.bulk_phase) - carried * test.shear_amplitude
    amplitude, phase = abs(wave), cmath.phase(wave)
    # The wave starts at zero.
    mean = -amplitude * math.sin(phase)
    return {
        "type": "traction", "boundary": "lower_right", "direction": "normal",
        "history": [
            HOLD, *_wave(amplitude, mean, math.degrees(phase)),
        ],
    }  # fmt: skip
