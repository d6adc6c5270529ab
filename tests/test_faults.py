# SPDX-License-Identifier: LGPL-3.0-or-later
"""Errors of fretfe itself cost what they have to do with, and nothing else.

Each stage behind the solution is broken in turn; everything else has to be on the disk.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.drawn import write_folder
from cases.pad_cases import cylinder, pad_text, press, shear
from matplotlib.figure import Figure
from typer.testing import CliRunner, Result

from fretfe.backends import halfplane
from fretfe.cli.app import app
from fretfe.errors import FaultError, OutputError
from fretfe.evaluate.plane.edges import PlaneEdges
from fretfe.faults import FAULTS, CollectiveError, collecting, guarded
from fretfe.halfplane import solver
from fretfe.halfplane.solver import HalfPlaneOutcome
from fretfe.history.stream import STATES, Storage
from fretfe.idealise import HalfPlaneProblem
from fretfe.report.pictures import folder as pictures
from fretfe.report.theme import Plot
from fretfe.results.field_files import FIELDS
from fretfe.results.model import Result as Run
from fretfe.results.reader import load_result
from fretfe.results.run_folder import MARK
from fretfe.results.writer import NUMBERS, as_numbers
from fretfe.runner import draw_report

CASE = pad_text(
    geometry=cylinder(size=0.1),
    loads={"press": press(steps=2), "shear": shear(cycles=1, steps=4)},
)
# Where an error is made, and what is unknown for it.
EVALUATION = {
    "fretfe.evaluate.evaluate.separate_patches": "patches of the contacts",
    "fretfe.evaluate.evaluate.evaluate_plane": "contact main",
    "fretfe.evaluate.evaluate.plane_warnings": "contact main",
    "fretfe.evaluate.evaluate.cycle_changes": "contact main",
    "fretfe.backends.halfplane.contact_limits": "limits of the model",
    "fretfe.backends.halfplane.size_limits": "limits of the model",
    "fretfe.backends.halfplane.with_size_errors": "error bars by the size of the bodies",
    "fretfe.backends.halfplane.unlike_notes": "notes",
    "fretfe.results.writer.write_stations": "stations.csv",
    "fretfe.results.writer.write_cycles": "cycles.csv",
    "fretfe.report.page.tables.contact_table": "table of contacts",
    "fretfe.report.page.tables.station_table": "table of edges",
    "fretfe.report.page.tables.cycle_table": "table of counted cycles",
    "fretfe.evaluate.verdicts._excuse": "verdict at left, station 0; verdict at right, station 0",
}


def broken(*_: object, **__: object) -> Any:
    raise ZeroDivisionError("division by zero")


def run(folder: Path, *words: str) -> Result:
    case = folder / "pad.toml"
    case.write_text(CASE)
    out = str(folder / "out")
    command = ["run", str(case), "-o", out, "--backend", "halfplane", *words]
    return CliRunner().invoke(app, command)


@pytest.fixture(scope="module", autouse=True)
def _solved_once() -> Iterator[None]:
    """Steps that are solved are not to be solved again."""
    solve = halfplane.solve_half_planes
    outcomes: list[HalfPlaneOutcome] = []

    def solved(problem: HalfPlaneProblem, **options: Any) -> HalfPlaneOutcome:
        if not outcomes:
            outcomes.append(solve(problem, **{**options, "storage": Storage()}))
        return outcomes[0]

    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(halfplane, "solve_half_planes", solved)
        yield


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The same run without an error."""
    folder = tmp_path_factory.mktemp("sound")
    assert run(folder, "--no-report").exit_code == 0
    return load_result(folder / "out")


def require_told(done: Result, out: Path, place: str) -> None:
    """Check that the end names what is unknown, and where the traceback is."""
    assert isinstance(done.exception, FaultError), done.exception
    assert done.exception.exit_code == 9
    told = str(done.exception)
    assert f"unknown for that reason: {place}. All else is written" in told
    assert "`fretfe info`" in told and str(out / FAULTS) in told
    assert "Traceback" not in done.output
    log = (out / FAULTS).read_text("utf-8")
    assert "Traceback" in log and "ZeroDivisionError: division by zero" in log


@pytest.mark.parametrize("stage", EVALUATION)
def test_a_broken_evaluation_costs_nothing_else(
    stage: str, tmp_path: Path, sound: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stage, broken)
    done = run(tmp_path, "--no-report")
    out = tmp_path / "out"
    require_told(done, out, EVALUATION[stage])
    assert json.loads((out / MARK).read_text())["doing"] == "finished"
    result = load_result(out)
    (contact,), (same,) = result.contacts, sound.contacts
    np.testing.assert_array_equal(result.loads.times, sound.loads.times)
    # P balances the load, whatever the evaluation has to say.
    assert contact.normal_force[-1] == pytest.approx(600, rel=1e-9)
    known = [each for each in contact.stations if np.isfinite(each.reported_k_n)]
    for station in known:
        (other,) = [each for each in same.stations if each.front == station.front]
        assert station.decisive_k_n == pytest.approx(other.decisive_k_n, rel=1e-12)
    unknown = [each for each in contact.stations if each not in known]
    assert all("ZeroDivisionError" in each.lack.text for each in unknown)
    assert contact.stations == () or len(contact.stations) == 2


def test_one_edge_costs_not_the_other(
    tmp_path: Path, sound: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    station = PlaneEdges.station

    def half_broken(edges: PlaneEdges, number: int) -> Any:
        return broken() if edges.front(number)[0] == "right" else station(edges, number)

    monkeypatch.setattr(PlaneEdges, "station", half_broken)
    done, out = run(tmp_path, "--no-report"), tmp_path / "out"
    require_told(done, out, "contact main, right edge")
    left, right = load_result(out).contacts[0].stations
    assert left.decisive_k_n == pytest.approx(sound.contacts[0].stations[0].decisive_k_n, rel=1e-12)
    assert np.isnan(right.decisive_k_n).all() and np.isnan(right.reported_range)
    assert any(
        each.sentence.startswith("right edge: unknown, because fretfe itself failed (ZeroDivisionE")
        for each in load_result(out).contacts[0].warnings
    )


FIGURES = (
    "edges.edge_plot",
    "history.factor_plot",
    "history.load_plot",
    "history.path_plot",
    "history.slip_loop_plot",
    "history.work_loop_plots",
    "tractions.local_plot",
    "tractions.traction_plot",
    "tractions.slip_plot",
)
PAGE = {
    "_sections": "figures",
    "edge_answers": "answers for edges",
    "summary": "summary",
    "contact_table": "table of contacts",
    "cycle_table": "table of counted cycles",
    "body_table": "table of bodies",
    "pair_table": "table of contact surfaces",
    "own_rows": "checks of this run",
    "_certificate_rows": "certificate",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results with bodies, without fields."""
    made = write_folder(tmp_path_factory.mktemp("drawn") / "out", (3.0,))
    (made / FIELDS).unlink()
    return made


@pytest.fixture
def drawn(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy that is drawn in no time; figures of the page have the names of what draws them."""
    monkeypatch.setattr("fretfe.report.page.html.own_rows", lambda _: ())
    monkeypatch.setattr(pictures, "draw_status", lambda *_: (Figure(), "states"))
    for name in FIGURES:
        plot = Plot(name, name, "<svg></svg>")
        found = [plot] if name.endswith("plots") else plot
        monkeypatch.setattr(f"fretfe.report.figures.{name}", lambda *_, found=found: found)
    return Path(shutil.copytree(folder, tmp_path / "out"))


@pytest.mark.parametrize("name", FIGURES)
def test_a_broken_figure_costs_no_other(
    name: str, drawn: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(f"fretfe.report.figures.{name}", broken)
    found = draw_report(drawn)
    assert found.faults and found.failure is None and not found.problems
    page = (drawn / "report.html").read_text("utf-8")
    shown = {each for each in FIGURES if f"<h3>{each}</h3>" in page}
    assert shown == set(FIGURES) - {name}
    assert "Not drawn: figure " in page
    assert "fretfe itself failed (ZeroDivisionError: division by zero)" in page
    assert (drawn / "pictures" / "status.png").exists()
    assert "Traceback" in (drawn / FAULTS).read_text("utf-8")


@pytest.mark.parametrize("part", PAGE)
def test_a_broken_part_of_the_page_costs_no_other(
    part: str, drawn: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(f"fretfe.report.page.html.{part}", broken)
    found = draw_report(drawn)
    assert [fault.place for fault in found.faults] == [PAGE[part]]
    page = (drawn / "report.html").read_text("utf-8")
    for heading in ("Answer", "Pictures", "Solver and checks", "Case", "Terms"):
        assert f">{heading}</h2>" in page
    if part != "_sections":
        assert "<h3>edges.edge_plot</h3>" in page


@pytest.mark.parametrize("part", ["draw_status", "plan_pictures", "save_png", "load_result"])
def test_broken_pictures_cost_no_report(
    part: str, drawn: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pictures, part, broken)
    found = draw_report(drawn)
    (fault,) = found.faults
    assert fault.place in ("picture status.png", "pictures")
    assert "<h3>edges.edge_plot</h3>" in (drawn / "report.html").read_text("utf-8")


def test_an_error_in_the_process_that_draws_is_told(
    drawn: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def draw(directory: Path, files: list[str]) -> dict[str, dict[str, str]]:
        told = {"error": "IndexError: 4", "trace": "Traceback: of another process"}
        return {file: told if file == files[0] else {"reason": "no OpenGL"} for file in files}

    (drawn / FIELDS).touch()
    monkeypatch.setattr(pictures, "draw_in_child", draw)
    found = draw_report(drawn)
    assert {fault.error for fault in found.faults} == {"IndexError: 4"}
    assert "of another process" in (drawn / FAULTS).read_text("utf-8")
    page = (drawn / "report.html").read_text("utf-8")
    assert "fretfe itself failed (IndexError: 4)" in page and "no OpenGL" in page


def test_a_full_disk_behind_the_results_has_its_exit_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> Path:
        raise OutputError("report.html: cannot write the report: the disk is full")

    monkeypatch.setattr("fretfe.report.page.html.write_report", full)
    monkeypatch.setattr("fretfe.report.page.html.draw_plots", lambda _: ())
    done = run(tmp_path)
    assert isinstance(done.exception, OutputError) and done.exception.exit_code == 6
    assert (tmp_path / "out" / "results.json").exists()
    assert "OutputError" not in done.output


def test_steps_are_kept_where_the_numbers_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The folder says why there are none, and the same command goes on from the last step."""
    monkeypatch.setattr(halfplane, "solve_half_planes", solver.solve_half_planes)
    monkeypatch.setattr("fretfe.results.writer.as_numbers", broken)
    done, out = run(tmp_path, "--no-report"), tmp_path / "out"
    assert isinstance(done.exception, FaultError) and done.exception.exit_code == 9
    mark = json.loads((out / MARK).read_text())
    assert mark["reason"] == str(done.exception)
    start = f"{out / NUMBERS}: not written: fretfe itself failed (ZeroDivisionError"
    assert mark["reason"].startswith(start)
    assert "Traceback" in (out / FAULTS).read_text("utf-8")
    assert not (out / NUMBERS).exists() and any((out / STATES).iterdir())
    monkeypatch.setattr("fretfe.results.writer.as_numbers", as_numbers)
    assert run(tmp_path, "--no-report", "--resume").exit_code == 0
    assert load_result(out).contacts[0].normal_force[-1] == pytest.approx(600, rel=1e-9)


def test_guards_raise_what_is_not_theirs(tmp_path: Path) -> None:
    def otherwise(_: object) -> None:
        raise AssertionError

    for error in (OutputError("x"), CollectiveError("x"), MemoryError(), KeyboardInterrupt()):

        def fail(error: BaseException = error) -> None:
            raise error

        with collecting(tmp_path), pytest.raises(type(error)):
            guarded("x", fail, otherwise)
    with pytest.raises(ZeroDivisionError):  # nobody is there to tell it
        guarded("x", broken, otherwise)
