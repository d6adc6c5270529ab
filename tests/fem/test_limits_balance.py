# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forces that cancel on every body: they balance, and what is really wrong is found."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases import blocks, sectors
from cases.contact_runs import Run, ramp, run

from fretfe._typing import Array
from fretfe.contact.recorder import StateBlock
from fretfe.fem.limits import LARGEST_IMBALANCE, balance
from fretfe.mesh.mesh import BodyMesh

BORE, SEAT, RIM = 5.0, 10.0, 15.0
STEEL = {"young": 210e3, "poisson": 0.3, "expansion": 1e-5, "reference_temperature": 20.0}
INTERNAL: dict[str, dict[str, dict[str, Any]]] = {
    "shrunk": {
        f"fit{half}": {"type": "interference", "contact": f"seat{half}", "history": ramp(0.005)}
        for half in (1, 2)
    },
    "heated": {
        "heat": {"type": "temperature", "value": 70, "bodies": ["shaft"], "history": ramp(1.0)}
    },
    "blown up": {
        f"oil{half}": {
            "type": "traction",
            "boundary": f"shaft_left{half}",
            "direction": "normal",
            "history": ramp(-20.0),
        }
        for half in (1, 2)
    },
}


def around(name: str, inside: float, outside: float) -> BodyMesh:
    """A whole ring; its boundaries are those of two halves."""
    grid = blocks.block(
        name,
        np.linspace(inside, outside, 3),
        np.linspace(0, 180, 13),
        order=2,
        mapping=sectors.polar,
    )
    halves = [sectors.turned(grid, 180.0 * half, number=str(half + 1)) for half in (0, 1)]
    return sectors.joined(halves, name)


def fitted(loads: dict[str, dict[str, Any]]) -> Run:
    """A shaft in a ring, which is held at its rim: whatever acts, all resultants are zero."""
    case = {
        "bodies": {"shaft": STEEL, "ring": STEEL},
        "contacts": {
            f"seat{half}": {
                "surface1": f"ring_left{half}",
                "surface2": f"shaft_right{half}",
                "friction": 0.2,
            }
            for half in (1, 2)
        },
        "supports": {
            f"rim{half}": {"boundary": f"ring_right{half}", "fix": ["x", "y"]} for half in (1, 2)
        },
        "loads": loads,
    }
    return run(case, around("shaft", BORE, SEAT), around("ring", SEAT, RIM))


def at_the_end(found: Run) -> StateBlock:
    state, loads = found.results[-1].state, found.steps[-1]
    return StateBlock(
        slice(0, 1),
        state.traction.reshape(1, -1),
        state.coordinates[None],
        state.forces[None],
        loads.amplitudes[None],
    )


def ratios(found: Run, block: StateBlock) -> Array:
    """(2,) imbalance of forces and of moments over their scales."""
    parts = balance(found.model.reduction, [block])
    return np.array(
        [parts[f"{kind}_imbalance"][0] / parts[f"{kind}_scale"][0] for kind in ("force", "moment")]
    )


@pytest.mark.parametrize("kind", INTERNAL)
def test_forces_that_cancel_balance(kind: str) -> None:
    """Resultants of 1e-12 of the forces at the nodes, over one another, would be about one."""
    found = fitted(INTERNAL[kind])
    block = at_the_end(found)
    pressed = found.tractions[-1][:, 0] > 0
    assert pressed.any()
    assert (ratios(found, block) < 1e-10).all()
    # One of some fifty nodes carries a fifth of its pressure as shear, too: 1e-3 of all that acts.
    wrong = block.traction.copy()
    node = int(np.argmax(block.traction[0, ::2]))
    wrong[0, 2 * node + 1] += 0.2 * wrong[0, 2 * node]
    assert (ratios(found, replace(block, traction=wrong)) > LARGEST_IMBALANCE).all()
