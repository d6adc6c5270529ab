# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results whose digest is right and whose parts do not fit together."""

from __future__ import annotations

import json
import os
import shutil
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from cases.pad_cases import pad
from cases.stored_runs import CYCLE, write_run

from fretfe.case import parse_case
from fretfe.caution import Caution, Subject
from fretfe.errors import OutputError
from fretfe.halfplane import solve_half_planes
from fretfe.reason import Kind
from fretfe.results.reader import load_result
from fretfe.results.run_folder import KEY, with_digest
from fretfe.runner import Runner


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("run")
    with pytest.MonkeyPatch.context() as patch:
        few = partial(solve_half_planes, elements=40)
        patch.setattr("fretfe.backends.halfplane.solve_half_planes", few)
        Runner.find("halfplane").run(parse_case(pad()), found)
    return found


def renamed(table: dict[str, Any], name: str) -> None:
    table["other"] = table.pop(name)


@pytest.mark.parametrize(
    ("place", "name", "message"),
    [
        ("loads", "press", "loads: 'other', which is none of the case"),
        ("contacts", "main", "expected arrays that this version of fretfe reads, found others: "),
        ("case.loads", "press", "loads: 'press', which is none of the case"),
        ("case.contacts", "main", "contacts: 'main', which is none of the case"),
    ],
)
def test_other_names(tmp_path: Path, folder: Path, place: str, name: str, message: str) -> None:
    numbers = copied(folder, tmp_path)
    table = numbers
    for part in place.split("."):
        table = table[part]
    renamed(table, name)
    written(tmp_path, numbers)
    with pytest.raises(OutputError) as raised:
        load_result(tmp_path)
    assert message in str(raised.value)
    assert f"read it with fretfe {numbers['versions']['fretfe']}, which" in str(raised.value)


@pytest.mark.parametrize(("key", "value"), [("cycle", [None, 12]), ("cycle", ["a", 3])])
def test_other_types(tmp_path: Path, folder: Path, key: str, value: object) -> None:
    written(tmp_path, {**copied(folder, tmp_path), key: value})
    with pytest.raises(OutputError, match="in place of a whole number"):
        load_result(tmp_path)


@pytest.mark.parametrize(
    "place",
    [
        *("notes", "limits", "faults", "contacts.main.warnings", "contacts.main.fronts"),
        *("contacts.main.fronts.0.stations", "contacts.main.fronts.0.stations.0.slip_zones"),
    ],
)
@pytest.mark.parametrize("text", ["", "none"])
def test_a_text_in_place_of_a_list(tmp_path: Path, folder: Path, place: str, text: str) -> None:
    """An empty one would be a list of nothing."""
    numbers = copied(folder, tmp_path)
    *parts, last = place.split(".")
    table: Any = numbers
    for part in parts:
        table = table[int(part) if part.isdecimal() else part]
    table[last] = text
    written(tmp_path, numbers)
    with pytest.raises(OutputError, match=r"found: .* in place of a list"):
        load_result(tmp_path)


def test_a_number_that_is_missing(tmp_path: Path, folder: Path) -> None:
    numbers = copied(folder, tmp_path)
    numbers["contacts"]["main"]["fronts"][0]["stations"][0]["last"] = None
    written(tmp_path, numbers)
    with pytest.raises(OutputError, match="nothing in place of a whole number"):
        load_result(tmp_path)


def copied(folder: Path, to: Path) -> dict[str, Any]:
    shutil.copytree(folder, to, dirs_exist_ok=True)
    numbers = json.loads((to / "results.json").read_text())
    return {key: value for key, value in numbers.items() if key != KEY}


def written(folder: Path, numbers: dict[str, Any]) -> None:
    (folder / "results.json").write_text(json.dumps(with_digest(numbers)))


@pytest.mark.parametrize("name", ["run.json", "results.json", "results.h5"])
def test_a_pipe_in_place_of_a_file_is_not_waited_for(
    tmp_path: Path, folder: Path, name: str
) -> None:
    copied(folder, tmp_path)
    (tmp_path / name).unlink()
    os.mkfifo(tmp_path / name)
    with pytest.raises(OutputError, match=f"{name}: expected a file of results, found a pipe"):
        load_result(tmp_path)


def test_an_old_folder_names_the_version_that_reads_it(tmp_path: Path, folder: Path) -> None:
    numbers = copied(folder, tmp_path)
    numbers["schema"]["version"] -= 1
    numbers["versions"]["fretfe"] = "0.0.9"
    written(tmp_path, numbers)
    with pytest.raises(OutputError, match=r"read it with fretfe 0\.0\.9, which wrote it, or run"):
        load_result(tmp_path)


def test_warnings_keep_kind_and_subject(tmp_path: Path, folder: Path) -> None:
    numbers = copied(folder, tmp_path)
    subject = {"contact": "main", "front": "left"}
    told = {"kind": "K_N uncertain", "subject": subject, "text": "K_N is 1 ± .1", "partly": False}
    numbers["contacts"]["main"]["warnings"] = [told]
    written(tmp_path, numbers)
    (found,) = load_result(tmp_path).warnings
    assert found == Caution(Kind.K_N_UNCERTAIN, Subject("main", "left"), "K_N is 1 ± .1")
    told["kind"] = "of another version"
    written(tmp_path, numbers)
    with pytest.raises(OutputError, match="'of another version' is not a valid Kind"):
        load_result(tmp_path)


def test_files_of_the_case_are_found_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gap = {"main": {**CYCLE["contacts"]["main"], "gap": "gap.txt"}}
    case = parse_case({**CYCLE, "contacts": gap}, tmp_path / "here" / "case.toml")
    folder = write_run(tmp_path / "results", "halfplane", case)
    monkeypatch.chdir(tmp_path)
    found = load_result(folder).case
    assert found.resolve(found.contacts["main"].gap or "") == tmp_path / "here" / "gap.txt"
