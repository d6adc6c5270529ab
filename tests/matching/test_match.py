# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tests matched to an edge: closed forms back and forth, bounds, refusals, and overlays."""

from __future__ import annotations

import copy
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from cases.pad_cases import PAD, wave
from cases.solid_runs import (
    FRICTION,
    K_N,
    LIMIT,
    PEAK,
    SHEAR,
    exact_station,
    stationed_sphere,
    with_stations,
)
from reference.closed_forms import closed_contact
from scipy.integrate import quad
from scipy.optimize import brentq
from typer.testing import CliRunner

import fretfe
from fretfe.analytic.edges import factor_range_phase_shifted
from fretfe.analytic.profiles import (
    FlatRounded,
    Hertz,
    Profile,
    Wedge,
    composite_modulus,
    edge_factor_k_n,
)
from fretfe.case import changed, parse_case
from fretfe.cli.app import app
from fretfe.errors import CaseError, FretfeError, ModelError
from fretfe.evaluate.contacts import Station
from fretfe.matching.agreement import compare_edges
from fretfe.matching.casefile import case_tables
from fretfe.matching.files import match_numbers, write_match
from fretfe.matching.match import Match, compare_tests, corrected, match_test
from fretfe.matching.pads import Factors, PadTest, closed_form, pad_test
from fretfe.matching.rig import parse_rig
from fretfe.matching.spreads import numbers_of
from fretfe.matching.target import read_target
from fretfe.reason import Kind
from fretfe.results.model import Result

E_STAR = composite_modulus(210e3, 0.3, 210e3, 0.3)
PROFILES: list[Profile] = [Hertz(50.0, E_STAR), FlatRounded(1.0, 30.0, E_STAR), Wedge(0.02, E_STAR)]
RIG: dict[str, Any] = {
    "pad": {
        "shapes": ["cylinder"], "young": 210e3, "poisson": 0.3, "radius": [50.0, 50.0],
        "half_width": 12.0, "height": 12.0,
    },
    "specimen": {"young": 210e3, "poisson": 0.3, "thickness": 12.0, "half_width": 12.0},
    "forces": {"normal": [100.0, 5000.0], "shear": [0.0, 500.0]},
}  # fmt: skip


def rig(**tables: dict[str, Any]) -> Any:
    data = copy.deepcopy(RIG)
    for name, values in tables.items():
        data[name] |= values
    return parse_rig(data)


def case(amplitude: float = 60.0) -> Any:
    tables = copy.deepcopy(PAD)
    tables["loads"]["shear"]["history"] = [{"hold": True, "until": 1}, wave(amplitude)]
    return parse_case(tables)


@pytest.fixture(scope="module")
def exact() -> Result:
    """Half-planes, with a contact by closed forms in place of theirs."""
    result = fretfe.run(case(), backend="halfplane")
    return replace(result, contacts=(closed_contact(result.case),))


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Result:
    folder = tmp_path_factory.mktemp("match") / "pad"
    fretfe.run(case(), backend="halfplane", output=folder)
    return fretfe.load_result(folder)


def radius(test: PadTest) -> float:
    assert isinstance(test.profile, Hertz)
    return test.profile.radius


def only(match: Match) -> PadTest:
    (shape,) = match.shapes
    assert shape.infeasible == ()
    return shape.choices[shape.best].test


@pytest.mark.parametrize("profile", PROFILES, ids=["hertz", "flat", "wedge"])
@pytest.mark.parametrize(("k_i_range", "bulk"), [(0.0, 0.0), (0.0, 20.0), (25.0, 0.0)])
def test_loads_and_factors_are_inverse(profile: Profile, k_i_range: float, bulk: float) -> None:
    half_width = 0.6 if not profile.kinks else profile.kinks[-1] + 0.5
    k_n = float(edge_factor_k_n(profile, half_width))
    factors = Factors(k_n, 40.0, k_i_range, -1, 0.4, bulk, 0.7)
    test = pad_test(profile, factors)
    assert test.half_width == pytest.approx(half_width, rel=1e-10)
    assert test.normal_force == pytest.approx(float(profile.load(half_width)), rel=1e-10)
    found = closed_form(test)
    assert [found.k_n, found.k_t_range, found.k_i_range] == pytest.approx(
        [k_n, 40.0, k_i_range], rel=1e-9
    )


@pytest.mark.parametrize("profile", PROFILES, ids=["hertz", "flat", "wedge"])
def test_k_i_adds_up_over_the_load(profile: Profile) -> None:
    # dK_I = dP/(pi sqrt(2a)), adaptive quadrature over the load.
    k_n = float(edge_factor_k_n(profile, 1.5))
    test = pad_test(profile, Factors(k_n, 40.0, 60.0, 1, 0.4))
    ends = test.normal_force + test.normal_amplitude * np.array([-1, 1])
    k_i, _ = quad(lambda p: 1 / (math.pi * math.sqrt(2 * float(profile.half_width(p)))), *ends)
    assert k_i == pytest.approx(60.0, rel=1e-8)
    assert test.shear_amplitude == pytest.approx(test.normal_amplitude * 40 / 60, rel=1e-12)


def test_k_i_beyond_lift_off_needs_a_larger_amplitude_than_the_load() -> None:
    test = pad_test(PROFILES[0], Factors(1200.0, 40.0, 1e4, 1, 0.4))
    assert test.normal_amplitude > test.normal_force
    assert test.shear_ratio == math.inf


@pytest.mark.parametrize("backend", ["closed form", "halfplane"])
def test_a_hertz_contact_is_matched_by_itself(exact: Result, solved: Result, backend: str) -> None:
    # The radius is given: K_N gives P and the range of K_T gives Q. Fits to the tractions of
    # half-planes find K_N to 6e-6, of which P has four times as much.
    result, tolerance = (exact, 1e-9) if backend == "closed form" else (solved, 4e-5)
    test = only(match_test(result, "main.left", rig()))
    assert test.normal_force == pytest.approx(600.0, rel=tolerance)
    assert test.shear_amplitude == pytest.approx(60.0, rel=tolerance)


def test_a_given_load_leads_to_the_radius(exact: Result) -> None:
    given = rig(pad={"radius": [10.0, 200.0]}, forces={"normal": [600.0, 600.0]})
    test = only(match_test(exact, "main.left", given))
    assert radius(test) == pytest.approx(50.0, rel=1e-6)
    assert test.shear_amplitude == pytest.approx(60.0, rel=1e-6)


def test_bounds_that_bind_are_named(exact: Result) -> None:
    given = rig(pad={"radius": [5.0, 200.0]}, forces={"normal": [300.0, 2000.0], "shear": [0, 80]})
    (shape,) = match_test(exact, "main.left", given).shapes
    first, last = shape.choices[0], shape.choices[-1]
    assert first.binding == ("smallest normal force",)
    assert first.test.normal_force == pytest.approx(300.0)
    assert last.binding == ("amplitude of the shear force",)
    assert last.test.shear_amplitude == pytest.approx(80.0)
    # P ~ R^3 and Q ~ R at given factors.
    assert radius(first.test) == pytest.approx(50 * 0.5 ** (1 / 3), rel=1e-9)
    assert radius(last.test) == pytest.approx(50 * 80 / 60, rel=1e-9)


@pytest.mark.parametrize(
    ("tables", "text"),
    [
        ({"forces": {"normal": [10.0, 100.0]}}, "largest normal force: the rig allows at most 100"),
        (
            {"forces": {"shear": [0.0, 20.0]}},
            "amplitude of the shear force: the rig allows at most",
        ),
        ({"specimen": {"yield_stress": 100.0}}, "largest pressure, by the yield stress"),
        (
            {"specimen": {"thickness": 1e-6}},
            "for the height of the pad and the thickness: the rig allows at most 5e-07",
        ),
        (
            {"pad": {"radius": [10.0, 200.0]}, "forces": {"normal": [900, 2000], "shear": [0, 60]}},
            "smallest normal force and amplitude of the shear force exclude each other",
        ),
    ],
)
def test_infeasible_bounds_are_named(
    exact: Result, tables: dict[str, dict[str, Any]], text: str
) -> None:
    (shape,) = match_test(exact, "main.left", rig(**tables)).shapes
    assert shape.choices == ()
    assert any(text in reason for reason in shape.infeasible), shape.infeasible


def test_the_yield_stress_is_no_bound_for_a_wedge(exact: Result) -> None:
    pad = {"shapes": ["cylinder", "wedge"], "angle": [0.2, 5.0]}
    found = match_test(exact, "main.left", rig(pad=pad, specimen={"yield_stress": 1e-3}))
    cylinder, wedge = found.shapes
    assert "largest pressure, by the yield stress" in cylinder.infeasible[0]
    assert wedge.infeasible == ()
    assert wedge.choices
    assert any("no bound for wedges" in text for text in found.notes)


def test_error_bars_reach_the_loads(exact: Result) -> None:
    (shape,) = match_test(exact, "main.left", rig()).shapes
    (choice,) = shape.choices
    target = read_target(exact, "main.left")
    relative = target.k_n_spread / target.k_n
    # At a given radius a ~ K_N^2, P ~ a^2 and Q ~ sqrt(a).
    ranges = target.k_t_range_spread / target.k_t_range
    powers = {"normal_force": (4, 0), "half_width": (2, 0), "peak_pressure": (2, 0),
              "shear_amplitude": (1, 1), "shear_ratio": (3, 1), "slip_long": (1, 1),
              "slip_over_length": (3, 1), "over_thickness": (2, 0), "over_pad": (2, 0)}  # fmt: skip
    numbers = numbers_of(choice.test, rig())
    for name, (of_k_n, of_range) in powers.items():
        expected = math.hypot(of_k_n * relative, of_range * ranges) * numbers[name]
        assert choice.spreads[name] == pytest.approx(expected, rel=0.05), name


def test_the_bars_of_a_corrected_test_are_those_of_both_edges(solved: Result) -> None:
    match = match_test(solved, "main.left", rig())
    comparison = compare_tests(match, [("itself", solved)])
    numbers = match_numbers(match, comparison)
    (choice,) = numbers["shapes"][0]["choices"]
    found = numbers["tests"][0]["corrected"]
    ratio = found["normal_force_spread"] / choice["normal_force_spread"]
    assert ratio == pytest.approx(math.sqrt(2), rel=0.05)


def test_a_bulk_stress_takes_its_part_of_the_range(exact: Result) -> None:
    given = rig(forces={"bulk_range": 60.0, "bulk_phase": 50.0})
    test = only(match_test(exact, "main.left", given))
    found = factor_range_phase_shifted(
        test.shear_amplitude, 30.0, math.radians(50.0), test.half_width, "left"
    )
    assert float(found) == pytest.approx(exact.contacts[0].stations[0].k_t_range, rel=1e-9)


def test_a_bulk_stress_bounds_the_width(exact: Result) -> None:
    # B = (range/8) sqrt(a/2) alone has the range of K_T at some a: no pad is wider.
    forces = {"bulk_range": 100.0, "normal": [10.0, 5e4]}
    given = rig(pad={"radius": [20.0, 200.0]}, forces=forces)
    (shape,) = match_test(exact, "main.left", given).shapes
    k_t_range = exact.contacts[0].stations[0].k_t_range
    widest = 2 * (k_t_range / 2 / (100 / 8)) ** 2
    assert shape.choices[-1].test.half_width == pytest.approx(widest, rel=1e-6)
    assert shape.choices[0].binding == ("Q/(f P), which is sliding at 1",)
    (shape,) = match_test(exact, "main.left", rig(forces={"bulk_range": 900.0})).shapes
    assert any("no value gives the range of K_T" in text for text in shape.infeasible)


def test_the_case_of_a_bulk_stress_has_the_factors(exact: Result) -> None:
    given = rig(forces={"bulk_range": 60.0, "bulk_phase": 50.0})
    match = match_test(exact, "main.left", given)
    tables = case_tables(only(match), given, "test")
    # Half-planes feel no arm of Q, and know no load that takes it back.
    del tables["loads"]["level"], tables["edges"]
    (left, _) = closed_contact(parse_case(tables)).stations
    assert left.k_n[-1] == pytest.approx(match.target.k_n, rel=1e-9)
    # 40 states in a cycle miss its extremes by (pi/40)^2/2 at most.
    assert left.k_t_range == pytest.approx(match.target.k_t_range, rel=4e-3)


@pytest.mark.parametrize("phase", [0.0, 60.0])
@pytest.mark.parametrize("shape", ["cylinder", "flat_rounded"])
def test_the_slip_zone_to_expect_with_a_bulk_stress(
    exact: Result, shape: str, phase: float
) -> None:
    # About a quarter to a half of the range of K_T comes from the bulk stress.
    pad = {"shapes": [shape], "radius": [40.0, 60.0], "flat_half_width": [0.3, 0.3]}
    given = rig(pad=pad, forces={"bulk_range": 100.0, "bulk_phase": phase})
    (found,) = match_test(exact, "main.left", given).shapes
    test = found.choices[found.best].test
    assert 0.2 < test.tension_share < 0.6
    tables = case_tables(test, given, "test")
    del tables["loads"]["level"], tables["edges"]
    tables["contacts"]["pad"]["friction_from"] = 1.0
    (left, _) = fretfe.run(parse_case(tables), backend="halfplane").contacts[0].stations
    # The longer of the last two: 40 states in a cycle miss the extremes by 3e-3 of their range.
    zone = max(left.slip_zones[-2:], key=lambda each: each.length)
    length = test.slip[0] / (1 + test.asymptote_error)
    assert zone.length == pytest.approx(length, rel=0.01)
    assert abs(zone.length / test.slip[0] - 1) > 0.005


def with_station(result: Result, **values: Any) -> Result:
    (contact,) = result.contacts
    fronts = tuple(
        replace(front, stations=(replace(front.stations[0], **values),)) for front in contact.fronts
    )
    return replace(result, contacts=(replace(contact, fronts=fronts),))


def test_what_is_not_known_is_not_matched(exact: Result) -> None:
    (left, _) = exact.contacts[0].stations
    gross = tuple(replace(zone, gross=True) for zone in left.slip_zones)
    for values, text in (
        ({"k_n": np.full_like(left.k_n, np.nan)}, "expected K_N to be known"),
        ({"k_n_spread": left.k_n}, "error bar of less than half"),
        ({"k_t_range": math.nan, "k_range": math.nan}, "expected the range of K_T to be known"),
        ({"k_range_spread": math.nan}, "found no error bar"),
        ({"slip_zones": gross}, "the whole contact slips"),
        ({"oscillation": 0.02}, r"found unlike ones, epsilon = 0.02: shear alone makes K_I vary"),
    ):
        with pytest.raises(ModelError, match=text):
            read_target(with_station(exact, **values), "main.left")
    with pytest.raises(CaseError, match=r"one of the edges main.left, main.right, found 'mai'"):
        read_target(exact, "mai")
    assert read_target(exact, "main").name == "main.left"


def test_other_friction_or_units_are_refused(exact: Result) -> None:
    with pytest.raises(ModelError, match=r"friction: expected 0.4 as in the component, found 0.5"):
        match_test(exact, "main.left", parse_rig(RIG | {"friction": 0.5}))
    with pytest.raises(CaseError, match=r"units.length: expected 'mm' as in the component"):
        match_test(exact, "main.left", parse_rig(RIG | {"units": {"length": "m"}}))


@pytest.mark.parametrize(
    ("tables", "values", "text"),
    [
        ({"units": {"length": "m"}}, {}, "test: units.length: expected 'mm' as in the component"),
        ({}, {"friction": 0.3}, "test: friction: expected 0.4 as in the component, found 0.3"),
    ],
    ids=["units", "friction"],
)
def test_tests_of_other_friction_or_units_are_refused(
    solved: Result, tables: dict[str, Any], values: dict[str, float], text: str
) -> None:
    other = parse_case({**case().model_dump(exclude_unset=True), **tables})
    test = replace(with_station(solved, **values), case=other)
    with pytest.raises(FretfeError, match=text):
        compare_tests(match_test(solved, "main.left", rig()), [("test", test)])


def test_a_flat_beyond_numbers_is_no_test(exact: Result) -> None:
    """The contact would end a micrometre beyond a flat of 10^30."""
    flat = {"shapes": ["flat_rounded"], "radius": [50.0, 50.0], "flat_half_width": [1e30, 1e30]}
    (shape,) = match_test(exact, "main.left", rig(pad=flat)).shapes
    (reason,) = shape.infeasible
    assert not shape.choices and "too little beside 1e+30 for numbers to tell" in reason


@pytest.mark.parametrize(
    ("table", "key", "value", "text"),
    [
        ("pad", "radius", [50.0, 10.0], "pad.radius: expected the smaller bound first"),
        ("pad", "radius", None, "pad: expected 'radius' for the shape 'cylinder', found none"),
        ("pad", "radios", [1.0, 2.0], "pad.radios: unknown key; did you mean 'radius'?"),
        ("pad", "angle", [1.0, 100.0], "pad.angle[item 2]: expected a number <= 20, found 100"),
        ("pad", "shapes", ["ball"], "pad.shapes[item 1]: expected"),
        ("forces", "normal", [0.0, 1.0], "forces.normal[item 1]: expected a number > 0"),
        ("specimen", "thickness", "thick", "specimen.thickness: expected a number"),
    ],
)  # fmt: skip
def test_mistakes_in_a_rig_are_told(table: str, key: str, value: Any, text: str) -> None:
    data = copy.deepcopy(RIG)
    data[table][key] = value
    if value is None:
        del data[table][key]
    with pytest.raises(CaseError) as error:
        parse_rig(data)
    assert text in str(error.value)


def test_a_result_agrees_with_itself(solved: Result) -> None:
    target = read_target(solved, "main.left")
    found = compare_edges(target, solved, "itself")
    assert [each.whole for each in found.pressure_reach + found.shear_reach] == [True] * 4
    assert found.remark == ""


def test_how_far_two_cylinders_agree(solved: Result) -> None:
    # p = K_N sqrt(s (1 - s/(2a))): the ratio of both is 1.05 at one s only.
    match = match_test(solved, "main.left", rig(pad={"radius": [40.0, 40.0]}))
    tables = {"geometry.parameters.upper_radius": 40.0}
    test = only(match)
    loads = {
        "loads.press.history": [{"ramp": -test.normal_force, "until": 1, "steps": 4}],
        "loads.shear.history": [{"hold": True, "until": 1}, wave(test.shear_amplitude)],
    }
    other = fretfe.run(changed(case(), tables | loads), backend="halfplane")
    found = compare_edges(match.target, other, "narrow")
    wide, narrow = match.target.half_width, test.half_width

    def excess(s: float) -> float:
        return 1 - math.sqrt((1 - s / (2 * narrow)) / (1 - s / (2 * wide))) - 0.05

    expected = brentq(excess, 1e-3, narrow)
    # An element is 0.01 a.
    assert found.pressure_reach[0].length == pytest.approx(expected, abs=0.01 * wide)
    assert "falls from" in found.remark
    # Nothing is to be corrected between half-planes.
    again = corrected(match.factors, found.test, other)
    assert again.normal_force == pytest.approx(test.normal_force, rel=1e-4)
    assert again.shear_amplitude == pytest.approx(test.shear_amplitude, rel=1e-3)


@pytest.mark.pictures
def test_the_command_writes_cases_and_numbers(solved: Result, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(tomli_w.dumps(RIG))
    words = ["match", str(solved.directory), "--edge", "main.left", "--rig",
             str(tmp_path / "rig.toml"), "-o", str(tmp_path / "tests")]  # fmt: skip
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    assert fretfe.load_case(tmp_path / "tests" / "cylinder.toml").title.endswith("cylinder")
    numbers = json.loads((tmp_path / "tests" / "match.json").read_text())
    assert numbers["schema"] == {"name": "fretfe-match", "version": 2}
    (choice,) = numbers["shapes"][0]["choices"]
    assert choice["normal_force"] == pytest.approx(600.0, rel=4e-5)
    done = CliRunner().invoke(app, [*words, "--against", str(solved.directory)])
    assert done.exit_code == 0, done.output
    numbers = json.loads((tmp_path / "tests" / "match.json").read_text())
    assert numbers["tests"][0]["pressure"][0]["whole"]
    assert (tmp_path / "tests" / "match.png").stat().st_size > 10_000
    own = tmp_path / "tests" / "cylinder.toml"
    own.write_text("title = 'mine'")
    done = CliRunner().invoke(app, words)
    assert isinstance(done.exception, CaseError)
    assert "cylinder.toml: expected a folder in which no test" in str(done.exception)
    assert own.read_text() == "title = 'mine'"


def test_a_rig_that_can_do_nothing_is_an_error(solved: Result, tmp_path: Path) -> None:
    data = RIG | {"forces": {"normal": [10.0, 20.0], "shear": [0.0, 1.0]}}
    (tmp_path / "rig.toml").write_text(tomli_w.dumps(data))
    words = ["match", str(solved.directory), "--edge", "main.left", "--rig",
             str(tmp_path / "rig.toml"), "-o", str(tmp_path / "tests")]  # fmt: skip
    done = CliRunner().invoke(app, words)
    assert isinstance(done.exception, FretfeError)
    assert "largest normal force: the rig allows at most 20" in str(done.exception)
    assert not (tmp_path / "tests").exists()


@pytest.fixture(scope="module")
def sphere() -> Result:
    """Twelve stations around a sphere under Q along x, with exact factors; a = 1."""
    result = stationed_sphere()
    shear = result.loads.values[:, 1]
    load = SHEAR * shear / np.abs(shear).max()

    def exact(station: Station) -> Station:
        inward, along = station.frame.inward[0], station.frame.along[0]
        sign = 1.0 if inward > 0 else -1.0
        angle = math.degrees(math.atan2(sign * along, sign * inward))
        return exact_station(station, sign * load, angle)

    return with_stations(result, exact)


def at_station(result: Result, number: int, **values: Any) -> Result:
    def change(station: Station) -> Station:
        return replace(station, **values) if station.number == number else station

    return with_stations(result, change)


def test_a_station_of_solids_is_read(sphere: Result) -> None:
    target = read_target(sphere, "main.1.1")
    station = sphere.contacts[0].stations[1]
    assert target.name == "main.1.1"
    assert [target.k_n, target.k_t_range] == pytest.approx([K_N, 2 * SHEAR * LIMIT])
    assert [target.half_width, target.stiffening] == [1.0, 2.0]
    assert target.k_angle == station.k_angle and abs(target.k_angle) == pytest.approx(50, abs=1)
    (direction,) = (each for each in target.warnings if each.kind is Kind.TARGET_DIRECTION)
    assert f"varies most, {station.k_angle:.0f}° from inward" in direction.text
    assert Kind.TARGET_TURNS not in {each.kind for each in target.warnings}
    turned = read_target(at_station(sphere, 1, turning=0.3), "main.1.1")
    assert any("range across that direction is 30%" in each.text for each in turned.warnings)


def test_a_station_near_a_free_end_is_read_as_far_as_its_factors_mean_something(
    sphere: Result,
) -> None:
    """Three slip zones from the end and farther, with a remark on what a test cannot show."""
    station = sphere.contacts[0].stations[1]
    slip = station.k_range / (station.friction * K_N)
    near = at_station(sphere, 1, end=True, to_end=3.1 * slip)
    (remark,) = (
        each for each in read_target(near, "main.1.1").warnings if each.kind is Kind.TARGET_AT_END
    )
    assert "at this station and its neighbours: a plane test has the same" in remark.text
    nearer = at_station(sphere, 1, end=True, to_end=2.9 * slip)
    with pytest.raises(ModelError, match="so near to a free end that they are unknown or mean"):
        read_target(nearer, "main.1.1")
    assert not any(
        each.kind is Kind.TARGET_AT_END for each in read_target(sphere, "main.1.1").warnings
    )


@pytest.mark.parametrize("number", range(12))
def test_tractions_next_to_a_station(sphere: Result, number: int) -> None:
    """Hertz, and twice Cattaneo and Mindlin for half of the change of Q, in means over rows."""
    profile = read_target(sphere, f"main.1.{number}").profile
    assert profile is not None
    radius = 1 - profile.s
    hertz = PEAK * np.sqrt(1 - radius**2)
    inner = PEAK * np.sqrt(np.clip((1 - SHEAR) ** (2 / 3) - radius**2, 0, None))
    change = 2 * FRICTION * (hertz - inner)
    # Rows are an element of about 1/12 wide; pressures bend in the first of them.
    np.testing.assert_allclose(profile.pressure, hertz, rtol=0.02)
    np.testing.assert_allclose(profile.limit, 2 * FRICTION * profile.pressure)
    np.testing.assert_allclose(profile.shear_change, change, atol=0.04 * change.max())


def test_a_contact_or_front_stands_for_its_worst_station(sphere: Result) -> None:
    (front,) = sphere.contacts[0].fronts
    size = front.stations[0].k_range
    worse = at_station(sphere, 7, k_range=1.1 * size)
    assert read_target(worse, "main").name == read_target(worse, "main.1").name == "main.1.7"
    # Not by the range alone, and not near an end.
    stiffer = at_station(worse, 7, k_n=1.2 * front.stations[7].k_n)
    assert read_target(stiffer, "main.1").name == "main.1.0"
    assert read_target(at_station(worse, 7, end=True, to_end=0.0), "main").name == "main.1.0"
    unknown = with_stations(sphere, lambda each: replace(each, k_range_spread=math.nan))
    with pytest.raises(ModelError, match="edge main: expected K_N and the range of K_T to be"):
        read_target(unknown, "main")


def test_stations_that_are_not_matched(sphere: Result, solved: Result) -> None:
    for values, text in (
        ({"end": True, "to_end": 0.0}, "a station .* found one so near to a free end"),
        (
            {"k_n": np.full(len(sphere.loads.times), np.nan)},
            "K_N to be known, found that it is not",
        ),
        ({"k_range_spread": math.nan}, "the range of K_T .* found no error bar"),
        ({"k_range_spread": 100.0}, "less than half of it, found 33.94 ± 1e\\+02"),
    ):
        with pytest.raises(ModelError, match=f"edge main.1.5: expected .*{text}"):
            read_target(at_station(sphere, 5, **values), "main.1.5")
    for name in ("main.2", "main.1.12", "main.left"):
        with pytest.raises(
            CaseError, match=f"one of the edges main.1.0 to main.1.11, found '{name}'"
        ):
            read_target(sphere, name)
    with pytest.raises(CaseError, match="test: expected a test of plane bodies, found solids"):
        compare_tests(match_test(solved, "main.left", rig()), [("test", sphere)])


def test_how_far_a_cylinder_agrees_with_a_sphere(sphere: Result, tmp_path: Path) -> None:
    """The same p = K_N sqrt(s (1 - s/2)) where both are as wide; slip is 1 - (1 - Q/(f P))^n."""
    size = E_STAR * math.sqrt(2) / (2 * K_N)
    match = match_test(sphere, "main.1.5", rig(pad={"radius": [size, size]}))
    test = only(match)
    assert test.half_width == pytest.approx(1.0)
    # ΔK = 2 Q/(π sqrt(2 a)): two thirds of Q/(f P) of the sphere.
    assert test.shear_ratio == pytest.approx(2 * SHEAR / 3)
    tables = {
        "geometry.parameters.upper_radius": size,
        "loads.press.history": [{"ramp": -test.normal_force, "until": 1, "steps": 4}],
        "loads.shear.history": [{"hold": True, "until": 1}, wave(test.shear_amplitude)],
    }
    solved = fretfe.run(changed(case(), tables), backend="halfplane")
    comparison = compare_tests(match, [("cylinder", solved)])
    (found,) = comparison.agreements
    assert found.test.k_t_range == pytest.approx(match.target.k_t_range, rel=1e-3)
    assert [each.whole for each in found.pressure_reach] == [True, True]
    # Behind its slip zone q falls like a root, within a row of an element of 1/12.
    slip = 1 - math.sqrt(1 - 2 * SHEAR / 3)
    assert found.shear_reach[0].length == pytest.approx(slip, abs=1 / 12)
    write_match(match, comparison, tmp_path)
    numbers = json.loads((tmp_path / "match.json").read_text())
    assert numbers["component"]["edge"] == "main.1.5"
    assert numbers["component"]["k_angle"] == pytest.approx(match.target.k_angle)
    assert (tmp_path / "match.png").stat().st_size > 10_000
