# SPDX-License-Identifier: LGPL-3.0-or-later
"""A mesh that is too coarse for its contact is said before anything is solved, and only then."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pad_cases import STEEL, TOP, cylinder, pad, pad_text, press, shear
from typer.testing import CliRunner

from fretfe.backends.protocol import Observer, RunOptions
from fretfe.case import load_case, parse_case
from fretfe.cli.app import app
from fretfe.evaluate.resolution import coarse_contacts
from fretfe.fem.backend import BACKEND
from fretfe.loads import build_history
from fretfe.surface.checks import load_mesh

DEMOS = Path(__file__).parents[2] / "demos"


def foreseen(tables: dict[str, Any]) -> list[str]:
    case = parse_case(tables)
    return list(coarse_contacts(case, load_mesh(case), build_history(case)))


@pytest.mark.parametrize("size", [0.25, 0.15])
def test_the_width_is_that_of_hertz(size: float) -> None:
    (text,) = foreseen(pad(geometry=cylinder(size=size)))
    assert float(re.findall(r"half-width ([\d.]+)", text)[0]) == pytest.approx(0.5749, rel=0.02)
    count = int(re.findall(r"about (\d+) nodes", text)[0])
    assert count == pytest.approx(2 * 0.5749 / size, abs=2)
    assert "16 wanted at least: make the elements there 0.07 mm long or less" in text


def test_a_wedge_is_as_wide_as_its_theory() -> None:
    geometry = {"template": "wedge", "parameters": {"angle": 1.0, "size": 0.1}}
    (text,) = foreseen(pad(geometry=geometry))
    # P = E* a tan(angle)
    width = 600 / (210e3 / (2 * 0.91) * np.tan(np.radians(1.0)))
    assert float(re.findall(r"half-width ([\d.]+)", text)[0]) == pytest.approx(width, rel=0.05)


def test_a_traction_presses_as_well() -> None:
    down = {**press(), "type": "traction", "direction": "normal"}
    down = {key: value for key, value in down.items() if key != "control"}
    loads = {"press": {**down, "history": [{"ramp": -25.0, "until": 1.0, "steps": 2}]}}
    (text,) = foreseen(pad(geometry=cylinder(size=0.2), loads=loads))
    assert "expected at P = 600" in text


def test_nothing_is_said_where_it_is_not_known() -> None:
    driven = {"press": {**press(), "control": "displacement"}}
    assert foreseen(pad(geometry=cylinder(size=0.25), loads=driven)) == []
    sideways = {"shear": {**shear(), **TOP, "direction": "x"}}
    assert foreseen(pad(geometry=cylinder(size=0.25), loads=sideways)) == []


@pytest.mark.parametrize("size", [0.06, 0.02])
def test_a_fine_mesh_is_quiet(size: float) -> None:
    assert foreseen(pad(geometry=cylinder(size=size))) == []


SOLIDS = {
    "geometry": {"template": "sphere", "parameters": {}},
    "bodies": {"upper": STEEL, "lower": STEEL},
    "contacts": {
        "main": {"surface1": "upper_contact", "surface2": "lower_contact", "friction": 0.5}
    },
    "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
    "loads": {"press": {**press(), "history": [{"ramp": -2900.0, "until": 1.0, "steps": 1}]}},
}


@pytest.mark.parametrize(
    ("template", "parameters", "width"),
    [
        # Steel of press(): E* = 115.4 GPa; a³ = 3 P R/(4 E*).
        ("sphere", {"size": 0.3}, (0.75 * 2900 * 50 / 115385) ** (1 / 3)),
        # Half-planes under the mean force per length, a² = 4 P R/(π E*).
        ("cylinder_finite", {"size": 0.2}, (4 * 290 * 30 / np.pi / 115385) ** 0.5),
    ],
)
def test_the_width_of_solids(template: str, parameters: dict[str, float], width: float) -> None:
    (text,) = foreseen({**SOLIDS, "geometry": {"template": template, "parameters": parameters}})
    assert float(re.findall(r"half-width ([\d.]+)", text)[0]) == pytest.approx(width, rel=0.02)
    count = int(re.findall(r"about (\d+) nodes across", text)[0])
    assert count == pytest.approx(2 * width / parameters["size"], abs=1)


def test_a_fine_sphere_and_the_dovetail_of_solids_are_quiet() -> None:
    assert (
        foreseen({**SOLIDS, "geometry": {"template": "sphere", "parameters": {"size": 0.1}}}) == []
    )
    case = load_case(DEMOS / "dovetail_solid.toml", trust_geo=True)
    assert list(coarse_contacts(case, load_mesh(case), build_history(case))) == []


@pytest.mark.parametrize("name", ["dovetail", "wedge", "flat_rounded", "ellipse"])
def test_demos_are_quiet(name: str) -> None:
    case = load_case(DEMOS / f"{name}.toml", trust_geo=True)
    assert list(coarse_contacts(case, load_mesh(case), build_history(case))) == []


class Announced(Observer):
    """Keeps what is announced before the first step."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.before_steps = 0

    def announce(self, text: str) -> None:
        self.texts.append(text)

    def step(self, number: int, count: int, text: str) -> None:
        self.before_steps = self.before_steps or len(self.texts)


def test_check_and_run_say_it_first(tmp_path: Path) -> None:
    path = tmp_path / "pad.toml"
    path.write_text(pad_text(geometry=cylinder(size=0.25), bodies={"upper": STEEL, "lower": STEEL}))
    checked = CliRunner().invoke(app, ["check", str(path)])
    assert checked.exit_code == 0 and "Warning: contact main: about 5 nodes" in checked.stdout
    observer = Announced()
    BACKEND.solve(load_case(path), RunOptions(observer=observer))
    said = ["Warning: contact main: about 5 nodes" in text for text in observer.texts]
    assert said.count(True) == 1 and observer.before_steps == len(observer.texts)
