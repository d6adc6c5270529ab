# SPDX-License-Identifier: LGPL-3.0-or-later
"""A mesh that is too coarse for its contact is said before anything is solved, and only then."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from cases.pad_cases import STEEL, TOP, cylinder, pad, pad_text, press, shear
from typer.testing import CliRunner

from fretfe import checked
from fretfe.analytic.profiles import FlatRounded, edge_factor_k_n
from fretfe.backends.protocol import Observer, RunOptions
from fretfe.bodies.expected import (
    Proposal,
    coarse_contacts,
    expected_contacts,
    pressure_doubts,
    proposed_sizes,
)
from fretfe.case import load_case, parse_case
from fretfe.checked import check, propose
from fretfe.cli.app import app
from fretfe.errors import ModelError
from fretfe.evaluate.resolution import BAR_TIMES_ELEMENTS
from fretfe.fem.backend import BACKEND
from fretfe.loads import build_history
from fretfe.surface.checks import load_mesh

DEMOS = Path(__file__).parents[2] / "demos"


def foreseen(tables: dict[str, Any]) -> list[str]:
    case = parse_case(tables)
    return list(coarse_contacts(case, load_mesh(case), build_history(case)))


def proposals(tables: dict[str, Any]) -> list[Proposal]:
    case = parse_case(tables)
    return list(proposed_sizes(case, load_mesh(case), build_history(case), 0.03))


def elements(text: str) -> float:
    return float(re.findall(r"over ([\d.]+) elements", text)[0])


@pytest.mark.parametrize("size", [0.25, 0.15])
def test_the_width_is_that_of_hertz(size: float) -> None:
    (text,) = foreseen(pad(geometry=cylinder(size=size)))
    assert float(re.findall(r"half-width ([\d.]+)", text)[0]) == pytest.approx(0.5749, rel=0.02)
    # K_N rises as far as half of that; the table says it with one digit.
    count = float(re.findall(r"over ([\d.]+) elements, 8 are wanted", text)[0])
    assert count == pytest.approx(0.5749 / 2 / size, rel=0.1)
    wanted = float(re.findall(r"set geometry.parameters.size = ([\d.]+), or give edges", text)[0])
    assert wanted == pytest.approx(0.5749 / 16, rel=0.05)


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
    assert "at P = 600 " in text


def test_nothing_is_said_where_it_is_not_known() -> None:
    driven = {"press": {**press(), "control": "displacement"}}
    assert foreseen(pad(geometry=cylinder(size=0.25), loads=driven)) == []
    sideways = {"shear": {**shear(), **TOP, "direction": "x"}}
    assert foreseen(pad(geometry=cylinder(size=0.25), loads=sideways)) == []


@pytest.mark.parametrize("size", [0.05, 0.02])
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
    # Layers and triangles differ from the size by a tenth.
    assert elements(text) == pytest.approx(width / 2 / parameters["size"], rel=0.15)


STRAIGHT = {"solid": {"length": 4.0, "layers": 1}}
PUNCH = {"flat_half_width": 1.0, "radius": 8.0, "edge_size": 0.04, "growth": 0.5}


@pytest.mark.parametrize(
    ("geometry", "length"),
    [
        # a³ = 3 P R/(4 E*), and the smaller half axis of an ellipse, whose tips need more elements.
        (
            {"template": "sphere", "parameters": {"size": 0.3}},
            (0.75 * 2900 * 50 / 115385) ** (1 / 3),
        ),
        # Half-planes under the mean force per length, a² = 4 P R/(π E*).
        (
            {"template": "cylinder_finite", "parameters": {"size": 0.2}},
            (4 * 290 * 30 / np.pi / 115385) ** 0.5,
        ),
    ],
)
def test_the_size_for_three_percent(geometry: dict[str, Any], length: float) -> None:
    (found,) = proposals({**SOLIDS, "geometry": geometry})
    assert found.length == pytest.approx(length, rel=0.02)
    assert found.size == pytest.approx(length * 0.03 / BAR_TIMES_ELEMENTS, rel=0.07)


def test_a_straight_section_is_a_cylinder_that_grows_as_fast() -> None:
    round_pad = {**cylinder(size=0.1), **STRAIGHT}
    (found,) = proposals({**SOLIDS, "geometry": round_pad})
    # As before, on four millimetres.
    assert found.length == pytest.approx((4 * 725 * 50 / np.pi / 115385) ** 0.5, rel=0.03)
    (punch,) = proposals(
        {**SOLIDS, "geometry": {"template": "flat_rounded", "parameters": PUNCH, **STRAIGHT}}
    )
    profile = FlatRounded(1.0, 8.0, 115385.0)
    grown = [float(profile.half_width(load)) for load in (1.01 * 725.0, 725.0)]
    assert punch.length == pytest.approx(2 * (grown[0] - grown[1]) / np.log(1.01), rel=0.05)
    assert punch.length < 0.5


def test_no_size_is_proposed_where_it_is_not_known() -> None:
    driven = {**SOLIDS["loads"]["press"], "control": "displacement"}
    (found,) = proposals({**SOLIDS, "loads": {"press": driven}})
    assert np.isnan(found.size) and "equilibrium does not" in found.reason


def test_check_proposes_a_size_with_its_memory(tmp_path: Path) -> None:
    path = tmp_path / "ball.toml"
    geometry = {"template": "sphere", "parameters": {"size": 0.3, "growth": 0.7}}
    path.write_text(tomli_w.dumps({**SOLIDS, "geometry": geometry}))
    out = " ".join(CliRunner().invoke(app, ["check", str(path)]).stdout.split())
    assert "Proposal: set geometry.parameters.size = 0.082 for K_N and ΔK to 3% at all" in out
    assert re.search(r"expected in contact main at P = 2900: about \d+ unknowns, [\d.]+ GB", out)
    set_size = ["check", str(path), "--set", "geometry.parameters.size=0.08"]
    out = " ".join(CliRunner().invoke(app, set_size).stdout.split())
    assert "geometry.parameters.size = 0.08 is likely to be small enough" in out


def test_much_finer_elements_are_not_meshed_to_see_what_they_take(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Meshing them may take hours, as with a load or a stiffness in another unit."""
    geometry = {"template": "sphere", "parameters": {"size": 0.3, "growth": 0.7}}
    light = {**SOLIDS, "geometry": geometry, "loads": {"press": press(0.29)}}
    case = check(parse_case(light))
    pascals = {name: {**STEEL, "young": 210e9} for name in ("upper", "lower")}
    doubted = check(parse_case({**SOLIDS, "geometry": geometry, "bodies": pascals}))
    assert case is not None and doubted is not None
    monkeypatch.setattr(checked, "check", None)
    (text,) = propose(case)
    assert re.search(r"what that takes was not looked at, as .*size is \d\d times as large", text)
    assert list(propose(doubted)) == []
    assert any("In Pa it would be usual" in note for note in doubted.notes)


def test_a_fine_sphere_is_quiet() -> None:
    assert (
        foreseen({**SOLIDS, "geometry": {"template": "sphere", "parameters": {"size": 0.1}}}) == []
    )


@pytest.mark.parametrize("name", ["dovetail", "firtree", "wedge", "ellipse"])
def test_demos_are_quiet(name: str) -> None:
    case = load_case(DEMOS / f"{name}.toml", trust_geo=True)
    assert list(coarse_contacts(case, load_mesh(case), build_history(case))) == []


def root(parameters: dict[str, float], friction: float = 0.6) -> dict[str, Any]:
    """The dovetail of the demos, with other sizes."""
    tables = tomllib.loads((DEMOS / "dovetail.toml").read_text())
    tables["geometry"]["parameters"] = parameters
    tables["contacts"] = {
        name: {**contact, "friction": friction} for name, contact in tables["contacts"].items()
    }
    return tables


def test_flanks_share_their_load_as_they_slide_and_stick() -> None:
    """By equilibrium: 3900 = 2 P (cos 45° + f sin 45°), then 1500 less of it by 1500/2 cos 45°."""
    case = parse_case(root({"edge_size": 0.02, "flank_size": 0.3}))
    mesh, history = load_mesh(case), build_history(case)
    (half,) = {tuple(np.round(each.forces, 6)) for each in expected_contacts(case, mesh, history)}
    largest = 3900 / (2 * (1 + 0.6) * np.sqrt(0.5))
    # Cycles go from 2400 to 3600; meshes follow the flanks to round-off.
    fallen = [(3900 - load) / 2 * np.sqrt(0.5) for load in (2400, 3600)]
    assert half == pytest.approx([largest - each for each in fallen], rel=1e-5)


def test_edges_of_flanks_and_the_size_that_they_want() -> None:
    (text,) = foreseen(root({"edge_size": 0.008, "flank_size": 0.3}))
    assert text.startswith("contact left (left and right), contact right (left and right): K_N is")
    assert "16 are wanted: set geometry.parameters.edge_size = 0.002" in text
    assert foreseen(root({"edge_size": 0.003, "flank_size": 0.3})) == []
    (text,) = foreseen(root({"edge_size": 0.003, "edge_zone": 0.02, "flank_size": 0.3}))
    assert "long, as those of geometry.parameters.edge_size end before" in text


@pytest.mark.parametrize("template", ["dovetail", "firtree"])
def test_default_sizes_of_roots_are_quiet(template: str) -> None:
    tables = tomllib.loads((DEMOS / f"{template}.toml").read_text())
    assert foreseen(tables | {"geometry": {"template": template}}) == []


def test_an_extruded_section_has_edges_as_a_plane_one() -> None:
    plain = {"template": "flat_rounded", "parameters": {**PUNCH, "edge_size": 0.05}}
    (text,) = foreseen({**SOLIDS, "geometry": {**plain, **STRAIGHT}})
    profile = FlatRounded(1.0, 8.0, 115385.0)
    a = float(profile.half_width(725.0))
    peak = profile.pressure(np.linspace(0.0, a, 4001)[:-1], a).max()
    rise = (peak / float(edge_factor_k_n(profile, a))) ** 2
    # Elements differ from their size by a tenth.
    assert elements(text) == pytest.approx(rise / 0.05, rel=0.15)
    assert ", 5 are wanted" in text


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
    assert (
        checked.exit_code == 0 and "Warning: contact main (left and right): K_N" in checked.stdout
    )
    observer = Announced()
    BACKEND.solve(load_case(path), RunOptions(observer=observer))
    said = ["Warning: contact main (left and right): K_N" in text for text in observer.texts]
    assert said.count(True) == 1 and observer.before_steps == len(observer.texts)


def test_loads_that_pull_apart_are_refused_by_check_and_run(tmp_path: Path) -> None:
    """Before anything is condensed; a body around the other one may be pulled anywhere."""
    path = tmp_path / "pad.toml"
    path.write_text(pad_text(loads={"press": press(-10.0)}))
    text = "pull them apart all the time, by up to 10: turn them round"
    with pytest.raises(ModelError, match=text):
        check(load_case(path))
    with pytest.raises(ModelError, match=text):
        BACKEND.solve(load_case(path), RunOptions())


def test_a_doubtful_stiffness_is_said_in_place_of_what_follows_from_it(tmp_path: Path) -> None:
    path = tmp_path / "pad.toml"
    # In kPa: in Pa a single node carries the load, on some meshes none.
    stiff = {**STEEL, "young": 210e6}
    geometry = cylinder(size=0.25)
    path.write_text(pad_text(geometry=geometry, bodies={"upper": stiff, "lower": stiff}))
    shown = " ".join(CliRunner().invoke(app, ["check", str(path)]).stdout.split())
    assert "K_N is likely" not in shown
    assert shown.count("bodies.upper.young, bodies.lower.young: 2.1e+08 is in MPa") == 1
    observer = Announced()
    result = BACKEND.solve(load_case(path), RunOptions(observer=observer))
    for texts in (observer.texts, result.notes):
        assert sum("2.1e+08 is in MPa" in text for text in texts) == 1
    assert not any("K_N is likely" in text for text in observer.texts)


def test_a_modulus_in_gpa_is_doubted(tmp_path: Path) -> None:
    """210 MPa is a polymer; under the loads of steel it would be squeezed flat."""
    path = tmp_path / "pad.toml"
    soft = {**STEEL, "young": 210.0}
    path.write_text(pad_text(bodies={"upper": soft, "lower": soft}))
    shown = " ".join(CliRunner().invoke(app, ["check", str(path)]).stdout.split())
    assert "Warning: contact main: P = 600 means a pressure of " in shown
    assert "check bodies.upper and bodies.lower, which are in MPa" in shown
    assert "K_N is likely" not in shown
    case = load_case(path)
    assert len(list(pressure_doubts(case, load_mesh(case), build_history(case)))) == 1
    path.write_text(pad_text())
    case = load_case(path)
    assert not list(pressure_doubts(case, load_mesh(case), build_history(case)))
