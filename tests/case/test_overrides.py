# SPDX-License-Identifier: LGPL-3.0-or-later
"""Values of a case set from outside its file: where they go, what is refused, what is written."""

from __future__ import annotations

import copy
import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import HERTZ, pad, pad_text
from harness.launch import fretfe

from fretfe.case import as_written, case_text, changed, load_case, parse_assignments, parse_case
from fretfe.case.overrides import parse_value, with_overrides
from fretfe.errors import CaseError

DATA = tomllib.loads(HERTZ)
SOURCE = Path("pad.toml")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "pad.toml"
    path.write_text(HERTZ)
    return path


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("120", 120),
        ("-1.5e3", -1500.0),
        ("true", True),
        ('"120"', "120"),
        ("[1, 2]", [1, 2]),
        ('["x"]', ["x"]),
        ("{ a = 1 }", {"a": 1}),
        ("none", "none"),
        ("True", "True"),
        ("two words", "two words"),
        ("", ""),
        ("[1", "[1"),
        # one value, not a document
        ("1\nother = 2", "1\nother = 2"),
    ],
)
def test_value(text: str, value: Any) -> None:
    assert parse_value(text) == value
    assert type(parse_value(text)) is type(value)


def at(data: Any, *path: str | int) -> Any:
    for key in path:
        data = data[key]
    return data


@pytest.mark.parametrize(
    ("path", "place"),
    [
        ("title", ("title",)),
        ("contacts.main.friction", ("contacts", "main", "friction")),
        ("loads.shear.history.2.amplitude", ("loads", "shear", "history", 1, "amplitude")),
        ("loads.shear.amplitude", ("loads", "shear", "history", 1, "amplitude")),
        # in no segment yet, and possible in one
        ("loads.shear.mean", ("loads", "shear", "history", 1, "mean")),
        ("loads.press.ramp", ("loads", "press", "history", 0, "ramp")),
        # a key of the load is not looked for in its segments
        ("loads.shear.direction", ("loads", "shear", "direction")),
        ("supports.base.fix.2", ("supports", "base", "fix", 1)),
        ("geometry.parameters.size", ("geometry", "parameters", "size")),
        # tables that the file does not have
        ("model.degree", ("model", "degree")),
        ("edges.tolerance", ("edges", "tolerance")),
        # checked by the reader, which knows the keys
        ("contacts.main.frction", ("contacts", "main", "frction")),
    ],
)
def test_place(path: str, place: tuple[str | int, ...]) -> None:
    before = copy.deepcopy(DATA)
    data = with_overrides(DATA, {path: "new"}, SOURCE)
    assert at(data, *place) == "new"
    assert before == DATA
    assert json.dumps(data).count('"new"') == 1


def test_star_stands_for_every_key() -> None:
    data = with_overrides(DATA, {"bodies.*.young": 70e3, "loads.*.history.*.until": 2.0}, SOURCE)
    assert [body["young"] for body in data["bodies"].values()] == [70e3, 70e3]
    untils = [each["until"] for load in data["loads"].values() for each in load["history"]]
    assert untils == [2.0] * 3


MISTAKES = {
    "contact.main.friction": "there is no 'contact' in the file; did you mean 'contacts'?",
    "contacts.mian.friction": "there is no 'mian' in contacts; did you mean 'main'?",
    "loads.pull.amplitude": "there is no 'pull' in loads, expected one of 'press', 'shear'",
    "loads.shear.amplitud": "did you mean 'amplitude'?",
    "loads.shear.history.3.until": "expected a number from 1 to 2 after loads.shear.history",
    "loads.shear.history.0.until": "expected a number from 1 to 2",
    "loads.shear.history.wave.until": "expected a number from 1 to 2",
    "contacts.main.friction.x": "expected a table or a list at contacts.main.friction, found 0.4",
    "title.*": "expected a table or a list for the '*', found 'Cylindrical",
}


@pytest.mark.parametrize("path", MISTAKES)
def test_path_that_leads_nowhere(path: str) -> None:
    with pytest.raises(CaseError) as error:
        with_overrides(DATA, {path: 1.0}, SOURCE)
    assert str(error.value).startswith(f"pad.toml: {path}: ")
    assert MISTAKES[path] in str(error.value)


def test_key_of_several_segments() -> None:
    data = copy.deepcopy(DATA)
    data["loads"]["press"]["history"] *= 2
    with pytest.raises(CaseError, match=r"2 segments .* 'ramp'; give .*1\.ramp or .*2\.ramp"):
        with_overrides(data, {"loads.press.ramp": 1.0}, SOURCE)


def test_all_paths_that_lead_nowhere_are_listed() -> None:
    with pytest.raises(CaseError) as error:
        with_overrides(DATA, {"contacts.mian.friction": 1, "loads.pull.ramp": 1}, SOURCE)
    assert len(str(error.value).splitlines()) == 2


@pytest.mark.parametrize("text", ["friction", "=1", "contacts..friction=1", ".=1"])
def test_not_an_assignment(text: str) -> None:
    with pytest.raises(CaseError, match=r"--set: expected KEY=VALUE"):
        parse_assignments([text])


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("contacts.main.friction=much", "main.friction: expected a number, found text 'much'"),
        ("contacts.main.friction=-1", "main.friction: expected a number >= 0, found -1"),
        ("contacts.main.frction=1", "frction: unknown key; did you mean 'friction'"),
        ("loads.shear.steps_per_cycle=3", "history[segment 2].steps_per_cycle: expected a number"),
    ],
)
def test_values_are_checked_by_the_reader(file: Path, assignment: str, message: str) -> None:
    with pytest.raises(CaseError) as error:
        load_case(file, parse_assignments([assignment]))
    assert message in str(error.value)
    assert str(error.value).startswith(str(file))


def test_overrides_count(file: Path) -> None:
    case = load_case(file, parse_assignments(["contacts.main.friction=0.5", "title=Other"]))
    assert (case.contacts["main"].friction, case.title) == (0.5, "Other")
    assert not as_written(case)
    assert as_written(load_case(file))


def test_numbers_of_numpy_are_numbers(file: Path) -> None:
    case = load_case(file, {"contacts.main.friction": np.float64(0.5), "model.degree": np.int64(1)})
    assert (case.contacts["main"].friction, case.model.degree) == (0.5, 1)


def test_changed_case_keeps_its_source_and_the_original() -> None:
    case = parse_case(pad(), SOURCE)
    other = changed(case, {"loads.shear.amplitude": 70.0})
    assert other.source == SOURCE
    assert other.loads["shear"].history[1].amplitude == 70.0  # type: ignore[union-attr]
    assert case.loads["shear"].history[1].amplitude == 60.0  # type: ignore[union-attr]
    assert changed(other, {"loads.shear.amplitude": 60.0}) == case


def test_text_of_a_case_is_its_file_if_nothing_differs(file: Path) -> None:
    assert case_text(load_case(file)) == HERTZ


def test_text_of_a_changed_case_is_the_case(file: Path, tmp_path: Path) -> None:
    case = load_case(file, {"loads.shear.amplitude": 70, "output.fields": "none"})
    (tmp_path / "other.toml").write_text(case_text(case))
    assert load_case(tmp_path / "other.toml").model_dump() == case.model_dump()


def test_text_of_a_case_without_a_file() -> None:
    case = parse_case(pad())
    assert parse_case(tomllib.loads(case_text(case))).model_dump() == case.model_dump()


def test_files_get_their_full_paths(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    case = pad(geometry={"file": "meshes/pad.msh"})
    segment = {"csv": "../loads.csv", "time": "t", "value": "F"}
    case["loads"]["press"]["history"] = [segment]
    monkeypatch.chdir(tmp_path)
    text = case_text(parse_case(case, Path("case.toml")))
    written = tomllib.loads(text)
    assert written["geometry"]["file"] == str(tmp_path / "meshes" / "pad.msh")
    csv = Path(written["loads"]["press"]["history"][0]["csv"])
    assert csv.is_absolute() and csv.resolve() == tmp_path.parent / "loads.csv"


def run(case: Path, out: Path, *options: str) -> dict[str, Any]:
    done = fretfe("run", "--no-report", case, "-o", out, "--backend", "halfplane", *options)
    assert done.returncode == 0, done.stderr
    return dict(json.loads((out / "results.json").read_text()))


def test_results_run_again_from_their_folder(tmp_path: Path) -> None:
    """With another value, and with a history from a file beside the case file."""
    case = tmp_path / "cases" / "pad.toml"
    case.parent.mkdir()
    ramp = "{ ramp = -600, until = 1, steps = 4 }"
    assert ramp in HERTZ
    case.write_text(HERTZ.replace(ramp, '{ csv = "press.csv", time = "t", value = "F" }'))
    (case.parent / "press.csv").write_text("t,F\n0,0\n0.5,-300\n1,-600\n")
    first = run(case, tmp_path / "first", "--set", "loads.shear.amplitude=30")
    assert max(first["loads"]["shear"]) == 30
    second = run(tmp_path / "first" / "case.toml", tmp_path / "second")
    assert second["contacts"] == first["contacts"]
    assert second["loads"] == first["loads"]


def test_a_changed_case_does_not_replace_its_own_file(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(HERTZ)
    options = ("--backend", "halfplane", "--set", "loads.shear.amplitude=30")
    done = fretfe("run", "--no-report", case, "-o", tmp_path, *options)
    assert done.returncode == 6
    assert "expected another folder" in done.stderr and "Traceback" not in done.stderr
    assert case.read_text() == HERTZ
    assert run(case, tmp_path)["complete"]
    assert case.read_text() == HERTZ


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("contacts.main.friction", "contacts.main.friction"),
        ("bodies.*.young", "bodies.upper.young"),
        ("bodies.upper.young", "bodies.*.young"),
        ("loads.shear.amplitude", "loads.shear.history.2.amplitude"),
        ("bodies.upper.young", "bodies.upper"),
    ],
)
def test_one_value_is_set_once(first: str, second: str) -> None:
    """Also by two paths, or by a table that would take it away again."""
    with pytest.raises(CaseError, match=r"expected each key once|sets the same value") as caught:
        with_overrides(DATA, parse_assignments([f"{first}=0.1", f"{second}=0.2"]), SOURCE)
    assert first in str(caught.value)


def test_a_value_in_a_table_that_is_set_before() -> None:
    changes = {"bodies.upper": {"young": 1.0, "poisson": 0.3}, "bodies.upper.poisson": 0.2}
    found = with_overrides(DATA, changes, SOURCE)
    assert found["bodies"]["upper"] == {"young": 1.0, "poisson": 0.2}


def test_numbers_and_truths_of_numpy_are_those_of_python() -> None:
    case = load_case(
        {
            **pad(),
            "model": {"degree": np.int64(2), "thickness": np.float32(0.5)},
            "edges": {"local": np.bool_(False)},
            "output": {"stress_depths": np.array([0.0, 0.1])},
        },
        {"edges.stations": np.int32(20)},
    )
    assert (case.model.degree, case.edges.local, case.edges.stations) == (2, False, 20)
    assert case.output.stress_depths == (0.0, 0.1)


def test_tables_in_tables_are_not_endless() -> None:
    deep: dict[str, Any] = {}
    inner = deep
    for _ in range(5000):
        inner = inner.setdefault("a", {})
    with pytest.raises(CaseError, match="at most 20 deep"):
        load_case({**pad(), "geometry": deep})
    with pytest.raises(CaseError, match="at most 20 deep"):
        load_case(pad(), {"geometry": deep})


def test_many_keys_are_refused_before_they_are_looked_at(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(pad_text() + "[many]\n" + "\n".join(f"k{i} = 1" for i in range(6 * 10**4)))
    with pytest.raises(CaseError, match="at most 20000 keys"):
        load_case(path)
    with pytest.raises(CaseError, match="at most 20000 keys"):
        load_case({**pad(), "many": dict.fromkeys(map(str, range(10**5)), 1)})
