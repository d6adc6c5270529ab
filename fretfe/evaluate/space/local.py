# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of all stations by the plane problems next to them, whatever the mesh resolves."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.edges import oscillation
from fretfe.case import AnyBody, isotropic
from fretfe.evaluate.contacts import (
    LARGEST_TURNING,
    Contact,
    Frame,
    Front,
    LocalProblem,
    SlipZone,
    Station,
    no_local_problem,
)
from fretfe.evaluate.cycles import same_cycles
from fretfe.evaluate.edge_memory import INNER, LEFT_BEHIND, EdgeMemory
from fretfe.evaluate.edge_zone import rise_length
from fretfe.evaluate.factors import whole_factor
from fretfe.evaluate.loaded import loaded, normal_force
from fretfe.evaluate.plane.slip import INTERVAL, UNSEEN, slip_border
from fretfe.evaluate.space.pressure_fit import load_growth
from fretfe.evaluate.withheld import withheld
from fretfe.history.solution import ContactHistory, Solution
from fretfe.local.batches import Share, solve_batches, solve_edges
from fretfe.local.half_planes import Contacts, work_share
from fretfe.local.problem import (
    SLIDES,
    UNSETTLED,
    EdgeHistories,
    EdgeSlip,
    SlipProfile,
    Tractions,
)
from fretfe.materials.moduli import half_plane
from fretfe.reason import Kind

# Smallest half-width over that of the reference state with which a history can be followed.
NARROWEST = 0.2
# Powers of the gap: of a cylinder, whose fronts are straight; of what is round, under shear; and
# under twist, by which slip zones are within 1 % of those of a twisted sphere (Lubkin 1951) as far
# as .3 of its radius.
STRAIGHT = 2.0
ROUND = 3.0
TWISTED = 3.5
# Where a front is concave the contact grows less; below this the pressure has a peak in its middle.
LEAST_POWER = 1.5
# Nodes whose slip in a half cycle is below this fraction of the largest have not slipped: before a
# cycle is quite steady a mean shear creeps by about as much behind the zone.
FAINT = 3e-3
# Radii of curvature along a bent front over which its stations are alike.
LEAST_BEND = 0.5
# Of stations next to each other so many have fits that do not see the same nodes.
INDEPENDENT = 3
# Variance of the middle of a parabola through many points over that of their mean.
LESS = 2.25
# A pressure that falls behind a front over nearly all of the half-width is that of Hertz, over all.
HERTZIAN = 0.85
# Share of what the shape of the contact adds to the first order of a slip zone that is left open.
SHAPE = 0.1
# Error of a slip zone because pressure and shear of crystals displace points across one another, as
# the plane problem leaves out, over f times `EdgeBodies.coupling`: measured on half-planes, up to
# 3.8 f beta (f beta = .02 to .16) and 1.7 f times the cross compliance (f times it up to .12).
UNLIKE = 2.0
# Between unlike bodies K_N is that of both ends of the cycle in the mean at this part of the length
# of the slip zone, e^2/4: by the power law it differs there by (2 - 2 ln 2) f beta/pi.
MEAN_LENGTH = math.exp(2 - 2 * math.log(2))
# Largest part of the half-width for which the growth of a zone with its loads is told.
DEEPEST = 0.9
PASSED = "slip passes the rounding next to the front: how far depends on the contact as a whole"


@dataclass(frozen=True)
class EdgeBodies:
    """The two bodies of a contact next to a station.

    Attributes:
        modulus: E* by the compliance to pressure; in plane strain.
        tangential: (2, 2) compliance to shear inward and along the front over that to pressure.
        coupling: displacements that pressure and shear of crystals cause of each other, over those
            by themselves: the cross compliance, and beta, twice. Zero of isotropic bodies, whose
            beta the plane problem knows.
    """

    modulus: float
    tangential: Array
    coupling: float

    @classmethod
    def of(cls, bodies: Sequence[AnyBody], frame: Frame) -> EdgeBodies:
        """That of two bodies in the frame of a station."""
        axes = np.array([frame.across, frame.inward, frame.along])
        first, second = (half_plane(body, "strain", axes) for body in bodies)
        both, skew = first.compliance + second.compliance, first.skew - second.skew
        root = np.sqrt(np.diag(both))
        cross = ((np.abs(both) + 2 * np.abs(skew)) / np.outer(root, root))[0, 1:]
        if all(isotropic(each) for each in bodies):
            cross = np.zeros(2)
        return cls(
            modulus=2 / float(both[0, 0]),
            tangential=both[1:, 1:] / both[0, 0],
            coupling=float(np.linalg.norm(cross)),
        )


def add_local_problems(
    solution: Solution, contacts: Sequence[Contact], bodies: Mapping[str, AnyBody], share: Share
) -> tuple[Contact, ...]:
    """Solve the plane problems of all stations of solids.

    Args:
        solution: the solved history.
        contacts: evaluated.
        bodies: of the case.
        share: has parts of it solved.

    Returns:
        The contacts with `Station.local`, and the lengths of its slip zones by it.
    """
    histories = {each.name: each for each in solution.contacts}
    return tuple(
        replace(each, fronts=_fronts(solution, histories[each.name], each.fronts, bodies, share))
        for each in contacts
    )


def _fronts(
    solution: Solution,
    contact: ContactHistory,
    fronts: Sequence[Front],
    bodies: Mapping[str, AnyBody],
    share: Share,
) -> tuple[Front, ...]:
    """Fronts whose stations have their plane problems."""
    posed = [(front, each) for front in fronts for each in front.stations]
    found = _solved(_Path.of(solution, contact), bodies, posed, share)
    done = {
        (station.front, station.number): replace(station, local=no_local_problem(each))
        if isinstance(each, str)
        else each[0].solved(each[1])
        for (_, station), each in zip(posed, found, strict=True)
    }
    return tuple(
        _with_work(front, [done[front.name, each.number] for each in front.stations])
        for front in fronts
    )


def _solved(
    path: _Path,
    bodies: Mapping[str, AnyBody],
    stations: Sequence[tuple[Front, Station]],
    share: Share,
    shown: tuple[int, ...] = (),
) -> list[tuple[_Edge, EdgeSlip] | str]:
    """The plane problems of stations with their solutions, or the reasons why there is none.

    Where a contact would slide before the cycle, that is begun without any shear.

    Args:
        path: through the states.
        bodies: of the case.
        stations: with their fronts.
        share: has parts of it solved.
        shown: as of `EdgeHistories`.
    """
    pair = bodies[path.contact.body1], bodies[path.contact.body2]
    beta = path.contact.surface.dundurs
    twists = {front.name: _twist(front) for front, _ in stations}
    done: dict[int, tuple[_Edge, EdgeSlip] | str] = {}
    left = list(range(len(stations)))
    for late in (False, True) if path.cycle else (False,):
        posed = {
            key: _pose(path, pair, beta, *stations[key], twists[stations[key][0].name], late)
            for key in left
        }
        edges = {key: edge for key, edge in posed.items() if isinstance(edge, _Edge)}
        histories = _histories(edges.values(), path, beta, shown) if edges else None
        found = solve_edges(histories, share) if histories else []
        done |= {key: reason for key, reason in posed.items() if isinstance(reason, str)}
        solved = dict(zip(edges, found, strict=True))
        done |= {key: (edges[key], slip) for key, slip in solved.items()}
        left = [key for key, slip in solved.items() if slip.reason in (SLIDES, UNSETTLED)]
    return [done[key] for key in range(len(stations))]


@dataclass(frozen=True)
class PlaneTractions:
    """Tractions of the plane problem of a station, on all of its contact, through n states.

    Attributes:
        x: (K,) distances inward from the outermost place of the edge in these states.
        pressure: (n, K) p.
        shear: (n, K, 2) along `inward` and `along` of the station, on body 2.
    """

    x: Array
    pressure: Array
    shear: Array


def plane_tractions(
    solution: Solution,
    contact: ContactHistory,
    stations: Sequence[tuple[Front, Station]],
    bodies: Mapping[str, AnyBody],
    states: Indices,
) -> list[PlaneTractions | str]:
    """Solve the plane problems of some stations again, for their tractions in many states.

    Args:
        solution: the solved history.
        contact: whose stations they are, of bodies of one material.
        stations: with their fronts.
        bodies: of the case.
        states: (n,) wanted, in time order.

    Returns:
        The tractions of each, zero without contact, or the reason why they are not known.
    """
    path, carries = _Path.of(solution, contact), loaded(normal_force(contact))[states]
    places = [path.place(each) for each in states[carries].tolist()]
    shown = tuple(sorted(set(places)))
    found: list[PlaneTractions | str] = []
    for solved in _solved(path, bodies, stations, solve_batches, shown):
        if isinstance(solved, str) or solved[1].reason:
            found.append(solved if isinstance(solved, str) else solved[1].reason)
        elif shown[0] < max(solved[0].loads.first, 1):
            found.append("its plane problem is not followed in all states of the cycle")
        else:
            rows = [shown.index(each) for each in places]
            found.append(_whole(list(solved[1].tractions.values()), rows, carries))
    return found


def _whole(tractions: Sequence[Tractions], rows: Sequence[int], carries: Bools) -> PlaneTractions:
    """Tractions in all states at the same nodes, from those next to the edge as it is in each.

    All of them reach to the middle of the contact, where its other half begins.

    Args:
        tractions: in states that differ.
        rows: (m,) numbers of those in the states with contact.
        carries: (n,) which of all states these are.
    """
    x = max((each.s for each in tractions), key=lambda s: float(s[-1]))
    count = len(x)
    values = np.zeros((len(tractions), count, 3))
    for own, each in zip(values, tractions, strict=True):
        own[count - len(each.s) :] = np.column_stack([each.pressure, each.shear])
    whole = np.zeros((len(carries), 2 * count - 1, 3))
    whole[carries] = np.concatenate([values, values[:, -2::-1]], axis=1)[rows]
    x = np.concatenate([x, 2 * x[-1] - x[-2::-1]])
    return PlaneTractions(x, whole[..., 0], whole[..., 1:])


def _with_work(front: Front, stations: Sequence[Station]) -> Front:
    """A front with its solved stations, evenly spaced, and their friction work over its length."""
    part = front.length / len(stations)
    works = [each.local.work for each in stations if math.isfinite(each.local.work)]
    return replace(
        front,
        stations=tuple(stations),
        local_work=part * sum(works) if works else math.nan,
        local_length=part * len(works),
    )


@dataclass(frozen=True)
class _Path:
    """The way through the states of a history.

    States that repeat others are left out before the cycle. Of the cycles that lead to it with the
    same loads only the last one is gone through: it is then repeated until it is steady.

    Attributes:
        kept: (n,) states to go through.
        source: (T,) the state that each state is the same as.
        contact: the contact.
        evaluated: first and last state of the evaluated cycle, or None.
        cycle: the same if it is repeated: bodies that part at its ends remember nothing, and it is
            gone through once, up to the last state with contact.
        step_of: the step of the case in which a state lies.
    """

    kept: Indices
    source: Indices
    contact: ContactHistory
    evaluated: tuple[int, int] | None
    cycle: tuple[int, int] | None
    step_of: Callable[[int], int]

    @classmethod
    def of(cls, solution: Solution, contact: ContactHistory) -> _Path:
        """That of a contact."""
        first, last = solution.cycle or (len(solution.times), len(solution.times) - 1)
        left_out = solution.source != np.arange(len(solution.times))
        own, *before = [begin for begin, _ in same_cycles(solution, contact.friction)] or [first]
        left_out[before[-1] if before else own : before[0] if before else own] = True
        left_out[before[0] if before else first :] = False  # half cycles begin in the one before
        carries = np.flatnonzero(loaded(normal_force(contact))[: last + 1])
        end = int(carries[-1]) if len(carries) else last
        cycle = solution.cycle if end == last else None
        kept = np.flatnonzero(~left_out[: end + 1])
        return cls(kept, solution.source, contact, solution.cycle, cycle, solution.step_of)

    @cached_property
    def first(self) -> int:
        """Place among the kept states from which on there is friction."""
        return max(int(np.argmax(self.contact.friction.acts[self.kept])) - 1, 0)

    @property
    def begin(self) -> int:
        """Place of the first state of the cycle; without one of the last but one."""
        if self.cycle is None:
            return len(self.kept) - 2
        return int(np.searchsorted(self.kept, self.cycle[0]))

    @cached_property
    def places(self) -> dict[int, int]:
        """Places of the kept states among themselves, by state."""
        return {state: place for place, state in enumerate(self.kept.tolist())}

    def peak(self, station: Station) -> float:
        """Largest pressure next to a station, as far away as the middle of the contact."""
        near = np.linalg.norm(self.contact.surface.points - station.point, axis=1) < station.depth
        return float(self.contact.mean_traction[station.last][near, 0].max(initial=0.0))

    def place(self, state: int) -> int:
        """Place of a state or of one that it repeats; -1 if it is not on the way."""
        return self.places.get(state, self.places.get(int(self.source[state]), -1))

    def span(self, zone: SlipZone, first: int, last: int) -> tuple[int, int] | None:
        """Places of the ends of a half cycle, or of one that it repeats; None if not on the way."""
        places = self.places
        for start, end in ((zone.start, zone.end), self.source[[zone.start, zone.end]].tolist()):
            if start in places and first < places.get(end, -1) <= last:
                return places[start], places[end]
        return None


def _histories(
    edges: Collection[_Edge], path: _Path, dundurs: float, shown: tuple[int, ...]
) -> EdgeHistories:
    """Histories of edges, and what they have in common."""
    shapes = [each.shape for each in edges]
    return EdgeHistories(
        contacts=Contacts(
            half_width=np.array([each.half_width for each in shapes]),
            k_n=np.array([each.k_n for each in shapes]),
            power=np.array([each.power for each in shapes]),
        ),
        k=np.array([each.loads.k for each in edges]),
        k_i=np.array([each.loads.k_i for each in edges]),
        locked=np.array([each.loads.locked for each in edges]),
        direction=np.array([each.station.direction for each in edges]),
        zone=np.array([each.smallest for each in edges]),
        halves=tuple(each.halves for each in edges),
        counted=np.array([each.counted for each in edges]),
        friction=np.array([each.station.friction for each in edges]),
        behind=tuple(each.behind for each in edges),
        modulus=np.array([each.bodies.modulus for each in edges]),
        tangential=np.array([each.bodies.tangential for each in edges]),
        cycle=(path.begin, len(path.kept) - 1) if path.cycle else None,
        dundurs=dundurs,
        shown=shown,
    )


@dataclass(frozen=True)
class _Shape:
    """The contact of half-planes that stands for an edge, in the state `last` of the station.

    It is as wide, and grows with such a power, that a slip zone is longer than to first order by as
    much as at the station: dP/da grows at the same rate, which `load_growth` takes from the
    pressure behind K_N √s, and a bent front gets longer.
    Closed fronts shrink all around the contact as the stick zone does, as those of an ellipse: with
    its half axis b and the first order d1 its slip zones are d = b (1 - (1 - 3 d1/b)^(1/3))
    (Vermeulen and Johnson). Between the axes of an ellipse that is so to 1 % if b is the geometric
    mean of half of the chord along `inward` and of the distance of the tangent from the centre.

    Attributes:
        half_width, k_n, power: of the contact.
        locally: the power by the curvature of the front alone.
        k_n_bar, length_bar: relative error bars of K_N and of `length`.
        twist: share of the shear that turns with the front.
        reach: longest slip zone of which it tells; infinite if it is as wide as the contact itself.
    """

    half_width: float
    k_n: float
    power: float
    locally: float
    k_n_bar: float
    length_bar: float
    twist: float
    reach: float

    @classmethod
    def of(cls, front: Front, station: Station, twist: float, peak: float) -> _Shape:
        """That of a station of a front, where `_twist` of the shear is twist.

        Args:
            front: of the station.
            station: it.
            twist: share of the shear.
            peak: largest pressure next to the station.
        """
        k_n, k_n_bar = _k_n_around(front, station)
        length, length_bar = _length_around(front, station)
        width, whole = _width(front, station), length > HERTZIAN * station.depth
        half_width = width if whole else 1 / load_growth(length, width)
        # Behind the rounding of a flat, of three rises, the hold falls with the power 3/2 of what
        # is left of it, not 2: zones of half of it are 2 % too short, and all is passed where the
        # plane problem has 2.5 rises.
        reach = math.inf if whole else 3 / 2 * rise_length(peak, k_n, width)
        bend = station.curvature * half_width
        locally = STRAIGHT + float(np.clip(bend, LEAST_POWER - STRAIGHT, 1.0))
        round_power = ROUND + twist * (TWISTED - ROUND)
        all_round = STRAIGHT + (round_power - STRAIGHT) * half_width / width
        power = all_round if front.closed and bend > 0 else locally
        return cls(half_width, k_n, power, locally, k_n_bar, length_bar, twist, reach)

    def bar(self, length: float, first_order: float, range_bar: float) -> float:
        """Share of the error bar of a slip zone by those of the factors and by the shape.

        Args:
            length: of the zone.
            first_order: by the factors.
            range_bar: relative error bar of the range of (K_T, K_S).
        """
        b, n = self.half_width, self.power
        depth = min(length / b, DEEPEST)
        # Of d = b (1 - (1 - n d1/b)^(1/n)).
        reached = 1 - (1 - depth) ** n
        growth = reached / (n * depth * (1 - depth) ** (n - 1)) if depth > 0 else 1.0
        straight = b * reached / n
        return math.hypot(
            growth * self.k_n_bar * length,
            growth * range_bar * max(first_order, length),
            math.hypot(SHAPE, self.length_bar) * (length - straight),
            abs(n - self.locally) * straight**2 / (4 * b),
        )


@dataclass(frozen=True)
class _Loads:
    """Loads of the plane problem of a station in the n states that are gone through.

    From a state without contact to the first one that is followed K_T and K_S grow in proportion to
    K_I, and what sticks then carries as much shear over its pressure. Where there is no such state
    nothing acts before, and what they have reached is a first step: the end of a steady cycle
    depends on that little.

    Attributes:
        k, k_i: (n, 2) and (n,), constant up to the first one.
        locked: (2,) shear over the pressure there.
        first: place of that state.
        last: place of the last one that is followed: then all stays as it is.
    """

    k: Array
    k_i: Array
    locked: Array
    first: int
    last: int

    @classmethod
    def of(cls, path: _Path, station: Station, shape: _Shape, dundurs: float) -> _Loads:
        """Those as early as the factors are known."""
        kept = path.kept
        k_t, k_i = _loading(station, dundurs, shape.half_width)
        k = np.column_stack([k_t, station.k_s, k_i - k_i[station.last]])[kept]
        grown = 1 + 3 * k[:, 2] / (shape.k_n * shape.half_width)
        states = np.arange(len(kept))
        lost = ~(np.isfinite(k).all(axis=1) & (grown > NARROWEST**1.5))
        last = len(kept) - 1
        if path.cycle is None:  # what opens behind the last half cycle that is told is no matter
            ends = [path.place(each.end) for each in station.slip_zones if not each.unknown]
            last = max((at for at in ends if at >= 0 and not lost[at]), default=0)
            k, lost = k[np.minimum(states, last)], lost & (states <= last)
        first = max(int(np.flatnonzero(lost)[-1]) + 1 if lost.any() else 0, path.first)
        if first > path.begin:
            return cls(k[:, :2], k[:, 2], np.zeros(2), first, last)
        locked, reached = np.zeros(2), np.zeros(2)
        apart = path.first + np.flatnonzero(station.hold[kept][path.first : first] <= 0)
        *pulled, pressed = k[first] - k[apart[-1]] if len(apart) else np.zeros(3)
        if pressed > 0 and np.isfinite(pulled).all() and not dundurs:
            locked, reached = np.array(pulled) / pressed, k[first, :2]
            locked *= station.friction / max(station.friction, float(np.hypot(*locked)))
        return cls(k[:, :2], k[:, 2], locked, first, last)._still(reached)

    def late(self, begin: int) -> _Loads:
        """The same from a cycle on, K_T and K_S counted from the middle of their ranges in it."""
        cycle = self.k[begin:]
        k = self.k - (cycle.max(axis=0) + cycle.min(axis=0)) / 2
        return _Loads(k, self.k_i, np.zeros(2), begin, self.last)._still(np.zeros(2))

    def _still(self, reached: Array) -> _Loads:
        """The same with nothing that moves before the first state, and (K_T, K_S) reached there."""
        before = np.arange(len(self.k)) < max(self.first, 1)
        k = np.where(before[:, None], reached, self.k)
        return replace(self, k=k, k_i=np.where(before, self.k_i[self.first], self.k_i))


@dataclass(frozen=True)
class _Edge:
    """The plane problem of a station.

    Attributes:
        station: it.
        bodies: next to it.
        shape: of its contact.
        loads: on it in the states that are gone through.
        counted: (n,) whether slip in the step to each of them counts.
        spans: the half cycles of its slip zones by places of these states; None for those that are
            not followed.
    """

    station: Station
    bodies: EdgeBodies
    shape: _Shape
    loads: _Loads
    counted: Bools
    spans: tuple[tuple[int, int] | None, ...]

    @property
    def behind(self) -> Array | None:
        """Coefficient behind the edge, as of `EdgeHistories.behind`."""
        found, station = self.station.friction_behind, self.station
        if not found.varies:
            return None
        return np.array([found.place - float(station.position[station.last]), found.share])

    @property
    def halves(self) -> tuple[tuple[int, int], ...]:
        """Half cycles that are followed, in time order."""
        return tuple(sorted({span for span in self.spans if span is not None}))

    @property
    def smallest(self) -> float:
        """Length of the smallest slip zone that is expected."""
        swing = float(np.ptp(self.loads.k @ self.station.direction))
        expected = swing / (self.station.friction * self.shape.k_n)
        lengths = (zone.prediction for zone in self.station.slip_zones)
        return min((each for each in lengths if each > 0), default=expected)

    def solved(self, found: EdgeSlip) -> Station:
        """The station with what was found."""
        profiles = {self.halves[number]: each for number, each in found.profiles.items()}
        zones = tuple(
            self._zone(zone, profiles[span]) if span in profiles else zone
            for zone, span in zip(self.station.slip_zones, self.spans, strict=True)
        )
        deepest = max((zone.local for zone in zones if zone.local > 0), default=0.0)
        reason = "" if profiles else found.reason
        if deepest > self.shape.reach or (reason == SLIDES and self.shape.reach < math.inf):
            reason = PASSED
        if reason:
            return replace(self.station, local=no_local_problem(reason))
        station = replace(self.station, slip_zones=zones)
        told = zip(zones, self.spans, strict=True)
        shape = self.shape
        round_work = work_share(shape.power, min(deepest / shape.half_width, DEEPEST), shape.twist)
        span = next((span for zone, span in told if zone is station.longest_zone), None)
        local = LocalProblem(
            half_width=shape.half_width,
            power=shape.power,
            slip=float(profiles[max(profiles)].slip.max()),
            work=found.work * float(round_work),
            change=found.change,
            tractions=tuple(
                each for place, each in found.tractions.items() if place in (span or ())
            ),
            reason="",
        )
        return replace(station, local=local)

    def _zone(self, zone: SlipZone, profile: SlipProfile) -> SlipZone:
        """A slip zone with the length by the slip of the plane problem."""
        slips = profile.slip > FAINT * profile.slip.max()
        if not slips.any():
            return replace(zone, local=0.0, local_spread=float(profile.s[1]))
        border = slip_border(profile.s, profile.slip, slips)
        driven = slip_border(profile.s, profile.slip, profile.slip > INNER * profile.slip.max())
        # A loop that closes touches an older front: what slips behind the jump drives nothing.
        border = driven if driven.length < LEFT_BEHIND * border.length else border
        if border.gross:
            return zone
        # Where slip, which has no noise, does not fall evenly its border is known to an element.
        own = border.spread / (1.0 if border.resolved else UNSEEN)
        station, length = self.station, border.length
        first_order = zone.predicted if math.isfinite(zone.predicted) else length
        open_part = self.shape.bar(length, first_order, station.range_error)
        unlike = UNLIKE * self.station.friction * self.bodies.coupling * length
        spread = math.hypot(own, zone.missed, open_part, unlike)
        return replace(zone, local=length, local_spread=spread)


def _twist(front: Front) -> float:
    """Share of the shear that turns with a closed front, as under a twist; 0 for an open one.

    Of the way in which (K_T, K_S) of all its stations vary most, the mean as they see it beside the
    mean in space, which vanishes around a closed front under twist as the first does under a force.
    """
    if not front.closed:
        return 0.0
    histories = np.array([np.column_stack([each.k_t, each.k_s]) for each in front.stations])
    told = np.isfinite(histories[:, -1]).all(axis=1)
    histories = histories[told]
    known = np.isfinite(histories).all(axis=(0, 2))
    if not told.any() or np.count_nonzero(known) < 2:
        return 0.0
    varied = (histories - histories[:, known].mean(axis=1, keepdims=True))[:, known]
    by_state = varied.swapaxes(0, 1).reshape(np.count_nonzero(known), -1)
    own = np.linalg.svd(by_state, full_matrices=False)[2][0].reshape(-1, 2)
    frames = np.array([[each.frame.inward, each.frame.along] for each in front.stations])[told]
    in_space = np.linalg.norm(np.einsum("nk,nkd->d", own, frames))
    turning = np.linalg.norm(own.sum(axis=0))
    return float(turning / (turning + in_space))


def _pose(
    path: _Path,
    pair: Sequence[AnyBody],
    dundurs: float,
    front: Front,
    station: Station,
    twist: float,
    late: bool,
) -> _Edge | str:
    """The plane problem of a station, or the reason why there is none.

    Args:
        path: through the states.
        pair: the bodies.
        dundurs: their beta.
        front: of the station.
        station: one of its stations.
        twist: share of the shear along the front that turns with it.
        late: begin with the cycle, K_T and K_S counted from the middle of their ranges in it; else
            as early as the factors are known.
    """
    if reason := _unposed(station):
        return reason
    kept = path.kept
    wanted = kept[path.begin :] if path.cycle else np.array([station.last])
    small = wanted[~np.isfinite(station.k_n[wanted])]
    if len(small):
        step = path.step_of(int(small[0]))
        return f"the contact is too small in step {step} for factors that are good enough"
    shape = _Shape.of(front, station, twist, path.peak(station))
    loads = _Loads.of(path, station, shape, dundurs)
    if loads.first > path.begin:
        return (
            "K_T, K_S or K_I are unknown, or the contact nearly opens, as late as in state "
            f"{int(kept[loads.first - 1])}"
        )
    loads = loads.late(path.begin) if late else loads
    spans = tuple(
        None if zone.gross or zone.unknown else path.span(zone, loads.first, loads.last)
        for zone in station.slip_zones
    )
    if not any(spans):
        return "no half cycle can be followed"
    friction = path.contact.edge_friction(station.places)
    counted = np.ones(len(friction), dtype=bool)
    if station.cycles.irregular:
        end = path.evaluated[1] if path.evaluated else len(friction) - 1
        memory = EdgeMemory.of(station, friction, end, station.stiffening)
        if memory is not None:
            counted = memory.outer(memory.longest(path.evaluated or ()))
    return _Edge(
        station=station,
        bodies=EdgeBodies.of(pair, station.frame),
        shape=shape,
        loads=loads,
        counted=(np.arange(len(kept)) > loads.first) & counted[kept],
        spans=spans,
    )


def _loading(station: Station, dundurs: float, half_width: float) -> tuple[Array, Array]:
    """(T,) K_T and K_I that load the plane problem, as of `EdgeHistories`.

    Of unlike bodies those at twice the half-width, whatever the length at which they are told.
    """
    if not dundurs:
        return station.k_t, station.k_i
    whole = whole_factor(
        station.k_i, station.k_t, dundurs, station.reference_length, 2 * half_width
    ) / math.cosh(math.pi * oscillation(dundurs))
    return whole.imag, whole.real


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


def _width(front: Front, station: Station) -> float:
    """Half-width of a Hertzian contact, as of `_Shape`."""
    if not front.closed:
        return station.depth
    centre = front.along("point").mean(axis=0)
    to_centre = float((centre - station.point) @ station.frame.inward)
    return math.sqrt(station.depth * to_centre) if to_centre > 0 else station.depth


def _length_around(front: Front, station: Station) -> tuple[float, float]:
    """Median of `length` around a station, and relative bar by their scatter.

    Around a closed front, whose depth varies as at the tips of an ellipse, of `length` over that.
    """
    around = _around(front, station)
    depth = front.along("depth")[around] if front.closed else np.full(len(around), station.depth)
    shares = front.along("length")[around] / np.where(depth > 0, depth, np.nan)
    middle, finite = float(np.nanmedian(shares)), shares[np.isfinite(shares)]
    scatter = INTERVAL * float(np.std(finite)) / math.sqrt(len(finite)) if len(finite) else 0.0
    return middle * station.depth, scatter / middle


def _k_n_around(front: Front, station: Station) -> tuple[float, float]:
    """K_N in the last state by a curve through those around a station, and relative bar.

    Around a closed front a parabola, along an open one a straight line. The bar is that of fits as
    good as those, of which `INDEPENDENT` do not see the same nodes, and by their scatter about it.
    """
    stations = [front.stations[number] for number in _around(front, station)]
    told = [each for each in stations if math.isfinite(each.k_n[each.last])]
    k_n, bars = np.array([_mean_k_n(each) for each in told]).T
    s = _along(front, station, np.array([each.arc for each in told]))
    order = min(2 if front.closed else 1, len(s) - 1)
    weights = 1 / np.maximum(bars, 1e-3 * k_n)
    curve = np.polynomial.Polynomial([float(k_n.mean())])
    if order:
        curve = np.polynomial.Polynomial.fit(s, k_n, order, w=weights)
    rest = INTERVAL * float(np.std(k_n - curve(s))) / math.sqrt(len(s))
    # Of so many the curve is the mean; a parabola through three goes through the middle one.
    alike = float(min(len(s), INDEPENDENT))
    if order == 2:
        alike = INDEPENDENT / LESS if len(s) > INDEPENDENT else 1.0
    if station.oscillation:  # what fits miss beyond the slip zone is the same along the front
        alike = 1.0
    own = float(np.median(bars)) / math.sqrt(alike)
    middle = float(curve(0.0))
    return middle, math.hypot(own, rest) / middle


def _mean_k_n(station: Station) -> tuple[float, float]:
    """K_N in the state `last`, and its error bar; of unlike bodies that without shear."""
    k_n, bar = float(station.k_n[station.last]), float(station.k_n_spread[station.last])
    if not station.oscillation:
        return k_n, bar
    predicted = [each.prediction for each in station.slip_zones if each.prediction > 0]
    zone = predicted[-1] if predicted else station.reference_length
    ratio = (MEAN_LENGTH * zone / station.reference_length) ** (station.exponent - 0.5)
    return ratio * k_n, ratio * bar


def _unposed(station: Station) -> str:
    """Reason why a station has no plane problem; empty if it may have one."""
    if station.lack.whole:
        return station.lack.text
    if station.end:
        return Kind.NEAR_END.seen
    if not station.friction > 0:
        return "there is no friction"
    if reason := withheld(station, ranged=False):
        return reason.text
    if not station.slip_zones:
        return "K_T and K_S are unknown, or do not vary"
    driven = station.k_range > 0 or station.turning > LARGEST_TURNING
    if not driven and all(math.isnan(zone.prediction) for zone in station.slip_zones):
        return "P alone drives the edge, without a cycle: slip follows it as it moves"
    if not station.depth > 0 or not station.length > 0:
        return "the width of the contact is not known"
    return ""
