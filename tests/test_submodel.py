# SPDX-License-Identifier: LGPL-3.0-or-later
"""The plane problem of a station, from exact factors of a sphere: Cattaneo and Mindlin, a = 1."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solid_runs import (
    FRICTION,
    K_N,
    LIMIT,
    PEAK,
    SHEAR,
    exact_station,
    stationed_sphere,
    with_stations,
)
from typer.testing import CliRunner

from fretfe.analytic.profiles import Hertz, edge_factor_k_n
from fretfe.cli.app import app
from fretfe.errors import CaseError, ConvergenceError, ModelError, OutputError
from fretfe.evaluate.contacts import SlipZone
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import write_results
from fretfe.submodel.comparison import StationModel
from fretfe.submodel.run import run_station

# The load is ±SHEAR f P: the slip annulus of Cattaneo and Mindlin.
WIDTH = 1 - (1 - 0.5 * SHEAR) ** (1 / 3)
ANGLE = 30.0


@pytest.fixture(scope="module")
def solid() -> Result:
    """Twelve stations with exact K_N, K_T, K_S and K_I for half of the shear, across each other."""
    result = stationed_sphere()
    shear = result.loads.values[:, 1]
    load = 0.5 * SHEAR * shear / np.abs(shear).max()
    return with_stations(result, lambda station: exact_station(station, load, ANGLE))


@pytest.fixture(scope="module")
def model(solid: Result) -> StationModel:
    return run_station(solid, "main", 1, 5, None)


def changed(solid: Result, **values: Any) -> Result:
    return with_stations(solid, lambda station: replace(station, **values))


def test_cylinder_has_the_factors_of_the_station(model: StationModel) -> None:
    assert model.half_width == pytest.approx(0.5)
    bodies = model.plane.case.bodies
    e_star = bodies["upper"].young / (2 * (1 - bodies["upper"].poisson ** 2))
    profile = Hertz(model.radius, e_star)
    assert float(edge_factor_k_n(profile, 0.5)) == pytest.approx(K_N)
    assert model.plane_k_n == pytest.approx(K_N, rel=1e-3)
    assert model.k_mismatch < 0.005 and model.k_i_mismatch < 0.005
    assert np.ptp(model.k) == pytest.approx(SHEAR * LIMIT, rel=1e-6)


def test_slip_zone_is_that_of_the_sphere_to_second_order(model: StationModel) -> None:
    """The first order alone is 10 % short, that of a cylinder as wide as the sphere 6 %."""
    lengths = [zone.length for zone in model.plane.contacts[0].stations[0].slip_zones[-2:]]
    assert lengths == pytest.approx([WIDTH, WIDTH], rel=0.02)
    first_order = SHEAR * LIMIT / (FRICTION * K_N)
    assert first_order / WIDTH == pytest.approx(0.9, abs=0.02)


def test_error_bars_of_the_station_are_those_of_the_plane_problem(model: StationModel) -> None:
    (edge, _) = model.plane.contacts[0].stations
    k_n, spread = edge.last_k_n
    assert 0.03 < spread / k_n < 0.04
    assert 0.04 < edge.k_range_spread / edge.k_t_range < 0.05
    assert edge.k_range_parts.total == edge.k_range_spread
    for zone in edge.slip_zones[-2:]:
        assert 0.05 < zone.spread / zone.length < 0.06
    # A cylinder as wide: R ~ 1/K_N, P ~ a²/R.
    assert model.radius_spread == pytest.approx(0.03 * model.radius)
    assert model.normal_force_spread == pytest.approx(0.03 * model.normal_force)


def test_a_range_without_an_error_bar_is_told(solid: Result) -> None:
    last = len(solid.loads.times) - 1
    zone = SlipZone(last - 4, last, 0.2, 0.2, 0.01, True, False, 0.2, 0.2)
    changed_one = changed(solid, k_range_spread=np.nan, slip_zones=(zone,))
    found = run_station(changed_one, "main", 1, 5, None)
    assert found.zones[0].predicted_spread == pytest.approx(0.03 * 0.2)
    assert "its range of (K_T, K_S) has no error bar" in found.plane.notes[-1]
    assert math.isnan(found.plane.contacts[0].stations[0].reported_range)


def test_tractions_next_to_the_edge(model: StationModel) -> None:
    found = model.plane_tractions
    next_to = (found.s > 0.002) & (found.s < 0.03)
    ratio = found.pressure[next_to] / (K_N * np.sqrt(found.s[next_to]))
    assert np.abs(ratio - 1).max() < 0.03
    np.testing.assert_allclose(
        np.abs(found.shear[next_to]), FRICTION * found.pressure[next_to], rtol=1e-6
    )
    solids = model.solid_tractions
    assert len(solids.s) > 10 and np.all(np.diff(solids.s) >= 0)
    inside = solids.s > 0.1
    s = solids.s[inside]
    np.testing.assert_allclose(solids.pressure[inside], PEAK * np.sqrt(s * (2 - s)), rtol=0.03)


def test_normal_load_that_varies_moves_the_edge(solid: Result) -> None:
    """K_I of a cycle moves the edge by 2 ΔK_I/K_N."""
    k_i = solid.contacts[0].fronts[0].stations[0].k_i
    wave = 0.02 * K_N * np.sin(np.linspace(0, 4 * np.pi, len(k_i)))
    model = run_station(changed(solid, k_i=k_i + wave), "main", 1, 5, None)
    assert model.k_i_mismatch < 0.005 and model.k_mismatch < 0.005
    edge = model.plane.contacts[0].stations[0]
    moved = edge.position[-30:] - edge.position[-1]
    expected = -2 * (wave - wave[-1])[-30:] / K_N
    np.testing.assert_allclose(moved, expected, atol=0.1 * np.ptp(expected))


def test_what_is_refused(solid: Result, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="within a local length of a free end"):
        run_station(changed(solid, end=True), "main", 1, 0, None)
    unknown = np.full(len(solid.loads.times), np.nan)
    with pytest.raises(ModelError, match="expected a known K_N, found none"):
        run_station(changed(solid, k_n=unknown), "main", 1, 0, None)
    with pytest.raises(ModelError, match="found K_T, K_S or K_I unknown"):
        run_station(changed(solid, k_t=unknown), "main", 1, 0, None)
    zero = np.zeros(len(unknown))
    with pytest.raises(ModelError, match="expected friction, and K_T or K_S that vary"):
        run_station(changed(solid, k_t=zero, k_s=zero), "main", 1, 0, None)
    with pytest.raises(ModelError, match=r"(?s)station 0 of front 1.*the contact slides"):
        run_station(changed(solid, depth=0.1), "main", 1, 0, None)
    with pytest.raises(CaseError, match="expected one of the contacts main, found 'none'"):
        run_station(solid, "none", 1, 0, None)
    with pytest.raises(CaseError, match="expected a front from 1 to 1, found 2"):
        run_station(solid, "main", 2, 0, None)
    with pytest.raises(CaseError, match="expected a station from 0 to 11, found 12"):
        run_station(solid, "main", 1, 12, None)
    failed = replace(solid, failure=ConvergenceError("step 9 did not converge"))
    with pytest.raises(OutputError, match="complete results, found: step 9"):
        run_station(failed, "main", 1, 0, None)
    with pytest.raises(CaseError, match="expected another folder"):
        run_station(replace(solid, directory=tmp_path), "main", 1, 0, tmp_path)


def test_command(solid: Result, tmp_path: Path) -> None:
    folder, output = tmp_path / "solid", tmp_path / "plane"
    folder.mkdir()
    write_results(folder, solid)
    done = CliRunner().invoke(
        app, ["station", str(folder), "main:1", "--station", "5", "-o", str(output)]
    )
    assert done.exit_code == 0, done.exception
    assert "in the plane" in done.output and f"Results in {output}" in done.output.replace("\n", "")
    assert re.search(r"Station: K_N \S+ ± \S+, ΔK \S+ ± \S+", done.output)
    (edge, _) = load_result(output).contacts[0].stations
    assert edge.last_k_n[1] > 0.03 * edge.last_k_n[0]
    numbers = json.loads((output / "station.json").read_text("utf-8"))
    assert numbers["station"] == 5 and numbers["half_width"] == pytest.approx(0.5)
    names = {path.name for path in output.iterdir()}
    assert {"station.png", "results.json", "results.h5", "case.toml", "report.html"} <= names
