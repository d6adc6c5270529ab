# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reversals of the slip at an edge, from its factors: where forward and backward slip end."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Indices

# Changes below this fraction of the range are no reversal.
TOLERANCE = 1e-6


def slip_reversals(forward: Array, backward: Array) -> Indices:
    """Last states of the phases in which slip goes one way, in time order.

    Of a plateau the first state counts. Between two phases an edge may stick.

    Args:
        forward: (T,) grows while the edge slips forward.
        backward: (T,) falls while the edge slips backward; the same as `forward` at constant load.

    Returns:
        (n,) ends; forward and backward phases alternate, the last one may not be complete.
    """
    return slip_phases(forward, backward)[0]


def slip_phases(forward: Array, backward: Array) -> tuple[Indices, Indices]:
    """As `slip_reversals`, and (n,) the directions of the phases: 1 forward, -1 backward."""
    tolerance = TOLERANCE * max(np.ptp(forward), np.ptp(backward))
    # In the sense of each phase: what makes it go on, what turns it round.
    senses = {
        1: (forward.tolist(), backward.tolist()),
        -1: ((-backward).tolist(), (-forward).tolist()),
    }
    ends: list[int] = []
    directions: list[int] = []
    direction, end, peak = 0, 0, 0
    for state in range(1, len(forward)):
        onward, back = senses[direction or 1]
        if onward[state] - onward[end] > tolerance:
            end, peak, direction = state, state, direction or 1
        elif back[state] > back[peak]:
            peak = state
        elif back[peak] - back[state] > tolerance:
            if direction:
                ends.append(end)
                directions.append(direction)
            direction, end, peak = (1 if direction < 0 else -1), state, state
    if direction:
        ends.append(end)
        directions.append(direction)
    return np.array(ends, dtype=np.int64), np.array(directions, dtype=np.int64)
