# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers that are not told: one typed reason, the same in warnings, rows and tables."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import pad

from fretfe.backends import find_backend
from fretfe.case import parse_case
from fretfe.contact.recorder import ROUND_OFF, Extent
from fretfe.evaluate.contacts import Contact, Station, fronts_of
from fretfe.evaluate.plane.lacks import with_lack
from fretfe.evaluate.warnings import plane_warnings
from fretfe.evaluate.withheld import untouched_hint, withheld
from fretfe.quality.rows import own_rows
from fretfe.reason import Kind, Reason
from fretfe.report.page.tables import station_table
from fretfe.results.model import Result
from fretfe.results.reader import restored
from fretfe.results.tables import edge_records
from fretfe.sweeps.table import _edge_cells


@cache
def solved() -> Result:
    """Half-planes under a steady shear cycle."""
    return find_backend("halfplane").solve(parse_case(pad()))


def changed(**values: Any) -> Result:
    """The run with other numbers at its left edge."""
    (contact,) = solved().contacts
    left, right = contact.stations
    return replace(
        solved(), contacts=(replace(contact, fronts=fronts_of([replace(left, **values), right])),)
    )


def test_each_edge_has_its_own_reason() -> None:
    lack, unknown = Reason(Kind.STEEP, 3, 8), np.full_like(left_of(solved()).k_n, np.nan)
    run = changed(lack=lack, k_n=unknown, k_t_range=math.nan, k_range=math.nan)
    rows = [row for row in own_rows(run) if row.verdict == "unknown"]
    assert [(row.edge, row.quantity, row.reason) for row in rows] == [
        ("left", "K_N", lack.text),
        ("left", "ΔK_T", lack.text),
    ]


def left_of(run: Result) -> Station:
    return run.contacts[0].stations[0]


@pytest.mark.parametrize(
    ("emptied", "kind"), [(slice(-4, -2), Kind.NO_CONTACT), (slice(0, 0), Kind.NOTHING)]
)
def test_a_pad_that_lifts_off_needs_no_finer_elements(emptied: slice, kind: Kind) -> None:
    solution = solved().solution
    (contact,) = solution.contacts
    traction = contact.traction[:].copy()
    traction[emptied] = 0.0
    parted = replace(contact, traction=traction)
    place = left_of(solved()).position.copy()
    place[emptied] = np.nan
    station = replace(left_of(solved()), position=place, k_range_spread=np.nan)
    found = with_lack(solution, parted, station) if kind is not Kind.NOTHING else station
    assert found.lack.kind is kind
    if kind is Kind.NO_CONTACT:
        assert math.isnan(found.k_t_range) and math.isnan(found.k_range)
        states = solution.cycle[1] - solution.cycle[0] + 1 if solution.cycle else 0
        assert (found.lack.found, found.lack.wanted) == (states - 2, states)
        first, *_ = plane_warnings(solution, parted, fronts_of([found]), [np.nan], slides=False)
        assert (first.kind, first.subject.front) == (Kind.FACTORS_UNKNOWN, "left")
        assert first.text == f"the range of K_T unknown, because {found.lack.text}"
        assert "smaller" not in first.text


@pytest.mark.parametrize("part", [0.4, 0.6])
def test_a_range_without_a_word_is_within_half_of_itself(part: float) -> None:
    run = solved()
    (contact,) = run.solution.contacts
    bar = part * left_of(run).k_range
    parts = replace(left_of(run).k_range_parts, extraction=bar)
    found = replace(left_of(run), k_range_spread=bar, k_range_parts=parts)
    told = plane_warnings(run.solution, contact, fronts_of([found]), [np.nan], slides=False)
    unknown = [each.text for each in told if each.kind is Kind.FACTORS_UNKNOWN]
    assert len(unknown) == math.isnan(found.reported_range) == (part > 0.5)
    assert all(withheld(found).text == text for text in unknown)


def test_a_reason_is_restored() -> None:
    given = Reason(Kind.FEW_NODES, 5, 16)
    table = {"kind": "few nodes", "found": 5, "wanted": 16, "words": ""}
    assert restored(Reason, table) == given
    assert "make the elements at least 3.5 times smaller" in given.text


@pytest.mark.parametrize(
    "kind",
    [
        Kind.ABSENT, Kind.NO_CONTACT, Kind.FEW_NODES, Kind.SURFACE_ENDS, Kind.STEEP, Kind.NO_ROOT,
        Kind.NO_TRACTIONS, Kind.FREE_END, Kind.NO_BORDER, Kind.NARROW, Kind.CUT, Kind.SHORT_BORDER,
        Kind.NO_CURVE,
    ],
)  # fmt: skip
def test_every_kind_has_a_sentence(kind: Kind) -> None:
    given = Reason(kind, 1, 8)
    assert len(given.text) > 20 and not given.whole
    assert "{" not in given.text and given.text.endswith(given.advice)


@pytest.mark.parametrize("kind", [Kind.NO_EDGE, Kind.LOST, Kind.FAULT])
def test_where_nothing_is_known_the_reason_has_its_own_words(kind: Kind) -> None:
    given = Reason(kind, 1, 8, words="the bodies go on behind it")
    assert given.whole and given.text == given.words


def test_sweeps_and_runs_mark_alike() -> None:
    k_n = left_of(solved()).decisive_k_n[0]
    spread = np.full_like(left_of(solved()).k_n, 0.1 * k_n)
    contact = changed(k_n_spread=spread).contacts[0]
    in_run, in_sweep = cells(contact), _edge_cells(records(contact)[0])[1:]
    assert in_run == in_sweep
    assert [each.startswith("~") for each in in_run] == [True, False, False, True]


def test_nothing_is_predicted_without_k_n() -> None:
    k_n = left_of(solved()).decisive_k_n[0]
    contact = changed(k_n_spread=np.full_like(left_of(solved()).k_n, 0.6 * k_n)).contacts[0]
    in_run, in_sweep = cells(contact), _edge_cells(records(contact)[0])[1:]
    assert (in_run[0], in_run[3]) == (in_sweep[0], in_sweep[3]) == ("-", "-")


def cells(contact: Contact) -> list[str]:
    """K_N, ΔK_T, slip zones and predictions of the left edge, as a run prints them."""
    table = station_table(replace(solved(), contacts=(contact,)))
    assert table is not None
    return [str(next(iter(column.cells))) for column in table.columns][3:]


def records(contact: Contact) -> list[dict[str, Any]]:
    return edge_records([contact])


def test_gaps_of_chords_are_no_fault_of_the_loads() -> None:
    # A circle of R = 10 h leaves h/80 between its chord and itself.
    weights = np.full(30, 0.1)
    assert "chords" in untouched_hint(1.0, 0.1 / 80, weights, 2)
    assert "chords" in untouched_hint(1.0, 0.1 / 80, weights**2, 3)
    assert "signs" in untouched_hint(0.1, 0.1, weights, 2)
    # loads of the right sign that do not suffice
    assert "from a gap of 0.2 without them, but not far" in untouched_hint(0.2, 0.1, weights, 2)


def test_one_runaway_state_does_not_undo_the_others() -> None:
    interface = SimpleNamespace(
        roots=np.ones(2), motion=np.ones(1), compliance=SimpleNamespace(level=1.0)
    )

    def state(pressure: float, motion: float) -> Any:
        return SimpleNamespace(
            relative=np.zeros((2, 2)),
            coordinates=np.array([motion]),
            traction=np.array([[pressure, 0.0], [0.0, 0.0]]),
        )

    extent = Extent()
    extent.add(interface, state(0.0, 0.0))  # type: ignore[arg-type]
    assert not extent.carried > ROUND_OFF
    extent.add(interface, state(1.0, 1.0))  # type: ignore[arg-type]
    extent.add(interface, state(0.0, 1e20))  # type: ignore[arg-type]
    assert extent.carried > ROUND_OFF
