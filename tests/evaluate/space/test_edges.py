# SPDX-License-Identifier: LGPL-3.0-or-later
"""K_N by the movement of a front, from exact pressures at two loads and the exact K_I."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from evaluate.space.test_evaluate import STATIONS, grid, hertz, means, solved

from fretfe.evaluate.space.edges import (
    AWAY,
    NO_FRONT,
    NO_LOADS,
    POOR,
    STANDS,
    moved_stations,
)
from fretfe.evaluate.space.evaluate import evaluate_fronts
from fretfe.evaluate.space.fronts import FrontTrack, follow_fronts
from fretfe.history.solution import ContactHistory, NearbyLoads, Solution

# p0 / a of the sphere: p = sqrt(a² - r²), P = 2π a³/3, K_N = sqrt(2 a).
LOADS = 0.95, 1.05
K_I = (LOADS[1] - LOADS[0]) * (2 * np.pi / 3) / (2 * np.pi * np.sqrt(2))
Case = tuple[Solution, ContactHistory, FrontTrack]


@pytest.fixture(scope="module")
def case() -> Case:
    """A sphere, a = 1, and its neighbours; K_I in two ways that are 2 % apart."""
    points, facets = grid()
    solution, contact = solved(points, facets, [hertz(1.0, 1.0)])
    radii = np.cbrt(LOADS)
    pressure = np.array([means(points, facets, hertz(a, a, peak=a))[0] for a in radii])
    k_i = K_I * np.array([[0.99], [1.01]]) * np.ones(STATIONS)
    contact = replace(contact, nearby_loads=NearbyLoads(pressure, k_i))
    (track,) = follow_fronts(solution, contact, STATIONS)
    return replace(solution, contacts=(contact,)), contact, track


def reasons(case: Case, **changes: Any) -> set[str]:
    _, contact, track = case
    assert contact.nearby_loads is not None
    changed = replace(contact, nearby_loads=replace(contact.nearby_loads, **changes))
    return {each.reason for each in moved_stations(changed, track.front, slice(0, STATIONS))}


def test_sphere(case: Case) -> None:
    _, contact, track = case
    moved = moved_stations(contact, track.front, slice(0, STATIONS))
    errors = np.array([each.k_n for each in moved]) / np.sqrt(2) - 1
    spreads = np.array([each.spread for each in moved]) / np.sqrt(2)
    assert {each.reason for each in moved} == {""}
    assert np.abs(errors).max() < 0.04 and abs(errors.mean()) < 0.01
    assert np.all(np.abs(errors) < spreads) and spreads.max() < 0.25
    # The two ways to find K_I, and the ragged border of the nodes, at least.
    assert spreads.min() > np.hypot(0.01, 0.6 / 14)


def test_stations_have_it_and_their_bar_of_k_n_knows_it(case: Case) -> None:
    solution, contact, track = case
    (front,) = evaluate_fronts(solution, contact, (track,))
    station = front.stations[3]
    assert station.k_n_moved == pytest.approx(np.sqrt(2), rel=0.03)
    assert station.k_n_spread[-1] == track.fit.k_n_spread[-1, 3]  # the fits agree: theirs
    loose = track.fit.k_n_spread.copy()
    loose[-1, 3] = 0.08 * track.fit.k_n[-1, 3]
    k_n = track.fit.k_n.copy()
    k_n[-1, 3] *= 1.2
    fit = replace(track.fit, k_n=k_n, k_n_spread=loose)
    (front,) = evaluate_fronts(solution, contact, (replace(track, fit=fit),))
    station = front.stations[3]
    # At least that: its neighbours, whose K_N is none of this, widen it further.
    assert station.k_n_spread[-1] > (1 - 1e-6) * (k_n[-1, 3] - station.k_n_moved)


def test_reasons(case: Case) -> None:
    _, contact, track = case
    assert contact.nearby_loads is not None
    low, high = contact.nearby_loads.pressure
    assert reasons(case, k_i=np.full((2, STATIONS), np.nan)) == {NO_FRONT}
    assert reasons(case, pressure=np.array([high, low])) == {STANDS}
    assert reasons(case, pressure=np.array([low, low])) == {STANDS}
    assert reasons(case, k_i=contact.nearby_loads.k_i * [[0.1], [1.9]]) == {POOR}
    points, facets = grid()
    wide = means(points, facets, hertz(1.09, 1.09, peak=1.09))[0]
    assert reasons(case, pressure=np.array([low, wide])) == {AWAY}
    none = moved_stations(replace(contact, nearby_loads=None), track.front, slice(0, STATIONS))
    assert {each.reason for each in none} == {NO_LOADS}
    assert all(np.isnan([each.k_n, each.spread]).all() for each in none)
    assert len(none) == len(track.front.sectors)
