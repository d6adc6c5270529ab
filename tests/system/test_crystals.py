# SPDX-License-Identifier: LGPL-3.0-or-later
"""Crystals in finite elements: stress, crack-tip fields, contacts against half-planes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.pad_cases import pad
from dolfinx import fem

from fretfe._typing import Array
from fretfe.case import IS_CRYSTAL, Crystal, Solid, parse_case
from fretfe.case.bodies import Elastic, Orientation
from fretfe.errors import CaseError
from fretfe.evaluate.surface_stress import SurfaceLaw, along_surface
from fretfe.exchange.export import export_tables
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import COMPONENTS, PLANE_TENSOR, ElasticBody
from fretfe.fem.fields import StressPoints
from fretfe.fem.interaction_integral import InteractionForm, Tip, Tube
from fretfe.materials.crystals import (
    CrackTip,
    HalfPlane,
    bunge_rotation,
    cubic,
    plane_stress,
    tensor,
    turned,
)
from fretfe.materials.crystals import isotropic as isotropic_stiffness
from fretfe.materials.material import Material
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh
from fretfe.reason import Kind
from fretfe.report.figures.tractions import SLIP_SYSTEMS, slip_system_plot
from fretfe.report.source import shown_contacts
from fretfe.report.texts import number
from fretfe.results.model import Result
from fretfe.runner import Runner

RUNNER = Runner.find("fem")
Solve = Callable[[dict[str, Any]], Result]
NICKEL = cubic(252.0, 161.0, 131.0)
ORIENTED = {
    2: turned(NICKEL, bunge_rotation((20.0, 0.0, 0.0))),
    3: turned(NICKEL, bunge_rotation((20.0, 40.0, 70.0))),
}
HEIGHT, HALF = 0.6, 0.4


def material(matrix: Array, plane: str = "strain") -> Material:
    crystal = plane_stress(matrix) if plane == "stress" else matrix
    rows = tuple(map(tuple, crystal.tolist()))
    return Material(np.nan, np.nan, 0.0, plane, crystal=rows)


def body_of(
    own: Material, upper: bool, size: int, element: float, components: int | None = None
) -> ElasticBody:
    """A block above or below y = 0, along a front at x = 0."""
    name = "pad" if upper else "block"
    span = np.linspace(-1, 1, round(2 / element) + 1)
    depth = np.linspace(0, HEIGHT, round(HEIGHT / element) + 1)
    mesh = blocks.block(name, span, depth if upper else depth - HEIGHT, cell="quadrilateral")
    if size == 3:
        length = 2 * HALF + 0.4
        solid = Solid(length=length, layers=round(length / element / 1.5))
        mesh = extrude(Mesh({name: mesh}), solid).bodies[name]
    root = MPI.COMM_WORLD.rank == 0
    return ElasticBody(MPI.COMM_WORLD, mesh if root else None, own, 2, components)


@pytest.mark.parametrize(
    ("size", "components", "plane"),
    [(2, 2, "strain"), (2, 2, "stress"), (2, 3, "strain"), (3, 3, "strain")],
)
def test_stress_is_hookes_law(size: int, components: int, plane: str) -> None:
    """Of a displacement that the elements have exactly, at nodes and at points."""
    matrix = ORIENTED[components]
    body = body_of(material(matrix, plane), True, size, 0.3, components)
    slope = np.zeros((3, 3))
    slope[:components, :size] = np.random.default_rng(2).normal(size=(components, size))
    moved = fem.Function(body.space)
    moved.interpolate(lambda x: slope[:components, :size] @ x[:size])
    strain = (slope + slope.T) / 2
    if plane == "stress":
        s, e = tensor(matrix), strain.copy()
        e[2, 2] = -(s[2, 2, :2, :2] * strain[:2, :2]).sum() / s[2, 2, 2, 2]
        strain = e
    expected = np.einsum("ijkl,kl->ij", tensor(matrix), strain)
    assert abs(expected[2, 2]) < 1e-12 or plane == "strain"
    pairs = np.array(PLANE_TENSOR if components == 2 else COMPONENTS)
    wanted = expected[pairs[:, 0], pairs[:, 1]]
    nodes = body.element_stresses(moved)
    np.testing.assert_allclose(nodes - wanted, 0, atol=1e-10 * np.abs(wanted).max())
    points = np.array([[0.11, 0.07, 0.13], [0.5, 0.3, 0.4]])[:, :size]
    at = StressPoints(body, points)
    np.testing.assert_allclose(at.stress(moved) - wanted, 0, atol=1e-10 * np.abs(wanted).max())


@pytest.mark.parametrize(
    ("plane", "size", "euler"),
    [
        ("strain", 2, (20.0, 0.0, 0.0)),
        ("stress", 2, (20.0, 0.0, 0.0)),
        ("strain", 3, (20.0, 40.0, 70.0)),
    ],
)
def test_stress_at_a_surface_from_the_strain_along_it(
    plane: Any, size: int, euler: tuple[float, float, float]
) -> None:
    """Back from a stress: tractions, the strain along the surface less the free one."""
    body = Crystal(
        elastic=Elastic(cubic=(252.0, 161.0, 131.0)), orientation=Orientation(euler=euler)
    )
    generator = np.random.default_rng(4)
    stress = generator.normal(size=(5, 3, 3))
    if size == 2:
        stress *= [[1, 1, 0], [1, 1, 0], [0, 0, 1]]
    stress += stress.swapaxes(1, 2)
    initial = np.tile(np.diag([1e-3, 2e-3, 3e-3]), (5, 1, 1))
    compliance = np.linalg.inv(body.stiffness)
    if plane == "stress":
        stress[:, 2, 2] = 0
    else:
        inner = stress[:, [0, 1, 1, 0, 0], [0, 1, 2, 2, 1]] @ compliance[2, [0, 1, 3, 4, 5]]
        stress[:, 2, 2] = -(inner + 3e-3) / compliance[2, 2]
    strain = initial + np.einsum("ijkl,nkl->nij", np.linalg.tensorinv(full(body.stiffness)), stress)
    assert plane == "stress" or np.abs(strain[:, 2, 2]).max() < 1e-15
    angle = generator.uniform(0, 6, 5)
    nothing, one = np.zeros(5), np.ones(5)
    normal = np.stack([np.cos(angle), np.sin(angle), nothing], axis=1)
    tangent = np.stack([np.sin(angle), -np.cos(angle), nothing], axis=1)
    frames = np.stack([normal, tangent, np.stack([nothing, nothing, one], axis=1)], axis=1)
    local = np.einsum("nai,nij,nbj->nab", frames, stress, frames)
    turned_strain = np.einsum("nai,nij,nbj->nab", frames, strain, frames)
    along = turned_strain[:, [1, 2, 1], [1, 2, 2]] * [1, 1, 2]
    along -= along_surface(initial, tangent[:, :2])
    traction = local[:, 0] * [-1, 1, 1]
    found = SurfaceLaw.of(body, plane).stress(along, traction[:, :size], frames[:, :size, :size])
    pairs = np.array(COMPONENTS)
    np.testing.assert_allclose(found, stress[:, pairs[:, 0], pairs[:, 1]], atol=1e-12)


def full(matrix: Array) -> Array:
    """(3, 3, 3, 3) stiffness that has an inverse as a map of all tensors."""
    skew = np.eye(9).reshape(3, 3, 3, 3)
    return tensor(matrix) + (skew - skew.swapaxes(2, 3)) / 2


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_initial_stress_is_what_holds_a_strain(plane: str) -> None:
    matrix, strain = ORIENTED[2], 1e-3 * np.eye(3)
    found = material(matrix, plane).initial_stress(strain[None])[0]
    held = strain.copy()
    if plane == "stress":
        s = tensor(matrix)
        held[2, 2] = -(s[2, 2, :2, :2] * strain[:2, :2]).sum() / s[2, 2, 2, 2]
    expected = np.einsum("ijkl,kl->ij", tensor(matrix), held)
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


def exact(matrix: Array, places: Array, side: int, size: int) -> Array:
    """(n, c, c) displacements of c components in the model's axes by a unit factor of each mode."""
    x, y = places[:, 0, None], places[:, 1, None]
    tip = CrackTip.of(turned(matrix, WHOLE), size)
    root = np.exp(0.25j * np.pi * side) * np.sqrt(-1j * side * (x + tip.roots * y))
    own = np.sqrt(2 / np.pi) * np.einsum("mia,na->nim", tip.shapes, root).real
    return np.einsum("ai,nam->nim", WHOLE[:size, :size], own)


# Normal y, inward x, along across x inward.
WHOLE = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def factors(
    own: Material, matrix: Array, size: int, element: float, components: int | None = None
) -> Array:
    """(c, c) stress intensity factors by integrals of the exact fields of units of them."""
    count = components or size
    sums = np.zeros((count, count))
    point = np.array([0.0, 0.0, HALF + 0.2])[:size]
    for upper in (True, False):
        body = body_of(own, upper, size, element, components)
        places = body.space.tabulate_dof_coordinates()[:, :size]
        form = InteractionForm(body, ["pad_bottom" if upper else "block_top"], upper)
        moved = exact(matrix, places, 1 if upper else -1, count)
        sums += form.products(Tip(point, WHOLE[:count, :count]), [Tube(0.4, HALF)], moved)[0]
    sums = MPI.COMM_WORLD.allreduce(sums)
    compliance = HalfPlane.of(matrix, WHOLE).compliance[:count, :count]
    return np.linalg.solve(compliance, sums)


@pytest.mark.parametrize(
    ("size", "components", "element", "limit"),
    [
        pytest.param(2, 2, 0.1, 5e-4, marks=pytest.mark.mpi),
        (2, 2, 0.05, 1e-5),
        (2, 3, 0.1, 1e-3),
        (2, 3, 0.05, 1e-5),
        pytest.param(3, 3, 0.1, 1e-3, marks=pytest.mark.mpi),
    ],
)
def test_exact_fields_of_a_crack(size: int, components: int, element: float, limit: float) -> None:
    """All modes, four and eight elements along the radius: 4e-4, 4e-6 and 8e-4 measured."""
    matrix = ORIENTED[components]
    found = factors(material(matrix), matrix, size, element, components)
    np.testing.assert_allclose(found, np.eye(components), atol=limit)


@pytest.mark.parametrize(("size", "components"), [(2, 2), (2, 3), (3, 3)])
def test_equal_roots_give_the_isotropic_factors(size: int, components: int) -> None:
    """By the fields of crystals, which have no closed form where roots are equal: 3e-11."""
    matrix = isotropic_stiffness(100.0, 0.3)
    by_crystal = factors(material(matrix), matrix, size, 0.2, components)
    by_constants = factors(Material(100.0, 0.3, 0.0, "strain"), matrix, size, 0.2, components)
    np.testing.assert_allclose(by_crystal, by_constants, atol=1e-10)


# A cylinder of R = 50 on bodies that are large against the contact.
CYLINDER = {
    "upper_radius": 50.0, "lower_radius": 0.0, "size": 0.02, "zone": 0.8,
    "upper_width": 20.0, "lower_width": 30.0, "lower_height": 30.0, "upper_height": 10.0,
}  # fmt: skip


def tables(body: dict[str, Any], lower: dict[str, Any] | None = None) -> dict[str, Any]:
    geometry = {"template": "cylinder", "parameters": CYLINDER}
    return pad(geometry=geometry, bodies={"upper": body, "lower": lower or body})


def nickel(angle: float) -> dict[str, Any]:
    return {
        "elastic": {"cubic": [252e3, 161e3, 131e3]},
        "orientation": {"euler": [angle, 0.0, 0.0]},
    }


LARGE = {"upper_width": 40.0, "upper_height": 40.0, "lower_width": 90.0, "lower_height": 90.0}


@pytest.mark.parametrize(("bodies", "error"), [({}, 2.5e-3), (LARGE, 5e-4)], ids=["30", "90 mm"])
@pytest.mark.parametrize("angle", [0.0, 30.0])
def test_hertz_with_the_compliance_of_a_crystal(
    solved: Solve, angle: float, bodies: dict[str, float], error: float
) -> None:
    """a, p0 and K_N by A_n. What they miss is the size of the bodies: .2 %, and .02 %."""
    case = tables(nickel(angle))
    case["geometry"]["parameters"] = CYLINDER | bodies
    answer = solved(case)
    half_width = np.sqrt(2 * 600.0 * 50.0 * 2 * 9.14631e-6 / np.pi)
    peak = 2 * 600.0 / (np.pi * half_width)
    contact = answer.contacts[0]
    assert contact.half_width[-1] == pytest.approx(half_width, rel=error)
    pressure = np.asarray(answer.contact_history("main").mean_traction[-1])[:, 0].max()
    assert pressure == pytest.approx(peak, rel=error)
    for station in contact.stations:
        assert station.k_n[-1] == pytest.approx(peak * np.sqrt(2 / half_width), rel=error)


@pytest.mark.parametrize("angle", [0.0, 30.0])
def test_contact_of_a_crystal_is_that_of_half_planes(solved: Solve, angle: float) -> None:
    """Hertz with A_n: 4 A_n instead of 4/E'."""
    answer = solved(tables(nickel(angle)))
    both = 2 * 9.14631e-6
    half_width = np.sqrt(2 * 600.0 * 50.0 * both / np.pi)
    peak = 2 * 600.0 / (np.pi * half_width)
    contact = answer.contacts[0]
    assert not contact.warnings
    for station in contact.stations:
        # The bodies are 17 half-widths wide: .2 to .3 %.
        assert abs(station.position[-1]) == pytest.approx(half_width, rel=5e-3)
        assert station.k_n[-1] == pytest.approx(peak * np.sqrt(2 / half_width), rel=5e-3)
        shear = 2 * 60.0 / (np.pi * np.sqrt(2 * half_width))
        assert station.k_range == pytest.approx(shear, rel=5e-3)
        assert station.k_t_range_fitted == pytest.approx(station.k_range, rel=5e-3)


def test_isotropic_constants_in_21_numbers_are_the_isotropic_run(solved: Solve) -> None:
    steel = {"young": 210e3, "poisson": 0.3}
    numbers = isotropic_stiffness(210e3, 0.3)[np.triu_indices(6)].tolist()
    results = [solved(tables(each)) for each in (steel, {"elastic": {"constants": numbers}})]
    for one, other in zip(*(each.contacts[0].stations for each in results), strict=True):
        assert other.k_n == pytest.approx(one.k_n, rel=1e-10, nan_ok=True)
        assert other.k_range == pytest.approx(one.k_range, rel=1e-10)
        assert other.slip_zones[-1].length == pytest.approx(one.slip_zones[-1].length, rel=1e-9)


def test_crystals_that_couple_pressure_and_shear_are_unlike_bodies(solved: Solve) -> None:
    answer = solved(tables(nickel(0.0), {"young": 70e3, "poisson": 0.1}))
    assert Kind.OSCILLATION in {each.kind for each in answer.warnings}


def test_plane_stress_needs_a_plane_of_symmetry(solved: Solve) -> None:
    askew = nickel(0.0)
    askew["orientation"]["euler"] = [10.0, 20.0, 30.0]
    with pytest.raises(CaseError, match=r"bodies\.upper\.orientation: expected nothing that moves"):
        solved({**tables(askew), "model": {"plane": "stress"}})


def test_stress_near_contacts(tmp_path: Path) -> None:
    """That at the surface is next to that just below; with a cusp at the edge as K_N has one."""
    case = tables(nickel(30.0))
    case["output"] = {"fields": "none", "stress_depths": [0.0, 0.02, 0.04]}
    answer = RUNNER.run(parse_case(case), tmp_path / "run")
    history = answer.stress_history("main")
    middle = np.abs(history.arc - history.arc.mean()) < 0.2
    peak = history.traction[..., 0].max()
    for body in history.bodies:
        surface, *below = np.moveaxis(body.stress, 1, 0)
        line = 2 * below[0] - below[1]
        assert np.abs(surface - line)[:, middle].max() < 0.03 * peak
    assert {each.reason for each in history.edges} == {IS_CRYSTAL}
    upper, _ = answer.stress_parameters("main")
    stress = history.bodies[0].stress[:, 1]
    # Crystal axes at 30 degrees about z: (111)[1-10] by hand.
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    axes = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    normal, slip = np.ones(3) @ axes / np.sqrt(3), np.array([1, -1, 0]) @ axes / np.sqrt(2)
    tensors = np.zeros((*stress.shape[:2], 3, 3))
    for part, (i, j) in enumerate(PLANE_TENSOR):
        tensors[..., i, j] = tensors[..., j, i] = stress[..., part]
    one = np.ptp(np.einsum("tnij,i,j->tn", tensors, slip, normal), axis=0)
    # Of all planes half of the largest chord of the principal stresses.
    span = np.ptp(np.linalg.eigvalsh(tensors), axis=2)
    own = upper.octahedral_shear[1]
    known = np.isfinite(own)
    assert np.all(own[known] >= one[known] * (1 - 1e-12)) and np.isclose(own, one).any()
    assert np.all(own[known] <= span.max(axis=0)[known])
    (table,) = (each for each in export_tables(answer) if each.file == "stress.csv")
    column = [each.name for each in table.headings].index("octahedral_shear")
    below = [row[column] for row in table.rows if row[1] == "upper" and row[2] == 0.02]
    np.testing.assert_array_equal(below, own)
    (shown,) = shown_contacts(answer)
    plot = slip_system_plot(shown)
    assert plot is not None
    for found in answer.stress_parameters("main"):
        for systems, values in zip(
            SLIP_SYSTEMS, (found.octahedral_shear, found.cube_shear), strict=True
        ):
            assert f"{found.body}, {systems}: {number(np.nanmax(values))} MPa" in plot.caption
