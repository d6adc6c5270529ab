# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of a contact: between successive reversals of the slip at one edge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.analytic.edges import slip_length_first_loading
from fretfe.edges import Side, SlipBorder, main_patch, predicted_slip, slip_border
from fretfe.results.solution import OPEN, SLIP, ContactHistory

States = Indices

# Nodes whose slip in a half cycle is below this fraction of the largest slip have not slipped.
# Where slip turns round between two steps, nodes behind the border move by about as much. What is
# left out at the border is less than 1 % of the zone, which the fit of the border puts back.
SMALLEST_SLIP = 3e-4
# Where no node slips there is no slip zone if the formulas predict less than this fraction of the
# distance within which no node would see it.
HIDDEN = 0.1
# The history ends with a complete half cycle if K_T is this close to its extreme, as a fraction of
# its range.
AT_EXTREME = 1e-2


@dataclass(frozen=True)
class SlipZone:
    """Slip of one edge in one direction, from one reversal to the next.

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

    @property
    def prediction(self) -> float:
        """What the length is compared with: `predicted_loop` in the cycle, else `predicted`."""
        return self.predicted_loop if np.isfinite(self.predicted_loop) else self.predicted


# Slip zone between two states, measured from the edge at the second one.
FindBorder = Callable[[int, int], SlipBorder]


def cycle_states(cycle: tuple[int, int] | None) -> States:
    """States of the evaluated cycle, first and last included; empty without a cycle."""
    if cycle is None:
        return np.array([], dtype=np.int64)
    return np.arange(cycle[0], cycle[1] + 1)


def slip_zones(
    cycle: States,
    friction: Array,
    side: Side,
    position: Array,
    factors: tuple[Array, Array, Array],
    find_border: FindBorder,
) -> tuple[SlipZone, ...]:
    """Slip zones at one edge in time order.

    Args:
        cycle: states of the evaluated cycle.
        friction: (T,) coefficient in the step that ends at each state.
        side: "left" or "right".
        position: (T,) of the edge, NaN where unknown.
        factors: (T,) each: K_N, K_T and K_I.
        find_border: gives the slip zone of a half cycle.
    """
    frictional = np.flatnonzero((friction > 0) & np.isfinite(position))
    if not len(frictional):
        return ()
    k_n, k_t, _ = factors
    first = int(frictional[0]) - 1
    zones, inward = [], 1.0 if side == "left" else -1.0
    for start, end in _half_cycles(cycle, friction, factors, first):
        if not np.isfinite(position[end]):
            continue
        border = find_border(start, end)
        cyclic, loop = _prediction(cycle, friction[end], end, factors)
        if start == first:
            rise = abs(k_t[end] - k_t[first])
            cyclic = float(slip_length_first_loading(rise, k_n[end], friction[end]))
        zone = SlipZone(
            start=start,
            end=end,
            length=border.length,
            border=float(position[end]) + inward * border.length,
            resolved=border.resolved,
            gross=border.gross,
            predicted=cyclic,
            predicted_loop=loop,
        )
        zones.append(replace(zone, resolved=False) if _hides(zone, border.spread) else zone)
    return tuple(zones)


def _hides(zone: SlipZone, spread: float) -> bool:
    """Whether no node slips although a zone is predicted, which may stand between the nodes."""
    return zone.length == 0 and zone.prediction > HIDDEN * spread > 0


def _half_cycles(
    cycle: States, friction: Array, factors: tuple[Array, Array, Array], first: int
) -> list[tuple[int, int]]:
    """First and last state of each half cycle in which an edge slips one way, from `first` on.

    Forward slip grows as long as K_T - f K_I does, backward slip as long as K_T + f K_I falls: at
    constant normal load half cycles end where K_T reverses.
    """
    _, k_t, k_i = factors
    last = len(k_t) - 1
    f = friction.max()  # the same in all steps with friction
    forward, backward = k_t - f * k_i, k_t + f * k_i
    ends = [first + int(end) for end in slip_reversals(forward[first:], backward[first:])]
    states = cycle if len(cycle) else np.arange(first, last + 1)
    if len(ends) > 1 and ends[-1] == last and not _at_extreme(forward, backward, states, last):
        ends.pop()
    ends = ends or [last]
    return list(zip([first, *ends[:-1]], ends, strict=True))


def _at_extreme(forward: Array, backward: Array, states: States, last: int) -> bool:
    """Whether slip one way is as far as it gets in these states: the half cycle is complete."""
    growth = forward[states].max() - forward[last]
    fall = backward[last] - backward[states].min()
    # Both counted from the same state: the length of the slip zone but for a factor.
    size = np.ptp(
        np.concatenate([forward[states] - forward[last], backward[states] - backward[last]])
    )
    return bool(min(growth, fall) < AT_EXTREME * size)


def slip_reversals(forward: Array, backward: Array, relative_tolerance: float = 1e-6) -> Indices:
    """Last states of the phases in which slip goes one way, in time order.

    Of a plateau the first state counts. Between two phases an edge may stick.

    Args:
        forward: (T,) grows while the edge slips forward.
        backward: (T,) falls while the edge slips backward; the same as `forward` at constant load.
        relative_tolerance: changes below this fraction of the range are ignored.

    Returns:
        (n,) ends; forward and backward phases alternate, the last one may not be complete.
    """
    tolerance = relative_tolerance * max(np.ptp(forward), np.ptp(backward))
    ends: list[int] = []
    direction, end, peak = 0, 0, 0
    for state in range(1, len(forward)):
        # In the sense of the present phase: what makes it go on, what turns it round.
        onward, back = (-backward, -forward) if direction < 0 else (forward, backward)
        if onward[state] - onward[end] > tolerance:
            end, peak, direction = state, state, direction or 1
        elif back[state] > back[peak]:
            peak = state
        elif back[peak] - back[state] > tolerance:
            if direction:
                ends.append(end)
            direction, end, peak = (1 if direction < 0 else -1), state, state
    return np.array([*ends, end] if direction else ends, dtype=np.int64)


def slip_border_of(contact: ContactHistory, side: Side, position: Array) -> FindBorder:
    """Slip zones of a solved contact, whose edge is at `position` (T,)."""
    return lambda start, end: _border(contact, side, start, end, float(position[end]))


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
    cycle: States, friction: float, end: int, factors: tuple[Array, Array, Array]
) -> tuple[float, float]:
    """Slip length by ΔK_T/(f K_N) and by the general loop, if the zone is in the cycle."""
    k_n, k_t, k_i = factors
    if not len(cycle) or end <= cycle[0] or not np.isfinite(k_n[end]):
        return np.nan, np.nan
    states = cycle if end in cycle else np.append(cycle, end)
    reference = int(np.flatnonzero(states == end)[0])
    predicted = predicted_slip(
        k_t[states], k_i[states], float(k_n[end]), float(friction), reference
    )
    return predicted.cyclic, predicted.loop
