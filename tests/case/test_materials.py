# SPDX-License-Identifier: LGPL-3.0-or-later
"""Materials from files, and constants over temperature: numbers, units, notes, wrong files."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from cases.pad_cases import pad, press
from typer.testing import CliRunner

from fretfe.case import Body, Case, Crystal, case_schema, case_text, changed, load_case, parse_case
from fretfe.case.bodies import OverTemperature
from fretfe.case.materials import find_material, material_names, read_material
from fretfe.case.overrides import parse_assignments
from fretfe.cli.app import app
from fretfe.errors import CaseError

STEEL = {"young": 210e3, "poisson": 0.3}
CURVE = {"temperatures": [20, 220, 420], "values": [200e3, 190e3, 170e3]}


def case_of(upper: dict[str, Any], source: Path | str = "case.toml", **tables: Any) -> Case:
    bodies = {"upper": upper, "lower": STEEL}
    return parse_case(pad(bodies=bodies, loads={"press": press()}, **tables), source)


def upper(given: dict[str, Any], source: Path | str = "case.toml", **tables: Any) -> Any:
    return case_of(given, source, **tables).bodies["upper"]


@pytest.mark.parametrize(("temperature", "young"), [(20, 200e3), (320, 180e3), (420, 170e3)])
def test_linear_between_temperatures(temperature: float, young: float) -> None:
    body = upper({"young": CURVE, "poisson": 0.3, "temperature": temperature})
    assert isinstance(body, Body)
    assert (body.young, body.temperature) == (young, temperature)


def test_all_constants_over_temperature() -> None:
    def over(one: Any, other: Any) -> dict[str, Any]:
        return {"temperatures": [0, 100], "values": [one, other]}

    body = upper({"young": over(1.0, 3.0), "poisson": over(0.2, 0.4), "density": over(1.0, 2.0),
                  "expansion": over(-1e-6, 1e-6), "temperature": 50.0})  # fmt: skip
    found = body.young, body.poisson, body.density, body.expansion
    np.testing.assert_allclose(found, [2.0, 0.3, 1.5, 0.0], atol=1e-15)
    cubic = over([250e3, 160e3, 130e3], [230e3, 150e3, 110e3])
    crystal = upper({"elastic": {"cubic": cubic}, "temperature": 50.0})
    assert crystal.elastic.cubic == (240e3, 155e3, 120e3)


# Stress unit, length unit, force unit: E of Ti-6Al-4V and its density in these.
UNITS = {
    "mm": ({}, 113.8e3, 4.43e-9),
    "m": ({"length": "m", "stress": "Pa"}, 113.8e9, 4430.0),
    "GPa": ({"length": "mm", "force": "kN", "stress": "GPa"}, 113.8, 4.43e-12),
    "ms": ({"time": "ms"}, 113.8e3, 4.43e-3),
    "in": ({"length": "in", "force": "lbf", "stress": "psi"}, 16.50529e6, 4.14526e-4),
}


@pytest.mark.parametrize(("units", "young", "density"), UNITS.values(), ids=UNITS)
def test_constants_are_in_the_units_of_the_case(
    units: dict[str, str], young: float, density: float
) -> None:
    geometry = pad()["geometry"]
    body = upper({"material": "Ti-6Al-4V"}, units=units, geometry=geometry)
    assert body.young == pytest.approx(young, rel=1e-5)
    assert body.density == pytest.approx(density, rel=1e-5)
    assert (body.poisson, body.expansion, body.material) == (0.342, 8.6e-6, None)


def test_crystals_and_keys_beside_the_material() -> None:
    crystal = upper({"material": "nickel-crystal", "orientation": {"euler": [10, 0, 0]}})
    assert isinstance(crystal, Crystal)
    assert crystal.elastic.cubic == (246.5e3, 147.3e3, 124.7e3)
    assert upper({"material": "steel", "density": 1.0}).density == 1.0
    own = upper({"material": "steel", "elastic": {"cubic": [250e3, 160e3, 130e3]}})
    assert isinstance(own, Crystal)
    assert own.density == pytest.approx(7.85e-9)
    body = upper({"material": "nickel-crystal", **STEEL})
    assert isinstance(body, Body)


def test_a_table_in_a_material_needs_a_temperature() -> None:
    # 31.0e6 psi at -129 C, 30.4e6 psi at -73 C.
    body = upper({"material": "CrMo-steel", "temperature": -101.0})
    assert body.young == pytest.approx(30.7e6 * 6.894757e-3, rel=1e-6)
    with pytest.raises(CaseError, match=r"upper\.temperature: expected a temperature from -200 to"):
        upper({"material": "CrMo-steel"})
    # A modulus of its own needs none.
    assert upper({"material": "CrMo-steel", "young": 1e5}).young == 1e5


def test_every_material_is_whole_and_has_a_source() -> None:
    for name in material_names():
        read = read_material(find_material(name, Path()))
        assert len(read.source) > 20
        body = upper({"material": name, "temperature": 21.0})
        assert isinstance(body, Body | Crystal)


OWN = {"source": "tests", "units": {"stress": "GPa", "density": "kg/m^3"}, "young": 70.0,
       "poisson": 0.33, "density": 2700.0}  # fmt: skip


def write(folder: Path, data: dict[str, Any] | str) -> Path:
    text = data if isinstance(data, str) else tomli_w.dumps(data)
    (folder / "own.toml").write_text(text)
    return folder / "case.toml"


def test_a_file_of_the_user_and_what_is_recorded(tmp_path: Path) -> None:
    curve = {"temperatures": [0.0, 100.0], "values": [70.0, 60.0]}
    source = write(tmp_path, {**OWN, "young": curve})
    bodies = {"upper": {"material": "own.toml", "temperature": 50.0}, "lower": STEEL}
    source.write_text(tomli_w.dumps(pad(bodies=bodies, loads={"press": press()})))
    case = load_case(source)
    note = "bodies.upper: own.toml (tests), constants at 50 °C: young = 65000, poisson = 0.33"
    assert case.material_notes == (f"{note}, density = 2.7e-9",)
    # The case as run needs the file no more.
    text = case_text(case)
    assert note in text
    again = parse_case(tomllib.loads(text))
    assert again.bodies == case.bodies
    # Other temperatures are those of the table, by overrides and sweeps.
    key = "bodies.upper.temperature"
    hot = changed(case, {key: 100.0}).bodies["upper"]
    assert isinstance(hot, Body)
    assert hot.young == pytest.approx(60e3)
    assert load_case(source, parse_assignments([f"{key}=100.0"])).bodies["upper"] == hot


FILES: dict[str, tuple[dict[str, Any] | str, str]] = {
    "no TOML": ("young = ", "own.toml: line 1, column 9: not valid TOML"),
    "empty": ("", "own.toml: source: expected a value (the key is required)"),
    "no units": ({**OWN, "units": {}}, "own.toml: units.stress: expected a value"),
    "unknown unit": ({**OWN, "units": {"stress": "bar"}}, "expected one of Pa, kPa, MPa"),
    "no unit of density": (
        {**OWN, "units": {"stress": "GPa"}},
        "expected units.density beside density, found none",
    ),
    "unknown key": ({**OWN, "yuong": 1}, "own.toml: yuong: unknown key; did you mean 'young'?"),
    "nan": ({**OWN, "young": float("nan")}, "own.toml: young: expected a"),
    "negative": ({**OWN, "young": -1.0}, "own.toml: young: expected a number > 0, found -1000"),
    "text": ({**OWN, "young": "70"}, "own.toml: young: expected a number, found text '70'"),
    "no young": (
        {k: v for k, v in OWN.items() if k != "young"},
        "own.toml: young: expected a value",
    ),
    "both": (
        {**OWN, "elastic": {"cubic": [3.0, 1.0, 1.0]}},
        "own.toml: expected either 'young' and 'poisson', or 'elastic'",
    ),
    "not definite": (
        {"source": "x", "units": {"stress": "GPa"}, "elastic": {"cubic": [1.0, 2.0, 1.0]}},
        "own.toml: elastic: expected constants by which every strain takes energy",
    ),
    "unsorted": (
        {**OWN, "young": {"temperatures": [100, 0], "values": [1, 2]}},
        "own.toml: young: expected increasing temperatures, found [100.0, 0.0]",
    ),
    "counts": (
        {**OWN, "young": {"temperatures": [0, 100], "values": [1]}},
        "own.toml: young: expected as many values as temperatures, found 2 temperatures and 1",
    ),
    "cold": (
        {**OWN, "young": {"temperatures": [-300, 100], "values": [1, 2]}},
        "own.toml: young.temperatures[item 1]: expected a number >= -273.15, found -300",
    ),
    "huge": ("# " + "x" * 1_100_000, "of at most 1e+06 bytes, found 1100002"),
}


@pytest.mark.parametrize(("data", "expected"), FILES.values(), ids=FILES)
def test_wrong_files(data: dict[str, Any] | str, expected: str, tmp_path: Path) -> None:
    source = write(tmp_path, data)
    with pytest.raises(CaseError, match=re.escape(expected)):
        upper({"material": "own.toml", "temperature": 50.0}, source)


def over(**keys: Any) -> dict[str, Any]:
    return {"young": {**CURVE, **keys}, "poisson": 0.3, "temperature": 50.0}


KEYS: dict[str, tuple[dict[str, Any], str]] = {
    "unknown": ({"material": "ti-6al-4v"}, "found text 'ti-6al-4v'; did you mean 'Ti-6Al-4V'?"),
    "number": ({"material": 3}, "case.toml: bodies.upper.material: expected one of"),
    "path": ({"material": "../../etc/passwd"}, "or a file whose name ends in '.toml'"),
    "no file": ({"material": "no.toml"}, "no.toml: expected a material file (TOML), found nothing"),
    "hot": ({**over(), "temperature": 421.0}, "expected a temperature from 20 to 420 °C, those of "
            "'young', at which the constants are taken, found 421"),
    "no temperature": ({**over(), "temperature": float("nan")}, "found nan"),
    "text": ({**over(), "temperature": "hot"}, "found text 'hot'"),
    "one": (over(temperatures=[20], values=[1]), "temperatures: expected at least 2 entries"),
    "nan": (over(values=[1, float("nan"), 2]), "expected numbers, found another value in item 2"),
    "nan in it": (over(temperatures=[20, float("nan"), 30]), "temperatures[item 2]: expected a"),
    "key": (over(unit="K"), "bodies.upper.young.unit: unknown key"),
    "lists": (over(values=[[1, 2], [1], [1, 2]]), "expected as many constants at each temperature"),
    "list": (over(values=[[1, 2], [1, 3], [1, 2]]), "bodies.upper.young: expected a number"),
    "negative": (over(values=[-1, -1, -1]), "bodies.upper.young: expected a number > 0"),
}  # fmt: skip


@pytest.mark.parametrize(("body", "expected"), KEYS.values(), ids=KEYS)
def test_wrong_keys(body: dict[str, Any], expected: str) -> None:
    with pytest.raises(CaseError, match=re.escape(expected)):
        upper(body)


WRONG_UNITS = {
    "unknown": ({"length": "furlong"}, "units.length: expected one of um"),
    "stress": ({"length": "in"}, "units.stress: expected one of Pa, kPa"),
    "contradiction": ({"stress": "GPa"}, "units: expected stress = 'MPa', which is force/length²"),
}  # fmt: skip


@pytest.mark.parametrize(("units", "expected"), WRONG_UNITS.values(), ids=WRONG_UNITS)
def test_units_that_cannot_be_converted(units: dict[str, str], expected: str) -> None:
    with pytest.raises(CaseError, match=re.escape(expected)):
        upper({"material": "steel"}, units=units)
    if "length" in units:
        assert upper(STEEL, units=units).young == 210e3  # no material, nothing to convert


def test_schema_and_command() -> None:
    tables = case_schema()["$defs"]
    young = tables["Body"]["properties"]["young"]
    assert {"$ref": "#/$defs/OverTemperature"} in young["anyOf"]
    assert tables["OverTemperature"]["properties"].keys() == set(OverTemperature.model_fields)
    runner = CliRunner()
    assert "Ti-6Al-4V" in runner.invoke(app, ["materials"]).output
    printed = runner.invoke(app, ["materials", "steel"]).output
    assert tomllib.loads(printed)["young"] == 210e3
    assert isinstance(runner.invoke(app, ["materials", "x"]).exception, CaseError)
