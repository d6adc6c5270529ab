# SPDX-License-Identifier: LGPL-3.0-or-later
"""Free ends of the fronts of solid contacts: the places at which both bodies end."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.errors import CaseError
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.results.model import Result

# Names of the ends of a front, before its first and behind its last station.
START = "start"
END = "end"


@dataclass(frozen=True)
class FrontEnd:
    """A free end of a front.

    Attributes:
        contact: that the front belongs to.
        front: the front.
        name: of the end, such as "left.1.start".
        point: (3,) place before deformation.
        into: (3,) unit tangent of the front there, from the end into the front.
        first: whether it lies before the first station.
    """

    contact: Contact
    front: Front
    name: str
    point: Array
    into: Array
    first: bool

    @property
    def station(self) -> Station:
        """The nearest station."""
        return self.front.stations[0 if self.first else -1]

    @property
    def distance(self) -> Array:
        """(n,) distances of the stations of the front from the end, along it."""
        arc = self.front.along("arc")
        return arc if self.first else self.front.length - arc


def free_ends(result: Result) -> Iterator[FrontEnd]:
    """All free ends of the fronts of a result, none of plane bodies."""
    for contact in result.contacts:
        for front in contact.fronts if contact.solid else ():
            for end in (START, END):
                found = _free_end(contact, front, end)
                if found is not None:
                    yield found


def find_end(result: Result, name: str) -> FrontEnd | None:
    """The free end of a name; None if the name is that of something else.

    Raises:
        CaseError: if there is no such end, or the bodies go on behind it.
    """
    if name.rpartition(".")[2] not in (START, END):
        return None
    known = {each.name: each for each in free_ends(result)}
    if name not in known:
        raise CaseError(
            f"{result.directory or result.case.source}: expected one of the free ends "
            f"{', '.join(known) or '(none)'}, found {name!r}"
        )
    return known[name]


def end_near(result: Result, point: Array) -> FrontEnd | None:
    """The free end of a front that is nearest to a place (3,); None without any."""
    ends = free_ends(result)
    return min(ends, key=lambda each: float(np.linalg.norm(each.point - point)), default=None)


def end_beside(result: Result, station: Station) -> FrontEnd | None:
    """The free end of the front of a station that is no farther away than its contact is deep.

    So near to an end a front differs from that of a section; None farther away.
    """
    if not station.to_end <= station.depth:
        return None
    ends = (
        each for each in free_ends(result) if any(own is station for own in each.front.stations)
    )
    return min(
        ends, key=lambda each: float(np.linalg.norm(each.point - station.point)), default=None
    )


def worst_end(result: Result) -> FrontEnd | None:
    """The free end with the largest |ΔK| at the nearest station that has one; None without any."""
    known = [(each, stations) for each in free_ends(result) if (stations := known_stations(each))]
    nearest = max(known, key=lambda each: each[1][0][1].k_range, default=None)
    return None if nearest is None else nearest[0]


def known_stations(end: FrontEnd) -> list[tuple[float, Station]]:
    """Stations of a front at which |ΔK| means something, by their distance from an end of it."""
    every = zip(end.distance.tolist(), end.front.stations, strict=True)
    known = [each for each in every if not each[1].end and math.isfinite(each[1].reported_range)]
    return sorted(known, key=lambda each: each[0])


def zone_at(end: FrontEnd) -> float:
    """Longest slip zone of the nearest station that has one; NaN without any."""
    zones = (each.longest_zone for _, each in known_stations(end))
    lengths = (zone.rank for zone in zones if zone is not None)
    return next((each for each in lengths if 0 < each < math.inf), math.nan)


def known_numbers(end: FrontEnd) -> Array:
    """(5, n) distances of these stations, |ΔK| and K_N, each followed by its error bar."""
    rows = [
        (away, each.k_range, each.k_range_spread, *each.decisive_k_n)
        for away, each in known_stations(end)
    ]
    return np.array(rows).reshape(-1, 5).T


def _free_end(contact: Contact, front: Front, end: str) -> FrontEnd | None:
    """One end of a front; None if that is closed, or the bodies go on behind it."""
    first = end == START
    station = front.stations[0 if first else -1]
    away = station.arc if first else front.length - station.arc
    if front.closed or not abs(station.to_end - away) <= 1e-9 * front.length:
        return None
    into = station.frame.along * (1.0 if first else -1.0)
    name = f"{contact.name}.{front.name.removeprefix('front ')}.{end}"
    return FrontEnd(contact, front, name, station.point - away * into, into, first)
