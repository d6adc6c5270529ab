# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random cases with known answers: no number is wrong without a word, and error bars hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from campaign.draw import MIDDLE, MISSION, MOVING, SWEPT, case_of, draw, draw_moving, with_mission
from campaign.extent import SEED
from campaign.judge import QUANTITIES, Judged, judge_case
from campaign.known_zones import COUNT, stored_zones, zones_by_half_planes
from campaign.tables import RESOLVED, tables

from fretfe.case import parse_case
from fretfe.loads import build_history

# Elements over the half-width from which on bars are to be sharp.
SHARP = 20


@pytest.fixture(scope="module")
def judged() -> list[Judged]:
    return [each for number in range(COUNT) for each in judge_case(number)]


@pytest.mark.slow
def test_no_number_is_silently_wrong(judged: list[Judged]) -> None:
    assert [each.text for each in judged if each.verdict == "wrong"] == []


@pytest.mark.slow
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_error_bars_hold_and_are_no_larger_than_needed(judged: list[Judged], quantity: str) -> None:
    given = [e for e in judged if e.quantity == quantity and np.isfinite(e.value)]
    assert len(given) > COUNT / 2
    assert np.mean([each.error <= each.bar for each in given]) >= 0.95
    resolved = [e for e in given if e.draw.per_half_width >= SHARP and e.truth and e.value]
    bar = np.median([each.bar / each.truth for each in resolved])
    error = np.median([abs(each.value / each.truth - 1) for each in resolved])
    assert bar <= 6 * error


@pytest.mark.slow
def test_meshes_as_they_are_advised_give_numbers(judged: list[Judged]) -> None:
    resolved = [each for each in judged if each.draw.per_half_width >= RESOLVED]
    assert np.mean([np.isfinite(each.value) for each in resolved]) >= 0.9


@pytest.mark.slow
def test_tables(judged: list[Judged]) -> None:
    text = tables(judged)
    assert text.startswith(f"All {COUNT} cases:")
    for quantity in QUANTITIES:
        (row, _, *rows) = (line for line in text.splitlines() if line.startswith(f"| {quantity} |"))
        given, right, flagged, wrong = (cell.strip() for cell in row.split("|")[2:6])
        assert int(given.split(" of ")[1]) == int(right) + int(flagged) + int(wrong)
        assert all(len(each.split("|")) == 10 for each in rows)
        counts = [int(each.split("|")[3].split(" of ")[1]) for each in rows]
        assert sum(counts) == int(given.split(" of ")[1])


@pytest.mark.slow
def test_stored_answers_are_those_of_half_planes() -> None:
    """Of another case each week."""
    number = SEED % COUNT
    solved = zones_by_half_planes(draw(number))
    for stored, zones in zip(stored_zones()[number], solved, strict=True):
        assert [zone.counts for zone in stored] == [zone.counts for zone in zones]
        one, other = (np.array([[x.end, x.length] for x in each]) for each in (stored, zones))
        np.testing.assert_allclose(one, other, rtol=1e-4)


@pytest.mark.parametrize("kind", MOVING)
def test_moving_loads_are_drawn_as_they_are_meant(kind: str, tmp_path: Path) -> None:
    one = next(each for each in map(draw_moving, range(40)) if each.kind == kind)
    tables = case_of(one)
    case = parse_case(with_mission(tables, one, tmp_path) if kind == MISSION else tables)
    loads, fine = build_history(case), build_history(parse_case(case_of(one, 360)))
    assert loads.cycle is not None and fine.cycle is not None
    # The same loads at the same times, whoever solves them.
    ends = [each.times[list(each.cycle or ())] for each in (loads, fine)]
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-9)
    for column in range(loads.values.shape[1]):
        at = np.interp(loads.times, fine.times, fine.values[:, column])
        np.testing.assert_allclose(at, loads.values[:, column], atol=1e-6 * np.abs(at).max())
    normal, shear = (loads.values[loads.times >= 1, column] for column in (0, 1))
    assert (normal < 0).all() and (np.abs(shear) <= 0.9 * one.friction * -normal).all()
    if kind == SWEPT:
        assert np.max(normal) > 0.2 * np.min(normal)
    assert (loads.cycle[1] < len(loads.times) - 1) == (kind == MIDDLE)
