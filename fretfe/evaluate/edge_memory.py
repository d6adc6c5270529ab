# SPDX-License-Identifier: LGPL-3.0-or-later
"""Places next to an edge between similar bodies remember the shear with which they stick.

With the depth y inward from the outermost place of the edge and r = f K_N y/2, a place sticks as
long as K_T stays within r of what it remembers, c(y): c is what keeps within K_T - f K_I - r and
K_T + f K_I + r, K_I counted from its largest value. A place that the edge covers remembers K_T as
it is then; the edge itself stands where r is what f K_I has fallen by.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fretfe._typing import Array

# Depths at which the memory is followed, over the largest one.
LEVELS = 800
# Part of the way of an edge that draws back by which K_T there is not known.
SLACK = 0.02
# Part of the range of K_T by which places have to slip: increments of an edge that moves leave so
# much from cycle to cycle.
LEAST_SLIP = 0.02
# Zones whose lengths differ by less than this part are equal, and the last one counts.
SAME_LENGTH = 1e-3
# Part of a zone at which its inner end begins.
INNER = 0.95


def depths(k_t: Array, retreat: Array) -> Array:
    """(m,) f K_N y, from the outermost place of an edge to twice the largest of all that slips.

    Where the edge has turned round the memory has a kink.

    Args:
        k_t: (n,) at the states.
        retreat: (n,) f K_I below its largest value.
    """
    largest = 2 * float(np.max(np.abs(k_t - k_t[0]) + retreat))
    moves = np.diff(retreat)
    turns = retreat[1:-1][(moves[:-1] > 0) & (moves[1:] <= 0)]
    places = np.sort(np.append(np.linspace(0.0, largest, LEVELS + 1), 2 * turns))
    return places[np.diff(places, prepend=-1.0) > 1e-9 * largest]


def remembered(k_t: Array, retreat: Array, depth: Array, in_steps: bool = False) -> Iterator[Array]:
    """(m,) what places remember before the step to each state but the first.

    Places outside the edge count as if it covered them.

    Args:
        k_t: (n,) at the states.
        retreat: (n,) f K_I below its largest value.
        depth: (m,) f K_N y, increasing.
        in_steps: whether the edge covers places at the beginning of a step, as nodes close in the
            solved one, and not in the course of it.
    """
    radius, memory = depth / 2, np.full(len(depth), k_t[0])
    for state in range(1, len(k_t)):
        yield memory
        before, now = retreat[state - 1], retreat[state]
        memory, edge = memory.copy(), int(np.searchsorted(radius, now))
        if now < before and not in_steps:
            covered = slice(edge, int(np.searchsorted(radius, before)))
            share = (radius[covered] - now) / (before - now)
            memory[covered] = k_t[state] + share * (k_t[state - 1] - k_t[state])
        np.maximum(memory, k_t[state] + now - radius, out=memory)
        np.minimum(memory, k_t[state] - now + radius, out=memory)
        memory[:edge] = k_t[state]


def longest_zones(
    k_t: Array, f_k_i: Array, k_n: Array, first: int
) -> tuple[tuple[int, int] | None, tuple[int, int] | None]:
    """Forward and backward, the states between which the longest slip zone comes about.

    It comes about since the places at its inner end were covered or slipped the other way. None
    where nothing slips that way.

    Args:
        k_t: (n,) at the states.
        f_k_i: (n,) f K_I at the states.
        k_n: (n,) K_N at the states; NaN where not known.
        first: state after which zones are looked for.
    """
    retreat, least = f_k_i.max() - f_k_i, LEAST_SLIP * np.ptp(k_t)
    radius = depths(k_t, retreat) / 2
    since = np.zeros((2, len(radius)), dtype=np.int64)
    longest = [0.0, 0.0]
    found: list[tuple[int, int] | None] = [None, None]
    for state, memory in enumerate(remembered(k_t, retreat, 2 * radius), 1):
        free = radius - retreat[state]
        beyond = free + least
        slips = (free >= 0) & np.array([memory < k_t[state] - beyond, memory > k_t[state] + beyond])
        for way in np.flatnonzero(slips.any(axis=1)).tolist():
            deepest = int(np.flatnonzero(slips[way])[-1])
            length = free[deepest] / k_n[state]
            if state > first and k_n[state] > 0 and length >= (1 - SAME_LENGTH) * longest[way]:
                begin = int(since[way, int(INNER * deepest)])
                longest[way], found[way] = max(length, longest[way]), (begin, state)
        since[0, slips[1] | (free < 0)] = state
        since[1, slips[0] | (free < 0)] = state
    return found[0], found[1]


def slip_drive(k_t: Array, f_k_i: Array) -> Array:
    """(n,) sum of what drives slip at an edge forward in all steps, less what drives it backward.

    At constant P that is K_T. An edge that moves outward slips where it is sheared faster than it
    is pressed; one that draws back to a place slips the way in which K_T has left what that
    remembers.

    Args:
        k_t: (n,) at the states.
        f_k_i: (n,) f K_I at the states.
    """
    retreat, sheared = f_k_i.max() - f_k_i, np.diff(k_t)
    pressed = -np.diff(retreat)
    driven = np.sign(sheared) * np.maximum(np.abs(sheared) - np.maximum(pressed, 0.0), 0.0)
    if (pressed < 0).any():
        depth = depths(k_t, retreat)
        for step, memory in enumerate(remembered(k_t, retreat, depth)):
            if pressed[step] < 0:
                left = k_t[step + 1] - float(np.interp(retreat[step + 1], depth / 2, memory))
                known = max(abs(left) + SLACK * float(pressed[step]), 0.0)
                driven[step] = np.sign(left) * known
    return np.append(0.0, np.cumsum(driven))
