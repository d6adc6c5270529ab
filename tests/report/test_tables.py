# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables in a terminal of 80 columns: nothing is cut, whatever the numbers are."""

from __future__ import annotations

import io
import math
import re
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from cases.solid_runs import exact_station, stationed_sphere, with_stations
from cases.stored_runs import solved
from matplotlib.figure import Figure
from rich.console import Console

from fretfe.evaluate.contacts import Contact, SlipZone, Station, fronts_of
from fretfe.evaluate.refinement import Refinement
from fretfe.evaluate.resultants import force_ranges
from fretfe.quality.comparison import Row, print_rows
from fretfe.quality.rows import Row as Checked
from fretfe.quality.validation import Validation, print_validation
from fretfe.report.figures.edges import _zones
from fretfe.report.page.tables import (
    contact_table,
    front_texts,
    refinement_tables,
    station_table,
    timing_table,
    work_words,
)
from fretfe.report.texts import number, print_whole, with_error, with_prefix
from fretfe.results.model import Result
from fretfe.results.tables import edge_records, station_records
from fretfe.verdict import Verdict

WIDTH = 80
WIDE = 1.23456e5


def cut(text: str) -> list[str]:
    """Words that end with dots; those of ranges stand alone."""
    return re.findall(r"\S+…", text)


@pytest.fixture(autouse=True)
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(WIDTH))


def zone(**values: Any) -> SlipZone:
    numbers = {"length": 0.0412, "spread": 0.019, "predicted": 0.0331, "predicted_loop": 0.0331}
    return SlipZone(
        **{"start": 10, "end": 20, "border": 0.05, "resolved": False, "gross": False}
        | numbers | values
    )  # fmt: skip


@pytest.fixture(scope="module")
def sphere() -> Result:
    """Twelve stations with slip zones that only the plane problem can tell."""
    load = stationed_sphere().loads.values[:, 1] / 1e3

    def station(each: Station) -> Station:
        local = zone(local=0.0424 + 1e-3 * each.number, local_spread=0.0022)
        return replace(exact_station(each, load, 10.0), slip_zones=(local,))

    return with_stations(stationed_sphere(), station)


def large(contact: Contact) -> Contact:
    fronts = tuple(replace(front, local_work=2.341e-5) for front in contact.fronts)
    return replace(
        contact, name="left flank", fronts=fronts, normal_force=WIDE * contact.normal_force,
        shear_force=WIDE * contact.shear_force,
        **force_ranges(WIDE * contact.normal_force, WIDE * contact.shear_force, None),
        contact_area=WIDE * contact.contact_area,
        stick_area=WIDE * contact.stick_area, dissipation=1.234e-5, dissipation_spread=1.2e-6,
    )  # fmt: skip


@pytest.mark.parametrize(("part", "shown"), [(1e-13, "0"), (1e-9, "1e-7")])
def test_shear_that_is_round_off_of_p_is_none(part: float, shown: str) -> None:
    run = solved("halfplane")
    normal = np.full_like(run.contacts[0].normal_force, 100.0)
    contact = replace(run.contacts[0], **force_ranges(normal, part * normal, None))
    table = contact_table(replace(run, contacts=(contact,)))
    assert list(table.columns[2].cells) == [shown]


def test_contacts_of_solids_fit(sphere: Result, capsys: pytest.CaptureFixture[str]) -> None:
    for contacts in (sphere.contacts, tuple(map(large, sphere.contacts))):
        table = contact_table(replace(sphere, contacts=contacts))
        print_whole(table)
        text = capsys.readouterr().out
        assert not cut(text) and max(map(len, text.splitlines())) <= WIDTH
    assert "P, |Q| in MN" in str(table.title) and "1.23e-5" in text
    work = next(list(each.cells) for each in table.columns if each.header == "work")
    assert list(table.columns[0].cells) == ["left flank", "  at fronts"]
    assert work == ["1.23e-5\n± 1.2e-6", "2.34e-5"]


def test_fronts_fit_and_have_the_plane_problem(
    sphere: Result, capsys: pytest.CaptureFixture[str]
) -> None:
    table = station_table(sphere)
    assert table is not None
    print_whole(table)
    text = capsys.readouterr().out
    assert not cut(text) and max(map(len, text.splitlines())) <= WIDTH
    names, *_, slip, _ = (list(column.cells) for column in table.columns)
    assert slip[0] == "0.042 … 0.053" and not any("resolved" in str(each) for each in names)
    worst = sphere.contacts[0].fronts[0].worst
    assert worst is not None and slip[1] == with_error(*worst.slip_zones[0].told)


def test_the_first_lines_name_the_station_of_a_longer_slip_zone(sphere: Result) -> None:
    longest = sphere.contacts[0].stations[11]
    zone, told = longest.longest_zone, sphere.headline
    assert zone is not None and told.worst is not None and told.longest is not None
    assert told.worst.name == "main.1.0" and told.longest.name == "main.1.11"
    assert (told.longest.length, told.longest.spread) == zone.told
    assert told.sentences.longer.startswith(
        "Worst is the largest |ΔK|; the longest known slip zone is at station main.1.11, "
        f"{number(longest.arc, 3)} mm along the front: d 0.0534 ± 0.0022 mm (predicted "
    )
    table = station_table(sphere)
    assert table is not None
    assert list(table.columns[0].cells)[1] == "  0 at 0 *"


def test_a_length_that_stands_alone_is_that_of_the_longer_half_cycle(sphere: Result) -> None:
    """Under P and Q out of phase the zones of both half cycles differ; either may come last."""
    long = zone(local=0.0934, local_spread=0.0031, predicted_loop=0.09)
    short = zone(local=0.0276, local_spread=0.0013, predicted_loop=0.027)
    for zones in ((long, short), (short, long)):
        result = with_stations(sphere, partial(replace, slip_zones=zones))
        told = result.headline.sentences
        assert "d 0.0934 ± 0.0031 mm" in told.worst and told.longer == ""
        assert "At 12 of 12 stations the longest slip zone agrees" in told.agreement
        table = station_table(result)
        assert table is not None
        *_, slip, predicted = (list(column.cells) for column in table.columns)
        lengths = [with_error(*each.told) for each in zones]
        assert slip == ["\n".join(f"{z.local:.2g}" for z in zones), "\n".join(lengths)]
        assert predicted[1] == "\n".join(f"{each.prediction:.3g}" for each in zones)
        row = station_records(result.contacts)[0]
        assert (row["local"], row["local_spread"], row["predicted"]) == (0.0934, 0.0031, 0.09)
        assert [row["local_1"], row["local_2"]] == [each.local for each in zones]
        axes = Figure().add_subplot()
        _zones(axes, result.contacts[0].fronts[0])
        line = next(line for line in axes.lines if line.get_label() == "plane problem")
        assert np.unique(np.asarray(line.get_ydata())).tolist() == [0.0934]


def test_a_zone_without_length_is_ranked_by_what_is_known_of_it() -> None:
    unknown = zone(local=0.06, local_spread=0.05)
    known = zone(local=0.0276, local_spread=0.0013)
    gross = zone(gross=True, local=0.01, local_spread=0.001)
    (station, *_) = stationed_sphere().contacts[0].stations
    for zones in ((unknown, known), (known, unknown)):
        assert replace(station, slip_zones=zones).longest_zone is unknown
    assert replace(station, slip_zones=(gross, unknown)).longest_zone is gross
    assert replace(station, slip_zones=(unknown, known, known)).longest_zone is unknown
    assert replace(station, slip_zones=()).longest_zone is None


def test_edge_from_which_a_slip_zone_counts() -> None:
    """An edge that was elsewhere when a zone was as long as that: so it is under varying P."""
    result = solved("halfplane")
    (contact,) = result.contacts

    def with_moved_edge(edge: Station) -> Station:
        position = edge.position.copy()
        position[edge.slip_zones[-2].end] -= 0.1
        return replace(edge, position=position)

    edges = tuple(with_moved_edge(each) for each in contact.stations)
    moved = replace(contact, fronts=fronts_of(edges))
    table = station_table(replace(result, contacts=(moved,)))
    assert table is not None
    cells = next(list(each.cells) for each in table.columns if each.header == "slip zones")
    for edge, row, cell in zip(edges, edge_records((moved,)), cells, strict=True):
        places = [float(edge.position[zone.end]) for zone in edge.slip_zones[-2:]]
        first, second = (number(zone.length, 3) for zone in edge.slip_zones[-2:])
        assert cell == f"{first} / {second}\nfrom {' / '.join(map(number, places))}"
        assert [row["slip_1_from"], row["slip_2_from"]] == places
        assert places[0] == pytest.approx(row["position"] - 0.1)


def test_ends_of_fronts_have_a_line_of_their_own(sphere: Result) -> None:
    def station(each: Station) -> Station:
        spread = 5.0 if each.number == 1 else 1.0
        return replace(each, end=each.number < 2, k_range=30.0 + each.number, k_range_spread=spread)

    *_, last = front_texts(with_stations(sphere, station))
    assert "outside the edge formulas" in last and "|ΔK| is 31.0 ± 5.0 MPa·√mm" in last
    assert "at station main.1.1, " in last and "of extruded bodies only" not in last
    case = sphere.case.model_copy(
        update={"geometry": sphere.case.geometry.model_copy(update={"solid": None})}
    )
    *_, bare = front_texts(with_stations(replace(sphere, case=case), station))
    assert "made of extruded bodies only: no sub-model shows" in bare
    contact, (front,) = sphere.solution.contacts[0], sphere.contacts[0].fronts
    found = re.search(
        r"slip by up to (\S+) mm, with a friction work of up to (\S+) N·mm/mm²\.", last
    )
    assert found is not None
    angle = np.arctan2(*contact.surface.points[:, [2, 0]].T)
    places = [np.arctan2(*each.point[[2, 0]]) for each in front.stations[:2]]
    # The sectors of two of twelve stations.
    near = np.any([np.cos(angle - each) > np.cos(np.pi / 12) for each in places], axis=0)
    moved = sphere.local_parameters("main")
    for text, values in zip(found.groups(), (moved.slip_range, moved.work), strict=True):
        assert float(text) == pytest.approx(values[near].max(), rel=0.1) and float(text) > 0


def test_nodes_tell_where_there_is_no_plane_problem() -> None:
    assert zone(spread=0.01).told == (0.0412, 0.01)
    assert np.isnan(zone(local=np.nan, spread=0.03).told[0])
    assert zone(local=0.03, local_spread=0.001).told == (0.03, 0.001)


def test_a_table_that_is_wider_is_printed_whole(capsys: pytest.CaptureFixture[str]) -> None:
    print_whole(timing_table({"a phase with a name of a hundred letters " * 3: WIDE}))
    text = capsys.readouterr().out
    assert not cut(text) and max(map(len, text.splitlines())) > WIDTH


def printed(show: Any) -> str:
    console = Console(width=WIDTH, file=io.StringIO())
    show(console)
    text = console.file.getvalue()  # type: ignore[attr-defined]
    assert max(map(len, text.splitlines())) <= WIDTH and not cut(text)
    return str(text)


def test_meshes_of_which_nothing_is_known_have_no_tables() -> None:
    assert refinement_tables(Refinement(0.01, (), False, "fretfe itself failed")) == []


def test_benchmarks_fit() -> None:
    name = "largest difference of K_T and K_S from those of the sphere, over the largest"
    row = Row(
        benchmark="sphere", quantity=name, backend="halfplane", computed=-WIDE, reference=-WIDE,
        difference=-1.2e-13, tolerance=2e-3, verdict=Verdict.AGREES, reason="",
    )  # fmt: skip
    benchmark = SimpleNamespace(name="sphere", source="closed form")
    text = printed(lambda console: print_rows(console, benchmark, [row]))  # type: ignore[arg-type]
    for header in ("computed", "reference", "difference", "tolerance", "verdict"):
        assert header in text
    assert text.count("-1.2346e+05") == 2


def test_validations_fit(sphere: Result) -> None:
    row = Checked(
        contact="a contact", edge="right", quantity="slip zone of the last half cycle by nodes",
        value=-WIDE, reference=-WIDE, tolerance=1.2e-13, verdict=Verdict.DEPENDS, reason="why",
    )  # fmt: skip
    found = Validation(sphere, (row,))
    text = printed(lambda console: print_validation(console, found))
    assert text.count("-123000") == 2 and "depends" in text
    narrow: Any = Console(width=60, file=io.StringIO())
    print_validation(narrow, found)
    text = narrow.file.getvalue()
    assert not cut(text) and Verdict.DEPENDS in text and narrow.width == 60


@pytest.mark.parametrize(
    ("value", "text"),
    [(1.548e4, "1.548e4"), (-1.2e-5, "-1.2e-5"), (3e10, "3e10"), (1e100, "1e100"), (5905, "5905")],
)
def test_exponents_are_short(value: float, text: str) -> None:
    assert number(value) == text and float(text) == value


def test_forces_take_a_prefix() -> None:
    assert with_prefix("N", 9999.0) == (1.0, "N")
    assert with_prefix("N", 20170.0) == (1e3, "kN")
    assert with_prefix("N/mm", 2e7) == (1e6, "MN/mm")
    assert with_prefix("lbf", 2e7) == (1.0, "lbf")


def test_friction_work_is_told_with_its_bar_or_why_not(sphere: Result) -> None:
    contact = replace(sphere.contacts[0], dissipation=2.0, dissipation_spread=0.25)
    assert work_words(contact) == "2.00 ± 0.25"
    wide = replace(contact, dissipation_spread=3.0)
    elements = max(
        zone.told[0] / each.size for each in wide.stations for zone in each.evaluated_zones
    )
    assert work_words(wide) == (
        f"unknown, because its error bar of 3 exceeds it: slip zones have {number(elements, 2)} "
        "elements at most"
    )
    blind = replace(contact, dissipation=0.0, dissipation_spread=math.inf, fronts=())
    text = "unknown, because nodes do not show how far slip goes: no slip zone is seen"
    assert work_words(blind) == text
    shown = " ".join(front_texts(replace(sphere, contacts=(blind,))))
    assert f"The friction work of {blind.name} is {text}." in shown
