# SPDX-License-Identifier: LGPL-3.0-or-later
"""Memory of an edge between similar bodies: where slip goes under its loads, and how far.

A place next to an edge is named by the hold H with which the edge stands on it: K_I, each increment
taken at the size of the edge in one state, so that loads which return bring it back, however they
are divided into steps. Places are locked in with a part D of f p, -1 to 1: that with which they
were covered, dK_T/(f dK_I), or 1 the way they slipped last. Shear takes what that leaves, from the
edge inward: f (1 -+ D) dH. Where it is used up is the inner end of the slip zone; where nothing is
left the whole contact slips. For half-planes all of this is exact (Ciavarella 1998, Jaeger 1998).

Where f is not the same at all places behind the edge, places are named by G, what f makes of H:
f G is the most that shear takes there. As P moves the edge, to first order (`friction_behind`).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.contacts import SAME_RANGE, StationHistory
from fretfe.evaluate.edge_slip import (
    BEHIND,
    ROUND_OFF,
    TOLERANCE,
    HalfCycle,
    Places,
    Slip,
    follow,
    places_of,
)
from fretfe.evaluate.load_path import LoadPath, filled, straight

# The loads between the steps from one state to another.
FindPath = Callable[[tuple[int, int] | None], LoadPath | None]

# Slip that takes less than this part of f H is none: zones of so much of the half-width.
UNDRIVEN = 1e-5
# An edge leaves a zone behind if less than this part of its largest length is left.
LEFT_BEHIND = 0.5
# Part of a zone at which its inner end begins.
INNER = 0.05
# Part of the shear that other drivers may make for a history to be that of one.
MOST_APART = 0.1
# Places behind an edge at which what drives slip is told.
LEVELS = 800
# A half cycle is complete if it has come to within this part as far as another one.
COMPLETE = 1e-2


@dataclass(frozen=True)
class EdgeMemory:
    """An edge followed through all states.

    Attributes:
        station: its history.
        friction: (T,) coefficient in the step that ends at each state.
        places: behind the edge.
        gained: (T,) what the edge has gained of its hold at its place in each state.
        begin: state from which on it is followed.
        last: state up to which it is.
        rubbed: whether something may be locked in at the beginning.
        times: (T,) numbers of the states, with a share of the step for instants within one.
        loads: between the steps; None if they are straight lines.
    """

    station: StationHistory
    friction: Array
    places: Places
    gained: Array
    begin: int
    last: int
    rubbed: bool
    times: Array
    loads: LoadPath | None

    @classmethod
    def of(
        cls,
        station: StationHistory,
        friction: Array,
        last: int,
        stiffening: float = math.nan,
        half_width: float = math.nan,
        exact: bool = False,
        path: FindPath = lambda _: None,
    ) -> EdgeMemory | None:
        """Follow an edge; None where its factors are not known, or there is no friction.

        Args:
            station: its history.
            friction: (T,) coefficient in the step that ends at each state.
            last: state up to which it is followed.
            stiffening: relative growth of dP/da with the half-width.
            half_width: of the contact in the state `last` of the station.
            exact: whether its hold is known as well as its positions.
            path: gives the loads between the steps from one state to another.
        """
        inside = slice(0, last + 1)
        hold, shear = station.hold[inside], station.shear[inside]
        known = np.isfinite(hold) & np.isfinite(shear)
        lost = np.flatnonzero(~known)
        begin = max(int(lost[-1]) + 1 if len(lost) else 0, int(np.argmax(friction > 0)) - 1)
        if begin >= last or not friction[begin + 1 : last + 1].any():
            return None
        places = places_of(station, last, half_width, exact, stiffening)
        return cls(
            station=station,
            friction=friction,
            places=places,
            gained=places.gain(-station.inward * station.position, station.hold),
            begin=begin,
            last=last,
            rubbed=bool((friction[1 : begin + 1] > 0).any()) and hold[begin] > 0,
            times=np.arange(last + 1.0),
            loads=path((begin, last)),
        )

    @cached_property
    def fine(self) -> EdgeMemory:
        """The same at instants: as P moves the edge, and by the loads within steps."""
        fine = self._at(self.loads.times) if self.loads else self
        fine = self._at(fine._divided(np.ceil(16 * fine._moved)))
        ends = np.array([[half.end - 1, half.end] for half in fine.half_cycles], dtype=np.int64)
        parts = np.ones(fine.last)
        parts[ends[ends < fine.last]] = 16
        return self._at(fine._divided(parts))

    @cached_property
    def _moved(self) -> Array:
        """(T-1,) part of the loads that each step makes, 0 where P does not move the edge."""
        loads = np.array([self.hold[: self.last + 1], self.station.shear[: self.last + 1]])
        loads[:, : self.begin] = loads[:, [self.begin]]
        most = loads[0].max() or 1.0, np.ptp(loads[1]) or 1.0
        hold, shear = np.abs(np.diff(loads)) / np.array(most)[:, None]
        return np.where(hold > UNDRIVEN, np.maximum(hold, shear), 0.0)

    def _divided(self, parts: Array) -> Array:
        """Times of instants, so many (T-1,) in each step in which P moves the edge."""
        inside = np.where(self._moved > 0, parts, 1).clip(1).astype(np.int64)
        ways = (np.arange(each) / each + step for step, each in enumerate(inside.tolist()))
        return straight(self.times, np.concatenate([*ways, [self.last]]))

    def _at(self, times: Array) -> EdgeMemory:
        """The same at instants, which are its states."""
        if len(times) == len(self.times):
            return self
        station, every = self.station, slice(0, self.last + 1)
        refined = partial(self.loads.at if self.loads else straight, times=times)
        hold, shear = (refined(each[every]) for each in (station.hold, station.shear))
        # An edge that P lifts off has no place in the end, but had one within the step.
        moved = self.gained - station.hold
        position, moved = (refined(filled(each[every])) for each in (station.position, moved))
        gained = hold + moved
        unit = np.array([*map(self.places.unit_at, gained.tolist())])
        ends = np.ceil(times).astype(np.int64)
        begin, last = np.searchsorted(times, (self.begin, station.last % len(station.hold)))
        station = replace(
            station,
            position=position,
            hold=hold,
            shear=shear,
            unit=unit,
            slid=np.where(times == ends, station.slid[ends], 0.0),
            last=int(last),
        )
        return replace(
            self,
            station=station,
            friction=self.friction[ends],
            gained=gained,
            begin=int(begin),
            last=len(times) - 1,
            times=times,
            loads=None,
        )

    @cached_property
    def _made(self) -> tuple[Array, Array] | None:
        """Holds (n,), from 0 on, and what friction makes of them; None if f is the same."""
        behind, station = self.station.friction_behind, self.station
        if not behind.varies:
            return None
        most = self.begin + int(np.nanargmax(station.hold[self.begin : self.last + 1]))
        holds = np.linspace(0.0, float(station.hold[most]), LEVELS)
        lengths = np.array([self._inward(most, each) for each in holds.tolist()])
        lengths[np.isnan(lengths)] = np.nanmax(lengths)
        edge = float(station.hold[station.last])
        edge = edge if edge > 0 else float(holds[-1])
        places = station.inward * float(station.position[most]) + lengths
        return holds, behind.made(holds, places, edge)

    def made(self, hold: Array) -> Array:
        """(n,) what friction makes of holds (n,)."""
        return hold if self._made is None else np.asarray(np.interp(hold, *self._made))

    def hold_of(self, made: float) -> float:
        """Hold of which friction makes so much."""
        if self._made is None:
            return made
        holds, friction_makes = self._made
        return float(np.interp(made, friction_makes, holds))

    @cached_property
    def hold(self) -> Array:
        """(T,) what friction makes of the hold of the edge."""
        return self.made(self.station.hold)

    @property
    def unknown(self) -> float:
        """Hold up to which nothing is known of what is locked in; 0 if there is none."""
        return float(self.hold[self.begin]) if self.rubbed else 0.0

    @cached_property
    def slip(self) -> Slip:
        """The slip in all steps."""
        return self._followed(at_once=False)

    def _followed(self, *, at_once: bool) -> Slip:
        station = replace(self.station, hold=self.hold)
        return follow(station, self.friction[: self.last + 1], self.begin, at_once=at_once)

    @cached_property
    def of_nodes(self) -> Slip:
        """The slip if places are covered as steps begin, as nodes close in the solved ones."""
        return self._followed(at_once=True)

    def length(self, state: int, front: float) -> float:
        """Length from the edge in a state to the place of a hold; NaN if that is not known."""
        if not front < self.hold[state]:
            return 0.0
        if front <= 0.0:
            return math.nan
        return self._inward(state, self.hold_of(front))

    def _inward(self, state: int, inner: float) -> float:
        """Length from the edge in a state to where it stands on another hold."""
        gained = float(self.gained[state])
        less = float(self.station.hold[state]) - inner
        return max(self.places.at(gained) - self.places.at(gained - less), 0.0)

    @cached_property
    def _phases(self) -> list[tuple[int, int]]:
        """Last state of each phase in which slip goes one way, and that way, in time order.

        An edge may stick in between. It slips the same way twice if it has covered new places
        meanwhile, on which slip does not come to that before.
        """
        taken, f_hold = self.slip.taken, self.friction.max() * np.nanmax(self.hold)
        least = max(TOLERANCE * float(taken.max(initial=0.0)), UNDRIVEN * float(f_hold))
        ways, fronts, hold = self.slip.way.astype(int), self.slip.front, self.hold
        apart = np.cumsum(hold[: len(ways)] <= 0)  # what was before is forgotten
        phases: list[tuple[int, int]] = []
        going, since = 0, 0.0
        for state in np.flatnonzero(taken > 0).tolist():
            way = ways[state]
            going, since = way, taken[state] + (since if way == going else 0.0)
            if not since > least:
                continue
            while (
                phases
                and phases[-1][1] == way
                and apart[phases[-1][0]] == apart[state]
                and fronts[state] <= hold[phases[-1][0]]
            ):
                phases.pop()
            phases.append((state, way))
        return phases

    @cached_property
    def half_cycles(self) -> tuple[HalfCycle, ...]:
        """All half cycles, in time order; the last one may not be complete."""
        phases = self._phases
        if not phases:
            return ()
        slips = np.flatnonzero(self.slip.way == phases[0][1])
        starts = [int(slips[0]) - 1, *(end for end, _ in phases[:-1])]
        return tuple(
            self._half(start, turn, way) for start, (turn, way) in zip(starts, phases, strict=True)
        )

    @cached_property
    def recurring(self) -> tuple[HalfCycle, ...]:
        """Half cycles without first loading that a later one exceeds: slip comes so far once."""
        swings = np.array([*map(self._swing, self.half_cycles), 0.0])
        later = (1 + SAME_RANGE) * np.maximum.accumulate(swings[:0:-1])[::-1]
        pairs = zip(self.half_cycles, swings, later, strict=False)
        return tuple(each for each, own, most in pairs if own > most or not self._once(each))

    def _swing(self, half: HalfCycle) -> float:
        return abs(float(self.station.shear[half.end] - self.station.shear[half.start]))

    def _once(self, half: HalfCycle) -> bool:
        """True if the inner end of a zone has not slipped back before, and the edge stays then."""
        since, inner = self._since(half), self._inner(half)
        slipped = self.slip.way[since] == -half.way and self.slip.front[since] <= inner
        moved = float(np.ptp(self.hold[half.start : self.last + 1]))
        return not slipped and moved <= inner - half.front

    def largest(self, first: int = -1) -> HalfCycle | None:
        """The half cycle with the largest equivalent range that ends after a state; None without.

        Those in which the whole contact slips do not count: they have none. The last of equal ones.
        """
        known = [e for e in self.recurring if e.turn > first and math.isfinite(e.length)]
        size = max(map(self.equivalent_range, known), default=0.0)
        equal = [e for e in known if self.equivalent_range(e) >= (1 - SAME_RANGE) * size]
        return equal[-1] if size > 0 else None

    def still(self, first: int) -> HalfCycle:
        """One from a state on in which nothing slips, as far as there is a contact to tell that."""
        seen = np.isfinite(self.station.position)
        hold = np.where(seen, np.maximum(self.hold, 0.0), 0.0)[first + 1 : self.last + 1]
        held = np.flatnonzero(hold >= LEFT_BEHIND * hold.max())
        return HalfCycle.still(first, first + 1 + int(held[-1]))

    def equivalent_range(self, half: HalfCycle) -> float:
        """Range f K_N d by what the edge stands on down to the inner end: dK_T at constant P.

        In first loading it is twice that of K_T, as places then take half of what they take later.
        """
        f, unit = float(self.friction[half.end]), float(self.station.unit[half.end])
        return 2 * f * unit * (float(self.hold[half.end]) - half.front) if half.way else 0.0

    def misheld(self, half: HalfCycle) -> float:
        """Part of an equivalent range that is in doubt: edges move otherwise than their hold tells.

        So they do between finite bodies that slip. And the instant in which a zone is longest.
        """
        ends, beside = [half.start, half.end], (half.end - 1, half.end + 1)
        missed = float(np.diff(self.gained[ends] - self.station.hold[ends])[0])
        missed *= 2 * float(self.friction[half.end] * self.station.unit[half.end])
        # A zone may jump in an instant, and is as long as in the next or in the last one.
        near = (replace(half, end=e, front=self.slip.front[e]) for e in beside if e <= self.last)
        size = self.equivalent_range(half)
        apart = np.abs([size - self.equivalent_range(each) for each in near])
        least = float(np.min(apart[np.isfinite(apart)], initial=size))
        return math.hypot(missed, least if self.times[half.end] % 1 else 0.0)

    @property
    def sure(self) -> bool:
        """True if one driver makes the shear, or P does not move the edge: ranges hold then."""
        return self.station.apart <= MOST_APART or self.station.at_rest(self.begin, self.last)

    def doubt(self, half: HalfCycle) -> float:
        """Part of its equivalent range by which that of a half cycle may be off; 0 with one driver.

        What cycles of several leave over of the shear, whether its zone jumps by that, and, where P
        moves the edge, how far they are apart: half-planes under P, Q and tension are off by .23.
        """
        station, end = self.station, half.end
        moves = half.way and not station.at_rest(half.start, end)
        apart = station.apart / 4 if moves else 0.0
        if not (half.way and station.loose):
            return apart
        left = station.loose * float(np.nanmax(station.shear) - np.nanmin(station.shear))
        jumped = replace(self.slip, behind=BEHIND).between(half.start, end, half.way).front
        jump = 2 * float(self.friction[end] * station.unit[end]) * abs(half.front - jumped)
        return math.hypot(apart, (left + jump) / self.equivalent_range(half))

    def longest(self, cycle: Sequence[int] | Indices) -> tuple[HalfCycle, ...]:
        """The half cycles with the longest zone forward and backward that end in a cycle.

        Of all without one. And those in which the whole contact slips. Each from where places at
        its inner end were covered or slipped the other way last; smaller ones lie within.
        """
        found, first = [], int(cycle[0]) if len(cycle) else self.begin
        for way, slides in itertools.product((1, -1), (True, False)):
            own = [each for each in self.recurring if each.way == way and each.end > first]
            own = [each for each in own if math.isnan(each.length) is slides]
            least = (1 - SAME_RANGE) * max((each.length for each in own), default=0.0)
            longest = [each for each in own if slides or each.length >= least]
            found += [replace(each, start=self._since(each)) for each in longest[-1:]]
        return tuple(sorted(found, key=lambda each: each.end))

    def _since(self, half: HalfCycle) -> int:
        """Last state before a half cycle in which its inner end was covered, or slipped back."""
        inner, before = self._inner(half), np.arange(self.begin, half.start + 1)
        slipped = (self.slip.way[before] == -half.way) & (self.slip.front[before] <= inner)
        there = np.flatnonzero((self.hold[before] <= inner) | slipped)
        return int(before[there[-1]]) if len(there) else self.begin

    def _inner(self, half: HalfCycle) -> float:
        """Hold of places next to the inner end of a zone."""
        return half.front + INNER * float(self.hold[half.end] - half.front)

    def outer(self, halves: Sequence[HalfCycle]) -> Bools:
        """(T,) steps to states in which zones of half cycles get longer, or outside of them all."""
        counts, within = np.zeros((2, len(self.friction)), dtype=bool)
        for half in halves:
            steps = slice(half.start + 1, half.end + 1)
            fronts = np.where(self.slip.way[steps] == half.way, self.slip.front[steps], math.inf)
            before = np.append(math.inf, np.minimum.accumulate(fronts)[:-1])
            counts[steps] |= (fronts < before) | (fronts <= 0)
            within[steps] = True
        return np.asarray(counts | ~within)

    def path(self, halves: Sequence[HalfCycle]) -> Indices:
        """(n,) states on the way through half cycles, without those in smaller ones.

        Empty if P moves the edge meanwhile: what that does counts, too.
        """
        first, last = halves[0].start, max(each.end for each in halves)
        if not self.station.at_rest(first, last):
            return np.zeros(0, dtype=np.int64)
        steps = np.arange(first + 1, last + 1)
        return np.append(first, steps[self.outer(halves)[steps]])

    def cut_off(self, half: HalfCycle, others: Sequence[HalfCycle]) -> bool:
        """True if the history ends before slip has come as far as in another, larger zone."""
        size = float(self.hold[half.end]) - half.front
        larger = (e for e in others if self.hold[e.end] - e.front > size and e.way == half.way)
        return half.front - min((e.front for e in larger), default=math.inf) > COMPLETE * size

    def onset(self, half: HalfCycle) -> int:
        """State of a half cycle before which nothing slips."""
        if not half.way:
            return half.start
        return half.start + int(np.argmax(self.slip.way[half.start + 1 : half.end + 1] == half.way))

    def misplaced(self, half: HalfCycle, told: float) -> float:
        """Length by which nodes find a zone longer than it is where steps have covered its end.

        Nodes close in solved states: what a step shears while it covers places is there as if they
        had been covered when it began, and by straight loads. NaN if then the whole contact slips.
        """
        if not half.way or math.isnan(half.length):
            return 0.0
        found = self.of_nodes.between(self.onset(half), half.end, half.way).front
        return self.length(half.end, found) - told

    def told(self, half: HalfCycle) -> float:
        """Length of the zone of a half cycle, as the loads between steps have it."""
        if not half.way or math.isnan(half.length):
            return half.length
        fine = self.fine
        start, end = np.searchsorted(fine.times, (self.onset(half), half.end)).tolist()
        # What slips by straight loads may have stopped by these, or not slip at all.
        slips = np.flatnonzero(fine.slip.way[: end + 1] == half.way)
        end = int(slips[-1]) if len(slips) else start
        return fine.length(end, fine.slip.between(start, end, half.way).front)

    def _half(self, start: int, turn: int, way: int) -> HalfCycle:
        """A half cycle with the state in which its zone is told."""
        stretches = self._stretches(start, turn, way)
        states, fronts, begins = (np.array(each) for each in zip(*stretches, strict=True))
        lengths = np.array([self.length(state, front) for state, front, _ in stretches])
        known = lengths[np.isfinite(lengths)]
        # That all slides in the end does not count if little is left of its zone by then.
        little = len(known) > 0 and known[-1] < LEFT_BEHIND * known.max()
        lengths = np.where((fronts <= 0) & (not little), math.inf, np.nan_to_num(lengths))
        inner = int(np.flatnonzero(fronts <= fronts[-1])[0])
        deepest = int(begins[inner]), int(states[inner])
        while True:
            at = int(np.flatnonzero(lengths >= (1 - ROUND_OFF) * lengths.max())[-1])
            start, front, end = int(begins[at]), float(fronts[at]), int(states[at])
            driven = self.slip.between(start, end, way).front
            if driven <= front:
                break
            # A loop that closes touches an older front: that is not how far its slip comes.
            fronts[at], lengths[at] = driven, np.nan_to_num(self.length(end, driven))
        length = self.length(end, front) if self.knows(front, start) else math.nan
        return HalfCycle(start, turn, end, way, front, length, deepest)

    def _stretches(self, start: int, turn: int, way: int) -> list[tuple[int, float, int]]:
        """States in which an edge slips one way, inner end of what has slipped so, since when.

        What is uncovered meanwhile does not count any more, nor what lies behind places that have
        been covered since and stick.
        """
        found, apart = [], list[tuple[float, float, int]]()  # inner and outer ends, outward
        slips = self.slip.way == way
        for state in range(start + 1, turn + 1):
            hold = float(self.hold[state])
            while apart and apart[-1][0] >= hold:
                apart.pop()
            if apart:
                apart[-1] = apart[-1][0], min(apart[-1][1], hold), apart[-1][2]
            if slips[state]:
                inner, since = float(self.slip.front[state]), state - 1
                while apart and apart[-1][1] >= inner:
                    inner, since = min(inner, apart[-1][0]), apart.pop()[2]
                apart.append((inner, hold, since))
                found.append((state, inner, since))
        return found

    def knows(self, front: float, state: int) -> bool:
        """True if what has been locked in up to a place until a state is known: all has slipped."""
        if front >= self.unknown:
            return True
        slipped = self.slip.front[self.begin : state + 1]
        deepest = float(np.nanmin(slipped)) if np.isfinite(slipped).any() else math.inf
        return front >= deepest - BEHIND * (self.unknown - deepest)
