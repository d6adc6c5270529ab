# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields that a run writes, and pictures of them, on one process and on two."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import cylinder, pad, pad_text, press, shear
from dolfinx import fem
from dolfinx.mesh import create_box, create_rectangle, to_type
from harness.launch import fretfe, python

from fretfe._typing import Array
from fretfe.backends import RunOptions
from fretfe.case import parse_case
from fretfe.contact.interface import DenseCompliance
from fretfe.errors import OutputError
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.fields import common_modes
from fretfe.fem.model import Request
from fretfe.fem.run import solve
from fretfe.materials.material import Material
from fretfe.results.field_files import FIELDS, FieldReader, FieldWriter

COARSE = cylinder(size=0.05)


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ("extremes", [2.25, 2.75, 3.0]),
        ([1.0, 2.25], [1.0, 2.25]),
    ],
    ids=["extremes", "times"],
)
def test_states_that_are_written(shared_path: Path, fields: Any, expected: list[float]) -> None:
    """K_T swings with the shear force, which is largest at 2.25 and smallest at 2.75."""
    case = parse_case(pad(geometry=COARSE, output={"fields": fields}))
    result = solve(MPI.COMM_WORLD, case, RunOptions(fields=shared_path / FIELDS))
    MPI.COMM_WORLD.barrier()
    if MPI.COMM_WORLD.rank > 0:
        return
    reader = FieldReader(shared_path / FIELDS)
    assert reader.times == pytest.approx(expected)
    assert reader.bodies == ("upper", "lower")
    for name, mesh in result.bodies.items():
        # Each element once, whichever rank has it.
        nodes = reader.nodes(name)[..., :2]
        assert len(nodes) == len(mesh.cells)
        corners = np.sort(np.round(nodes[:, :3].mean(axis=1), 9), axis=0)
        places = np.sort(np.round(mesh.points[mesh.cells[:, :3]].mean(axis=1), 9), axis=0)
        # DOLFINx and Gmsh have the same coordinates to round-off.
        assert np.allclose(corners, places, rtol=0, atol=2e-9)
        # Nodes that elements share are at exactly the same place, on both ranks.
        rows = nodes.reshape(-1, 2)
        assert len(np.unique(rows, axis=0)) == len(np.unique(np.round(rows, 10), axis=0))


def body_of(cell: str, degree: int) -> ElasticBody:
    """A block of 2 × 1 (× 3) of steel."""
    solid = cell in ("tetrahedron", "hexahedron")
    if solid:
        mesh = create_box(MPI.COMM_WORLD, [[0, 0, 0], [2, 1, 3]], [2, 2, 3], to_type(cell))
    else:
        mesh = create_rectangle(MPI.COMM_WORLD, [[0, 0], [2, 1]], [4, 3], to_type(cell))
    body = ElasticBody.__new__(ElasticBody)
    body.comm, body.material = MPI.COMM_WORLD, Material(200.0, 0.3, 0.0, "strain")
    body.name, body.gdim, body.mesh = "block", mesh.geometry.dim, mesh
    body.components = body.gdim
    body.space = fem.functionspace(mesh, ("Lagrange", degree, (body.gdim,)))
    return body


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
def test_fields_are_read_as_they_are_written(tmp_path: Path, cell: str, degree: int) -> None:
    """Displacements of degree 2 are exact between the nodes, as VTK interpolates them.

    Steps are found by their time, cells at any place, and the stress is that of Hooke's law.
    """
    body = body_of(cell, degree)
    gdim, size = body.gdim, np.array([2.0, 1.0, 3.0])[: body.gdim]
    slope = np.array([[1.0, 0.2, 0.1], [0.0, -0.5, 0.3], [0.4, 0.0, 0.7]])[:gdim, :gdim]

    def field(x: Array) -> Array:
        return slope @ x + (degree - 1) * np.stack([x[0] * x[1], x[0] ** 2, x[1] * x[-1]])[:gdim]

    displacement = fem.Function(body.space)
    displacement.interpolate(lambda x: field(x[:gdim]))
    with closing(FieldWriter(tmp_path / FIELDS, {"block": body.element_nodes()})) as writer:
        for factor in (0.0, 1.0):
            values = factor * body.element_displacements(displacement)
            stress = factor * body.element_stresses(displacement)
            writer.add(0.5 + factor, {"displacement": [values], "stress": [stress]})
    grid = read_grid(tmp_path / FIELDS, 1.5)
    assert grid.n_cells == len(body.element_nodes())
    places = np.random.default_rng(0).uniform(0.01, 0.99, (20, gdim)) * size
    probe = pyvista_of(places).sample(grid)
    assert probe["vtkValidPointMask"].all()
    strains = strain_at(slope, places, degree)
    lame, mu = body.material.first_lame, body.material.shear_modulus
    traces = np.trace(strains, axis1=1, axis2=2)[:, None, None]
    stress = 2 * mu * strains + lame * traces * np.eye(3)
    expected = stress[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    # VTK looks for places within an element up to 1e-5 of it.
    assert probe["displacement"][:, :gdim] == pytest.approx(field(places.T).T, abs=1e-4)
    assert probe["stress"] == pytest.approx(expected, rel=1e-4, abs=0.02)


def strain_at(slope: Array, places: Array, degree: int) -> Array:
    """(n, 3, 3) strain of the displacement in the test above."""
    gradient = np.zeros((len(places), 3, 3))
    gdim = len(slope)
    gradient[:, :gdim, :gdim] = slope
    if degree == 2:
        x = places.T
        gradient[:, 0, 0] += x[1]
        gradient[:, 0, 1] += x[0]
        gradient[:, 1, 0] += 2 * x[0]
        if gdim == 3:
            gradient[:, 2, 1] += x[2]
            gradient[:, 2, 2] += x[1]
    return (gradient + gradient.transpose(0, 2, 1)) / 2


def read_grid(path: Path, time: float) -> Any:
    """The grid with its values at a time, as PyVista and VTK read it."""
    pyvista = pytest.importorskip("pyvista")
    reader = pyvista.get_reader(path).reader
    reader.UpdateTimeStep(time)
    return pyvista.wrap(reader.GetOutputDataObject(0))


def pyvista_of(places: Array) -> Any:
    """Points of the plane or of space."""
    pyvista = pytest.importorskip("pyvista")
    return pyvista.PolyData(np.pad(places, [(0, 0), (0, 3 - places.shape[1])]))


def test_fields_that_cannot_be_written_take_nothing_away(tmp_path: Path) -> None:
    case = parse_case(pad(geometry=COARSE, output={"fields": "last"}))
    result = solve(MPI.COMM_SELF, case, RunOptions(fields=tmp_path / "nowhere" / FIELDS))
    assert result.failure is None
    (note,) = result.notes
    assert "fields.hdf: cannot write the fields" in note


def test_a_file_that_holds_no_fields(tmp_path: Path) -> None:
    (tmp_path / FIELDS).write_text("of something else")
    with pytest.raises(OutputError, match=r"fields\.hdf: expected fields of a run, found"):
        FieldReader(tmp_path / FIELDS)


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_run_draws_pictures_once(tmp_path: Path, ranks: int) -> None:
    pytest.importorskip("pyvista")
    loads = {"press": press(steps=2), "shear": shear(cycles=1, steps=8)}
    (tmp_path / "case.toml").write_text(pad_text(geometry=COARSE, loads=loads, output={}))
    out = tmp_path / "out"
    for stale in (FIELDS, "pictures/old.png", "run.json"):
        (out / stale).parent.mkdir(parents=True, exist_ok=True)
        (out / stale).write_text("of an earlier run")
    arguments = ("run", tmp_path / "case.toml", "-o", out)
    done = fretfe(*arguments) if ranks == 1 else python("-m", "fretfe", *arguments, ranks=ranks)
    assert done.returncode == 0, done.stderr
    assert "no pictures" not in done.stdout and done.stdout.count("Results in") == 1
    content = json.loads((out / "pictures" / "pictures.json").read_text())
    if any("OpenGL" in each["reason"] for each in content["missing"]):
        pytest.skip(content["missing"][0]["reason"])
    assert content["missing"] == []
    names = {each["file"] for each in content["pictures"]}
    assert names == {"stress.png", "edges.png", "status.png"}
    assert {path.name for path in (out / "pictures").iterdir()} == {*names, "pictures.json"}
    assert FieldReader(out / FIELDS).times == pytest.approx([1.25, 1.75, 2.0])
    assert "Colours end at" in content["pictures"][1]["caption"]


def test_states_share_few_fields() -> None:
    """Of 40 states that are combinations of three, but for a millionth: three fields are enough."""
    random = np.random.default_rng(3)
    root = random.standard_normal((30, 30))
    compliance = DenseCompliance(root @ root.T)
    parts = [random.standard_normal((3, size)) for size in (30, 4, 2)]
    # Coordinates are displacements, and turns that are small beside them.
    parts[1][:, 2:] *= 1e-5
    factors = random.standard_normal((40, 3))
    exact = [factors @ part for part in parts]
    noisy = [exact[0] + 1e-6 * random.standard_normal((40, 30)), *exact[1:]]
    modes, shares = common_modes([Request(*each) for each in zip(*noisy, strict=True)], compliance)
    assert len(modes) == 3 and shares.shape == (3, 40)
    for name, part in zip(("traction", "coordinates", "amplitudes"), exact, strict=True):
        found = shares.T @ np.array([getattr(each, name) for each in modes])
        assert (np.abs(found - part) <= 2e-4 * np.abs(part).max(axis=0)).all()
