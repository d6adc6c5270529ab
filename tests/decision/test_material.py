# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fatigue data from material files: units, and hostile files with file and key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from fretfe.case import Body, Units
from fretfe.case.materials import material_directory, material_names, read_material
from fretfe.decision.material import fatigue_data
from fretfe.decision.thresholds import critical_length
from fretfe.errors import CaseError

LIMIT = {"range": 496.0, "ratio": -1.0}
WALKER = {"range": 4.2, "ratio": 0.0, "walker": 0.5}
PARIS = {"factor": 1e-11, "exponent": 3.0, "ranges": [5.0, 50.0], "start": 1e-4, "end": 2e-3}
FATIGUE: dict[str, Any] = {
    "source": "for a test",
    "units": {"stress": "MPa", "length": "m"},
    "limit": LIMIT,
    "torsion": 155.0,
    "threshold": WALKER,
    "growth": PARIS,
}


def write(folder: Path, **fatigue: Any) -> Path:
    """A material file with other fatigue data; None leaves a key out."""
    table = {key: value for key, value in {**FATIGUE, **fatigue}.items() if value is not None}
    tables = {"source": "for a test", "units": {"stress": "GPa"}, "young": 210.0, "poisson": 0.3}
    path = folder / "alloy.toml"
    path.write_text(tomli_w.dumps({**tables, "fatigue": table}), "utf-8")
    return path


def test_numbers_are_in_the_units_of_the_results(tmp_path: Path) -> None:
    """MPa √m are √1000 MPa √mm; growth in m per cycle is 1000 mm."""
    path = write(tmp_path)
    data = fatigue_data(path, Units())
    assert data.limit is not None and data.threshold is not None and data.growth is not None
    assert (data.limit.stress_range, data.limit.ratio, data.torsion) == (496.0, -1.0, 155.0)
    assert data.threshold.at(np.array([0.0])) == pytest.approx(4.2 * np.sqrt(1000))
    assert data.growth.rate(np.array([10 * np.sqrt(1000)])) == pytest.approx(1e-5)
    assert data.lengths == pytest.approx((0.1, 2.0))
    assert data.young == pytest.approx((210e3, 210e3))
    same = fatigue_data(path, Units(length="m", stress="Pa", force="N"))
    assert same.threshold is not None
    assert same.threshold.at(np.array([0.0])) == pytest.approx(4.2e6)


@pytest.mark.parametrize(
    ("data", "found"),
    [
        ({"limit": {"range": 496e3, "ratio": -1.0}, "torsion": 155e3}, "found 2.36 E"),
        ({"limit": {"range": 0.496, "ratio": -1.0}, "torsion": 0.155}, "found 2.36e-06 E"),
        ({"threshold": {**WALKER, "range": 4.2 * 1000**0.5}}, "found 0.000632 E √m"),
        ({"threshold": {**WALKER, "range": 4.2e-3}}, "found 2e-08 E √m"),
    ],
)
def test_data_in_another_unit_are_refused(tmp_path: Path, data: dict[str, Any], found: str) -> None:
    """Of E = 210 GPa: kPa, GPa, MPa √mm and GPa √m in place of MPa and m."""
    with pytest.raises(CaseError, match=f"{found}: are the units"):
        fatigue_data(write(tmp_path, **data), Units())


def test_the_file_of_the_documents(tmp_path: Path) -> None:
    """It is whole, and L has the value that stands there."""
    page = (Path(__file__).parents[2] / "docs" / "strength.md").read_text("utf-8")
    path = tmp_path / "alloy.toml"
    path.write_text(page.split("```toml\n")[1].split("```")[0], "utf-8")
    data = fatigue_data(path, Units())
    assert data.limit is not None and data.threshold is not None and data.growth is not None
    assert f"L = {critical_length(data.threshold, data.limit):.3g} mm" in page


def test_tables_and_what_is_left_out(tmp_path: Path) -> None:
    table = {"ratios": [-1.0, 0.0, 0.5], "ranges": [8.0, 4.0, 3.0]}
    rates = {"ranges": [5, 10, 20], "rates": [1e-9, 1e-8, 1e-7], "start": 1e-4, "end": 1e-3}
    data = fatigue_data(
        write(tmp_path, threshold=table, growth=rates, torsion=None, limit=None), Units()
    )
    assert data.threshold is not None and data.growth is not None
    assert data.limit is data.torsion is None
    assert data.threshold.at(np.array([0.25])) == pytest.approx(3.5 * np.sqrt(1000))
    assert data.growth.rate(np.array([10 * np.sqrt(1000)])) == pytest.approx(1e-5)
    bare = {key: None for key in FATIGUE if key not in ("source", "units")}
    data = fatigue_data(write(tmp_path, **bare), Units())
    assert data.growth is data.threshold is data.limit is data.lengths is None


def test_bodies_of_the_material(tmp_path: Path) -> None:
    data = fatigue_data(write(tmp_path), Units())
    assert data.disagreement(Body(young=205e3, poisson=0.29)) == ""
    assert "E = 1.138e+05" in data.disagreement(Body(young=113.8e3, poisson=0.3))
    assert "ν = 0.35" in data.disagreement(Body(young=210e3, poisson=0.35))


def test_a_file_over_temperature(tmp_path: Path) -> None:
    path = write(tmp_path)
    text = path.read_text("utf-8").replace(
        "young = 210.0", "young = { temperatures = [20, 400], values = [210, 180] }"
    )
    path.write_text(text, "utf-8")
    assert fatigue_data(path, Units()).young == pytest.approx((180e3, 210e3))


HOSTILE: dict[str, tuple[dict[str, Any], str]] = {
    "no source": ({"source": None}, "fatigue.source"),
    "empty source": ({"source": ""}, "fatigue.source"),
    "no units": ({"units": None}, "fatigue: expected units beside data"),
    "no data": ({key: None for key in FATIGUE if key != "source"}, "fatigue: expected a table of"),
    "unit of stress": ({"units": {"stress": "bar", "length": "m"}}, "fatigue.units.stress"),
    "unit of length": ({"units": {"stress": "MPa", "length": "MPa"}}, "fatigue.units.length"),
    "no unit of length": ({"units": {"stress": "MPa"}}, "fatigue.units.length"),
    "another unit": ({"units": {"stress": "MPa", "length": "m", "x": 1}}, "fatigue.units.x"),
    "units as text": ({"units": "MPa"}, "fatigue.units"),
    "another key": ({"limits": LIMIT}, "fatigue.limits"),
    "limit as number": ({"limit": 496.0}, "fatigue.limit"),
    "limit without ratio": ({"limit": {"range": 496.0}}, "fatigue.limit.ratio"),
    "limit of none": ({"limit": {"range": 0.0, "ratio": -1.0}}, "fatigue.limit.range"),
    "negative limit": ({"limit": {"range": -5.0, "ratio": -1.0}}, "fatigue.limit.range"),
    "infinite limit": ({"limit": {"range": float("inf"), "ratio": 0.0}}, "fatigue.limit.range"),
    "no number": ({"limit": {"range": float("nan"), "ratio": 0.0}}, "fatigue.limit.range"),
    "limit as text": ({"limit": {"range": "496", "ratio": 0.0}}, "fatigue.limit.range"),
    "true": ({"limit": {"range": True, "ratio": 0.0}}, "fatigue.limit.range"),
    "static limit": ({"limit": {"range": 5.0, "ratio": 1.0}}, "fatigue.limit.ratio"),
    "ratio of nan": ({"limit": {"range": 5.0, "ratio": float("nan")}}, "fatigue.limit.ratio"),
    "torsion of none": ({"torsion": 0.0}, "fatigue.torsion"),
    "torsion as list": ({"torsion": [155.0]}, "fatigue.torsion"),
    "brittle": ({"torsion": 260.0}, "fatigue: expected torsion between"),
    "weak": ({"torsion": 100.0}, "fatigue: expected torsion between"),
    "pulsating limit": ({"limit": {"range": 300.0, "ratio": 0.0}}, "fatigue: expected a limit"),
    "torsion alone": ({"limit": None}, "fatigue: expected a limit"),
    "threshold as number": ({"threshold": 4.2}, "fatigue.threshold"),
    "empty threshold": ({"threshold": {}}, "fatigue.threshold"),
    "without exponent": ({"threshold": {"range": 4.2, "ratio": 0.0}}, "fatigue.threshold"),
    "both": ({"threshold": {**WALKER, "ratios": [0.0, 1.0]}}, "fatigue.threshold"),
    "negative exponent": ({"threshold": {**WALKER, "walker": -1.0}}, "fatigue.threshold.walker"),
    "threshold of none": ({"threshold": {**WALKER, "range": 0}}, "fatigue.threshold.range"),
    "one ratio": ({"threshold": {"ratios": [0.0], "ranges": [4.0]}}, "fatigue.threshold.ratios"),
    "turned": ({"threshold": {"ratios": [0.5, 0.0], "ranges": [3, 4]}}, "fatigue.threshold"),
    "unequal": ({"threshold": {"ratios": [0.0, 0.5], "ranges": [3, 4, 5]}}, "fatigue.threshold"),
    "ratio of one": ({"threshold": {"ratios": [0.0, 1.0], "ranges": [3, 4]}}, "fatigue.threshold"),
    "threshold that grows": (
        {"threshold": {"ratios": [0.0, 0.5], "ranges": [3, 4]}},
        "fatigue.threshold: expected ranges that do not grow with R",
    ),
    "only ratios": ({"threshold": {"ratios": [0.0, 0.5]}}, "fatigue.threshold"),
    "growth without lengths": ({"growth": {**PARIS, "start": None}}, "fatigue.growth.start"),
    "growth to the stars": ({"growth": {**PARIS, "end": 1e30}}, "fatigue: growth.end: expected"),
    "growth backwards": ({"growth": {**PARIS, "start": 1.0}}, "fatigue.growth"),
    "three bounds": ({"growth": {**PARIS, "ranges": [1, 2, 3]}}, "fatigue.growth"),
    "one bound": ({"growth": {**PARIS, "ranges": [1]}}, "fatigue.growth.ranges"),
    "turned bounds": ({"growth": {**PARIS, "ranges": [50, 5]}}, "fatigue.growth"),
    "no law": ({"growth": {"ranges": [5, 50], "start": 1e-4, "end": 1e-3}}, "fatigue.growth"),
    "steep law": ({"growth": {**PARIS, "exponent": 300.0}}, "fatigue.growth: expected rates"),
    "half a law": ({"growth": {**PARIS, "exponent": None}}, "fatigue.growth"),
    "two laws": ({"growth": {**PARIS, "rates": [1e-9, 1e-8]}}, "fatigue.growth"),
    "life below the limit": (
        {"life": {"ratio": -1.0, "amplitudes": [420, 100], "cycles": [1e4, 1e6]}},
        "fatigue: life: expected amplitudes of at least 248",
    ),
    "law below the limit": (
        {
            "life": {
                **{"strength": 500.0, "exponent": -0.1, "ductility": 1.0},
                **{"ductility_exponent": -0.6, "cycles": [1e3, 1e7]},
            }
        },
        "fatigue: life: expected amplitudes of at least 248",
    ),
    "falling": (
        {"growth": {"ranges": [5, 50], "rates": [2e-9, 1e-9], "start": 1e-4, "end": 1e-3}},
        "fatigue.growth",
    ),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_refused_with_file_and_key(name: str, tmp_path: Path) -> None:
    changed, key = HOSTILE[name]
    cleaned = {
        part: {k: v for k, v in value.items() if v is not None}
        if isinstance(value, dict)
        else value
        for part, value in changed.items()
    }
    path = write(tmp_path, **cleaned)
    with pytest.raises(CaseError) as error:
        fatigue_data(path, Units())
    assert str(error.value).startswith(f"{path}: {key}")


def test_files_without_data_and_results_without_known_units(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"steel\.toml: fatigue: expected a table of data"):
        fatigue_data(material_directory() / "steel.toml", Units())
    strange = Units(length="furlong", force="N", stress="N/furlong²")
    with pytest.raises(CaseError, match=r"alloy\.toml: fatigue\.units\.stress: expected results"):
        fatigue_data(write(tmp_path), strange)
    with pytest.raises(CaseError, match="expected a material file"):
        fatigue_data(tmp_path / "none.toml", Units())


def test_no_fatigue_data_are_invented() -> None:
    for name in material_names():
        assert read_material(material_directory() / f"{name}.toml").fatigue is None
