# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of all stations by the plane problems next to them, whatever the mesh resolves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.contacts import (
    Contact,
    Front,
    LocalProblem,
    SlipZone,
    Station,
    StationHistory,
    no_local_problem,
    reported,
)
from fretfe.evaluate.cycles import worst_cycle
from fretfe.evaluate.plane.slip import INTERVAL, slip_border
from fretfe.evaluate.slip import cycle_states
from fretfe.history.solution import ContactHistory, Solution
from fretfe.local.half_planes import Contacts
from fretfe.local.problem import EdgeHistories, EdgeSlip, Share, SlipProfile, solve_edges

# Smallest half-width over that of the reference state with which a history can be followed.
NARROWEST = 0.2
# Powers of the gap: of a cylinder, whose fronts are straight, and of what is round.
STRAIGHT, ROUND = 2.0, 3.0
# Where a front is concave the contact grows less; below this the pressure has a peak in its middle.
LEAST_POWER = 1.5
# Nodes whose slip in a half cycle is below this fraction of the largest have not slipped: before a
# cycle is quite steady a mean shear creeps by about as much behind the zone.
FAINT = 3e-3
# Radii of curvature along a bent front over which its stations are alike.
LEAST_BEND = 0.5
# Of stations next to each other so many have fits that do not see the same nodes.
INDEPENDENT = 3
# A pressure that falls behind a front over nearly all of the half-width is that of Hertz, over all.
HERTZIAN = 0.85
# Share of what the shape of the contact adds to the first order of a slip zone that is left open.
SHAPE = 0.1
# Largest part of the half-width for which the growth of a zone with its loads is told.
DEEPEST = 0.9


@dataclass(frozen=True)
class EdgeBodies:
    """The two bodies of a contact, as its edges see them.

    Attributes:
        modulus: E* in plane strain.
        antiplane: compliance across the plane over that in it.
    """

    modulus: float
    antiplane: float


def add_local_problems(
    solution: Solution,
    contacts: Sequence[Contact],
    bodies: Mapping[str, EdgeBodies],
    share: Share,
) -> tuple[Contact, ...]:
    """Solve the plane problems of all stations of solids.

    Args:
        solution: the solved history.
        contacts: evaluated.
        bodies: of each contact, by name.
        share: has parts of it solved.

    Returns:
        The contacts with `Station.local`, and the lengths of its slip zones by it.
    """
    histories = {each.name: each for each in solution.contacts}
    return tuple(
        replace(
            each,
            fronts=_fronts(solution, histories[each.name], each.fronts, bodies[each.name], share),
        )
        for each in contacts
    )


def _fronts(
    solution: Solution,
    contact: ContactHistory,
    fronts: Sequence[Front],
    bodies: EdgeBodies,
    share: Share,
) -> tuple[Front, ...]:
    """Fronts whose stations have their plane problems."""
    kept = _kept_states(solution)
    edges = [
        _Edge(solution, contact, front, station, kept)
        for front in fronts
        for station in front.stations
    ]
    found: dict[_Edge, EdgeSlip] = {}
    # Where the contact slides before the cycle, that is begun without any shear.
    for late in (False, True):
        posed = [edge for edge in edges if edge not in found and edge.begins(late)]
        if posed:
            given = _histories(solution, contact, posed, kept, bodies)
            solved = zip(posed, solve_edges(given, share), strict=True)
            found.update({edge: slip for edge, slip in solved if late or not slip.reason})
    stations = iter([edge.station(found.get(edge)) for edge in edges])
    return tuple(
        replace(front, stations=tuple(next(stations) for _ in front.stations)) for front in fronts
    )


def _kept_states(solution: Solution) -> Indices:
    """(n,) states to go through: those that repeat others only within the evaluated cycle."""
    first, last = solution.cycle or (len(solution.times), len(solution.times) - 1)
    repeated = solution.source != np.arange(len(solution.times))
    repeated[first:] = False
    return np.flatnonzero(~repeated[: last + 1])


def _histories(
    solution: Solution,
    contact: ContactHistory,
    edges: Sequence[_Edge],
    kept: Indices,
    bodies: EdgeBodies,
) -> EdgeHistories:
    """Histories of edges in the states that are gone through, and what they have in common."""
    cycle = solution.cycle
    return EdgeHistories(
        contacts=Contacts(
            half_width=np.array([each.half_width for each in edges]),
            k_n=np.array([each.k_n for each in edges]),
            power=np.array([each.power for each in edges]),
        ),
        k=np.array([each.k for each in edges]),
        k_i=np.array([each.k_i for each in edges]),
        direction=np.array([each.direction for each in edges]),
        zone=np.array([each.smallest for each in edges]),
        halves=tuple(each.halves for each in edges),
        counted=np.array([each.counted for each in edges]),
        friction=float(contact.friction[kept[-1]]),
        modulus=bodies.modulus,
        antiplane=bodies.antiplane,
        cycle=(int(np.searchsorted(kept, cycle[0])), len(kept) - 1) if cycle else None,
    )


class _Edge:
    """The plane problem of a station: what it is made of, or the reason why there is none.

    Its contact is as wide, and grows with such a power, that a slip zone is longer than to first
    order by as much as at the station: the pressure falls behind K_N √s as that of a Hertzian
    contact of the half-width `length`. Closed fronts shrink all around the contact as the stick
    zone does, as those of an ellipse: with its half axis b and the first order d1 its slip zones
    are d = b (1 - (1 - 3 d1/b)^(1/3)) (Vermeulen and Johnson).

    Attributes:
        reason: why there is no plane problem, in words; empty if there is.
        half_width, k_n, power: of the contact in the reference state.
        k, k_i: (n, 2) and (n,) in the states that are gone through.
        direction: (2,) unit vector of (K_T, K_S).
        smallest: length of the smallest slip zone that is expected.
        halves: half cycles, as numbers of states that are gone through.
        counted: (n,) whether slip in the step to each of them counts.
    """

    def __init__(
        self,
        solution: Solution,
        contact: ContactHistory,
        front: Front,
        station: Station,
        kept: Indices,
    ) -> None:
        self._station, self._source = station, solution.source
        self._friction = float(contact.friction[kept[-1]])
        self.reason = _unposed(station, self._friction)
        if self.reason:
            return
        last, angle = int(kept[-1]), math.radians(station.k_angle)
        self.k_n, self._k_n_bar = _k_n_around(front, station, last)
        length, self._shape_bar = _length_around(front, station)
        self.half_width = station.depth if length > HERTZIAN * station.depth else length
        bend = station.curvature * self.half_width
        self._locally = STRAIGHT + float(np.clip(bend, LEAST_POWER - STRAIGHT, 1.0))
        self.power = ROUND if front.closed and bend > 0 else self._locally
        self.direction = np.array([math.cos(angle), math.sin(angle)])
        cycle = cycle_states(solution.cycle)
        along = replace(station, k_t=self._along(station))
        worst = worst_cycle(station.cycles, cycle, contact.friction, along)
        counted = worst.outer if worst else np.ones(len(station.k_t), dtype=bool)
        self._outer: Bools = counted[kept]
        self._kept, self._cycle = kept, solution.cycle
        self._earliest = int(np.argmax(contact.friction[kept] > 0)) - 1
        predicted = [zone.prediction for zone in station.slip_zones]
        clear = [each for each in predicted if each > 0]
        self.smallest = min(clear, default=station.k_range / (self._friction * self.k_n))

    def _along(self, station: StationHistory) -> Array:
        return np.column_stack([station.k_t, station.k_s]) @ self.direction

    def begins(self, late: bool) -> bool:
        """Choose where the history begins to be followed; False if it cannot be.

        Nothing acts before: what K_T and K_S have reached there is a first step. The end of a
        steady cycle depends on that little.

        Args:
            late: begin with the evaluated cycle, K_T and K_S counted from the middle of their
                ranges; else as early as possible.
        """
        if self.reason or (late and self._cycle is None):
            return False
        station, kept = self._station, self._kept
        k = np.column_stack([station.k_t, station.k_s])[kept]
        k_i = station.k_i[kept] - station.k_i[kept[-1]]
        grown = 1 + 3 * k_i / (self.k_n * self.half_width)
        lost = np.flatnonzero(~(np.isfinite(k).all(axis=1) & (grown > NARROWEST**1.5)))
        self._first = max(int(lost[-1]) + 1 if len(lost) else 0, self._earliest, 0)
        start = int(np.searchsorted(kept, self._cycle[0])) if self._cycle else len(kept) - 2
        if self._first > start:
            self.reason = (
                "K_T, K_S or K_I are unknown, or the contact nearly opens, as late as in state "
                f"{int(kept[self._first - 1])}"
            )
            return False
        if late:
            self._first, cycle = start, k[start:]
            k = k - (cycle.max(axis=0) + cycle.min(axis=0)) / 2
        states = np.arange(len(kept))
        self.k = np.where(states[:, None] < max(self._first, 1), 0.0, k)
        self.k_i = np.where(states < self._first, k_i[self._first], k_i)
        self.counted = self._outer & (states > self._first)
        places = {state: number for number, state in enumerate(kept.tolist())}
        self._spans = [self._span(zone, places) for zone in station.slip_zones]
        self.halves = tuple(sorted({span for span in self._spans if span is not None}))
        if not self.halves:
            self.reason = "no half cycle can be followed"
        return not self.reason

    def _span(self, zone: SlipZone, places: Mapping[int, int]) -> tuple[int, int] | None:
        """A half cycle by the states that are gone through; None if it is not among them."""
        if zone.gross:
            return None
        for start, end in ((zone.start, zone.end), self._source[[zone.start, zone.end]].tolist()):
            if start in places and end in places and places[end] > self._first:
                return places[start], places[end]
        return None

    def station(self, found: EdgeSlip | None) -> Station:
        """The station with what was found, or with the reason why nothing was."""
        reason = found.reason if found else self.reason
        if found is None or reason:
            return replace(self._station, local=no_local_problem(reason))
        zones = [
            zone if span is None else self._zone(zone, found.profiles[self.halves.index(span)])
            for zone, span in zip(self._station.slip_zones, self._spans, strict=True)
        ]
        local = LocalProblem(
            half_width=self.half_width,
            power=self.power,
            slip=float(found.profiles[-1].slip.max()),
            work=found.work * self._round(zones),
            change=found.change,
            tractions=found.tractions,
            reason="",
        )
        return replace(self._station, slip_zones=tuple(zones), local=local)

    def _round(self, zones: Sequence[SlipZone]) -> float:
        """Friction work over that of the plane problem, by the longest of the zones."""
        longest = max((each.local for each in zones if each.local > 0), default=0.0)
        here = Contacts(*np.array([[self.half_width], [self.k_n], [self.power]]))
        return float(here.work_share(np.array([min(longest / self.half_width, DEEPEST)]))[0])

    def _zone(self, zone: SlipZone, profile: SlipProfile) -> SlipZone:
        slips = profile.slip > FAINT * profile.slip.max()
        if not slips.any():
            size = float(profile.s[1])
            return replace(zone, local=0.0, local_spread=math.hypot(size, self._open(zone, 0.0)))
        border = slip_border(profile.s, profile.slip, slips)
        if border.gross or not border.resolved:
            return zone
        bars = self._open(zone, border.length)
        spread = math.hypot(border.spread, zone.missed, bars)
        return replace(zone, local=border.length, local_spread=spread)

    def _open(self, zone: SlipZone, length: float) -> float:
        """Share of the error bar of a length by those of the factors and by the contact's shape."""
        station, b, n = self._station, self.half_width, self.power
        depth = min(length / b, DEEPEST)
        # Of d = b (1 - (1 - n d1/b)^(1/n)).
        reached = 1 - (1 - depth) ** n
        growth = reached / (n * depth * (1 - depth) ** (n - 1)) if depth > 0 else 1.0
        first_order = b * reached / n
        shear = zone.predicted if math.isfinite(zone.predicted) else length
        relative = station.k_range_spread / station.k_range if station.k_range > 0 else 0.0
        bent = abs(n - self._locally) * first_order**2 / (4 * b)
        return math.hypot(
            growth * self._k_n_bar * length,
            growth * relative * max(shear, length),
            math.hypot(SHAPE, self._shape_bar) * (length - first_order),
            bent,
        )


def _around(front: Front, station: Station) -> Indices:
    """Numbers of the stations within a half-width of one, or less where the front is bent.

    Single fits of the pressure scatter by some per cent, and what they are for varies slowly.
    """
    s = _along(front, station, front.along("arc"))
    reach = min(station.depth, LEAST_BEND / max(abs(station.curvature), 1e-300))
    return np.flatnonzero(np.abs(s) <= max(reach, float(np.sort(np.abs(s))[min(2, len(s) - 1)])))


def _along(front: Front, station: Station, arc: Array) -> Array:
    """Distances along a front from a station, the shorter way round if it is closed."""
    s = arc - station.arc
    return s - front.length * np.round(s / front.length) if front.closed else s


def _length_around(front: Front, station: Station) -> tuple[float, float]:
    """Median of `length` around a station, and its error bar over it by their scatter."""
    lengths = front.along("length")[_around(front, station)]
    middle = float(np.nanmedian(lengths))
    scatter = INTERVAL * float(np.nanstd(lengths)) / math.sqrt(len(lengths))
    return middle, scatter / middle


def _k_n_around(front: Front, station: Station, state: int) -> tuple[float, float]:
    """K_N of a state by a straight line through those around a station, and its relative bar.

    The bar is that of fits as good as those, of which `INDEPENDENT` do not see the same nodes, and
    by their scatter about the line.
    """
    stations = [front.stations[number] for number in _around(front, station)]
    told = [each for each in stations if math.isfinite(reported(*_k_n(each, state)))]
    k_n, bars = np.array([_k_n(each, state) for each in told]).T
    s = _along(front, station, np.array([each.arc for each in told]))
    order = 1 if len(told) > INDEPENDENT else 0
    weights = 1 / np.maximum(bars, 1e-3 * k_n)
    line = np.polynomial.Polynomial.fit(s, k_n, order, w=weights) if order else _mean(k_n)
    rest = INTERVAL * float(np.std(k_n - line(s))) / math.sqrt(len(told))
    own = float(np.median(bars)) / math.sqrt(min(len(told), INDEPENDENT))
    middle = float(line(0.0))
    return middle, math.hypot(own, rest) / middle


def _mean(values: Array) -> np.polynomial.Polynomial:
    return np.polynomial.Polynomial([float(values.mean())])


def _k_n(station: Station, state: int) -> tuple[float, float]:
    return float(station.k_n[state]), float(station.k_n_spread[state])


def _unposed(station: Station, friction: float) -> str:
    """Reason why a station has no plane problem; empty if it may have one."""
    if station.end:
        return "within a local length of a free end, where the fields are not those of an edge"
    if not friction > 0:
        return "there is no friction"
    last = station.last
    if not math.isfinite(reported(float(station.k_n[last]), float(station.k_n_spread[last]))):
        return "K_N is not known, or has an error bar of more than half of it"
    if not station.slip_zones:
        return "K_T and K_S are unknown, or do not vary"
    if not station.depth > 0 or not station.length > 0:
        return "the width of the contact is not known"
    return ""
