# SPDX-License-Identifier: LGPL-3.0-or-later
"""The interface problem in three dimensions: a sphere on a half-space, no finite elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from cases.marching import march_through
from numpy.typing import NDArray
from reference import halfspace
from reference.halfspace import SphereOnFlat

from fretfe._typing import Array
from fretfe.contact import march as march_module
from fretfe.contact.interface import Coordinate, DenseCompliance, Interface, add_layers
from fretfe.contact.linear_operator import FactoredOperator
from fretfe.contact.march import March, StepResult
from fretfe.contact.newton import LoadedStep, Newton, status_by_fixed_point
from fretfe.contact.state import (
    OPEN,
    SLIP,
    STICK,
    Guess,
    LinearSolution,
    Status,
    StatusRules,
    StepLoads,
    certify,
)
from fretfe.errors import ConvergenceError

FRICTION = 0.4
# E* = R = a = 1.
PEAK = 2 / np.pi
LIMIT = FRICTION * SphereOnFlat().load_for(1.0)
CERTIFIED = 1e-8
COUPLING = pytest.mark.parametrize("nu", [0.0, 0.3])


@cache
def sphere(nu: float = 0.0, cells: int = 17) -> Interface:
    return halfspace.build(SphereOnFlat(cells=cells, nu=nu))


def march(
    interface: Interface, shear: Array, friction: float = FRICTION, load: float = 1.0
) -> list[StepResult]:
    """Full normal load first, then shear forces (steps, 2) in units of f P."""
    normal = -load * LIMIT / FRICTION
    values = np.zeros((len(shear) + 2, 3))
    values[1:, 0] = normal
    values[2:, 1:] = shear * friction * -normal
    return list(
        march_through(March(interface), [halfspace.loads(interface, v, friction) for v in values])
    )


def nodal(interface: Interface, result: StepResult) -> Array:
    """(N, 3) pressure and shear."""
    return result.state.traction / interface.roots[:, None]


def area_radius(chosen: NDArray[np.bool_], problem: SphereOnFlat) -> float:
    return float(np.sqrt(chosen.sum() / np.pi) * problem.size)


def worst(results: Sequence[StepResult]) -> float:
    return max(result.certificate.worst for result in results)


def assert_newton_alone(results: Sequence[StepResult], most: int) -> None:
    assert worst(results) < CERTIFIED
    assert sum(result.fallbacks for result in results) == 0
    assert {result.parts for result in results} == {1}
    assert max(result.iterations for result in results) <= most


def test_love_and_cerruti_agree_with_quadrature() -> None:
    """Far from the square a point load, close to it fine quadrature."""
    offset = np.array([[30.0, 40.0], [0.9, 0.4], [0.0, -1.2]])
    s = (np.arange(400) + 0.5) / 400 - 0.5
    x, y = (offset[:, k, None, None] - np.meshgrid(s, s)[k] for k in (0, 1))
    r = np.hypot(x, y)
    # Midpoint rule with 400 points in each direction.
    np.testing.assert_allclose(halfspace.love(offset, 1.0), (1 / r).mean((1, 2)), rtol=1e-5)
    expected = np.stack([x * x, x * y, x * y, y * y], -1) / r[..., None] ** 3
    found = halfspace.cerruti(offset, 1.0).reshape(3, 4)
    # Its own midpoint rule has 8 points, closest 0.4 sides away.
    np.testing.assert_allclose(found, expected.mean((1, 2)), rtol=0, atol=3e-3)


@pytest.mark.parametrize(("cells", "tolerance"), [(15, 0.012), (21, 0.005), (27, 0.004)])
def test_pressure_is_that_of_hertz(cells: int, tolerance: float) -> None:
    problem, interface = SphereOnFlat(cells=cells), sphere(cells=cells)
    (result,) = march(interface, np.empty((0, 2)))
    pressure = nodal(interface, result)[:, 0]
    squared = (problem.centres**2).sum(axis=1)
    inside = squared < 0.7
    slope, peak = np.polyfit(squared[inside], pressure[inside] ** 2, 1)
    # Constant tractions on squares: error about h^2 away from the edge.
    assert np.sqrt(-peak / slope) == pytest.approx(1.0, rel=tolerance)
    assert np.sqrt(peak) == pytest.approx(PEAK, rel=tolerance)
    assert -result.state.coordinates[0] == pytest.approx(1.0, rel=tolerance)  # a^2 / R
    exact = PEAK * np.sqrt(np.maximum(1 - squared, 0))
    assert np.abs(pressure - exact)[squared < 0.64].max() < tolerance * PEAK
    # The contact is made of whole squares: half of one of them at the edge.
    assert area_radius(result.state.closed, problem) == pytest.approx(1, abs=problem.size / 2)
    assert worst([result]) < CERTIFIED


@pytest.mark.parametrize("angle", [0.0, 90.0, 36.9, 200.0])
@pytest.mark.parametrize("ratio", [0.3, 0.5, 0.8])
def test_shear_is_that_of_mindlin(ratio: float, angle: float) -> None:
    """nu = 0, where the solution of Cattaneo and Mindlin is exact, in any direction."""
    problem, interface = SphereOnFlat(cells=21), sphere(cells=21)
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    results = march(interface, np.array([0.5 * ratio, ratio])[:, None] * along)
    state, shear = results[-1].state, nodal(interface, results[-1])[:, 1:]
    stick = (1 - ratio) ** (1 / 3)
    radius = np.linalg.norm(problem.centres, axis=1)

    def ellipse(c: float) -> Array:
        return c * np.sqrt(np.maximum(1 - (radius / c) ** 2, 0))

    exact = FRICTION * PEAK * (ellipse(1.0) - ellipse(stick))
    # rms over the grid (h = a / 8): the kink at the stick radius and the square root at the edge.
    error = np.sqrt(np.mean((shear @ along - exact) ** 2)) / exact.max()
    assert error < 0.035
    np.testing.assert_allclose(shear @ [-along[1], along[0]], 0.0, atol=1e-12)
    # Whole squares: half of one.
    assert area_radius(state.status == STICK, problem) == pytest.approx(stick, abs=problem.size / 2)
    # Mindlin's displacement with E* = G: an integral, much better than its integrand.
    travel = state.coordinates[1:] @ along
    assert travel == pytest.approx(0.75 * LIMIT * (1 - stick**2), rel=3e-3)
    assert_newton_alone(results, 7)


def test_cycle_dissipates_as_mindlin_and_deresiewicz() -> None:
    """Energy of a cycle between +-Q (Johnson 1985, eq. 7.57), for nu = 0 and similar spheres."""
    ratio = 0.8
    path = np.concatenate([np.linspace(0.2, 0.8, 4), np.linspace(0.6, -0.8, 8)])
    path = np.concatenate([path, np.linspace(-0.6, 0.8, 8)])
    interface = sphere(cells=21)
    results = march(interface, np.column_stack([path, np.zeros(len(path))]))
    loop = sum(result.dissipation.sum() for result in results[5:])
    c = (1 - ratio) ** (1 / 3)
    expected = 9 / 10 * LIMIT**2 * 4 * (1 - c**5 - 5 * ratio / 6 * (1 + c**2))
    # The mesh's share of the slip annulus, a fifth of a wide.
    assert loop == pytest.approx(expected, rel=0.03)
    up, again = results[4].state, results[-1].state
    np.testing.assert_allclose(again.traction, up.traction, rtol=0, atol=1e-10)
    assert_newton_alone(results, 7)


TURNS = np.linspace(0, 4 * np.pi, 33)
PATHS = {
    "x then y": np.vstack(
        [
            np.column_stack([np.linspace(0.2, 0.6, 3), np.zeros(3)]),
            np.column_stack([np.full(5, 0.6), np.linspace(0.15, 0.75, 5)]),
        ]
    ),
    "rotating": 0.7 * np.column_stack([np.cos(TURNS), np.sin(TURNS)]),
    "reversal along an oblique line": np.outer(
        np.concatenate([np.linspace(0.2, 0.9, 4), np.linspace(0.6, -0.9, 6)]), [0.8, 0.6]
    ),
    "figure of eight": 0.6 * np.column_stack([np.sin(TURNS), np.sin(2 * TURNS)]),
}


@COUPLING
@pytest.mark.parametrize("path", PATHS.values(), ids=PATHS.keys())
def test_path_in_the_plane(path: Array, nu: float) -> None:
    interface = sphere(nu)
    results = march(interface, path)
    assert_newton_alone(results, 10)
    # 2-4 iterations on the status, 2 or 3 more until directions turn by less than 1e-10.
    assert np.mean([result.iterations for result in results]) <= 7
    forces = np.array([result.state.forces for result in results])
    np.testing.assert_allclose(forces[1:, 1:], path * LIMIT, rtol=0, atol=1e-11)
    assert_slip_opposes_shear(interface, results)


def test_directions_that_turn_by_round_off_are_converged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Large systems leave more round-off than small ones, other in each iteration."""
    rng, exact = np.random.default_rng(3), Newton._linear_solution

    def noisy(*arguments: Any) -> LinearSolution:
        solution = exact(*arguments)
        left: dict[str, Any] = {
            name: np.where(
                values == 0,
                0.0,
                values + 1e-10 * np.abs(values).max() * rng.uniform(-1, 1, values.shape),
            )
            for name, values in vars(solution).items()
            if name in ("traction", "relative")
        }
        return replace(solution, **left)

    path = PATHS["rotating"]
    expected = march(sphere(), path)
    monkeypatch.setattr(Newton, "_linear_solution", noisy)
    results = march(sphere(), path)
    assert_newton_alone(results, 10)
    largest = np.abs(expected[-1].state.traction).max()
    difference = results[-1].state.traction - expected[-1].state.traction
    assert np.abs(difference).max() < 1e-8 * largest


def assert_slip_opposes_shear(interface: Interface, results: Sequence[StepResult]) -> None:
    """At each slipping node the shear is f p long and points against the slip increment."""
    before, after = results[-2].state, results[-1].state
    slips = after.status == SLIP
    assert slips.sum() > 20
    increment = (after.relative - before.relative)[slips, 1:]
    shear, pressure = after.traction[slips, 1:], after.traction[slips, 0]
    lengths = np.linalg.norm(increment, axis=1)
    np.testing.assert_allclose(np.linalg.norm(shear, axis=1), FRICTION * pressure, rtol=1e-9)
    cosine = np.einsum("ni,ni->n", increment, shear) / (lengths * FRICTION * pressure)
    # Slip of the least slipping node has few digits: weigh with its length.
    np.testing.assert_allclose(lengths * cosine, -lengths, rtol=0, atol=1e-9 * lengths.max())


def test_oblique_load_is_the_turned_solution() -> None:
    """A quarter turn maps the grid onto itself: the whole history turns with the load."""
    problem, interface = SphereOnFlat(nu=0.3), sphere(0.3)
    path = PATHS["x then y"]
    turned = path @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    one, two = (march(interface, p)[-1].state for p in (path, turned))
    quarter = problem.centres @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    distance = np.linalg.norm(quarter[:, None] - problem.centres[None], axis=2)
    image = distance.argmin(axis=1)
    np.testing.assert_array_equal(two.status[image], one.status)
    expected = one.traction @ np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    np.testing.assert_allclose(two.traction[image], expected, rtol=0, atol=1e-11)


@cache
def walks(nu: float) -> list[StepResult]:
    """300 steps between random loads in all directions, friction from .1 to 1.2."""
    results = []
    interface = sphere(nu, 15)
    for seed in range(30):
        rng = np.random.default_rng(seed)
        friction = rng.uniform(0.1, 1.2)
        normal = LIMIT / FRICTION * rng.uniform(0.06, 1, 10)
        angle, size = rng.uniform(0, 2 * np.pi, 10), rng.uniform(0, 0.99, 10) * friction * normal
        values = np.zeros((11, 3))
        values[1:] = np.column_stack([-normal, size * np.cos(angle), size * np.sin(angle)])
        steps = [halfspace.loads(interface, v, friction) for v in values]
        results += list(march_through(March(interface), steps))
    return results


@COUPLING
def test_random_steps(nu: float) -> None:
    results = walks(nu)
    assert len(results) == 300
    # Found: 5.7 and 6.7 on average, at most 10.
    assert np.mean([result.iterations for result in results]) < 7.5
    assert_newton_alone(results, 15)
    assert min(result.dissipation.min() for result in results) > -1e-13


@COUPLING
def test_gross_slip_by_displacement(nu: float) -> None:
    """The whole contact follows a path that turns; the force has the size f P throughout."""
    interface = halfspace.build(SphereOnFlat(nu=nu), ("force", "displacement", "displacement"))
    turns = np.linspace(0, 2 * np.pi, 17)
    travel = np.column_stack([np.cos(turns), np.sin(turns)])
    values = np.zeros((len(turns) + 2, 3))
    values[1:, 0] = -LIMIT / FRICTION
    values[2:, 1:] = travel
    results = list(
        march_through(March(interface), [halfspace.loads(interface, v, FRICTION) for v in values])
    )
    assert_newton_alone(results, 10)
    forces = np.array([result.state.forces[1:] for result in results[2:]])
    assert all(set(result.state.status) == {OPEN, SLIP} for result in results[2:])
    # The size is f p at every node; the sum is smaller as long as their directions differ, because
    # the elastic part of the motion follows the path with a delay.
    size = np.linalg.norm(forces, axis=1) / LIMIT
    assert size.max() < 1
    assert size.min() > 0.97
    assert size[-1] > 0.995
    # Body 1 drags along its path: the force on it has a positive share along each chord.
    assert np.all(np.einsum("ni,ni->n", forces, np.diff(travel, axis=0)) > 0)


def test_force_above_the_limit_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """The slow method, thousands of iterations, is tried at the first and the last cut only."""
    runs = []

    def counted(*arguments: Any) -> tuple[Status, Array]:
        runs.append(1)
        return status_by_fixed_point(*arguments)

    monkeypatch.setattr(march_module, "status_by_fixed_point", counted)
    with pytest.raises(ConvergenceError, match=r"step 3 of 3 .*slides or opens as a whole"):
        march(sphere(0.3, 9), np.array([[0.5, 0.0], [0.8, 0.7]]))
    # The half of the load before the last cut is below the limit or above it.
    assert len(runs) in (2, 3)


@COUPLING
def test_frictionless_contact_moves_freely(nu: float) -> None:
    interface = halfspace.build(SphereOnFlat(nu=nu), ("force", "displacement", "displacement"))
    # Nodes close in steps that also move sideways.
    share = np.linspace(0.0, 1.0, 13)
    values = share[:, None] * np.array([-LIMIT / FRICTION, 0.3, -0.2])
    results = list(
        march_through(March(interface), [halfspace.loads(interface, v, 0.0) for v in values])
    )
    # Shear is what the linear system makes of zero.
    shear = np.array([result.state.traction[:, 1:] for result in results])
    np.testing.assert_allclose(shear, 0.0, atol=1e-14)
    assert worst(results) < CERTIFIED


def test_certificate_sees_slip_across_the_shear() -> None:
    interface = sphere(0.3, 15)
    steps = [
        halfspace.loads(interface, np.array([-1.0, 0.8 * q, 0.6 * q]) * LIMIT / FRICTION, FRICTION)
        for q in (0.0, 0.7 * FRICTION)
    ]
    before, after = march_through(March(interface), [replace(steps[0], values=np.zeros(3)), *steps])
    state, reference = after.state, before.state.relative[:, 1:]
    node = int(np.flatnonzero(state.status == SLIP)[0])
    relative = state.relative.copy()
    relative[node, 1:] += 1e-3 * interface.roots[node] * state.direction[node, ::-1] * [-1, 1]
    found = certify(interface, steps[1], replace(state, relative=relative), reference)
    assert found.slip_with_traction == pytest.approx(1e-3, rel=1e-6)


# --- the linearised conditions --------------------------------------------------------------------


def small_problem(rng: np.random.Generator) -> Interface:
    """Four nodes with a random compliance, nothing to control."""
    root = rng.standard_normal((12, 12))
    return Interface(
        components=3,
        compliance=DenseCompliance(root @ root.T / 12 + np.eye(12)),
        gap=np.zeros(12),
        motion=np.zeros((12, 0)),
        stiffness=np.zeros((0, 0)),
        loads=np.eye(12),
        coordinate_loads=np.zeros((0, 12)),
        roots=np.ones(4),
        coordinates=(),
        contacts={"main": slice(0, 4)},
    )


STATUS = np.array([SLIP, STICK, SLIP, OPEN], np.int8)


def conditions(traction: Array, interface: Interface, penalty: Array, free: Array) -> Array:
    """(N, 3) what is zero at the solution, in tractions and displacements; complex is welcome."""
    compliance = interface.compliance.block(np.arange(12), np.arange(12))
    relative = (compliance @ traction.ravel()).reshape(4, 3) + free
    residual = relative.copy()
    residual[STATUS == OPEN] = traction[STATUS == OPEN]
    trial = traction[:, 1:] - penalty[:, None] * relative[:, 1:]
    length = np.sqrt((trial**2).sum(axis=1, keepdims=True))  # not abs: analytic
    projected = FRICTION * traction[:, :1] * trial / length
    slips = STATUS == SLIP
    residual[slips, 1:] = (traction[:, 1:] - projected)[slips]
    return residual


def newton_step_by_differences(
    traction: Array, interface: Interface, penalty: Array, free: Array
) -> Array:
    """One Newton step with a Jacobian by complex differences, which have no cancellation."""
    step = 1e-30
    columns = [
        conditions(traction + 1j * step * e.reshape(4, 3), interface, penalty, free).imag / step
        for e in np.eye(12)
    ]
    jacobian = np.array([column.ravel() for column in columns]).T
    residual = conditions(traction, interface, penalty, free).ravel()
    return traction - np.linalg.solve(jacobian, residual).reshape(4, 3)


@pytest.mark.parametrize("slip", 10.0 ** np.arange(-9, 7, 3), ids=lambda slip: f"{slip:.0e}")
@pytest.mark.parametrize("seed", range(3))
def test_tangent_of_the_slip_conditions(seed: int, slip: float) -> None:
    """An iteration is the Newton step of the augmented-Lagrangian conditions, for slips from far
    below to far above what the shear could do elastically, next to stuck and open nodes."""
    rng = np.random.default_rng(seed)
    interface = small_problem(rng)
    newton = Newton(FactoredOperator(interface))
    penalty = 1 / interface.compliance.diagonal.reshape(4, 3)[:, 1:].mean(axis=1)
    traction = np.column_stack([rng.uniform(1, 2, 4), np.zeros((4, 2))])
    angle = rng.uniform(0, 2 * np.pi, 4)
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    # On or above the bound, and not quite in line with the slip: this is not the solution.
    traction[:, 1:] = 1.05 * FRICTION * traction[:, :1] * along
    increment = -slip * (along + 0.5 * np.column_stack([-along[:, 1], along[:, 0]]))
    relative = np.column_stack([rng.uniform(-1, 1, 4), increment])
    free = relative - interface.compliance.apply(traction.ravel()).reshape(4, 3)
    start = Guess(STATUS, np.where((STATUS == SLIP)[:, None], along, 0.0), np.ones(4))
    linearised = StatusRules(interface).following(
        start,
        LinearSolution(traction, relative, np.empty(0), motion=0.0),
        np.full(4, FRICTION),
    )
    linearised = Guess(
        STATUS, np.where((STATUS == SLIP)[:, None], linearised.direction, 0.0), linearised.turning
    )
    loads = StepLoads(free.ravel(), np.empty(0), np.full(4, FRICTION))
    step = LoadedStep(interface, loads, np.zeros((4, 2)))
    found = newton._linear_solution(step, linearised).traction
    expected = newton_step_by_differences(traction, interface, penalty, free)
    # Round-off of a system whose entries span the decades of slip.
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-11 * max(1.0, slip))


# Approach per pressure, and shift per shear, of two contacts.
LAYERS = {"one": np.tile([1e-3, 2.5e-3], (3, 1)), "two": np.full((1, 2), 1e-6)}
MOVED = [(0.0, 0.0), (-0.004, 0.0), (-0.004, 0.0025)]


def test_rigid_bodies_on_a_layer_have_its_pressure() -> None:
    """p = k_n times the approach at each node, whatever its weight, and q = k_t times the shift."""
    roots, height = np.sqrt([0.5, 1.0, 2.0, 1.0]), np.array([0.0, 0.001, 0.002, 0.5])
    matrix, motion = np.zeros((8, 8)), np.zeros((4, 2, 2))
    add_layers(matrix, {"one": slice(0, 3), "two": slice(3, 4)}, LAYERS, 2)
    motion[:, 0, 0] = motion[:, 1, 1] = roots
    interface = Interface(
        components=2,
        compliance=DenseCompliance(matrix),
        gap=np.column_stack([roots * height, 0 * roots]).ravel(),
        motion=motion.reshape(8, 2),
        stiffness=np.zeros((2, 2)),
        loads=np.zeros((8, 0)),
        coordinate_loads=np.zeros((2, 0)),
        roots=roots,
        coordinates=tuple(Coordinate(each, "punch", "displacement", each) for each in "yx"),
        contacts={"one": slice(0, 3), "two": slice(3, 4)},
    )
    steps = [StepLoads(np.zeros(0), np.array(each), np.full(4, 0.3)) for each in MOVED]
    state = list(march_through(March(interface), steps))[-1].state
    pressure, shear = (state.traction / roots[:, None]).T
    assert pressure == pytest.approx([4.0, 3.0, 2.0, 0.0], rel=1e-12)
    # k_t = 400 times .0025 is 1, less than .3 p at the first node alone.
    assert shear == pytest.approx([-1.0, -0.9, -0.6, 0.0], rel=1e-12)
    assert list(state.status) == [STICK, SLIP, SLIP, OPEN]
