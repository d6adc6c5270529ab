# SPDX-License-Identifier: LGPL-3.0-or-later
"""Layers between the surfaces of bodies, and gaps that are given."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import BASE, HOLD, PAD, TOP, cylinder, pad, press
from reference.half_plane_collocation import compliance, partial_slip, pressed

import fretfe
from fretfe._typing import Array
from fretfe.analytic.profiles import composite_modulus
from fretfe.case import parse_case
from fretfe.errors import CaseError
from fretfe.reason import Kind
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import write_results

MODULUS = composite_modulus(210e3, 0.3, 210e3, 0.3)
HALF_WIDTH = 0.57536
SHEARED = [HOLD, {"ramp": 120.0, "until": 2.0, "steps": 4}]


def solved(
    main: dict[str, Any], folder: Path = Path(), radius: float = 50.0, size: float = 0.02
) -> Result:
    geometry = cylinder(size=size)
    geometry["parameters"]["upper_radius"] = radius
    shear = {**TOP, "direction": "x", "history": SHEARED}
    tables = {
        "geometry": geometry,
        "contacts": {"main": {**PAD["contacts"]["main"], **main}},
        "loads": {"press": press(), "shear": shear},
        "supports": BASE,
    }
    return fretfe.run(parse_case(pad(**tables), source=folder / "pad.toml"))


def profile(folder: Path, arc: Array, gap: Array) -> dict[str, str]:
    rows = "\n".join(f"{a:.12g},{g:.12g}" for a, g in zip(arc, gap, strict=True))
    (folder / "gap.csv").write_text(f"arc,gap\n{rows}\n")
    return {"gap": "gap.csv"}


@pytest.fixture(scope="module")
def layered() -> Result:
    normal = MODULUS / (0.3 * HALF_WIDTH)
    return solved({"layer": {"normal": normal, "tangential": 2 * normal}})


def test_pressure_and_shear_on_a_layer_are_those_of_collocation(layered: Result) -> None:
    history = layered.contact_history("main")
    x = np.linspace(-1, 1, 801) * 1.4 * HALF_WIDTH
    given = 0.3 * HALF_WIDTH / MODULUS
    pressure = pressed(x, x**2 / 100, compliance(x, MODULUS, given), 600.0)
    touching = pressure > 0
    places = x[touching]
    matrix = compliance(places, MODULUS, given / 2)
    shear, slips = partial_slip(places, matrix, 0.4 * pressure[touching], 120.0)
    assert 0.2 < np.abs(places[~slips]).max() / places.max() < 0.9
    arc, found = history.surface.arc, history.traction[-1]
    assert np.abs(found[:, 0] - np.interp(arc, x, pressure)).max() < 0.01 * pressure.max()
    inside = np.abs(arc) < places.max()
    wrong = found[inside, 1] - np.interp(arc[inside], places, shear)
    assert np.abs(wrong).max() < 0.03 * 0.4 * pressure.max()
    assert np.abs(wrong).mean() < 0.005 * 0.4 * pressure.max()
    assert Kind.LAYER in {each.kind for each in layered.contacts[0].warnings}
    assert layered.contacts[0].shear_force[-1] == pytest.approx(120.0, rel=1e-9)


def test_a_coat_that_is_worn_through_in_the_middle(tmp_path: Path) -> None:
    places = np.array([-3, -0.32, -0.28, 0.28, 0.32, 3])
    thick, thin = 0.3 * HALF_WIDTH / MODULUS, 0.03 * HALF_WIDTH / MODULUS
    given = np.array([thick, thick, thin, thin, thick, thick])
    rows = "\n".join(f"{a},{1 / c:.12g},{1 / c:.12g}" for a, c in zip(places, given, strict=True))
    (tmp_path / "coat.csv").write_text(f"arc,normal,tangential\n{rows}\n")
    history = solved({"layer": {"csv": "coat.csv"}}, tmp_path).contact_history("main")
    x = np.linspace(-1, 1, 801) * 1.4 * HALF_WIDTH
    own = np.interp(x, places, given)
    pressure = pressed(x, x**2 / 100, compliance(x, MODULUS, own), 600.0)
    even = pressed(x, x**2 / 100, compliance(x, MODULUS, thick), 600.0)
    assert pressure.max() > 1.05 * even.max()
    wrong = history.traction[-1][:, 0] - np.interp(history.surface.arc, x, pressure)
    # Most where the coat begins, over two elements.
    assert np.abs(wrong).max() < 0.05 * pressure.max()
    assert np.abs(wrong).mean() < 0.005 * pressure.max()


def test_a_table_of_one_stiffness_is_that_layer_bit_for_bit(
    layered: Result, tmp_path: Path
) -> None:
    normal = MODULUS / (0.3 * HALF_WIDTH)
    places = np.linspace(-3, 3, 13)
    rows = "".join(f"{x},0,{normal!r},{2 * normal!r}\n" for x in places)
    (tmp_path / "coat.csv").write_text(f"x,y,normal,tangential\n{rows}")
    other = solved({"layer": {"csv": "coat.csv"}}, tmp_path)
    mine, theirs = (each.contact_history("main").traction[:] for each in (layered, other))
    assert np.array_equal(mine, theirs)


def test_files_keep_the_length_of_the_layer(layered: Result, tmp_path: Path) -> None:
    write_results(tmp_path, layered)
    kept = load_result(tmp_path).contact_history("main").surface.layer
    assert kept == pytest.approx([0.3 * HALF_WIDTH, 0.15 * HALF_WIDTH], rel=1e-4)


def test_crowning_as_a_gap_is_crowning_of_the_mesh(tmp_path: Path) -> None:
    arc = np.linspace(-3, 3, 121)
    gap = profile(tmp_path, arc, arc**2 / 2 * (1 / 50 - 1 / 100))
    given, meshed = solved(gap, tmp_path, radius=100.0), solved({})
    pair = zip(given.contacts[0].stations, meshed.contacts[0].stations, strict=True)
    for one, other in pair:
        assert one.decisive_k_n[0] == pytest.approx(other.decisive_k_n[0], rel=2e-3)
        assert one.k_t[-1] == pytest.approx(other.k_t[-1], rel=2e-3)
        assert one.slip_zones[-1].length == pytest.approx(other.slip_zones[-1].length, rel=2e-3)
    half_widths = given.contacts[0].half_width[-1], meshed.contacts[0].half_width[-1]
    assert half_widths[0] == pytest.approx(half_widths[1], rel=1e-3)


def test_waves_that_elements_do_not_resolve_are_reported(tmp_path: Path) -> None:
    arc = np.linspace(-3, 3, 3001)
    smooth = 0.0005 * (1 - np.cos(np.pi * arc))
    waves = {
        "fine": smooth + 0.0002 * (1 - np.cos(2 * np.pi * arc / 0.02)),
        "smooth": smooth,
    }
    found = {}
    for name, values in waves.items():
        result = solved(profile(tmp_path, arc, values), tmp_path)
        found[name] = Kind.GAP_MISSED in {each.kind for each in result.contacts[0].warnings}
    assert found == {"fine": True, "smooth": False}


def test_a_gap_that_lets_surfaces_overlap_is_refused(tmp_path: Path) -> None:
    arc = np.linspace(-3, 3, 61)
    with pytest.raises(CaseError) as error:
        solved(profile(tmp_path, arc, -0.01 * np.cos(arc)), tmp_path)
    text = str(error.value)
    assert "contacts.main.gap: expected a gap that leaves the surfaces apart or touching" in text
    assert "found an overlap of 0.009999 mm at (0, 0): add that" in text


# Of rough surfaces: p grows as the square of the approach.
PRESSURES = np.array([0.0, 5.0, 20.0, 60.0, 150.0, 300.0, 600.0])
ROUGH = {
    "pressure": PRESSURES.tolist(),
    "approach": (0.002 * np.sqrt(PRESSURES / 600)).tolist(),
    "tangential": 3e5,
}


def test_pressure_on_rough_surfaces_is_that_of_collocation() -> None:
    history = solved({"layer": ROUGH}).contact_history("main")
    x = np.linspace(-1, 1, 801) * 1.5 * HALF_WIDTH
    slopes = np.diff(ROUGH["approach"]) / np.diff(PRESSURES)
    pressure = np.full_like(x, 100.0)
    for _ in range(40):  # Newton's method: a linear layer at each place
        part = np.clip(np.searchsorted(PRESSURES, pressure, "right") - 1, 0, len(slopes) - 1)
        given = np.array(ROUGH["approach"])[part] - slopes[part] * PRESSURES[part]
        before = pressure
        matrix = compliance(x, MODULUS, slopes[part])
        pressure = pressed(x, x**2 / 100 + given, matrix, 600.0)
        if np.abs(pressure - before).max() < 1e-6:
            break
    else:
        raise AssertionError("collocation did not settle")
    found = history.traction[-1][:, 0]
    assert np.abs(found - np.interp(history.surface.arc, x, pressure)).max() < 0.01 * found.max()
    smooth = solved({}).contact_history("main").traction[-1][:, 0]
    assert found.max() < 0.97 * smooth.max()


def test_a_straight_curve_is_a_linear_layer(layered: Result) -> None:
    normal = MODULUS / (0.3 * HALF_WIDTH)
    pressures = [0.0, 10.0, 100.0, 2000.0]
    curve = {"pressure": pressures, "approach": [p / normal for p in pressures]}
    other = solved({"layer": {**curve, "tangential": 2 * normal}})
    mine, theirs = (each.contact_history("main").traction[:] for each in (layered, other))
    assert np.abs(mine - theirs).max() < 1e-8 * np.abs(mine).max()
