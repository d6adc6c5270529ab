# SPDX-License-Identifier: LGPL-3.0-or-later
"""Geometry templates without Gmsh: what is read from the .geo files, and values out of range."""

from __future__ import annotations

import math
import re
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import pytest
from launch import fretfe

from fretfe.errors import CaseError
from fretfe.geometry import templates
from fretfe.geometry.templates import Parameter, check_parameters, find_template, template_names
from fretfe.report.page.listings import parameter_rows

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
        ({"growth": True}, "growth: expected a number .*, found True"),
        ({"growth": "fast"}, "growth: expected a number .*, found 'fast'"),
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
    assert [each.name for each in firtree.parameters if each.whole] == ["lobes"]
    with pytest.raises(CaseError, match=message):
        check_parameters(firtree, {"lobes": value})


def command(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> CompletedProcess[str]:
    monkeypatch.setenv("COLUMNS", "200")
    return fretfe("templates", *arguments)


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
    page = (Path(__file__).parents[1] / "docs" / "templates.md").read_text("utf-8")
    for name in NAMES:
        table = page.partition(f"<!-- parameters of {name} -->\n")[2].partition("<!-- end -->")[0]
        # tools/template_docs.py writes it anew
        assert table == parameter_rows(find_template(name))
