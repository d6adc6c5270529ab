# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction work between two states, node by node."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.contact.state import OPEN, SLIP, STICK, ContactState, friction_work

FRICTION = 0.5


def state(status: list[int], pressure: list[float], moved: list[float], way: float) -> ContactState:
    """Nodes of which those that slip have their shear against `way`; the others carry none."""
    kinds = np.array(status, np.int8)
    p, slips = np.array(pressure), kinds == SLIP
    direction = np.where(slips, -way, 0.0)[:, None]
    traction = np.column_stack([p, FRICTION * p * direction[:, 0]])
    relative = np.column_stack([np.zeros(len(p)), moved])
    return ContactState(kinds, direction, traction, relative, np.zeros(0), np.zeros(0))


def work(before: ContactState, after: ContactState, *contacts: slice) -> Array:
    every = contacts or (slice(0, len(after.status)),)
    count = len(after.status)
    return friction_work(before, after, FRICTION * np.ones(count), every, np.ones(count))


def test_pressure_on_the_way_of_slip_that_goes_on_begins_and_turns() -> None:
    """Means of p from 2 to 4: 1/2, and 3/4 of the change as of a zone that grows from the edge."""
    before = state([SLIP, STICK, SLIP, STICK], [2.0] * 4, [0.0] * 4, 1.0)
    before.direction[2] *= -1
    after = state([SLIP, SLIP, SLIP, STICK], [4.0] * 4, [0.1, 0.1, 0.1, 1e-18], 1.0)
    assert work(before, after) == pytest.approx(
        0.5 * 0.1 * np.array([3.0, 3.5, 3.5, 0.0]), rel=1e-12
    )


def test_a_constant_pressure_gives_the_shear_times_the_slip() -> None:
    before, after = (
        state([SLIP, SLIP], [3.0, 1.0], moved, 1.0) for moved in ([0.0, 0.0], [0.2, 0.1])
    )
    expected = -after.traction[:, 1] * after.relative[:, 1]
    assert work(before, after) == pytest.approx(expected, rel=1e-12)


def test_nodes_that_touch_or_part_on_the_way_slip_no_farther_than_those_in_contact() -> None:
    before = state([SLIP, OPEN, SLIP], [2.0, 0.0, 1.0], [0.0] * 3, 1.0)
    after = state([SLIP, SLIP, OPEN], [2.0, 1.0, 0.0], [0.1, 0.1, 7.0], 1.0)
    # 2/5 of f p of the side on which they are in contact.
    assert work(before, after) == pytest.approx([0.1, 0.02, 0.02], rel=1e-12)
    # In a contact of its own that parts as a whole they do none.
    assert work(before, after, slice(0, 2), slice(2, 3))[2] == 0.0


def test_bodies_that_meet_while_they_move_do_no_work_before() -> None:
    before = state([OPEN] * 2, [0.0] * 2, [0.0] * 2, 1.0)
    after = state([SLIP] * 2, [2.0] * 2, [50.0] * 2, 1.0)
    assert work(before, after).tolist() == [0.0, 0.0]
