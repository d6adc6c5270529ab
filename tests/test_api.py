# SPDX-License-Identifier: LGPL-3.0-or-later
"""The Python interface: what `fretfe.run` and `fretfe.sweep` return, draw and write."""

from __future__ import annotations

import csv
import importlib.metadata
import inspect
import json
import logging
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import HERTZ
from harness.launch import python
from harness.told import Told
from matplotlib import pyplot as plt

import fretfe
from fretfe.api import Result
from fretfe.case import changed
from fretfe.cli.run import run as run_case
from fretfe.errors import (
    CaseError,
    ConvergenceError,
    DependencyError,
    OutputError,
    StoppedError,
)

FRICTION = "contacts.main.friction"


@pytest.fixture(scope="module")
def pad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("api") / "pad.toml"
    path.write_text(HERTZ)
    return path


@pytest.fixture(scope="module")
def solved(pad: Path) -> Result:
    result = fretfe.run(fretfe.load_case(pad), backend="halfplane")
    assert isinstance(result, Result)
    return result


LIGHT = """
import sys
import tomllib
import fretfe
heavy = {"numpy", "matplotlib", "pydantic", "typer", "dolfinx", "fretfe.api"}
print(sorted(heavy & set(sys.modules)), "run" in dir(fretfe), callable(fretfe.run))
try:
    fretfe.rum
except AttributeError as error:
    print(error)
"""


def test_the_package_alone_is_light() -> None:
    done = python("-c", LIGHT)
    assert done.stdout.splitlines() == [
        "[] True True",
        "module 'fretfe' has no attribute 'rum'",
    ], done.stderr


WITHOUT_DOLFINX = """
import sys
import tomllib
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"dolfinx", "dolfinx_solver", "mpi4py", "petsc4py", "gmsh"}:
            raise ImportError(f"{name} is blocked in this test")
sys.meta_path.insert(0, Block())
import fretfe
case = fretfe.load_case(sys.argv[1], {"loads.shear.amplitude": 30})
print(len(fretfe.run(case, backend="halfplane").edges()))
print(len(fretfe.sweep(case, {"contacts.main.friction": [0.3, 0.4]}, "halfplane").records()))
try:
    fretfe.run(case)
except Exception as error:
    print(type(error).__name__)
"""


def test_works_without_dolfinx(pad: Path) -> None:
    done = python("-c", WITHOUT_DOLFINX, pad)
    assert done.stdout.split() == ["2", "4", "DependencyError"], done.stderr


def test_edges_are_flat_records(solved: Result) -> None:
    records = solved.edges()
    assert [(each["contact"], each["edge"]) for each in records] == [
        ("main", "left"),
        ("main", "right"),
    ]
    contact = solved.contacts[0]
    for record, edge in zip(records, contact.stations, strict=True):
        assert {type(value) for value in record.values()} <= {str, float, bool}
        assert record["k_n"] == edge.k_n[edge.decisive]
        assert record["k_t_range"] == edge.k_t_range
        assert record["half_width"] == contact.half_width[edge.decisive]
        assert record["slip_2"] == edge.slip_zones[-1].length
        assert record["slip_1"] == edge.slip_zones[-2].length
        assert record["predicted_2"] == edge.slip_zones[-1].predicted_loop
        assert record["steady"] is True


def test_history_of_an_edge(solved: Result) -> None:
    history = solved.history("main", "right")
    assert list(history) == [
        "time", "loads.press", "loads.shear", "k_n", "k_t", "k_s", "k_i", "position"
    ]  # fmt: skip
    assert {value.shape for value in history.values()} == {(21,)}
    assert history["loads.press"][-1] == -600
    assert np.array_equal(history["k_t"], solved.contacts[0].stations[1].k_t)


def test_history_of_an_edge_that_is_not_there(solved: Result) -> None:
    with pytest.raises(CaseError, match="edges main left, main right, found main middle"):
        solved.history("main", "middle")


@pytest.mark.parametrize(("kind", "panels"), [("tractions", 1), ("factors", 2), ("loads", 2)])
def test_plots_draw_in_new_axes_or_in_those_given(solved: Result, kind: Any, panels: int) -> None:
    drawn = solved.plot(kind)
    assert len(drawn) == panels and all(axes.get_ylabel() for axes in drawn)
    assert drawn[0].figure in [plt.figure(each) for each in plt.get_fignums()]
    figure, given = plt.subplots(1, panels, squeeze=False)
    again = getattr(fretfe, f"plot_{kind}")(solved, given[0])
    assert list(again) == figure.axes == list(given[0])
    for one, two in zip(drawn, again, strict=True):
        assert [each.get_label() for each in one.lines] == [each.get_label() for each in two.lines]
        np.testing.assert_array_equal(one.lines[0].get_ydata(), two.lines[0].get_ydata())
    plt.close("all")


def test_plots_in_the_wrong_number_of_axes_or_of_something_else(solved: Result) -> None:
    with pytest.raises(OutputError, match="expected 2 axes, one for each panel, found 1"):
        fretfe.plot_factors(solved, plt.figure().subplots())
    plt.close("all")
    with pytest.raises(OutputError, match="expected one of tractions, factors, loads, found 'k_n'"):
        solved.plot("k_n")  # type: ignore[arg-type]


def test_logs_of_a_run(pad: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG, "fretfe"):
        result = fretfe.run(fretfe.load_case(pad, {"loads.shear.amplitude": 30}), "halfplane")
    told = [each.getMessage() for each in caplog.records if each.name == "fretfe"]
    assert [each for each in told if each.startswith("step 20 of 20: ")]
    assert result.notes and all(f"{result.case.title}: {note}" in told for note in result.notes)
    warned = [each for each in caplog.records if each.levelno == logging.WARNING]
    assert len(warned) == len(result.warnings)


USER_SCRIPT = """
import fretfe

class Dots(fretfe.Observer):
    def step(self, number: int, count: int, text: str) -> None:
        print(".", end="")

def longest(case: fretfe.Case, frictions: list[float]) -> float:
    sweep: fretfe.Sweep = fretfe.sweep(case, {"contacts.main.friction": frictions}, "halfplane")
    return max(float(record["slip_2"]) for record in sweep.records())

case = fretfe.load_case("pad.toml", {"loads.shear.amplitude": 30.0})
result: fretfe.Result = fretfe.run(case, backend="halfplane", observer=Dots())
axes = result.plot("loads")
fretfe.plot_factors(result, axes)[0].set_title(f"{result.history('main', 'left')['k_n'].max()}")
print(longest(case, [0.4, 0.6]), fretfe.__version__)
"""


@pytest.mark.slow
def test_a_script_of_a_user_passes_strict_checks_of_types(tmp_path: Path) -> None:
    """One with a mistake does not."""
    pytest.importorskip("mypy")
    (tmp_path / "user.py").write_text(USER_SCRIPT)
    (tmp_path / "wrong.py").write_text("import fretfe\nfretfe.rum()\nfretfe.run(3)\n")
    paths = tmp_path / "user.py", tmp_path / "wrong.py"
    done = python("-m", "mypy", "--strict", "--cache-dir", tmp_path, *paths, timeout=280)
    found = [line for line in done.stdout.splitlines() if " error: " in line]
    assert len(found) == 2 and all("wrong.py" in line for line in found), done.stdout


def test_loads_have_the_units_of_their_histories(pad: Path) -> None:
    overrides = {
        "loads.pull": {
            "type": "traction",
            "boundary": "lower_right",
            "direction": "normal",
            "history": [{"hold": True, "until": 1.0}],
        },
        "supports": {
            "base": {"boundary": "lower_bottom", "fix": ["y"]},
            "side": {"boundary": "lower_left", "fix": ["x"]},
        },
        "units.force": "kN",
    }
    result = fretfe.run(fretfe.load_case(pad, overrides), "halfplane")
    panels = fretfe.plot_loads(result)
    labels = [f"{panel.get_title(loc='left')} {panel.get_ylabel()}" for panel in panels]
    assert labels == ["press [kN]", "shear [kN]", "pull [GPa]"]


def test_notebooks_show_a_card_in_which_nothing_is_markup(pad: Path) -> None:
    case = fretfe.load_case(pad, {"title": "<i>P & Q</i>"})
    text = fretfe.run(case, backend="halfplane")._repr_html_()
    assert "<i>" not in text and "&lt;i&gt;P &amp; Q&lt;/i&gt;" in text and "by halfplane" in text
    assert text.count("<tr>") == 3 and text.count("<td>main</td>") == 2
    assert "<th>k_n [MPa/√mm]</th>" in text and "20 states" not in text and "21 states" in text


def test_output_is_that_of_the_command(pad: Path, tmp_path: Path) -> None:
    case = fretfe.load_case(pad, {"loads.shear.amplitude": 30})
    fretfe.run(case, backend="halfplane", output=tmp_path / "api")
    run_case(pad, tmp_path / "command", "halfplane", ["loads.shear.amplitude=30"])
    names = [{path.name for path in (tmp_path / name).iterdir()} for name in ("api", "command")]
    assert names[0] == names[1]
    one, two = (
        json.loads((tmp_path / name / "results.json").read_text()) for name in ("api", "command")
    )
    for numbers in (one, two):
        del numbers["seconds"], numbers["digest"]
    assert one == two
    texts = [(tmp_path / name / "case.toml").read_text() for name in ("api", "command")]
    assert texts[0] == texts[1]


def test_what_is_loaded_is_what_was_run(pad: Path, tmp_path: Path) -> None:
    run = fretfe.run(fretfe.load_case(pad), backend="halfplane", output=tmp_path)
    loaded = fretfe.load_result(tmp_path)
    assert isinstance(loaded, Result)
    assert (run.directory, run.backend) == (loaded.directory, loaded.backend)
    assert (loaded.directory, loaded.backend) == (tmp_path, "halfplane")
    for mine, other in zip(loaded.edges(), run.edges(), strict=True):
        assert mine == pytest.approx(other, nan_ok=True)
    np.testing.assert_array_equal(
        loaded.contact_history("main").traction, run.contact_history("main").traction
    )
    assert {"writing", "pictures", "report"} & set(loaded.seconds) == set()


def test_an_observer_follows_and_ends_a_run(pad: Path, tmp_path: Path) -> None:
    told = Told(most_steps=5)
    with pytest.raises(StoppedError, match="stopped by SIGINT after step 5 of 20") as caught:
        fretfe.run(fretfe.load_case(pad), "halfplane", tmp_path, told)
    assert caught.value.exit_code == 130
    assert [number for number, _, _ in told.steps] == [1, 2, 3, 4, 5]
    stored = fretfe.load_result(tmp_path)
    assert len(stored.loads.times) == 6
    assert str(stored.failure) == str(caught.value)


def test_edges_as_a_data_frame(solved: Result) -> None:
    table = solved.to_dataframe()
    assert list(table.columns) == list(solved.edges()[0])
    assert list(table["edge"]) == ["left", "right"]
    edge = solved.contacts[0].stations[1]
    assert table["k_n"][1] == edge.k_n[edge.decisive]
    units = table.attrs["units"]
    assert list(units) == list(table.columns)
    assert (units["k_n"], units["k_t_range"], units["slip_2"]) == ("MPa/√mm", "MPa·√mm", "mm")
    stations = solved.to_dataframe(stations=True)
    assert list(stations.attrs["units"]) == list(stations.columns)
    assert stations["k_n"][1] == table["k_n"][1] and stations.attrs["units"]["stick_border"] == "mm"


def test_histories_and_tractions_as_a_dataset(solved: Result) -> None:
    data = solved.to_xarray()
    (contact,) = solved.contacts
    assert data["k_t"].dims == ("contact", "edge", "time")
    right = data["k_t"].sel(contact="main", edge="right")
    np.testing.assert_array_equal(right, contact.stations[1].k_t)
    np.testing.assert_array_equal(data["loads"].sel(load="press"), solved.loads.values[:, 0])
    np.testing.assert_array_equal(data["half_width"].sel(contact="main"), contact.half_width)
    history = solved.contact_history("main")
    assert data["main.traction"].dims == ("time", "main.node", "component")
    np.testing.assert_array_equal(data["main.traction"], history.traction)
    np.testing.assert_array_equal(data["main.arc"], history.surface.arc)


@pytest.mark.parametrize(("package", "name"), [("pandas", "to_dataframe"), ("xarray", "to_xarray")])
def test_a_missing_package_is_named(
    solved: Result, monkeypatch: pytest.MonkeyPatch, package: str, name: str
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(DependencyError, match=f"pip install {package}"):
        getattr(solved, name)()


def test_validation_and_its_files(pad: Path, tmp_path: Path) -> None:
    told = Told()
    found = fretfe.validate(fretfe.load_case(pad), "halfplane", tmp_path, told)
    assert found.passed
    assert told.phases[0] == "the case itself" and len(told.phases) > 1
    assert found.result.directory == tmp_path
    assert {path.name for path in tmp_path.iterdir()} == {
        "run.json", "case.toml", "results.json", "results.h5", "stations.csv", "validation.json",
    }  # fmt: skip


def test_a_session_shows_the_interface_and_short_results(solved: Result) -> None:
    assert set(dir(fretfe)) == {*fretfe.__all__, "__version__"}
    shown = repr(solved)
    assert len(shown.splitlines()) == 3 and len(shown) < 400
    contact = solved.contacts[0]
    for each in (contact, contact.stations[0], solved.solution):
        assert len(repr(each)) < 100
    assert contact.name in repr(contact) and f"{contact.stations[0].k_range:.4g}" in repr(
        contact.stations
    )


@pytest.mark.parametrize("act", [fretfe.run, fretfe.validate, lambda it: fretfe.sweep(it, {})])
def test_a_path_is_no_case(act: Callable[[Any], object]) -> None:
    with pytest.raises(TypeError, match=r"as load_case gives it, found 'pad\.toml'"):
        act("pad.toml")


def test_tables_are_a_case(pad: Path) -> None:
    tables = tomllib.loads(pad.read_text())
    case = fretfe.load_case(tables, {FRICTION: 0.3})
    assert case.contacts["main"].friction == 0.3
    assert case.as_tables() == fretfe.load_case(pad, {FRICTION: 0.3}).as_tables()


def test_sweep(pad: Path, tmp_path: Path) -> None:
    case, told = fretfe.load_case(pad), Told()
    frictions = np.linspace(0.3, 0.5, 3)
    sweep = fretfe.sweep(case, {FRICTION: frictions}, "halfplane", output=tmp_path, observer=told)
    records = sweep.records()
    assert [record[FRICTION] for record in records] == [0.3, 0.3, 0.4, 0.4, 0.5, 0.5]
    assert {type(record[FRICTION]) for record in records} == {float}
    expected: list[dict[str, Any]] = []
    for friction in frictions:
        expected += fretfe.run(changed(case, {FRICTION: friction}), "halfplane").edges()
    assert [{name: record[name] for name in expected[0]} for record in records] == expected
    assert len(told.announced) == 3
    assert {path.name for path in tmp_path.iterdir()} == {
        "case.toml",
        "run.json",
        "sweep.csv",
        "sweep.png",
        "variants.jsonl",
    }
    with (tmp_path / "sweep.csv").open(newline="") as file:
        assert len(list(csv.DictReader(file))) == 6


def test_mistakes(pad: Path) -> None:
    case = fretfe.load_case(pad, {"loads.shear.amplitude": 300})
    with pytest.raises(ConvergenceError, match="the backend 'halfplane' cannot solve this case"):
        fretfe.run(case, "halfplane")
    with pytest.raises(CaseError, match="no backend is called 'halfplain'"):
        fretfe.run(case, "halfplain")
    with pytest.raises(CaseError, match="there is no 'mian' in contacts"):
        fretfe.sweep(case, {"contacts.mian.friction": [0.4]}, "halfplane")


def test_the_version_is_that_of_the_package() -> None:
    assert fretfe.__version__ == importlib.metadata.version("fretfe")


OTHERS = [None, 5, "x", [1], {"a": 1}, object(), b"x", 3.5, np.zeros(3), True]
# First arguments that no value of these types can be.
OBJECTS = [
    *("assess", "check", "compare", "compare_tests", "export", "make_mesh", "match_test"),
    *("plot_comparison", "plot_factors", "plot_loads", "plot_scatter", "plot_strength"),
    *("plot_tornado", "plot_tractions", "run", "sweep", "validate", "write_submodel"),
]


@pytest.mark.parametrize("other", OTHERS, ids=lambda other: type(other).__name__)
@pytest.mark.parametrize("name", OBJECTS)
def test_an_argument_of_a_wrong_type_is_named(name: str, other: object) -> None:
    function = getattr(fretfe, name)
    first, *others = inspect.signature(function).parameters.values()
    rest = [None for each in others if each.default is each.empty]
    with pytest.raises(TypeError, match=f"{name}: {first.name}: expected "):
        function(other, *rest)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fretfe.load_case(5), "load_case: path: expected Path | str | Mapping"),  # type: ignore[arg-type]
        (lambda: fretfe.load_case({}, [1]), r"overrides: .*found \[1\]"),  # type: ignore[arg-type]
        (lambda: fretfe.load_result(b"pad"), "load_result: directory: "),  # type: ignore[arg-type]
        (lambda: fretfe.sample({"a": (0, 1)}, "4"), "sample: count: expected int"),  # type: ignore[arg-type]
        (lambda: fretfe.sample({"a": (0, 1)}, True), "sample: count: expected int"),
        (lambda: fretfe.sample({"a": 3}, 4), "sample: bounds: "),  # type: ignore[dict-item]
        (lambda: fretfe.strength_map("t", [5], 1e6), "strength_map: results: "),  # type: ignore[list-item]
        (lambda: fretfe.verify("fem"), "verify: names: "),
    ],
)
def test_other_arguments_of_wrong_types(call: Callable[[], object], message: str) -> None:
    with pytest.raises(TypeError, match=message.replace("|", r"\|")):
        call()


def test_numbers_of_numpy_are_arguments() -> None:
    bounds: Any = {"a": (np.float64(0), np.int64(1))}
    count: Any = np.int64(4)
    points = fretfe.sample(bounds, count)
    assert len(points["a"]) == 4
