# SPDX-License-Identifier: LGPL-3.0-or-later
"""Decks from end to end: the case that `check` proposes, solved."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.decks import LOW as LOW_ROWS
from cases.decks import NODES
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
)


def cap_loads(*, rigid: bool) -> dict[str, dict[str, Any]]:
    """The forces at the reference node, as `check` says that a case has them."""
    ramps = {
        value: [{"ramp": value, "until": 1.0, "steps": 2}] for value in (PRESSED, MOMENT, -MOMENT)
    }
    if not rigid:  # the moment is a couple with an arm of one
        force = {"type": "force", "boundary": "up_top", "direction": "y"}
        places = (("press", 1.3, PRESSED), ("right", 1.8, MOMENT), ("left", 0.8, -MOMENT))
        return {
            name: force | {"through": [x, 2.5], "history": ramps[value]}
            for name, x, value in places
        }
    own = {"type": "platen", "boundary": "up_top", "control": "force"}
    free = [{"hold": True, "until": 1.0, "steps": 1}]
    tilt = own | {"type": "tilt", "axis": "z", "centre": [1.3, 2.5], "control": "moment"}
    return {
        "up_top_x": own | {"direction": "x", "history": free},
        "up_top_y": own | {"direction": "y", "history": ramps[PRESSED]},
        "up_top_about_z": tilt | {"history": ramps[MOMENT]},
    }


@pytest.mark.parametrize("layers", [0, 1])
@pytest.mark.parametrize("kind", ["*KINEMATIC\n1, 2", "*DISTRIBUTING"])
def test_a_column_that_a_reference_node_bends(tmp_path: Path, kind: str, layers: int) -> None:
    """Navier's linear pressure and, of a rigid cap, the turn M H/(E I), both exact for ν = 0.

    M is about the middle of the column: the moment about the reference node, which is .2 beside it,
    and that of the force.
    """
    rigid = kind != "*DISTRIBUTING"
    lever = MOMENT - 0.2 * PRESSED
    path = tmp_path / "column.inp"
    write_deck(path, [LOW, UP], CAPPED.format(kind))
    tables = tomllib.loads("\n".join(outline(path).lines))
    tables["loads"] = cap_loads(rigid=rigid)
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


# Under the head a square of order 2, one of order 1 and two triangles.
MIDDLE_NODES = "41, 0.5, 1.\n42, 1., 1.5\n43, 0.5, 2.\n44, 0., 1.5\n"
MIXED = (
    f"*NODE\n{NODES}{MIDDLE_NODES}*ELEMENT, TYPE=CPE4, ELSET=LOW\n{LOW_ROWS}"
    "*ELEMENT, TYPE=CPE8, ELSET=UP\n21, 21, 22, 26, 25, 41, 42, 43, 44\n"
    "*ELEMENT, TYPE=CPE4, ELSET=UP\n22, 22, 23, 27, 26\n"
    "*ELEMENT, TYPE=CPE3, ELSET=UP\n23, 23, 24, 28\n24, 23, 28, 27\n"
    "*NSET, NSET=FOOT\n1, 2, 3, 4\n*SURFACE, NAME=FACE\nLOW, S3\n*SURFACE, NAME=PAD\n21, S1\n"
    "22, S1\n23, S1\n*SURFACE, NAME=HEAD\n21, S3\n22, S3\n24, S2\n"
    "*SURFACE, NAME=LEFT\n1, S4\n*SURFACE, NAME=PADLEFT\n21, S4\n"
)


@pytest.mark.parametrize("layers", [0, 1])
def test_a_body_of_both_orders_and_two_shapes_passes_the_patch_test(
    tmp_path: Path, layers: int
) -> None:
    (tmp_path / "mixed.inp").write_text(MIXED)
    steel = {"young": 200e3, "poisson": 0.3}
    geometry: dict[str, Any] = {"file": "mixed.inp"}
    supports = {"FOOT": ["y"], "LEFT": ["x"], "PADLEFT": ["x"]}
    if layers:
        geometry["solid"] = {"length": 0.5, "layers": layers}
        supports |= {"low_front": ["z"], "up_front": ["z"]}
    case = parse_case({
        "geometry": geometry,
        "bodies": {"low": steel, "up": steel},
        "contacts": {"main": {"surface1": "PAD", "surface2": "FACE", "friction": 0.3}},
        "supports": {name.lower(): {"boundary": name, "fix": fix}
                     for name, fix in supports.items()},
        "loads": {"press": {"type": "traction", "boundary": "HEAD", "direction": "normal",
                            "history": [{"ramp": -10.0, "until": 1.0, "steps": 1}]}},
        "output": {"fields": "none"},
    }, tmp_path / "mixed.toml")  # fmt: skip
    found = fretfe.run(case)
    traction = found.contact_history("main").traction[-1]
    np.testing.assert_allclose(traction[:, 0], 10.0, rtol=1e-9)
    np.testing.assert_allclose(traction[:, 1:], 0.0, atol=1e-8)
    told = " ".join(found.notes)
    assert "body 'up' has 1 quadrilaterals and 2 triangles of order 1 beside others" in told
    assert "and is divided into triangles" in told
