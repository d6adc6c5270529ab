# SPDX-License-Identifier: LGPL-3.0-or-later
"""A pad of two tied parts: the same as in one piece, and exact where nothing is approximated."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.tied_blocks import Block, pressed_case, write_deck

import fretfe
from fretfe._typing import Array

X, Y = np.linspace(0, 4, 9), np.linspace(1, 3, 9)
BLOCK = Block("BLOCK", "block", np.linspace(0, 4, 17), np.linspace(-1, 1, 9))
WHOLE = (Block("PAD", "low", X, Y),)
HALVES = (Block("PAD", "low", X, Y[:5]), Block("PAD", "high", X, Y[4:]))
UNLIKE = (HALVES[0], Block("PAD", "high", np.linspace(0, 4, 8), Y[4:]))
TIE = {"glue": {"boundary1": "low_top", "boundary2": "high_bottom"}}
# Pressed, and then sheared, on a block that is held at its lower side.
SHEARED: dict[str, Any] = {"supports": {"base": {"boundary": "block_bottom", "fix": ["x", "y"]}}}


def tractions(folder: Path, parts: tuple[Block, ...], **tables: Any) -> Array:
    """(T, n, d) of the contact nodes."""
    write_deck(folder / "pad.inp", [*parts, BLOCK])
    tied = len(parts) > 1
    top = "high_top" if tied else "low_top"
    for load in tables.get("loads", {}).values():
        load["boundary"] = top
    ties = {"ties": TIE} if tied else {}
    case = pressed_case(folder / "pad.inp", top, **ties, **tables)
    return np.asarray(fretfe.run(case).contact_history("main").traction[:])


def sheared() -> dict[str, Any]:
    held = {"hold": True, "until": 2.0, "steps": 4}
    ramps = {
        "normal": [{"ramp": -10.0, "until": 1.0, "steps": 1}, held],
        "x": [{"hold": True, "until": 1.0}, {"ramp": 1.0, "until": 2.0, "steps": 4}],
    }
    return {
        name: {"type": "traction", "boundary": "", "direction": name, "history": history}
        for name, history in ramps.items()
    }


def test_matching_halves_are_one_piece(tmp_path: Path) -> None:
    one, two = (tractions(tmp_path, parts, loads=sheared(), **SHEARED) for parts in (WHOLE, HALVES))
    assert np.abs(one[-1, :, 1]).max() > 0.5
    np.testing.assert_allclose(two, one, atol=1e-9 * np.abs(one).max())


def test_other_nodes_change_the_contact_less_than_its_mesh_does(tmp_path: Path) -> None:
    one, two = (tractions(tmp_path, parts, loads=sheared(), **SHEARED) for parts in (WHOLE, UNLIKE))
    np.testing.assert_allclose(two, one, atol=1e-4 * np.abs(one).max())


@pytest.mark.parametrize("layers", [0, 1])
@pytest.mark.parametrize("degree", [1, 2])
def test_a_state_of_even_stress_is_exact(tmp_path: Path, degree: int, layers: int) -> None:
    """Patch test: both bodies under the same pressure, whatever the nodes at the tie are."""
    solid = {"solid": {"length": 0.5, "layers": layers}} if layers else {}
    supports = {
        "base": {"boundary": "block_bottom", "fix": ["y"]},
        "side": {"boundary": "block_left", "fix": ["x"]},
    }
    if layers:
        supports |= {
            each: {"boundary": each, "fix": ["z"]} for each in ("block_front", "pad_front")
        }
    found = tractions(tmp_path, UNLIKE, model={"degree": degree}, supports=supports,
                      geometry={"file": "pad.inp", **solid})  # fmt: skip
    even = np.zeros_like(found[-1])
    even[:, 0] = 10.0
    np.testing.assert_allclose(found[-1], even, atol=1e-9)
