# SPDX-License-Identifier: LGPL-3.0-or-later
"""The answer of a run as data: its worst place, the half cycles that are told, and their trust.

Whatever names, marks or draws a worst place takes it from here, and the half cycle of a station
from `Station.longest_zone`. Numbers whose error bar is unknown or more than half of them are NaN.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

from fretfe.evaluate.contacts import Contact, Quantity, SlipZone, Station, worst_of
from fretfe.evaluate.verdicts import judge
from fretfe.verdict import Verdict

# An edge that moves by less than this part of a slip zone is in the same place, and ranges or
# lengths that differ by less are equal.
SAME = 0.01


class Trust(StrEnum):
    """Trust in the numbers of the worst place."""

    TRUSTED = "trusted"
    DOUBTED = "doubted"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class ToldZone:
    """The longest slip zone of an edge or a station in the evaluated cycle, or of all without."""

    name: Annotated[str, Quantity("", "of the edge or station")]
    start: Annotated[int, Quantity("", "state in which the half cycle begins")]
    end: Annotated[int, Quantity("", "state in which its zone is longest")]
    length: Annotated[float, Quantity("length", "d, by the plane problem, else by the nodes")]
    spread: Annotated[float, Quantity("length", "its error bar")]
    predicted: Annotated[float, Quantity("length", "d by the edge factors alone")]
    gross: Annotated[bool, Quantity("", "whether the whole contact slides in the half cycle")]
    verdict: Annotated[Verdict, Quantity("", "of `length` beside `predicted`")]
    reason: Annotated[str, Quantity("", "what that rests on")]

    @classmethod
    def of(cls, contact: Contact, station: Station, zone: SlipZone) -> ToldZone:
        """A zone of a station of a contact."""
        judged, (length, spread) = judge(station, zone), zone.told
        predicted = station.told_prediction(zone)
        if zone.gross:
            length = predicted = math.nan
        name, told = contact.name_of(station), (length, spread, predicted)
        return cls(name, zone.start, zone.end, *told, zone.gross, judged.verdict, judged.reason)


@dataclass(frozen=True)
class WorstPlace:
    """The edge or station of the largest range, in a cycle or of all, else of the largest K_N."""

    name: Annotated[str, Quantity("", "CONTACT.left or CONTACT.right; CONTACT.FRONT.STATION")]
    place: Annotated[float, Quantity("length", "x along the arc, of solids along the front")]
    state: Annotated[int, Quantity("", "of K_N and x")]
    time: Annotated[float, Quantity("time", "of that state")]
    k_n: Annotated[float, Quantity("k_n", "K_N then")]
    k_n_spread: Annotated[float, Quantity("k_n", "its error bar")]
    k_range: Annotated[float, Quantity("k_t", "range that slip follows; unknown without a cycle")]
    k_range_spread: Annotated[float, Quantity("k_t", "its error bar")]
    zone: Annotated[ToldZone | None, Quantity("", "its longest slip zone")]


@dataclass(frozen=True)
class Sentences:
    """The same in a few sentences; a sentence that has nothing to say is empty.

    Attributes:
        larger: the largest half cycle of all where the evaluated cycle has none as large.
        worst: the edge or station of the largest range, where it is, its numbers with their bars,
            and what they are compared with.
        longer: the longest slip zone, where that is elsewhere.
        trust: whether these can be trusted, and why not.
        sliding: contacts that slide as a whole, how far, with which work, and for how long.
        agreement: how many edges or stations agree with what is predicted.
        cycle: the evaluated cycle.
        half: contacts of which the model has the half.
    """

    larger: str
    worst: str
    longer: str
    trust: str
    sliding: str
    agreement: str
    cycle: str
    half: str

    @property
    def lines(self) -> tuple[str, ...]:
        """The sentences that there are, the answer first."""
        return tuple(filter(None, vars(self).values()))


@dataclass(frozen=True)
class Headline:
    """The answer of a run; `sentences` are its first lines in the terminal and in the report."""

    worst: Annotated[WorstPlace | None, Quantity("", "the worst place; none if nothing is known")]
    longest: Annotated[ToldZone | None, Quantity("", "longest known slip zone of all places")]
    larger: Annotated[str, Quantity("", "name of the edge with a half cycle that is larger")]
    trust: Annotated[Trust, Quantity("", "whether the numbers of the worst place can be trusted")]
    doubts: Annotated[tuple[str, ...], Quantity("", "reasons not to")]
    verdicts: Annotated[Mapping[Verdict, int], Quantity("", "numbers of stations by verdicts")]
    sentences: Annotated[Sentences, Quantity("", "the first lines; empty if nothing is to be said")]


def shown_stations(contacts: Sequence[Contact]) -> list[tuple[Contact, Station]]:
    """Stations with lines and rows of their own: edges, of solids the worst of each front."""
    return [
        (contact, station)
        for contact in contacts
        for front in contact.fronts
        if (station := front.worst if contact.solid else front.stations[0]) is not None
        if not station.no_edge
    ]


def worst_station(contacts: Sequence[Contact]) -> tuple[Contact, Station] | None:
    """The worst station of some contacts; None where neither a range nor a K_N is known."""
    every = [(c, station) for c in contacts for front in c.fronts for station in front.defined]
    worst = worst_of(station for _, station in every)
    return next((each for each in every if each[1] is worst), None)


def longest_zone(contacts: Sequence[Contact]) -> tuple[Contact, Station, SlipZone] | None:
    """The longest slip zone that is known; that of the worst station unless one is longer."""
    known = [
        (contact, station, zone)
        for contact in contacts
        for front in contact.fronts
        for station in front.judged
        if (zone := station.longest_zone) is not None and not zone.gross
        if math.isfinite(zone.told[0])
    ]
    if not known:
        return None
    longest, worst = max(known, key=lambda each: each[2].told[0]), worst_station(contacts)
    least = (1 - SAME) * longest[2].told[0]
    own = (each for each in known if worst is not None and each[1] is worst[1])
    return next((each for each in own if each[2].told[0] >= least), longest)


def larger_half_cycle(contacts: Sequence[Contact]) -> tuple[Contact, Station] | None:
    """The station with the largest half cycle of all, if the evaluated cycle has no such."""
    every = [(c, station) for c in contacts for front in c.fronts for station in front.defined]
    known = [each for each in every if math.isfinite(each[1].largest_range)]
    largest = max(known, key=lambda each: each[1].largest_range, default=None)
    if largest is None or largest[1].slides:
        return largest
    return None if largest[1].largest_range <= (1 + SAME) * largest[1].equivalent_range else largest
