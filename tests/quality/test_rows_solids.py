# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows about fronts of solids: places in common, nine tenths of the stations, companions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases import solid_runs
from evaluate.space.test_evaluate import fronts, grid, hertz, zone

from fretfe._typing import Array
from fretfe.evaluate.contacts import Frame, Front, HalfSpaceRatios
from fretfe.evaluate.partners import front_partners
from fretfe.evaluate.refinement import at_places
from fretfe.quality.companions import (
    COARSER,
    FINE,
    MEAN,
    MESH,
    START,
    Variant,
    companion_rows,
    make_variants,
    resized,
)
from fretfe.quality.rows import Pairs, Place, Row, own_rows
from fretfe.quality.validation import plan
from fretfe.reason import Kind
from fretfe.results.model import Result


@pytest.fixture(scope="module")
def circle() -> Front:
    (front,) = fronts(*grid(), [hertz(1.0, 1.0)])
    return front


@pytest.fixture(scope="module")
def ellipse() -> Front:
    (front,) = fronts(*grid(half=1.3, across=1.8), [hertz(1.0, 1.5)])
    return front


def result_with(front: Front) -> Result:
    result = solid_runs.solid_result()
    return replace(result, contacts=(replace(result.contacts[0], fronts=(front,)),))


def scaled(front: Front, factor: float) -> Front:
    stations = (replace(each, k_n=each.k_n * factor) for each in front.stations)
    return replace(front, stations=tuple(stations))


def row_of(values: Array, references: Array, circle: Front) -> Row:
    pairs = Pairs(values, references, np.full(len(values), 0.1))
    return Place("main", circle.name).over_stations("K_N", pairs, "for a test")


def test_nine_tenths_of_the_stations_must_agree(circle: Front) -> None:
    values = np.ones(20)
    two_off = np.r_[1.5, 1.5, np.full(18, 1.05)]
    row = row_of(values, two_off, circle)
    assert (row.verdict, row.reference) == ("agrees", 1.05)
    assert "18 of 20 stations agree" in row.reason
    assert row.where == "main, front 1"
    three_off = np.r_[1.5, 1.5, 1.5, np.full(17, 1.05)]
    assert row_of(values, three_off, circle).verdict == "differs"


def test_few_numbers_are_no_comparison(circle: Front) -> None:
    row = row_of(np.ones(20), np.r_[np.full(11, np.nan), np.ones(9)], circle)
    assert row.verdict == "no verdict" and "at 9 of 20 stations" in row.reason


def test_numbers_between_the_stations(circle: Front) -> None:
    places = circle.along("point")
    between = (places + np.roll(places, -1, axis=0)) / 2
    expected = circle.along("reported_k_n")
    (at_stations,) = at_places(circle, places, [lambda each: each.reported_k_n])
    np.testing.assert_allclose(at_stations, expected, rtol=1e-9)
    (found,) = at_places(circle, between, [lambda each: each.reported_k_n])
    np.testing.assert_allclose(found, (expected + np.roll(expected, -1)) / 2, rtol=1e-9)


def test_front_of_a_companion_is_the_nearest(circle: Front, ellipse: Front) -> None:
    assert front_partners([circle], [ellipse, circle]) == [circle]
    assert front_partners([ellipse, circle], [circle, ellipse]) == [ellipse, circle]
    assert front_partners([circle], [replace(circle, closed=False)]) == [None]
    assert front_partners([circle], []) == [None]


def test_front_elsewhere_or_of_the_other_side_is_no_partner(circle: Front) -> None:
    def moved(x: float) -> Front:
        way = np.array([x, 0.0, 0.0])
        stations = (replace(each, point=each.point + way) for each in circle.stations)
        return replace(circle, stations=tuple(stations))

    def turned(frame: Frame) -> Frame:
        return replace(frame, inward=-frame.inward)

    outside = (replace(each, frame=turned(each.frame)) for each in circle.stations)
    near, hole = moved(0.2), replace(circle, stations=tuple(outside))
    assert front_partners([circle], [moved(3.0), hole, near]) == [near]
    assert front_partners([circle], [moved(3.0), hole]) == [None]


def test_companion_mesh_within_the_error_bars(circle: Front) -> None:
    for factor, verdict in ((1.005, "agrees"), (1.3, "differs")):
        other = result_with(scaled(circle, factor))
        rows = {row.quantity: row for row in companion_rows(MESH, result_with(circle), other)}
        row = rows[f"K_N {MESH}"]
        assert row.verdict == verdict
        assert row.reference == pytest.approx(factor * row.value, rel=0.05)
    (lost,) = companion_rows(MESH, result_with(circle), solid_runs.solid_result())
    assert lost.verdict == "no verdict" and "no such front" in lost.reason


def with_zones(front: Front, **values: float) -> Front:
    """Two slip zones at each station; |ΔK| is largest at the station 5."""
    stations = (
        replace(
            each, k_range=100.0 + (each.number == 5), k_range_spread=2.0, stiffening=2.0,
            size=0.02, slip_zones=(zone(**values), zone(**values)),
        )
        for each in front.stations
    )  # fmt: skip
    return replace(front, stations=tuple(stations))


def slip_rows(front: Front) -> dict[tuple[str, str], Row]:
    found = {(row.edge, row.quantity): row for row in own_rows(result_with(front))}
    return {key: row for key, row in found.items() if key[1].startswith("d, ")}


@pytest.mark.parametrize(
    ("nodes", "formula", "verdicts"),
    [
        (0.05, 0.05, ("agrees", "agrees")),
        (0.02, 0.05, ("differs", "agrees")),
        (0.05, 0.09, ("agrees", "differs")),
    ],
)
def test_plane_problem_against_nodes_and_formula(
    circle: Front, nodes: float, formula: float, verdicts: tuple[str, str]
) -> None:
    given = {"predicted": formula, "predicted_loop": formula}
    rows = slip_rows(with_zones(circle, length=nodes, local=0.05, local_spread=0.002, **given))
    for edge in ("front 1", "front 1, station 5"):
        by_nodes, by_formula = (
            rows[edge, name]
            for name in ("d, plane problem, by nodes", "d, by formula, half cycle 2")
        )
        assert (by_nodes.verdict, by_formula.verdict) == verdicts
        assert (by_nodes.value, by_nodes.reference) == (0.05, nodes)
        assert (by_formula.value, by_formula.reference) == (0.05, formula)


def test_without_plane_problems_the_nodes_have_the_formula_alone(circle: Front) -> None:
    rows = slip_rows(with_zones(circle))
    assert rows["front 1, station 5", "d, by formula, half cycle 2"].verdict == "agrees"
    assert not any("plane problem" in quantity for _, quantity in rows)


def test_worst_station_has_lines_of_its_own_on_the_coarser_mesh(circle: Front) -> None:
    front = with_zones(circle, local=0.05, local_spread=0.002)
    coarse = with_zones(circle, local=0.07, local_spread=0.002)
    rows = {
        (row.edge, row.quantity): row
        for row in companion_rows(MESH, result_with(front), result_with(coarse))
    }
    for edge in ("front 1", "front 1, station 5"):
        assert rows[edge, f"K_N {MESH}"].verdict == "agrees"
        d = rows[edge, f"d {MESH}"]
        assert d.verdict == "differs" and (d.value, d.reference) == pytest.approx((0.05, 0.07))


def test_factors_against_half_spaces(circle: Front) -> None:
    ratios = HalfSpaceRatios(np.ones(2), 0.99, np.nan, np.nan, 1.1, "")
    rows = {
        row.quantity: row
        for row in own_rows(result_with(replace(circle, half_space_ratios=ratios)))
    }
    assert rows["K_T, K_S / by half-spaces"].verdict == "agrees"
    assert rows["K_N / by half-spaces"].verdict == "outside"
    unlike = replace(ratios, reason="the front is open")
    rows = {
        row.quantity: row
        for row in own_rows(result_with(replace(circle, half_space_ratios=unlike)))
    }
    assert rows["K_N and ΔK, by half-spaces"].reason == "the front is open"


def test_contact_without_fronts_is_unknown(circle: Front) -> None:
    rows = {row.quantity: row for row in own_rows(solid_runs.solid_result())}
    assert rows["fronts"].verdict == "unknown"
    rows = {row.quantity: row for row in own_rows(result_with(circle))}
    assert "fronts" not in rows and "K_N" not in rows
    # There are no integrals in this run.
    assert rows["ΔK"].verdict == "unknown"


def test_companion_of_few_elements_is_finer(circle: Front) -> None:
    many = [replace(each, depth=1.0, length=1.0, size=0.08) for each in circle.stations]
    few = [replace(each, size=0.09) for each in many]
    for stations, name in ((many, MESH), (few, FINE)):
        result = result_with(replace(circle, stations=tuple(stations)))
        meshed = replace(result, bodies={"upper": None})  # type: ignore[dict-item]
        variants, reasons = make_variants(result.case, meshed)
        assert name in {*(each.name for each in variants), *reasons}
    rows = companion_rows(FINE, result_with(circle), result_with(scaled(circle, 1.005)))
    (row,) = (each for each in rows if each.quantity == f"K_N {FINE}" and each.edge == "front 1")
    assert row.verdict == "agrees" and row.reason.startswith("elements 0.71 times as large")


def test_layers_of_an_extruded_case_are_thicker_in_its_companion() -> None:
    case = solid_runs.solid_case()
    coarse = resized(case, COARSER)
    assert coarse is not None and coarse.geometry.solid is not None
    assert case.geometry.solid is not None
    assert coarse.geometry.solid.layers == round(case.geometry.solid.layers / 1.5)


def test_plan_tells_number_time_and_memory(circle: Front) -> None:
    seconds = {"condensation": 20.0, "steps": 10.0, "edge integrals": 30.0}
    result = replace(result_with(circle), seconds=seconds)
    case, history = result.case, result.loads
    text = plan([Variant(START, case, history), Variant(MESH, case, None)], result)
    # The same steps and integrals; 60 s over 1.5 to the power of 4.
    assert text.startswith(f"2 companions: {START} 40 s, {MESH} 12 s, 52 s together, estimated; ")
    assert "GB at most" in text
    variants, reasons = make_variants(case, result)
    assert {*(each.name for each in variants), *reasons} == {MEAN, START, MESH}
    assert plan([], result) == "no companions"


def test_each_number_of_a_front_has_a_reason_of_its_own(circle: Front) -> None:
    stations = (replace(each, k_n_spread=0.7 * each.k_n) for each in circle.stations)
    front = replace(circle, stations=tuple(stations))
    rows = {row.quantity: row for row in own_rows(result_with(front))}
    assert rows["K_N"].reason.endswith(f"stations, as {Kind.WIDE_BAR.seen}")
    assert "K_N" not in rows["ΔK"].reason and Kind.WIDE_BAR.seen not in rows["ΔK"].reason
