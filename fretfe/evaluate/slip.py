# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of a station, between successive reversals of the slip there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.analytic.edges import slip_length_cyclic, slip_length_first_loading, slip_length_loop
from fretfe.evaluate.contacts import SlipZone, StationHistory
from fretfe.evaluate.cycles import Worst, slip_phases
from fretfe.evaluate.edge_memory import slip_drive
from fretfe.evaluate.load_path import LoadPath
from fretfe.history.solution import OPEN, SLIP, ContactHistory

States = Indices

# Nodes whose slip in a half cycle is below this fraction of the largest slip have not slipped.
# Where slip turns round between two steps, nodes behind the border move by about as much. What is
# left out at the border is less than 1 % of the zone, which the fit of the border puts back.
SMALLEST_SLIP = 3e-4
# Where no node slips there is no slip zone if the formulas predict less than this fraction of the
# distance within which no node would see it.
HIDDEN = 1e-3
# Error bar of border and front over the length of the zone, beyond which it is not resolved.
LARGEST_SPREAD = 0.5
# The history ends with a complete half cycle if K_T is this close to its extreme, as a fraction of
# its range.
AT_EXTREME = 1e-2


@dataclass(frozen=True)
class SlipBorder:
    """Slip-zone length from the edge inward; 0 without slip, NaN if the whole patch slips.

    If not ``resolved``, too few nodes slip, or the slip does not fall to zero where the sticking
    nodes begin: the length then ends half an element inside the last slipping node.

    ``spread`` is half the width of an interval that is meant to hold the place of the border with
    95 %, 0 in closed forms; the error of the edge is not in it. Infinite if a fit has no length.
    ``beyond`` is how much farther inward the zone may end although no node shows it.
    """

    length: float
    resolved: bool
    gross: bool
    spread: float = 0.0
    beyond: float = 0.0

    @property
    def held(self) -> SlipBorder:
        """The border with a bar that holds an end of the zone which no node shows."""
        return replace(self, spread=max(self.spread, self.beyond))


@dataclass(frozen=True)
class PredictedSlip:
    """Slip-zone length of the steady cycle: at constant normal load, and by the general loop."""

    cyclic: float
    loop: float


# Part of the ranges of K_T and f K_I by which they may miss their beginning in a closed cycle:
# increments of a moving edge add up to that much.
LEFT_OPEN = 0.1
# Part of all that drives slip which is round-off.
UNDRIVEN = 1e-9
# An edge has drawn back so far that zones count from where it was before if less than this part of
# their largest length is left.
LEFT_BEHIND = 0.5
# Part by which the way of an edge may miss the border of permanent stick that it is.
SWEPT = 1e-6

# Slip zone between two states, measured from the edge at the second one, and (n,) its lengths from
# the edge in each of these states by K_T and K_I of all steps so far; none where not known.
FindBorder = Callable[[int, int], SlipBorder]
FindLengths = Callable[[int, int], Array]


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


def slip_zones(
    cycle: States,
    friction: Array,
    station: StationHistory,
    find_border: FindBorder,
    find_lengths: FindLengths = lambda *_: np.zeros(0),
    path: LoadPath | None = None,
    worst: Worst | None = None,
    pressed: bool = False,
    unlike: bool = False,
) -> tuple[SlipZone, ...]:
    """Slip zones of a station in time order.

    Args:
        cycle: states of the evaluated cycle.
        friction: (T,) coefficient in the step that ends at each state.
        station: position and factors.
        find_border: gives the slip zone of a half cycle.
        find_lengths: foretells its lengths.
        path: loads of the cycle between its steps, unless they are straight lines.
        worst: the cycle whose half cycles alone are looked at, where loads are irregular.
        pressed: whether P alone drives the edge. Slip then follows the edge, and what slipped
            before lies behind it: the last step is all there is.
        unlike: whether bodies are unlike, so that P makes slip, which no formula predicts. Between
            similar ones an edge sticks while it moves outward faster than it is sheared.
    """
    frictional = np.flatnonzero((friction > 0) & np.isfinite(station.position))
    if not len(frictional):
        return ()
    first = int(frictional[0]) - 1
    known = np.isfinite(station.k_t) & np.isfinite(station.k_i)
    begin = max(first, int(np.argmax(known)))
    last = last_state(cycle, station)
    if begin >= last or not friction[last] > 0 or not known[begin : last + 1].all():
        return ()
    fresh, gripped, pressing = begin == first, _Gripped(begin), begin
    if not unlike:
        gripped = _gripped(begin, last, cycle, float(friction.max()), station)
        begin = gripped.until
    zones = []
    halves: Sequence[tuple[int, int]] = [(max(last - 1, begin), last)]
    pressed = pressed and unlike
    if not pressed:
        halves = (
            worst.half_cycles if worst else _half_cycles(cycle, friction, station, pressing, begin)
        )
    halves = [(start, end) for start, end in halves if np.isfinite(station.position[end])]
    following = [start for start, _ in halves[1:]] + [last]
    for (start, turn), until in zip(halves, following, strict=False):
        if _falls(friction, start, max(turn, until)):  # what slips then shows in no factor
            zones.append(SlipZone.untold(start, turn))
            continue
        lengths = np.zeros(0) if pressed else find_lengths(start, turn)
        end = _longest(start, turn, lengths, station)
        border = find_border(_begun(start, end, lengths), end)
        cyclic, loop = _prediction(cycle, friction[end], end, station)
        swept = _swept(cycle, end, station, loop)
        if end != turn or (len(lengths) and swept):
            loop = float(lengths[end - start])
        elif swept and border.length - border.spread > loop:  # slip that no edge drives
            border = replace(border, resolved=False, spread=max(border.spread, border.length))
        if worst and not len(cycle) and math.isfinite(worst.predicted):
            cyclic = worst.predicted
        elif not len(cycle) and len(lengths) and (worst or _moves(station, start, end)):
            cyclic = float(lengths[end - start])
        elif fresh and start == begin and not pressed and math.isfinite(station.k_n[end]):
            rise = float(station.k_t[end] - station.k_t[begin])
            # What is locked in already leaves less of f p on that side, and more on the other.
            left = 1 - math.copysign(gripped.part, gripped.part * rise)
            rise = rise / left if left > 0 else math.nan
            cyclic = float(slip_length_first_loading(rise, station.k_n[end], friction[end]))
        spread = math.hypot(border.spread, float(station.position_spread[end]))
        if pressed and border.length > 0:  # what slips depends on where the edge is in the step
            spread = math.hypot(spread, float(np.ptp(station.position[start : end + 1])))
        if not unlike and border.length > 0:
            since = pressing
            if start > begin and len(cycle):  # others slip where the first one has
                since = max(begin, end - int(cycle[-1] - cycle[0]))
            f = float(friction.max())
            spread = math.hypot(spread, _locked_in(station, f, since, end, border.length))
        missed = _missed(cycle, friction[end], end, station, path) if path is not None else 0.0
        # A zone that is long against its edge grows faster than predicted.
        missed *= max(1.0, border.length / loop) if loop > 0 else 1.0
        zone = SlipZone(
            start=start,
            end=end,
            length=border.length,
            border=float(station.position[end]) + station.inward * border.length,
            spread=math.hypot(spread, missed),
            resolved=border.resolved and _told(border, spread),
            gross=border.gross,
            predicted=cyclic,
            predicted_loop=loop,
            missed=missed,
        )
        foretold = float(lengths[end - start]) if len(lengths) else math.nan
        zones.append(_doubted(zone, border.spread, foretold))
    return tuple(zones[0 if worst else _before_cycle(halves, cycle) :])


def _begun(start: int, end: int, lengths: Array) -> int:
    """State until which no zone is foretold; where P grows the other way may slip until then.

    Args:
        start: first state.
        end: in which the zone is looked for.
        lengths: (n,) as foretold; none where not known.
    """
    still = np.flatnonzero(lengths[: end - start] <= 0)
    return start + int(still[-1]) if len(still) else start


def _moves(station: StationHistory, start: int, end: int) -> bool:
    """True if P moves an edge between two states."""
    inside = station.k_i[start : end + 1]
    return bool(np.ptp(inside) > UNDRIVEN * np.abs(inside).max())


def _falls(friction: Array, start: int, end: int) -> bool:
    """True if a coefficient (T,) falls between two states by more than borders would show."""
    inside = friction[max(start, 1) : end + 1]
    return bool((inside < (1 - HIDDEN) * np.maximum.accumulate(inside)).any())


def _longest(start: int, end: int, lengths: Array, station: StationHistory) -> int:
    """State of a half cycle in which its slip zone is longest, if the edge leaves it behind.

    Args:
        start: first state.
        end: last state, in which slip has come to its inner end.
        lengths: (n,) as foretold; none where not known.
        station: its factors.
    """
    if not len(lengths):
        return end
    known = np.isfinite(station.position[start : end + 1] + lengths)
    longest = int(np.argmax(np.where(known, lengths, -math.inf)))
    return start + longest if lengths[-1] < LEFT_BEHIND * lengths[longest] else end


def _swept(cycle: States, end: int, station: StationHistory, loop: float) -> bool:
    """True if the edge itself draws back in a cycle to where permanent stick begins.

    Then (11) is the way of the edge, whatever slips on it. K_I falls by less, as K_N falls with it.
    """
    if not loop > 0:
        return False
    fallen = 2 * (station.k_i[end] - station.k_i[cycle].min()) / station.k_n[end]
    inward = station.inward * (station.position[cycle] - station.position[end])
    # NaN without contact: the edge has been everywhere.
    return not loop > (1 + SWEPT) * float(np.maximum(fallen, np.max(inward)))


@dataclass(frozen=True)
class _Gripped:
    """Pressing during which an edge between similar bodies sticks.

    As long as P moves it outward faster than it is sheared nothing slips, and the shear that is
    locked in behind it is that part s = dK_T/(f dK_I) of f p. Slip counts from there on.

    Attributes:
        until: last state of it.
        part: s of the last step that moves the edge.
    """

    until: int
    part: float = 0.0


def _locked_in(
    station: StationHistory, friction: float, since: int, end: int, length: float
) -> float:
    """Length by which a border may be misplaced where the edge has moved outward over it.

    Over the width da of a step nothing says where its shear, that part s = dK_T/(f dK_I) of f p, is
    locked in, so that K_T is known there to half of s f dK_I = s f K_N da/2. Slip later on the same
    way has 1 - s of f p to overcome, the other way 1 + s: that moves a border by da/2 s/(1 -+ s),
    and by da at most, as measured on half-planes up to s = .9.

    Args:
        station: its factors.
        friction: coefficient.
        since: first state whose edge counts.
        end: state of the border.
        length: from the edge to the border.
    """
    place = station.inward * station.position[since : end + 1]
    border = place[-1] + length
    covers = np.flatnonzero((place[1:] <= border) & (border < place[:-1]))
    if not len(covers):
        return 0.0
    step = int(covers[-1])
    k_t, k_i = station.k_t[since : end + 1], friction * station.k_i[since : end + 1]
    pressed, sheared = float(k_i[step + 1] - k_i[step]), float(k_t[step + 1] - k_t[step])
    if not pressed > UNDRIVEN * np.abs(k_i).max():
        return 0.0
    part, later = sheared / pressed, float(k_t[-1] - k_t[step + 1])
    left = 1 - (math.copysign(part, part * later) if later else abs(part))
    width = float(place[step] - place[step + 1])
    return width * min(abs(part) / (2 * max(left, UNDRIVEN)), 1.0)


def _gripped(
    begin: int, last: int, cycle: States, friction: float, station: StationHistory
) -> _Gripped:
    """The pressing with which an edge sticks from `begin` on, until `last` at most.

    Args:
        begin: first state.
        last: last state.
        cycle: states of the evaluated cycle, which begins no earlier than what is returned.
        friction: coefficient.
        station: its factors.
    """
    end = min(last, int(cycle[0])) if len(cycle) else last
    presses = friction * np.diff(station.k_i[begin : end + 1])
    shears = np.diff(station.k_t[begin : end + 1])
    tolerance = UNDRIVEN * max(np.abs(presses).max(initial=0.0), np.abs(shears).max(initial=0.0))
    slips = np.flatnonzero(np.abs(shears) > presses + tolerance)
    count = int(slips[0]) if len(slips) else 0
    moves = np.flatnonzero(presses[:count] > tolerance)
    if not len(moves):
        return _Gripped(begin + count)
    return _Gripped(begin + count, float(shears[moves[-1]] / presses[moves[-1]]))


def _told(border: SlipBorder, spread: float) -> bool:
    """True if the length is known to a good part of itself, or there is none to be known."""
    return border.gross or border.length == 0 or spread <= LARGEST_SPREAD * border.length


def _missed(
    cycle: States, friction: float, end: int, station: StationHistory, path: LoadPath
) -> float:
    """Length by which a zone that ends between two steps of the cycle is longer, as predicted."""
    _, sampled = _prediction(cycle, friction, end, station)
    if not np.isfinite(sampled):
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


def _half_cycles(
    cycle: States, friction: Array, station: StationHistory, begin: int, first: int
) -> list[tuple[int, int]]:
    """First and last state of each half cycle in which an edge slips one way, from `first` on.

    What places have remembered since `begin` tells when that is: at constant normal load half
    cycles end where K_T reverses. What comes after the evaluated cycle has other ranges than those
    that are told, and is left out. A cycle in which nothing drives slip on is a half cycle of its
    own.
    """
    last = last_state(cycle, station)
    k_t, k_i = station.k_t[: last + 1], station.k_i[: last + 1]
    f = friction.max()  # the same in all steps with friction
    forward, backward = k_t - f * k_i, k_t + f * k_i
    drive = np.append(np.zeros(begin), slip_drive(k_t[begin:], f * k_i[begin:]))
    phases, _ = slip_phases(drive[first:], forward[first:], backward[first:])
    ends = [first + int(end) for end in phases]
    if len(cycle) and len(ends) > 1 and ends[-1] == last:
        if not _at_extreme(forward, backward, cycle, last):
            ends.pop()
    ends = ends or [last]
    halves = list(zip([first, *ends[:-1]], ends, strict=True))
    if not len(cycle):
        return halves
    # Of a cycle in which slip neither turns round nor is driven on.
    inside = [each for half in halves for each in half if cycle[0] < each < cycle[-1]]
    if inside or _driven_on(drive[cycle], forward, backward):
        return halves
    return [*halves, (int(cycle[0]), last)]


def _before_cycle(halves: Sequence[tuple[int, int]], cycle: States) -> int:
    """Number of first half cycles that would stand among the last two, and are none of the cycle.

    First loading beside a single half cycle of it, and all before one that is the whole cycle.
    """
    if not len(cycle) or len(halves) < 2:
        return 0
    if tuple(halves[-1]) == (cycle[0], cycle[-1]):
        return len(halves) - 1
    return 1 if len(halves) == 2 and halves[0][1] <= cycle[0] else 0


def _driven_on(drive: Array, forward: Array, backward: Array) -> bool:
    """True if slip goes on beyond the first state of a cycle, by what drives it in its states."""
    within = np.abs(drive - drive[0]).max()
    return bool(within > UNDRIVEN * max(np.ptp(forward), np.ptp(backward)))


def in_cycle(cycle: States, station: StationHistory) -> StationHistory:
    """The history of a station, with the first and last state that count in it."""
    first = int(cycle[0]) if len(cycle) else -1
    return replace(station, last=last_state(cycle, station), first=first)


def last_state(cycle: States, station: StationHistory) -> int:
    """The state with which the evaluated cycle ends, or the history without one."""
    return int(cycle[-1]) if len(cycle) else len(station.k_t) - 1


def _at_extreme(forward: Array, backward: Array, states: States, last: int) -> bool:
    """True if slip one way is as far as it gets in these states: the half cycle is complete."""
    growth = forward[states].max() - forward[last]
    fall = backward[last] - backward[states].min()
    # Both counted from the same state: the length of the slip zone but for a factor.
    size = np.ptp(
        np.concatenate([forward[states] - forward[last], backward[states] - backward[last]])
    )
    return bool(min(growth, fall) < AT_EXTREME * size)


def _prediction(
    cycle: States, friction: float, end: int, station: StationHistory
) -> tuple[float, float]:
    """Slip length by ΔK_T/(f K_N) and by the general loop, if the zone is in the cycle."""
    k_n = station.k_n
    if not len(cycle) or end <= cycle[0] or not np.isfinite(k_n[end]):
        return np.nan, np.nan
    if not _closed(station, cycle, friction):
        return np.nan, np.nan
    reference = end - int(cycle[0])
    predicted = predicted_slip(
        station.k_t[cycle], station.k_i[cycle], float(k_n[end]), float(friction), reference
    )
    return predicted.cyclic, predicted.loop


def _closed(station: StationHistory, cycle: States, friction: float) -> bool:
    """True if the factors return in a cycle to what they were: formulas hold for closed ones."""
    k_t, k_i = station.k_t[cycle], friction * station.k_i[cycle]
    left = abs(k_t[-1] - k_t[0]) + abs(k_i[-1] - k_i[0])
    return bool(left <= LEFT_OPEN * (np.ptp(k_t) + np.ptp(k_i)))


def predicted_slip(
    k_t: Array, k_i: Array, k_n: float, friction: float, reference: int = 0
) -> PredictedSlip:
    """Return the slip lengths that the edge factors of one closed cycle predict.

    Args:
        k_t: (T,) K_T over the cycle.
        k_i: (T,) K_I over the cycle; zero at constant normal load.
        k_n: K_N in the reference state.
        friction: coefficient f.
        reference: index of the state whose edge the loop length is measured from.

    Raises:
        ValueError: if ``k_n`` or ``friction`` is not positive.
    """
    cyclic = slip_length_cyclic(np.ptp(k_t), k_n, friction)
    loop = slip_length_loop(k_t, k_i, k_n, friction, reference)
    return PredictedSlip(float(cyclic), float(loop))
