# SPDX-License-Identifier: LGPL-3.0-or-later
"""K_N by the moving edge fails a run only where the movement is known well enough to tell."""

from __future__ import annotations

from dataclasses import replace

import pytest
from cases.pad_cases import pad

from fretfe.backends import find_backend
from fretfe.case import parse_case
from fretfe.quality.rows import own_rows
from fretfe.results.model import Result


@pytest.fixture(scope="module")
def result() -> Result:
    return find_backend("halfplane").solve(parse_case(pad()))


@pytest.mark.parametrize(
    ("share", "spread", "verdict"),
    [
        (1.0, 0.0, "agrees"),
        (1.07, 0.0, "differs"),
        (1.07, 0.17, "agrees"),
        (1.07, 0.4, "no verdict"),
    ],
    ids=["equal", "off", "pin in a hole", "edge that hardly moves"],
)
def test_the_bar_of_the_movement_counts(
    result: Result, share: float, spread: float, verdict: str
) -> None:
    (contact,) = result.contacts
    changed = []
    for front in contact.fronts:
        (station,) = front.stations
        moved = share * float(station.k_n[-1])
        station = replace(station, k_n_moved=moved, k_n_moved_spread=spread * moved)
        changed.append(replace(front, stations=(station,)))
    other = replace(result, contacts=(replace(contact, fronts=tuple(changed)),))
    rows = [row for row in own_rows(other) if row.quantity == "K_N, by moving edge"]
    assert [row.verdict for row in rows] == [verdict] * 2
