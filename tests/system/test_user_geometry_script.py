# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gmsh scripts of users: opened only if the caller says so, never because a case file does."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
import typer.testing
from cases.pad_cases import pad, pad_text, press

from fretfe.case import load_case, parse_case
from fretfe.cli.app import app
from fretfe.errors import CaseError, FretfeError, MeshError
from fretfe.mesh.templates import template_directory
from fretfe.quality.companions import COARSER, resized
from fretfe.surface.checks import load_mesh

# Two squares, one on the other, with a trace of having run.
SCRIPT = """
SystemCall "touch '{trace}'";
DefineConstant[
  height = {{1, Min 0.5, Max 2, Name "Parameters/1 height of the pad [mm]"}}
];
Point(1) = {{-1, 0, 0, 0.5}}; Point(2) = {{1, 0, 0, 0.5}};
Point(3) = {{1, height, 0, 0.5}}; Point(4) = {{-1, height, 0, 0.5}};
Point(5) = {{-1, 0, 0, 0.4}}; Point(6) = {{1, 0, 0, 0.4}};
Point(7) = {{1, -1, 0, 0.4}}; Point(8) = {{-1, -1, 0, 0.4}};
Line(1) = {{1, 2}}; Line(2) = {{2, 3}}; Line(3) = {{3, 4}}; Line(4) = {{4, 1}};
Line(5) = {{5, 6}}; Line(6) = {{6, 7}}; Line(7) = {{7, 8}}; Line(8) = {{8, 5}};
Curve Loop(1) = {{1, 2, 3, 4}}; Plane Surface(1) = {{1}};
Curve Loop(2) = {{5, 6, 7, 8}}; Plane Surface(2) = {{2}};
Physical Surface("upper") = {{1}}; Physical Surface("lower") = {{2}};
Physical Curve("upper_contact") = {{1}}; Physical Curve("upper_top") = {{3}};
Physical Curve("lower_contact") = {{5}}; Physical Curve("lower_bottom") = {{7}};
"""


@pytest.fixture
def trace(tmp_path: Path) -> Path:
    """What the script in this folder leaves behind when it runs."""
    (tmp_path / "pad.geo").write_text(SCRIPT.format(trace=tmp_path / "trace"))
    return tmp_path / "trace"


def case_data(**geometry: Any) -> dict[str, Any]:
    return pad(geometry={"file": "pad.geo", **geometry})


def load(folder: Path, *, trust_geo: bool, **geometry: Any) -> Any:
    case = parse_case(case_data(**geometry), folder / "case.toml", trust_geo=trust_geo)
    return load_mesh(case)


def test_a_script_is_not_opened_unless_it_is_trusted(trace: Path) -> None:
    with pytest.raises(CaseError) as caught:
        load(trace.parent, trust_geo=False)
    message = str(caught.value)
    assert "case.toml: geometry.file: " in message
    assert "pad.geo is a Gmsh script and was not opened" in message
    assert "add the option --trust-geo" in message
    assert not trace.exists()


def test_a_script_that_is_trusted_runs(trace: Path) -> None:
    mesh = load(trace.parent, trust_geo=True)
    assert set(mesh.bodies) == {"upper", "lower"}
    assert {body.order for body in mesh.bodies.values()} == {2}
    assert trace.exists()


def test_parameters_of_a_script(trace: Path) -> None:
    mesh = load(trace.parent, trust_geo=True, parameters={"height": 1.5}, order=1)
    assert mesh.bodies["upper"].points[:, 1].max() == 1.5
    assert mesh.bodies["upper"].order == 1
    # and what was set before is forgotten
    assert load(trace.parent, trust_geo=True).bodies["upper"].points[:, 1].max() == 1.0


@pytest.mark.parametrize(
    ("parameters", "expected"),
    [
        ({"heigth": 1.5}, "no parameter is called 'heigth' (did you mean height?)"),
        ({"height": 3.0}, "height: expected a number from 0.5 to 2 mm, found 3"),
    ],
    ids=["unknown", "range"],
)
def test_parameters_are_checked(trace: Path, parameters: dict[str, Any], expected: str) -> None:
    with pytest.raises(CaseError) as caught:
        load(trace.parent, trust_geo=True, parameters=parameters)
    assert expected in str(caught.value)
    assert not trace.exists()


def test_a_script_checks_its_own_parameters(trace: Path) -> None:
    script = trace.parent / "pad.geo"
    check = 'If (height > 1.2)\n  Error("height: expected at most 1.2, found %g", height);\nEndIf\n'
    script.write_text(script.read_text() + check)
    with pytest.raises(CaseError, match=r"pad.geo':\n  - height: expected at most 1.2, found 1.5"):
        load(trace.parent, trust_geo=True, parameters={"height": 1.5})
    assert set(load(trace.parent, trust_geo=True).bodies) == {"upper", "lower"}
    script.write_text(script.read_text() + 'Error("nothing of the kind");\n')
    with pytest.raises(MeshError, match=r"pad.geo: Gmsh reports: nothing of the kind"):
        load(trace.parent, trust_geo=True)


@pytest.mark.parametrize("block", ["height = 1;", "DefineConstant[\n height = 0.5 * 2\n];"])
def test_parameters_that_nothing_is_known_of(trace: Path, block: str) -> None:
    script = trace.parent / "pad.geo"
    start, _, rest = script.read_text().partition("DefineConstant[")
    script.write_text(start + block + rest.partition("];")[2])
    assert set(load(trace.parent, trust_geo=True).bodies) == {"upper", "lower"}
    with pytest.raises(CaseError, match=r"parameters: .* no DefineConstant block .*height"):
        load(trace.parent, trust_geo=True, parameters={"height": 1.5})


def test_the_case_file_cannot_grant_trust(trace: Path) -> None:
    with pytest.raises(CaseError, match=r"geometry.trust_geo: unknown key"):
        parse_case(case_data(trust_geo=True))
    with pytest.raises(CaseError, match=r"trust_geo: unknown key"):
        parse_case({**case_data(), "_trust_geo": True, "trust_geo": True})
    assert not parse_case(case_data()).trust_geo


def test_variants_of_a_case_keep_its_trust() -> None:
    data = pad()
    for trust in (False, True):
        variant = resized(parse_case(data, trust_geo=trust), COARSER)
        assert variant is not None
        assert variant.trust_geo is trust


@pytest.mark.parametrize(
    "name", ["pad.msh", "pad.step", "pad.stp", "pad.brep", "pad.xdmf", "pad.inp"]
)
def test_scripts_under_other_names_do_not_run(trace: Path, name: str) -> None:
    folder = trace.parent
    shutil.copyfile(folder / "pad.geo", folder / name)
    geometry: dict[str, Any] = {"file": name}
    if name not in ("pad.msh", "pad.inp"):
        way = {"tag": 1} if name == "pad.xdmf" else {"point": [0, 0]}
        named = pad()["bodies"], ("upper_contact", "upper_top", "lower_contact", "lower_bottom")
        geometry["bodies"], geometry["boundaries"] = (dict.fromkeys(each, way) for each in named)
    if name.endswith(("p", "brep")):
        geometry |= {} if name == "pad.inp" else {"size": 0.1}
    with pytest.raises(MeshError):
        load_mesh(parse_case(pad(geometry=geometry), folder / "case.toml", trust_geo=True))
    assert not trace.exists()


def test_unrolled_scripts_and_unknown_names_are_refused() -> None:
    for name in ("pad.geo_unrolled", "pad.vtk", "pad"):
        with pytest.raises(CaseError) as caught:
            parse_case(pad(geometry={"file": name}))
        assert "expected a file name that ends in one of (Gmsh mesh: .msh; " in str(caught.value)
        assert f"found '{name}'" in str(caught.value)


def test_a_template_of_ours_needs_no_trust() -> None:
    assert not parse_case(pad()).trust_geo
    # by its file it does
    script = template_directory() / "cylinder.geo"
    with pytest.raises(CaseError, match="--trust-geo"):
        load_mesh(parse_case(pad(geometry={"file": str(script)})))


def test_a_script_with_a_mistake(trace: Path) -> None:
    script = trace.parent / "pad.geo"
    for text, error in (("Point(1) = {", MeshError), ("", MeshError)):
        script.write_text(text)
        with pytest.raises(error, match=r"pad.geo"):
            load(trace.parent, trust_geo=True)
    script.unlink()
    with pytest.raises(
        FretfeError, match=r"geometry.file: expected a file, found nothing at .*pad.geo"
    ):
        load(trace.parent, trust_geo=True)


CASE = pad_text(geometry={"file": "pad.geo"}, loads={"press": press(1.0, steps=1)})


@pytest.mark.parametrize(
    "command",
    [["check"], ["mesh", "-o", "m.msh"], ["run", "-o", "out"], ["validate", "--json"]],
    ids=lambda command: command[0],
)
def test_every_command_that_needs_it_has_the_option(
    trace: Path, monkeypatch: pytest.MonkeyPatch, command: list[str]
) -> None:
    monkeypatch.chdir(trace.parent)
    (trace.parent / "case.toml").write_text(CASE)
    name, *options = command
    runner = typer.testing.CliRunner()
    refused = runner.invoke(app, [name, "case.toml", *options])
    assert isinstance(refused.exception, CaseError)
    assert not trace.exists()
    accepted = runner.invoke(app, [name, "case.toml", *options, "--trust-geo"])
    assert not isinstance(accepted.exception, FretfeError), accepted.output
    assert trace.exists()


def test_trust_comes_with_loading(trace: Path) -> None:
    path = trace.parent / "case.toml"
    path.write_text(CASE)
    assert load_case(path, trust_geo=True).trust_geo
    assert not load_case(path).trust_geo
