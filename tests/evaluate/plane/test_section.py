# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts and sections of a plane contact: distances, places, frames, and what evaluation makes."""

from __future__ import annotations

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, problem

from fretfe.analytic.edges import tangential_factor
from fretfe.evaluate.contacts import Contact, fronts_of
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.plane.section import PLANE_FRONTS, PlaneFront, plane_front, plane_sections
from fretfe.evaluate.plane.unit_factors import half_plane_units
from fretfe.halfplane import solve_half_planes
from fretfe.history.solution import Factor

fronts = pytest.mark.parametrize("front", PLANE_FRONTS, ids=lambda front: front.name)
X = np.array([0.0, 1.0, 3.0, 4.0, 8.0, 9.0])
# Two states; the second one has a patch that carries less.
PRESSURE = np.array([[0.0, 1.0, 2.0, 5.0, 0.0, 0.0], [0.5, 0.0, 0.0, 4.0, 3.0, 0.0]])


def test_sections_run_inward_through_the_main_patch() -> None:
    left, right = plane_sections(X, PRESSURE)
    assert left.nodes.tolist() == right.nodes.tolist() == [3, 2]
    np.testing.assert_array_equal(left.s, [[0, 2, 3], [0, 4, np.nan]])
    np.testing.assert_array_equal(right.s, [[0, 1, 3], [0, 4, np.nan]])
    np.testing.assert_array_equal(left.values, [[1, 2, 5], [4, 3, 0]])
    np.testing.assert_array_equal(right.values, [[5, 2, 1], [3, 4, 0]])
    # half an element outside the outermost nodes
    assert left.place(np.array([-0.5, -0.5])).tolist() == [0.5, 3.5]
    assert right.place(np.array([-0.5, -0.5])).tolist() == [4.5, 8.5]


def test_some_states_of_a_section() -> None:
    _, right = plane_sections(X, PRESSURE)
    second = right.of_states(np.array([1]))
    assert (second.nodes.tolist(), second.place(np.zeros(1)).tolist()) == ([2], [8.0])


@fronts
def test_distances_and_places_undo_each_other(front: PlaneFront) -> None:
    edge = -1.0 if front.name == "left" else 10.0
    s = front.distances(X, edge)
    assert np.all(np.diff(s) > 0) and s[0] >= 1.0
    assert (edge + front.inward * s).tolist() == front.from_front(X).tolist()


@fronts
def test_frames_are_right_handed(front: PlaneFront) -> None:
    # a flank of 30 degrees, vectors of any length
    tangent = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    frame = front.frame(across=2 * np.array([-tangent[1], tangent[0]]), tangent=3 * tangent)
    rows = np.array([frame.inward, frame.along, frame.across])
    assert rows @ rows.T == pytest.approx(np.eye(3), abs=1e-15)
    assert np.linalg.det(rows) == pytest.approx(1.0)
    assert frame.inward[:2] == pytest.approx(front.inward * tangent)
    assert frame.along == pytest.approx([0.0, 0.0, -front.inward])


def test_an_unknown_front() -> None:
    with pytest.raises(ValueError, match="front must be 'left' or 'right', found 'top'"):
        plane_front("top")


@pytest.fixture(scope="module")
def contact() -> Contact:
    outcome = solve_half_planes(problem(np.full(8, LOAD), np.linspace(0.0, 0.2 * LIMIT, 8)))
    return evaluate(outcome.solution, outcome.unit_factors)[0]


def test_a_plane_contact_has_two_fronts_of_one_station(contact: Contact) -> None:
    assert [front.name for front in contact.fronts] == ["left", "right"]
    assert [(each.front, each.number) for each in contact.stations] == [("left", 0), ("right", 0)]
    assert fronts_of(contact.stations) == contact.fronts


def test_the_shear_factor_is_along_inward(contact: Contact) -> None:
    for station, direction in zip(contact.stations, (1.0, -1.0), strict=True):
        assert station.frame.inward == pytest.approx([direction, 0.0, 0.0])
        # Q acts along x on body 2
        assert np.sign(station.k_t[-1]) == direction
        assert not np.any(station.k_s)


@fronts
def test_unit_factors_are_in_the_order_of_the_traction(front: PlaneFront) -> None:
    units = half_plane_units(np.array([[-2.0], [2.0]]))[0, front.number]
    assert units.shape == (2, 4)
    # loads P, M, Q, sigma0; the pressure has K_I, the shear K_T
    assert units[Factor.K_I, 2:].tolist() == units[Factor.K_T, :2].tolist() == [0.0, 0.0]
    assert units[Factor.K_T, 2] == tangential_factor(1.0, 0.0, 2.0, front.name)
