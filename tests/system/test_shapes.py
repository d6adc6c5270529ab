# SPDX-License-Identifier: LGPL-3.0-or-later
"""Boundaries whose displacement follows a shape; forces for the whole thickness."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import Run, ramp, run

from fretfe.case import Solid
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh

DOWN, TURN = -0.02, 0.003
# A platen that goes down by DOWN while it turns by TURN about (0.5, 1), at three points of it.
TOP = [[0.0, 1.0], [0.5, 1.0], [1.0, 1.0]]
MOVED = [[0.0, DOWN - 0.5 * TURN], [0.0, DOWN], [0.0, DOWN + 0.5 * TURN]]
PLATEN = {"type": "platen", "boundary": "upper_top", "control": "displacement"}
RIGID: dict[str, dict[str, Any]] = {
    "press": {**PLATEN, "direction": "y", "history": ramp(DOWN)},
    "tilt": {
        "type": "tilt",
        "boundary": "upper_top",
        "centre": [0.5, 1.0],
        "control": "rotation",
        "history": ramp(TURN),
    },
}


def shape(**keys: Any) -> dict[str, Any]:
    own = {"type": "shape", "boundary": "upper_top", "history": ramp(1.0), **keys}
    return own if "file" in own else {"points": TOP, "values": MOVED, **own}


def pressed(loads: dict[str, Any], supports: dict[str, Any] | None = None, order: int = 2) -> Run:
    """A block on a wider one, which is held at its base."""
    upper = blocks.block("upper", [0.0, 0.3, 0.6, 1.0], [0, 0.5, 1.0], order=order)
    lower = blocks.block("lower", [-0.5, 0.0, 0.5, 1.0, 1.5], [-1.0, 0.0], order=order)
    case = {
        "model": {"thickness": 2.0},
        "bodies": {name: {"young": 200.0, "poisson": 0.3} for name in ("upper", "lower")},
        "contacts": {
            "main": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.4}
        },
        "loads": loads,
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}, **(supports or {})},
    }
    return run(case, upper, lower)


@pytest.mark.mpi
@pytest.mark.parametrize("order", [1, 2])
def test_a_rigid_shape_is_a_platen(order: int) -> None:
    rigid, shaped = pressed(RIGID, order=order), pressed({"mode": shape()}, order=order)
    assert rigid.tractions[-1][:, 0].max() > 1.0
    scale = np.abs(rigid.tractions).max()
    np.testing.assert_allclose(shaped.tractions, rigid.tractions, atol=1e-9 * scale)
    force, moment, side = (rigid.forces[name] for name in ("press", "tilt", "upper_top guide x"))
    for name, expected in (("force x", side), ("force y", force), ("moment z", moment)):
        np.testing.assert_allclose(
            shaped.forces[f"mode {name}"], expected, atol=1e-9 * np.abs(force).max()
        )
    # the force of the shape does its work: by a unit of it
    work = DOWN * force + TURN * moment
    np.testing.assert_allclose(shaped.forces["mode"], work, rtol=1e-9)


def test_a_file_in_other_units(tmp_path: Path) -> None:
    path = tmp_path / "mode.csv"
    rows = [
        f"{i},{x / 1000:.17g},{y / 1000:.17g},{u / 1000:.17g},{v / 1000:.17g}\n"
        for i, ((x, y), (u, v)) in enumerate(zip(TOP, MOVED, strict=True))
    ]
    path.write_text('# mode 1, it"s in metres\nnode,x,y,ux,uy\n# rows\n' + "".join(rows))
    inline = pressed({"mode": shape()})
    found = pressed({"mode": shape(file=str(path), factor=1000.0)})
    np.testing.assert_allclose(found.tractions, inline.tractions, rtol=1e-9, atol=1e-12)


def test_a_bent_shape_bends_the_surface_of_a_body() -> None:
    """u = (-x y, x^2/2) k is a state of pure bending without tractions on top and bottom."""
    bend, nu, middle = 1e-3, 0.3, 0.5
    ratio = nu / (1 - nu)
    sides = {}
    for side, x in (("left", 0.0), ("right", 1.0)):
        y = np.linspace(0.0, 1.0, 41) - middle
        points = np.stack([np.full_like(y, x), y + middle], axis=1)
        arm = x - middle
        values = bend * np.stack([-arm * y, (arm**2 + ratio * y**2) / 2], axis=1)
        sides[side] = {
            "type": "shape",
            "boundary": f"upper_{side}",
            "points": points.tolist(),
            "values": (values + np.array([0.0, 0.2])).tolist(),
            "history": ramp(1.0, 1),
        }
    found = pressed(sides)
    np.testing.assert_allclose(found.tractions, 0.0, atol=1e-12)  # lifted
    (stress,) = (found.stress(0)[name] for name in ("upper",))
    # in the order of the stress
    y = found.model.bodies["upper"].elastic.element_nodes().reshape(-1, 2)[:, 1]
    modulus = 200.0 / (1 - nu**2)
    np.testing.assert_allclose(stress[:, 0, 0], -modulus * bend * (y - middle), atol=5e-4 * 0.1)
    assert np.abs(stress[:, 0, 0]).max() > 0.1


def test_supports_and_platens_at_a_common_corner() -> None:
    """A platen takes precedence at the corner, the shape over a support."""
    wall = {"wall": {"boundary": "upper_left", "fix": ["x"]}}
    moved = shape(values=[[0.01, DOWN], [0.01, DOWN], [0.01, DOWN]])
    found = pressed({"mode": moved}, wall)
    corner = found.displacement(1, "upper", lambda x: np.hypot(x[0], x[1] - 1) < 1e-9)
    np.testing.assert_allclose(corner, [[0.01, DOWN]], atol=1e-12)
    left = {**moved, "boundary": "upper_left", "points": [[0, 0.0], [0, 0.5], [0, 1.0]]}
    found = pressed({"mode": left, "press": RIGID["press"]})
    corner = found.displacement(1, "upper", lambda x: np.hypot(x[0], x[1] - 1) < 1e-9)
    np.testing.assert_allclose(corner, [[0.0, DOWN]], atol=1e-12)


def test_shapes_of_solids() -> None:
    """A twist by a shape is that by a tilt about the normal of the platen."""
    plane = {
        "upper": blocks.block("upper", [0.0, 0.5, 1.0], [0, 0.5, 1.0]),
        "lower": blocks.block("lower", [-0.5, 0.0, 0.5, 1.0, 1.5], [-1.0, 0.0]),
    }
    meshes = extrude(Mesh(plane), Solid(length=1.0, layers=2)).bodies.values()
    top = [[x, 1.0, z] for x in (0.0, 1.0) for z in (0.0, 1.0)]
    values = [[TURN * (z - 0.5), DOWN, -TURN * (x - 0.5)] for x, _, z in top]
    turned = {**RIGID["tilt"], "centre": [0.5, 1.0, 0.5], "axis": "y"}
    contact = {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.4}
    found = [
        run(
            {
                "bodies": {name: {"young": 200.0, "poisson": 0.3} for name in plane},
                "contacts": {"main": contact},
                "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
                "loads": loads,
            },
            *meshes,
        )
        for loads in (
            {"press": RIGID["press"], "tilt": turned},
            {"mode": shape(points=top, values=values)},
        )
    ]
    rigid, shaped = found
    scale = np.abs(rigid.tractions).max()
    np.testing.assert_allclose(shaped.tractions, rigid.tractions, atol=1e-9 * scale)
    assert np.abs(rigid.tractions[-1][:, 1:]).max() > 0.01 * scale
    moment = rigid.forces["tilt"]
    np.testing.assert_allclose(shaped.forces["mode moment y"], moment, rtol=1e-8)


def test_a_force_is_for_the_whole_thickness() -> None:
    """Here 2: half of it for a unit of thickness, in equilibrium with the contact."""
    wall = {"wall": {"boundary": "upper_left", "fix": ["x"]}}
    push = {"type": "force", "boundary": "upper_top", "direction": "y", "history": ramp(-3.0)}
    for part in ({}, {"centre": [0.5, 1.0], "radius": 0.3}):
        found = pressed({"push": {**push, **part}}, wall)
        weights = np.asarray(found.model.reduction.interface.roots) ** 2
        assert weights @ found.tractions[-1][:, 0] == pytest.approx(1.5, rel=1e-9)
