# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of a station, between successive reversals of the slip there."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.edges import slip_length_first_loading
from fretfe.edges.between import LoadPath
from fretfe.edges.front import SlipZone, StationHistory
from fretfe.edges.missions import Worst
from fretfe.edges.patches import main_patch
from fretfe.edges.reversals import slip_reversals
from fretfe.edges.section import PlaneFront, plane_front
from fretfe.edges.slip import SlipBorder, predicted_slip, slip_border
from fretfe.results.solution import OPEN, SLIP, ContactHistory
from fretfe.results.states import blocks

States = Indices

# Nodes whose slip in a half cycle is below this fraction of the largest slip have not slipped.
# Where slip turns round between two steps, nodes behind the border move by about as much. What is
# left out at the border is less than 1 % of the zone, which the fit of the border puts back.
SMALLEST_SLIP = 3e-4
# Where no node slips there is no slip zone if the formulas predict less than this fraction of the
# distance within which no node would see it.
HIDDEN = 0.1
# Error bar of border and front over the length of the zone, beyond which it is not resolved.
LARGEST_SPREAD = 0.5
# Fewer sticking nodes than this are no stick zone.
FEWEST_STUCK = 3
# The history ends with a complete half cycle if K_T is this close to its extreme, as a fraction of
# its range.
AT_EXTREME = 1e-2


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
    station: StationHistory,
    find_border: FindBorder,
    path: LoadPath | None = None,
    place: Callable[[float, float], float] | None = None,
    worst: Worst | None = None,
) -> tuple[SlipZone, ...]:
    """Slip zones of a station in time order.

    Args:
        cycle: states of the evaluated cycle.
        friction: (T,) coefficient in the step that ends at each state.
        station: position and factors.
        find_border: gives the slip zone of a half cycle.
        path: loads of the cycle between its steps, unless they are straight lines.
        place: gives the position that is some length inward from a position of the station; None
            for a station of a plane front.
        worst: the cycle whose half cycles alone are looked at, where loads are irregular.
    """
    place = place or plane_front(station.front).place
    frictional = np.flatnonzero((friction > 0) & np.isfinite(station.position))
    if not len(frictional):
        return ()
    first = int(frictional[0]) - 1
    known = np.isfinite(station.k_t) & np.isfinite(station.k_i)
    begin = max(first, int(np.argmax(known)))
    if not known[begin:].all():
        return ()
    zones = []
    halves = worst.half_cycles if worst else _half_cycles(cycle, friction, station, begin)
    for start, end in halves:
        if not np.isfinite(station.position[end]):
            continue
        border = find_border(start, end)
        cyclic, loop = _prediction(cycle, friction[end], end, station)
        if worst and not len(cycle):
            cyclic = worst.predicted
        elif start == first:
            rise = abs(station.k_t[end] - station.k_t[first])
            cyclic = float(slip_length_first_loading(rise, station.k_n[end], friction[end]))
        spread = math.hypot(border.spread, float(station.position_spread[end]))
        missed = _missed(cycle, friction[end], end, station, path) if path is not None else 0.0
        # A zone that is long against its edge grows faster than predicted.
        missed *= max(1.0, border.length / loop) if loop > 0 else 1.0
        zone = SlipZone(
            start=start,
            end=end,
            length=border.length,
            border=place(float(station.position[end]), border.length),
            spread=math.hypot(spread, missed),
            resolved=border.resolved and _told(border, spread),
            gross=border.gross,
            predicted=cyclic,
            predicted_loop=loop,
        )
        zones.append(replace(zone, resolved=False) if _hides(zone, border.spread) else zone)
    return tuple(zones)


def _told(border: SlipBorder, spread: float) -> bool:
    """True if the length is known to a good part of itself, or there is none to be known."""
    return border.gross or border.length == 0 or spread <= LARGEST_SPREAD * border.length


def _missed(
    cycle: States, friction: float, end: int, station: StationHistory, path: LoadPath
) -> float:
    """Length by which a zone that ends between two steps of the cycle is longer, as predicted."""
    _, sampled = _prediction(cycle, friction, end, station)
    if not np.isfinite(sampled) or end not in cycle:
        return 0.0
    k_t, k_i, k_n = (path.refine(each) for each in (station.k_t, station.k_i, station.k_n))
    if not np.isfinite(k_t + k_i + k_n).all():
        return 0.0
    forward, backward = k_t - friction * k_i, k_t + friction * k_i
    near = path.instants(end)
    middle = (forward.max() + backward.min()) / 2
    turns = forward[near] if station.k_t[end] > middle else -backward[near]
    turn = near.start + int(np.argmax(turns))
    return abs(predicted_slip(k_t, k_i, float(k_n[turn]), friction, turn).loop - sampled)


def _hides(zone: SlipZone, spread: float) -> bool:
    """True if no node slips although a zone is predicted, which may stand between the nodes."""
    return zone.length == 0 and zone.prediction > HIDDEN * spread > 0


def _half_cycles(
    cycle: States, friction: Array, station: StationHistory, first: int
) -> list[tuple[int, int]]:
    """First and last state of each half cycle in which an edge slips one way, from `first` on.

    Forward slip grows as long as K_T - f K_I does, backward slip as long as K_T + f K_I falls: at
    constant normal load half cycles end where K_T reverses.
    """
    k_t, k_i = station.k_t, station.k_i
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
    """True if slip one way is as far as it gets in these states: the half cycle is complete."""
    growth = forward[states].max() - forward[last]
    fall = backward[last] - backward[states].min()
    # Both counted from the same state: the length of the slip zone but for a factor.
    size = np.ptp(
        np.concatenate([forward[states] - forward[last], backward[states] - backward[last]])
    )
    return bool(min(growth, fall) < AT_EXTREME * size)


def slip_border_of(
    contact: ContactHistory, front: PlaneFront, position: Array, outer: Bools
) -> FindBorder:
    """Slip zones of a solved contact at a front.

    Args:
        contact: one contact.
        front: one of its fronts.
        position: (T,) of the edge.
        outer: (T,) whether the slip in the step to each state counts.
    """
    return lambda start, end: _border(contact, front, start, end, float(position[end]), outer)


def _border(
    contact: ContactHistory,
    front: PlaneFront,
    start: int,
    end: int,
    position: float,
    outer: Bools,
) -> SlipBorder:
    """Slip zone between two states, from the slip that happened while in contact.

    K_T may reverse between two steps, so that the first step of a half cycle still holds slip of
    the half cycle before: only slip in the direction of the largest slip at this front counts.
    """
    forward, backward = _slip_both_ways(contact, start, end, outer)
    closed = contact.status[end] != OPEN
    patch = main_patch(contact.arc, contact.traction[end, :, 0])
    closed[: patch.first] = closed[patch.last + 1 :] = False
    nodes = front.from_front(np.flatnonzero(closed))
    total = (forward - backward)[nodes[: len(nodes) // 2]]
    direction = np.sign(total[np.argmax(np.abs(total))])
    slip = {1.0: forward, -1.0: backward}.get(direction, np.zeros_like(forward))
    moved = slip > SMALLEST_SLIP * slip.max()
    s, moved = front.distances(contact.arc[closed], position), moved[nodes]
    border = slip_border(s, slip[nodes], moved)
    behind = _slip_behind(moved)
    if behind is None or border.gross:
        return border
    spread = max(border.spread, float(s[behind]) - border.length)
    return replace(border, resolved=False, spread=spread)


def _slip_both_ways(
    contact: ContactHistory, start: int, end: int, outer: Bools
) -> tuple[Array, Array]:
    """(N,) sums of slip increments to larger and smaller x in the outer steps between states."""
    sums = np.zeros((2, len(contact.arc)))
    for part in blocks(end - start, len(contact.arc)):
        first, last = start + part.start, start + part.stop
        slipping = contact.status[first + 1 : last + 1] == SLIP
        slipping &= outer[first + 1 : last + 1, None]
        increments = np.where(slipping, np.diff(contact.slip[first : last + 1, :, 0], axis=0), 0.0)
        sums += np.maximum(increments, 0.0).sum(axis=0), np.maximum(-increments, 0.0).sum(axis=0)
    return sums[0], sums[1]


def _slip_behind(moved: Bools) -> int | None:
    """Innermost node that has slipped behind one that has not, but for the zone of the other edge.

    None without any. Few sticking nodes in between are none.

    Args:
        moved: (n,) nodes in contact that have slipped, from the front inward.
    """
    stuck = np.flatnonzero(~moved[1:]) + 1  # the status of the outermost node means nothing
    if not len(stuck):
        return None
    between = moved[stuck[0] : stuck[-1]]
    if len(stuck) < FEWEST_STUCK:
        return len(moved) - 1
    return int(stuck[0] + np.flatnonzero(between)[-1]) if between.any() else None


def _prediction(
    cycle: States, friction: float, end: int, station: StationHistory
) -> tuple[float, float]:
    """Slip length by ΔK_T/(f K_N) and by the general loop, if the zone is in the cycle."""
    k_n = station.k_n
    if not len(cycle) or end <= cycle[0] or not np.isfinite(k_n[end]):
        return np.nan, np.nan
    states = cycle if end in cycle else np.append(cycle, end)
    reference = int(np.flatnonzero(states == end)[0])
    predicted = predicted_slip(
        station.k_t[states], station.k_i[states], float(k_n[end]), float(friction), reference
    )
    return predicted.cyclic, predicted.loop
