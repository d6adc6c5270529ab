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
        depth: (m,) f K_N y.
        in_steps: whether the edge covers places at the beginning of a step, as nodes close in the
            solved one, and not in the course of it.
    """
    radius, memory = depth / 2, np.full(len(depth), k_t[0])
    for state in range(1, len(k_t)):
        yield memory
        before, now = retreat[state - 1], retreat[state]
        if now < before and not in_steps:
            covered = k_t[state] + (radius - now) / (before - now) * (k_t[state - 1] - k_t[state])
            memory = np.where((radius >= now) & (radius < before), covered, memory)
        memory = np.clip(memory, k_t[state] + now - radius, k_t[state] - now + radius)
        memory = np.where(radius < now, k_t[state], memory)


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
