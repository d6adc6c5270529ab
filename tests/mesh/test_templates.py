# SPDX-License-Identifier: LGPL-3.0-or-later
"""Geometry templates without Gmsh: what is read from the .geo files, and values out of range."""

from __future__ import annotations

import math
import re
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import pytest
from cases import pad_cases
from harness.launch import fretfe

from fretfe.case import parse_case
from fretfe.cli.lists import parameter_rows
from fretfe.errors import CaseError
from fretfe.idealise import idealise
from fretfe.mesh import templates
from fretfe.mesh.templates import Parameter, check_parameters, find_template, template_names

NAMES = (
    "cylinder",
    "cylinder_finite",
    "dovetail",
    "firtree",
    "flat_rounded",
    "sphere",
    "wedge",
)


def test_all_templates_are_found() -> None:
    assert template_names() == NAMES


def test_unknown_template() -> None:
    with pytest.raises(CaseError, match=r"geometry\.template.*'dovetale' \(did you mean dovetail"):
        find_template("dovetale")


def test_installed_templates_come_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "fretfe" / "meshes").mkdir(parents=True)
    monkeypatch.setattr(
        templates, "__file__", str(tmp_path / "fretfe" / "geometry" / "templates.py")
    )
    assert templates.template_directory() == tmp_path / "fretfe" / "meshes"


def test_parameter_is_read_as_written() -> None:
    parameters = {each.name: each for each in find_template("dovetail").parameters}
    assert parameters["flank_angle"] == Parameter(
        "flank_angle", 45.0, 30.0, 70.0, "Angle of the flank to the x axis", "degrees"
    )
    assert parameters["growth"].unit == "-"


@pytest.mark.parametrize("name", NAMES)
def test_every_constant_of_the_script_is_a_parameter(name: str) -> None:
    template = find_template(name)
    block = template.path.read_text().partition("DefineConstant[")[2].partition("\n];")[0]
    names = [line.split("=")[0].strip() for line in block.strip().splitlines()]
    assert [parameter.name for parameter in template.parameters] == names


@pytest.mark.parametrize("name", NAMES)
def test_defaults_are_valid_and_complete(name: str) -> None:
    template = find_template(name)
    assert check_parameters(template, {}) == {
        each.name: each.default for each in template.parameters
    }


def test_given_values_replace_defaults() -> None:
    values = check_parameters(find_template("dovetail"), {"edge_size": 0.02, "neck_width": 13})
    assert (values["edge_size"], values["neck_width"], values["flank_length"]) == (0.02, 13.0, 6.0)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"neck_widht": 12}, r"no parameter is called 'neck_widht' \(did you mean neck_width"),
        ({"zzz": 12}, r"no parameter is called 'zzz'\n.*the parameters are: flank_angle, "),
        ({"neck_width": 1000}, "neck_width: expected a number from 2 to 100 mm, found 1000"),
        ({"growth": 0}, "growth: expected a number from 0.02 to 0.5, found 0"),
        ({"growth": math.nan}, "growth: expected a number .*, found nan"),
        ({"growth": True}, "growth: expected a number .*, found true"),
        ({"growth": "fast"}, "growth: expected a number .*, found text 'fast'"),
    ],
)
def test_refused_values(values: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError, match=rf"parameters of template 'dovetail':\n.*{message}"):
        check_parameters(find_template("dovetail"), values)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (2.5, "lobes: expected a whole number from 2 to 4, found 2.5"),
        (5, "lobes: expected a whole number from 2 to 4, found 5"),
    ],
)
def test_a_number_of_lobes_is_whole(value: float, message: str) -> None:
    firtree = find_template("firtree")
    assert [each.name for each in firtree.parameters if each.whole] == ["lobes", "sectors"]
    with pytest.raises(CaseError, match=message):
        check_parameters(firtree, {"lobes": value})


def command(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> CompletedProcess[str]:
    monkeypatch.setenv("COLUMNS", "200")
    return fretfe("templates", *arguments)


@pytest.mark.parametrize(("label", "unit"), [("m", 1e3), ("um", 1e-3), ("in", 25.4), ("mm", 1.0)])
def test_ranges_and_defaults_follow_the_unit(label: str, unit: float) -> None:
    template = find_template("cylinder", length=label)
    values = check_parameters(template, {"upper_radius": 50 / unit})
    assert values["upper_radius"] == 50 / unit
    assert values["upper_width"] == pytest.approx(7 / unit, rel=1e-15)
    assert values["growth"] == 0.15
    with pytest.raises(CaseError) as caught:
        check_parameters(template, {"upper_radius": 2e4 / unit, "growth": 0.6})
    assert f"upper_radius: expected a number from {0.1 / unit:g} to {1e4 / unit:g} {label}" in str(
        caught.value
    )


def test_a_case_in_metres_is_the_same_case() -> None:
    """N, m and Pa: K_N is that of MPa/mm^0.5, times 1e6/sqrt(0.001), and so on."""
    load = {"type": "platen", "boundary": "upper_top", "direction": "y", "control": "force"}
    found = []
    for label, unit, stress in (("mm", 1.0, 1.0), ("m", 1e3, 1e6)):
        steel = {"young": 210e3 * stress, "poisson": 0.3}
        ramp = [{"ramp": -600 * unit, "until": 1, "steps": 2}]
        case = pad_cases.pad(
            units={"length": label},
            geometry={
                "template": "cylinder",
                "parameters": {"upper_radius": 50 / unit, "lower_radius": 0},
            },
            bodies={"upper": steel, "lower": steel},
            loads={"press": {**load, "history": ramp}},
        )
        problem = idealise(parse_case(case))
        found.append((problem.profile.half_width(600 * unit) * unit, problem.normal_force / unit))
    assert found[0][0] == pytest.approx(found[1][0], rel=1e-9)
    assert found[0][1] == pytest.approx(found[1][1], rel=1e-12)


def test_the_command_lists_the_templates(monkeypatch: pytest.MonkeyPatch) -> None:
    done = command(monkeypatch)
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines()]
    assert [row[0] for row in rows if row and row[0] in NAMES] == list(NAMES)
    assert "Firtree: a blade root with 2 to 4 pairs of lobes" in done.stdout


def test_the_command_lists_the_parameters_of_a_template(monkeypatch: pytest.MonkeyPatch) -> None:
    done = command(monkeypatch, "firtree")
    assert done.returncode == 0, done.stderr
    names = [line.split()[0] for line in done.stdout.splitlines() if " … " in line]
    assert names == [each.name for each in find_template("firtree").parameters]
    assert re.search(r"lobes +3 +2 … 4, whole +Number of pairs of lobes", done.stdout)
    assert re.search(r"flank_angle +45 +30 … 65 +degrees +Angle of the flanks", done.stdout)


def test_the_command_refuses_an_unknown_template(monkeypatch: pytest.MonkeyPatch) -> None:
    done = command(monkeypatch, "firtre")
    assert done.returncode == 2
    assert "NAME: no template is called 'firtre' (did you mean firtree?)" in done.stderr


def test_the_document_has_the_parameters_that_the_templates_have() -> None:
    page = (Path(__file__).parents[2] / "docs" / "templates.md").read_text("utf-8")
    for name in NAMES:
        table = page.partition(f"<!-- parameters of {name} -->\n")[2].partition("<!-- end -->")[0]
        # tools/template_docs.py writes it anew
        assert table == parameter_rows(find_template(name))
