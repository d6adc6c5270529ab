# SPDX-License-Identifier: LGPL-3.0-or-later
"""Least slip against the shear, against places that can be seen."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.contact.newton import least_motion_back

ALIKE = np.ones((4, 1))


@pytest.mark.parametrize(
    ("slip", "shear", "expected"),
    [
        # The mean is the least, and every node slips against its shear then.
        ([3.0, 2.0, -6.0, -7.0], [-1, -1, 1, 1], -2.0),
        # The least leaves the second node slipping with its shear: to where it does not slip.
        ([8.0, 0.1, -1.0, -1.0], [-1, -1, 1, 1], 0.1),
        # No place is right for the first two: the least.
        ([3.0, 2.0, 1.0, 4.0], [1, -1, -1, -1], 2.5),
        # No slip at all.
        ([0.0, 0.0, 0.0, 0.0], [1, -1, 1, 1], 0.0),
    ],
)
def test_one_motion(slip: list[float], shear: list[float], expected: float) -> None:
    """Exact but for round-off of sums of four."""
    found = least_motion_back(ALIKE, np.array(slip), np.array(shear, float))
    assert found == pytest.approx([expected], abs=1e-12)


def test_two_bodies_do_not_know_of_each_other() -> None:
    slip: Array = np.array([8.0, 0.1, -1.0, -1.0, 3.0, 2.0, -6.0, -7.0])
    shear: Array = np.array([-1.0, -1, 1, 1, -1, -1, 1, 1])
    both: Array = np.zeros((8, 2))
    both[:4, :1] = both[4:, 1:] = ALIKE
    assert least_motion_back(both, slip, shear) == pytest.approx([0.1, -2.0], abs=1e-12)
