# SPDX-License-Identifier: LGPL-3.0-or-later
"""Margins along a front by stations of a run and of the sub-model of a free end."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cases.solid_runs import straight, with_stations
from decision.test_material import write

from fretfe.decision import end_parts as ends
from fretfe.decision import front_stations as module
from fretfe.decision.assess import assess
from fretfe.decision.assessment import Assessment, Criterion
from fretfe.decision.field import EdgeField, SmoothStress
from fretfe.decision.near_field import NearField
from fretfe.decision.texts import details
from fretfe.evaluate.contacts import Contact, Station
from fretfe.results.end_answers import Compared, EndAnswer, Meeting
from fretfe.results.model import Result

NAME = "main.1.start"
# Distances of the stations of the sub-model that hold; those of both are .125, .375, .625 and on.
DISTANCES = np.array([0.375, 0.625])


def known(station: Station) -> Station:
    """With K_N, whose bar is that of a run."""
    k_n = np.full(len(station.k_n), 100.0)
    return replace(station, k_n=k_n, k_n_spread=0.2 * k_n)


def whole() -> Result:
    """A front along which stations are known from .5 on, in a folder."""
    return replace(with_stations(straight(mirrored=False), known), directory=Path("run"))


def part() -> Result:
    """The same front, known from .2 on."""
    return with_stations(whole(), lambda each: replace(each, end=each.to_end < 0.2))


def field(station: Station, stress: float, body: int) -> EdgeField:
    """A reversed uniaxial stress along the surface."""
    values, none = np.zeros((2, 1, 6)), np.zeros((2, 3))
    values[:, 0, 0] = stress, -stress
    return EdgeField(
        "main", f"{station.front}.{station.number}", ("upper", "lower")[body], np.arange(2), 0.0,
        NearField(np.array([-1.0, 0.0, 1.0]), none, none, 0.3, none),
        SmoothStress(np.zeros((1, 2), dtype=np.int64), 1.0, values, 0.0, 1.0, (1.0, 1.0)),
    )  # fmt: skip


@pytest.fixture
def assessed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, part_stress: float | str, agrees: bool
) -> Assessment:
    """124 MPa at all stations of the run, more at those of the sub-model, or a reason."""
    k_range = Compared(9.375, 0.1, 9.375 if agrees else 8.0, 0.1)
    meeting = Meeting("main.1.2", 0.625, k_range, Compared(100.0, 1.0, 100.0, 1.0))
    answer = EndAnswer(
        NAME, np.zeros(3), DISTANCES, 10 - DISTANCES, np.full(2, 0.3), np.full(2, 100.0),
        np.full(2, 4.0), DISTANCES, 0.1, 0.01, 0.3, (), (meeting,),
    )  # fmt: skip
    run, own = whole(), part()

    def fields(result: Result, contact: Contact, _: object) -> object:
        stress = part_stress if result is own else 124.0
        for each in contact.stations:
            reason = "too near" if each.end else stress
            if isinstance(reason, str):
                yield each, (reason, reason)
            else:
                yield each, (field(each, reason, 0), field(each, reason, 1))

    monkeypatch.setattr(module, "station_fields", fields)
    monkeypatch.setattr(ends, "read_answers", lambda _: [answer])
    monkeypatch.setattr(ends, "load_result", lambda _: own)
    monkeypatch.setattr(Result, "has_station_stress", True)
    return assess(run, write(tmp_path))


@pytest.mark.parametrize(("part_stress", "agrees"), [(155.0, True)])
def test_the_worst_place_of_a_front_may_be_at_its_end(assessed: Assessment) -> None:
    """The fatigue limit is 248 MPa: margins are 2 along the front, and 1.6 beside the end."""
    for edge in assessed.edges:
        judgement = edge.of(Criterion.CROSSLAND)
        assert judgement.margin == pytest.approx(248 / 155, rel=2e-3)
        assert (judgement.end, judgement.station, judgement.to_end) == (NAME, 1, 0.375)
        # Its bar is that by both sub-models.
        assert edge.bar == pytest.approx(math.hypot(0.3 / 9.625, 4.0 / 100.0), rel=1e-6)
        # The first station of the run is within the sub-model, whose remark tells what is nearer
        # than its own; another end has none.
        assert edge.lost == {"too near": (10, 11)}
        # The radius of the front is 1, and its end nearer.
        assert (edge.depth, edge.straight) == (1.0, 0.375)
    # Of the other end nothing is known.
    assert not assessed.keeps(0.1)
    first = assessed.edges[0]
    inside = replace(first.of(Criterion.CROSSLAND), outermost=False)
    judged = replace(first, judgements=(first.judgements[0], inside))
    assert not replace(assessed, edges=(judged,)).keeps(1.59)
    assert replace(assessed, edges=(replace(judged, lost={}),)).keeps(1.59)
    assert any("down to 1 mm, 267% of the radius" in each for each in details(assessed))
    assert any(
        "nearer than 0.375 to the free end main.1.start" in each for each in assessed.remarks
    )


@pytest.mark.parametrize(("part_stress", "agrees"), [(100.0, True)])
def test_the_worst_place_may_be_elsewhere(assessed: Assessment) -> None:
    for edge in assessed.edges:
        judgement = edge.of(Criterion.CROSSLAND)
        assert judgement.margin == pytest.approx(2, rel=2e-3)
        # The sub-model stands for the stations 1 and 2.
        assert (judgement.end, judgement.station) == ("", 3) and math.isnan(judgement.to_end)


@pytest.mark.parametrize(
    ("part_stress", "agrees", "lost", "remark"),
    [
        (155.0, False, {"too near": (0, 1, 10, 11)}, "it differs from the run at main.1.2"),
        ("no plane problem", True, {
            "too near": (10, 11), f"by the sub-model of {NAME}: no plane problem": (1, 2)
        }, "nearer than"),
    ],
)  # fmt: skip
def test_sub_models_that_do_not_hold(
    assessed: Assessment, lost: dict[str, tuple[int, ...]], remark: str
) -> None:
    assert all(edge.lost == lost for edge in assessed.edges)
    assert assessed.worst is not None
    assert assessed.worst[1].margin == pytest.approx(2, rel=0.06)
    assert any(remark in each for each in assessed.remarks)
