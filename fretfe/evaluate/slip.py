# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of a station, between successive reversals of the slip there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.analytic.edges import slip_length_cyclic, slip_length_first_loading, slip_length_loop
from fretfe.evaluate.contacts import NOTHING, SMALL_LOAD, SlipZone, StationHistory
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.edge_slip import BEHIND, HalfCycle
from fretfe.history.solution import OPEN, SLIP, ContactHistory

States = Indices

# Nodes whose slip in a half cycle is below this fraction of the largest slip have not slipped.
# Where slip turns round between two steps, nodes behind the border move by about as much. What is
# left out at the border is less than 1 % of the zone, which the fit of the border puts back.
SMALLEST_SLIP = 3e-4
# Fewer sticking nodes than this are no stick zone.
FEWEST_STUCK = 3
# Where no node slips there is no slip zone if the formulas predict less than this fraction of the
# distance within which no node would see it.
HIDDEN = 1e-2
# Error bar of border and front over the length of the zone, beyond which it is not resolved.
LARGEST_SPREAD = 0.5


@dataclass(frozen=True)
class SlipBorder:
    """Slip-zone length from the edge inward; 0 without slip, NaN if the whole patch slips.

    If not ``resolved``, too few nodes slip, or the slip does not fall to zero where the sticking
    nodes begin: the length then ends half an element inside the last slipping node.

    ``spread`` is half the width of an interval that is meant to hold the place of the border with
    95 %, 0 in closed forms; the error of the edge is not in it. Infinite if a fit has no length.
    """

    length: float
    resolved: bool
    gross: bool
    spread: float = 0.0


# Part of its range by which a cycle may miss its beginning, or a half cycle be in doubt, where a
# length is predicted: increments of a moving edge add up to that much.
LEFT_OPEN = 0.1
# Part of what steps of pressing misplace a border by that may be wrong.
MISPLACED = 0.5
# Slip zone between two states, measured from the edge at the second one.
FindBorder = Callable[[int, int], SlipBorder]


def slip_in_steps(
    contact: ContactHistory,
    first: int,
    last: int,
    least: Array,
    nearby: Indices | slice = slice(None),
) -> Array:
    """(last - first, N, d - 1) slip of the nodes in the steps between two states.

    Motion before a node touches is no slip: of a node that closes in a step no more counts than of
    those nearby that were in contact before, and nothing where these stick.

    Args:
        contact: one contact.
        first: state.
        last: state.
        least: (T,) slip of a node beyond which it counts in the step to each state.
        nearby: nodes that tell how much of the motion of closing ones is slip.
    """
    slip = np.diff(contact.slip[first : last + 1], axis=0)
    status, size = np.asarray(contact.status[first : last + 1]), np.linalg.norm(slip, axis=2)
    slips = (status[1:] == SLIP) & (size > least[first + 1 : last + 1, None])
    closes = status[:-1] == OPEN
    largest = np.where(slips & ~closes, size, 0.0)[:, nearby].max(axis=1, initial=0.0)
    counted = np.where(closes, np.minimum(size, largest[:, None]), size)
    return slip * np.where(slips, counted / np.where(size > 0, size, 1.0), 0.0)[..., None]


def cycle_states(cycle: tuple[int, int] | None) -> States:
    """States of the evaluated cycle, first and last included; empty without a cycle."""
    first, last = cycle or (0, -1)
    return np.arange(first, last + 1)


def half_cycles(
    cycle: States, memory: EdgeMemory, irregular: bool, pressed: bool
) -> tuple[HalfCycle, ...]:
    """The half cycles of an edge whose slip zones are told, in time order.

    All of them, also before the cycle; under irregular loads those with the longest zone each way.

    Args:
        cycle: states of the evaluated cycle; empty without one.
        memory: of the edge.
        irregular: whether its cycles differ.
        pressed: whether P alone drives an edge between unlike bodies. Slip then follows the edge,
            and what slipped before lies behind it: the last step is all there is.
    """
    if pressed:
        return (HalfCycle.still(max(memory.last - 1, memory.begin), memory.last),)
    found = memory.longest(cycle) if irregular else memory.half_cycles
    if irregular or not len(cycle):
        return found or (memory.still(memory.begin),)
    inside = [each for each in found if each.turn > cycle[0]]
    if not inside:
        return (memory.still(int(cycle[0])),)
    return found[:-1] if memory.cut_off(inside[-1], inside[:-1]) else found


def slip_zones(
    cycle: States, friction: Array, station: StationHistory, find_border: FindBorder
) -> tuple[SlipZone, ...]:
    """Slip zones of an edge between similar bodies in its half cycles.

    Args:
        cycle: states of the evaluated cycle.
        friction: (T,) coefficient in the step that ends at each state.
        station: position and factors.
        find_border: gives the slip zone of a half cycle.
    """
    memory = EdgeMemory.of(station, friction, last_state(cycle, station))
    if memory is None:
        return ()
    halves = half_cycles(cycle, memory, irregular=False, pressed=False)
    return zones_of(cycle, memory, halves, find_border)


def zones_of(
    cycle: States,
    memory: EdgeMemory,
    halves: Sequence[HalfCycle],
    find_border: FindBorder,
    pressed: bool = False,
    unlike: bool = False,
) -> tuple[SlipZone, ...]:
    """Slip zones of a station in its half cycles.

    Args:
        cycle: states of the evaluated cycle.
        memory: of its edge.
        halves: its half cycles that are told.
        find_border: gives the slip zone of a half cycle.
        pressed: as of `half_cycles`.
        unlike: whether bodies are unlike, so that P makes slip, which the memory leaves out.
    """
    station, friction = memory.station, memory.friction
    zones = []
    for half in halves:
        start, end = half.start, half.end
        lost = np.isnan(station.position[end])
        if lost and not unlike and memory.hold[end] >= SMALL_LOAD * memory.hold.max():
            zones.append(SlipZone.untold(start, end, half.length))
        if lost or not (unlike or memory.hold[end] > 0):
            continue  # no contact to tell one of
        acting = friction[max(start, 1) : half.turn + 1]
        # What slips as the coefficient falls shows in no factor.
        if (acting < (1 - BEHIND) * np.maximum.accumulate(acting)).any():
            zones.append(SlipZone.untold(start, half.turn))
            continue
        border = find_border(start if unlike else memory.onset(half), end)
        length, cyclic = half.length if unlike else memory.told(half), math.nan
        loop = foretold = length if memory.doubt(half) <= LEFT_OPEN else math.nan
        if unlike:
            (cyclic, loop), foretold = _prediction(cycle, friction[end], end, station), math.nan
        elif half.length == 0 and border.length > border.spread:  # slip that no edge drives
            spread = max(border.spread, border.length)
            border = replace(border, resolved=False, spread=spread)
        rests = station.k_n[end] > 0 and (unlike or station.at_rest(start, end, NOTHING))
        alike = not station.friction_behind.varies
        if math.isnan(cyclic) and not pressed and rests and alike:
            cyclic = _asymptote(memory, half)
        spread = math.hypot(border.spread, float(station.position_spread[end]))
        if pressed and border.length > 0:  # what slips depends on where the edge is in the step
            spread = math.hypot(spread, float(np.ptp(station.position[start : end + 1])))
        if not unlike and border.length > 0:
            border, doubt = _without_steps(border, memory.misplaced(half, length))
            spread = math.hypot(spread, doubt)
        missed = half.within if unlike else _missed(half, memory.fine, length)
        deepest = (start, end) if unlike or border.gross else half.deepest
        place = float(station.position[deepest[1]])  # not known of a contact of a few nodes
        inner = find_border(*deepest) if deepest[1] != end and math.isfinite(place) else border
        # Known to a good part of itself, or nothing is there to be known.
        told = border.gross or border.length == 0 or spread <= LARGEST_SPREAD * border.length
        zone = SlipZone(
            start=start,
            end=end,
            length=border.length,
            border=place + station.inward * inner.length,
            # By memory a zone is that much longer within the step; by nodes it may be.
            spread=math.hypot(spread, missed) if unlike else spread + missed,
            resolved=border.resolved and told,
            gross=border.gross,
            predicted=cyclic,
            predicted_loop=loop,
            missed=missed,
        )
        zones.append(_doubted(zone, border.spread, foretold))
    return tuple(zones)


def _asymptote(memory: EdgeMemory, half: HalfCycle) -> float:
    """Length by the published formulas at constant P: of first loading, or after a reversal."""
    station, f = memory.station, float(memory.friction[half.end])
    # Of missions from zero K_T is not known, as it is counted from there.
    along = station.k_t if math.isfinite(station.k_t[half.start]) else station.shear
    swing = abs(float(along[half.end] - along[half.start]))
    first = half in memory.half_cycles[:1] and not memory.unknown
    formula = slip_length_first_loading if first else slip_length_cyclic
    return float(formula(swing, station.k_n[half.end], f))


def _without_steps(border: SlipBorder, misplaced: float) -> tuple[SlipBorder, float]:
    """A border where it would be with fine steps of pressing, and what that leaves in doubt.

    Args:
        border: as nodes have it.
        misplaced: how much longer that is, NaN if not known.
    """
    if math.isnan(misplaced) or border.gross:
        return border, 0.0 if border.gross else math.inf
    length = max(border.length - misplaced, 0.0)
    return replace(border, length=length), MISPLACED * abs(misplaced)


def _missed(half: HalfCycle, fine: EdgeMemory, told: float) -> float:
    """Length by which a zone is longer within steps than it is as they end."""
    times = fine.times
    same = (each for each in fine.half_cycles if each.way == half.way)
    now = (each for each in same if times[each.start] < half.turn and times[each.turn] > half.start)
    return max((each.length - told for each in now if each.length > told), default=0.0)


def _doubted(zone: SlipZone, spread: float, foretold: float) -> SlipZone:
    """The zone, not resolved if no node slips though one may lie between the nodes.

    That nothing slips at all is known only where next to nothing is predicted.

    The bar of one that is not resolved reaches the prediction, which may be the better number.

    Args:
        zone: as found.
        spread: error bar of its border.
        foretold: its length by K_T and K_I of all steps, where formulas predict none; else NaN.
    """
    expected = foretold if math.isnan(zone.prediction) else zone.prediction
    hidden = zone.length == 0 and spread > 0 and not expected <= HIDDEN * spread
    if zone.gross or (zone.resolved and not hidden):
        return zone
    missed = abs(zone.length - zone.prediction)
    spread = max(zone.spread, missed) if math.isfinite(missed) else zone.spread
    return replace(zone, resolved=False, spread=spread)


def last_state(cycle: States, station: StationHistory) -> int:
    """The state with which the evaluated cycle ends, or the history without one."""
    return int(cycle[-1]) if len(cycle) else len(station.k_t) - 1


def _prediction(
    cycle: States, friction: float, end: int, station: StationHistory
) -> tuple[float, float]:
    """Slip length by ΔK_T/(f K_N) and by the general loop, if the zone is in the cycle."""
    k_n = station.k_n
    if not len(cycle) or end <= cycle[0] or not np.isfinite(k_n[end]):
        return np.nan, np.nan
    k_t, k_i, end_k_n = station.k_t[cycle], station.k_i[cycle], float(k_n[end])
    left = abs(k_t[-1] - k_t[0]) + friction * abs(k_i[-1] - k_i[0])
    if not left <= LEFT_OPEN * (np.ptp(k_t) + friction * np.ptp(k_i)):
        return np.nan, np.nan
    cyclic = slip_length_cyclic(np.ptp(k_t), end_k_n, friction)
    return float(cyclic), float(slip_length_loop(k_t, k_i, end_k_n, friction, end - int(cycle[0])))
