# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts in states whose contact is too small for its pressure to tell them, as P falls far."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evaluate.space.test_evaluate import SIZE, STATIONS, grid, hertz, solved

from fretfe._typing import Array
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.space.fronts import BY_OUTLINE, OUTSIDE, FrontTrack, follow_fronts
from fretfe.history.solution import Solution
from fretfe.reason import Kind

# Radii of spheres with a fixed p0/a in turn, as P goes up and down: 6, 14 and 5 elements.
RADII = (0.44, 1.0, 0.36)


@pytest.fixture(scope="module")
def case() -> tuple[Solution, FrontTrack]:
    """A cycle that ends with the smallest contact."""
    points, facets = grid()
    solution, contact = solved(points, facets, [hertz(a, a, peak=a) for a in RADII])
    # Of solved spheres the nodes in contact end that far inside the front, in the mean.
    inner = [hertz(a, a)(points[:, 0], points[:, 2]) for a in np.array(RADII) - OUTSIDE * SIZE]
    traction = np.zeros_like(contact.traction)
    traction[1:, :, 0] = inner
    contact = replace(contact, traction=traction)
    solution = replace(solution, cycle=(1, 3), contacts=(contact,))
    (track,) = follow_fronts(solution, contact, STATIONS)
    return solution, track


def test_the_front_is_that_of_the_largest_contact(case: tuple[Solution, FrontTrack]) -> None:
    _, track = case
    radius = np.linalg.norm(track.front.frames.points[:, [0, 2]], axis=1)
    assert track.state == 2
    np.testing.assert_allclose(radius, 1.0, atol=0.1 * SIZE)
    np.testing.assert_allclose(track.fit.k_n[2], np.sqrt(2), rtol=0.03)


@pytest.mark.parametrize("state", [1, 3])
def test_the_place_of_a_small_contact_is_that_of_its_nodes(
    case: tuple[Solution, FrontTrack], state: int
) -> None:
    """K_N is not, and elements of 1/14 leave what is told of the place open."""
    _, track = case
    place, bar = track.fit.place[state], track.fit.place_spread[state]
    assert np.isnan(track.fit.k_n[state]).all() and np.isinf(track.fit.k_n_spread[state]).all()
    assert np.all(np.abs(place - (1 - RADII[state - 1])) < bar)
    np.testing.assert_allclose(bar, BY_OUTLINE * SIZE, rtol=0.25)


def test_numbers_are_those_of_the_largest_contact_and_say_so(
    case: tuple[Solution, FrontTrack],
) -> None:
    solution, track = case
    (contact,) = evaluate(solution, tracks={"main": (track,)})
    known: Array = np.array([station.decisive_k_n for station in contact.stations])
    assert contact.lack.kind is Kind.NARROW
    assert {(station.first, station.last) for station in contact.stations} == {(1, 2)}
    assert np.all(np.abs(known[:, 0] - np.sqrt(2)) < known[:, 1])
    (found,) = (each for each in contact.warnings if each.kind is Kind.NO_FRONTS)
    assert "K_N is that of state 2, in which the contact is largest" in found.text


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_flight_that_ends_with_next_to_nothing_is_told_where_it_is_loaded(
    case: tuple[Solution, FrontTrack], share: float
) -> None:
    solution, known = case
    (contact,) = solution.contacts
    traction, mean = np.array(contact.traction), np.array(contact.mean_traction)
    traction[3], mean[3] = share * traction[3], share * mean[3]
    ended = replace(contact, traction=traction, mean_traction=mean)
    (track,) = follow_fronts(solution, ended, STATIONS)
    assert track.state == 2
    np.testing.assert_array_equal(track.fit.k_n[2], known.fit.k_n[2])
    (found,) = evaluate(replace(solution, contacts=(ended,)), tracks={"main": (track,)})
    assert found.lack.kind is Kind.NOTHING
