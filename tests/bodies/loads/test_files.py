# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files that loads name are read before anything is meshed."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from cases.pad_cases import pad
from harness import launch

from fretfe import checked
from fretfe.bodies.loads.files import checked_history
from fretfe.case import parse_case
from fretfe.errors import CaseError
from fretfe.fields import field
from fretfe.surface import ahead, checks

RAMP = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
FIELD = {"type": "field", "boundary": "upper_top", "file": "run.csv", "history": RAMP}
MISSING = "ru.csv"
GOOD = "x,y,ux,uy,time\n0,0,1,2,1\n1,0,3,4,1\n"
TABLES: dict[str, tuple[dict[str, Any], str, str]] = {
    "nan": (FIELD, GOOD.replace("3", "nan"), "line 3, column 'ux': expected a finite number, "
            "found 'nan'"),
    "no column": (FIELD, GOOD.replace("uy", "u2"), "line 1: expected one column 'uy', found"),
    "a point twice": (FIELD, GOOD.replace("1,0,3", "0,0,3"), "line 3, column 'x': expected a poi"),
    "time": (FIELD, GOOD.replace("2,1", "2,-1").replace("4,1", "4,-1"), "expected times of steps"),
    "empty": (FIELD, "", "expected a header row"),
    "kind": ({**FIELD, "file": "run.dat"}, "", "expected a file of displacements whose name ends"),
    "none": ({**FIELD, "file": MISSING}, GOOD, "ru.csv: expected a file with displacements"),
    "shape": ({**FIELD, "type": "shape"}, GOOD.replace("4", "inf"), "line 3, column 'uy': expect"),
    "traction": ({**FIELD, "type": "traction", "direction": "y"}, GOOD, "one column 'value'"),
    "temperature": ({"type": "temperature", "file": "run.csv", "history": RAMP}, GOOD,
                    "line 1: expected one column 'T'"),
    "temperatures": ({"type": "temperature_field", "file": "run.csv", "history": RAMP}, GOOD,
                     "line 1: expected one column 'T'"),
    "eigenstrain": ({"type": "eigenstrain", "file": "run.csv", "history": RAMP}, GOOD,
                    "line 1: expected one column 'exx'"),
    "history": ({"type": "displacement", "boundary": "upper_top", "direction": "y", "history":
                 [{"csv": "run.csv", "time": "time", "value": "ux"}]}, GOOD,
                "line 3, column 'time': expected a time after 1, found 1"),
}  # fmt: skip
UNITS: dict[str, tuple[dict[str, Any], str, str]] = {
    "lengths": ({**FIELD, "factor": 1.0}, GOOD.replace("ux", "ux [m]"), "ux in mm, found ux in m"),
    "row of units": ({**FIELD, "type": "shape", "factor": 1.0},
                     GOOD.replace("time\n", "time\nm,m,mm,mm,s\n"), "x in mm, found x in m"),
    "factors": ({**FIELD, "type": "traction", "direction": "y"},
                "x,y,value [kPa]\n0,0,1\n1,0,1\n", "value in pure numbers, found value in kPa"),
    "heat": ({"type": "temperature", "file": "run.csv", "history": RAMP},
             "x,y,T [K]\n0,0,1\n1,0,1\n", "T in °C, found T in K"),
}  # fmt: skip
HOT = {
    name: {"young": 210e3, "poisson": 0.3, "expansion": 1e-5, "reference_temperature": 20}
    for name in ("upper", "lower")
}


def case_file(folder: Path, load: dict[str, Any], text: str) -> Path:
    name = load.get("file", "run.csv")
    (folder / (name if name != MISSING else "run.csv")).write_text(text)
    (folder / "case.toml").write_text(tomli_w.dumps(pad(loads={"other": load}, bodies=HOT)))
    return folder / "case.toml"


@pytest.fixture
def _no_mesh(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise AssertionError("meshed")

    for module in (ahead, checks, checked):
        monkeypatch.setattr(module, "load_mesh", fail)
    monkeypatch.setattr(ahead, "_Begun", fail)


@pytest.mark.usefixtures("_no_mesh")
@pytest.mark.parametrize(
    "command", ["check", *(pytest.param(each, marks=pytest.mark.fem) for each in ("run", "sweep"))]
)
@pytest.mark.parametrize(("load", "text", "expected"), TABLES.values(), ids=TABLES)
def test_bad_files_are_told_before_a_mesh_is_made(
    tmp_path: Path, load: dict[str, Any], text: str, expected: str, command: str
) -> None:
    file = case_file(tmp_path, load, text)
    more: list[str | Path] = [] if command == "check" else ["-o", tmp_path / "out"]
    if command == "sweep":
        more += ["--vary", "contacts.main.friction=0.3,0.4"]
    done = launch.fretfe(command, file, *more)
    assert done.returncode == 2 and expected in done.stderr, done
    assert f"{file}: loads.other." in done.stderr


def test_good_files_pass(tmp_path: Path) -> None:
    case_file(tmp_path, FIELD, GOOD)
    case = parse_case(pad(loads={"other": FIELD}), tmp_path / "case.toml")
    assert checked_history(case).times.tolist() == [0.0, 1.0]


@pytest.mark.parametrize(("load", "text", "expected"), UNITS.values(), ids=UNITS)
def test_other_units_are_refused(
    tmp_path: Path, load: dict[str, Any], text: str, expected: str
) -> None:
    """Numbers would be taken to be in those of the case; a factor of lengths converts them."""
    file = case_file(tmp_path, load, text)
    data = pad(loads={"other": load}, bodies=HOT)
    with pytest.raises(CaseError, match=f"loads.other.file: .*expected {expected}"):
        checked_history(parse_case(data, file))
    if "factor" in load:
        checked_history(parse_case(pad(loads={"other": {**load, "factor": 1e3}}), file))


def test_columns_of_solids(tmp_path: Path) -> None:
    """Extruded bodies need a third one; whether a mesh file has solids is not known yet."""
    load = {**FIELD, "type": "shape"}
    case_file(tmp_path, load, GOOD)
    checked_history(parse_case(pad(loads={"other": load}), tmp_path / "case.toml"))
    solid = pad(loads={"other": load})
    solid["geometry"]["solid"] = {"length": 2.0, "layers": 2}
    with pytest.raises(CaseError, match=r"line 1: expected one column 'z', found"):
        checked_history(parse_case(solid, tmp_path / "case.toml"))


def test_a_table_of_several_loads_is_read_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And again if it has changed."""
    read, original = [], field.read_field

    def noted(path: Path, quantity: field.Quantity, arrays: field.Names) -> field.Field:
        read.append(path)
        return original(path, quantity, arrays)

    monkeypatch.setattr(field, "read_field", noted)
    other = {**FIELD, "boundary": "lower_bottom"}
    tables = pad(loads={"one": FIELD, "other": other}, supports={})
    case_file(tmp_path, FIELD, GOOD)
    case = parse_case(tables, tmp_path / "case.toml")
    for _ in range(2):
        checked_history(case)
    assert len(read) == 1
    (tmp_path / "run.csv").write_text(GOOD.replace("3", "three"))
    with pytest.raises(CaseError, match="found 'three'"):
        checked_history(case)


@pytest.mark.skipif(find_spec("dolfinx") is None, reason="DOLFINx is not installed")
def test_all_processes_end_alike(tmp_path: Path) -> None:
    file = case_file(tmp_path, FIELD, GOOD.replace("3", "nan"))
    done = launch.python("-m", "fretfe", "run", file, "-o", tmp_path / "out", ranks=2)
    assert done.returncode == 2
    assert done.stderr.count("run.csv: line 3, column 'ux': expected a finite number") == 1
