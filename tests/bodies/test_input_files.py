# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files that a case reads are found with those that are named in them."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from cases.pad_cases import pad, press

from fretfe.bodies.input_files import input_digests, input_files
from fretfe.case import Case, parse_case

FIELD = {"type": "field", "boundary": "lower_left", "history": [{"hold": True, "until": 1.0}]}


def case_in(folder: Path, **tables: Any) -> Case:
    return parse_case(pad(**tables), folder / "case.toml")


def geometry_of(file: str) -> dict[str, Any]:
    label = {"label": "a"} if file.endswith(".inp") else {"tag": 1}
    sides = ("upper_contact", "lower_contact", "lower_bottom", "upper_top")
    groups = dict.fromkeys(("upper", "lower"), label)
    return {"file": file, "bodies": groups, "boundaries": dict.fromkeys(sides, label)}


def test_a_case_of_a_template_reads_nothing(tmp_path: Path) -> None:
    assert input_digests(case_in(tmp_path)) == {}


def test_histories_and_fields(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text("t,v\n0,0\n1,-600\n")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "fields.hdf").write_bytes(b"a")
    load = {**press(), "history": [{"csv": "path.csv", "time": "t", "value": "v"}]}
    case = case_in(tmp_path, loads={"press": load, "driven": {**FIELD, "file": "run"}})
    assert input_files(case) == {
        tmp_path / "path.csv": "loads.press.history.0.csv",
        tmp_path / "run" / "fields.hdf": "loads.driven.file",
    }
    before = input_digests(case)
    assert before[str(tmp_path / "run" / "fields.hdf")] == sha256(b"a").hexdigest()
    (tmp_path / "run" / "fields.hdf").write_bytes(b"b")
    after = input_digests(case)
    assert {path for path in before if before[path] != after[path]} == {
        str(tmp_path / "run" / "fields.hdf")
    }


@pytest.mark.parametrize(
    ("file", "text", "others"),
    [
        ("a.inp", "*NODE\n1, 0, 0\n*INCLUDE, INPUT=b.inp\n", {"b.inp": "*Include, input=c.inp\n"}),
        ("a.inp", "*NODE\n1, 0, 0\n", {}),
        ("a.xdmf", "<DataItem Format='HDF'>a.h5:/mesh</DataItem>", {"a.h5": "", "b.h5": ""}),
    ],
    ids=["a deck that includes", "a deck", "XDMF"],
)
def test_meshes(tmp_path: Path, file: str, text: str, others: dict[str, str]) -> None:
    (tmp_path / file).write_text(text)
    for name, content in {**others, "c.inp": "** end\n"}.items():
        (tmp_path / name).write_text(content)
    found = {path.name for path in input_files(case_in(tmp_path, geometry=geometry_of(file)))}
    read = {"b.inp", "c.inp"} if others and file == "a.inp" else set()
    assert found == {file, *read, *({"a.h5"} if file == "a.xdmf" else ())}


def test_steps_of_a_collection(tmp_path: Path) -> None:
    (tmp_path / "a.pvd").write_text('<DataSet timestep="1" file="one.vtu"/><DataSet file="2.vtu"/>')
    for name in ("one.vtu", "2.vtu", "3.vtu"):
        (tmp_path / name).touch()
    case = case_in(tmp_path, loads={"press": press(), "driven": {**FIELD, "file": "a.pvd"}})
    assert {path.name for path in input_files(case)} == {"a.pvd", "one.vtu", "2.vtu"}


def test_missing_files_are_left_to_their_readers(tmp_path: Path) -> None:
    (tmp_path / "a.inp").write_text("*INCLUDE, INPUT=missing.inp\n")
    case = case_in(tmp_path, geometry=geometry_of("a.inp"))
    assert [path.name for path in input_files(case)] == ["a.inp"]
