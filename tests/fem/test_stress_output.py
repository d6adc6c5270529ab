# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress near contacts: closed forms of Hertz contacts in partial slip, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from cases.pad_cases import HOLD, cylinder, pad, press, shear, wave
from dolfinx import fem
from dolfinx.mesh import create_box, create_rectangle, to_type
from harness.told import Told
from reference.elliptical_stress import elliptical_stress

import fretfe
from fretfe._typing import Array
from fretfe.case import changed, parse_case
from fretfe.decision.field import EdgeField, edge_field
from fretfe.errors import CaseError, OutputError
from fretfe.evaluate.stress import StressHistory, worst_states
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.fields import StressPoints
from fretfe.materials.material import Material
from fretfe.report.figures.tractions import slip_system_plot, stress_plot
from fretfe.report.source import shown_contacts
from fretfe.report.texts import with_error
from fretfe.results.hdf5_file import STRESSES, read_stress
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.runner import Runner

RUNNER = Runner.find("fem")
# R = 50, P = 600, Q = 60, f = 0.4, steel in plane strain.
E_STAR = 210e3 / (2 * (1 - 0.3**2))
A = np.sqrt(4 * 600 * 50 / (np.pi * E_STAR))
P0 = 2 * 600 / (np.pi * A)
C = A * np.sqrt(1 - 60 / (0.4 * 600))
DEPTHS = [0.0, 0.03, 0.1]
LOADS = {"press": press(), "shear": shear(steps=8)}


def case_of(size: float, **changed: Any) -> Any:
    output = {"fields": "none", "stress_depths": DEPTHS}
    tables = {"geometry": cylinder(size=size), "loads": LOADS, "output": output}
    return parse_case(pad(**{**tables, **changed}))


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """The pad with elements of 0.01 at the contact: eight in a slip zone."""
    return RUNNER.run(case_of(0.01), tmp_path_factory.mktemp("pad"))


def exact(x: Array, depth: float, body: int, way: float) -> Array:
    """(n, 3) stress of half-planes at an extreme of the shear: the slip zones of first loading.

    Body 1 is body 2 turned upside down, under the opposite shear.
    """
    side = way if body == 1 else -way
    shear = 0.4 * P0 * side
    slip = elliptical_stress(x, depth, A, 0.0, shear)
    stick = elliptical_stress(x, depth, C, 0.0, shear * C / A)
    return (slip - stick) * [1, 1, 1 if body == 1 else -1]


def swing(history: StressHistory, values: Array) -> Array:
    """Half the difference between the extremes of Q.

    What the size of the bodies adds to pressing, 3.5 % of p0 here, is the same in both.
    """
    ends = [int(np.argmin(np.abs(history.times - time))) for time in (2.25, 2.75)]
    return np.asarray(values[ends[0]] - values[ends[1]]) / 2


def test_stress_along_the_surface_at_the_edges(solved: Result) -> None:
    """2 f p0 sqrt(1 - c²/a²), tension at the trailing edge: within 1 %, and within its bar."""
    history = solved.stress_history("main")
    expected = 2 * 0.4 * P0 * np.sqrt(1 - (C / A) ** 2)
    assert len(history.edges) == 4
    for each in history.edges:
        trailing = (each.edge == "left") == (each.body == "lower")
        found = swing(history, each.value)
        assert found == pytest.approx(expected if trailing else -expected, rel=0.01)
        known = np.isfinite(each.spread)
        assert abs(abs(found) - expected) < each.spread[known].max()
        # Just after a reversal next to nothing slips.
        assert 0 < known.sum() < len(known)
        assert "slip" in each.reason and not each.largest.reason


@pytest.mark.parametrize(("number", "depth"), [(b, d) for b in (0, 1) for d in range(3)])
def test_stress_at_depths(solved: Result, number: int, depth: int) -> None:
    history = solved.stress_history("main")
    x = history.arc
    found = swing(history, history.bodies[number].stress[:, depth])[:, [0, 1, 3]]
    expected = exact(x, DEPTHS[depth], number, 1.0)
    # At the surface without what is next to the edges and the borders of slip, where the stress has
    # roots that nodes see by the root of the element size.
    distance = np.abs(np.abs(x)[:, None] - [A, C]).min(axis=1)
    seen = (np.abs(x) < 0.9) & ((distance > 0.03) | (DEPTHS[depth] > 0))
    assert seen.sum() > 50
    largest = np.abs(found - expected)[seen].max()
    assert largest < (0.006 if depth == 0 else 0.004) * P0


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("edge", [0, 1])
def test_stress_on_rays_from_an_edge(solved: Result, number: int, edge: int) -> None:
    """From the files alone: of the tractions, and of what elements have beside it."""
    contact = solved.contacts[0]
    field = edge_field(solved, contact, contact.stations[edge], number)
    assert isinstance(field, EdgeField)
    history, sign = solved.stress_history("main"), contact.stations[edge].inward
    for angle in (0.0, 0.6, -0.6):
        distances = np.array([0.01, 0.02, 0.05, 0.09])
        assert distances.max() < field.reach(angle)
        found = swing(history, field.along(angle, distances))[:, [0, 1, 3]]
        x = sign * (distances * np.sin(angle) - A)
        known = np.array([
            exact(at[None], depth, number, 1.0)[0] * [1, 1, sign if number else -sign]
            for at, depth in zip(x, distances * np.cos(angle), strict=True)
        ])  # fmt: skip
        assert np.abs(found - known).max(axis=1) == pytest.approx([0, 0, 0, 0], abs=0.004 * P0)
    assert 0 < field.smooth.spread < 0.005 * P0


def test_within_an_element_next_to_an_edge_nothing_is_told(tmp_path: Path) -> None:
    history = RUNNER.run(case_of(0.05), tmp_path).stress_history("main")
    away = np.abs(np.abs(history.arc) - A)
    for body in history.bodies:
        shallow = np.isnan(body.stress[:, 1]).all(axis=(0, 2))
        assert shallow[away < 0.09].all() and not shallow[(away > 0.11) & (away < 0.3)].any()
        assert np.isfinite(body.stress[:, [0, 2]][:, :, away < 0.3]).all()


def test_parameters_along_the_contact(solved: Result) -> None:
    """Most damage next to the edges, less below; Ruiz 2 is Ruiz 1 times the tension."""
    x, ruiz = solved.stress_history("main").arc, solved.local_parameters("main").ruiz
    for found in solved.stress_parameters("main"):
        assert found.fatemi_socie is None
        worst = np.abs(x[np.nanargmax(found.swt[0])])
        assert C - 0.02 < worst < A + 0.02
        assert 0 < np.nanmax(found.swt[2]) < np.nanmax(found.swt[1]) < np.nanmax(found.swt[0])
        known = np.isfinite(found.ruiz2)
        expected = np.maximum(found.largest_tension[0], 0) * ruiz
        assert np.nanmax(expected) > 0
        assert found.ruiz2[known] == pytest.approx(expected[known], rel=1e-9)


def test_tables_have_the_parameters(solved: Result, tmp_path: Path) -> None:
    files = {path.name: path for path in fretfe.export(solved, tmp_path, fatemi_socie=(0.5, 350.0))}
    table, edges = (pd.read_csv(files[name]) for name in ("stress.csv", "edge_stress.csv"))
    _, lower = solved.stress_parameters("main", (0.5, 350.0))
    assert lower.fatemi_socie is not None
    rows = table[(table["body"] == "lower") & (table["depth [mm]"] == DEPTHS[1])]
    assert rows["swt [MPa]"].to_numpy() == pytest.approx(lower.swt[1], nan_ok=True)
    assert rows["fatemi_socie"].to_numpy() == pytest.approx(lower.fatemi_socie[1], nan_ok=True)
    assert rows["ruiz2 [MPa^2*mm]"].isna().all()
    found = [each.largest.value for each in solved.stress_history("main").edges]
    assert edges["largest_tension [MPa]"].to_numpy() == pytest.approx(found)
    with pytest.raises(CaseError, match=r"k >= 0 and a yield stress > 0 .* -1 and 350"):
        fretfe.export(solved, tmp_path, fatemi_socie=(-1.0, 350.0))


@pytest.mark.pictures
def test_the_report_tells_the_stress_at_the_edges(solved: Result) -> None:
    (shown,) = shown_contacts(solved)
    plot = stress_plot(shown)
    assert plot is not None
    assert slip_system_plot(shown) is None  # of isotropic bodies
    for each in solved.stress_history("main").edges:
        value = with_error(each.largest.value, each.largest.spread)
        assert f"{value} MPa ({each.edge} edge, {each.body})" in plot.caption


def test_too_few_elements_in_the_slip_zone_are_told(tmp_path: Path) -> None:
    RUNNER.run(case_of(0.03), tmp_path)
    history = read_stress(tmp_path, "main")
    for each in history.edges:
        assert np.isnan(each.largest.value)
        assert each.largest.reason.startswith("the slip zone has") or "slips" in each.reason


@pytest.mark.mpi
def test_plane_stress_on_all_ranks(shared_path: Path) -> None:
    """Without sigma_zz; K and stress of half-planes with E* = E/2."""
    case = case_of(0.02, model={"plane": "stress"})
    result = RUNNER.run(case, shared_path)
    MPI.COMM_WORLD.barrier()
    if MPI.COMM_WORLD.rank > 0:
        return
    history = result.stress_history("main")
    half_width = np.sqrt(4 * 600 * 50 / (np.pi * 105e3))
    pressure = 2 * 600 / (np.pi * half_width)
    x, states = history.arc, [int(np.argmin(np.abs(history.times - t))) for t in (2.25, 2.75)]
    for body in history.bodies:
        assert np.nanmax(np.abs(body.stress[..., 2])) == 0
        mean = body.stress[states].mean(axis=0)[1:]
        for depth, own in zip(DEPTHS[1:], mean, strict=True):
            across = elliptical_stress(x, depth, half_width, pressure, 0.0)[:, 1]
            seen = np.abs(x) < 0.9
            # 2e-3 measured; pressing on 12 mm wide bodies adds 0.3 %.
            assert np.abs(own[:, 1] - across)[seen].max() < 0.01 * pressure


def body_of(cell: str, degree: int) -> ElasticBody:
    """A block of 2 × 1 (× 3)."""
    if cell in ("tetrahedron", "hexahedron"):
        mesh = create_box(MPI.COMM_WORLD, [[0, 0, 0], [2, 1, 3]], [2, 2, 3], to_type(cell))
    else:
        mesh = create_rectangle(MPI.COMM_WORLD, [[0, 0], [2, 1]], [4, 3], to_type(cell))
    body = ElasticBody.__new__(ElasticBody)
    body.comm, body.material = MPI.COMM_WORLD, Material(200.0, 0.3, 0.0, "strain")
    body.gdim, body.mesh, body.degree, body.order = mesh.geometry.dim, mesh, degree, 1
    body.components = body.gdim
    body.space = fem.functionspace(mesh, ("Lagrange", degree, (body.gdim,)))
    return body


@pytest.mark.mpi
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
def test_stress_at_points_is_hookes_law(cell: str, degree: int) -> None:
    """Of displacements that the elements have exactly; each point on some rank, or outside."""
    body = body_of(cell, degree)
    gdim = body.gdim
    slope = np.array([[1.0, 0.2, 0.1], [0.0, -0.5, 0.3], [0.4, 0.0, 0.7]])[:gdim, :gdim]
    displacement = fem.Function(body.space)

    def field(x: Array) -> Array:
        return slope @ x[:gdim] + (degree - 1) * np.stack([x[0] * x[1], x[0] ** 2, x[1] * x[-1]])[
            :gdim
        ] * (gdim == 3)

    displacement.interpolate(field)
    points = np.random.default_rng(1).uniform(0.01, 0.99, (30, gdim)) * [2, 1, 3][:gdim]
    points[0] = [3.0, 0.5, 1.0][:gdim]
    points[1] = np.nan
    at = StressPoints(body, points)
    whole = np.full((len(points), 4 if gdim == 2 else 6), np.nan)
    for found, values in MPI.COMM_WORLD.allgather((at.found, at.stress(displacement))):
        whole[found] = values
    assert np.isnan(whole[:2]).all()
    gradient = np.zeros((len(points), 3, 3))
    gradient[:, :gdim, :gdim] = slope
    if gdim == 3 and degree == 2:
        x, y, z = points.T
        gradient[:, 0, 0] += y
        gradient[:, 0, 1] += x
        gradient[:, 1, 0] += 2 * x
        gradient[:, 2, 1] += z
        gradient[:, 2, 2] += y
    strain = (gradient + gradient.swapaxes(1, 2)) / 2
    lame, mu = body.material.first_lame, body.material.shear_modulus
    trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
    stress = 2 * mu * strain + lame * trace * np.eye(3)
    pairs = np.array(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)))[: whole.shape[1]]
    expected = stress[:, pairs[:, 0], pairs[:, 1]]
    assert whole[2:] == pytest.approx(expected[2:], rel=1e-10, abs=1e-9)


def test_a_continued_run_has_the_same_stress(tmp_path: Path) -> None:
    case = case_of(0.05)
    RUNNER.run(case, tmp_path / "whole")
    RUNNER.run(case, tmp_path / "cut", Told(9))
    assert read_stress(tmp_path / "cut", "main").states[-1] == 9
    told = Told()
    RUNNER.run(changed(case, {"output.fields": "last"}), tmp_path / "cut", told, resume=True)
    one, other = (load_result(tmp_path / name).stress_history("main") for name in ("whole", "cut"))
    assert np.array_equal(one.states, other.states)
    for first, second in zip(one.bodies, other.bodies, strict=True):
        assert first.stress == pytest.approx(second.stress, rel=1e-9, abs=1e-6, nan_ok=True)
    # What takes long besides the steps, before them and behind them, is named as it begins.
    begun = [each.split(":")[0] for each in told.done]
    assert list(dict.fromkeys(begun)) == [
        "mesh",
        "condensation of the bodies",
        "edge factors",
        "evaluation of edges and slip zones",
        "stress near the contacts",
        "fields",
    ]
    assert told.done[1].startswith("condensation of the bodies: upper, ")
    assert "edge factors: 2 of 2" in told.done and told.done[-1].startswith("fields: 1 of ")


def test_irregular_loads_have_the_states_of_the_worst_cycle(tmp_path: Path) -> None:
    """Of a cycle of 60 and one of 30 the way through the larger one, which comes first."""
    waves = [wave(amplitude, cycles=1, steps=8) for amplitude in (60.0, 30.0)]
    loads = {"press": press(), "shear": {**shear(), "history": [HOLD, *waves]}}
    case = case_of(0.05, loads=loads, cycle={"start": 1.0, "end": 3.0})
    result = RUNNER.run(case, tmp_path)
    found = result.stress_history("main").states
    assert np.array_equal(found, worst_states(result.solution, result.contacts))
    forces = result.loads.values[found, result.loads.channels.index("shear")]
    assert (forces.min(), forces.max()) == pytest.approx((-60, 60))
    assert len(found) < 17


def test_nothing_is_written_unless_it_is_asked_for(tmp_path: Path) -> None:
    case = case_of(0.05, output={"fields": "none"})
    RUNNER.run(case, tmp_path)
    assert not (tmp_path / STRESSES).exists()
    with pytest.raises(OutputError, match=r"stress\.h5: .*\[output\] stress_depths"):
        load_result(tmp_path).stress_history("main")
