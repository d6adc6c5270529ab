# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors of a disc: sides that follow each other, against closed forms and the whole ring."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import blocks
import numpy as np
import pytest
import sectors
from contact_runs import Run, run
from scipy import sparse
from scipy.spatial import cKDTree

from fretfe._typing import Array
from fretfe.bodies.cyclic import Tie, tie_sides
from fretfe.bodies.definition import (
    Constraint,
    DistributedLoad,
    Material,
    ModelDefinition,
    define_model,
)
from fretfe.case import Case, Symmetry
from fretfe.contact.interface import Coordinate
from fretfe.fem import model as fem_model
from fretfe.fem._compat import MPI
from fretfe.fem.condensation import Body
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.timing import Clock
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.surface import boundary_surface


def tie(mesh: BodyMesh, count: int, degree: int = 2, **keys: Any) -> Tie:
    names = (f"{mesh.name}_bottom", f"{mesh.name}_top")
    table = {"type": "cyclic", "boundary1": names[0], "boundary2": names[1], "sectors": count}
    symmetry = Symmetry.model_validate({"centre": (0, 0), **table, **keys})
    return tie_sides(symmetry, ("symmetry", "s"), Path("case.toml"), mesh, degree)


def annulus_error(count: int) -> float:
    """Relative error of the hoop stress at the bore of a spinning annulus, in plane stress.

    sigma = (rho w^2/4) ((3 + nu) b^2 + (1 - nu) a^2) (Timoshenko & Goodier, art. 32).
    """
    a, b, nu = 1.0, 2.0, 0.3
    mesh = blocks.block(
        "disc", a + (b - a) * np.linspace(0, 1, count + 1) ** 1.5, np.linspace(-20, 20, 9), order=2,
        mapping=sectors.polar,
    )  # fmt: skip
    elastic = ElasticBody(
        MPI.COMM_WORLD, mesh if MPI.COMM_WORLD.rank == 0 else None,
        Material(200.0, nu, 1.0, "stress"), 2,
    )  # fmt: skip
    sides = tie(mesh, 9)
    hold = Constraint(
        "hold",
        "disc_bottom",
        tuple(sides.circumferential(sides.leaders[0])),
        roller=True,
        at=tuple(sides.leaders[0]),
        within=1e-6,
    )
    points = boundary_surface(mesh, "disc_left").displacement_points(2)
    operator = sparse.eye(points.size, format="csr")
    load = DistributedLoad("spin", "rotation", "", (0.0, 0.0, 1.0), (0.0, 0.0))
    body = Body(elastic, [hold], [load], points, operator, Clock(), sides)
    zero = np.zeros(operator.shape[0])
    (field,) = body.recover([(zero, np.zeros(1), np.ones(1))])
    stress, nodes = elastic.element_stresses(field), elastic.element_nodes()
    x, y = np.moveaxis(nodes, 2, 0)
    angle = np.arctan2(y, x)
    xx, yy, _, xy = np.moveaxis(stress, 2, 0)
    hoop = xx * np.sin(angle) ** 2 + yy * np.cos(angle) ** 2 - xy * np.sin(2 * angle)
    expected = ((3 + nu) * b**2 + (1 - nu) * a**2) / 4
    wrong = np.abs(hoop[np.hypot(x, y) < a + 1e-9] / expected - 1).max(initial=0.0)
    return float(elastic.comm.allreduce(wrong, op=MPI.MAX))


@pytest.mark.mpi
def test_hoop_stress_of_a_spinning_annulus() -> None:
    coarse, fine = annulus_error(10), annulus_error(20)
    assert fine < 1e-4
    assert coarse / fine > 6  # quadratic elements


def whole_ring(**options: Any) -> list[BodyMesh]:
    """All sectors in one body, and their blocks."""
    step = 360 / sectors.SECTORS
    count = range(sectors.SECTORS)
    parts = [sectors.turned(sectors.ring(**options), i * step, number=str(i)) for i in count]
    pads = [sectors.turned(sectors.pad(), i * step, f"pad{i}", str(i)) for i in count]
    return [sectors.joined(parts, "ring"), *pads]


def hold_ring(case: Case, mesh: Mesh) -> ModelDefinition:
    """The model, its ring held as one of its sectors is, at the same place of all of them."""
    constraints = []
    for number in range(sectors.SECTORS):
        angle = np.radians(-45 + 360 / sectors.SECTORS * number)
        way, place = (-np.sin(angle), np.cos(angle)), (np.cos(angle), np.sin(angle))
        at = tuple(sectors.OUTSIDE * np.array(place))
        name = f"ring_bottom{number}"
        constraints.append(Constraint(name, name, way, roller=True, at=at, within=1e-6))
    coordinates = tuple(Coordinate(c.label, "ring", "fixed", "") for c in constraints)
    definition = define_model(case, mesh)
    bodies = [
        replace(body, constraints=tuple(constraints), coordinates=coordinates)
        if body.name == "ring"
        else body
        for body in definition.bodies
    ]
    return replace(definition, bodies=tuple(bodies))


def one_sector(angle: float = 0.0, **options: Any) -> Run:
    meshes = (sectors.turned(each, angle) for each in (sectors.ring(**options), sectors.pad()))
    return run(sectors.spinning(1, symmetry=sectors.cyclic()), *meshes)


def assert_same(found: Array, expected: Array) -> None:
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max(), rtol=0)


@pytest.mark.mpi
def test_a_sector_is_the_whole_ring(monkeypatch: pytest.MonkeyPatch) -> None:
    one = one_sector()
    monkeypatch.setattr(fem_model, "held_model", hold_ring)
    ring = run(sectors.spinning(sectors.SECTORS), *whole_ring())
    for part in np.split(ring.tractions, sectors.SECTORS, axis=1):
        assert_same(part, one.tractions)


@pytest.mark.mpi
def test_a_turned_sector_has_the_same_tractions() -> None:
    assert_same(one_sector(31.0).tractions, one_sector().tractions)


def test_sides_move_alike() -> None:
    one = one_sector()
    nodes = one.model.bodies["ring"].elastic.space.tabulate_dof_coordinates()[:, :2]
    values = one.fields(1)["ring"].x.array.reshape(-1, 2)
    sides = tie(sectors.ring(), sectors.SECTORS)
    places = cKDTree(nodes)
    following, leading = (
        values[places.query(each)[1]] for each in (sides.followers, sides.leaders)
    )
    assert np.abs(leading).max() > 1e-3
    assert np.abs(following - sides.image(leading)).max() < 1e-12 * np.abs(leading).max()
