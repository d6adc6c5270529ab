# SPDX-License-Identifier: LGPL-3.0-or-later
"""Initial strain: its stress where a body is held, which a contact does not feel; from files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import Run, run

from fretfe._typing import Array
from fretfe.bodies.loads.strain import Layer, StrainAtPoints, StrainBelow
from fretfe.bodies.point_values import PointValues
from fretfe.case import Solid
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.interaction_integral import InteractionForm, Tip, Tube
from fretfe.materials.material import Material
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.surface import boundary_surface

YOUNG, POISSON = 1000.0, 0.3
DEPTH, STRAIN = 0.2, 2e-3
# Grid lines that include those at which the profile bends.
HEIGHTS = np.concatenate([np.linspace(-0.6, -0.3, 4), np.linspace(-0.25, 0, 6)])


def bodies(solid: bool = False, count: int = 8) -> list[BodyMesh]:
    """A punch with a curved lower side on a block."""

    def lifted(points: Array) -> Array:
        x, y = points.T
        return np.stack([x, y + 0.01 * (0.5 - x) ** 2 * (1 - y / 0.4)], axis=1)

    upper = blocks.block(
        "upper", np.linspace(0.2, 0.8, 7), np.linspace(0, 0.4, 4), order=2, mapping=lifted
    )
    lower = blocks.block("lower", np.linspace(0, 1, count + 1), HEIGHTS, order=2)
    if not solid:
        return [upper, lower]
    return list(
        extrude(Mesh({"upper": upper, "lower": lower}), Solid(length=0.3, layers=2)).bodies.values()
    )


def pressed(plane: str = "strain", solid: bool = False, **loads: Any) -> dict[str, Any]:
    """A block between walls, under a punch that is pressed and sheared."""
    steel = {"young": YOUNG, "poisson": POISSON}
    walls = {"left": "lower_left", "right": "lower_right"}
    supports: dict[str, Any] = {
        "base": {"boundary": "lower_bottom", "fix": ["y"]},
        "punch": {"boundary": "upper_left", "fix": ["x"]},
        **{name: {"boundary": boundary, "fix": ["x"]} for name, boundary in walls.items()},
    }
    if solid:
        ends = [f"{name}_{end}" for name in ("upper", "lower") for end in ("back", "front")]
        supports |= {end: {"boundary": end, "fix": ["z"]} for end in ends}
    press = [{"hold": True, "until": 0.5}, {"ramp": -1.0, "until": 1.0, "steps": 2}]
    push = [{"hold": True, "until": 1.0}, {"ramp": -0.2, "until": 2.0, "steps": 1}]
    top = {"type": "traction", "boundary": "upper_top", "direction": "y", "history": press}
    side = {"type": "traction", "boundary": "upper_right", "direction": "x", "history": push}
    contact = {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.3}
    return {
        "model": {} if solid else {"plane": plane},
        "bodies": {"upper": steel, "lower": steel},
        "contacts": {"main": contact},
        "supports": supports,
        "loads": {**loads, "press": top, "push": side},
    }


def peened(depths: list[float], values: list[float]) -> dict[str, Any]:
    return {
        "type": "eigenstrain",
        "surfaces": ["lower_top"],
        "depths": depths,
        "values": values,
        "history": [{"ramp": 2.0, "until": 0.5, "steps": 1}],
    }


def profile(y: Array, depths: list[float], values: list[float]) -> Array:
    return np.asarray(2 * np.interp(-y, depths, values))


PROFILES = {
    "uniform": ([0.0], [STRAIN]),
    "layer": ([0.0, 0.1, DEPTH], [STRAIN, 1.5 * STRAIN, 0.0]),
}


def stress_of(found: Run) -> tuple[Array, Array]:
    """Depths (m,) and stress (m, 4 or 6) of the block at the nodes of its elements, at the end."""
    last = len(found.results), found.steps[-1].amplitudes if found.steps else None
    count, amplitudes = found.model.comm.bcast(last)
    fields = found.fields(count - 1)
    if "lower" not in fields:
        return np.empty(0), np.empty((0, 4))
    body = found.model.bodies["lower"]
    stress = body.elastic.element_stresses(fields["lower"], body.initial_stress(amplitudes))
    nodes = body.elastic.element_nodes()
    return nodes.reshape(-1, nodes.shape[2])[:, 1], stress.reshape(-1, stress.shape[2])


@pytest.mark.mpi
@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize(
    ("plane", "solid"), [("strain", False), ("stress", False), ("strain", True)]
)
def test_a_held_body_has_the_stress_and_its_contact_feels_nothing(
    plane: str, solid: bool, name: str
) -> None:
    """sigma = -E/(1 - nu) e in both directions of the surface, -E e in plane stress."""
    depths, values = PROFILES[name]
    treated = run(pressed(plane, solid, peen=peened(depths, values)), *bodies(solid))
    plain = run(pressed(plane, solid), *bodies(solid))
    pressure = np.abs(plain.tractions).max()
    assert pressure > 1.0
    assert np.abs(treated.tractions - plain.tractions).max() < 1e-10 * pressure
    heights, stress = stress_of(treated)
    modulus = YOUNG / (1 - POISSON) if plane == "strain" else YOUNG
    sizes = -modulus * profile(heights, depths, values)
    plain_stress = stress_of(plain)[1]
    if not len(heights):  # of another rank
        return
    expected = np.zeros_like(stress)
    expected[:, 0] = sizes
    expected[:, 2] = sizes if plane == "strain" else 0.0
    expected += plain_stress
    # Exact: lines of the mesh are where the profile bends.
    assert np.abs(stress - expected).max() < 1e-9 * np.abs(sizes).max()


def test_layer_between_lines_of_the_mesh() -> None:
    """The strain is met at the lines of the mesh, and linear in the elements between them."""
    depths, values = [0.0, 0.11, 0.17], [STRAIN, STRAIN, 0.0]
    treated = run(pressed(peen=peened(depths, values)), *bodies())
    plain = run(pressed(), *bodies())
    pressure = np.abs(plain.tractions).max()
    assert np.abs(treated.tractions - plain.tractions).max() < 1e-10 * pressure
    heights, stress = stress_of(treated)
    found = (stress - stress_of(plain)[1])[:, 0]
    at_lines = profile(HEIGHTS, depths, values)
    sizes = -YOUNG / (1 - POISSON) * np.interp(heights, HEIGHTS, at_lines)
    np.testing.assert_allclose(found, sizes, atol=1e-9 * np.abs(sizes).max())


COLUMNS = ("exx", "eyy", "ezz", "exy", "eyz", "exz")


def from_file(folder: Path, solid: bool, points: Array, strains: Array) -> dict[str, Any]:
    """A strain (n, 6) at points (n, d) of the lower body."""
    size = 3 if solid else 2
    rows = [",".join(("x", "y", "z")[:size] + COLUMNS[: 2 * size])]
    rows += [
        ",".join(f"{value!r}" for value in (*point[:size], *strain[: 2 * size]))
        for point, strain in zip(points.tolist(), strains.tolist(), strict=True)
    ]
    (folder / "strain.csv").write_text("\n".join(rows) + "\n")
    whole = {"file": str(folder / "strain.csv"), "bodies": ["lower"]}
    history = [{"ramp": 2.0, "until": 0.5, "steps": 1}]
    return {"type": "eigenstrain", "history": history, **whole}


@pytest.mark.parametrize("solid", [False, True], ids=["plane", "solid"])
def test_a_profile_from_a_file_is_that_of_a_layer(solid: bool, tmp_path: Path) -> None:
    depths, values = PROFILES["layer"]
    lines = np.array([*depths, 0.6])
    sizes = np.interp(lines, depths, values)
    points = np.stack([0 * lines, -lines, 0 * lines], axis=1)
    strains = np.zeros((len(lines), 6))
    strains[:, [0, 2]] = sizes[:, None]
    by_layer = run(pressed(solid=solid, peen=peened(depths, values)), *bodies(solid))
    given = from_file(tmp_path, solid, points, strains)
    by_file = run(pressed(solid=solid, peen=given), *bodies(solid))
    pressure = np.abs(by_layer.tractions).max()
    assert np.abs(by_file.tractions - by_layer.tractions).max() < 1e-10 * pressure
    stress = stress_of(by_layer)[1]
    assert np.abs(stress_of(by_file)[1] - stress).max() < 1e-9 * np.abs(stress).max()


def test_a_strain_of_its_own_in_each_direction(tmp_path: Path) -> None:
    """In a held block (1 - nu^2) s_xx = -E (e_xx + nu e_zz); e_yy lifts it as a whole."""
    strain = np.array([1e-3, 4e-4, -5e-4, 0.0, 0.0, 0.0])
    points = np.array([[0.0, -0.6], [0.0, 0.0]])
    given = from_file(tmp_path, False, points, np.tile(strain, (2, 1)))
    treated, plain = run(pressed(peen=given), *bodies()), run(pressed(), *bodies())
    pressure = np.abs(plain.tractions).max()
    assert np.abs(treated.tractions - plain.tractions).max() < 1e-10 * pressure
    stress = stress_of(treated)[1] - stress_of(plain)[1]
    xx, zz = 2 * strain[0], 2 * strain[2]
    modulus = YOUNG / (1 - POISSON**2)
    expected = -modulus * np.array([xx + POISSON * zz, 0.0, zz + POISSON * xx, 0.0])
    assert np.abs(stress - expected).max() < 1e-9 * np.abs(expected).max()


TIP, TUBE = Tip(np.array([0.03, 0.0]), np.array([[0.0, 1.0], [1.0, 0.0]])), Tube(0.5)


def forms(load: Any) -> list[tuple[ElasticBody, InteractionForm]]:
    """Two bodies that touch in y = 0, with their integrals; a load by its body and side there."""
    found = []
    for upper, side in ((True, "bottom"), (False, "top")):
        lines, depth = np.linspace(-1, 1, 21), np.linspace(0, 1, 11) - (not upper)
        mesh = blocks.block("b", lines, depth, cell="triangle", order=2)
        elastic = ElasticBody(MPI.COMM_SELF, mesh, Material(200.0, 0.3, 0.0, "strain"), 2)
        own = load(mesh, f"b_{side}")
        found.append((elastic, InteractionForm(elastic, [f"b_{side}"], upper, [own])))
    return found


def test_no_edge_factor_of_a_strain_that_bodies_can_follow() -> None:
    """All components, linear: of u_x = 2 x^2 - 3 x y + y^2 and u_y = x^2 + 4 x y - 2 y^2."""
    points = np.array([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
    x, y = points.T
    exx, eyy = 4 * x - 3 * y, 4 * x - 4 * y
    exy = (-3 * x + 2 * y + 2 * x + 4 * y) / 2
    field = PointValues(points, np.stack([exx, eyy, 0 * x, exy], axis=1))
    load = StrainAtPoints("weld", field)
    by_displacement, by_load = np.zeros((2, 2))
    for elastic, form in forms(lambda mesh, side: load):
        x, y = elastic.space.tabulate_dof_coordinates()[:, :2].T
        moved = np.stack([2 * x**2 - 3 * x * y + y**2, x**2 + 4 * x * y - 2 * y**2], axis=1)
        by_displacement += form.products(TIP, [TUBE], moved[:, :, None])[0][:, 0]
        by_load += form.load_products(TIP, [TUBE])[0][:, 0]
    largest = np.abs(by_load).max()
    # A radial quadrature of 1/sqrt(r) in the element with the tip.
    np.testing.assert_allclose(by_displacement, -by_load, atol=5e-3 * largest)
    assert largest > 1.0


def test_edge_factors_of_a_profile_from_a_file() -> None:
    depths, values = np.array([0.0, 0.3, 1.0]), np.array([2e-3, 1e-3, 0.0])
    points = np.array([[0.0, sign * depth] for sign in (1, -1) for depth in depths[sign < 0 :]])
    sizes = np.concatenate([values, values[1:]])
    strains = np.stack([sizes, 0 * sizes, sizes, 0 * sizes], axis=1)
    field = StrainAtPoints("weld", PointValues(points, strains))

    def layer(mesh: BodyMesh, side: str) -> StrainBelow:
        own = Layer((boundary_surface(mesh, side),), depths, values)
        return StrainBelow("peen", {"b": own})

    for (_, one), (_, other) in zip(forms(layer), forms(lambda mesh, side: field), strict=True):
        expected, found = (form.load_products(TIP, [TUBE])[0][:, 0] for form in (one, other))
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
        assert np.abs(expected).max() > 1e-4
