# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nodes of a line in the order in which they lie on it, whatever the order of their rows."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.errors import CaseError
from fretfe.exchange.traction_path import order_along

RANDOM = np.random.default_rng(5)
ANGLE = np.linspace(0, 3.0, 61)
# 350 nodes of which each is much nearer to the next than the turns are apart.
TURNS = np.linspace(2, 20, 350)


@pytest.mark.parametrize(
    "points",
    [
        np.column_stack([np.cos(ANGLE), np.sin(ANGLE)]),
        np.column_stack([TURNS * np.cos(TURNS), TURNS * np.sin(TURNS)]),
        # elements that grow by a fifth, around a corner of a right angle
        np.array([[x, 0.0] for x in -np.cumsum(1.2 ** np.arange(20))[::-1]] + [[0, 0]]
                 + [[0, y] for y in np.cumsum(1.2 ** np.arange(20))]),
        np.column_stack([ANGLE, ANGLE**2, np.sin(ANGLE)]),
        np.array([[0.0, 0.0], [1.0, 1.0]]),
    ],
    ids=["arc", "spiral", "corner", "in space", "two"],
)  # fmt: skip
def test_rows_in_any_order(points: np.ndarray) -> None:
    rows = RANDOM.permutation(len(points))
    order = rows[order_along(points[rows], np.zeros(len(points)))]
    found = order if order[0] == 0 else order[::-1]
    np.testing.assert_array_equal(found, np.arange(len(points)))


def test_a_closed_line_begins_where_nothing_touches() -> None:
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    # in contact where the rows begin and end, and in two nodes opposite
    pressure = np.where((np.cos(angle) > 0.5) | (np.abs(angle - np.pi) < 0.1), 1.0, 0.0)
    order = order_along(circle, pressure)
    loaded = pressure[order] > 0
    assert sorted(order) == list(range(40)) and not loaded[[0, -1]].any()
    # two patches, neither of them cut
    assert np.count_nonzero(np.diff(loaded.astype(int)) == 1) == 2
    with pytest.raises(CaseError, match="found pressure all round"):
        order_along(circle, np.ones(40))


def test_nodes_of_a_surface_are_no_line() -> None:
    grid = np.array([[x, y, 0] for x in range(4) for y in range(4)], dtype=float)
    with pytest.raises(CaseError, match=r"found a branch at \("):
        order_along(grid, np.ones(16))
