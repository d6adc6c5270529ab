# SPDX-License-Identifier: LGPL-3.0-or-later
"""A body in pieces that are apart is solved only if something holds each of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases.pieces_of_cells import Cells

from fretfe.bodies.rigid_modes import held_model
from fretfe.case import Case, parse_case
from fretfe.errors import ModelError
from fretfe.mesh.elements import directed_facets, exterior_facets
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.mesh.split import mesh_from_raw

MATERIAL = {"young": 2e5, "poisson": 0.3}
SIDES = {"top": (1, 1.0), "bottom": (1, 0.0), "far": (0, 3.0)}


def body(name: str, cells: Cells) -> BodyMesh:
    """With its top, its bottom and its right end as boundaries."""
    found = mesh_from_raw(cells.raw(name), "m.msh").bodies[name]
    outside, _ = exterior_facets(directed_facets(found.cells, found.cell, found.order), "line")
    middles = found.points[outside].mean(axis=1)
    sides = {
        f"{name}_{side}": outside[np.abs(middles[:, axis] - value) < 1e-9]
        for side, (axis, value) in SIDES.items()
    }
    return replace(
        found, boundaries={side: facets for side, facets in sides.items() if len(facets)}
    )


def pad_in_pieces() -> Mesh:
    """A pad whose right half stands beside it, both on a block."""
    pad = Cells("quadrilateral", 1).brick((0.0, 0.0), (1.0, 1.0), 2, 2)
    pad = pad.brick((2.0, 0.0), (3.0, 1.0), 2, 2)
    block = Cells("quadrilateral", 1).brick((0.0, 0.0), (3.0, 1.0), 2, 2)
    return Mesh({"pad": body("pad", pad), "block": body("block", block)})


def case(**supports: Any) -> Case:
    """Pressed by a platen over all of the pad, or held as given and pulled."""
    history = [{"ramp": -1.0, "until": 1.0, "steps": 1}]
    press = {"type": "platen", "boundary": "pad_top", "direction": "y", "control": "force",
             "history": history}  # fmt: skip
    pull = {"type": "traction", "boundary": "pad_top", "direction": "y", "history": history}
    base = {"boundary": "block_bottom", "fix": ["x", "y"]}
    return parse_case(
        {
            "geometry": {"file": "m.msh"},
            "bodies": {"pad": MATERIAL, "block": MATERIAL},
            "contacts": {
                "main": {"surface1": "pad_bottom", "surface2": "block_top", "friction": 0.3}
            },
            "supports": {"base": base, **supports},
            "loads": {"press": pull if supports else press},
        }
    )


def test_pieces_under_one_platen_are_held() -> None:
    mesh = pad_in_pieces()
    assert mesh.bodies["pad"].pieces == 2
    held_model(case(), mesh)


def test_a_piece_that_nothing_holds() -> None:
    with pytest.raises(ModelError) as caught:
        held_model(case(right={"boundary": "pad_far", "fix": ["x", "y"]}), pad_in_pieces())
    message = str(caught.value)
    assert message.startswith(
        "piece 1 of 2 of the body 'pad', around (0.5, 0.5) with the boundaries pad_top, "
        "pad_bottom, is not joined to the others and free "
    )
    assert "Expected supports or a platen that hold it" in message
