# SPDX-License-Identifier: LGPL-3.0-or-later
"""Element sizes that a solved history asks for, near fronts and the inner ends of slip zones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.edges.front import ContactSummary, SlipZone, Station
from fretfe.edges.patches import main_patch
from fretfe.edges.refinement import SHORTEST_SLIP, StationValues
from fretfe.edges.section import plane_front
from fretfe.edges.slip_zones import cycle_states
from fretfe.results.solution import ContactHistory, Solution

# Elements over the length in which the pressure rises, and over a slip zone, in the first mesh that
# resolves a front; each further level halves the elements.
PER_RISE, PER_SLIP_ZONE = 16, 8
# Elements may be larger than asked for by this factor: a mesh follows sizes only roughly.
MISSED = 1.3
# So much smaller are the next elements where these are too large to tell K_N.
BLIND = 4
# Slip lengths that are reported and must converge: those of the last loading and unloading.
ZONES = 2


@dataclass(frozen=True)
class Interval:
    """Places low to high along the arc of a contact that need elements of a size."""

    contact: str
    low: float
    high: float
    size: float


def station_values(
    solution: Solution, contacts: Sequence[ContactSummary]
) -> tuple[StationValues, ...]:
    """Values that must converge, of every contact that carries something at the end."""
    return tuple(
        StationValues(
            contact=contact.name,
            front=station.front,
            k_n=float(station.k_n[-1]),
            k_t=_k_t(solution, station),
            slip=tuple(zone.length for zone in _last_zones(station)),
            rise=_rise(history, contact, station),
            friction=float(history.friction.max()),
        )
        for history, contact, station in _stations(solution, contacts)
    )


def _k_t(solution: Solution, station: Station) -> float:
    """Range of K_T over the cycle; without one that of the worst counted cycle, or the last value.

    The last value of K_T under irregular loads is as good as any.
    """
    if solution.cycle is not None:
        return station.k_t_range
    cycles = station.cycles
    return float(cycles.k_t_range[cycles.worst] if cycles.irregular else station.k_t[-1])


def _stations(
    solution: Solution, contacts: Sequence[ContactSummary]
) -> Iterator[tuple[ContactHistory, ContactSummary, Station]]:
    for history, contact in zip(solution.contacts, contacts, strict=True):
        if np.any(history.traction[-1, :, 0] > 0):
            for station in contact.stations:
                yield history, contact, station


def _last_zones(station: Station) -> tuple[SlipZone, ...]:
    """The last slip zones; those of a contact that slides as a whole have no length."""
    return tuple(zone for zone in station.slip_zones[-ZONES:] if not zone.gross)


def _rise(history: ContactHistory, contact: ContactSummary, station: Station) -> float:
    """Distance in which p = K_N sqrt(s) would rise to the largest pressure on this side.

    Half of the half-width for Hertz; about the length of the rounding in contact for a flat and
    rounded punch. At most the half-width; that of the closed elements while K_N is unknown.
    """
    pressure = history.traction[-1, :, 0]
    patch = main_patch(history.arc, pressure)
    half_width = float(contact.half_width[-1])
    if not np.isfinite(station.k_n[-1]) or not np.isfinite(half_width):
        low, high = max(patch.first - 1, 0), min(patch.last + 1, len(pressure) - 1)
        return float(history.arc[high] - history.arc[low]) / 2
    inside = slice(patch.first, patch.last + 1)
    arc, pressure = history.arc[inside], pressure[inside]
    near = plane_front(station.front).inward * (contact.centre[-1] - arc) >= 0
    return float(min((pressure[near].max() / station.k_n[-1]) ** 2, half_width))


def needed_sizes(
    solution: Solution, contacts: Sequence[ContactSummary], level: int
) -> tuple[Interval, ...]:
    """Element sizes that are needed and where; each level halves them."""
    intervals: list[Interval] = []
    for values, (history, contact, station) in zip(
        station_values(solution, contacts), _stations(solution, contacts), strict=True
    ):
        intervals += _station_intervals(solution, history, contact, station, values, 2.0**-level)
    return tuple(intervals)


def resolves(solution: Solution, intervals: Sequence[Interval]) -> bool:
    """True if the elements of the surfaces that carry the tractions are as small as needed."""
    contacts = {contact.name: contact for contact in solution.contacts}
    return all(
        _largest_element(contacts[each.contact].arc, each.low, each.high) <= MISSED * each.size
        for each in intervals
    )


def _largest_element(arc: Array, low: float, high: float) -> float:
    first = max(int(np.searchsorted(arc, low, side="right")) - 1, 0)
    last = min(int(np.searchsorted(arc, high, side="left")), len(arc) - 1)
    return float(np.diff(arc[first : max(last, first + 1) + 1]).max())


def _station_intervals(
    solution: Solution,
    history: ContactHistory,
    contact: ContactSummary,
    station: Station,
    values: StationValues,
    refinement: float,
) -> list[Interval]:
    """Range of a station in the cycle and its slip zones; finer where numbers are taken.

    Those places are the station at the end of the history and of half cycles, and the inner ends of
    slip zones; only there do the elements shrink with the level.
    """
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([len(solution.times) - 1])
    low, high = _front_range(history, station, states)
    size = values.rise / PER_RISE
    if not np.isfinite(station.k_n[-1]) or station.uncertain:
        size = min(size, _largest_element(history.arc, low, high) / BLIND)
    front = plane_front(station.front)
    places, intervals = [(float(station.position[-1]), size)], []
    for zone in _last_zones(station):
        length = _length(zone)
        if length > SHORTEST_SLIP * values.rise:
            position, zone_size = float(station.position[zone.end]), length / PER_SLIP_ZONE
            ends = (position, front.place(position, length))
            intervals.append(Interval(contact.name, min(ends), max(ends), zone_size))
            size = min(size, zone_size)
            places += [(end, min(size, zone_size)) for end in ends]
    intervals.append(Interval(contact.name, low, high, size))
    intervals += [
        Interval(contact.name, place, place, refinement * min(size, own))
        for place, own in places
        if math.isfinite(place)
    ]
    return intervals


def _length(zone: SlipZone) -> float:
    """Length of a slip zone, or what is predicted while the mesh does not resolve it."""
    if zone.resolved and zone.length > 0:
        return zone.length
    return zone.prediction if math.isfinite(zone.prediction) else 0.0


def _front_range(history: ContactHistory, station: Station, states: Indices) -> tuple[float, float]:
    """Range of a station in some states: fitted, or else between the last closed and open nodes."""
    positions = station.position[states]
    if np.isfinite(positions).all():
        return float(positions.min()), float(positions.max())
    arc, front = history.arc, plane_front(station.front)
    places = []
    for state in states:
        if not np.any(history.traction[state, :, 0] > 0):
            continue
        closed = front.outermost(main_patch(arc, history.traction[state, :, 0]))
        opened = np.clip(closed - front.inward, 0, len(arc) - 1)
        places += [arc[opened], arc[closed]]
    return float(min(places)), float(max(places))
