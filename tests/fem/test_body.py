# SPDX-License-Identifier: LGPL-3.0-or-later
"""Condensed bodies: rigid motions, equilibrium, dense algebra and uniform stress as judges."""

from __future__ import annotations

from collections.abc import Sequence

import blocks
import numpy as np
import pytest
from petsc_garbage import replace_meshes

from fretfe._typing import Array
from fretfe.bodies.body import Constraint, DistributedLoad, Material
from fretfe.bodies.rigid_modes import rigid_motions
from fretfe.fem._compat import MPI
from fretfe.fem.condensation import Body, CondensedBody
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.timing import Clock
from fretfe.mesh.mesh import BodyMesh
from fretfe.surface.surface import build_surface

pytestmark = pytest.mark.mpi


STEEL = Material(200.0, 0.3, 2.5, "strain")
LENGTH, HEIGHT = 1.5, 1.0
LINES = blocks.graded(0.0, LENGTH, 5), blocks.graded(0.0, HEIGHT, 4)
ELEMENTS = pytest.mark.parametrize(
    ("cell", "degree"),
    [("triangle", 1), ("triangle", 2), ("quadrilateral", 1), ("quadrilateral", 2)],
)


def wavy(points: Array) -> Array:
    """Straight sides; interior nodes, and with them curved edges, moved."""
    x, y = points.T / np.array([[LENGTH], [HEIGHT]])
    bubble = np.sin(np.pi * x) * np.sin(np.pi * y)
    return points + 0.05 * np.stack([bubble, -bubble * x], axis=1)


def make_body(
    mesh: BodyMesh,
    constraints: Sequence[Constraint] = (),
    loads: Sequence[DistributedLoad] = (),
    *,
    degree: int = 2,
    material: Material = STEEL,
    surface: str = "b_bottom",
) -> tuple[Body, Array]:
    """A body that all ranks share, and the points of its contact surface."""
    elastic = ElasticBody(
        MPI.COMM_WORLD, mesh if MPI.COMM_WORLD.rank == 0 else None, material, degree
    )
    replace_meshes(elastic.mesh)
    points = build_surface(mesh, surface).displacement_points(degree)
    return Body(elastic, list(constraints), list(loads), points, Clock()), points


def condensed(body: Body) -> CondensedBody:
    """The result of rank 0, on every rank."""
    result: CondensedBody = MPI.COMM_WORLD.bcast(body.condensed)
    return result


def rectangle(cell: str = "triangle", order: int = 1) -> BodyMesh:
    return blocks.block("b", *LINES, cell=cell, order=order)


LEFT_X = Constraint("left x", "b_left", (1.0, 0.0))
LEFT_Y = Constraint("left y", "b_left", (0.0, 1.0))
TOP_X = Constraint("top x", "b_top", (1.0, 0.0))
TOP_Y = Constraint("top y", "b_top", (0.0, 1.0))
RIGHT_Y = Constraint("right y", "b_right", (0.0, 1.0))
SLANT = Constraint("top along", "b_top", (0.6, 0.8))
ACROSS = Constraint("top across", "b_top", (-0.8, 0.6))


@ELEMENTS
@pytest.mark.parametrize("order", [1, 2])
def test_rigid_motions_of_a_free_body_need_no_force(order: int, cell: str, degree: int) -> None:
    body, points = make_body(rectangle(cell, order), degree=degree)
    result = condensed(body)
    rigid = rigid_motions(points).reshape(-1, 3)
    largest = np.abs(result.stiffness).max()
    np.testing.assert_allclose(result.stiffness @ rigid, 0.0, atol=1e-12 * largest)
    assert result.modes.shape == (2 * len(points), 3)
    np.testing.assert_allclose(result.modes.T @ result.modes, np.eye(3), atol=1e-13)
    within = result.modes @ (result.modes.T @ rigid)
    np.testing.assert_allclose(within, rigid, atol=1e-13)
    # Nothing else is free: the next eigenvalue is one of elasticity.
    assert np.linalg.eigvalsh(result.stiffness)[3] > 1e-3 * largest


@pytest.mark.parametrize(
    ("constraints", "count"),
    [
        ((), 3),
        ((LEFT_X,), 1),  # y
        ((LEFT_Y,), 2),  # x, and rotation about a point on the side
        ((TOP_Y,), 1),  # x
        ((SLANT,), 0),  # a fixed direction fixes both components of its boundary
        ((LEFT_Y, RIGHT_Y), 1),  # x
        ((LEFT_X, TOP_Y), 0),
        ((TOP_X, TOP_Y), 0),
    ],
    ids=["nothing", "left x", "left y", "top y", "slant", "both y", "left x, top y", "platen"],
)
def test_free_modes_are_those_that_no_constraint_prevents(
    constraints: tuple[Constraint, ...], count: int
) -> None:
    result = condensed(make_body(rectangle(), constraints)[0])
    largest = np.abs(result.stiffness).max()
    assert result.modes.shape[1] == count
    # Motions that move no constrained node: no force there either.
    np.testing.assert_allclose(result.stiffness @ result.modes, 0.0, atol=1e-12 * largest)
    np.testing.assert_allclose(result.coupling.T @ result.modes, 0.0, atol=1e-12 * largest)
    eigenvalues = np.linalg.eigvalsh(result.stiffness)
    assert np.count_nonzero(eigenvalues < 1e-9 * eigenvalues[-1]) == count


@ELEMENTS
def test_translation_with_all_constraints_needs_no_force(cell: str, degree: int) -> None:
    constraints = (SLANT, ACROSS, LEFT_X, LEFT_Y)
    body, points = make_body(rectangle(cell), constraints, degree=degree)
    result = condensed(body)
    shift = np.array([0.3, -0.7])
    u = np.tile(shift, len(points))
    c = np.array([shift @ np.array(k.direction) for k in constraints])
    tolerance = 1e-12 * np.abs(result.stiffness).max()
    # The corner of the contact surface on the left side follows that side.
    held = np.any(result.prescribed != 0, axis=1)
    np.testing.assert_array_equal(np.flatnonzero(held), [0, 1])
    np.testing.assert_allclose((result.prescribed @ c)[held], shift, atol=1e-15)
    u[held] = 0.0
    np.testing.assert_allclose(result.stiffness @ u + result.coupling @ c, 0, atol=tolerance)
    reaction = result.coupling.T @ u + result.coordinate_stiffness @ c
    np.testing.assert_allclose(reaction, 0, atol=tolerance)
    np.testing.assert_array_equal(result.coordinate_stiffness, result.coordinate_stiffness.T)


LOADS = (
    DistributedLoad("pull", "traction", "b_right", (0.6, -0.8)),
    DistributedLoad("swell", "normal", "b_left"),
    DistributedLoad("spin", "rotation", centre=(0.25, -2.0)),
    DistributedLoad("elsewhere", "traction", "another_body", (1.0, 0.0)),
)
AREA = LENGTH * HEIGHT
# Force and moment about the origin of each load, by hand.
RESULTANTS = np.array(
    [
        [0.6 * HEIGHT, -0.8 * HEIGHT, -0.8 * HEIGHT * LENGTH - 0.6 * HEIGHT**2 / 2],
        [-HEIGHT, 0.0, HEIGHT**2 / 2],
        [
            2.5 * AREA * (LENGTH / 2 - 0.25),
            2.5 * AREA * (HEIGHT / 2 + 2.0),
            # (x, y) x ((x, y) - centre) integrated: only the centre's arm remains.
            2.5 * AREA * (LENGTH / 2 * 2.0 + HEIGHT / 2 * 0.25),
        ],
        [0.0, 0.0, 0.0],
    ]
).T


@ELEMENTS
def test_condensed_loads_have_the_force_and_moment_of_the_loads(cell: str, degree: int) -> None:
    body, points = make_body(rectangle(cell), loads=LOADS, degree=degree)
    result = condensed(body)
    rigid = rigid_motions(points).reshape(-1, 3)
    # Loads are polynomials that the quadrature integrates exactly.
    np.testing.assert_allclose(rigid.T @ result.surface_loads, RESULTANTS, atol=1e-11)
    np.testing.assert_allclose(result.load_resultants, RESULTANTS[:2], atol=1e-12)


def test_loads_on_constrained_bodies_are_shared_with_the_constraints() -> None:
    constraints = (SLANT, ACROSS)
    result = condensed(make_body(rectangle(), constraints, LOADS)[0])
    directions = np.array([k.direction for k in constraints])
    surface = result.surface_loads.reshape(-1, 2, len(LOADS)).sum(axis=0)
    np.testing.assert_allclose(
        surface + directions.T @ result.coordinate_loads, RESULTANTS[:2], atol=1e-11
    )


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_normal_load_on_a_closed_boundary_has_no_resultant(cell: str) -> None:
    loads = [DistributedLoad(s, "normal", f"b_{s}") for s in ("bottom", "right", "top", "left")]
    mesh = blocks.block("b", *LINES, cell=cell, order=2, mapping=lambda p: wavy(2 * p) + p)
    result = condensed(make_body(mesh, loads=loads)[0])
    np.testing.assert_allclose(result.load_resultants.sum(axis=1), 0.0, atol=1e-12)


class DenseJudge:
    """A condensed body by dense algebra, on one rank; constraints as (nodes, direction)."""

    def __init__(
        self, elastic: ElasticBody, sides: Sequence[tuple[Array, Constraint]], points: Array
    ) -> None:
        x = elastic.space.tabulate_dof_coordinates()[:, :2]
        shapes = np.zeros((len(sides), *x.shape))
        for shape, (nodes, constraint) in zip(shapes, sides, strict=True):
            shape[nodes] = constraint.direction
        shapes = shapes.reshape(len(sides), -1).T
        held = np.any(shapes != 0, axis=1)
        nodes = np.linalg.norm(x[None] - points[:, None], axis=2).argmin(axis=1)
        retained = (nodes[:, None] * 2 + np.arange(2)).ravel()
        self.prescribed = shapes[retained]
        surface = np.zeros((x.size, len(retained)))
        surface[retained, np.arange(len(retained))] = ~held[retained]
        self.stiffness = self._dense(elastic)
        self.basis = np.hstack([surface, shapes])
        inner = np.setdiff1d(np.flatnonzero(~held), retained)
        self.basis[inner] = -np.linalg.solve(
            self.stiffness[np.ix_(inner, inner)], self.stiffness[inner] @ self.basis
        )
        self.free = ~held[retained]

    @staticmethod
    def _dense(elastic: ElasticBody) -> Array:
        pointers, columns, values = elastic.stiffness(np.empty(0, np.int32)).getValuesCSR()
        size = len(pointers) - 1
        full = np.zeros((size, size))
        full[np.repeat(np.arange(size), np.diff(pointers)), columns] = values
        return full

    @property
    def condensed(self) -> Array:
        return self.basis.T @ self.stiffness @ self.basis


@pytest.mark.skipif(MPI.COMM_WORLD.size > 1, reason="the dense judge needs the whole matrix")
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("surface", ["b_right", "b_bottom"])
@pytest.mark.parametrize("support_first", [False, True])
def test_condensation_is_that_of_dense_algebra(
    support_first: bool, surface: str, cell: str
) -> None:
    """Slanted platen, support and contact surface share corner nodes; the first one holds them."""
    platen, support = [SLANT, ACROSS], [LEFT_X, LEFT_Y]
    constraints = support + platen if support_first else platen + support
    body, points = make_body(rectangle(cell), constraints, LOADS, surface=surface)
    result = condensed(body)
    x = body.elastic.space.tabulate_dof_coordinates()
    top, left = np.isclose(x[:, 1], HEIGHT), np.isclose(x[:, 0], 0.0)
    first, second = (left, top & ~left) if support_first else (top, left & ~top)
    sides = list(zip([first, first, second, second], constraints, strict=True))
    judge = DenseJudge(body.elastic, sides, points)
    loads = judge.basis.T @ np.array([body.elastic.load_vector(load).array for load in LOADS]).T
    n, expected = 2 * len(points), judge.condensed
    close = {"rtol": 0, "atol": 1e-12 * np.abs(expected).max()}
    own = np.ix_(judge.free, judge.free)
    assert not judge.free.all()
    np.testing.assert_array_equal(result.prescribed, judge.prescribed)
    np.testing.assert_allclose(result.stiffness[own], expected[:n, :n][own], **close)
    np.testing.assert_allclose(result.coupling, expected[:n, n:], **close)
    np.testing.assert_allclose(result.coordinate_stiffness, expected[n:, n:], **close)
    np.testing.assert_allclose(result.surface_loads, loads[:n], **close)
    np.testing.assert_allclose(result.coordinate_loads, loads[n:], **close)


def uniform(material: Material, stress: Array) -> Array:
    """(2, 2) displacement gradient (without rotation) of a uniform plane stress tensor."""
    mu, lame = material.shear_modulus, material.first_lame
    trace = np.trace(stress) / (2 * mu + 2 * lame)
    return (stress - lame * trace * np.eye(2)) / (2 * mu)


STRESS = np.array([[3.0, -0.7], [-0.7, -1.9]])
SIDES = (("b_right", (1.0, 0.0)), ("b_top", (0.0, 1.0)), ("b_left", (-1.0, 0.0)))


def side_tractions(stress: Array) -> list[DistributedLoad]:
    """Tractions of a stress on all sides but the contact surface."""
    loads = []
    for side, normal in SIDES:
        traction = stress @ np.array(normal)
        loads.append(DistributedLoad(side, "traction", side, tuple(traction)))
    return loads


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize(
    ("cell", "degree", "order"),
    [
        ("triangle", 1, 1),
        ("triangle", 2, 1),
        ("triangle", 2, 2),
        ("quadrilateral", 1, 1),
        ("quadrilateral", 2, 1),
        ("quadrilateral", 2, 2),
    ],
)
def test_recovery_of_uniform_stress(cell: str, degree: int, order: int, plane: str) -> None:
    """Linear displacements lie in all spaces (curved inner edges if isoparametric): round-off."""
    material = Material(200.0, 0.3, 0.0, plane)
    mesh = blocks.block("b", *LINES, cell=cell, order=order, mapping=wavy)
    loads = side_tractions(STRESS)
    body, points = make_body(mesh, loads=loads, degree=degree, material=material)
    gradient = uniform(material, STRESS) + np.array([[0.0, -0.01], [0.01, 0.0]])
    offset = np.array([0.02, -0.01])
    surface = (points @ gradient.T + offset).ravel()
    field = body.recover(surface, np.empty(0), np.ones(len(loads)))
    x = body.elastic.space.tabulate_dof_coordinates()[:, :2]
    expected = x @ gradient.T + offset
    np.testing.assert_allclose(field.x.array.reshape(-1, 2), expected, rtol=0, atol=1e-14)
    stress = body.elastic.element_stresses(field).reshape(-1, 4)
    across = 0.3 * np.trace(STRESS) if plane == "strain" else 0.0
    expected = np.tile([STRESS[0, 0], STRESS[1, 1], across, STRESS[0, 1]], (len(stress), 1))
    np.testing.assert_allclose(stress, expected, rtol=0, atol=1e-11)


def test_recovery_with_constraints_and_a_shared_corner() -> None:
    """Confined compression by a platen, sides held; the contact surface ends at one of them."""
    constraints = (TOP_X, TOP_Y, LEFT_X)
    load = DistributedLoad("right", "traction", "b_right", (1.0, 0.0))
    body, points = make_body(rectangle(), constraints, [load])
    strain = -0.01
    first_lame, mu = STEEL.first_lame, STEEL.shear_modulus
    side = first_lame * strain
    surface = np.stack([np.zeros(len(points)), strain * points[:, 1]], axis=1)
    coordinates = np.array([0.0, strain * HEIGHT, 0.0])
    field = body.recover(surface.ravel(), coordinates, np.array([side]))
    x = body.elastic.space.tabulate_dof_coordinates()[:, :2]
    expected = np.stack([np.zeros(len(x)), strain * x[:, 1]], axis=1)
    np.testing.assert_allclose(field.x.array.reshape(-1, 2), expected, rtol=0, atol=1e-15)
    # The platen presses with the stress times its width; the left side balances the right one.
    result = condensed(body)
    force = (
        result.coupling.T @ surface.ravel()
        + result.coordinate_stiffness @ coordinates
        - result.coordinate_loads @ [side]
    )
    normal = (first_lame + 2 * mu) * strain
    np.testing.assert_allclose(force[1], normal * LENGTH, rtol=1e-12)
    np.testing.assert_allclose(force[0] + force[2], -side * HEIGHT, rtol=1e-12)


@pytest.mark.parametrize(
    ("plane", "modulus", "contraction"),
    [("strain", 200.0 / (1 - 0.3**2), 0.3 / 0.7), ("stress", 200.0, 0.3)],
)
def test_uniaxial_tension(plane: str, modulus: float, contraction: float) -> None:
    left, right = LEFT_X, Constraint("right x", "b_right", (1.0, 0.0))
    bottom = Constraint("bottom y", "b_bottom", (0.0, 1.0))
    material = Material(200.0, 0.3, 0.0, plane)
    body, points = make_body(rectangle(), (left, right, bottom), surface="b_top", material=material)
    result = condensed(body)
    strain = 1e-3
    c = np.array([0.0, strain * LENGTH, 0.0])
    u = np.linalg.solve(result.stiffness, -result.coupling @ c) + result.prescribed @ c
    expected = np.stack([strain * points[:, 0], np.full(len(points), -contraction * strain)], 1)
    np.testing.assert_allclose(u.reshape(-1, 2), expected, rtol=0, atol=1e-12 * strain)
    force = result.coupling.T @ u + result.coordinate_stiffness @ c
    np.testing.assert_allclose(force[1], modulus * strain * HEIGHT, rtol=1e-11)
