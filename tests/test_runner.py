# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs in folders that hold their own inputs, or links of somebody else; inputs that change."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
import tomli_w
from cases.pad_cases import pad, press
from harness.launch import fretfe
from harness.told import Told

from fretfe.case import Case, parse_case
from fretfe.errors import OutputError
from fretfe.halfplane import solve_half_planes
from fretfe.runner import Runner

RUNNER = Runner.find("halfplane")
FRICTION = "contacts.main.friction"


@pytest.fixture(scope="module", autouse=True)
def few_elements() -> Iterator[None]:
    with patch(
        "fretfe.backends.halfplane.solve_half_planes", partial(solve_half_planes, elements=60)
    ):
        yield


def write_path(path: Path, force: float) -> None:
    path.write_text(f"t,v\n0,0\n1,{-force / 2}\n2,{-force}\n")


def pressed_by(folder: Path, file: str, **tables: Any) -> Case:
    load = {**press(), "history": [{"csv": file, "time": "t", "value": "v"}]}
    return parse_case(pad(loads={"press": load}, **tables), folder / "pad.toml")


def tree(folder: Path) -> dict[str, bytes]:
    return {str(each): each.read_bytes() for each in folder.rglob("*") if each.is_file()}


def test_inputs_in_the_folder_of_the_results_are_not_removed(tmp_path: Path) -> None:
    """A table among the results of another run, as a sub-model has."""
    out = tmp_path / "out"
    (out / "pictures").mkdir(parents=True)
    for name in ("stations.csv", "results.json"):
        write_path(out / name, 600.0)
    before = tree(out)
    for command in ("run", "sweep", "validate"):
        words = {"sweep": [{FRICTION: [0.4, 0.5]}]}.get(command, [])
        with pytest.raises(OutputError, match=r"expected another folder .*stations\.csv"):
            getattr(RUNNER, command)(pressed_by(tmp_path, "out/stations.csv"), *words, output=out)
        assert tree(out) == before


def test_inputs_beside_the_results_are_read(tmp_path: Path) -> None:
    write_path(tmp_path / "path.csv", 600.0)
    result = RUNNER.run(pressed_by(tmp_path, "path.csv"), tmp_path)
    # The force of the table.
    assert result.contacts[0].normal_force[-1] == pytest.approx(600.0, rel=1e-9)
    assert (tmp_path / "path.csv").exists()


def test_a_mesh_is_not_written_over_a_file_of_its_case(tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text("$MeshFormat")
    tables = pad(geometry={"file": "a.msh"})
    (tmp_path / "pad.toml").write_text(tomli_w.dumps(tables))
    done = fretfe("mesh", tmp_path / "pad.toml", "-o", tmp_path / "a.msh")
    assert done.returncode == 2
    assert "expected a new file" in done.stderr
    assert (tmp_path / "a.msh").read_text() == "$MeshFormat"


@pytest.mark.parametrize("name", ["run.lock", "states", "states/states.rows", "pictures"])
@pytest.mark.parametrize("resume", [False, True])
def test_links_of_somebody_else_are_not_written_through(
    tmp_path: Path, name: str, resume: bool
) -> None:
    outside, out = tmp_path / "outside", tmp_path / "out"
    outside.mkdir()
    (outside / "a.png").write_text("of somebody else")
    target = outside if name in ("states", "pictures") else outside / "a.png"
    (out / name).parent.mkdir(parents=True, exist_ok=True)
    (out / name).symlink_to(target)
    with pytest.raises(OutputError, match=r"link"):
        RUNNER.run(parse_case(pad()), out, resume=resume)
    assert [each.name for each in outside.iterdir()] == ["a.png"]
    assert (outside / "a.png").read_text() == "of somebody else"


@pytest.mark.parametrize("name", ["case.toml", "stations.csv", "report.html"])
def test_files_of_no_run_are_not_replaced(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("of somebody else")
    for resume in (False, True):
        with pytest.raises(OutputError, match=f"found {name} without the run.json"):
            RUNNER.run(parse_case(pad()), tmp_path, resume=resume)
    assert [each.name for each in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "of somebody else"


def test_links_in_place_of_results_are_replaced(tmp_path: Path) -> None:
    outside, out = tmp_path / "outside", tmp_path / "out"
    outside.write_text("of somebody else")
    out.mkdir()
    names = ("run.json", "results.json", "results.h5", "results.h5.new", "case.toml", "cycles.csv")
    for name in names:
        (out / name).symlink_to(outside)
    RUNNER.run(parse_case(pad()), out)
    assert outside.read_text() == "of somebody else"
    assert [name for name in names if (out / name).is_symlink()] == ["results.h5.new"]


def test_a_complete_run_of_other_inputs_is_not_taken_for_this_one(tmp_path: Path) -> None:
    out, file = tmp_path / "out", tmp_path / "path.csv"
    write_path(file, 600.0)
    case = pressed_by(tmp_path, "path.csv")
    RUNNER.run(case, out)
    told = Told()
    RUNNER.run(case, out, told, resume=True)
    assert not told.steps
    mark = json.loads((out / "run.json").read_text())
    assert list(mark["inputs"]) == [str(file)]
    write_path(file, 500.0)
    before = tree(out)
    with pytest.raises(OutputError, match=r"path\.csv has changed since it was read"):
        RUNNER.run(case, out, resume=True)
    assert tree(out) == before


def test_a_sweep_does_not_go_on_with_other_inputs(tmp_path: Path) -> None:
    out, file = tmp_path / "out", tmp_path / "path.csv"
    write_path(file, 600.0)
    case = pressed_by(tmp_path, "path.csv")
    values = {FRICTION: [0.4, 0.5]}
    RUNNER.sweep(case, values, out)
    (digests,) = {
        json.dumps(json.loads(line)["inputs"])
        for line in (out / "variants.jsonl").read_text().splitlines()
    }
    assert json.loads(digests) == json.loads((out / "run.json").read_text())["inputs"]
    write_path(file, 500.0)
    with pytest.raises(OutputError, match=r"path\.csv has changed since it was read"):
        RUNNER.sweep(case, values, out, resume=True)


def test_rows_of_a_sweep_are_all_of_the_same_inputs(tmp_path: Path) -> None:
    """The table changes when the first case is solved."""
    out, file = tmp_path / "out", tmp_path / "path.csv"
    write_path(file, 600.0)

    class Changes(Told):
        def announce(self, text: str) -> None:
            write_path(file, 500.0)

    case = pressed_by(tmp_path, "path.csv")
    sweep = RUNNER.sweep(case, {FRICTION: [0.4, 0.5]}, out, Changes())
    assert [each.failure for each in sweep.variants] == [
        "",
        f"{file}: changed since the sweep began",
    ]
    with (out / "sweep.csv").open() as table:
        rows = list(csv.DictReader(table))
    assert [bool(row["failure"]) for row in rows] == [False, False, True]
