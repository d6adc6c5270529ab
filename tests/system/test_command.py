# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command line as a user meets it: runs, files, and a clear message for each mistake."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
from cases.b1 import PAD_ON_BLOCK as CASE
from cases.b1_meshes import write_b1
from harness.launch import fretfe, python

from fretfe.case import load_case
from fretfe.mesh.make import read_mesh
from fretfe.surface.checks import load_mesh


def on_two_processes(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return python("-m", "fretfe", *arguments, ranks=2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("case")
    write_b1(path / "pad.msh", order=1, h=0.05, growth=0.2)
    (path / "case.toml").write_text(CASE)
    return path


@pytest.fixture(scope="module")
def results(folder: Path) -> Path:
    done = python(
        "-m", "fretfe", "run", folder / "case.toml", "-o", folder / "results", "--timings"
    )
    assert done.returncode == 0, done.stderr
    (folder / "results" / "stdout.txt").write_text(done.stdout)
    return folder / "results"


def test_run_prints_edges_and_where_the_results_are(results: Path) -> None:
    output = (results / "stdout.txt").read_text()
    assert "left" in output and "right" in output
    assert "condensation" in output
    assert str(results) in output.replace("\n", "")


def test_results_hold_what_the_guide_describes(results: Path) -> None:
    data = json.loads((results / "results.json").read_text())
    assert data["schema"] == {"name": "fretfe-results", "version": 10}
    assert data["complete"] is True
    steps = len(data["times"])
    contact = data["contacts"]["main"]
    assert len(contact["normal_force"]) == steps == 20
    assert [front["name"] for front in contact["fronts"]] == ["left", "right"]
    assert len(data["steps"]["certificate"]["worst"]) == steps
    assert data["units"]["stress"] == "MPa"
    assert list(data["drivers"]) == ["press", "shear"]
    with h5py.File(results / "results.h5") as arrays:
        group = arrays["contacts/main"]
        nodes = len(group["arc"])
        assert group["traction"].shape == (steps, nodes, 2)
        assert group["slip"].shape == (steps, nodes, 1)
        assert "mesh/pad/points" in arrays


def test_results_tell_the_case_as_it_was_run(results: Path, folder: Path) -> None:
    case = json.loads((results / "results.json").read_text())["case"]
    assert case["contacts"]["main"]["friction"] == 0.4
    # The mesh has its full path, so that the case runs again from the folder of the results.
    again = load_case(results / "case.toml")
    assert again.geometry.file == str(folder / "pad.msh")
    original = load_case(folder / "case.toml").model_dump(exclude={"geometry"})
    assert again.model_dump(exclude={"geometry"}) == original


@pytest.mark.parametrize("name", ["report.html", "fields.hdf"])
def test_run_writes_pictures_and_fields(results: Path, name: str) -> None:
    assert (results / name).stat().st_size > 0


@pytest.mark.parametrize("ranks", [2, 4])
def test_several_processes_give_the_same_results(results: Path, folder: Path, ranks: int) -> None:
    """Two have a body each; of four, two share each body's factor."""
    out = folder / f"on-{ranks}"
    words = "-m", "fretfe", "run", "--no-report", folder / "case.toml", "-o", out
    done = python(*words, ranks=ranks)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("Results in") == 1
    serial, parallel = (json.loads((path / "results.json").read_text()) for path in (results, out))
    assert parallel["ranks"] == ranks
    for quantity in ("normal_force", "shear_force", "half_width", "centre"):
        compare(serial["contacts"]["main"][quantity], parallel["contacts"]["main"][quantity])
    edges = (
        [front["stations"][0] for front in run["contacts"]["main"]["fronts"]]
        for run in (serial, parallel)
    )
    for one, other in zip(*edges, strict=True):
        for quantity in ("position", "k_n", "k_t", "k_i", "k_t_range"):
            compare(one[quantity], other[quantity])
        lengths = [[zone["length"] for zone in edge["slip_zones"]] for edge in (one, other)]
        compare(*lengths)


def compare(one: object, other: object) -> None:
    first, second = (np.array(values, dtype=float) for values in (one, other))
    scale = np.nanmax(np.abs(first))
    assert np.allclose(first, second, rtol=0, atol=1e-10 * scale, equal_nan=True)


def test_check_lists_what_would_be_solved(folder: Path) -> None:
    done = fretfe("check", folder / "case.toml")
    assert done.returncode == 0, done.stderr
    assert "pad (1) on substrate (2)" in done.stdout
    assert "19 steps" in done.stdout
    assert "pad_contact" in done.stdout and "smallest angle" in done.stdout
    # The platen that moves the pad holds it.
    assert "without contact" not in done.stdout
    assert "The case is valid." in done.stdout


def test_check_tells_which_body_only_contact_holds(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "pad.msh", tmp_path)
    text = CASE.replace('control = "displacement"', 'control = "force"', 1)
    (tmp_path / "case.toml").write_text(text)
    done = fretfe("check", tmp_path / "case.toml")
    assert done.returncode == 0, done.stderr
    assert "Note: without contact pad is free to move along y." in done.stdout


def test_mesh_is_written_and_read_back(folder: Path) -> None:
    done = fretfe("mesh", folder / "case.toml", "-o", folder / "copy.msh")
    assert done.returncode == 0, done.stderr
    assert str(folder / "copy.png") in done.stdout.replace("\n", "")
    assert (folder / "copy.png").read_bytes().startswith(b"\x89PNG")
    copy, original = read_mesh(folder / "copy.msh"), load_mesh(load_case(folder / "case.toml"))
    assert list(copy.bodies) == list(original.bodies)
    for name, body in original.bodies.items():
        assert np.allclose(copy.bodies[name].points, body.points, atol=1e-12)
        assert {k: len(v) for k, v in copy.bodies[name].boundaries.items()} == {
            k: len(v) for k, v in body.boundaries.items()
        }


def test_info_names_versions() -> None:
    done = fretfe("info")
    assert done.returncode == 0
    for name in ("dolfinx", "petsc", "mpi", "BLAS"):
        assert name in done.stdout


def test_schema_is_json() -> None:
    done = fretfe("schema")
    assert "contacts" in json.loads(done.stdout)["properties"]


# What a user gets wrong: edit of the case file, exit code, words that the message must contain.
MISTAKES = {
    "misspelt key": (("friction = 0.4", "frction = 0.4"), 2, ["contacts.main.frction", "friction"]),
    "missing group": (('"pad_contact"', '"pad_contct"'), 3, ["pad_contct", "pad_contact"]),
    "negative modulus": (("young = 210e3", "young = -1.0"), 2, ["bodies.pad.young", "-1"]),
    "incompressible": (("poisson = 0.3", "poisson = 0.5"), 2, ["bodies.pad.poisson", "0.5"]),
    "missing mesh": (('"pad.msh"', '"none.msh"'), 3, ["none.msh"]),
    "nothing holds the block": (('fix = ["x", "y"]', 'fix = ["x"]'), 4, ["substrate", "holds"]),
    "wrong side": (('"substrate_contact"', '"substrate_left"'), 3, ["contacts.main", "wrong way"]),
    "surfaces look away": (
        ('surface1 = "pad_contact"', 'surface1 = "pad_top"'),
        2,
        ["pad_top"],
    ),
    "surfaces never meet": (("ramp = -0.042", "ramp = 0.042"), 4, ["smallest gap"]),
    "history ends before it starts": (("until = 1.0, steps", "until = -1.0, steps"), 2, ["press"]),
}


@pytest.mark.parametrize("mistake", list(MISTAKES))
def test_mistake_gets_a_clear_message(folder: Path, tmp_path: Path, mistake: str) -> None:
    (old, new), code, words = MISTAKES[mistake]
    assert old in CASE
    shutil.copy(folder / "pad.msh", tmp_path)
    (tmp_path / "case.toml").write_text(CASE.replace(old, new, 1))
    done = fretfe("run", "--no-report", tmp_path / "case.toml", "-o", tmp_path / "out")
    assert done.returncode == code, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert all(word in done.stderr for word in words), done.stderr


def test_output_folder_that_cannot_be_written(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = fretfe("run", folder / "case.toml", "-o", tmp_path / "file" / "out")
    assert done.returncode == 6
    assert str(tmp_path / "file") in done.stderr and "Traceback" not in done.stderr


def test_error_on_two_processes_is_one_message(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "pad.msh", tmp_path)
    (tmp_path / "case.toml").write_text(CASE.replace('fix = ["x", "y"]', 'fix = ["x"]'))
    done = on_two_processes("run", "--no-report", tmp_path / "case.toml", "-o", tmp_path / "out")
    assert done.returncode == 4
    assert done.stderr.count("fretfe: error:") == 1


def test_what_was_computed_before_a_failure_is_kept(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "pad.msh", tmp_path)
    # a shear force of 1000 N/mm is more than friction can carry
    text = CASE.replace(
        'direction = "x"\ncontrol = "displacement"', 'direction = "x"\ncontrol = "force"'
    )
    (tmp_path / "case.toml").write_text(text.replace("amplitude = 0.01", "amplitude = 1000.0"))
    done = fretfe("run", tmp_path / "case.toml", "-o", tmp_path / "out")
    assert done.returncode == 5
    assert "step" in done.stderr and "Traceback" not in done.stderr
    data = json.loads((tmp_path / "out" / "results.json").read_text())
    assert data["complete"] is False and data["failure"] in done.stderr.replace("\n", " ")
    assert 4 <= len(data["times"]) < 20
    assert "Not all load steps were solved" in (tmp_path / "out" / "report.html").read_text("utf-8")
