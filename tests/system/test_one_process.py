# SPDX-License-Identifier: LGPL-3.0-or-later
"""A backend that runs on one process, started by mpirun on two: one run, one report."""

from __future__ import annotations

import json
from pathlib import Path
from subprocess import CompletedProcess

from cases.pad_cases import HERTZ
from harness.launch import python


def run(folder: Path, case: str, backend: str) -> CompletedProcess[str]:
    (folder / "case.toml").write_text(case)
    options = ("-o", folder / "out", "--no-report", "--backend", backend)
    return python("-m", "fretfe", "run", folder / "case.toml", *options, ranks=2)


def test_two_processes_make_one_run(tmp_path: Path) -> None:
    done = run(tmp_path, HERTZ, "halfplane")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("step 20/20") == done.stdout.count("Results in") == 1
    assert json.loads((tmp_path / "out" / "results.json").read_text())["ranks"] == 1


def test_two_processes_report_an_error_once(tmp_path: Path) -> None:
    done = run(tmp_path, HERTZ.replace("amplitude = 60", "amplitude = 300"), "halfplane")
    assert done.returncode == 5
    assert done.stderr.count("fretfe: error:") == 1


def test_two_processes_list_the_backends_once() -> None:
    done = python("-m", "fretfe", "backends", ranks=2)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("halfplane") == 1
