# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tractions and forces on boundaries, gravity, and body forces in interaction integrals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import run
from harness.petsc_garbage import replace_meshes

from fretfe._typing import Array
from fretfe.bodies.loads.spread import Acceleration, Force, SpreadLoad, Traction
from fretfe.bodies.point_values import PointValues
from fretfe.case import Solid
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.interaction_integral import InteractionForm, Tip, Tube
from fretfe.materials.material import Material
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh

STEEL = Material(200.0, 0.3, 2.5, "strain")


def elastic_block(degree: int, cell: str = "triangle", columns: int = 5) -> ElasticBody:
    x = blocks.graded(0, 2, columns, 1.3 ** (5 / columns))
    mesh = blocks.block("b", x, blocks.graded(0, 1, 3), cell=cell)
    body = ElasticBody(MPI.COMM_WORLD, mesh if MPI.COMM_WORLD.rank == 0 else None, STEEL, degree)
    replace_meshes(body.mesh)
    return body


@pytest.mark.mpi
def test_facets_of_several_boundaries() -> None:
    """A facet counts for every boundary that has it."""
    mesh = blocks.block("b", blocks.graded(0, 2, 5, 1.0), blocks.graded(0, 1, 3))
    top, bottom = (mesh.boundaries[name] for name in ("b_top", "b_bottom"))
    mesh = replace(mesh, boundaries={"both": np.vstack([top, bottom]), "part": top[2:], **{
        "b_top": top, "b_bottom": bottom
    }})  # fmt: skip
    body = ElasticBody(MPI.COMM_WORLD, mesh if MPI.COMM_WORLD.rank == 0 else None, STEEL, 2)
    replace_meshes(body.mesh)
    for name, length in {"both": 4.0, "part": 1.2, "b_top": 2.0, "b_bottom": 2.0}.items():
        load = Traction("p", name, (1.0, 0.0))
        assert resultant(body, load)[0] == pytest.approx(length)
        nodes = body.boundary_nodes(name)
        own = np.count_nonzero(nodes < body.space.dofmap.index_map.size_local)
        found = MPI.COMM_WORLD.allreduce(own)
        assert found == {"both": 22, "part": 7, "b_top": 11, "b_bottom": 11}[name]


def resultant(body: ElasticBody, load: SpreadLoad) -> Array:
    """(3,) force and moment about the origin of a unit of a load."""
    forces = body.load_vector(load).array.reshape(-1, 2)
    x, y = body.space.tabulate_dof_coordinates()[: len(forces), :2].T
    own = np.array([*forces.sum(axis=0), (x * forces[:, 1] - y * forces[:, 0]).sum()])
    return np.asarray(MPI.COMM_WORLD.allreduce(own))


@pytest.mark.mpi
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("direction", [(), (0.6, 0.8)], ids=["normal", "vector"])
def test_linear_pressure(degree: int, direction: tuple[float, ...]) -> None:
    """Between 1 at x = 0 and 4 at x = 2: the force is 5, at x = 1.2."""
    given = PointValues(np.array([[0.0, 7.0], [2.0, 7.0]]), np.array([1.0, 4.0]))
    load = Traction("p", "b_top", direction, given)
    force = 5.0 * np.array(direction or (0.0, 1.0))
    expected = [*force, 1.2 * force[1] - force[0]]
    np.testing.assert_allclose(resultant(elastic_block(degree), load), expected, atol=1e-12)


@pytest.mark.mpi
def test_points_all_over_a_boundary() -> None:
    points = np.stack(np.meshgrid([0.0, 1.0, 2.0], [0.0, 0.5, 1.0]), axis=-1).reshape(-1, 2)
    given = PointValues(points, 3.0 - points[:, 0])
    load = Traction("p", "b_bottom", factors=given)
    # 4 downwards, at x = (3 * 2 - 8/3)/4
    expected = [0.0, -4.0, -(6 - 8 / 3)]
    np.testing.assert_allclose(resultant(elastic_block(2), load), expected, atol=1e-9)


@pytest.mark.mpi
@pytest.mark.parametrize("degree", [1, 2])
def test_a_force_on_a_boundary_or_a_part_of_it(degree: int) -> None:
    """On the top of length 2 of a block of height 1."""
    body = elastic_block(degree)
    whole = Force("f", "b_top", (0.6, 0.8))
    expected = [0.6, 0.8, 1.0 * 0.8 - 1.0 * 0.6]
    np.testing.assert_allclose(resultant(body, whole), expected, atol=1e-12)
    part = Force("f", "b_top", (0.6, 0.8), (1.3, 1.0), radius=0.4)
    x, y, moment = resultant(elastic_block(degree, columns=20), part)
    np.testing.assert_allclose([x, y], [0.6, 0.8], atol=1e-12)
    assert moment == pytest.approx(1.3 * 0.8 - 0.6, abs=0.01)


@pytest.mark.mpi
@pytest.mark.parametrize("part", [False, True])
def test_a_force_through_a_point(part: bool) -> None:
    """The moment is that about the point; through the middle it is the even one."""
    around: dict[str, Any] = {"centre": (1.3, 1.0), "radius": 0.4} if part else {}
    body = elastic_block(2)
    load = Force("f", "b_top", (0.6, 0.8), through=(0.3, 2.5), **around)
    expected = [0.6, 0.8, 0.3 * 0.8 - 2.5 * 0.6]
    np.testing.assert_allclose(resultant(body, load), expected, atol=1e-12)
    if not part:
        even, middle = Force("f", "b_top", (0.6, 0.8)), replace(load, through=(1.0, 1.0))
        forces = [body.load_vector(each).array for each in (even, middle)]
        np.testing.assert_allclose(forces[1], forces[0], atol=1e-14)


def test_a_force_through_a_point_of_a_solid() -> None:
    """On both ends of a bent surface, force and moment about the point in space."""
    plane = Mesh({"b": blocks.block("b", np.linspace(0, 2, 4), np.linspace(0, 1, 3))})
    mesh = extrude(plane, Solid(length=0.4, layers=2)).bodies["b"]
    names = [each for each in mesh.boundaries if each in ("b_top", "b_right")]
    both = np.vstack([mesh.boundaries[name] for name in names])
    mesh = replace(mesh, boundaries={**mesh.boundaries, "both": both})
    body = ElasticBody(MPI.COMM_WORLD, mesh, STEEL, 2)
    replace_meshes(body.mesh)
    point, force = np.array([0.3, 2.5, -0.7]), np.array([0.48, -0.6, 0.64])
    for name in ("b_top", "both"):
        load = Force("f", name, tuple(force), through=tuple(point))
        nodal = body.load_vector(load).array.reshape(-1, 3)
        places = body.space.tabulate_dof_coordinates()
        np.testing.assert_allclose(nodal.sum(axis=0), force, atol=1e-12)
        np.testing.assert_allclose(np.cross(places - point, nodal).sum(axis=0), 0, atol=1e-12)


@pytest.mark.mpi
def test_acceleration_acts_on_the_mass() -> None:
    load = Acceleration("g", (0.6, -0.8))
    force = STEEL.density * 2.0 * np.array([0.6, -0.8])
    expected = [*force, 1.0 * force[1] - 0.5 * force[0]]
    np.testing.assert_allclose(resultant(elastic_block(2), load), expected, atol=1e-12)


@pytest.mark.parametrize("solid", [False, True], ids=["plane", "solid"])
def test_stacked_blocks_carry_their_weight(solid: bool) -> None:
    """p = density * g * height of the upper block, everywhere; the lower one has ten times that."""
    steel = {"young": 1000.0, "poisson": 0.3, "density": 0.5}
    upper = blocks.block("upper", np.linspace(0, 1, 4), np.linspace(0, 0.6, 3))
    lower = blocks.block("lower", np.linspace(0, 1, 6), np.linspace(-0.5, 0, 3))
    meshes = {"upper": upper, "lower": lower}
    if solid:
        meshes = extrude(Mesh(meshes), Solid(length=0.4, layers=2)).bodies
    data: dict[str, Any] = {
        "bodies": {"upper": steel, "lower": steel},
        "contacts": {
            "main": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.3}
        },
        "supports": {
            "base": {"boundary": "lower_bottom", "fix": ["y"]},
            **{
                f"{name}_{side}": {"boundary": f"{name}_{side}", "fix": ["x"]}
                for name in ("upper", "lower")
                for side in ("left", "right")
            },
        },
        "loads": {
            "gravity": {
                "type": "acceleration",
                "direction": [0, -2, 0] if solid else [0, -2],
                "history": [{"ramp": 9.81, "until": 1.0, "steps": 2}],
            }
        },
    }
    if solid:
        ends = [f"{name}_{end}" for name in meshes for end in ("back", "front")]
        data["supports"] |= {end: {"boundary": end, "fix": ["z"]} for end in ends}
    found = run(data, *meshes.values())
    pressure = 0.5 * 9.81 * 0.6
    np.testing.assert_allclose(found.tractions[-1][:, 0], pressure, rtol=1e-9)
    np.testing.assert_allclose(found.tractions[-1][:, 1:], 0.0, atol=1e-9 * pressure)


@pytest.mark.parametrize("solid", [False, True], ids=["plane", "solid"])
def test_no_edge_factor_of_a_bar_that_hangs(solid: bool) -> None:
    """s_xx = -b x alone: no traction on the surfaces, nothing singular, but a body force b."""
    per_length = 5 if solid else 10
    span = np.linspace(-1, 1, 2 * per_length + 1)
    depth = np.linspace(0, 0.8, 4 * per_length // 5 + 1)
    poisson, young = STEEL.poisson, STEEL.young
    if not solid:
        young, poisson = young / (1 - poisson**2), poisson / (1 - poisson)
    load = Acceleration("g", (1.0, 0.0, 0.0)[: 3 if solid else 2])
    frame = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    if solid:
        tip, tube = Tip(np.array([-0.5, 0.0, 1.0]), frame, 2.0), Tube(0.35, 0.45)
    else:
        tip, tube = Tip(np.array([0.03, 0.0]), frame[:2, :2]), Tube(0.5)
    size = 3 if solid else 2
    by_displacement, by_load = np.zeros((2, size))
    for upper, side in ((True, "bottom"), (False, "top")):
        plane = blocks.block("b", span, depth - (not upper) * 0.8, cell="triangle")
        mesh = (
            extrude(Mesh({"b": plane}), Solid(length=2.0, layers=10)).bodies["b"]
            if solid
            else plane
        )
        elastic = ElasticBody(MPI.COMM_SELF, mesh, STEEL, 2)
        form = InteractionForm(elastic, [f"b_{side}"], upper, [load])
        x, *across = elastic.space.tabulate_dof_coordinates()[:, :size].T
        bent = (x**2 + poisson * sum(y**2 for y in across)) / 2
        own = np.stack([-bent, *(poisson * x * y for y in across)], axis=1)
        own *= STEEL.density / young
        by_displacement += form.products(tip, [tube], own[:, :, None])[0][:, 0]
        by_load += form.load_products(tip, [tube])[0][:, 0]
    largest = np.abs(by_load).max()
    assert largest > 1e-4
    assert (np.abs(by_displacement + by_load) < (0.025 if solid else 5e-3) * largest).all()
