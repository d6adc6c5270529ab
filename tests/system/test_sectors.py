# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors of a disc: sides that follow each other, against closed forms and the whole ring."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks, sectors
from cases.contact_runs import Run, run
from cases.pad_cases import as_field
from scipy import sparse
from scipy.spatial import cKDTree

from fretfe._typing import Array
from fretfe.bodies.constraints import Constraint
from fretfe.bodies.cyclic import Tie, tie_sides
from fretfe.bodies.definition import ModelDefinition, define_model
from fretfe.bodies.loads.spread import Rotation
from fretfe.case import Case, Solid, Symmetry
from fretfe.contact.interface import Coordinate
from fretfe.fem import model as fem_model
from fretfe.fem._compat import MPI
from fretfe.fem.condensation import Body
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.timing import Clock
from fretfe.materials.material import Material
from fretfe.mesh.elements import quadrature, shape_values
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.make import mesh_template
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.mesh.templates import find_template
from fretfe.surface.surface import boundary_surface, normal_vectors


def tie(mesh: BodyMesh, count: int, degree: int = 2, **keys: Any) -> Tie:
    names = (f"{mesh.name}_bottom", f"{mesh.name}_top")
    table = {"type": "cyclic", "boundary1": names[0], "boundary2": names[1], "sectors": count}
    symmetry = Symmetry.model_validate({"centre": (0, 0), **table, **keys})
    return tie_sides(symmetry, ("symmetry", "s"), Path("case.toml"), mesh, degree)


def annulus_error(count: int, shift: float = 0.0) -> float:
    """Relative error of the hoop stress at the bore of a spinning annulus, in plane stress.

    The nodes of one side are shifted along it, by parts of an element.
    sigma = (rho w^2/4) ((3 + nu) b^2 + (1 - nu) a^2) (Timoshenko & Goodier, art. 32).
    """
    a, b, nu = 1.0, 2.0, 0.3

    def mapping(points: Array) -> Array:
        radius, angle = points.T
        away = np.sin(np.pi * (radius - a) / (b - a)) * (angle + 20) / 40
        return sectors.polar(np.column_stack([radius + shift * (b - a) / count * away, angle]))

    radii = a + (b - a) * np.linspace(0, 1, count + 1) ** 1.5
    mesh = blocks.block("disc", radii, np.linspace(-20, 20, 9), order=2, mapping=mapping)
    elastic = ElasticBody(
        MPI.COMM_WORLD, mesh if MPI.COMM_WORLD.rank == 0 else None,
        Material(200.0, nu, 1.0, "stress"), 2,
    )  # fmt: skip
    sides = tie(mesh, 9)
    hold = Constraint(
        "hold",
        "disc_bottom",
        tuple(sides.tangential(sides.leaders[:1])[0]),
        roller=True,
        at=tuple(sides.leaders[0]),
        within=1e-6,
    )
    points = boundary_surface(mesh, "disc_left").displacement_points(2)
    operator = sparse.eye(points.size, format="csr")
    load = Rotation("spin", (0.0, 0.0, 1.0), (0.0, 0.0))
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


def test_sides_whose_nodes_are_no_images() -> None:
    """The stress next to them is as good as elsewhere."""
    coarse, fine = (annulus_error(n, 0.4) for n in (10, 20))
    assert fine < 1e-4
    assert coarse / fine > 6


def warped(mesh: BodyMesh) -> BodyMesh:
    """A sector of the ring whose nodes at one side are moved along it, but for its ends."""
    points = mesh.points.copy()
    radius, angle = np.hypot(*points[:, :2].T), np.degrees(np.arctan2(points[:, 1], points[:, 0]))
    inside = (radius - sectors.BORE) / (sectors.OUTSIDE - sectors.BORE)
    weight = 0.05 * (angle + 45) / 90
    points[:, :2] *= (1 + weight * np.sin(np.pi * inside) / radius)[:, None]
    if points.shape[1] == 3:
        height = points[:, 2] / np.ptp(points[:, 2])
        points[:, 2] += weight * np.sin(np.pi * height) * (1 + inside)
    return replace(mesh, points=points)


def traction_forces(mesh: BodyMesh, name: str, degree: int) -> Array:
    """(n, d) forces at the nodes of a side by a unit traction along x."""
    side = boundary_surface(mesh, name)
    at, weights = quadrature(side.shape, 6)
    sizes = np.linalg.norm(normal_vectors(side.nodes, side.shape, side.degree, at), axis=2)
    forces = np.einsum("q,fq,qk->fk", weights, sizes, shape_values(side.shape, degree, at))
    total = np.zeros(side.displacement_points(degree).shape)
    np.add.at(total[:, 0], side.displacement_facets(degree), forces)
    return total


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("solid", [False, True], ids=["plane", "solid"])
def test_sides_of_other_nodes_stretch_and_pull_alike(solid: bool, cell: str) -> None:
    mesh = sectors.ring(order=1 if solid else 2, cell=cell)
    axis: dict[str, Any] = {}
    if solid:
        mesh = extrude(Mesh({"ring": mesh}), Solid(length=0.4, layers=4)).bodies["ring"]
        axis = {"centre": (0, 0, 0), "axis": (0, 0, 1)}
    mesh = warped(mesh)
    sides = tie(mesh, sectors.SECTORS, **axis)
    other = {"ring_top": "ring_bottom", "ring_bottom": "ring_top"}[sides.source]
    assert sides.weights.nnz > 2 * len(sides.followers)
    gradient = np.arange(sides.turn.size).reshape(sides.turn.shape) / 10
    straight = (sides.followers @ sides.turn) @ gradient @ sides.turn.T
    np.testing.assert_allclose(sides.image(sides.leaders @ gradient), straight, atol=1e-12)
    pulled, pulling = (traction_forces(mesh, name, 2) for name in (sides.source, other))
    passed = sides.passed_on(pulling @ sides.turn.T)
    # Products of functions are no polynomials in hexahedra.
    exact = 1e-5 if solid and cell == "quadrilateral" else 1e-12
    np.testing.assert_allclose(passed, pulled, atol=exact * pulled.max())


def whole_ring(one: Sequence[BodyMesh], name: str = "ring") -> list[BodyMesh]:
    """All sectors in one body, and their blocks, from a sector and its block."""
    steps = [(str(i), i * 360 / sectors.SECTORS) for i in range(sectors.SECTORS)]
    parts, pads = (
        [sectors.turned(mesh, angle, f"{mesh.name}{i}", i) for i, angle in steps] for mesh in one
    )
    return [sectors.joined(parts, name), *pads]


def held_as(sector: Run, ring: str = "ring") -> Callable[[Case, Mesh], ModelDefinition]:
    """Define models whose ring is held as a sector is, at the same places of all of them."""

    def define(case: Case, mesh: Mesh) -> ModelDefinition:
        definition = define_model(case, mesh)
        (hold,) = (c for c in sector.model.body_definition(ring).constraints if c.at)
        sides = sector.model.body_definition(ring).tie
        assert sides is not None
        turn, holds = np.linalg.inv(sides.turn) if first_turns_back(sides) else sides.turn, []
        at, way = np.array(hold.at), np.array(hold.direction)
        for number in range(sectors.SECTORS):
            name = f"{hold.boundary}{number}"
            holds.append(
                replace(hold, label=name, boundary=name, at=tuple(at), direction=tuple(way))
            )
            at, way = turn @ at, turn @ way
        coordinates = [Coordinate(each.label, ring, "fixed", "") for each in holds]
        bodies = [
            replace(
                body,
                constraints=(*body.constraints, *holds),
                coordinates=(*body.coordinates, *coordinates),
            )
            if body.name == ring
            else body
            for body in definition.bodies
        ]
        return replace(definition, bodies=tuple(bodies))

    return define


def first_turns_back(sides: Tie) -> bool:
    """True if the side that leads is ahead of the one that follows."""
    return bool(sides.turn[1, 0] < 0)


def one_sector(angle: float = 0.0) -> Run:
    meshes = (sectors.turned(each, angle) for each in (sectors.ring(), sectors.pad()))
    return run(sectors.spinning(1, symmetry=sectors.cyclic()), *meshes)


C, S = np.cos(0.4), np.sin(0.4)
# The axis becomes (c, s, 0). Tangents of curved surfaces, from n × z or others, turn with it.
TILT = np.array([[C, -S, 0.0], [S, C, 0.0], [0.0, 0.0, 1.0]]) @ np.eye(3)[[2, 0, 1]]


def solids() -> list[BodyMesh]:
    """The sector and its block as solids."""
    plane = {"ring": sectors.ring(), "pad": sectors.pad()}
    return list(extrude(Mesh(plane), Solid(length=0.5, layers=1)).bodies.values())


def one_solid_sector(turn: Array | None = None) -> Run:
    turn = np.eye(3) if turn is None else turn
    axis = turn[:, 2].tolist()
    back = {"direction": axis}
    meshes = [replace(each, points=each.points @ turn.T) for each in solids()]
    case = sectors.spinning(
        1,
        axis,
        symmetry=sectors.cyclic(axis=axis, centre=[0, 0, 0]),
        supports={
            "ring": {"boundary": "ring_back", **back},
            "pad": {"boundary": "pad_back", **back},
        },
    )
    return run(case, *meshes)


def assert_same(found: Array, expected: Array) -> None:
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max(), rtol=0)


@pytest.mark.mpi
def test_a_sector_is_the_whole_ring(monkeypatch: pytest.MonkeyPatch) -> None:
    one = one_sector()
    monkeypatch.setattr(fem_model, "held_model", held_as(one))
    parts = whole_ring([sectors.ring(), sectors.pad()])
    ring = run(sectors.spinning(sectors.SECTORS), *parts)
    for part in np.split(ring.tractions, sectors.SECTORS, axis=1):
        assert_same(part, one.tractions)


@pytest.mark.slow
@pytest.mark.mpi
def test_a_solid_sector_is_the_whole_ring(monkeypatch: pytest.MonkeyPatch) -> None:
    one = one_solid_sector()
    monkeypatch.setattr(fem_model, "held_model", held_as(one))
    backs = [f"{name}_back{i}" for name in ("ring", "pad") for i in range(sectors.SECTORS)]
    supports = {each: {"boundary": each, "fix": ["z"]} for each in backs}
    case = sectors.spinning(sectors.SECTORS, [0, 0, 1], supports=supports)
    ring = run(case, *whole_ring(solids()))
    # The frames of the surfaces of solids do not turn with the sectors: sizes are compared.
    sizes = [np.linalg.norm(each[..., 1:], axis=2) for each in (ring.tractions, one.tractions)]
    for part, shear in zip(
        *(np.split(each, sectors.SECTORS, axis=1) for each in (ring.tractions, sizes[0])),
        strict=True,
    ):
        assert_same(part[..., 0], one.tractions[..., 0])
        np.testing.assert_allclose(shear, sizes[1], atol=1e-9 * np.abs(one.tractions).max())


def test_a_solid_sector_about_any_axis() -> None:
    straight, tilted = one_solid_sector(), one_solid_sector(TILT)
    assert_same(tilted.tractions[..., 0], straight.tractions[..., 0])
    shear = [np.linalg.norm(each.tractions[..., 1:], axis=2) for each in (tilted, straight)]
    assert np.abs(shear[0] - shear[1]).max() < 1e-9 * np.abs(straight.tractions).max()


def test_a_turned_sector_has_the_same_tractions() -> None:
    assert_same(one_sector(31.0).tractions, one_sector().tractions)


def test_temperatures_of_another_run_in_a_sector(tmp_path: Path) -> None:
    """Hot everywhere: as by the value, next to the spin that presses the block on."""
    warm = {**sectors.STEEL, "expansion": 1e-3, "reference_temperature": 0.0}
    heat = {"type": "temperature", "value": 40.0, "history": sectors.ramp(1.0)}
    field = as_field(heat, tmp_path, 2.0, lambda x, y: 40.0)
    case = sectors.spinning(1, symmetry=sectors.cyclic())
    case["bodies"] = {"ring": warm, "pad": {**warm, "expansion": 2e-3}}
    spin = case["loads"]
    found = []
    for loads in (spin, {**spin, "heat": heat}, {**spin, "heat": field}):
        found.append(run({**case, "loads": loads}, sectors.ring(), sectors.pad()).tractions)
    assert_same(found[2], found[1])
    assert np.abs(found[1] - found[0]).max() > 0.01 * np.abs(found[0]).max()


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


@pytest.mark.slow
def test_a_firtree_in_a_sector_is_the_whole_disc(monkeypatch: pytest.MonkeyPatch) -> None:
    shape = {"lobes": 2, "sectors": sectors.SECTORS, "pitch_radius": 60.0}
    sizes = {"edge_size": 0.06, "flank_size": 0.2, "growth": 0.5}
    made = mesh_template(find_template("firtree"), shape | sizes, 2)
    meshes = [
        replace(made.bodies[name], points=made.bodies[name].points + np.array([0.0, 60.0]))
        for name in ("disc", "blade")
    ]
    one = run(firtrees(("",)), *meshes)
    monkeypatch.setattr(fem_model, "held_model", held_as(one, "disc"))
    numbers = tuple(str(i) for i in range(sectors.SECTORS))
    ring = run(firtrees(numbers), *whole_ring(meshes, "disc"))
    for part in np.split(ring.tractions, sectors.SECTORS, axis=1):
        assert_same(part, one.tractions)


def firtrees(numbers: Sequence[str]) -> dict[str, Any]:
    """The case of blades in one disc; of one blade without a number it is a sector."""
    flanks = [f"{side}_{lobe}" for lobe in (1, 2) for side in ("left", "right")]
    sides = {"boundary1": "disc_side_left", "boundary2": "disc_side_right"}
    symmetry = {"disc": {"type": "cyclic", **sides, "sectors": sectors.SECTORS, "centre": [0, 0]}}
    return {
        "bodies": {name: sectors.STEEL for name in ("disc", *(f"blade{n}" for n in numbers))},
        "contacts": {
            f"{flank}{number}": {
                "surface1": f"blade_flank_{flank}{number}",
                "surface2": f"disc_flank_{flank}{number}",
                "friction": 0.4,
            }
            for number in numbers
            for flank in flanks
        },
        "loads": {"spin": {"type": "rotation", "centre": [0, 0], "history": sectors.ramp(0.003)}},
        **({"symmetry": symmetry} if numbers == ("",) else {}),
    }


def test_a_support_carries_a_torque() -> None:
    """Of a force of 0.01 on the outside by the bore of the ring, where the block does not press."""
    ring = sectors.ring()
    whole = blocks.block("ring", np.linspace(1.0, 1.4, 4), sectors.ANGLES, order=2)
    free = [
        facet for facet in whole.boundaries["ring_left"]
        if not (ring.boundaries["ring_seat"] == facet).all(axis=1).any()
    ]  # fmt: skip
    ring = replace(ring, boundaries={**ring.boundaries, "ring_bore": np.array(free)})
    case = sectors.spinning(1, symmetry=sectors.cyclic())
    case["supports"] = {"hub": {"boundary": "ring_bore", "fix": ["tangential"]}}
    case["loads"]["gas"] = {
        "type": "force", "boundary": "ring_right", "direction": "y", "history": sectors.ramp(0.01)
    }  # fmt: skip
    found = run(case, ring, sectors.pad())
    if found.results:  # on rank 0
        middle = sectors.OUTSIDE * np.sin(np.pi / 4) / (np.pi / 4)
        # The traction is even on the quadratic facets, whose length is that of the arc to 1e-6.
        assert found.forces["hub tangential"][-1] == pytest.approx(-0.01 * middle, rel=1e-5)
