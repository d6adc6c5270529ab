# SPDX-License-Identifier: LGPL-3.0-or-later
"""Values that no case means, told before anything is made of them."""

from __future__ import annotations

import copy
import os
from pathlib import Path
from typing import Any

import pytest
from pad_cases import TOP, pad, pad_text, press, shear

from fretfe.case import load_case, parse_assignments, parse_case
from fretfe.errors import CaseError
from fretfe.files import file_fault
from fretfe.loads import build_history
from fretfe.loads.csv_file import read_columns


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
        read_columns(path, "t", "q")
    path.write_text("t,q\n0,0,\n1,2, ,\n")
    times, values = read_columns(path, "t", "q")
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
