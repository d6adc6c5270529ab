# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane cases as solids: straight extrusions, their ends held along z.

With hexahedra that are a tensor product of a plane mesh and layers along z, the solution of the
plane problem is that of the solid, to round-off: the residual of a solution that does not depend on
z, against φ(x, y) ψ(z) e_z, is σ_zz φ ∫ψ' = 0. With tetrahedra it is so to the error of the mesh.
"""

from __future__ import annotations

from typing import Any

import blocks
import numpy as np
import pytest
from contact_runs import ramp

from fretfe._typing import Array
from fretfe.case import Case, Solid, parse_case
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.mesh.extrude import extrude
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result
from fretfe.results.solution import ContactHistory

LENGTH = 0.7


def solve_on(case: Case, mesh: Mesh) -> Result:
    return solve(MPI.COMM_WORLD, case, load=lambda: mesh)


def as_solid(data: dict[str, Any]) -> dict[str, Any]:
    """The case of a solid whose ends do not move along z."""
    ends = {
        f"{body}_{end}": {"boundary": f"{body}_{end}", "fix": ["z"]}
        for body in data["bodies"]
        for end in ("front", "back")
    }
    data = {**data, "supports": {**data.get("supports", {}), **ends}}
    del data["model"]["thickness"]
    return data


def by_place(contact: ContactHistory) -> tuple[Array, Array]:
    """Numbers of the nodes in the order of x, and of z within each x; and (N,) x."""
    points = contact.points.round(9)
    order = np.lexsort([points[:, -1] if points.shape[1] == 3 else points[:, 0], points[:, 0]])
    return order, points[order, 0]


def compare(plane: Result, solid: Result, tolerance: float) -> None:
    """Tractions, slip and forces of a solid are those of the plane, in every state."""
    assert plane.solution is not None and solid.solution is not None
    assert plane.failure is None and solid.failure is None
    for flat, space in zip(plane.solution.contacts, solid.solution.contacts, strict=True):
        order2, order3 = by_place(flat)[0], by_place(space)[0]
        layers = len(order3) // len(order2)
        rows = np.repeat(order2, layers)
        np.testing.assert_allclose(space.points[order3][:, :2], flat.points[rows], atol=1e-9)
        axes = space.frames[order3][:, 1:]  # the first tangent is that of the plane
        np.testing.assert_allclose(axes[:, 0, :2], flat.frames[rows][:, 1], atol=1e-7)
        expected, found = np.asarray(flat.traction)[:, rows], np.asarray(space.traction)[:, order3]
        scale = tolerance * np.abs(expected).max()
        np.testing.assert_allclose(found[..., :2], expected, atol=scale)
        np.testing.assert_allclose(found[..., 2], 0.0, atol=scale)
        slip2, slip3 = np.asarray(flat.slip)[:, rows], np.asarray(space.slip)[:, order3]
        closed = np.asarray(flat.status)[:, rows] > 0
        moved = tolerance * np.abs(slip2).max()
        difference = np.where(closed[..., None], slip3[..., :1] - slip2, 0.0)
        np.testing.assert_allclose(difference, 0.0, atol=moved)
    forces = [
        [each.solution.forces[:, each.solution.coordinates.index(name)] for name in LOADS]
        for each in (plane, solid)
    ]
    whole = np.array(forces[0]) * LENGTH
    np.testing.assert_allclose(forces[1], whole, atol=tolerance * np.abs(whole).max())


LOADS = ("press", "shear")


def pad_case() -> dict[str, Any]:
    platen = {"type": "platen", "boundary": "pad_top", "control": "force"}
    shear = [
        {"hold": True, "until": 1},
        {"ramp": 1.5, "until": 2, "steps": 2},
        {"ramp": -1.5, "until": 3, "steps": 3},
    ]
    return {
        "geometry": {"file": "none.msh"},
        "model": {"thickness": LENGTH},
        "bodies": {name: {"young": 1000.0, "poisson": 0.3} for name in ("pad", "block")},
        "contacts": {"main": {"surface1": "pad_bottom", "surface2": "block_top", "friction": 0.4}},
        "loads": {
            "press": {**platen, "direction": "y", "history": ramp(-6.0)},
            "shear": {**platen, "direction": "x", "history": shear},
        },
        "supports": {"base": {"boundary": "block_bottom", "fix": ["x", "y"]}},
    }


def rounded(points: Array) -> Array:
    """A pad whose lower side has a radius of 2."""
    x, y = points.T
    return np.column_stack([x, y + (1 - y) * x**2 / 4])


def pad_meshes(order: int, cell: str = "quadrilateral") -> Mesh:
    x = np.linspace(-0.6, 0.6, 17)
    pad = blocks.block("pad", x, [0.0, 0.15, 0.5, 1.0], order=order, mapping=rounded, cell=cell)
    wide = np.linspace(-1.0, 1.0, 21)
    base = blocks.block("block", wide, [-1.0, -0.5, -0.15, 0.0], order=order, cell=cell)
    return Mesh({"pad": pad, "block": base})


@pytest.mark.parametrize("order", [1, 2])
def test_extruded_pad_is_the_plane_pad(order: int) -> None:
    data, mesh = {**pad_case()}, pad_meshes(order)
    data["model"]["degree"] = order
    plane = solve_on(parse_case(data), mesh)
    solid = extrude(mesh, Solid(length=LENGTH, layers=2))
    compare(plane, solve_on(parse_case(as_solid(data)), solid), 1e-9)
