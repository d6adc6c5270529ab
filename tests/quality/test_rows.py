# SPDX-License-Identifier: LGPL-3.0-or-later
"""Verdicts, and validations of half-plane cases that must pass, fail, or be outside."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, loop, problem, started
from cases.pad_cases import pad, press, shear
from harness.launch import fretfe, python
from harness.told import Told

from fretfe.backends import Backend, RunOptions, find_backend
from fretfe.case import Case, parse_case
from fretfe.evaluate.contacts import SlipZone, Station, fronts_of
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.plane.evaluate import plane_edges
from fretfe.evaluate.plane.unit_factors import integral_units
from fretfe.evaluate.verdicts import Judgement, expected_error, judge
from fretfe.halfplane import solve_half_planes
from fretfe.loads import History
from fretfe.quality.companions import MEAN, MESH, START, make_variants, overloaded, shifted
from fretfe.quality.rows import Place, Row, own_rows
from fretfe.quality.validation import validate
from fretfe.reason import Kind, Reason
from fretfe.results.model import Result
from fretfe.verdict import Verdict


@pytest.mark.parametrize(
    ("value", "reference", "verdict"),
    [
        (1.0, 1.05, "agrees"),
        (1.0, 0.89, "differs"),
        (math.nan, 1.0, "differs"),
        (1.0, math.nan, "differs"),
        (math.nan, math.nan, "no verdict"),
    ],
)
def test_verdicts(value: float, reference: float, verdict: str) -> None:
    row = Place("main", "left").compared("d", value, reference, 0.1, "for a test")
    assert row.verdict == verdict
    outside = Place("main", "left").compared(
        "d", value, reference, 0.1, "for a test", Verdict.OUTSIDE
    )
    assert outside.verdict == verdict.replace("differs", "outside")
    whole = Place("main").missing("d", "no friction")
    assert whole.verdict == "no verdict"
    assert (row.where, whole.where) == ("main, left edge", "main")


def test_a_zone_after_a_whole_slide_is_not_called_too_short_for_the_mesh() -> None:
    result = halfplane(0.3)
    (contact,), (history,) = result.contacts, result.solution.contacts
    station, edges = contact.stations[0], plane_edges(result.solution, history, integral_units)
    zone = replace(station.slip_zones[-1], resolved=False)

    def judged(size: float, zone: SlipZone) -> Judgement:
        return judge(replace(station, size=size), zone)

    found = judged(0.9 * zone.length, zone)
    assert found.verdict == Verdict.NOT_RESOLVED
    assert found.reason.startswith("too few elements over the slip zone: 1.1 of")
    assert "known to ±" in judged(zone.length / 10, zone).reason

    def slid(share: float) -> SlipZone:
        traction = history.mean_traction[:].copy()
        traction[..., 1] = share * history.friction.largest * traction[..., 0]
        sheared = replace(edges, contact=replace(history, mean_traction=traction))
        return sheared.with_shear(0, zone, np.array([1.0, 0.0]))

    assert judged(0.9 * zone.length, slid(0.9)).verdict == Verdict.NOT_RESOLVED
    sliding = judged(0.9 * zone.length, slid(-0.98))
    assert sliding.verdict == Verdict.NO_VERDICT
    assert "the shear is 98% of f p all over the flank" in sliding.reason


@cache
def halfplane(shear_ratio: float, cycles: int = 3, mean: float = 0.0) -> Result:
    """Hertz under a steady shear cycle."""
    ratio = mean + shear_ratio * np.cos(loop(24, cycles))
    given = problem(LOAD, started(ratio * LIMIT), cycle=24)
    outcome = solve_half_planes(given)
    solution = outcome.solution
    return Result(
        case=case(),
        loads=History(solution.channels, solution.times, solution.values, solution.cycle),
        contacts=evaluate(solution, outcome.unit_factors),
        root_solution=solution,
    )


def verdicts(rows: list[Row], quantity: str) -> set[str]:
    found: set[str] = {row.verdict for row in rows if quantity in row.quantity}
    assert found, quantity
    return found


def test_a_good_run_passes() -> None:
    rows = list(own_rows(halfplane(0.15)))
    assert {row.verdict for row in rows} == {"agrees", "no verdict"}
    assert verdicts(rows, "half cycle") == verdicts(rows, "moving edge") == {"agrees"}


def test_a_first_loading_that_stays_in_the_shear_is_no_failure() -> None:
    """From zero to the largest load: its slip zone is twice that of the cycle, and so is the
    place where the shear of that reversal leaves the friction bound."""
    rows = {row.quantity: row for row in own_rows(halfplane(0.2, mean=0.2)) if row.edge == "left"}
    for number in (1, 2):
        row = rows[f"d, by traction, half cycle {number}"]
        assert row.verdict == "agrees" and row.value == pytest.approx(row.reference, rel=0.03), row


def test_what_does_not_exist_is_no_failure() -> None:
    """No cycle or friction to be steady in; no second load that tells a formula's error."""
    result = halfplane(0.15)
    (contact,) = result.contacts
    fronts = fronts_of(replace(edge, stiffening=math.nan) for edge in contact.stations)
    edited = replace(contact, fronts=fronts, cycle_change=math.nan)
    rows = list(own_rows(replace(result, contacts=(edited,))))
    assert verdicts(rows, "change of q") == verdicts(rows, "d, by formula") == {"no verdict"}


def test_large_expected_error_does_not_excuse_a_large_difference() -> None:
    """A prediction of half the length that was found, where an error of 200 % is expected."""
    result = halfplane(0.15)
    (contact,) = result.contacts
    zones = [zone for zone in contact.stations[0].slip_zones if math.isfinite(zone.predicted_loop)]
    longer = tuple(replace(zone, predicted_loop=zone.length / 2) for zone in zones)
    stiffening = 4.0 / longer[0].length
    edges = (replace(edge, slip_zones=longer, stiffening=stiffening) for edge in contact.stations)
    edited = replace(contact, fronts=fronts_of(edges))
    rows = list(own_rows(replace(result, contacts=(edited,))))
    assert verdicts(rows, "d, by formula") == {"outside"}


@pytest.mark.parametrize("ratio", [0.1, 0.2, 0.4])
def test_expected_error_of_the_asymptote(ratio: float) -> None:
    for edge in halfplane(ratio).contacts[0].stations:
        zone = edge.slip_zones[-1]
        # Hertz: d/(2a); the second derivative of P(a) comes from fits at two loads
        assert expected_error(edge, zone.length) == pytest.approx(zone.length / 2, rel=0.1)
        actual = 1 - zone.predicted / zone.length
        # By what the edge remembers the same to second order.
        assert zone.predicted_loop == pytest.approx(zone.length, rel=0.01)
        assert actual == pytest.approx(expected_error(edge, zone.length), rel=0.25)


def test_long_slip_zones_are_outside_of_the_asymptote_and_no_failure() -> None:
    result = halfplane(0.85)
    rows = list(own_rows(result))
    assert {row.verdict for row in rows if "by formula" in row.quantity} == {"agrees"}
    for edge in result.contacts[0].stations:
        assert edge.slip_zones[-1].predicted < 0.8 * edge.slip_zones[-1].length


def test_what_is_wrong_fails() -> None:
    result = halfplane(0.15)
    contact = result.contacts[0]

    def with_edge(**changes: object) -> list[Row]:
        edges = (replace(contact.stations[0], **changes), contact.stations[1])  # type: ignore[arg-type]
        changed = replace(result, contacts=(replace(contact, fronts=fronts_of(edges)),))
        return list(own_rows(changed))

    zones = contact.stations[0].slip_zones
    longer = (*zones[:-1], replace(zones[-1], length=1.5 * zones[-1].length))
    assert "differs" in verdicts(with_edge(slip_zones=longer), "half cycle 2")
    moved = (*zones[:-1], replace(zones[-1], border=zones[-1].border + 0.02))
    assert "differs" in verdicts(with_edge(slip_zones=moved), "inner end")
    assert "differs" in verdicts(with_edge(k_n=1.1 * contact.stations[0].k_n), "moving edge")
    changes = {"k_t_range_fitted": 1.05 * contact.stations[0].k_t_range}
    assert "differs" in verdicts(with_edge(**changes), "by fit")
    unsteady = replace(result, contacts=(replace(contact, cycle_change=0.1),))
    assert verdicts(list(own_rows(unsteady)), "change of q") == {"differs"}
    strange = replace(result, contacts=(replace(contact, shear_mismatch=0.2),))
    assert verdicts(list(own_rows(strange)), "Q by ΔK_T") == {"outside"}
    missing = replace(contact, shear_mismatch=math.nan, cycle_change=math.nan)

    def given(loads: History, station: Station) -> set[str]:
        own = replace(missing, fronts=fronts_of((station, contact.stations[1])))
        rows = own_rows(replace(result, loads=loads, contacts=(own,)))
        return {
            each.reason for each in rows if each.quantity in ("Q by ΔK_T / by ∫q", "change of q")
        }

    whole, station = result.loads, contact.stations[0]
    assert given(replace(whole, cycle=None), station) == {"no cycle"}
    assert given(whole, station) == {"no shear force in the cycle", "no friction"}
    lost = replace(station, k_range=math.nan, lack=Reason(Kind.NO_TRACTIONS))
    text = f"ΔK_T of the {station.front} edge is not known: {lost.lack.text}"
    assert given(whole, lost) == {text, "no friction"}
    along = replace(station, k_angle=90.0)
    assert given(whole, along) == {"shear acts along z", "no friction"}


def test_histories_of_the_companions() -> None:
    history = halfplane(0.15).loads
    assert history.cycle is not None
    values = np.column_stack([np.linspace(0, 1, len(history.times)), np.ones(len(history.times))])
    first, last = history.cycle
    values[first:, 0] = 2.0 + np.cos(np.linspace(0, 2 * np.pi, last - first + 1))
    given = History(("a", "b"), history.times, values, history.cycle)
    other = shifted(given)
    assert other.cycle is not None
    new = other.values[other.cycle[0] : other.cycle[1] + 1]
    # a tenth of the range 2, towards zero; what does not vary stays
    assert new[:, 0] == pytest.approx(values[first:, 0] - 0.2)
    assert np.all(new[:, 1] == 1.0)
    assert np.array_equal(other.values[: first + 1], values[: first + 1])
    excursion = overloaded(given)
    assert excursion.values[first:, 0].max() == pytest.approx(3.15)
    assert excursion.values[first:, 0].min() == pytest.approx(0.85)
    assert excursion.cycle is not None
    start, end = excursion.cycle
    assert excursion.values[start : end + 1, 0] == pytest.approx(values[first:, 0])
    assert np.all(np.diff(excursion.times) > 0)


def case(**tables: object) -> Case:
    return parse_case(pad(**tables))


def test_companions_that_make_no_sense_say_why() -> None:
    backend = find_backend("halfplane")
    result = backend.solve(case())
    variants, reasons = make_variants(case(), result)
    assert [variant.name for variant in variants] == [MEAN, START]
    assert reasons == {MESH: "no mesh"}
    varying = {**press(), "history": [*press()["history"], shear(60.0)["history"][1]]}
    varying["history"][1] = {**varying["history"][1], "mean": -600.0}
    loads = case(loads={"press": varying, "shear": shear(90.0)})
    variants, reasons = make_variants(loads, backend.solve(loads))
    assert [variant.name for variant in variants] == [START]
    assert "the pressure at the edges varies" in reasons[MEAN]


def test_validation_of_half_planes() -> None:
    told = Told()
    validation = validate(case(), find_backend("halfplane"), RunOptions(observer=told))
    assert validation.passed
    first, plan, *companions = told.phases
    assert [first, *companions] == ["the case itself", MEAN, START]
    assert plan.startswith("2 companions: ")
    assert verdicts(list(validation.rows), f"d {MEAN}") == {"agrees"}
    assert verdicts(list(validation.rows), f"d {START}") == {"agrees"}


class Sliding(Backend):
    """The half-plane backend, with a wrong answer about any other history."""

    summary = "for a test"

    def supports(self, case: Case) -> tuple[str, ...]:
        return ()

    def solve(self, case: Case, options: RunOptions = RunOptions()) -> Result:  # noqa: B008
        result = find_backend("halfplane").solve(case, options)
        if options.history is None:
            return result
        contact = result.contacts[0]
        edges = [
            replace(
                edge, slip_zones=tuple(replace(z, length=2 * z.length) for z in edge.slip_zones)
            )
            for edge in contact.stations
        ]
        return replace(result, contacts=(replace(contact, fronts=fronts_of(edges)),))


def test_companions_that_disagree() -> None:
    rows = list(validate(case(), Sliding()).rows)
    assert verdicts(rows, f"d {MEAN}") == {"differs"}
    # another start may lead to another steady state: said, not failed
    assert verdicts(rows, f"d {START}") == {"depends"}


def test_command(tmp_path: Path) -> None:
    from cases.pad_cases import HERTZ

    file = tmp_path / "pad.toml"
    file.write_text(HERTZ, encoding="utf-8")
    # Not by Click's test runner: before 8.2 it adds what is printed on standard error.
    arguments: list[str | Path] = ["-m", "fretfe", "validate", file, "-o", tmp_path / "out"]
    arguments += ["--backend", "halfplane"]
    answer = python(*arguments, "--json")
    assert answer.returncode == 0, answer.stderr
    data = json.loads(answer.stdout)
    assert data["passed"] and data == json.loads((tmp_path / "out/validation.json").read_text())
    assert {"contact", "edge", "quantity", "value", "verdict", "difference"} <= set(data["rows"][0])
    assert (tmp_path / "out/results.json").exists()
    table = fretfe(*arguments[2:])
    assert "description holds for this case." in " ".join(table.stdout.split())
