# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sub-models of the free ends of a run, whose stations are nearer to these than those of the run.

What both sub-models of an end differ by is in the error bars of the factors of a station.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from fretfe.evaluate.contacts import Station
from fretfe.exchange.submodel import CASE
from fretfe.results.end_answers import EndAnswer, read_answers
from fretfe.results.front_ends import FrontEnd, end_near, find_end, known_stations
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import ENDS


@dataclass(frozen=True)
class EndPart:
    """The finer sub-model of a free end.

    Attributes:
        end: of the run.
        result: of the sub-model.
        own: the same end of the sub-model.
        stations: its stations that stand for the run, by their numbers; none if there is a reason.
        distances: of these from the end.
        reason: why there are none.
    """

    end: FrontEnd
    result: Result
    own: FrontEnd
    stations: dict[int, Station] = field(default_factory=dict)
    distances: dict[int, float] = field(default_factory=dict)
    reason: str = ""

    @property
    def replaced(self) -> list[int]:
        """Numbers of the stations of the run that lie between those of the sub-model."""
        return self._between(min(self.distances.values()))

    @property
    def covered(self) -> list[int]:
        """These and the nearer ones: a remark tells what the sub-model does not know."""
        return self._between(0.0)

    def _between(self, first: float) -> list[int]:
        last = max(self.distances.values())
        every = zip(self.end.distance, self.end.front.stations, strict=True)
        return [each.number for away, each in every if first <= away <= last]


def end_parts(result: Result) -> Iterator[EndPart]:
    """Sub-models of the free ends of a run that are in its folder.

    Raises:
        OutputError: if a file of theirs cannot be read.
    """
    for answer in read_answers(result) if result.solid else ():
        end = find_end(result, answer.name)
        assert end is not None and result.directory is not None
        part = load_result((result.directory / ENDS / answer.name / CASE).with_suffix(""))
        own = end_near(part, answer.point)
        assert own is not None
        found = EndPart(end, part, own)
        if reason := _obstacle(answer, part):
            yield replace(found, reason=reason)
        else:
            yield _with_stations(found, answer)


def _obstacle(answer: EndAnswer, part: Result) -> str:
    """Reason why the stations of a sub-model do not stand for the run, or an empty text."""
    if not len(answer.distance):
        return "all of it is within a local length of its ends"
    if other := [each.station for each in answer.meetings if not each.agrees]:
        return f"it differs from the run at {', '.join(other)}"
    if not part.has_station_stress:
        return "it has no stress of the bodies: run both with [output] stress_depths"
    return ""


def _with_stations(part: EndPart, answer: EndAnswer) -> EndPart:
    by_distance = dict(known_stations(part.own))
    stations, distances = {}, {}
    for n, away in enumerate(answer.distance.tolist()):
        station = by_distance[away]
        k_n_spread = np.array(station.k_n_spread)
        k_n_spread[station.decisive] = answer.k_n_spread[n]
        distances[station.number] = away
        stations[station.number] = replace(
            station, k_range_spread=float(answer.k_range_spread[n]), k_n_spread=k_n_spread
        )
    return replace(part, stations=stations, distances=distances)
