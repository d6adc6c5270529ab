# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs with finite elements that are cut off and continued, refining themselves or not."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from interruptions import CASE, KINDS, SEED, command, finish, kill_rank, one
from launch import ENVIRONMENT
from pad_cases import pad, press, shear
from restarts import cut_and_continued, largest_difference
from told import Told

from fretfe.case import load_case, parse_case
from fretfe.errors import OutputError, StoppedError
from fretfe.results.reader import load_result
from fretfe.runner import Runner

RUNNER = Runner.find("fem")
COARSE = {"geometry.parameters.edge_size": 0.1, "loads.pull.history.3.cycles": 1}
PAD = {
    "template": "cylinder",
    "parameters": {"upper_radius": 50, "upper_width": 12, "lower_radius": 0, "lower_width": 12},
}
HISTORY = {"press": press(steps=3), "shear": shear(20.0, steps=8)}


def dovetail():  # type: ignore[no-untyped-def]
    return load_case(CASE, COARSE)


def test_a_continued_dovetail_is_the_undisturbed_one(tmp_path: Path) -> None:
    case = dovetail()
    RUNNER.run(case, tmp_path / "undisturbed")
    cut_and_continued(case, "fem", tmp_path / "continued", 33)
    assert largest_difference(tmp_path / "undisturbed", tmp_path / "continued") < 1e-12


def test_another_mesh_is_not_continued(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    RUNNER.run(dovetail(), tmp_path, Told(5))
    monkeypatch.setattr("fretfe.fem.prepared.Prepared.digest", "other")
    with pytest.raises(OutputError, match=r"these have changed since: mesh\. Run"):
        RUNNER.run(dovetail(), tmp_path, resume=True)


@pytest.mark.slow
def test_a_continued_solid_is_the_undisturbed_one(tmp_path: Path) -> None:
    tables = pad(geometry={**PAD, "solid": {"length": 2.0, "layers": 2}}, loads=HISTORY)
    tables["geometry"]["parameters"] = {**PAD["parameters"], "size": 0.25, "growth": 0.5}  # type: ignore[dict-item]
    tables["supports"]["base"]["fix"] = ["x", "y", "z"]
    case = parse_case(tables)
    RUNNER.run(case, tmp_path / "undisturbed")
    cut_and_continued(case, "fem", tmp_path / "continued", 6)
    assert largest_difference(tmp_path / "undisturbed", tmp_path / "continued") < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("steps", [5, 25, 50])
def test_a_refinement_goes_on_with_the_mesh_that_it_was_at(tmp_path: Path, steps: int) -> None:
    case = parse_case(pad(geometry=PAD, edges={"tolerance": 0.05}, loads=HISTORY))
    whole = RUNNER.run(case, tmp_path / "undisturbed")
    assert whole.refinement is not None
    count, each = len(whole.refinement.passes), len(whole.loads.times) - 1
    first = RUNNER.run(case, tmp_path / "continued", Told(steps))
    assert isinstance(first.failure, StoppedError) and first.failure.exit_code == 130
    before = load_result(tmp_path / "continued")
    assert before.failure is not None and before.refinement is not None
    told = Told()
    RUNNER.run(case, tmp_path / "continued", told, resume=True)
    assert told.steps[0][0] == steps % each + 1
    assert len(told.steps) == count * each - steps
    assert largest_difference(tmp_path / "undisturbed", tmp_path / "continued") < 1e-12


def stopped_at_a_step(folder: Path, number: signal.Signals, ranks: int = 1) -> tuple[int, str]:
    """Exit code and words of a run that gets a signal after its fifth step; on rank 1, if any."""
    process = subprocess.Popen(
        command(folder, ranks=ranks),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**ENVIRONMENT, "PYTHONUNBUFFERED": "1"},
    )
    with process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("step 5/"):
                break
        if ranks > 1:
            kill_rank(process.pid, number)
        else:
            process.send_signal(number)
        said, _ = process.communicate(timeout=240)
    return process.returncode, said


@pytest.mark.parametrize(
    "number", [signal.SIGTERM, pytest.param(signal.SIGINT, marks=pytest.mark.slow)]
)
def test_a_run_that_is_stopped_keeps_its_steps(tmp_path: Path, number: signal.Signals) -> None:
    code, said = stopped_at_a_step(tmp_path, number)
    assert code == 128 + number, said
    numbers = json.loads((tmp_path / "results.json").read_text())
    steps = len(numbers["times"]) - 1
    assert not numbers["complete"] and 5 <= steps < 120
    assert f"stopped by {number.name} after step {steps} of 120, which are kept" in said
    assert "Traceback" not in said


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_to_one_rank_stops_all(tmp_path: Path, number: signal.Signals) -> None:
    code, said = stopped_at_a_step(tmp_path, number, ranks=2)
    assert code == 128 + number, said
    assert f"stopped by {number.name} after step" in said
    finish(tmp_path, "--resume")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    folder = tmp_path_factory.mktemp("whole")
    return folder, finish(folder)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_interrupted_runs_are_finished(
    tmp_path: Path, undisturbed: tuple[Path, float], kind: str
) -> None:
    if kind == "full disk" and not may_mount():
        pytest.skip("only root may make a small disk")
    whole, seconds = undisturbed
    part = random.Random(f"{SEED} {kind}").random()
    # On other ranks the same to 1e-8.
    assert one(kind, whole, tmp_path / "run", part, seconds) < (
        1e-8 if kind == "killed rank" else 1e-12
    )


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
