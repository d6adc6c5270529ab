# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stations at which the bodies of solids are judged: of the run, and of sub-models at free ends.

A front is as good as the worst of them, each criterion for itself.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from fretfe.decision.assessment import EdgeAssessment, Judgement
from fretfe.decision.end_parts import EndPart
from fretfe.decision.field import EdgeField
from fretfe.decision.station_field import BothFields, station_fields
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.results.model import Result

# Name of the free end whose sub-model has a station, empty for the run; its number.
Place = tuple[str, int]


@dataclass(frozen=True)
class FrontStations:
    """Stations of a front at which one body is judged.

    Attributes:
        front: of the run.
        body: 0 or 1.
        judged: those with their stress, or the first one with the reason why none is known.
        lost: numbers of the stations of the run that are not judged, with the reason.
    """

    front: Front
    body: int
    judged: dict[Place, tuple[Station, EdgeField | str]]
    lost: dict[int, str]


def along_fronts(
    result: Result, contact: Contact, parts: Sequence[EndPart]
) -> Iterator[FrontStations]:
    """Both bodies along each front of a contact.

    Args:
        result: of solids.
        contact: of it.
        parts: sub-models of its free ends.
    """
    at_ends = [(each, _at_end(each)) for each in parts if each.stations]
    replaced = {(each.end.front.name, key) for each, _ in at_ends for key in each.replaced}
    own = {(each.front, each.number) for each in contact.stations} - replaced
    run = _Judged.of(result, contact, own)
    for front in contact.fronts:
        for body in (0, 1):
            found = run.along(front, body)
            for part, stations in at_ends:
                if part.end.front is front:
                    found = _with_end(found, part, stations.along(part.own.front, body))
            yield found


@dataclass(frozen=True)
class _Judged:
    """Some stations of a contact, by names of fronts and numbers, with the stress there."""

    only: Collection[tuple[str, int]]
    fields: dict[tuple[str, int], BothFields]

    @classmethod
    def of(cls, result: Result, contact: Contact, only: Collection[tuple[str, int]]) -> _Judged:
        """Those whose stress is told, or why it is not known."""
        found = station_fields(result, contact, only)
        return cls(only, {(each.front, each.number): fields for each, fields in found})

    def along(self, front: Front, body: int) -> FrontStations:
        """Those of one front and body; the first station where nothing is known."""
        own = {
            each.number: (each, self.fields[front.name, each.number][body])
            for each in front.stations
            if (front.name, each.number) in self.fields
        }
        lost = {key: field for key, (_, field) in own.items() if isinstance(field, str)}
        mine = [key for key in own if (front.name, key) in self.only]
        known = [key for key in mine if key not in lost] or mine[:1]
        return FrontStations(front, body, {("", key): own[key] for key in known}, lost)


def _at_end(part: EndPart) -> _Judged:
    return _Judged.of(
        part.result, part.own.contact, {(part.own.front.name, key) for key in part.stations}
    )


def _with_end(run: FrontStations, part: EndPart, found: FrontStations) -> FrontStations:
    """Those of a run and of a sub-model, which stands for the stations of the run around it."""
    judged = {
        (part.end.name, key): (part.stations[key], field)
        for (_, key), (_, field) in found.judged.items()
    }
    lost = {key: reason for key, reason in run.lost.items() if key not in part.covered}
    for _, field in judged.values():
        if isinstance(field, str):
            lost |= dict.fromkeys(part.replaced, f"by the sub-model of {part.end.name}: {field}")
    return FrontStations(run.front, run.body, run.judged | judged, lost)


def worst_of(
    edges: dict[Place, EdgeAssessment], tests: dict[Place, Judgement], parts: Sequence[EndPart]
) -> EdgeAssessment:
    """A front by the worst of its stations, each criterion for itself.

    Args:
        edges: of stations, by their places.
        tests: the answers of tests at all stations of the run.
        parts: sub-models of its ends.
    """
    first = next(iter(edges.values()))
    away = {(each.end.name, key): own for each in parts for key, own in each.distances.items()}
    judgements = [_worst_judgement(tests, away)] + [
        _worst_judgement({place: each.of(one.criterion) for place, each in edges.items()}, away)
        for one in first.judgements[1:]
    ]
    found = replace(
        first,
        judgements=tuple(judgements),
        depth=max((own for each in edges.values() if (own := each.depth) > 0), default=math.nan),
        straight=min(each.straight for each in edges.values()),
    )
    if (arrest := edges.get(judgements[1].at_station)) is not None:
        found = replace(found, arrest=arrest.arrest, life=arrest.life)
    least = found.governing
    if least is not None and (at := edges.get(least.at_station)) is not None:
        found = replace(found, bar=at.bar, spread=at.spread)
    return found


def _worst_judgement(each: dict[Place, Judgement], away: dict[Place, float]) -> Judgement:
    """The one with the smallest margin; those of sub-models are so far away from their ends."""
    known = {place: one for place, one in each.items() if not one.reason}
    if not known:
        return next(iter(each.values()))
    place = min(known, key=lambda place: known[place].margin)
    end, station = place
    to_end = away.get(place, math.nan)
    return replace(known[place], end=end, station=station, to_end=to_end)
