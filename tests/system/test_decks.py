# SPDX-License-Identifier: LGPL-3.0-or-later
"""Decks from end to end: the case that `check` proposes, solved."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from cases.tied_blocks import Block, write_deck

import fretfe
from fretfe.case import parse_case
from fretfe.mesh.inp_outline import outline

LOW = Block("LOW", "low", np.linspace(0, 3, 4), np.linspace(0, 1, 3))
UP = Block("UP", "up", np.linspace(0, 3, 6), np.linspace(1, 2, 3))
YOUNG, PRESSED, MOMENT, HEIGHT = 200e3, -300.0, 40.0, 2.0
# The upper block has a cap with a reference node off its middle; nothing shrinks across.
CAPPED = (
    "*NODE, NSET=RP\n99, 1.3, 2.5\n*COUPLING, REF NODE=RP, SURFACE=up_top\n{}\n"
    f"*MATERIAL, NAME=M\n*ELASTIC\n{YOUNG}, 0.\n"
    "*SOLID SECTION, ELSET=LOW, MATERIAL=M\n*SOLID SECTION, ELSET=UP, MATERIAL=M\n"
    "*NSET, NSET=FOOT, GENERATE\n10000, 10003, 1\n*BOUNDARY\nFOOT, ENCASTRE\n"
    "*SURFACE INTERACTION, NAME=RUB\n*FRICTION\n0.5,\n"
    "*CONTACT PAIR, INTERACTION=RUB\nup_bottom, low_top\n"
    "*STEP\n*STATIC, DIRECT\n0.5, 1.\n*CLOAD\n{}\n*END STEP\n"
)


@pytest.mark.parametrize("layers", [0, 1])
@pytest.mark.parametrize("kind", ["*KINEMATIC\n1, 2", "*DISTRIBUTING"])
def test_a_column_that_a_reference_node_bends(tmp_path: Path, kind: str, layers: int) -> None:
    """Navier's linear pressure and, of a rigid cap, the turn M H/(E I), both exact for ν = 0.

    M is about the middle of the column; the cap gets it as a moment about its reference node, .2
    beside it, the spread force by its place alone.
    """
    rigid = kind != "*DISTRIBUTING"
    lever = (MOMENT if rigid else 0.0) - 0.2 * PRESSED
    loads = f"RP, 2, {PRESSED}" + (f"\nRP, 6, {MOMENT}" if rigid else "")
    path = tmp_path / "column.inp"
    write_deck(path, [LOW, UP], CAPPED.format(kind, loads))
    tables = tomllib.loads("\n".join(outline(path)))
    width = 0.5 if layers else 1.0
    if layers:
        tables["geometry"]["solid"] = {"length": width, "layers": layers}
        tables["supports"]["foot"]["fix"].append("z")
        for load in tables["loads"].values():
            for key in {"centre", "through"} & load.keys():
                load[key].append(width / 2)
    found = fretfe.run(parse_case(tables, path.with_suffix(".toml")))
    contact = found.contact_history("up_bottom")
    x = contact.surface.points[:, 0] - 1.5
    inertia = width * 3.0**3 / 12
    even = -PRESSED / (3.0 * width) - lever * x / inertia
    np.testing.assert_allclose(contact.traction[-1][:, 0], even, atol=1e-8 * even.max())
    np.testing.assert_allclose(contact.traction[-1][:, 1:], 0.0, atol=1e-8 * even.max())
    if rigid:
        turn = found.solution.coordinates.index("up_top_about_z")
        expected = lever * HEIGHT / (YOUNG * inertia)
        assert found.solution.amplitudes[-1, turn] == pytest.approx(expected, rel=1e-8)
