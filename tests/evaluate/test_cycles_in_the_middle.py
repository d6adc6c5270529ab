# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of an evaluated cycle after which the history goes on: those of the cycle alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases.edge_histories import edge_history
from cases.pad_cases import HOLD, TOP, pad, wave

import fretfe
from fretfe.case import Case, parse_case
from fretfe.evaluate.slip import SlipBorder, slip_zones
from fretfe.report.page.tables import contact_table, station_table
from fretfe.results.model import Result

CYCLE = {"start": 3.0, "end": 4.0}


def case(goes_on: bool) -> Case:
    """Three waves of Q; if it goes on, a larger wave, and P that falls to less than half."""
    shear: list[dict[str, Any]] = [HOLD, wave(60.0, cycles=3)]
    press: list[dict[str, Any]] = [{"ramp": -600.0, "until": 1.0, "steps": 4}]
    if goes_on:
        shear += [wave(150.0, cycles=2), {"hold": True, "until": 7.0}]
        press += [{"hold": True, "until": 6.0}, {"ramp": -250.0, "until": 7.0, "steps": 6}]
    loads = {
        "press": {**TOP, "direction": "y", "history": press},
        "shear": {**TOP, "direction": "x", "history": shear},
    }
    return parse_case(pad(loads=loads, cycle=CYCLE), source="a pad")


def printed(result: Result) -> list[list[str]]:
    stations = station_table(result)
    assert stations is not None
    tables = (stations, contact_table(result))
    return [[str(cell) for cell in column.cells] for table in tables for column in table.columns]


def test_what_comes_after_the_cycle_changes_none_of_its_numbers() -> None:
    longer, alone = (fretfe.run(case(each), backend="halfplane") for each in (True, False))
    for one, other in zip(longer.edges(), alone.edges(), strict=True):
        for name, value in other.items():
            # The grid of the longer history is another one.
            expected = value if isinstance(value, str | bool) else pytest.approx(
                value, rel=0.02, abs=1e-5, nan_ok=True
            )  # fmt: skip
            if not name.endswith("spread"):
                assert one[name] == expected, name
    zones = [len(station.slip_zones) for each in longer.contacts for station in each.stations]
    assert zones == [
        len(station.slip_zones) for each in alone.contacts for station in each.stations
    ]


def test_zones_of_a_cycle_after_which_the_contact_opens() -> None:
    k_t = np.array([0.0, 1, -1, 1, -1, 1, np.nan])
    found = slip_zones(
        np.arange(1, 6),
        np.full(7, 0.5),
        edge_history(k_t),
        lambda *_: SlipBorder(0.1, resolved=True, gross=False),
    )
    assert [(zone.start, zone.end) for zone in found] == [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5)]
