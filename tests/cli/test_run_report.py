# SPDX-License-Identifier: LGPL-3.0-or-later
"""`fretfe run` ends with a report, `fretfe report` makes it again; results stay in any case."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from cases.drawn import write_folder
from cases.pad_cases import HERTZ
from cases.stored_runs import write_run
from harness import launch
from harness.small_files import small_files
from typer.testing import CliRunner

from fretfe.backends.halfplane import BACKEND as HALFPLANE
from fretfe.cli.app import app
from fretfe.cli.run import run as run_case
from fretfe.errors import FaultError
from fretfe.report.page import html
from fretfe.report.pictures.folder import lacks_pictures
from fretfe.results.field_files import FIELDS
from fretfe.results.writer import PICTURE_LIST, PICTURES


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "pad.toml"
    path.write_text(HERTZ)
    return path


def test_run_ends_with_the_report_that_the_command_makes_again(case: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run_case(case, out, "halfplane")
    report = out / "report.html"
    text = report.read_text("utf-8")
    report.unlink()
    done = CliRunner().invoke(app, ["report", str(out)])
    assert done.exit_code == 0 and str(report) in done.stdout.replace("\n", "")
    assert report.read_text("utf-8") == text


def test_a_report_that_does_not_fit_leaves_the_one_before(case: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run_case(case, out, "halfplane")
    report = out / "report.html"
    before = report.read_bytes()
    with small_files(len(before) // 2):
        done = launch.fretfe("report", out)
    assert done.returncode == 6, done.stderr
    assert f"{report}: cannot write the report: " in done.stderr and "Report in" not in done.stdout
    assert report.read_bytes() == before


def test_a_run_keeps_the_report_before_until_it_has_its_own(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    first = launch.fretfe("run", case, "-o", out, "--backend", "halfplane")
    assert first.returncode == 0 and "replaces" not in first.stdout
    (out / "report.html").write_text("of the run before")
    seen: list[str] = []
    solve = HALFPLANE.solve

    def looking(*arguments: Any) -> Any:
        result = solve(*arguments)
        seen.append((out / "report.html").read_text())
        assert not (out / "results.json").exists()
        return result

    monkeypatch.setattr(type(HALFPLANE), "solve", lambda _, *arguments: looking(*arguments))
    run_case(case, out, "halfplane")
    assert seen == ["of the run before"]
    assert (out / "report.html").read_text("utf-8").startswith("<!")
    again = launch.fretfe("run", case, "-o", out, "--backend", "halfplane")
    assert f"This run replaces the results in {out}\n" in again.stdout
    quiet = launch.fretfe("run", case, "-o", out, "--backend", "halfplane", "-q", "--no-report")
    assert not quiet.stdout and not (out / "report.html").exists()


def test_run_without_a_report_leaves_none_of_an_earlier_run(case: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run_case(case, out, "halfplane", report=False)
    (out / "report.html").write_text("of another run")
    run_case(case, out, "halfplane", report=False)
    assert (out / "results.json").exists() and not (out / "report.html").exists()


def test_report_that_fails_is_a_warning(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(directory: Path, plots: object) -> Path:
        raise ZeroDivisionError("no [red]plot[/red]")

    monkeypatch.setattr(html, "write_report", fail)
    with pytest.raises(FaultError, match="unknown for that reason: report"):
        run_case(case, tmp_path / "out", "halfplane")
    printed = capsys.readouterr().out
    assert "report: unknown, because fretfe itself failed (ZeroDivisionError: no [red]pl" in printed
    assert (tmp_path / "out" / "results.json").exists()


def test_pictures_that_were_deleted_are_drawn_again(tmp_path: Path) -> None:
    """If the list is missing, or one of them."""
    out = write_folder(tmp_path / "out", (2.25, 2.75, 3.0))
    (out / FIELDS).unlink()  # without these there is one picture, which takes a second
    status = out / PICTURES / "status.png"
    again = "Drawing the pictures, of which some are missing"
    assert again in launch.fretfe("report", out).stdout
    page = (out / "report.html").read_bytes()
    assert status.exists() and b"data:image/png" in page
    assert not lacks_pictures(out)
    status.unlink()
    assert again in launch.fretfe("report", out).stdout
    assert status.exists() and (out / "report.html").read_bytes() == page


def test_pictures_are_not_drawn_into_another_folder(tmp_path: Path) -> None:
    """Those there would be removed."""
    out, elsewhere = write_folder(tmp_path / "out", (3.0,)), tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "mine.png").write_bytes(b"mine")
    (out / PICTURES).symlink_to(elsewhere)
    done = launch.fretfe("report", out)
    assert (
        done.returncode == 6 and f"{out / PICTURES}: expected a folder, found a link" in done.stderr
    )
    assert [path.name for path in elsewhere.iterdir()] == ["mine.png"]
    (elsewhere / PICTURE_LIST).write_text("{")
    assert "expected a list of pictures" in launch.fretfe("report", out).stderr


@pytest.mark.parametrize("damage", ["empty", "arrays missing"])
def test_folder_without_results_gets_a_message_and_its_code(tmp_path: Path, damage: str) -> None:
    if damage == "arrays missing":
        (write_run(tmp_path, "halfplane") / "results.h5").unlink()
    done = launch.python("-m", "fretfe", "report", tmp_path)
    assert done.returncode == 6
    assert done.stderr.startswith("fretfe: error:") and "Traceback" not in done.stderr
    assert str(tmp_path) in done.stderr and not (tmp_path / "report.html").exists()
