# SPDX-License-Identifier: LGPL-3.0-or-later
"""Lengths of slip zones that stand alone for a station or have no formula; reversals of K_T."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases.solid_runs import stationed_sphere
from cases.stored_runs import solved

from fretfe.evaluate.contacts import Front, SlipZone, Station, without_formulas
from fretfe.evaluate.verdicts import longest_verdict
from fretfe.results.tables import station_records


def zone(end: int, length: float, predicted: float, local: float = math.nan) -> SlipZone:
    """A resolved zone of two steps."""
    return SlipZone(
        start=end - 2, end=end, length=length, border=length, spread=length / 20, resolved=True,
        gross=False, predicted=predicted, predicted_loop=predicted, local=local,
        local_spread=0.03 * local,
    )  # fmt: skip


@pytest.fixture
def station() -> Station:
    """Of a cycle that begins with state 8, with three half cycles in it and one before."""
    found = stationed_sphere().contacts[0].stations[0]
    known: dict[str, Any] = {
        "k_n": np.ones_like(found.k_n),
        "k_n_spread": np.full_like(found.k_n, 0.02),
    }
    known |= {"k_range": 1.0, "k_range_spread": 0.02}
    zones = (zone(8, 0.5, 0.5), zone(10, 0.2, 0.18), zone(12, 0.1, 0.21), zone(14, 0.15, 0.1))
    return replace(found, **known, first=8, slip_zones=zones, turning=0.0)


def record(station: Station) -> dict[str, float]:
    """Its row."""
    contact = stationed_sphere().contacts[0]
    front = Front("front 1", (station,), length=1.0)
    return station_records([replace(contact, fronts=(front,))])[0]


def test_each_is_the_largest_of_all_half_cycles_of_the_cycle(station: Station) -> None:
    """Not that of the last two, nor that of first loading; none is tied to another one's zone."""
    row = record(station)
    assert station.longest_zone is station.slip_zones[1]
    assert (row["slip"], row["predicted"]) == (0.2, 0.21)
    assert row["slip_spread"] == pytest.approx(0.01)
    assert (row["slip_1"], row["slip_2"]) == (0.1, 0.15)


def test_what_is_not_known_of_the_longest_is_not_told(station: Station) -> None:
    lost = replace(station.slip_zones[1], length=0.25, spread=0.2)
    *zones, last = station.slip_zones
    row = record(replace(station, slip_zones=(zones[0], lost, zones[2], last)))
    assert math.isnan(row["slip"]) and row["predicted"] == 0.21


def test_without_a_cycle_all_count(station: Station) -> None:
    assert record(replace(station, first=-1))["slip"] == 0.5


def test_nothing_is_predicted_where_k_turns(station: Station) -> None:
    """Q that turns at constant size: no formula, in no table, and the reason is there."""
    turning = without_formulas(replace(station, turning=0.9))
    row = record(turning)
    assert all(math.isnan(row[name]) for name in ("predicted", "predicted_1", "predicted_2"))
    assert np.isnan(turning.cycles.slip).all()
    assert row["slip"] == 0.2
    assert longest_verdict(turning).reason.startswith("the direction of K_T and K_S turns")
    assert without_formulas(station) is station


def test_reversals_are_those_of_range_and_mean() -> None:
    """K_T of the states where these are ends of steps; half the range about the mean within."""
    station = solved("halfplane").contacts[0].stations[1]
    cycles = station.cycles
    ends = np.array([station.k_along[cycles.start], station.k_along[cycles.end]])
    assert station.reversals == pytest.approx(ends)
    within = replace(station, cycles=replace(cycles, k_t_range=1.5 * cycles.k_t_range))
    assert np.abs(np.diff(within.reversals, axis=0)[0]) == pytest.approx(1.5 * cycles.k_t_range)
    assert within.reversals.mean(axis=0) == pytest.approx(cycles.k_t_mean)
