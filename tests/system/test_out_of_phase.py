# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shear and bulk tension out of phase: every edge reverses at a time of its own, between steps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.b1_meshes import write_b1

from fretfe.case import parse_case
from fretfe.evaluate.contacts import Contact
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve

H = 0.03


def wave(amplitude: float, phase: float, steps: int) -> dict[str, Any]:
    shape = {"wave": "sine", "amplitude": amplitude, "phase": phase, "period": 1.0}
    return {**shape, "cycles": 2, "steps_per_cycle": steps}


def run(mesh: Path, steps: int) -> Contact:
    steel = {"young": 210e3, "poisson": 0.3}
    platen = {"type": "platen", "boundary": "pad_top", "control": "force"}
    hold = {"hold": True, "until": 1.0}
    lag = 100 * np.sin(np.radians(-60))
    case = parse_case(
        {
            "geometry": {"file": str(mesh)},
            "bodies": {"pad": steel, "substrate": steel},
            "contacts": {
                "main": {
                    "surface1": "pad_contact",
                    "surface2": "substrate_contact",
                    "friction": 0.5,
                    "friction_from": 1.0,
                }
            },
            "supports": {"left": {"boundary": "substrate_left", "fix": ["x", "y"]}}
            | {"base": {"boundary": "substrate_bottom", "fix": ["y"]}},
            "loads": {
                "press": {
                    **platen,
                    "direction": "y",
                    "history": [{"ramp": -1800.0, "until": 1.0, "steps": 3}],
                },
                "shear": {**platen, "direction": "x", "history": [hold, wave(200.0, 0.0, steps)]},
                "pull": {
                    "type": "traction",
                    "boundary": "substrate_right",
                    "direction": "x",
                    "history": [
                        {"ramp": float(lag), "until": 1.0, "steps": 3},
                        wave(100.0, -60.0, steps),
                    ],
                },
            },
            "output": {"fields": "none"},
        }
    )
    outcome = solve(MPI.COMM_WORLD, case)
    assert outcome.failure is None
    return outcome.contacts[0]


@pytest.fixture(scope="module")
def summaries(tmp_path_factory: pytest.TempPathFactory) -> list[Contact]:
    mesh = tmp_path_factory.mktemp("mesh") / "pad.msh"
    write_b1(mesh, order=2, h=H, growth=0.2)
    return [run(mesh, steps) for steps in (20, 80)]


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
def test_slip_zones_do_not_depend_on_the_steps(summaries: list[Contact], side: int) -> None:
    coarse, fine = (
        [zone.length for zone in summary.stations[side].slip_zones[-2:]] for summary in summaries
    )
    # A border is located to about a tenth of the element size; 20 steps miss a reversal by up to
    # (pi/20)^2/2 of the range.
    assert coarse == pytest.approx(fine, abs=0.1 * H + 0.012 * max(fine))


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
def test_slip_zones_are_resolved(summaries: list[Contact], side: int) -> None:
    assert all(zone.resolved for zone in summaries[0].stations[side].slip_zones[-2:])
