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

from fretfe._typing import Array, Bools

# Depths at which the memory is followed, over the largest one.
LEVELS = 800
# Part of the way of an edge that draws back by which K_T there is not known.
SLACK = 0.02
# Part of the range of K_T by which places have to slip: increments of an edge that moves leave so
# much from cycle to cycle.
LEAST_SLIP = 0.02
# A retreat below this part of the range of K_T takes nothing away that counts: edges of finite
# elements move a little at constant P.
NO_FALL = 0.02
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


def remembered(
    k_t: Array, retreat: Array, depth: Array, in_steps: bool = False, since: int = 0
) -> Iterator[Array]:
    """(m,) what places remember before the step to each state after one.

    Places outside the edge count as if it covered them.

    Args:
        k_t: (n,) at the states.
        retreat: (n,) f K_I below its largest value.
        depth: (m,) f K_N y, increasing.
        in_steps: whether the edge covers places at the beginning of a step, as nodes close in the
            solved one, and not in the course of it.
        since: that state; what came before it is remembered.
    """
    # Imported where it is needed: pages of results do without compiled code.
    from fretfe._core import _kernels

    k_t, retreat, radius = (np.ascontiguousarray(each) for each in (k_t, retreat, depth / 2))
    memory = np.full(len(depth), k_t[0])
    _kernels.follow_memory(k_t, retreat, radius, in_steps, 0, since, memory)
    for state in range(since + 1, len(k_t)):
        yield memory
        memory = memory.copy()
        _kernels.follow_memory(k_t, retreat, radius, in_steps, state - 1, state, memory)


def takes_away(retreat: Array, k_t: Array) -> bool:
    """True if an edge leaves places that count.

    Args:
        retreat: (n,) f K_I below its largest value.
        k_t: (m,) over the whole history.
    """
    return bool(retreat.max(initial=0.0) > NO_FALL * np.ptp(k_t))


class _Phase:
    """The slip of an edge one way, until it turns back by some drive.

    Attributes:
        way: 1 forward, -1 backward; 0 before there is any.
        begin: (m,) what places remembered when it began, or when they were covered.
    """

    def __init__(self, memory: Array, drive: float, least: float) -> None:
        self.way, self.begin, self._least = 0, memory, least
        self._extreme, self._memory = drive, memory

    def follow(self, memory: Array, drive: float, covered: Bools) -> None:
        """Go on to the drive, and to what places remember, in the next state."""
        change = drive - self._extreme
        turns = abs(change) > self._least and self.way * change <= 0
        if turns:
            self.way, self.begin = int(np.sign(change)), self._memory
        if turns or self.way * change > 0:
            self._extreme, self._memory = drive, memory
        self.begin = np.where(covered, self.begin, memory)
        self._memory = np.where(covered, self._memory, memory)


def longest_zones(
    k_t: Array, f_k_i: Array, k_n: Array, drive: Array, first: int
) -> tuple[tuple[int, int] | None, tuple[int, int] | None]:
    """Forward and backward, the states between which the longest slip zone comes about.

    It comes about since the places at its inner end were covered or slipped the other way. None
    where nothing slips that way.

    Args:
        k_t: (n,) at the states.
        f_k_i: (n,) f K_I at the states.
        k_n: (n,) K_N at the states.
        drive: (n,) as of `slip_drive`.
        first: state after which zones are looked for.
    """
    retreat, least = f_k_i.max() - f_k_i, LEAST_SLIP * float(np.ptp(k_t))
    radius = depths(k_t, retreat) / 2
    since, before = np.zeros((3, len(radius)), dtype=np.int64), np.full(len(radius), k_t[0])
    phase = _Phase(before, drive[0], least)
    longest: dict[int, float] = {1: 0.0, -1: 0.0}
    found: dict[int, tuple[int, int]] = {}
    # The last state once more: what is remembered is known before each step.
    steps = remembered(np.append(k_t, k_t[-1]), np.append(retreat, retreat[-1]), 2 * radius)
    for state, memory in enumerate(steps):
        covered = radius >= retreat[state]
        phase.follow(memory, drive[state], covered)
        way = phase.way
        slips = covered & (way * (memory - phase.begin) > least) & (way * (memory - before) > 0)
        before = memory
        if slips.any() and state > first:
            deepest = int(np.flatnonzero(slips)[-1])
            length = float(radius[deepest] - retreat[state]) / float(k_n[state])
            if length >= (1 - SAME_LENGTH) * longest[way]:
                longest[way] = max(length, longest[way])
                found[way] = int(since[way, int(INNER * deepest)]), state
        since[-way, slips] = state
        since[:, ~covered] = state
    return found.get(1), found.get(-1)


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
