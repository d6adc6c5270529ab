# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rainflow counting of a load history: ASTM E1049-85, sections 5.4.4 and 5.4.5.

A cycle is a pair of reversals that a closed loop of the history runs between. Ranges are compared
without tolerance: of a plateau the first point counts, and a range that is as large as the one
before it closes that one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fretfe._typing import Array, Indices

FULL, HALF = 1.0, 0.5


@dataclass(frozen=True)
class Rainflow:
    """Counted cycles of a history, n of them, in the order in which they were closed.

    Attributes:
        start, end: (n,) places of the two reversals in the history. In a repeated history `start`
            may stand behind `end`: the cycle then goes on in the next repetition.
        count: (n,) 1, or 0.5 for a range that no later one closes.
        range, mean: (n,) difference of the values at both reversals, positive, and their mean.
    """

    start: Indices
    end: Indices
    count: Array
    range: Array
    mean: Array


def rainflow(values: Array, repeated: bool = False) -> Rainflow:
    """Count the cycles of a history.

    Args:
        values: (T,) the history.
        repeated: it follows itself without end: it is counted from its largest value on, as
            section 5.4.5 has it, and all cycles are whole.

    Raises:
        ValueError: if a value is not finite.
    """
    values = np.asarray(values, dtype=np.float64)
    unknown = np.flatnonzero(~np.isfinite(values))
    if len(unknown):
        raise ValueError(f"expected finite values, found {values[unknown[0]]} at {unknown[0]}")
    order = np.arange(len(values))
    if repeated and len(values):
        largest = int(np.argmax(values))
        order = np.append(np.roll(order, -largest), largest)
    order = order[reversals(values[order])]
    pairs = np.array(list(_pairs(values[order].tolist(), repeated))).reshape(-1, 3)
    start, end = order[pairs[:, 0].astype(np.int64)], order[pairs[:, 1].astype(np.int64)]
    return Rainflow(
        start=start,
        end=end,
        count=pairs[:, 2],
        range=np.abs(values[end] - values[start]),
        mean=(values[end] + values[start]) / 2,
    )


def reversals(values: Array) -> Indices:
    """(n,) places of the first value, of all peaks and valleys, and of the last extreme.

    Of equal neighbours the first counts; a constant history has none.

    Args:
        values: (T,) finite.
    """
    places = np.append(0, 1 + np.flatnonzero(np.diff(values))) if len(values) else np.arange(0)
    if len(places) < 2:
        return places[:0]
    rises = np.diff(values[places]) > 0
    turns = 1 + np.flatnonzero(rises[1:] != rises[:-1])
    return np.asarray(places[[0, *turns, len(places) - 1]])


def _pairs(values: list[float], repeated: bool) -> Iterator[tuple[int, int, float]]:
    """Places of the two reversals of each cycle, and its count.

    Args:
        values: of the reversals; of a repeated history from its largest value to itself.
        repeated: whether it is one.
    """
    open_ones: list[int] = []
    for place, value in enumerate(values):
        open_ones.append(place)
        while len(open_ones) > 2:
            first, second = open_ones[-3:-1]
            if abs(value - values[second]) < abs(values[second] - values[first]):
                break
            if len(open_ones) > 3 or repeated:
                yield first, second, FULL
                del open_ones[-3:-1]
            else:
                # The range holds the starting point of the history: nothing has closed it.
                yield first, second, HALF
                del open_ones[0]
    for first, second in pairwise(open_ones):
        yield first, second, HALF
