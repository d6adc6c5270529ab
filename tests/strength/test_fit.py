# SPDX-License-Identifier: LGPL-3.0-or-later
"""Strength of tests and margins of edges. All tests here are made up, with known coefficients."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.solid_runs import solid_result, surface, write_solid
from cases.stored_runs import solved, write_run
from harness.launch import fretfe as command
from matplotlib import pyplot as plt
from matplotlib.container import ErrorbarContainer
from scipy import stats

import fretfe
from fretfe._typing import Array, Bools
from fretfe.api import StrengthMap
from fretfe.case import Units
from fretfe.case.units import same_unit
from fretfe.caution import Caution, Subject
from fretfe.errors import CaseError, ConvergenceError
from fretfe.evaluate.space.evaluate import evaluate_fronts
from fretfe.evaluate.space.fronts import follow_fronts
from fretfe.reason import Kind
from fretfe.strength.fit import LifeFit, fit_life
from fretfe.strength.lives import read_tests
from fretfe.strength.margins import _counted, component_edges, survival_text

HEADER = "k_n [MPa/mm^0.5],dk_t [MPa*mm^0.5],life,runout,friction,young [MPa],poisson"
# log10 N = 11.8 - 4 log10 ΔK_T - 0.3 log10 (K_N/1000), and its scatter.
TRUE, SCATTER = np.array([11.8 + 0.9, -4.0, -0.3]), 0.12
END = 1e6
LIFE = 4e5


def made_up(
    seed: int = 7, count: int = 24, end: float = END, k_n: tuple[float, float] = (900.0, 1600.0)
) -> tuple[Array, Array, Array, Bools]:
    """K_N, ΔK_T, life and run-out of tests that end after some cycles."""
    random = np.random.default_rng(seed)
    factors = np.exp(random.uniform(math.log(k_n[0]), math.log(k_n[1]), count))
    ranges = 10 ** random.uniform(1.45, 1.8, count)
    logs = np.column_stack([np.ones(count), np.log10(ranges), np.log10(factors)])
    life = 10 ** (logs @ TRUE + SCATTER * random.standard_normal(count))
    return factors, ranges, np.minimum(life, end), life > end


def fitted(*arrays: Any) -> LifeFit:
    found = fit_life(*arrays)
    assert isinstance(found, LifeFit), found
    return found


def write_tests(path: Path, *arrays: Any, friction: float = 0.4, young: float = 210e3) -> Path:
    rows = [
        f"{a:.8g},{b:.8g},{life:.8g},{int(ended)},{friction},{young},0.3"
        for a, b, life, ended in zip(*arrays, strict=True)
    ]
    path.write_text("\n".join([HEADER, *rows]), "utf-8")
    return path


@pytest.fixture
def tests(tmp_path: Path) -> Path:
    return write_tests(tmp_path / "tests.csv", *made_up())


def test_without_run_outs_the_fit_is_that_of_least_squares() -> None:
    k_n, ranges, life, runout = made_up(end=math.inf)
    found = fitted(k_n, ranges, life, runout)
    design = np.column_stack([np.ones(len(life)), np.log10(ranges), np.log10(k_n)])
    expected, residual, *_ = np.linalg.lstsq(design, np.log10(life), rcond=None)
    assert found.coefficients == pytest.approx(expected, rel=1e-5)
    variance = residual[0] / (len(life) - 3)
    assert found.scatter**2 == pytest.approx(variance, rel=1e-5)
    covariance = variance * np.linalg.inv(design.T @ design)
    assert found.covariance == pytest.approx(covariance, rel=1e-3)


def expectation_maximisation(
    design: Array, log: Array, runout: Bools, passes: int = 1000
) -> tuple[Array, float]:
    """The same maximum by another way: run-outs are given their expected lives, again and again."""
    estimate, scatter = np.linalg.lstsq(design, log, rcond=None)[0], 0.3
    for _ in range(passes):
        mean = design @ estimate
        z = (log - mean) / scatter
        hazard = stats.norm.pdf(z) / stats.norm.sf(z)
        expected = np.where(runout, mean + scatter * hazard, log)
        square = np.where(runout, scatter**2 * (1 + z * hazard - hazard**2), 0.0)
        estimate = np.linalg.lstsq(design, expected, rcond=None)[0]
        scatter = float(np.sqrt(((expected - design @ estimate) ** 2 + square).mean()))
    return estimate, scatter


def test_run_outs_are_censored() -> None:
    k_n, ranges, life, runout = made_up(end=2e5)
    assert runout.sum() > 5
    found = fitted(k_n, ranges, life, runout)
    design = np.column_stack([np.ones(len(life)), np.log10(ranges), np.log10(k_n)])
    estimate, scatter = expectation_maximisation(design, np.log10(life), runout)
    assert found.coefficients == pytest.approx(estimate, rel=1e-4)
    # Of the sample; the fit tells that of specimens.
    likely = found.scatter * math.sqrt(found.freedom / found.failures)
    assert likely == pytest.approx(scatter, rel=1e-4)
    rest = np.log10(life) - design @ found.coefficients
    data = stats.CensoredData(uncensored=rest[~runout], right=rest[runout])
    assert stats.norm.fit(data) == pytest.approx((0.0, likely), abs=1e-3)
    # As if run-outs were failures the line would be flatter.
    wrong = np.linalg.lstsq(design, np.log10(life), rcond=None)[0]
    assert wrong[1] > found.coefficients[1] + 0.3


@pytest.mark.slow
def test_intervals_hold_what_they_promise() -> None:
    """Of 200 samples with run-outs; the standard deviation of the count is 1.5 %."""
    random = np.random.default_rng(3)
    of_fit = of_part = 0
    expected = (math.log10(LIFE) - TRUE[0] - TRUE[2] * 3.1) / TRUE[1]
    for seed in range(200):
        found = fitted(*made_up(seed=seed, end=5e5))
        error = math.log10(float(found.strength(10**3.1, LIFE))) - expected
        fit, scatter = found.variances(10**3.1, LIFE)
        of_fit += abs(error) <= found.quantile * math.sqrt(fit)
        part = error - SCATTER / TRUE[1] * random.standard_normal()
        of_part += abs(part) <= found.quantile * math.sqrt(fit + scatter)
    assert 0.91 < of_fit / 200 <= 0.99
    assert 0.91 < of_part / 200 <= 0.99


def test_survival_without_run_outs_is_that_of_noncentral_t() -> None:
    """Its interval, and the next specimen's probability by Student (Owen 1968; Hahn 1970)."""
    k_n, ranges, life, runout = made_up(count=12, end=math.inf)
    fit = fitted(k_n, ranges, life, runout)
    design = np.column_stack([np.ones(12), np.log10(ranges), np.log10(k_n)])
    at = np.array([1, math.log10(45), math.log10(1200)])
    share = float(at @ np.linalg.inv(design.T @ design) @ at)
    mean = float(at @ np.linalg.lstsq(design, np.log10(life), rcond=None)[0])
    for cycles in (5e4, 1.2e5, 2e5):
        found = fit.survival(1200.0, 45.0, cycles, 0.0)
        distance = (mean - math.log10(cycles)) / fit.scatter
        for end, chance in ((found.low, 0.975), (found.high, 0.025)):
            place = stats.norm.ppf(end) / math.sqrt(share)
            known = stats.nct.cdf(distance / math.sqrt(share), 9, place)
            assert known == pytest.approx(chance, abs=1e-3)
        part = stats.t.cdf(distance / math.sqrt(1 + share), 9)
        assert found.part == pytest.approx(part, abs=1e-4)
        wide = fit.survival(1200.0, 45.0, cycles, 0.2)
        assert wide.low < found.low and wide.high > found.high


@pytest.mark.slow
def test_the_interval_holds_the_share_of_specimens_that_survive() -> None:
    """Of samples of 12 tests with run-outs; the standard deviation of the count is 2 %."""
    at = np.array([1, math.log10(42), math.log10(1200)])
    known = stats.norm.cdf((TRUE @ at - math.log10(1.5e5)) / SCATTER)
    fits = [fit_life(*made_up(seed, 12, 3e5)) for seed in range(150)]
    found = [fit.survival(1200.0, 42.0, 1.5e5, 0.0) for fit in fits if isinstance(fit, LifeFit)]
    assert len(found) > 100 and 0.6 < known < 0.99
    assert 0.91 < np.mean([each.low <= known <= each.high for each in found]) <= 0.99


def test_survival_of_a_pad(tests: Path, tmp_path: Path) -> None:
    """Even odds where the margin is one; the least share beyond the tested ΔK_T, or unknown."""
    margin = fretfe.strength_map(tests, [solved("halfplane")], LIFE).margins[0]
    edge, fit, survival = margin.edge, margin.fit, margin.survival
    assert fit is not None and survival is not None
    assert survival.low < survival.part < survival.high
    even = fit.survival(edge.k_n, margin.strength, LIFE, 0.0)
    assert even.part == pytest.approx(0.5) and even.low < 0.5 < even.high
    assert even.high == pytest.approx(1 - even.low)
    assert (survival.part > 0.5) == (margin.margin > 1)
    k_n, ranges, life, runout = made_up(count=60)
    high = ranges > 37
    path = write_tests(tmp_path / "high.csv", *(each[high] for each in (k_n, ranges, life, runout)))
    beyond = fretfe.strength_map(path, [solved("halfplane")], 1.5e5).margins[0]
    assert beyond.survival is not None and math.isnan(beyond.survival.part)
    assert beyond.margin > 1 and 0 < beyond.survival.low < 0.5


@pytest.mark.parametrize(
    ("lasted", "failed", "short", "milder"),
    [(29, 0, 0, False), (1, 0, 3, False), (18, 2, 0, False), (18, 1, 0, True)],
)
def test_survivors_alone_tell_the_least_share(
    lasted: int, failed: int, short: int, milder: bool, tmp_path: Path
) -> None:
    """Tests at 1.2 ΔK_T of the edge; beside them a milder one, which counts only if it failed."""
    edge = component_edges([solved("halfplane")])[0]
    count = lasted + failed + short
    lives = np.array(
        [LIFE] * lasted + [LIFE / 2] * (failed + short) + [LIFE / 3 if milder else END]
    )
    ended = np.array([True] * lasted + [False] * failed + [True] * short + [not milder])
    ranges = edge.k_t_range * np.array([1.2] * count + [0.9])
    path = write_tests(tmp_path / "few.csv", np.full(count + 1, edge.k_n), ranges, lives, ended)
    failed += milder
    margin = fretfe.strength_map(path, [solved("halfplane")], LIFE).margins[0]
    found = margin.survival
    assert margin.reason and found is not None
    assert (found.lasted, found.tests) == (lasted, lasted + failed)
    # The share with which so few failures or fewer have a probability of 5 %.
    assert stats.binom.cdf(failed, lasted + failed, 1 - found.low) == pytest.approx(0.05)
    if not failed:
        assert found.low == pytest.approx(0.05 ** (1 / lasted))
    words = survival_text(found)
    assert words.startswith("at least ") and f": {lasted} tests at" in words
    assert words.endswith(f"did, {failed} failed")


def test_tests_at_another_k_n_or_a_smaller_range_bound_nothing(tmp_path: Path) -> None:
    edge = component_edges([solved("halfplane")])[0]
    for k_n, k_t in ((0.8, 1.2), (1.2, 1.2), (1.0, 0.9)):
        rows = (np.full(9, k_n * edge.k_n), np.full(9, k_t * edge.k_t_range), np.full(9, LIFE))
        path = write_tests(tmp_path / "milder.csv", *rows, np.full(9, True))
        margin = fretfe.strength_map(path, [solved("halfplane")], LIFE).margins[0]
        assert margin.survival is None


@pytest.mark.parametrize(("share", "count"), [(0.9, 20), (0.97, 40), (0.5, 10)])
def test_the_least_share_holds_as_often_as_it_says(share: float, count: int, tests: Path) -> None:
    """Of all outcomes of tests that last with a share, those told more have at most 5 %."""
    edge, read = component_edges([solved("halfplane")])[0], read_tests(tests, Units())
    told = np.zeros(count + 1)
    for lasted in range(1, count + 1):
        life = np.array([LIFE] * lasted + [LIFE / 2] * (count - lasted))
        own = replace(
            read,
            k_n=np.full(count, edge.k_n),
            k_t_range=np.full(count, 1.1 * edge.k_t_range),
            life=life,
            runout=life >= LIFE,
        )
        found = _counted(own, np.full(count, True), edge, LIFE)
        assert found is not None
        told[lasted] = found.low
    assert stats.binom.pmf(np.flatnonzero(told > share), count, share).sum() <= 0.05


def test_one_k_n_needs_one_coefficient_less() -> None:
    found = fitted(*made_up(k_n=(1230.0, 1235.0)))
    assert found.coefficients[2] == 0
    expected = TRUE[0] + TRUE[2] * math.log10(1232)
    assert found.coefficients[:2] == pytest.approx([expected, TRUE[1]], rel=0.1)


def test_margin_of_a_pad(tests: Path) -> None:
    found = fretfe.strength_map(tests, [solved("halfplane")], LIFE)
    fit = fitted(*made_up())
    left, right = found.margins
    edge = left.edge
    strength = 10 ** (
        (math.log10(LIFE) - fit.coefficients @ [1, 0, math.log10(edge.k_n)]) / fit.coefficients[1]
    )
    assert left.reason == "" and left.tests == 24
    assert left.strength == pytest.approx(strength, rel=1e-6)
    assert left.margin == pytest.approx(strength / edge.k_t_range, rel=1e-6)
    assert right.margin == pytest.approx(left.margin, rel=1e-6)
    shares = (left.fit_share, left.scatter_share, left.edge_share)
    assert math.log10(left.high / left.margin) == pytest.approx(math.hypot(*shares))
    assert left.low * left.high == pytest.approx(left.margin**2)
    # True strength, known here.
    true = 10 ** ((math.log10(LIFE) - TRUE @ [1, 0, math.log10(edge.k_n)]) / TRUE[1])
    assert left.low < true / edge.k_t_range < left.high


def with_edges(change: Callable[[Any], Any]) -> Any:
    """The pad with changed edges."""
    result = solved("halfplane")
    (contact,) = result.contacts
    fronts = tuple(
        replace(each, stations=tuple(map(change, each.stations))) for each in contact.fronts
    )
    return replace(result, contacts=(replace(contact, fronts=fronts),))


def test_error_bars_of_the_edge_are_in_the_margin(tests: Path) -> None:
    wide = with_edges(
        lambda e: replace(e, k_range_spread=0.2 * e.k_t_range, k_n_spread=0.3 * e.k_n)
    )
    one, two = (
        fretfe.strength_map(tests, [each], LIFE).margins[0] for each in (solved("halfplane"), wide)
    )
    assert two.margin == one.margin
    slope = fitted(*made_up()).coefficients
    expected = math.hypot(0.2, 0.3 * slope[2] / slope[1]) / math.log(10)
    assert two.edge_share == pytest.approx(expected, rel=1e-5)
    assert two.low < one.low and two.high > one.high
    # The strength at the K_N of the edge is known as well as K_N and the fit.
    of_k_n = 0.3 * abs(slope[2] / slope[1])
    expected = math.hypot(of_k_n, math.log(10) * two.fit_share) * two.strength
    assert two.strength_spread == pytest.approx(expected, rel=1e-5)


def reason(path: Path, life: float = LIFE, run: str = "halfplane") -> str:
    margins = fretfe.strength_map(path, [solved(run)], life).margins
    assert all(math.isnan(each.margin) and math.isnan(each.low) for each in margins)
    assert len({each.reason for each in margins}) == 1
    return margins[0].reason


@pytest.mark.parametrize(
    ("arrays", "life", "expected"),
    [
        (made_up(), 2e6, "2e6 cycles are outside of the tested lives, "),
        (made_up(), 1e3, "1000 cycles are outside of the tested lives, "),
        (made_up(k_n=(300.0, 1200.0)), LIFE, "K_N = 1238 is outside of the tested K_N, "),
        (made_up(k_n=(1300.0, 1303.0)), LIFE, "K_N = 1238 is outside of the tested K_N, "),
        (made_up(count=6), LIFE, "7 failures are needed for 3 coefficients, found "),
        (made_up(end=3e4), 2.5e4, "7 failures are needed for 3 coefficients, found "),
    ],
)
def test_nothing_is_extrapolated(tmp_path: Path, arrays: Any, life: float, expected: str) -> None:
    assert expected in reason(write_tests(tmp_path / "tests.csv", *arrays), life)


def test_all_reasons_are_told_the_hardest_to_mend_first(tmp_path: Path) -> None:
    """More tests of the same pads give failures, and no other K_N."""
    arrays = made_up(k_n=(300.0, 1200.0), count=6)
    path = write_tests(tmp_path / "tests.csv", *arrays)
    k_n, failures = reason(path).split("; ")
    assert k_n.startswith("K_N = 1238 is outside of the tested K_N, ")
    assert failures.startswith("7 failures are needed for 3 coefficients, found ")
    # of the component, which is changed sooner than the tests
    assert reason(path, run="no cycle").endswith("; there is no evaluated cycle")


def test_a_strength_beyond_the_tested_ranges_is_unknown(tmp_path: Path) -> None:
    k_n, ranges, life, runout = made_up(count=60)
    high = ranges > 37
    path = write_tests(
        tmp_path / "tests.csv", *(each[high] for each in (k_n, ranges, life, runout))
    )
    assert life[high].max() > LIFE / 1.2
    found = reason(path, float(0.99 * life[high & ~runout].max()))
    assert found.startswith("the strength would be below all tested ΔK_T, 37")


def test_tests_in_a_row_say_nothing_beside_it(tmp_path: Path) -> None:
    """K_N and ΔK_T that grow together: the pad has a large K_N at a small ΔK_T."""
    k_n, _, _, runout = made_up(count=30)
    random = np.random.default_rng(1)
    ranges = 38 * (k_n / 1238) ** 3 * np.exp(0.03 * random.standard_normal(30))
    logs = np.column_stack([np.ones(30), np.log10(ranges), np.log10(k_n)])
    life = 10 ** (logs @ TRUE + 0.02 * random.standard_normal(30))
    path = write_tests(tmp_path / "tests.csv", k_n, ranges, life, np.zeros_like(runout))
    # At K_N = 1238 lives of about 3e5 were found; the strength at 1e6 is far below.
    assert reason(path, 1e6).startswith("K_N and the strength there lie outside of the cloud")


@pytest.mark.filterwarnings("error")
def test_equal_lives_show_nothing(tmp_path: Path) -> None:
    """The scatter of equal lives is zero: a step of the fit overflows."""
    k_n, ranges, life, _ = made_up()
    path = write_tests(tmp_path / "tests.csv", k_n, ranges, 0 * life + 1000, ranges < 30)
    assert (ranges < 30).any()
    for each in fretfe.strength_map(path, [solved("halfplane")], LIFE).margins:
        assert each.reason and math.isnan(each.margin)


def test_lives_must_fall(tmp_path: Path) -> None:
    k_n, ranges, life, runout = made_up()
    path = write_tests(tmp_path / "tests.csv", k_n, 2000 / ranges, life, runout)
    assert reason(path).startswith("lives do not fall with ΔK_T")


@pytest.mark.parametrize(
    ("friction", "young", "expected"),
    [
        (0.6, 210e3, "the tests have f = 0.6, E = 210000, ν = 0.3"),
        (0.4, 72e3, "f = 0.4, E = 210000, ν = 0.3: the tests have f = 0.4, E = 72000"),
    ],
)
def test_friction_and_material_must_agree(
    tmp_path: Path, friction: float, young: float, expected: str
) -> None:
    path = write_tests(tmp_path / "tests.csv", *made_up(), friction=friction, young=young)
    text = reason(path)
    assert text.startswith("no test has its friction and material") and expected in text


def test_other_tests_in_the_file_are_left_out(tests: Path, tmp_path: Path) -> None:
    other = write_tests(tmp_path / "other.csv", *made_up(seed=8), friction=0.9)
    both = tmp_path / "both.csv"
    both.write_text(tests.read_text("utf-8") + "\n" + other.read_text("utf-8").split("\n", 1)[1])
    one, two = (
        fretfe.strength_map(path, [solved("halfplane")], LIFE).margins[0] for path in (tests, both)
    )
    assert two.margin == pytest.approx(one.margin) and two.tests == 24


def test_edges_that_cannot_be_judged(tests: Path) -> None:
    assert reason(tests, run="no cycle") == "there is no evaluated cycle"
    ended = replace(solved("halfplane"), failure=ConvergenceError("for a test"))
    assert fretfe.strength_map(tests, [ended], LIFE).margins[0].reason == "the run is not complete"
    wide = with_edges(lambda edge: replace(edge, k_range_spread=edge.k_range))
    margins = fretfe.strength_map(tests, [wide], LIFE).margins
    assert "an error bar of more than half of it" in margins[0].reason
    varying = with_edges(lambda edge: replace(edge, k_i_range=edge.k_t_range))
    (remark,) = fretfe.strength_map(tests, [varying], LIFE).margins[0].edge.remarks
    assert remark == "P varies: f ΔK_I is 40% of ΔK_T, which the tests do not cover"


def test_a_layer_that_matters_is_remarked(tests: Path) -> None:
    run = solved("halfplane")
    layered = Caution(Kind.LAYER, Subject("main"), "it gives over a length of 0.2")
    contacts = tuple(replace(each, warnings=(layered,)) for each in run.contacts)
    margins = fretfe.strength_map(tests, [replace(run, contacts=contacts)], LIFE).margins
    for each in margins:
        assert any(remark.startswith("a layer rounds off") for remark in each.edge.remarks)


def test_stations_of_solids(tmp_path: Path) -> None:
    result = solid_result({"main": surface(bend=0.3)})
    (contact,) = result.solution.contacts
    fronts = evaluate_fronts(result.solution, contact, follow_fronts(result.solution, contact, 12))
    (front,) = fronts
    stations = tuple(
        replace(
            each,
            k_range=30.0 + each.number,
            k_range_spread=0.1,
            end=each.number >= 10,
            to_end=0.0 if each.number == 11 else 5.0,
        )
        for each in front.stations
    )
    (area,) = result.contacts
    area = replace(area, fronts=(replace(front, stations=stations),), steady=False)
    k_n = stations[0].reported_k_n
    path = write_tests(tmp_path / "tests.csv", *made_up(k_n=(k_n / 2, 2 * k_n)))
    found = fretfe.strength_map(path, [replace(result, contacts=(area,)), result], LIFE)
    assert [each.edge.station for each in found.margins] == list(range(11))
    assert [each.edge.k_t_range for each in found.margins] == [30.0 + n for n in range(11)]
    assert all("the cycle is not steady" in each.edge.remarks for each in found.margins)
    assert "a free end is 5 away, which the tests have not" in found.margins[10].edge.remarks
    margins = [each.margin * each.edge.k_t_range for each in found.margins]
    assert margins == pytest.approx([each.strength for each in found.margins])


def test_dimensionless_pairs(tests: Path, tmp_path: Path) -> None:
    """K_N √l0/σ0 and ΔK_T/(σ0 √l0), here with 0.04 mm and 500 MPa."""
    plain = read_tests(tests, Units())
    _, *rows = tests.read_text("utf-8").splitlines()
    lines = [
        "k_n_ratio,dk_t_ratio,life,runout,friction,young [MPa],poisson,stress [MPa],length [mm]"
    ]
    for row in rows:
        k_n, ranges, rest = row.split(",", 2)
        lines.append(f"{float(k_n) * 0.2 / 500},{float(ranges) / 100},{rest},500,0.04")
    path = tmp_path / "ratios.csv"
    path.write_text("\n".join(lines), "utf-8")
    found = read_tests(path, Units())
    np.testing.assert_allclose(found.k_n, plain.k_n, rtol=1e-12)
    np.testing.assert_allclose(found.k_t_range, plain.k_t_range, rtol=1e-12)


@pytest.mark.parametrize(
    ("one", "two", "same"),
    [
        ("MPa/√mm", "MPa/mm^0.5", True),
        ("MPa·√mm", "MPa*mm^0.5", True),
        ("MPa √mm", "MPa sqrt(mm)", True),
        ("MPa√m", "MPa*mm^0.5", False),
        ("MPa/√m", "MPa/√mm", False),
        ("GPa", "MPa", False),
    ],
)
def test_units(one: str, two: str, same: bool) -> None:
    assert same_unit(one, two) is same


ROW = "1000,40,1e5,0,0.4,210e3,0.3"


@pytest.mark.parametrize(
    ("header", "row", "message"),
    [
        (HEADER.replace("MPa/mm", "MPa/m"), ROW, r"column 'k_n': expected the unit of the results"),
        (
            HEADER.replace(" [MPa*mm^0.5]", ""),
            ROW,
            r"column 'dk_t': .* found none: it is never conv",
        ),
        (HEADER.replace("life", "cycles"), ROW, "line 1: expected a column 'life', found 'k_n', "),
        (HEADER.replace("k_n ", "kn ").replace("dk_t", "kt"), ROW, "expected either k_n and dk_t"),
        (HEADER.replace("life", "life [1e3]"), ROW, r"'life': expected no unit, found \[1e3\]"),
        (HEADER.replace("friction", "friction [%]"), ROW, r"'friction': expected no unit, found"),
        (HEADER.replace("[MPa],", "[MPa]],"), ROW, "line 1: expected a column 'young', found"),
        (f"{HEADER},k_n_ratio", f"{ROW},1", "expected either k_n and dk_t or .* found both"),
        (HEADER, ROW.replace("1e5", "0"), "line 2, column 'life': expected a number > 0, found 0"),
        (HEADER, ROW.replace("1e5,0", "1e5,2"), "expected 1 for a run-out or 0 for a failure"),
        (HEADER, ROW.replace("0.3", "0.5"), "'poisson': expected a number > -1 and < 0.5"),
        (HEADER, ROW.replace("40", "forty"), "expected a finite number, found 'forty'"),
        (HEADER, "", "expected rows of numbers below the header, found none"),
    ],
)
def test_mistakes_in_the_file(tmp_path: Path, header: str, row: str, message: str) -> None:
    path = tmp_path / "tests.csv"
    path.write_text(f"{header}\n{row}\n", "utf-8")
    with pytest.raises(CaseError, match=message) as caught:
        fretfe.strength_map(path, [solved("halfplane")], LIFE)
    assert str(path) in str(caught.value)


def test_other_mistakes(tests: Path) -> None:
    pad = solved("halfplane")
    with pytest.raises(CaseError, match="life: expected a finite number of cycles > 0, found -1"):
        fretfe.strength_map(tests, [pad], -1)
    other = replace(pad, case=pad.case.model_copy(update={"units": Units(length="m")}))
    with pytest.raises(CaseError, match="expected results in the same units"):
        fretfe.strength_map(tests, [pad, other], LIFE)
    with pytest.raises(CaseError, match="expected results with contact edges, found none"):
        fretfe.strength_map(tests, [solid_result({"main": surface()})], LIFE)


@pytest.mark.pictures
def test_command(tests: Path, tmp_path: Path) -> None:
    run, solid = write_run(tmp_path / "pad", "halfplane"), write_solid(tmp_path / "solid")
    arguments = ("strength", tests, run, solid, "--life", "4e5")
    done = command(*arguments, "-o", tmp_path / "map")
    assert done.returncode == 0, done.stderr
    text = " ".join(done.stdout.split())
    assert "pad main left" in text and "log10 N = " in text
    assert "Note: solid: the result has no edges whose factors are known" in text
    numbers = json.loads((tmp_path / "map" / "strength.json").read_text("utf-8"))
    assert numbers["schema"] == {"name": "fretfe-strength", "version": 1}
    left, _ = numbers["edges"]
    assert left["margin"] == pytest.approx(left["strength"] / left["k_t_range"])
    assert numbers["fits"][left["fit"]]["failures"] == 24 - numbers["tests"]["runouts"]
    assert (tmp_path / "map" / "strength.png").stat().st_size > 10_000
    assert json.loads(command(*arguments, "--json").stdout) == numbers
    assert command(*arguments, "-o", run).returncode == 2


@pytest.mark.pictures
def test_figure(tests: Path) -> None:
    found = fretfe.strength_map(tests, [solved("halfplane")], LIFE)
    assert isinstance(found, StrengthMap)
    figure, given = plt.subplots(layout="constrained")
    axes = fretfe.plot_strength(found, given)
    assert axes is given and len(figure.axes) == 2
    assert axes.get_xlabel() == "K_N [MPa/√mm]" and axes.get_ylabel() == "ΔK_T [MPa·√mm]"
    low, high = axes.get_ylim()
    assert low < found.tests.k_t_range.min() and high > found.tests.k_t_range.max()
    drawn = [each for each in axes.containers if isinstance(each, ErrorbarContainer)]
    assert {each.lines[0].get_alpha() for each in drawn} == {1.0}
    other = replace(found.margins[0], margin=math.nan, reason="no test has its friction")
    axes = fretfe.plot_strength(replace(found, margins=(other,)))
    (pale,) = [each for each in axes.containers if isinstance(each, ErrorbarContainer)]
    assert pale.lines[0].get_alpha() == 0.4
    assert pale.get_label() == f"{other.edge.name}\nwithout a margin"


@pytest.mark.pictures
def test_a_front_has_one_mark_with_its_range(tests: Path) -> None:
    found = fretfe.strength_map(tests, [solved("halfplane")], LIFE)
    pad = found.margins[0]
    front = [
        replace(
            pad,
            edge=replace(pad.edge, edge="front 1", station=n, k_n=size * pad.edge.k_n),
            margin=size * pad.margin,
        )
        for n, size in enumerate((1.2, 0.9, 1.0))
    ]
    axes = fretfe.plot_strength(replace(found, margins=(*front, *found.margins)))
    drawn = [each for each in axes.containers if isinstance(each, ErrorbarContainer)]
    (marks,) = [each for each in drawn if each.get_label() == front[0].edge.name]
    place, _, (across, up) = marks.lines
    assert np.array_equal(place.get_xydata(), [[0.9 * pad.edge.k_n, pad.edge.k_t_range]])
    assert across.get_segments()[0][:, 0] == pytest.approx([0.9 * pad.edge.k_n, 1.2 * pad.edge.k_n])
    assert np.ptp(up.get_segments()[0][:, 1]) == 0.0
