# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rainflow counting: the example of ASTM E1049-85, two packages, and strange histories."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from fretfe.analytic.paths import Rainflow, rainflow, reversals

# The points A to I of figures 6 and 7 of the standard.
STANDARD = np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0])
A, B, C, D, E, F, G, H, I = range(9)  # noqa: E741
ROWS = json.loads((Path(__file__).parents[1] / "data" / "rainflow.json").read_text("utf-8"))


def cycles(counted: Rainflow) -> set[tuple[int, int, float]]:
    """Places and counts."""
    columns = (counted.start.tolist(), counted.end.tolist(), counted.count.tolist())
    return set(zip(*columns, strict=True))


def test_example_of_the_standard() -> None:
    counted = rainflow(STANDARD)
    halves = {(A, B, 0.5), (B, C, 0.5), (C, D, 0.5), (D, G, 0.5), (G, H, 0.5), (H, I, 0.5)}
    assert cycles(counted) == halves | {(E, F, 1.0)}
    assert dict(zip(counted.start.tolist(), counted.range.tolist(), strict=True)) == {
        A: 3.0, B: 4.0, C: 8.0, D: 9.0, E: 4.0, G: 8.0, H: 6.0
    }  # fmt: skip


def test_example_of_the_standard_repeated() -> None:
    counted = rainflow(STANDARD, repeated=True)
    # I is A of the next repetition, which is where the range I-B begins.
    assert cycles(counted) == {(E, F, 1.0), (I, B, 1.0), (H, C, 1.0), (D, G, 1.0)}
    assert sorted(counted.range.tolist()) == [3.0, 4.0, 7.0, 9.0]
    assert counted.mean[counted.range == 9.0].tolist() == [0.5]


@pytest.mark.parametrize("begin", range(8))
def test_a_repeated_history_may_begin_anywhere(begin: int) -> None:
    counted = rainflow(np.roll(STANDARD[:-1], -begin), repeated=True)
    assert sorted(counted.range.tolist()) == [3.0, 4.0, 7.0, 9.0]


def test_200_random_histories_against_two_packages() -> None:
    assert len(ROWS) == 200
    for row in ROWS:
        history = np.array(row["history"], dtype=float)
        once, repeated = rainflow(history), rainflow(history, repeated=True)
        found = np.transpose([once.range, once.mean, once.count])
        assert sorted(found.tolist()) == row["counted"]
        assert sorted(repeated.range.tolist()) == row["repeated"]
        assert np.all(repeated.count == 1.0)
        for each in (once, repeated):
            np.testing.assert_array_equal(each.range, abs(history[each.end] - history[each.start]))
            np.testing.assert_array_equal(each.mean, (history[each.end] + history[each.start]) / 2)


@pytest.mark.parametrize("values", [[], [3.0], [3.0, 3.0, 3.0]])
@pytest.mark.parametrize("repeated", [False, True])
def test_nothing_that_varies_has_no_cycles(values: list[float], repeated: bool) -> None:
    assert len(rainflow(np.array(values), repeated).count) == 0


@pytest.mark.parametrize(
    ("values", "once", "repeated"),
    [
        ([1, 2], {(0, 1, 0.5)}, {(1, 0, 1.0)}),
        ([0, 1, 2, 3], {(0, 3, 0.5)}, {(3, 0, 1.0)}),
        ([0, 2, 0], {(0, 1, 0.5), (1, 2, 0.5)}, {(1, 2, 1.0)}),
        ([1, 1, 2, 2, 1, 1], {(0, 2, 0.5), (2, 4, 0.5)}, {(2, 4, 1.0)}),
    ],
)
def test_few_points(
    values: list[float], once: set[tuple[int, int, float]], repeated: set[tuple[int, int, float]]
) -> None:
    history = np.array(values, dtype=float)
    assert cycles(rainflow(history)) == once
    assert cycles(rainflow(history, repeated=True)) == repeated


def test_plateaus_count_where_they_begin() -> None:
    assert reversals(np.array([0.0, 1, 1, 2, 2, 0, 0])).tolist() == [0, 3, 5]


def test_unknown_values_are_refused() -> None:
    with pytest.raises(ValueError, match="found nan at 2"):
        rainflow(np.array([0.0, 1.0, np.nan]))


def test_100_000_points_close_every_loop() -> None:
    history = np.random.default_rng(1).standard_normal(100_000)
    counted = rainflow(history, repeated=True)
    # Each whole cycle goes there and back: all of the way up and down is in one of them.
    closed = np.append(history, history[0])
    assert 2 * counted.range.sum() == pytest.approx(np.abs(np.diff(closed)).sum(), rel=1e-12)
    assert counted.range.max() == np.ptp(history)
