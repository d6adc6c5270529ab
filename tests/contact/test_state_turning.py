# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ways from state to state of two nodes, on which a contact begins to slide, or parts."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.contact.state import SLIP, STICK, ContactState, turns

FRICTION, NODES = 0.5, slice(0, 2)


def state(normal: float, shear: float, place: float, status: int = SLIP) -> ContactState:
    """Two nodes under the same P and Q, at the same place along the contact."""
    return ContactState(
        status=np.full(2, status, np.int8),
        direction=np.full((2, 1), np.sign(shear)),
        traction=np.full((2, 2), [normal, shear]),
        relative=np.full((2, 2), [0.0, place]),
        coordinates=np.empty(0),
        forces=np.empty(0),
    )


# Body 2 has slid backward, against a shear that drives it forward.
SLID = state(1.0, 0.5, -1.0)


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        (SLID, state(2.0, 1.0, -2.0), False),  # goes on
        (SLID, state(2.0, -1.0, 0.0), True),  # slides back under the larger P of a flank that jams
        (SLID, state(1.0, -0.5, 0.0), False),  # P is the same: the ends of the step know it all
        (SLID, state(2.0, 0.0, -1.0, STICK), False),
        (state(1.0, 0.0, 0.0, STICK), state(2.0, 1.0, -1.0), True),
        (state(0.0, 0.0, 0.0), state(1.0, 0.5, -1.0), True),  # from no load: the way is not known
        (SLID, state(0.0, 0.0, 0.0), True),
        (state(0.02, 0.01, -1.0), state(0.0, 0.0, -2.0), False),  # next to nothing was left
    ],
)
def test_a_contact_begins_to_slide_or_parts(
    before: ContactState, after: ContactState, told: bool
) -> None:
    normal = np.array([2 * before.traction[0, 0], 2 * after.traction[0, 0], 2.0])
    assert turns(before, after, FRICTION * before.traction[:, 0], NODES, normal) is told
