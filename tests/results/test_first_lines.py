# SPDX-License-Identifier: LGPL-3.0-or-later
"""The first lines of a run: which edge is worst, what it is compared with, and whether to trust."""

from __future__ import annotations

import html
import json
import math
import pickle
import re
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.solid_runs import straight
from cases.stored_runs import solved

from fretfe.evaluate.contacts import Contact, Front, Station, fronts_of, unknown_station
from fretfe.evaluate.headline import Sentences, Trust
from fretfe.evaluate.limits import ModelLimit
from fretfe.evaluate.withheld import lost_front
from fretfe.quality.ends import write_answer
from fretfe.reason import Kind, Reason
from fretfe.report.page.tables import station_table
from fretfe.report.texts import number, with_error
from fretfe.results.end_answers import Compared, EndAnswer, Meeting
from fretfe.results.front_ends import find_end
from fretfe.results.model import Result
from fretfe.results.quantities import K_N, K_RANGE
from fretfe.results.reader import load_result
from fretfe.results.writer import ENDS, write_results
from fretfe.verdict import Verdict


def changed(change: Callable[[Station], Station], **of_contact: object) -> Result:
    """The half-planes with other stations, and other numbers of their contact."""
    result = solved("halfplane")
    (contact,) = result.contacts
    fronts = fronts_of(change(each) for each in contact.stations)
    other: Contact = replace(contact, fronts=fronts, **of_contact)  # type: ignore[arg-type]
    return replace(result, contacts=(other,))


def headline(result: Result) -> Sentences:
    """The first lines, without what was told before."""
    return replace(result).headline.sentences


def same(station: Station) -> Station:
    return station


def differing(station: Station) -> Station:
    """With a slip zone that is not the one that K_T and K_N predict."""
    zones = (replace(zone, length=1.3 * zone.length) for zone in station.slip_zones)
    return replace(station, slip_zones=tuple(zones))


def test_an_unsteady_cycle_with_the_slip_that_is_predicted_is_trusted() -> None:
    """K_N and ranges do not depend on what was before, and slip shows that it does not either."""
    found = headline(changed(same, steady=False, cycle_change=0.2)).trust
    assert found.startswith("To be trusted for this history: the mesh resolves it")


def test_the_worst_edge_is_that_of_the_largest_range() -> None:
    def wider(station: Station) -> Station:
        factor = 1.5 if station.front == "right" else 1.0
        return replace(station, k_range=factor * station.k_range)

    found = headline(changed(wider))
    worst = solved("halfplane").contacts[0].stations[1]
    zone = worst.longest_zone
    assert zone is not None
    assert found.worst.startswith("Worst: main, right edge, x = ")
    assert f"K_N {with_error(*worst.decisive_k_n)} MPa/√mm at t = " in found.worst
    assert f"ΔK_T {with_error(1.5 * worst.k_range, worst.k_range_spread)}" in found.worst
    assert f"d {with_error(*zone.told)} mm (predicted {number(zone.prediction, 3)}: " in found.worst
    assert found.lines[0] == found.worst and found.lines[1] == found.trust


def test_a_sound_run_is_to_be_trusted() -> None:
    found = headline(solved("halfplane"))
    assert found.trust.startswith("To be trusted: the cycle is steady")
    assert found.agreement.startswith("At 2 of 2 edges the longest slip zone agrees")
    assert found.sliding == found.half == ""


@pytest.mark.parametrize("larger", ["left", "right"])
def test_without_a_cycle_the_largest_half_cycle_counts(larger: str) -> None:
    def once(station: Station) -> Station:
        largest = 2.0 if station.front == larger else 1.0
        lost = replace(station, k_range=math.nan, equivalent_range=math.nan)
        return replace(lost, largest_range=largest)

    def without(change: Callable[[Station], Station]) -> Sentences:
        result = changed(change, steady=False, cycle_change=math.nan)
        return headline(replace(result, loads=replace(result.loads, cycle=None)))

    found = without(once)
    assert found.worst.startswith(f"Worst: main, {larger} edge")
    assert found.trust.startswith("To be trusted for this history: the mesh resolves it")
    assert found.longer == ""

    def longer(station: Station) -> Station:
        zones = (replace(zone, length=1.3 * zone.length) for zone in station.slip_zones)
        once_so = once(station)
        return once_so if station.front == larger else replace(once_so, slip_zones=tuple(zones))

    assert without(longer).longer.startswith(
        "Worst is the largest ΔK_T; the longest known slip zone"
    )
    unknown = without(lambda each: replace(once(each), largest_range=math.nan))
    assert unknown.trust.startswith("Not to be trusted as it stands: there is no evaluated cycle")


@pytest.mark.parametrize("count", [1, 2])
def test_edges_where_nothing_slips_are_not_said_to_agree(count: int) -> None:
    def still(station: Station) -> Station:
        if station.front == "left" and count == 1:
            return station
        zones = (
            replace(zone, length=0.0, predicted=0.0, predicted_loop=0.0, spread=0.01)
            for zone in station.slip_zones
        )
        return replace(station, slip_zones=tuple(zones), k_range=0.1 * station.k_range / count)

    found = headline(changed(still))
    rest = f"At {count} of 2 edges nothing slips, as predicted."
    slips = "At 1 of 1 edge the longest slip zone agrees with the prediction of the edge factors. "
    assert found.agreement == (slips + rest if count == 1 else rest)
    assert ("d < 0.01 mm (nothing slips, none predicted)" in found.worst) == (count == 2)


def test_a_zone_without_a_formula_is_called_so() -> None:
    def outside(station: Station) -> Station:
        zones = (
            replace(zone, predicted=math.nan, predicted_loop=math.nan)
            for zone in station.slip_zones
        )
        return replace(station, slip_zones=tuple(zones))

    assert "mm (without a prediction, no verdict)" in headline(changed(outside)).worst


@pytest.mark.parametrize(
    ("doubt", "change"),
    [
        ("the cycle is not steady", lambda: changed(differing, steady=False, cycle_change=0.2)),
        ("the slip zone found is not the one predicted", lambda: changed(differing)),
        (
            "K_N is known to 20% only",
            lambda: changed(lambda each: replace(each, k_n_spread=0.2 * each.k_n)),
        ),
        (
            "ΔK_T is known to 30% only",
            lambda: changed(lambda each: replace(each, k_range_spread=0.3 * each.k_range)),
        ),
        (
            "the mesh does not resolve the slip zone",
            lambda: changed(
                lambda each: replace(
                    each,
                    slip_zones=tuple(replace(zone, resolved=False) for zone in each.slip_zones),
                )
            ),
        ),
        (
            "outside the limits of the model (large sliding)",
            lambda: replace(
                solved("halfplane"), limits=(ModelLimit("main", Kind.SLIDING, "slip", 0.3, 0.1),)
            ),
        ),
    ],
    ids=["unsteady", "differs", "K_N", "range", "zone", "limit"],
)
def test_what_is_doubtful_is_said(doubt: str, change: Callable[[], Result]) -> None:
    found = headline(change())
    assert found.trust.startswith("Not to be trusted as it stands: ")
    assert doubt in found.trust


def test_contacts_that_slide_as_a_whole_have_a_sentence() -> None:
    def sliding(station: Station) -> Station:
        zones = (replace(zone, gross=True, length=math.nan) for zone in station.slip_zones)
        return replace(station, slip_zones=tuple(zones))

    result = changed(sliding, sliding_share=0.53, sliding_range=0.0283)
    found, (contact,) = headline(result), result.contacts
    work = with_error(contact.reported_dissipation, contact.dissipation_spread)
    assert found.sliding == (
        "Slides as a whole in the cycle: main in 53% of the time, by 0.0283 mm, friction work "
        f"{work} N·mm/mm."
    )
    assert "the whole contact slides there" in found.worst
    assert "At 0 of 2 edges" in found.agreement and "(2 gross)" in found.agreement


def test_an_end_at_a_plane_of_symmetry_is_no_edge() -> None:
    def half(station: Station) -> Station:
        lack = Reason(Kind.NO_EDGE, words="the bodies go on")
        return replace(station, lack=lack) if station.front == "left" else station

    found = headline(changed(half))
    assert found.agreement.startswith("At 1 of 1 edge ")
    assert found.half.startswith("Half model: main ends at a plane of symmetry")


def test_nothing_known_has_its_reason() -> None:
    lost = Reason(Kind.NO_TRACTIONS)
    found = headline(
        changed(
            lambda each: replace(
                each, k_n=math.nan * each.k_n, k_range=math.nan, lack=lost, slip_zones=()
            )
        )
    )
    assert found.worst.startswith("No edge has a known K_N or range of K_T (main.left: ")
    assert "the tractions of full stick cannot be told" in found.worst and found.trust == ""


def test_of_several_edges_that_is_named_which_needs_the_smallest_elements() -> None:
    def lost(each: Station) -> Station:
        lack = Reason(Kind.STEEP, 2 if each.front == "left" else 1, 8)
        unknown = replace(each, k_n=math.nan * each.k_n, k_t_range=math.nan, k_range=math.nan)
        return replace(unknown, lack=lack, slip_zones=())

    found = headline(changed(lost))
    assert (
        "(main.right: " in found.worst and "make the elements there at least 8 times" in found.worst
    )


def test_a_worst_station_beside_an_end_names_it(tmp_path: Path) -> None:
    """With |ΔK| by the sub-models of that end, if it has some."""
    result = straight(mirrored=False)
    first = headline(result).worst
    assert first.startswith("Worst: station main.1.1, 0.375 mm from the free end main.1.start: K_N")
    assert "by its sub-models" not in first
    end = find_end(result, "main.1.start")
    assert end is not None
    near, none = np.array([0.2, 0.4]), ()
    found = EndAnswer(
        end.name, end.point, near, 30 - near, near, near, near, near, 0.1, 0.01, 0.3, none, none
    )
    folder = tmp_path / ENDS / end.name
    folder.mkdir(parents=True)
    write_answer(result, found, folder)
    told = headline(replace(result, directory=tmp_path)).worst
    assert told.endswith(" (by its sub-models |ΔK| is 29.80 ± 0.20 MPa·√mm 0.2 mm from it).")
    other = replace(found, name="main.1.end")
    write_answer(result, other, folder)
    assert headline(replace(result, directory=tmp_path)).worst == first


def test_fronts_and_contacts_that_cannot_be_followed_are_named_beside_the_worst() -> None:
    result = straight(mirrored=False)
    (contact,) = result.contacts
    (front,) = contact.fronts
    lack = lost_front(np.zeros(3), 1, 4)
    states = len(result.loads.times)
    stations = tuple(unknown_station("front 2", number, states, lack) for number in range(12))
    other = replace(contact, name="other", fronts=(), lack=Reason(Kind.NARROW, 3, 8))
    both = replace(contact, fronts=(front, Front("front 2", stations, length=3.0)))
    found = headline(replace(result, contacts=(both, other)))
    assert found.worst.startswith("Worst of the fronts that are known: station main.1.1,")
    lost = "nothing is known of other; main, front 2, which may be worse"
    assert found.trust == f"Not to be trusted as it stands: {lost}."
    assert "24 unknown" in found.agreement
    table = station_table(replace(result, contacts=(both,)))
    assert table is not None
    cells = list(table.columns[0].cells)
    assert cells[-2:] == ["main front 2", "  cannot be followed"]


@pytest.mark.parametrize("part", [9.6, 19.0])
def test_sub_models_that_agree_are_trusted_where_the_run_is_not(
    tmp_path: Path, part: float
) -> None:
    result = straight(mirrored=False)
    (contact,) = result.contacts
    (front,) = contact.fronts
    stations = [
        replace(each, k_n_spread=0.2 * each.k_n, k_range_spread=0.3 * each.k_range)
        for each in front.stations
    ]
    front = replace(front, stations=tuple(stations))
    result = replace(
        result, contacts=(replace(contact, fronts=(front,)),), directory=tmp_path, failure=None
    )
    worst, end = front.stations[1], find_end(result, "main.1.start")
    assert end is not None
    k_range = Compared(worst.k_range, worst.k_range_spread, part, 0.1)
    met = Meeting("main.1.1", 0.375, k_range, Compared(*K_N.read(worst), 400.0, 1.0))
    none = np.empty(0)
    found = EndAnswer(end.name, end.point, *6 * (none,), 0.1, 0.01, 0.3, (), meetings=(met,))
    (tmp_path / ENDS / end.name).mkdir(parents=True)
    write_answer(result, found, tmp_path / ENDS / end.name)
    first, doubts = headline(result), ("K_N is known to 20% only", "|ΔK| is known to 30% only")
    agrees = part < 10
    assert ("; by sub-models there K_N 400.0 ± 1.0 MPa/√mm, |ΔK| 9.60 ± 0.10" in first.worst) is (
        agrees
    )
    assert all((doubt in first.trust) is not agrees for doubt in doubts)
    assert ("run and sub-model differ there: |ΔK| " in first.trust) is not agrees


def test_what_the_plane_problem_shows_nodes_need_not() -> None:
    def local(station: Station) -> Station:
        zones = (
            replace(zone, resolved=False, local=zone.length, local_spread=0.05 * zone.length)
            for zone in station.slip_zones
        )
        return replace(station, slip_zones=tuple(zones))

    assert "does not resolve the slip zone" not in headline(changed(local)).trust


def cards(result: Result) -> None:
    """Check that the notebook and the file of a result have its headline, which pickles."""
    told = result.headline
    assert pickle.loads(pickle.dumps(told)).sentences == told.sentences
    card = result._repr_html_()
    assert all(html.escape(line) in card for line in told.sentences.lines)


def numbers(folder: Path, result: Result) -> dict[str, Any]:
    """The headline in the file of a result."""
    write_results(folder, result)
    found: dict[str, Any] = json.loads((folder / "results.json").read_text("utf-8"))["headline"]
    return found


def is_same(written: Any, told: object) -> bool:
    """True if what was written are the fields of an object: null where a number is not known."""
    if is_dataclass(told):
        named = {each.name: getattr(told, each.name) for each in fields(told)}
        return written.keys() == named.keys() and all(is_same(written[n], named[n]) for n in named)
    if isinstance(told, tuple):
        return len(written) == len(told) and all(map(is_same, written, told))
    return written is None if isinstance(told, float) and math.isnan(told) else written == told


@pytest.mark.parametrize("name", ["halfplane", "no cycle", "incomplete"])
def test_the_headline_is_in_the_file_in_notebooks_and_pickles(name: str, tmp_path: Path) -> None:
    result = solved(name)
    written, told = numbers(tmp_path, result), result.headline
    assert is_same(written, told)
    cards(result)
    assert load_result(tmp_path).headline.sentences == told.sentences
    worst = told.worst
    assert worst is not None and worst.zone is not None
    contact, _, station = find(result, worst.name)
    zone = station.longest_zone
    assert zone is not None and contact.name_of(station) == worst.name
    assert (worst.zone.start, worst.zone.end) == (zone.start, zone.end)
    assert (worst.zone.length, worst.zone.spread) == zone.told
    assert (worst.k_n, worst.k_n_spread) == K_N.read(station)
    assert (worst.k_range, worst.k_range_spread) == pytest.approx(
        K_RANGE.read(station), nan_ok=True
    )
    assert worst.place == station.position[worst.state]
    sound = name in ("halfplane", "no cycle")
    assert (told.trust is Trust.TRUSTED) == sound == (told.doubts == ())


def find(result: Result, name: str) -> tuple[Contact, Front, Station]:
    return next(
        (contact, front, station)
        for contact in result.contacts
        for front in contact.fronts
        for station in front.stations
        if contact.name_of(station) == name
    )


def test_where_nothing_is_known_the_headline_says_why(tmp_path: Path) -> None:
    lost = Reason(Kind.NO_TRACTIONS)
    result = changed(
        lambda each: replace(
            each, k_n=math.nan * each.k_n, k_range=math.nan, lack=lost, slip_zones=()
        )
    )
    told = result.headline
    assert told.worst is None and told.longest is None and told.trust is Trust.UNKNOWN
    written = numbers(tmp_path, result)
    assert written["worst"] is None and written["trust"] == "unknown"
    assert written["sentences"]["worst"].startswith("No edge has a known K_N or range of K_T")
    cards(result)


def test_of_a_contact_that_slides_the_headline_has_no_length() -> None:
    result = changed(
        lambda each: replace(
            each, slip_zones=tuple(replace(zone, gross=True) for zone in each.slip_zones)
        )
    )
    told = result.headline
    assert told.worst is not None and told.worst.zone is not None and told.longest is None
    assert told.worst.zone.gross and math.isnan(told.worst.zone.length)
    assert told.sentences.longer == "" and told.verdicts == {Verdict.GROSS: 2}


def test_a_longer_slip_zone_than_that_of_the_largest_range_is_told() -> None:
    """As in a sector of a disc, whose edges have other K_N: the criterion is said."""

    def longer(each: Station) -> Station:
        if each.front == "left":
            return replace(each, k_range=1.1 * each.k_range)
        zones = (replace(zone, length=1.3 * zone.length) for zone in each.slip_zones)
        return replace(each, slip_zones=tuple(zones))

    result = changed(longer)
    told = result.headline
    assert told.worst is not None and told.longest is not None and told.worst.zone is not None
    assert (told.worst.name, told.longest.name) == ("main.left", "main.right")
    assert told.longest.length == pytest.approx(1.3 * told.worst.zone.length, rel=1e-2)
    assert told.sentences.longer.startswith(
        "Worst is the largest ΔK_T; the longest known slip zone is at main, right edge, x = "
    )
    assert headline(changed(same)).longer == ""


def test_a_range_and_a_zone_of_two_half_cycles_say_so() -> None:
    def moving(station: Station, earlier: int) -> Station:
        zone, hold = station.longest_zone, station.hold * np.linspace(1.0, 1.2, len(station.hold))
        assert zone is not None
        end = zone.end - earlier
        return replace(station, hold=hold, equivalent_range=station.k_range, equivalent_end=end)

    assert "half cycle" not in headline(changed(lambda each: moving(each, 0))).worst
    two = headline(changed(lambda each: moving(each, 5))).worst
    assert re.search(r"\(in the half cycle to t = [\d.]+, d in that to [\d.]+ s\), d", two)


def test_sub_models_that_come_later_change_the_headline_in_the_file(tmp_path: Path) -> None:
    result = straight(mirrored=False)
    before = numbers(tmp_path, result)
    result = replace(load_result(tmp_path))
    end = find_end(result, "main.1.start")
    assert end is not None
    worst = end.front.stations[1]
    k_range = Compared(worst.k_range, worst.k_range_spread, 2 * worst.k_range, 0.1)
    met = Meeting("main.1.1", 0.375, k_range, Compared(*K_N.read(worst), math.nan, math.nan))
    none = np.empty(0)
    found = EndAnswer(end.name, end.point, *6 * (none,), 0.1, 0.01, 0.3, (), meetings=(met,))
    (tmp_path / ENDS / end.name).mkdir(parents=True)
    write_answer(result, found, tmp_path / ENDS / end.name)
    after = json.loads((tmp_path / "results.json").read_text("utf-8"))["headline"]
    assert after["doubts"] != before["doubts"]
    assert any(each.startswith("run and sub-model differ there") for each in after["doubts"])
    assert is_same(after, load_result(tmp_path).headline)
