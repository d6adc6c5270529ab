# SPDX-License-Identifier: LGPL-3.0-or-later
"""Condensed bodies: rigid motions, equilibrium, dense algebra and uniform stress as judges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from cases import blocks
from harness.petsc_garbage import replace_meshes
from scipy import sparse
from scipy.spatial import cKDTree

from fretfe._typing import Array
from fretfe.bodies.constraints import Constraint
from fretfe.bodies.loads.spread import Rotation, SpreadLoad, Traction
from fretfe.fem._compat import MPI
from fretfe.fem.condensation import Body, CondensedBody
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.timing import Clock
from fretfe.fields.rigid_motions import rigid_motions
from fretfe.materials.material import Material
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
    loads: Sequence[SpreadLoad] = (),
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
    operator = sparse.identity(points.size, format="csr")
    return Body(elastic, list(constraints), list(loads), points, operator, Clock()), points


def nodal_forces(body: Body, points: Array, traction: Array, surface: str = "b_bottom") -> Array:
    """Nodal forces of a uniform traction on the contact surface, at its points."""
    load = Traction("own", surface, tuple(traction))
    forces = body.elastic.load_vector(load).array.reshape(-1, 2)
    places = body.elastic.space.tabulate_dof_coordinates()[: len(forces), :2]
    found = MPI.COMM_WORLD.allgather((places, forces))
    places, forces = (np.vstack(part) for part in zip(*found, strict=True))
    return np.asarray(forces[cKDTree(places).query(points)[1]].ravel())


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
    modes = result.motion
    np.testing.assert_allclose(modes.T @ modes, np.eye(3), atol=1e-13)
    np.testing.assert_allclose(modes @ (modes.T @ rigid), rigid, atol=1e-12)
    np.testing.assert_array_equal(result.stiffness, 0.0)
    # Forces along a free motion cause nothing else, and balanced ones no mean motion.
    compliance = result.compliance.whole()
    largest = np.abs(compliance).max()
    moved = compliance @ modes
    np.testing.assert_allclose(moved, modes * moved[0, 0] / modes[0, 0], atol=1e-11 * largest)
    # The whole compliance is definite.
    eigenvalues = np.linalg.eigvalsh(compliance)
    assert eigenvalues[0] > 1e-5 * eigenvalues[-1]


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
    driven = len(constraints)
    modes = result.motion[:, driven:]
    assert modes.shape[1] == count
    np.testing.assert_array_equal(result.stiffness[driven:], 0.0)
    # No force on a boundary, and none of the contact surface's, keeps them from moving.
    compliance = result.compliance.whole()
    moved = compliance @ modes
    largest = np.abs(compliance).max()
    np.testing.assert_allclose(moved, modes @ (modes.T @ moved), atol=1e-11 * largest)
    assert np.linalg.matrix_rank(result.stiffness, tol=1e-9) <= driven


@ELEMENTS
def test_translation_with_all_constraints_needs_no_force(cell: str, degree: int) -> None:
    constraints = (SLANT, ACROSS, LEFT_X, LEFT_Y)
    body, points = make_body(rectangle(cell), constraints, degree=degree)
    result = condensed(body)
    shift = np.array([0.3, -0.7])
    c = np.array([shift @ np.array(k.direction) for k in constraints])
    moved = (result.motion @ c).reshape(-1, 2)
    np.testing.assert_allclose(moved, np.tile(shift, (len(points), 1)), atol=1e-13)
    reaction = result.stiffness @ c
    np.testing.assert_allclose(reaction, 0, atol=1e-12 * np.abs(result.stiffness).max())
    np.testing.assert_array_equal(result.stiffness, result.stiffness.T)
    # The corner of the contact surface on the left side follows that side.
    np.testing.assert_array_equal(
        np.flatnonzero(np.all(result.compliance.whole() == 0, axis=1)), [0, 1]
    )


LOADS = (
    Traction("pull", "b_right", (0.6, -0.8)),
    Traction("swell", "b_left"),
    Rotation("spin", (0.0, 0.0, 1.0), (0.25, -2.0)),
    Traction("elsewhere", "another_body", (1.0, 0.0)),
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
    work = (result.motion.T @ rigid).T @ result.coordinate_loads
    np.testing.assert_allclose(work, RESULTANTS, atol=1e-11)
    np.testing.assert_allclose(result.load_resultants, RESULTANTS[:2], atol=1e-12)


def test_loads_on_constrained_bodies_are_taken_by_the_constraints() -> None:
    constraints = (SLANT, ACROSS)
    result = condensed(make_body(rectangle(), constraints, LOADS)[0])
    directions = np.array([k.direction for k in constraints])
    # Nothing pushes on the contact surface: the platen takes all.
    np.testing.assert_allclose(directions.T @ result.coordinate_loads, RESULTANTS[:2], atol=1e-11)


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_normal_load_on_a_closed_boundary_has_no_resultant(cell: str) -> None:
    loads = [Traction(s, f"b_{s}") for s in ("bottom", "right", "top", "left")]
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
    assert not judge.free.all()
    compliance = np.zeros((n, n))
    own = np.ix_(judge.free, judge.free)
    compliance[own] = np.linalg.inv(expected[:n, :n][own])
    coupling, stiffness = expected[:n, n:], expected[n:, n:]
    close = {"rtol": 1e-11, "atol": 1e-12 * np.abs(stiffness).max()}
    motion = judge.prescribed - compliance @ coupling
    small = {"rtol": 0, "atol": 1e-12 * np.abs(compliance).max()}
    np.testing.assert_allclose(result.compliance.whole(), compliance, **small)
    np.testing.assert_allclose(result.motion, motion, rtol=0, atol=1e-12)
    np.testing.assert_allclose(result.loads, compliance @ loads[:n], rtol=0, atol=1e-12)
    condensed_stiffness = stiffness - coupling.T @ compliance @ coupling
    np.testing.assert_allclose(result.stiffness, condensed_stiffness, **close)
    on_coordinates = loads[n:] - coupling.T @ compliance @ loads[:n]
    np.testing.assert_allclose(result.coordinate_loads, on_coordinates, rtol=0, atol=1e-11)


def uniform(material: Material, stress: Array) -> Array:
    """(2, 2) displacement gradient (without rotation) of a uniform plane stress tensor."""
    mu, lame = material.shear_modulus, material.first_lame
    trace = np.trace(stress) / (2 * mu + 2 * lame)
    return (stress - lame * trace * np.eye(2)) / (2 * mu)


STRESS = np.array([[3.0, -0.7], [-0.7, -1.9]])
SIDES = (("b_right", (1.0, 0.0)), ("b_top", (0.0, 1.0)), ("b_left", (-1.0, 0.0)))


def side_tractions(stress: Array) -> list[SpreadLoad]:
    """Tractions of a stress on all sides but the contact surface."""
    return [Traction(side, side, tuple(stress @ np.array(normal))) for side, normal in SIDES]


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize(
    ("cell", "degree", "order"),
    [
        ("triangle", 1, 1),
        ("triangle", 1, 2),
        ("triangle", 2, 1),
        ("triangle", 2, 2),
        ("quadrilateral", 1, 1),
        ("quadrilateral", 1, 2),
        ("quadrilateral", 2, 1),
        ("quadrilateral", 2, 2),
    ],
)
def test_recovery_of_uniform_stress(cell: str, degree: int, order: int, plane: str) -> None:
    """Linear displacements lie in all spaces (inner edges curve with degree 2 alone): round-off."""
    material = Material(200.0, 0.3, 0.0, plane)
    mesh = blocks.block("b", *LINES, cell=cell, order=order, mapping=wavy)
    loads = side_tractions(STRESS)
    body, points = make_body(mesh, loads=loads, degree=degree, material=material)
    gradient = uniform(material, STRESS) + np.array([[0.0, -0.01], [0.01, 0.0]])
    offset = np.array([0.02, -0.01])
    surface = (points @ gradient.T + offset).ravel()
    free = condensed(body).motion.T @ surface
    traction = nodal_forces(body, points, STRESS @ [0.0, -1.0])
    (field,) = body.recover([(traction, free, np.ones(len(loads)))])
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
    load = Traction("right", "b_right", (1.0, 0.0))
    body, points = make_body(rectangle(), constraints, [load])
    strain = -0.01
    first_lame, mu = STEEL.first_lame, STEEL.shear_modulus
    side = first_lame * strain
    normal = (first_lame + 2 * mu) * strain
    traction = nodal_forces(body, points, np.array([0.0, -normal]))
    coordinates = np.array([0.0, strain * HEIGHT, 0.0])
    (field,) = body.recover([(traction, coordinates, np.array([side]))])
    x = body.elastic.space.tabulate_dof_coordinates()[:, :2]
    expected = np.stack([np.zeros(len(x)), strain * x[:, 1]], axis=1)
    np.testing.assert_allclose(field.x.array.reshape(-1, 2), expected, rtol=0, atol=1e-15)
    # The platen presses with the stress times its width; the left side balances the right one.
    result = condensed(body)
    force = (
        result.stiffness @ coordinates
        - result.motion.T @ traction
        - result.coordinate_loads @ [side]
    )
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
    u = result.motion @ c
    expected = np.stack([strain * points[:, 0], np.full(len(points), -contraction * strain)], 1)
    np.testing.assert_allclose(u.reshape(-1, 2), expected, rtol=0, atol=1e-12 * strain)
    force = result.stiffness @ c
    np.testing.assert_allclose(force[1], modulus * strain * HEIGHT, rtol=1e-11)
