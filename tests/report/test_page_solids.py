# SPDX-License-Identifier: LGPL-3.0-or-later
"""The report of a run of solids, and the commands that make it."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cases.solid_runs import FRICTION, NORMAL, SHEAR, solid_result, surface, write_solid
from harness.plots import whole_plots
from typer.testing import CliRunner

import fretfe
from fretfe.cli.app import app
from fretfe.errors import CaseError
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.resultants import shear_direction
from fretfe.evaluate.space.fronts import follow_fronts
from fretfe.report.figures.edges import area_plot, force_plot
from fretfe.report.page.html import draw_plots, render
from fretfe.report.page.tables import summary
from fretfe.report.source import extremes
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import write_results


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    shapes = {"left": surface(bend=0.3), "right": surface()}
    return write_solid(tmp_path_factory.mktemp("page") / "results", shapes=shapes)


@pytest.fixture(scope="module")
def text(folder: Path) -> str:
    """The page without its drawings and its style."""
    with whole_plots():
        whole = render(folder)
    page = re.sub(r"<svg.*?</svg>|<style>.*?</style>", "", whole, flags=re.DOTALL)
    return re.sub(r"\s+", " ", page)


def test_answer_says_what_there_is(text: str) -> None:
    assert "left: no edge factors, as " in text and "right: no edge factors, as " in text
    assert "mm² in contact, largest pressure" in text
    assert "slip zones unknown" not in text
    assert "All 36 load steps are solved" in text


def test_numbers_are_those_of_the_run(folder: Path, text: str) -> None:
    left, right = load_result(folder).contacts
    for area in (left, right):
        row = text[text.index(f"<td>{area.name}</td>") :]
        cells = re.findall(r"<td[^>]*>(.*?)</td>", row)[:8]
        force = np.linalg.norm(area.shear_force[20:], axis=1)
        assert cells[2] == f"{force.min():.3g} … {force.max():.3g}"
        assert cells[3] == f"{area.contact_area[-1]:.3g}"
        assert float(cells[5]) == pytest.approx(300.0)
    assert right.shear_force[:, 0].max() == pytest.approx(SHEAR * FRICTION * NORMAL, rel=0.02)


def test_plane_sections_are_absent(text: str) -> None:
    anchors = re.findall(r'<h2 id="(\w+)">', text)
    assert anchors == ["answer", "areas", "loads", "loops", "solver", "case", "run", "terms"]
    assert "per unit thickness" not in text and "Edge factors</" not in text
    # Forces are whole forces.
    assert "N/mm" not in text and "N·mm" in text


def test_load_extremes_are_those_of_the_shear(folder: Path) -> None:
    assert extremes(load_result(folder)) == [24, 32]


def test_histories_have_a_line_for_each_component(folder: Path) -> None:
    run = load_result(folder)
    forces = force_plot(run, run.contacts[0], "a")
    areas = area_plot(run, run.contacts[0], "b")
    assert forces.svg.startswith("<svg") and areas.title.endswith("contact left")
    sections = {section.anchor: section for section in draw_plots(run)}
    assert [plot.title for plot in sections["loops"].plots] == [
        "Contact left",
        "Contact right",
        "Force and displacement: shear",
    ]


def test_direction_of_a_force_that_turns_back_and_forth() -> None:
    wave = np.sin(np.linspace(0, 6, 40))[:, None]
    direction = np.array([-0.6, 0.0, 0.8])
    found = shear_direction(5.0 + wave * direction)
    np.testing.assert_allclose(found, direction, atol=1e-12)


def test_no_cycle_is_said() -> None:
    result = solid_result()
    loads = replace(result.loads, cycle=None)
    told = summary(replace(result, loads=loads))
    assert any(each.startswith("There is no evaluated cycle: no load is a wave") for each in told)


def test_report_command(folder: Path) -> None:
    done = CliRunner().invoke(app, ["report", str(folder)])
    assert done.exit_code == 0
    assert "Hysteresis" in (folder / "report.html").read_text("utf-8")


@pytest.fixture(scope="module")
def with_front() -> Result:
    """A synthetic contact with its front, whose ranges of factors are made up."""
    result = solid_result({"main": surface()})
    (contact,) = result.solution.contacts
    tracks = {"main": follow_fronts(result.solution, contact, 12)}
    (found,) = evaluate(result.solution, tracks=tracks)
    (front,) = found.fronts
    stations = tuple(
        replace(each, k_range=10.0 + each.number, k_range_spread=0.1, k_t_range=9.0, k_s_range=4.0)
        for each in front.stations
    )
    return replace(result, contacts=(replace(found, fronts=(replace(front, stations=stations),)),))


def test_histories_of_stations(with_front: Result) -> None:
    pytest.importorskip("xarray")
    station = with_front.contacts[0].stations[3]
    data, history = with_front.to_xarray(), with_front.history("main", "front 1", 3)
    for name in ("k_n", "k_t", "k_s", "position"):
        np.testing.assert_array_equal(history[name], getattr(station, name))
        np.testing.assert_array_equal(data[name][3], getattr(station, name))
    assert data["k_n"].dims == ("station", "time") and data["front"][3] == "front 1"
    assert [data[f"station_{axis}"][3] for axis in "xyz"] == station.point.tolist()
    with pytest.raises(CaseError, match=r"a station of main front 1 from 0 to 11, found 12"):
        with_front.history("main", "front 1", 12)


def test_factors_are_those_of_the_worst_station(with_front: Result) -> None:
    of_k_n, _ = fretfe.plot_factors(with_front)
    (line, *_) = of_k_n.lines
    assert line.get_label() == "front 1, station 11"
    np.testing.assert_array_equal(line.get_ydata(), with_front.contacts[0].stations[11].k_n)


def test_fronts_are_shown_with_their_verdicts(with_front: Result, tmp_path: Path) -> None:
    shown, stations = with_front, with_front.contacts[0].stations
    write_results(tmp_path, shown)
    with whole_plots():
        page = render(tmp_path)
    assert "(12 unknown)" in page
    assert "Front 1 of contact main" in page
    row = re.search(r"<td>main front 1</td>(.*?)</tr>", page, flags=re.DOTALL)
    assert row is not None and "10 … 21" in row[1]
    assert re.search(r"<td>\s*11 at [\d.]+ \*</td>", page)
    assert shown.contacts[0].fronts[0].worst is stations[11]
    rows = (tmp_path / "stations.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 13 and rows[0].startswith("contact,front,station,arc,x,y,z,inward_x")
    again = load_result(tmp_path).contacts[0].fronts[0]
    np.testing.assert_array_equal(again.stations[3].k_n, stations[3].k_n)
    assert again.stations[3].frame.inward.tolist() == stations[3].frame.inward.tolist()
