# SPDX-License-Identifier: LGPL-3.0-or-later
"""`fretfe run --ranks`: the command that is started in place of this one."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from unittest.mock import patch

import pytest
from typer.testing import CliRunner

from fretfe.cli.app import app


@pytest.mark.parametrize("words", [["--ranks", "2"], ["--ranks=2"]])
def test_ranks_are_started_by_the_mpirun_beside_python(tmp_path: Path, words: list[str]) -> None:
    python, mpirun = tmp_path / "python", tmp_path / "mpirun"
    mpirun.touch()
    typed = ["run", "pad.toml", *words, "-o", "out", "--set", "a.b=--ranks"]
    with (
        patch("fretfe.environment.sys.executable", str(python)),
        patch.object(sys, "argv", ["fretfe", *typed]),
        patch("fretfe.cli.run.idle_cores", return_value=1),
        patch.object(os, "execv", side_effect=SystemExit) as started,
    ):
        CliRunner().invoke(app, typed)
    rest = ["-P", "-m", "fretfe", "run", "pad.toml", "-o", "out", "--set", "a.b=--ranks"]
    started.assert_called_once_with(str(mpirun), [str(mpirun), "-n", "2", str(python), *rest])


@pytest.mark.parametrize(
    ("ranks", "environment", "expected"),
    [("3", {}, "at most 2, the cores"), ("2", {"PMI_RANK": "0"}, "without mpirun")],
)
def test_ranks_that_cannot_be_started_are_refused(
    ranks: str, environment: dict[str, str], expected: str
) -> None:
    with (
        patch("fretfe.cli.run.idle_cores", return_value=1),
        patch.dict(os.environ, environment),
    ):
        found = CliRunner().invoke(app, ["run", "pad.toml", "-o", "out", "--ranks", ranks])
    assert found.exit_code == 2
    assert expected in " ".join(found.output.split())
