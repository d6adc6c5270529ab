# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows of nodes near the free end of a front, whose values are known."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.quality.end_rows import Rows, slip_at_edge


def test_a_mean_ends_where_its_length_does() -> None:
    """Of 3 - x the mean from 0 to .5 is 2.75, between rows or not."""
    for distance in ([0.0, 0.2, 0.4, 0.8], [0.0, 0.5, 1.0]):
        places = np.array(distance)
        rows = Rows(places, 3.0 - places, *5 * (np.zeros(len(places)),))
        assert rows.mean("work", 0.5) == pytest.approx(2.75)


def test_slip_is_taken_to_the_edge_of_each_row() -> None:
    """Of a zone of .1 whose nodes lie anywhere next to the edge, in two rows in any order."""
    place = np.array([0.045, -0.02, 0.02, 0.13, 0.01, 0.035, -0.015, 0.06])
    row = np.array([0, 0, 0, 0, 1, 1, 1, 1])
    slip = np.where(place > 0, 3e-3 * np.maximum(1 - place / 0.1, 0.0) ** 1.5, 0.0)
    np.testing.assert_allclose(slip_at_edge(place, row, slip, 2), 3e-3, rtol=1e-9)
    # A row that slides as a whole, one with a single node, one that nowhere slips.
    whole = slip_at_edge(place, row, np.where(place > 0, 2e-3, 0.0), 3)
    np.testing.assert_allclose(whole, [2e-3, 2e-3, 0.0])
    np.testing.assert_allclose(slip_at_edge(place[2:3], row[:1], slip[2:3], 1), slip[2])
