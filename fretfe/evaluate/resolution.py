# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elements that the contacts of a solved history need."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.evaluate.contacts import SMALL_LOAD, Contact, Front, SlipZone, Station
from fretfe.evaluate.edge_zone import WANTED_TO_PEAK, EdgeZone, rise_length
from fretfe.evaluate.loaded import normal_force
from fretfe.evaluate.numerics import most_loaded
from fretfe.evaluate.plane.section import main_patch, plane_front
from fretfe.evaluate.refinement import SHORTEST_SLIP, Pass, StationValues
from fretfe.evaluate.slip import cycle_states
from fretfe.history.solution import ContactHistory, Solution
from fretfe.mesh.sizing import FinePlaces
from fretfe.reason import Kind

# Elements over a slip zone in the first mesh that resolves a front; over the rise of the pressure
# it has twice as many as K_N wants. Each further level halves the elements. Zones shorter than such
# an element of the longest one get none of their own.
PER_SLIP_ZONE = 8
# Elements may be larger than asked for by this factor: a mesh follows sizes only roughly.
MISSED = 1.3
# So much smaller are the next elements where these are too large to tell K_N.
BLIND = 4
# Elements over the half-width of the contact below which K_N that is not known will never be.
SMALLEST_ELEMENT = 1e-4
# Slip lengths that must converge: of a cycle those of loading and unloading.
ZONES = 2
# Error bar of |ΔK| at single stations of solids, times the elements over the half-width of the
# contact, or over the radius of its front: .37 on spheres with 8 and with 12 of them.
BAR_TIMES_ELEMENTS = 0.36
# Nodes in contact of solids that are likely to show its fronts.
NODES_WITH_FRONTS = 200
# Elements along fronts of solids become smaller by factors between these from mesh to mesh.
LEAST_FINER = 1.4
MOST_FINER = 2.0


@dataclass(frozen=True)
class Interval:
    """Places low to high along the arc of a contact that need elements of a size."""

    contact: str
    low: float
    high: float
    size: float


def station_values(solution: Solution, contacts: Sequence[Contact]) -> tuple[StationValues, ...]:
    """Values that must converge, of every contact that carries something when it ends."""
    return tuple(_values(solution, *each) for each in _stations(solution, contacts))


def _values(
    solution: Solution, history: ContactHistory, contact: Contact, station: Station
) -> StationValues:
    k_n, k_n_spread = station.decisive_k_n
    zones = _longest_zones(station)
    k_t_spread = station.driven_range[1] if solution.cycle is not None else math.nan
    # K_T is no measure where all slides, nor told where nothing slips and there is no cycle.
    gross = [zone.gross for zone in station.slip_zones[-ZONES:]]
    still = solution.cycle is None and station.still
    untold = (len(gross) > 0 and all(gross)) or station.lack.by_loads or still
    return StationValues(
        contact=contact.name,
        front=station.front,
        k_n=k_n,
        k_t=_k_t(solution, station),
        slip=tuple(zone.length for zone in zones),
        rise=_rise(history, contact, station),
        friction=station.friction,
        k_t_scale=math.inf if untold else 0.0,
        spreads=(k_n_spread, k_t_spread, *(zone.spread for zone in zones)),
    )


def _k_t(solution: Solution, station: Station) -> float:
    """Range of K_T over the cycle; without one that of the largest half cycle, or a value.

    It is the largest: in the last state there may be next to no load.
    """
    if solution.cycle is not None:
        return station.k_range
    if math.isfinite(station.largest_range):
        return station.largest_range
    known = station.k_along[np.isfinite(station.k_along)]
    return float(known[np.argmax(np.abs(known))]) if len(known) else math.nan


def _stations(
    solution: Solution, contacts: Sequence[Contact]
) -> Iterator[tuple[ContactHistory, Contact, Station]]:
    for history, contact in zip(solution.contacts, contacts, strict=True):
        if np.any(history.traction[contact.stations[0].decisive, :, 0] > 0):
            for station in contact.stations:
                if not station.lack.whole:  # no mesh tells anything of those
                    yield history, contact, station


def _longest_zones(station: Station) -> tuple[SlipZone, ...]:
    """The longest slip zones, that first, but for those that need no elements of their own."""
    zones = [zone for zone in station.evaluated_zones if not (zone.gross or zone.unknown)]
    zones = sorted(zones[::-1], key=_length, reverse=True)[:ZONES]
    return tuple(each for each in zones if PER_SLIP_ZONE * _length(each) > _length(zones[0]))


def _rise(history: ContactHistory, contact: Contact, station: Station) -> float:
    """The `rise_length` of an edge; half of the closed elements while K_N is unknown."""
    pressure = history.traction[station.decisive, :, 0]
    patch = main_patch(history.surface.arc, pressure)
    half_width = float(contact.half_width[station.decisive])
    if not np.isfinite(station.decisive_k_n[0]) or not np.isfinite(half_width):
        low, high = max(patch.first - 1, 0), min(patch.last + 1, len(pressure) - 1)
        return float(history.surface.arc[high] - history.surface.arc[low]) / 2
    inside = slice(patch.first, patch.last + 1)
    arc, pressure = history.surface.arc[inside], pressure[inside]
    near = station.inward * (contact.centre[station.decisive] - arc) >= 0
    return rise_length(float(pressure[near].max()), station.decisive_k_n[0], half_width)


def needed_sizes(
    solution: Solution, contacts: Sequence[Contact], level: int
) -> tuple[Interval, ...]:
    """Element sizes that are needed and where; each level halves them."""
    intervals: list[Interval] = []
    for each in _stations(solution, contacts):
        intervals += _station_intervals(solution, *each, 2.0**-level)
    return tuple(intervals)


def edges_of_section(solution: Solution, contacts: Sequence[Contact]) -> Iterator[Interval]:
    """Edges of plane contacts in the cycle, with elements that tell K_N along fronts of solids."""
    for history, contact, station in _stations(solution, contacts):
        states = _carrying(solution, contact, station)
        low, high = _front_range(history, station, states)
        # Along the fronts of solids edges are a little elsewhere.
        rise = _rise(history, contact, station)
        size = EdgeZone(rise, rise, 3).size
        yield Interval(contact.name, low - size, high + size, size)


def fine_places(
    solution: Solution, history: ContactHistory, contact: Contact, tolerance: float
) -> Iterator[FinePlaces]:
    """Places along the fronts of a contact of solids, with the element sizes of the next mesh.

    Those are as small as the tolerance is likely to need, for the half-width at each station, but
    smaller than they were by no more than a factor. Where no front is known all nodes under
    pressure are to be finer, so that there are enough of them.
    """
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([len(solution.times) - 1])
    known = [front for front in contact.fronts if front.judged]
    for front in known:
        yield _along(front, states, tolerance)
    heaviest = most_loaded(normal_force(history), states)
    pressed = history.traction[heaviest, :, 0] > 0
    if not known and pressed.any():
        count = np.count_nonzero(pressed)
        finer = np.clip(math.sqrt(NODES_WITH_FRONTS / count), MOST_FINER, BLIND)
        size = float(np.sqrt(np.median(history.surface.weights[pressed])) / finer)
        yield FinePlaces(history.surface.points[pressed], np.full(count, size))


def _along(front: Front, states: Indices, tolerance: float) -> FinePlaces:
    """Places along a front, wherever it is in some states; those near its ends aside."""
    stations = front.judged
    before = np.array([station.size for station in stations])
    scale = np.array([np.fmin(station.depth, station.length) for station in stations])
    wanted = np.where(np.isfinite(scale), scale * tolerance / BAR_TIMES_ELEMENTS, 0.0)
    # Along a border without a front nothing tells how much finer.
    most = np.where([station.lack.whole for station in stations], BLIND, MOST_FINER)
    sizes = np.clip(wanted, before / most, before / LEAST_FINER)
    positions = np.nan_to_num([station.position[states] for station in stations])
    low, high = positions.min(axis=1), positions.max(axis=1)
    inward = np.array([station.frame.inward for station in stations])
    points = np.array([station.point for station in stations]) + low[:, None] * inward
    table = np.column_stack([points, (high - low)[:, None] * inward, sizes])
    arc = np.array([station.arc for station in stations])
    count = math.ceil(front.length / sizes.min())
    fine = np.linspace(
        0.0 if front.closed else arc[0], front.length if front.closed else arc[-1], count
    )
    period = front.length if front.closed else None
    rows = np.transpose([np.interp(fine, arc, column, period=period) for column in table.T])
    shares = np.linspace(0.0, 1.0, math.ceil((high - low).max() / sizes.min()) + 1)
    along = [rows[:, :3] + share * rows[:, 3:6] for share in shares]
    return FinePlaces(np.vstack(along), np.tile(rows[:, 6], len(shares)))


def hopeless(solution: Solution, contacts: Sequence[Contact], passes: Sequence[Pass] = ()) -> str:
    """Reason why finer elements will not tell K_N of some edge; empty if they may.

    Where K_N is not known elements become smaller from mesh to mesh by a factor, and would do so
    for ever at an edge that has none: a sharp corner, or the end of a surface.

    Args:
        solution: on the last mesh.
        contacts: of it.
        passes: all of them: an edge with a K_N on a coarser mesh has one.
    """
    seen = {x.key[:2] for done in passes for x in done.stations if math.isfinite(x.k_n)}
    for history, contact, station in _stations(solution, contacts):
        if np.isfinite(station.decisive_k_n[0]) and not station.uncertain:
            continue
        states = _carrying(solution, contact, station)
        element = _largest_element(history.surface.arc, *_front_range(history, station, states))
        half_width = float(contact.half_width[station.decisive])
        scale = half_width if math.isfinite(half_width) else _rise(history, contact, station)
        if element < SMALLEST_ELEMENT * scale:
            why = (
                "round-off hides it among so small elements"
                if (contact.name, station.front) in seen
                else "finer ones will not tell it, as at a sharp corner or at the end of a surface"
            )
            return (
                f"K_N at the {station.front} edge of contact {contact.name} is not known with "
                f"elements of {element:.1g} either, {element / scale:.1g} of the half-width: {why}"
            )
    return ""


def resolves(solution: Solution, intervals: Sequence[Interval]) -> bool:
    """True if the elements of the surfaces that carry the tractions are as small as needed."""
    contacts = {contact.name: contact for contact in solution.contacts}
    return all(
        _largest_element(contacts[each.contact].surface.arc, each.low, each.high)
        <= MISSED * each.size
        for each in intervals
    )


def _largest_element(arc: Array, low: float, high: float) -> float:
    # A front may lie at the end of its surface.
    first = min(max(int(np.searchsorted(arc, low, side="right")) - 1, 0), len(arc) - 2)
    last = min(int(np.searchsorted(arc, high, side="left")), len(arc) - 1)
    return float(np.diff(arc[first : max(last, first + 1) + 1]).max())


def _station_intervals(
    solution: Solution,
    history: ContactHistory,
    contact: Contact,
    station: Station,
    refinement: float,
) -> list[Interval]:
    """Range of a station in the cycle and its slip zones; finer where numbers are taken.

    Those places are the station in the state that decides, and at the ends of half cycles, and the
    inner ends of slip zones; only there do the elements shrink with the level.
    """
    states, rise = _carrying(solution, contact, station), _rise(history, contact, station)
    low, high = _front_range(history, station, states)
    size = rise / WANTED_TO_PEAK
    if not np.isfinite(station.decisive_k_n[0]) or station.uncertain:
        size = min(size, _largest_element(history.surface.arc, low, high) / BLIND)
    places, intervals = [(float(station.position[station.decisive]), size)], []
    # Others begin within the step in which the bodies part.
    for zone in (x for x in _longest_zones(station) if contact.normal_force[x.end] > 0):
        at, length = _front_range(history, station, np.array([zone.end])), _length(zone)
        if np.isnan(station.position[zone.end]):  # nor is the size of the edge known, and its hold
            finer = _largest_element(history.surface.arc, *at) / BLIND
            intervals.append(Interval(contact.name, *at, finer))
        if length > SHORTEST_SLIP * rise:
            zone_size = length / PER_SLIP_ZONE
            ends = at[0] + min(station.inward, 0) * length, at[1] + max(station.inward, 0) * length
            intervals.append(Interval(contact.name, min(ends), max(ends), zone_size))
            size = min(size, zone_size)
            places += [(end, min(size, zone_size)) for end in ends]
    intervals.append(Interval(contact.name, low, high, size))
    if not np.isfinite(station.position[states]).all():
        intervals.append(_crossed(history, contact, station))
    intervals += [
        Interval(contact.name, place, place, refinement * min(size, own)) for place, own in places
    ]
    return [each for each in intervals if math.isfinite(each.low) and math.isfinite(each.high)]


def _crossed(history: ContactHistory, contact: Contact, station: Station) -> Interval:
    """The patch in the state that decides, of which edges cross a part as bodies touch and part.

    That happens within steps, of which no place is known here. Its elements are as they are, or
    smaller if some state has too few of them for edges.
    """
    arc = history.surface.arc
    patch = main_patch(arc, history.traction[station.decisive, :, 0])
    low, high = float(arc[patch.first]), float(arc[patch.last])
    few = station.lack.kind is Kind.FEW_NODES
    finer = MISSED * station.lack.wanted / max(station.lack.found, 1) if few else 1.0
    return Interval(contact.name, low, high, _largest_element(arc, low, high) / finer)


def _length(zone: SlipZone) -> float:
    """Length of a slip zone, or what is predicted while the mesh does not resolve it."""
    if zone.resolved and zone.length > 0:
        return zone.length
    return zone.prediction if math.isfinite(zone.prediction) else 0.0


def _carrying(solution: Solution, contact: Contact, station: Station) -> Indices:
    """States of the cycle, or else the one that decides, whose P is no small part of the largest.

    Flats that hardly touch tilt: their edges may be anywhere, and all of the flat would be refined.
    """
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([station.decisive])
    force = contact.normal_force[states]
    return states[force >= SMALL_LOAD * force.max()]


def _front_range(history: ContactHistory, station: Station, states: Indices) -> tuple[float, float]:
    """Range of a station in some states: fitted, or else between the last closed and open nodes."""
    positions = station.position[states]
    if np.isfinite(positions).all():
        return float(positions.min()), float(positions.max())
    arc, front = history.surface.arc, plane_front(station.front)
    places = []
    for state in states:
        if not np.any(history.traction[state, :, 0] > 0):
            continue
        closed = front.outermost(main_patch(arc, history.traction[state, :, 0]))
        opened = np.clip(closed - front.inward, 0, len(arc) - 1)
        places += [arc[opened], arc[closed]]
    return float(min(places)), float(max(places))
