# SPDX-License-Identifier: LGPL-3.0-or-later
"""Thermal strain: stress in held bodies and a tube, free expansion, mismatch of two bodies."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import run
from cases.marching import march_through
from cases.pad_cases import HOLD, SLIDING, as_field, cylinder, pad, press, pull, shear, wave
from dolfinx import fem
from harness.petsc_garbage import replace_meshes
from scipy import sparse

from fretfe._typing import Array
from fretfe.analytic._numerics import Side
from fretfe.analytic.edges import tangential_factor
from fretfe.bodies.constraints import Constraint
from fretfe.bodies.loads.cut import Cut
from fretfe.bodies.loads.strain import Heating, Temperature, TemperatureShape
from fretfe.bodies.point_values import NodalValues, PointValues
from fretfe.case import Solid, parse_case
from fretfe.contact.march import March
from fretfe.fem._compat import MPI
from fretfe.fem.condensation import Body
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.fields import StressPoints
from fretfe.fem.interaction_integral import InteractionForm, Tip, Tube
from fretfe.fem.timing import Clock
from fretfe.materials.material import Material
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.results.model import Result
from fretfe.runner import Runner
from fretfe.surface.surface import build_surface

Solve = Callable[[dict[str, Any]], Result]
EXPANSION, REFERENCE = 1e-3, 20.0
LEFT_X = Constraint("left x", "b_left", (1.0, 0.0))
RIGHT_X = Constraint("right x", "b_right", (1.0, 0.0))
NO_CUT = Cut("hot", np.zeros(0), np.zeros((0, 0, 1)), (), 0.0)
BOTTOM_Y = Constraint("bottom y", "b_bottom", (0.0, 1.0))


def hot(points: Any, values: Any, name: str = "hot", **options: Any) -> Temperature:
    field = PointValues(np.array(points, dtype=float), np.array(values, dtype=float))
    return Temperature(name, field, **options)


def material(plane: str = "strain") -> Material:
    return Material(200.0, 0.3, 0.0, plane, EXPANSION, REFERENCE)


def make_body(
    mesh: BodyMesh,
    constraints: list[Constraint],
    load: Heating,
    steel: Material,
    surface: str = "b_top",
) -> Body:
    elastic = ElasticBody(MPI.COMM_WORLD, mesh if MPI.COMM_WORLD.rank == 0 else None, steel, 2)
    replace_meshes(elastic.mesh)
    points = build_surface(mesh, surface).displacement_points(2)
    operator = sparse.identity(points.size, format="csr")
    return Body(elastic, constraints, [load], points, operator, Clock())


def rectangle(cell: str = "triangle") -> BodyMesh:
    return blocks.block("b", blocks.graded(0.0, 1.5, 5), blocks.graded(0.0, 1.0, 4), cell=cell)


def moved(body: Body, amplitude: float) -> Any:
    """Displacement of a body without contact."""
    count = MPI.COMM_WORLD.bcast(body.condensed.motion.shape if body.condensed else None)
    (field,) = body.recover([(np.zeros(count[0]), np.zeros(count[1]), np.array([amplitude]))])
    return field


def stress_of(body: Body, amplitude: float = 1.0) -> tuple[Array, Array]:
    """Places (m, d) and stress (m, 4) at the nodes of the elements of a body without contact."""
    elastic, initial = body.elastic, body.initial_stress(np.array([amplitude]))
    stress = elastic.element_stresses(moved(body, amplitude), initial)
    return elastic.element_nodes().reshape(-1, elastic.gdim), stress.reshape(-1, stress.shape[2])


@pytest.mark.mpi
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize(
    ("plane", "along", "across"), [("stress", 1.0, 0.0), ("strain", 1 / 0.7, 1 / 0.7)]
)
def test_bar_held_at_both_ends(cell: str, plane: str, along: float, across: float) -> None:
    """sigma = -E alpha dT along the bar, whatever dT is across it; E/(1 - nu) if z is held too."""
    load = hot([[0, 0], [0, 1.0]], [REFERENCE + 30, REFERENCE + 90])
    body = make_body(rectangle(cell), [LEFT_X, RIGHT_X, BOTTOM_Y], load, material(plane))
    places, stress = stress_of(body, 0.5)
    change = 0.5 * (30 + 60 * places[:, 1])
    expected = -200.0 * EXPANSION * change[:, None] * np.array([along, 0.0, across, 0.0])
    np.testing.assert_allclose(stress, expected, rtol=0, atol=1e-11)
    # The same at single points.
    points = StressPoints(body.elastic, np.array([[0.3, 0.4], [1.1, 0.9]]))
    found = points.stress(moved(body, 0.5), body.initial_stress(np.array([0.5])))
    change = 0.5 * (30 + 60 * np.array([0.4, 0.9]))
    expected = -200.0 * EXPANSION * change[:, None] * np.array([along, 0.0, across, 0.0])
    np.testing.assert_allclose(found, expected[points.found], rtol=0, atol=1e-11)


def test_nothing_in_another_body_and_in_a_body_that_does_not_expand() -> None:
    for load, steel in (
        (hot([[0, 0]], [50.0], bodies=("other",)), material()),
        (hot([[0, 0]], [50.0]), Material(200.0, 0.3, 0.0, "strain")),
    ):
        body = make_body(rectangle(), [LEFT_X, RIGHT_X, BOTTOM_Y], load, steel)
        _, stress = stress_of(body)
        np.testing.assert_array_equal(stress, 0.0)


@pytest.mark.mpi
def test_tube_with_a_logarithmic_temperature() -> None:
    """Hoop stress at the bore, E alpha dT/(2 (1 - nu) ln(b/a)) (1 - 2 b^2 ln(b/a)/(b^2 - a^2))."""
    inner, outer, change = 1.0, 2.0, 80.0
    ratio = outer / inner

    def ring(points: Array) -> Array:
        radius, angle = points.T
        return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    mesh = blocks.block(
        "b", np.linspace(inner, outer, 17), np.linspace(0, np.pi / 2, 17), order=2, mapping=ring
    )
    radii, angles = np.meshgrid(np.linspace(0.99, 2.01, 120), np.linspace(-0.05, 1.62, 120))
    points = ring(np.stack([radii.ravel(), angles.ravel()], axis=1))
    values = REFERENCE + change * np.log(outer / radii.ravel()) / np.log(ratio)
    symmetric = [Constraint("y", "b_bottom", (0.0, 1.0)), Constraint("x", "b_top", (1.0, 0.0))]
    body = make_body(mesh, symmetric, hot(points, values), material(), "b_right")
    places, stress = stress_of(body)
    radius = np.linalg.norm(places, axis=1)
    unit = 200.0 * EXPANSION * change / (2 * 0.7 * np.log(ratio))
    bore = unit * (1 - 2 * outer**2 / (outer**2 - inner**2) * np.log(ratio))
    skin = unit * (1 - 2 * inner**2 / (outer**2 - inner**2) * np.log(ratio))
    hoop = stress[:, 1] + stress[:, 0]  # the radial stress vanishes on both surfaces
    assert bore < 0 < skin
    assert hoop[np.isclose(radius, inner)] == pytest.approx(bore, rel=0.01)
    assert hoop[np.isclose(radius, outer)] == pytest.approx(skin, rel=0.01)


WIDTH, HEIGHT = 1.0, 0.6


def bodies(solid: bool, gap: float) -> list[BodyMesh]:
    """Two blocks, the upper one with a curved lower side."""

    def lifted(points: Array) -> Array:
        x, y = points.T
        return np.stack([x, y + gap * (0.2 + (x / WIDTH) ** 2) * (1 - y / HEIGHT)], axis=1)

    y = np.linspace(0, HEIGHT, 5)
    upper = blocks.block("upper", np.linspace(0, WIDTH, 9), y, order=2, mapping=lifted)
    lower = blocks.block("lower", np.linspace(0, WIDTH, 11), y - HEIGHT, order=2)
    if not solid:
        return [upper, lower]
    whole = extrude(Mesh({"upper": upper, "lower": lower}), Solid(length=0.3, layers=2))
    return list(whole.bodies.values())


def pressed(solid: bool, **loads: Any) -> dict[str, Any]:
    """Bodies on rollers, free to expand, pressed on each other with friction."""
    steel = {"young": 1000.0, "poisson": 0.3}
    warm = {**steel, "expansion": EXPANSION, "reference_temperature": REFERENCE}
    supports = {
        "base": {"boundary": "lower_bottom", "fix": ["y"]},
        "lower": {"boundary": "lower_left", "fix": ["x"]},
        "upper": {"boundary": "upper_left", "fix": ["x"]},
    }
    if solid:
        supports |= {
            f"face_{name}": {"boundary": f"{name}_back", "fix": ["z"]}
            for name in ("upper", "lower")
        }
    return {
        "bodies": {"upper": warm, "lower": warm},
        "contacts": {
            "main": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.3}
        },
        "supports": supports,
        "loads": {
            **loads,
            "press": {
                "type": "traction",
                "boundary": "upper_top",
                "direction": "y",
                "history": [{"hold": True, "until": 0.5}, {"ramp": -2.0, "until": 1.0, "steps": 2}],
            },
            "push": {
                "type": "traction",
                "boundary": "upper_right",
                "direction": "x",
                "history": [{"hold": True, "until": 1.0}, {"ramp": -0.3, "until": 2.0, "steps": 2}],
            },
        },
    }


HEATING = {
    "type": "temperature",
    "value": REFERENCE + 100.0,
    "history": [{"ramp": 1.0, "until": 0.5, "steps": 1}],
}


@pytest.mark.mpi
@pytest.mark.parametrize("gap", [0.01, 0.0], ids=["curved", "conforming"])
@pytest.mark.parametrize("solid", [False, True], ids=["plane", "solid"])
def test_free_expansion_scales_the_gap(solid: bool, gap: float) -> None:
    """u = k x moves opposite points apart by k times their gap, along it."""
    stretch = EXPANSION * 100.0 * (1.0 if solid else 1.3)
    heated = run(pressed(solid, heat=HEATING), *bodies(solid, gap)).tractions[-1]
    cold = run(pressed(solid), *bodies(solid, gap))
    scaled = np.zeros_like(heated)
    if MPI.COMM_WORLD.rank == 0:
        interface = cold.model.reduction.interface
        wider = replace(interface, gap=(1 + stretch) * interface.gap)
        *_, last = march_through(March(wider), cold.steps)
        scaled = last.state.traction / interface.roots[:, None]
    MPI.COMM_WORLD.Bcast(scaled)
    pressure = np.abs(heated).max()
    assert pressure > 1.0
    np.testing.assert_allclose(heated, scaled, rtol=0, atol=1e-9 * pressure)
    same = np.abs(heated - cold.tractions[-1]).max() < 1e-9 * pressure
    assert same == (gap == 0.0)


@pytest.mark.parametrize("solid", [False, True], ids=["plane", "solid"])
def test_temperatures_of_another_run(solid: bool, tmp_path: Path) -> None:
    """The same tractions by a field, uniform or linear, as by a temperature and its points."""
    size = 2.0
    corners = [list(each) for each in itertools.product((-size, size), repeat=2 + solid)]
    slopes = np.array([30.0, 50.0, 40.0])[: 2 + solid]

    def linear(*place: float) -> float:
        return float(REFERENCE + slopes @ place)

    graded = {"type": "temperature", "history": HEATING["history"], "points": corners,
              "values": [linear(*each) for each in corners]}  # fmt: skip
    found = []
    for load, warm in ((HEATING, lambda *place: REFERENCE + 100.0), (graded, linear)):
        field = as_field(load, tmp_path, size, warm, 2 + solid)
        by_points, by_field = (
            run(pressed(solid, heat=each), *bodies(solid, 0.01)).tractions[-1]
            for each in (load, field)
        )
        largest = np.abs(by_points).max()
        np.testing.assert_allclose(by_field, by_points, rtol=0, atol=1e-9 * largest)
        found.append(by_field)
    assert np.abs(found[1] - found[0]).max() > 0.1 * largest


def test_no_stress_of_a_linear_field_in_a_free_solid() -> None:
    """T = 30 x: displacements 30 alpha ((x² - y² - z²)/2, x y, x z) follow it."""
    mesh = extrude(Mesh({"b": rectangle()}), Solid(length=0.5, layers=2)).bodies["b"]
    elastic = ElasticBody(MPI.COMM_SELF, mesh, material(), 2)
    change = NodalValues(mesh.points, 30 * mesh.points[:, 0])
    x, y, z = elastic.space.tabulate_dof_coordinates().T
    field = fem.Function(elastic.space)
    followed = np.stack([(x**2 - y**2 - z**2) / 2, x * y, x * z], axis=1)
    field.x.array[:] = 30 * EXPANSION * followed.ravel()
    initial = elastic.initial_stress(TemperatureShape("hot", {"b": change}, 1, NO_CUT))
    held, free = (elastic.element_stresses(field, each) for each in (None, initial))
    assert np.abs(held).max() > 1.0
    assert np.abs(free).max() < 1e-12 * np.abs(held).max()


PEENED = {
    "type": "eigenstrain",
    "surfaces": ["lower_top"],
    "depths": [0.0, 0.2],
    "values": [0.02, 0.0],
}
CYCLED = [
    {"ramp": 1.0, "until": 1.0, "steps": 2},
    {"hold": True, "until": 2.0},
    {**wave(0.8, steps=8), "mean": 1.0},
]


@pytest.mark.parametrize(
    "load",
    [{"type": "temperature", "value": REFERENCE + 20.0, "bodies": ["lower"]}, PEENED],
    ids=["temperature", "eigenstrain"],
)
def test_energy_balance(load: dict[str, Any]) -> None:
    """Elastic energy is the work of the loads, the strain too, less what friction takes.

    Each step takes the mean of forces times displacements, exactly, as the bodies are linear.
    """
    found = run(pressed(False, strain={**load, "history": CYCLED}), *bodies(False, 0.01))
    loads = found.model.reduction.definition.loads
    energy, moved = [], []
    for number in range(len(found.results)):
        fields = found.fields(number)
        pairs = [(found.model.bodies[name].elastic, each) for name, each in fields.items()]
        energy.append(sum(body.forces(u).dot(u.x.petsc_vec) / 2 for body, u in pairs))
        moved.append(
            [sum(body.load_vector(each).dot(u.x.petsc_vec) for body, u in pairs) for each in loads]
        )
    states = [each.state for each in found.results]
    work = work_of(np.array([each.amplitudes for each in found.steps[1:]]), np.array(moved))
    taken = -work_of(
        *(np.array([getattr(each, name).ravel() for each in states])
          for name in ("traction", "relative"))
    )  # fmt: skip
    assert taken[-8:].sum() > 1e-3 * np.abs(work[-8:]).sum()
    np.testing.assert_allclose(np.diff(energy), work - taken, rtol=0, atol=1e-10 * work.max())


def work_of(forces: Array, displacements: Array) -> Array:
    """(T - 1,) work of forces (T, n) from each state to the next."""
    means = (forces[1:] + forces[:-1]) / 2
    return np.asarray((means * np.diff(displacements, axis=0)).sum(axis=1))


SIDES: tuple[Side, Side] = ("left", "right")
# Large, so that half-planes are near.
SIZES = {"upper_width": 20.0, "lower_width": 30.0, "lower_height": 30.0, "upper_height": 10.0}
PAD = {"upper_radius": 50.0, "lower_radius": 0.0, "size": 0.02, "zone": 1.0, **SIZES}


MISMATCHES: dict[str, dict[str, Any]] = {
    "temperature": {"type": "temperature", "value": REFERENCE + 100.0, "bodies": ["lower"]},
    "eigenstrain": {
        "type": "eigenstrain",
        "surfaces": ["lower_contact"],
        "depths": [0.0],
        "values": [3e-4],
    },
}


@pytest.mark.parametrize(
    ("kind", "plane"),
    [("temperature", "strain"), ("temperature", "stress"), ("eigenstrain", "strain")],
)
def test_mismatch_is_a_bulk_tension(kind: str, plane: str, solved: Solve) -> None:
    """K_T of the expansion of one body is that of E alpha dT/(1 - nu) (stress: E alpha dT)."""
    steel = {"young": 210e3, "poisson": 0.3}
    loads = {
        "press": press(),
        "shear": {**shear(0.0), "history": [HOLD, {"hold": True, "until": 3.0}]},
        "pull": pull(0.0),
        "heat": {**MISMATCHES[kind], "history": [HOLD, wave(1.0)]},
    }
    tension = 210e3 * 3e-4 / (0.7 if plane == "strain" else 1.0)
    own = {
        "upper": steel,
        "lower": {**steel, "expansion": 3e-6, "reference_temperature": REFERENCE},
    }
    geometry = {"template": "cylinder", "parameters": PAD}
    model = {"degree": 2, "plane": plane}
    answer = solved(pad(geometry=geometry, model=model, loads=loads, supports=SLIDING, bodies=own))
    contact = answer.contacts[0]
    a = float(contact.half_width[-1])
    for edge, side in zip(contact.stations, SIDES, strict=True):
        expected = 2 * float(tangential_factor(0.0, tension, a, side))
        assert edge.k_t_range == pytest.approx(expected, rel=0.01)
        assert edge.k_t_range_fitted == pytest.approx(edge.k_t_range, rel=0.01)
    integrals = answer.solution.contacts[0].integrals
    assert integrals is not None
    # A pull that stretches the block as much does the same, to the quadrature next to the tip.
    by_pull, by_heat = (
        integrals.factors[..., 1, answer.solution.drivers.index(name)] for name in ("pull", "heat")
    )
    np.testing.assert_allclose(by_heat, tension * by_pull, rtol=1e-4)


TIP = np.array([0.03, 0.0])
# Temperatures that bodies can follow without stress: uniform, and linear in the plane.
FOLLOWED: Mapping[str, tuple[Any, Any, Callable[[Array], Array]]] = {
    "uniform": ([[0, 0]], [REFERENCE + 30.0], lambda x: 30 * x),
    "ahead": (
        [[-1, 0], [1, 0]],
        [REFERENCE - 30.0, REFERENCE + 30.0],
        lambda x: 30 * np.stack([(x[:, 0] ** 2 - x[:, 1] ** 2) / 2, x[:, 0] * x[:, 1]], axis=1),
    ),
    "across": (
        [[0, -1], [0, 1]],
        [REFERENCE - 30.0, REFERENCE + 30.0],
        lambda x: 30 * np.stack([x[:, 0] * x[:, 1], (x[:, 1] ** 2 - x[:, 0] ** 2) / 2], axis=1),
    ),
}


@pytest.mark.parametrize("name", FOLLOWED)
def test_no_edge_factor_without_stress(name: str) -> None:
    """Displacement and initial strain cancel in the interaction integral of both bodies."""
    points, values, displaced = FOLLOWED[name]
    load, lines = hot(points, values), np.linspace(-1, 1, 21)
    by_displacement, by_load = np.zeros((2, 2))
    for upper, side in ((True, "bottom"), (False, "top")):
        depth = np.linspace(0, 1, 11) - (not upper)
        mesh = blocks.block("b", lines, depth, cell="triangle", order=2)
        elastic = ElasticBody(MPI.COMM_SELF, mesh, material(), 2)
        form = InteractionForm(elastic, [f"b_{side}"], upper, [load])
        places = elastic.space.tabulate_dof_coordinates()[:, :2]
        own = 1.3 * EXPANSION * displaced(places)[:, :, None]
        tip, tube = Tip(TIP, np.array([[0.0, 1.0], [1.0, 0.0]])), Tube(0.5)
        by_displacement += form.products(tip, [tube], own)[0][:, 0]
        by_load += form.load_products(tip, [tube])[0][:, 0]
    largest = np.abs(by_load).max()
    # A radial quadrature of 1/sqrt(r) in the element with the tip.
    np.testing.assert_allclose(by_displacement, -by_load, atol=5e-3 * largest)
    assert largest > 1e-3


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_stress_near_a_contact_is_without_the_thermal_part(plane: str, tmp_path: Path) -> None:
    """A block that is held grows towards a pad under a force, which feels nothing of it."""
    supports = {**SLIDING, "other": {"boundary": "lower_right", "fix": ["x"]}}
    steel = {"young": 210e3, "poisson": 0.3}
    own = {"upper": steel, "lower": {**steel, "expansion": 1e-5, "reference_temperature": 20.0}}
    loads = {"press": press(), "shear": shear(steps=4, cycles=1)}
    warm = {"type": "temperature", "value": 120.0, "bodies": ["lower"]}
    heat = {**warm, "history": [{"ramp": 1.0, "until": 1.0, "steps": 4}]}
    field = as_field(heat, tmp_path, 50.0, lambda *place: 120.0)
    found = []
    for name, more in (("cold", {}), ("hot", {"heat": heat}), ("field", {"heat": field})):
        tables = pad(
            geometry=cylinder(size=0.04),
            model={"plane": plane},
            bodies=own,
            supports=supports,
            loads={**loads, **more},
            output={"fields": "none", "stress_depths": [0.0, 0.1]},
        )
        result = Runner.find("fem").run(parse_case(tables), tmp_path / name)
        found.append(result.stress_history("main"))
    cold, warmed, by_field = (each.bodies[1].stress for each in found)
    stress = -210e3 * 1e-5 * 100 / (0.7 if plane == "strain" else 1.0)
    expected = stress * np.array([1.0, 0.0, 1.0 if plane == "strain" else 0.0, 0.0])
    np.testing.assert_allclose(by_field, warmed, atol=1e-6 * abs(stress))
    known = np.isfinite(cold)
    assert known.mean() > 0.9
    difference = np.where(known, warmed - cold - expected, 0.0)
    assert np.abs(difference).max() < 1e-6 * abs(stress)
    np.testing.assert_allclose(found[1].bodies[0].stress, found[0].bodies[0].stress, atol=1e-6)
    for before, after in zip(found[0].edges, found[1].edges, strict=True):
        own_part = stress if before.body == "lower" else 0.0
        np.testing.assert_allclose(after.value, before.value + own_part, atol=1e-3)


def test_no_edge_factor_without_stress_in_space() -> None:
    """A curved front; linear along it and across it, and uniform."""
    span, depth = np.linspace(-1, 1, 11), np.linspace(0, 0.8, 5)
    frame = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    tip, tube = Tip(np.array([0.5, 0.0, 1.0]), frame, 2.0), Tube(0.35, 0.45)
    loads = [
        hot([[0, 0, 0]], [REFERENCE + 30.0]),
        hot([[-1, 0, 0], [1, 0, 0]], [REFERENCE - 30.0, REFERENCE + 30.0], "linear"),
    ]
    by_displacement, by_load = np.zeros((2, 3, 2))
    for upper, side in ((True, "bottom"), (False, "top")):
        plane = blocks.block("b", span, depth - (not upper) * 0.8, cell="triangle")
        mesh = extrude(Mesh({"b": plane}), Solid(length=2.0, layers=10)).bodies["b"]
        elastic = ElasticBody(MPI.COMM_SELF, mesh, material(), 2)
        form = InteractionForm(elastic, [f"b_{side}"], upper, loads)
        x, y, z = elastic.space.tabulate_dof_coordinates().T
        squares = np.stack([(x**2 - y**2 - z**2) / 2, x * y, x * z], axis=1)
        own = 30 * EXPANSION * np.stack([np.stack([x, y, z], axis=1), squares], axis=2)
        by_displacement += form.products(tip, [tube], own)[0]
        by_load += form.load_products(tip, [tube])[0]
    largest = np.abs(by_load).max(axis=0)
    assert (largest > 1e-3).all()
    assert (np.abs(by_displacement + by_load) < 5e-3 * largest).all()
