# SPDX-License-Identifier: LGPL-3.0-or-later
"""Values that no case means, told before anything is made of them."""

from __future__ import annotations

import copy
import os
import time
from pathlib import Path
from typing import Any

import pytest
from cases.pad_cases import TOP, pad, pad_text, press, shear

from fretfe.case import load_case, parse_assignments, parse_case
from fretfe.errors import CaseError, OutputError
from fretfe.files import file_fault
from fretfe.loads import build_history, csv_file
from fretfe.loads.csv_file import read_columns
from fretfe.results.run_folder import read_mark


def refused(data: dict[str, Any]) -> str:
    with pytest.raises(CaseError) as caught:
        build_history(parse_case(data))
    return str(caught.value)


@pytest.mark.parametrize(
    "text",
    ["a = " + "[" * 20000, "a = " + "[" * 300 + "]" * 300, ".".join("a" * 3000) + " = 1"],
    ids=["beyond Python", "lists", "keys"],
)
def test_deep_nesting(tmp_path: Path, text: str) -> None:
    path = tmp_path / "case.toml"
    path.write_text(text)
    with pytest.raises(CaseError, match="at most 20 deep in one another"):
        load_case(path)


def test_numbers_with_more_digits_than_python_reads(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text("a = 1" + "0" * 5000)
    with pytest.raises(CaseError, match="numbers that can be read"):
        load_case(path)
    assert parse_assignments(["a=1" + "0" * 5000])["a"].startswith("100")


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (10**400, "expected a number, found a whole number of more than 60 digits"),
        (1e31, "expected a number <= 1e+30, found 1e+31"),
        (1e-31, "expected a number of 1e-30 or more, found 1e-31"),
        (0.0, "expected a number > 0, found 0"),
    ],
    ids=["400 digits", "large", "tiny", "zero"],
)
def test_absurd_numbers(value: float, expected: str) -> None:
    data = pad()
    data["bodies"]["upper"]["young"] = value
    assert f"bodies.upper.young: {expected}" in refused(data)


def test_a_name_of_5000_characters() -> None:
    data = pad()
    data["contacts"]["x" * 5000] = data["contacts"].pop("main")
    message = refused(data)
    assert "contacts.xxxxxxxxxxxxxxxxxxxx... (5000 characters)" in message
    assert "at most 100 characters" in message
    assert len(message) < 300


def test_more_steps_than_can_be_solved() -> None:
    message = refused(pad(loads={"press": press(), "shear": shear(cycles=10**5, steps=40)}))
    assert "loads.shear.history[segment 2]: expected at most 1,000,000 steps" in message
    assert "found 4,200,001" in message
    assert "cycles" in refused(pad(loads={"press": press(), "shear": shear(cycles=10**30)}))


@pytest.mark.parametrize("surface", ["upper_contact", "lower_contact"])
def test_a_contact_surface_that_is_held(surface: str) -> None:
    data = copy.deepcopy(pad())
    data["supports"]["held"] = {"boundary": surface, "fix": ["x"]}
    assert "supports.held.boundary: expected a boundary that is no contact surface" in refused(data)
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    moved = {"type": "displacement", "boundary": surface, "direction": "x", "history": history}
    found = refused(pad(loads={"press": press(), "moved": moved}))
    assert "loads.moved.boundary: expected a boundary that is no contact surface" in found


def test_rows_longer_than_their_header(tmp_path: Path) -> None:
    """Decimal commas between commas: 0,5 and 1,5 are four cells."""
    path = tmp_path / "loads.csv"
    path.write_text("t,q\n0,0\n0,5,1,5\n")
    with pytest.raises(CaseError, match=r"line 3: expected at most 2 cells.*found 4.*decimal"):
        read_columns(path, "t", "q", {})
    path.write_text("t,q\n0,0,\n1,2, ,\n")
    times, values = read_columns(path, "t", "q", {})
    assert (times.tolist(), values.tolist()) == ([0, 1], [0, 2])


def test_pipes_and_devices(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert file_fault(tmp_path / "pipe") == "a pipe"
    assert file_fault(tmp_path) == "a folder"
    assert file_fault(Path("/dev/zero")) == "a device"
    assert file_fault(tmp_path / ("x" * 5000)).startswith("a name that cannot be opened")
    (tmp_path / "case.toml").write_text(pad_text())
    assert file_fault(tmp_path / "case.toml") == ""
    with pytest.raises(CaseError, match=r"expected a case file \(TOML\), found a pipe"):
        load_case(tmp_path / "pipe")
    load = {**TOP, "direction": "x", "history": [{"csv": "pipe", "time": "t", "value": "q"}]}
    case = parse_case(pad(loads={"press": press(), "shear": load}), tmp_path / "case.toml")
    with pytest.raises(CaseError, match="expected a CSV file, found a pipe"):
        build_history(case)


@pytest.mark.parametrize("value", [1e-320, -1e-31, 5e-324])
def test_numbers_that_have_lost_their_digits(tmp_path: Path, value: float) -> None:
    data = pad()
    data["loads"]["shear"]["history"][1]["amplitude"] = value
    assert f"expected 0, or a number of 1e-30 or more, found {value:g}" in refused(data)
    path = tmp_path / "loads.csv"
    path.write_text(f"t,q\n0,0\n1,{value!r}\n2,0\n")
    if abs(value) > 1e-300:  # remains in tables of other programs
        assert read_columns(path, "t", "q", {})[1].tolist() == [0, value, 0]
        return
    with pytest.raises(CaseError, match=r"line 3, column 'q': expected 0, or a number of 1e-300"):
        read_columns(path, "t", "q", {})


@pytest.mark.parametrize("delimiter", [",", ";", "\t", " "])
def test_names_in_quotes(tmp_path: Path, delimiter: str) -> None:
    """As spreadsheets write them; a name may hold what separates others."""
    path = tmp_path / "loads.csv"
    path.write_text(f'"time [s]"{delimiter}"q, N/mm"\n0{delimiter}1\n')
    assert read_columns(path, "time [s]", "q, N/mm", {})[1].tolist() == [1]


def test_a_quote_that_does_not_end(tmp_path: Path) -> None:
    path = tmp_path / "loads.csv"
    path.write_text('"t,q\n0,0\n')
    with pytest.raises(CaseError, match="line 2: expected cells of a CSV file"):
        read_columns(path, "t", "q", {})


def test_more_rows_than_documented(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(csv_file, "MOST_ROWS", 3)
    path = tmp_path / "loads.csv"
    path.write_text("t,q\n0,0\n1,1\n2,2\n")
    assert len(read_columns(path, "t", "q", {})[0]) == 3
    path.write_text("t,q\n0,0\n1,1\n2,2\n3,3\n")
    with pytest.raises(CaseError, match="line 5: expected at most 3 rows of numbers, found more"):
        read_columns(path, "t", "q", {})


@pytest.mark.parametrize("text", ["", "[" * 50_000 + "]" * 50_000, "{}", "[]", '{"schema": 1}'])
def test_a_damaged_note_of_a_run(tmp_path: Path, text: str) -> None:
    (tmp_path / "run.json").write_text(text)
    with pytest.raises(OutputError, match=r"damaged.*run the case without --resume, which starts"):
        read_mark(tmp_path)


def test_files_that_take_long_to_read_are_refused_by_their_size(tmp_path: Path) -> None:
    """Neither keys nor tables: a list alone takes TOML ten seconds."""
    path = tmp_path / "case.toml"
    path.write_text(f"values = [{', '.join(['1'] * 3_000_000)}]\n")
    start = time.perf_counter()
    with pytest.raises(CaseError, match="of at most 1e\\+06 bytes, found 9000010; CSV files hold"):
        load_case(path)
    assert time.perf_counter() - start < 1.0  # thousands of times what it takes


def test_tables_of_a_program_are_counted_before_they_are_copied() -> None:
    tables = {"bodies": dict.fromkeys(map(str, range(1_000_000)), 1)}
    with pytest.raises(CaseError, match="at most 20000 keys in all tables, found 1000001"):
        load_case(tables)


@pytest.mark.parametrize(
    ("key", "value"), [("stations", "20"), ("stations", 20.0), ("local", "true"), ("ends", 1)]
)
def test_nothing_is_made_of_another_kind(key: str, value: object) -> None:
    found = refused(pad(edges={key: value}))
    assert f"edges.{key}: " in found and found.endswith(f" {value!r}")
