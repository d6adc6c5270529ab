# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a mesh or a model does not carry is said to be unknown, with the reason, and never zero."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from cases.pad_cases import cylinder, pad

from fretfe.backends import find_backend
from fretfe.case import parse_case
from fretfe.evaluate.contacts import Contact, Station
from fretfe.quality.validation import summary, validate
from fretfe.results.model import Result
from fretfe.results.writer import write_results

EXACT_RANGE = 35.6  # 2 K_T of Q = 60 on a half-width of .5749, eq. (4)
EXACT_K_N = 1239.2  # 2 P/(π a) √(2/a) of Hertz, P = 600
CONTACT = pad()["contacts"]["main"]


def rough(size: float) -> dict[str, Any]:
    return pad(geometry=cylinder(size=size), contacts={"main": {**CONTACT, "friction": 0.5}})


@pytest.fixture(scope="module", params=[0.25, 0.15, 0.075], ids=str)
def coarse(request: pytest.FixtureRequest, solved: Any) -> Result:
    result: Result = solved(rough(request.param))
    return result


def texts_of(contact: Contact, station: Station) -> list[str]:
    return [each.text for each in contact.warnings if each.subject.front == station.front]


def test_factors_of_few_elements_are_unknown_or_right(coarse: Result) -> None:
    contact = coarse.contacts[0]
    for station in contact.stations:
        if math.isnan(station.k_t_range):
            assert any("range of K_T unknown" in text for text in texts_of(contact, station))
        else:
            assert abs(station.k_t_range - EXACT_RANGE) <= station.k_range_spread
        if math.isnan(station.k_n[-1]):
            texts = texts_of(contact, station)
            assert any("are wanted: make the elements at least" in text for text in texts)
        else:
            assert abs(station.k_n[-1] - EXACT_K_N) <= station.k_n_spread[-1]
            assert any("K_N" in text for text in texts_of(contact, station))


def test_integrals_know_what_no_fit_does(solved: Any) -> None:
    """With 11 nodes in contact."""
    contact = solved(rough(0.105)).contacts[0]
    for station in contact.stations:
        assert math.isnan(station.k_t_range_fitted)
        assert station.reported_range == pytest.approx(EXACT_RANGE, rel=0.05)
        assert station.k_range_spread > abs(station.k_t_range - EXACT_RANGE)


def test_unknown_is_null_in_the_results(coarse: Result, tmp_path: Path) -> None:
    write_results(tmp_path, coarse)
    (contact,) = json.loads((tmp_path / "results.json").read_text("utf-8"))["contacts"].values()
    for edge, station in zip(
        (each["stations"][0] for each in contact["fronts"]),
        coarse.contacts[0].stations,
        strict=True,
    ):
        assert (edge["k_t_range"] is None) == math.isnan(station.k_t_range)
        assert (edge["k_n"][-1] is None) == math.isnan(station.k_n[-1])


def test_unknown_passes_no_check() -> None:
    validation = validate(parse_case(rough(0.25)), find_backend("fem"))
    verdicts = {row.verdict for row in validation.rows if row.quantity in ("K_N", "ΔK_T")}
    assert verdicts == {"unknown"}
    assert not validation.passed
    assert summary(validation).endswith("nothing can be said of this case before they are known.")
