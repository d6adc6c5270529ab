# SPDX-License-Identifier: LGPL-3.0-or-later
"""A history that is stopped by a signal keeps the steps before."""

from __future__ import annotations

import csv
import json
import pickle
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from cases.pad_cases import HERTZ
from harness.launch import ENVIRONMENT

from fretfe.backends import RunOptions
from fretfe.cli.options import Verbosity
from fretfe.cli.progress import StepReport
from fretfe.errors import StoppedError

LONG = HERTZ.replace("cycles = 2", "cycles = 500")
assert LONG != HERTZ


def stopped(
    arguments: Sequence[str], seen: str, number: signal.Signals, folder: Path
) -> tuple[int, str, str]:
    """Exit code and output of `fretfe` that gets a signal when it has printed some text."""
    (folder / "case.toml").write_text(LONG)
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "fretfe", *arguments],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        env=ENVIRONMENT,
    )
    with process:
        assert process.stdout is not None
        for line in process.stdout:
            if seen in line:
                break
        process.send_signal(number)
        printed, errors = process.communicate(timeout=240)
    return process.returncode, printed, errors


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_run_that_is_stopped_keeps_its_steps(tmp_path: Path, number: signal.Signals) -> None:
    arguments = ["run", "case.toml", "-o", "out", "--backend", "halfplane", "--no-report"]
    code, printed, errors = stopped(arguments, "step 7/", number, tmp_path)
    assert code == 128 + number
    results = json.loads((tmp_path / "out" / "results.json").read_text())
    steps = len(results["contacts"]["main"]["fronts"][0]["stations"][0]["k_n"]) - 1
    assert 7 <= steps < 4004
    assert not results["complete"]
    assert f"stopped by {number.name} after step {steps} of 4004, which are kept" in errors
    assert results["failure"] in errors
    assert "Contact edges" in printed
    assert "Traceback" not in errors


def test_a_sweep_that_is_stopped_writes_its_table(tmp_path: Path) -> None:
    vary = "loads.shear.history.2.cycles=1,500,501,502"
    arguments = ["sweep", "case.toml", "-o", "out", "--backend", "halfplane", "--vary", vary, "-v"]
    code, _, errors = stopped(arguments, "1/4: ", signal.SIGTERM, tmp_path)
    assert code == 143, errors
    with (tmp_path / "out" / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    # Both edges of the first case; one row for each of the others.
    assert [row["failure"].split(" after")[0] for row in rows] == [
        "",
        "",
        *["stopped by SIGTERM"] * 3,
    ]


def test_before_the_first_step_a_signal_ends_the_process() -> None:
    with pytest.raises(KeyboardInterrupt), StepReport(0, Verbosity.QUIET):
        signal.raise_signal(signal.SIGINT)


def test_a_second_signal_ends_the_process(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(KeyboardInterrupt), StepReport(0, Verbosity.QUIET) as report:
        report.step(1, 9, "")
        signal.raise_signal(signal.SIGINT)
        assert "once more stops at once" in capsys.readouterr().err
        signal.raise_signal(signal.SIGINT)


def test_a_signal_after_the_steps_ends_the_process() -> None:
    with pytest.raises(KeyboardInterrupt), StepReport(0, Verbosity.QUIET) as report:
        report.step(9, 9, "")
        report.doing("edge factors")
        signal.raise_signal(signal.SIGINT)


def test_processes_without_steps_leave_a_signal_to_the_first() -> None:
    with StepReport(1, Verbosity.QUIET):
        signal.raise_signal(signal.SIGTERM)


def test_the_last_step_ends_the_history_anyway() -> None:
    with StepReport(0, Verbosity.QUIET) as report:
        options = RunOptions(observer=report)
        options.progress(7, 9, "")
        signal.raise_signal(signal.SIGINT)
        options.progress(9, 9, "")
        with pytest.raises(StoppedError, match="SIGINT after step 8 of 9, which are kept"):
            options.progress(8, 9, "")


def test_what_is_done_besides_steps_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    for verbosity, expected in ((Verbosity.NORMAL, "edge factors ...\n"), (Verbosity.QUIET, "")):
        with StepReport(0, verbosity) as report:
            RunOptions(observer=report).doing("edge factors")
        assert capsys.readouterr().out == expected


def test_handlers_of_others_are_put_back() -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with StepReport(0):
        assert signal.getsignal(signal.SIGTERM) != before[1]
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_other_ranks_get_the_same_error() -> None:
    error = StoppedError(signal.SIGTERM, "after step 3 of 9, which are kept")
    copy = pickle.loads(pickle.dumps(error))
    assert (str(copy), copy.exit_code) == (str(error), 143)
