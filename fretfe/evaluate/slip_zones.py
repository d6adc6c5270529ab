# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of a contact: between successive reversals of K_T, at one edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fretfe.analytic.edges import slip_length_first_loading
from fretfe.edges import Side, SlipBorder, main_patch, predicted_slip, slip_border
from fretfe.loads import turning_points
from fretfe.solution import OPEN, SLIP, ContactHistory, Solution

Array = npt.NDArray[np.float64]

# Nodes whose slip in a half cycle is below this fraction of the largest slip have not slipped.
SMALLEST_SLIP = 1e-6
# The history ends with a complete half cycle if K_T is this close to its extreme, as a fraction of
# its range.
AT_EXTREME = 1e-2


@dataclass(frozen=True)
class SlipZone:
    """Slip between two successive reversals of K_T at one edge.

    Attributes:
        start, end: states between which the nodes slipped.
        length: slip-zone length from the edge at `end`, inward; NaN if the whole contact slipped.
        border: position of its inner end along the arc.
        resolved: whether the mesh resolves the zone.
        gross: whether the whole contact slipped.
        predicted: slip length from K_T and K_N: 2 K_T/(f K_N) for first loading, ΔK_T/(f K_N) in
            the evaluated cycle; NaN elsewhere.
        predicted_loop: the same with varying normal load, from `end`; NaN outside the cycle.
    """

    start: int
    end: int
    length: float
    border: float
    resolved: bool
    gross: bool
    predicted: float
    predicted_loop: float


def cycle_states(solution: Solution) -> npt.NDArray[np.int64]:
    """States of the evaluated cycle, first and last included; empty without a cycle."""
    if solution.cycle is None:
        return np.array([], dtype=np.int64)
    return np.arange(solution.cycle[0], solution.cycle[1] + 1)


def slip_zones(
    solution: Solution,
    contact: ContactHistory,
    side: Side,
    position: Array,
    k_n: Array,
    k_t: Array,
    k_i: Array,
) -> tuple[SlipZone, ...]:
    """Slip zones at one edge in time order.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        side: "left" or "right".
        position: (T,) of the edge, NaN where unknown.
        k_n: (T,) pressure factor.
        k_t: (T,) shear factor.
        k_i: (T,) factor of the normal increments.
    """
    frictional = np.flatnonzero((contact.friction > 0) & np.isfinite(position))
    if not len(frictional):
        return ()
    first = int(frictional[0]) - 1
    zones, inward = [], 1.0 if side == "left" else -1.0
    for start, end in _half_cycles(solution, k_t, first):
        if not np.isfinite(position[end]):
            continue
        border = _border(contact, side, start, end, float(position[end]))
        cyclic, loop = _prediction(solution, contact, start, end, k_n, k_t, k_i)
        if start == first:
            rise = abs(k_t[end] - k_t[first])
            cyclic = float(slip_length_first_loading(rise, k_n[end], contact.friction[end]))
        zones.append(
            SlipZone(
                start=start,
                end=end,
                length=border.length,
                border=float(position[end]) + inward * border.length,
                resolved=border.resolved,
                gross=border.gross,
                predicted=cyclic,
                predicted_loop=loop,
            )
        )
    return tuple(zones)


def _half_cycles(solution: Solution, k_t: Array, first: int) -> list[tuple[int, int]]:
    """First and last state between successive reversals of K_T (T,), from the state `first`."""
    last = len(k_t) - 1
    turns = first + turning_points(k_t[first:])
    ends = [int(turn) for turn in turns if first < turn < last]
    if not ends or _at_extreme(solution, k_t, last):
        ends.append(last)
    return list(zip([first, *ends[:-1]], ends, strict=True))


def _at_extreme(solution: Solution, k_t: Array, state: int) -> bool:
    """Whether K_T is at its largest or smallest of the cycle: the half cycle is complete."""
    cycle = cycle_states(solution)
    history = k_t[cycle] if len(cycle) else k_t
    distance = min(history.max() - k_t[state], k_t[state] - history.min())
    return bool(distance < AT_EXTREME * np.ptp(history))


def _border(contact: ContactHistory, side: Side, start: int, end: int, edge: float) -> SlipBorder:
    """Slip zone between two states, from the slip that happened while in contact.

    K_T may reverse between two steps, so that the first step of a half cycle still holds slip of
    the half cycle before: only slip in the direction of the largest slip at this edge counts.
    """
    steps = np.arange(start + 1, end + 1)
    slipping = contact.status[steps] == SLIP
    increments = contact.slip[steps, :, 0] - contact.slip[steps - 1, :, 0]
    increments = np.where(slipping, increments, 0.0)
    closed = contact.status[end] != OPEN
    patch = main_patch(contact.arc, contact.traction[end, :, 0])
    closed[: patch.first] = closed[patch.last + 1 :] = False
    nodes = np.flatnonzero(closed)
    here = nodes[: len(nodes) // 2] if side == "left" else nodes[len(nodes) // 2 :]
    total = increments[:, here].sum(axis=0)
    direction = np.sign(total[np.argmax(np.abs(total))])
    slip = np.maximum(direction * increments, 0.0).sum(axis=0)
    moved = np.abs(slip) > SMALLEST_SLIP * np.abs(slip).max()
    return slip_border(contact.arc[closed], slip[closed], moved[closed], edge, side)


def _prediction(
    solution: Solution,
    contact: ContactHistory,
    start: int,
    end: int,
    k_n: Array,
    k_t: Array,
    k_i: Array,
) -> tuple[float, float]:
    """Slip length by ΔK_T/(f K_N) and by the general loop, if the zone is in the cycle."""
    cycle = cycle_states(solution)
    if not len(cycle) or end <= cycle[0] or not np.isfinite(k_n[end]):
        return np.nan, np.nan
    states = cycle if end in cycle else np.append(cycle, end)
    reference = int(np.flatnonzero(states == end)[0])
    predicted = predicted_slip(
        k_t[states], k_i[states], float(k_n[end]), float(contact.friction[end]), reference
    )
    return predicted.cyclic, predicted.loop
