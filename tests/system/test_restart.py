# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs with finite elements that are cut off and continued, refining themselves or not."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest
from cases.pad_cases import pad, press, shear, wave
from harness.interruptions import (
    CASE,
    KINDS,
    Course,
    Moment,
    arguments,
    finish,
    kill_rank,
    one,
    read_to_step,
    undisturbed,
)
from harness.launch import started
from harness.restarts import cut_and_continued, largest_difference
from harness.told import Told

from fretfe.case import Case, load_case, parse_case
from fretfe.errors import OutputError, StoppedError
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.runner import Runner

RUNNER = Runner.find("fem")
COARSE = {"geometry.parameters.edge_size": 0.1, "loads.pull.history.3.cycles": 1}
PAD = {
    "template": "cylinder",
    "parameters": {"upper_radius": 50, "upper_width": 12, "lower_radius": 0, "lower_width": 12},
}
HISTORY = {"press": press(steps=3), "shear": shear(20.0, steps=8)}
REFINED = parse_case(pad(geometry=PAD, edges={"tolerance": 0.05}, loads=HISTORY))


def dovetail():  # type: ignore[no-untyped-def]
    return load_case(CASE, COARSE)


def test_a_continued_dovetail_is_the_undisturbed_one(tmp_path: Path) -> None:
    case = dovetail()
    RUNNER.run(case, tmp_path / "undisturbed")
    cut_and_continued(case, "fem", tmp_path / "continued", 33)
    assert largest_difference(tmp_path / "undisturbed", tmp_path / "continued") < 1e-12


def test_another_mesh_is_not_continued(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    RUNNER.run(dovetail(), tmp_path, Told(5))
    monkeypatch.setattr("fretfe.fem.model.Prepared.digest", "other")
    with pytest.raises(OutputError, match=r"these have changed since: mesh\. Run"):
        RUNNER.run(dovetail(), tmp_path, resume=True)


class Removing(Told):
    """Removes a folder after the fifth step."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self._folder = folder

    def step(self, number: int, count: int, text: str) -> None:
        super().step(number, count, text)
        if number == 5:
            shutil.rmtree(self._folder)


def test_a_folder_that_vanishes_is_told_and_not_made_again(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with pytest.raises(OutputError, match="the folder is no longer there"):
        RUNNER.run(dovetail(), folder, Removing(folder))
    assert not folder.exists()


def solid(loads: dict[str, Any]) -> Case:
    tables = pad(geometry={**PAD, "solid": {"length": 2.0, "layers": 2}}, loads=loads)
    tables["geometry"]["parameters"] = {**PAD["parameters"], "size": 0.25, "growth": 0.5}  # type: ignore[dict-item]
    tables["supports"]["base"]["fix"] = ["x", "y", "z"]
    return parse_case(tables)


@pytest.mark.slow
def test_a_continued_solid_is_the_undisturbed_one(tmp_path: Path) -> None:
    case = solid(HISTORY)
    RUNNER.run(case, tmp_path / "undisturbed")
    cut_and_continued(case, "fem", tmp_path / "continued", 6)
    assert largest_difference(tmp_path / "undisturbed", tmp_path / "continued") < 1e-12


@pytest.fixture(scope="module")
def prolonged(tmp_path_factory: pytest.TempPathFactory) -> tuple[Case, Path]:
    """A solid to whose 19 steps cycles of 8 are added, and its undisturbed run."""
    down = {**wave(-200.0, steps=8), "mean": -600.0}
    pressed = press(steps=3)
    pressed["history"] = [*pressed["history"], down]
    case = solid({"press": pressed, "shear": shear(150.0, steps=8)})
    folder = tmp_path_factory.mktemp("prolonged")
    result = RUNNER.run(case, folder)
    # Longer than where any test cuts it off.
    assert len(result.loads.times) - 1 > 41
    return case, folder


@pytest.mark.parametrize("steps", [20, 28, 30, 36, 41])
def test_added_cycles_are_continued(
    prolonged: tuple[Case, Path], tmp_path: Path, steps: int
) -> None:
    """Behind the loads as written, and behind step 27, after which slip is extrapolated."""
    case, undisturbed = prolonged
    cut_and_continued(case, "fem", tmp_path, steps)
    assert largest_difference(undisturbed, tmp_path) < 1e-12


class Ending(Told):
    """Ends the process when it is told for the second time that a cycle is not steady."""

    def announce(self, text: str) -> None:
        super().announce(text)
        if sum(each.startswith("not steady") for each in self.announced) == 2:
            raise KeyboardInterrupt


def test_slip_is_extrapolated_once_more_where_a_run_was_cut_off(
    prolonged: tuple[Case, Path], tmp_path: Path
) -> None:
    case, undisturbed = prolonged
    with pytest.raises(KeyboardInterrupt):
        RUNNER.run(case, tmp_path, Ending())
    told = Told()
    RUNNER.run(case, tmp_path, told, resume=True)
    assert "continued after step 27 of 27" in told.announced
    assert told.steps[0][0] == 28
    assert largest_difference(undisturbed, tmp_path) < 1e-12


@pytest.fixture(scope="module")
def refined(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    folder = tmp_path_factory.mktemp("refined")
    return folder, RUNNER.run(REFINED, folder)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [5, 25, 50])
def test_a_refinement_goes_on_with_the_mesh_that_it_was_at(
    tmp_path: Path, refined: tuple[Path, Result], steps: int
) -> None:
    undisturbed, whole = refined
    assert whole.refinement is not None
    count, each = len(whole.refinement.passes), len(whole.loads.times) - 1
    first = RUNNER.run(REFINED, tmp_path, Told(steps))
    assert isinstance(first.failure, StoppedError) and first.failure.exit_code == 130
    before = load_result(tmp_path)
    assert before.failure is not None and before.refinement is not None
    told = Told()
    RUNNER.run(REFINED, tmp_path, told, resume=True)
    assert told.steps[0][0] == steps % each + 1
    assert len(told.steps) == count * each - steps
    assert largest_difference(undisturbed, tmp_path) < 1e-12


def stopped_at_a_step(folder: Path, number: signal.Signals, ranks: int = 1) -> tuple[int, str]:
    """Exit code and words of a run that gets a signal after its fifth step; on rank 1, if any."""
    with started(*arguments(folder), ranks=ranks) as process:
        said = read_to_step(process, 5)
        if ranks > 1:
            kill_rank(process.pid, number)
        else:
            process.send_signal(number)
        rest, _ = process.communicate(timeout=240)
    return process.returncode, said + rest


def test_a_run_that_is_stopped_keeps_its_steps(tmp_path: Path) -> None:
    code, said = stopped_at_a_step(tmp_path, signal.SIGTERM)
    assert code == 143, said
    numbers = json.loads((tmp_path / "results.json").read_text())
    steps = len(numbers["times"]) - 1
    assert not numbers["complete"] and 5 <= steps < 1530
    assert f"stopped by SIGTERM after step {steps} of 1530, which are kept" in said
    assert "Traceback" not in said


@pytest.mark.slow
def test_a_signal_to_one_rank_stops_all(tmp_path: Path) -> None:
    code, said = stopped_at_a_step(tmp_path, signal.SIGINT, ranks=2)
    assert code == 130, said
    assert "stopped by SIGINT after step" in said
    finish(tmp_path, "--resume")


@pytest.fixture(scope="module")
def course(tmp_path_factory: pytest.TempPathFactory) -> Course:
    return undisturbed(tmp_path_factory.mktemp("whole"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_interrupted_runs_are_finished(tmp_path: Path, course: Course, kind: str) -> None:
    if kind == "full disk" and not may_mount():
        pytest.skip("only root may make a small disk")
    where, difference = one(kind, course, tmp_path / "run", Moment.at(course, 1))
    # On other ranks the same to 1e-8.
    assert difference < (1e-8 if kind == "killed rank" else 1e-12), where


@pytest.mark.slow
@pytest.mark.parametrize(("before", "after"), [(1, 2), (2, 1), (1, 3)])
def test_a_run_goes_on_with_another_number_of_processes(
    tmp_path: Path, course: Course, before: int, after: int
) -> None:
    code, said = stopped_at_a_step(tmp_path / "run", signal.SIGTERM, before)
    assert code == 143, said
    solved = finish(tmp_path / "run", "--resume", ranks=after)
    assert solved[0] > 5
    assert largest_difference(course.folder, tmp_path / "run") < 1e-8


def may_mount() -> bool:
    """True for root, if the machine lets it."""
    if os.geteuid() != 0 or sys.platform != "linux":
        return False
    with tempfile.TemporaryDirectory() as folder:
        mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "none", folder]
        if subprocess.run(mount, capture_output=True).returncode != 0:
            return False
        subprocess.run(["umount", folder], check=True)
    return True
