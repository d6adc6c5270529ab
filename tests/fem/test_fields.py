# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields that a run writes, and pictures of them, on one process and on two."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from dolfinx import fem
from dolfinx.io import VTKFile
from dolfinx.mesh import CellType, create_rectangle
from launch import fretfe, python
from pad_cases import cylinder, pad, pad_text, press, shear

from fretfe.backends import RunOptions
from fretfe.case import parse_case
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve

COARSE = cylinder(size=0.05)


def times_of(path: Path) -> list[float]:
    return [float(each.attrib["timestep"]) for each in ET.parse(path).iter("DataSet")]


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
    result = solve(MPI.COMM_WORLD, case, RunOptions(fields=shared_path / "fields"))
    MPI.COMM_WORLD.barrier()
    if MPI.COMM_WORLD.rank > 0:
        return
    for name in ("upper", "lower"):
        assert times_of(shared_path / "fields" / f"{name}.pvd") == pytest.approx(expected)
    pyvista = pytest.importorskip("pyvista")
    del pyvista
    from fretfe.report.pictures.fields import read_body

    for name, mesh in result.bodies.items():
        body = read_body(shared_path / "fields", name, 0, 0.3)
        # Each element once, whichever rank has it.
        assert len(body.cells) == len(mesh.cells)
        corners = np.sort(np.round(body.points[body.cells[:, :3]].mean(axis=1), 9), axis=0)
        places = np.sort(np.round(mesh.points[mesh.cells[:, :3]].mean(axis=1), 9), axis=0)
        # DOLFINx and Gmsh have the same coordinates to round-off.
        assert np.allclose(corners, places, rtol=0, atol=2e-9)


@pytest.mark.parametrize("degree", [1, 2])
def test_quadrilaterals_are_read_in_the_order_they_are_written(tmp_path: Path, degree: int) -> None:
    """A rectangle of 4 × 3 elements: pieces fill it, middles of edges are where they belong."""
    pytest.importorskip("pyvista")
    from fretfe.report.pictures.fields import EDGES, PIECES, read_body
    from fretfe.report.pictures.stress import polygon_areas

    kind = CellType.quadrilateral
    mesh = create_rectangle(MPI.COMM_SELF, [[0, 0], [2, 1]], [4, 3], kind)
    functions = []
    for name, shape in (("displacement", (2,)), ("stress", (2, 2))):
        space = fem.functionspace(mesh, ("DG", degree, shape))
        functions.append(fem.Function(space, name=name))
    functions[0].interpolate(lambda x: x[:2])
    functions[1].interpolate(lambda x: np.stack([x[0], x[1], x[1], 0 * x[0]]))
    with VTKFile(MPI.COMM_SELF, tmp_path / "body.pvd", "w") as file:
        file.write_function(functions, 0.5)
    body = read_body(tmp_path, "body", 0, None)
    assert np.array_equal(body.displacement, body.points)
    assert np.array_equal(
        body.stress, np.stack([*body.points.T * [[1], [0]], body.points[:, 1]], 1)
    )
    corners = body.points[body.cells]
    count = corners.shape[1]
    pieces = corners[:, np.array(PIECES[count])]
    assert polygon_areas(pieces.reshape(-1, 4, 2)).sum() == pytest.approx(2.0)
    assert np.allclose(polygon_areas(corners[:, :4]), 2.0 / 12)
    for edge in EDGES[count]:
        if degree == 2:
            ends = corners[:, [edge[0], edge[2]]]
            assert np.allclose(corners[:, edge[1]], ends.mean(axis=1))
    assert len(body.outline) == 14


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_run_draws_pictures_once(tmp_path: Path, ranks: int) -> None:
    pytest.importorskip("pyvista")
    loads = {"press": press(steps=2), "shear": shear(cycles=1, steps=8)}
    (tmp_path / "case.toml").write_text(pad_text(geometry=COARSE, loads=loads, output={}))
    out = tmp_path / "out"
    for stale in ("fields/old.pvd", "fields/old_p3_000000.vtu", "pictures/old.png"):
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
    assert not list((out / "fields").glob("old*"))
    assert "Colours end at" in content["pictures"][1]["caption"]
