# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ends of fronts at planes of symmetry and at sides of sectors: the bodies go on behind them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases import blocks

from fretfe._typing import Array
from fretfe.bodies.continued import continued_nodes
from fretfe.bodies.definition import contact_surfaces, couple_contacts, define_model
from fretfe.case import Solid, parse_case
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh

Data = dict[str, Any]
LENGTH = 0.7


def slice_meshes() -> Mesh:
    """A pad on a wider block, as solids."""
    pad = blocks.block("pad", [-0.6, -0.2, 0.2, 0.6], [0.0, 1.0], cell="quadrilateral")
    base = blocks.block("block", [-1.0, -0.3, 0.3, 1.0], [-1.0, 0.0], cell="quadrilateral")
    return extrude(Mesh({"pad": pad, "block": base}), Solid(length=LENGTH, layers=2))


def slice_case() -> Data:
    """Both ends of both bodies are held along z."""
    platen = {"type": "platen", "boundary": "pad_top", "control": "force", "direction": "y"}
    ends = [f"{body}_{end}" for body in ("pad", "block") for end in ("front", "back")]
    return {
        "geometry": {"file": "none.msh"},
        "bodies": {name: {"young": 1000.0, "poisson": 0.3} for name in ("pad", "block")},
        "contacts": {"main": {"surface1": "pad_bottom", "surface2": "block_top", "friction": 0.4}},
        "loads": {"press": {**platen, "history": [{"ramp": -1.0, "until": 1, "steps": 1}]}},
        "supports": {
            "base": {"boundary": "block_bottom", "fix": ["x", "y"]},
            **{end: {"boundary": end, "fix": ["z"]} for end in ends},
        },
    }


def ends(data: Data, mesh: Mesh, low: float, high: float) -> tuple[bool, bool]:
    """Whether both bodies go on behind the nodes at z = low, and at z = high, and nowhere else."""
    case = parse_case(data)
    model = define_model(case, mesh)
    (pair,) = couple_contacts(case, contact_surfaces(model, mesh), 3)
    normals, z = continued_nodes(case, model, mesh, pair), pair.coupling.surface.points[:, 2]
    assert normals is not None
    found = np.abs(normals[:, 2]) == 1
    assert np.isnan(normals[~found]).all() and not normals[found, :2].any()
    at = [np.abs(z - end) < 1e-9 for end in (low, high)]
    assert not found[~(at[0] | at[1])].any()
    assert all(found[each].all() or not found[each].any() for each in at)
    return bool(found[at[0]].all()), bool(found[at[1]].all())


def let_go(data: Data) -> None:
    del data["supports"]["pad_back"]


def along_too(data: Data) -> None:
    data["supports"]["block_back"]["fix"] = ["x", "z"]


def on_rollers(data: Data) -> None:
    data["supports"]["pad_back"] = {"boundary": "pad_back", "direction": [0, 0, -2]}


def pulled_along(data: Data) -> None:
    pull = {"direction": [0, 1, 0], "history": [{"ramp": 1.0, "until": 1, "steps": 1}]}
    data["loads"]["pull"] = {"type": "traction", "boundary": "pad_back", **pull}


def moved_across(data: Data) -> None:
    del data["supports"]["pad_back"]
    move = {"direction": "z", "history": [{"ramp": 0.01, "until": 1, "steps": 1}]}
    data["loads"]["move"] = {"type": "displacement", "boundary": "pad_back", **move}


CUBIC = {"cubic": [252e3, 161e3, 131e3]}


def aligned(data: Data) -> None:
    data["bodies"]["pad"] = {"elastic": CUBIC, "orientation": {"x": [1, 1, 0], "y": [-1, 1, 0]}}


def tilted(data: Data) -> None:
    data["bodies"]["pad"] = {"elastic": CUBIC, "orientation": {"x": [1, 1, 1], "y": [-1, 1, 0]}}


@pytest.mark.parametrize(
    ("change", "back"),
    [
        (dict, True),
        (on_rollers, True),
        (let_go, False),
        (along_too, False),
        (pulled_along, False),
        (moved_across, False),
        (aligned, True),
        (tilted, False),
    ],
)
def test_planes_of_symmetry(change: Callable[[Data], None], back: bool) -> None:
    """Held across and by nothing else, both bodies, of a material that is its own image."""
    data = slice_case()
    change(data)
    assert ends(data, slice_meshes(), 0.0, LENGTH) == (back, change is not tilted)


COUNT, BORE = 12, 3.0


def bent(mesh: Mesh) -> Mesh:
    """A sector of a ring on a drum: layers turned about an axis along x."""

    def turned(points: Array) -> Array:
        x, y, z = points.T
        angle = z / LENGTH * 2 * np.pi / COUNT
        return np.column_stack([x, (BORE + y) * np.cos(angle), (BORE + y) * np.sin(angle)])

    return Mesh({n: replace(b, points=turned(b.points)) for n, b in mesh.bodies.items()})


@pytest.mark.parametrize("tied", [("pad", "block"), ("block",)])
def test_sides_of_sectors(tied: tuple[str, ...]) -> None:
    """Of both bodies: the sides of a pad in a drum that goes on are free."""
    data = slice_case()
    del data["supports"]
    data["symmetry"] = {
        name: {
            "type": "cyclic",
            "boundary1": f"{name}_back",
            "boundary2": f"{name}_front",
            "sectors": COUNT,
            "axis": [1, 0, 0],
            "centre": [0, 0, 0],
        }
        for name in tied
    }
    mesh = bent(slice_meshes())
    case = parse_case(data)
    model = define_model(case, mesh)
    (pair,) = couple_contacts(case, contact_surfaces(model, mesh), 3)
    _, y, z = pair.coupling.surface.points.T
    angle = np.arctan2(z, y) * COUNT / (2 * np.pi)
    at_side = (np.abs(angle) < 1e-9) | (np.abs(angle - 1) < 1e-9)
    assert at_side.any()
    normals = continued_nodes(case, model, mesh, pair)
    assert normals is not None
    assert np.isnan(normals[~at_side]).all()
    expected = 0.0 if len(tied) == 2 else np.nan
    np.testing.assert_array_equal(normals[at_side], expected)
