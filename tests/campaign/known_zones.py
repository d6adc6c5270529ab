# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones by half-planes, the answers of cases; those of the first cases are stored.

`cd tests; python -m campaign.known_zones` stores them again, which takes a minute or two.
"""

from __future__ import annotations

import json
import math
from dataclasses import astuple, dataclass
from functools import cache
from pathlib import Path

from campaign.draw import Draw, case_of, draw

import fretfe
from fretfe.case import parse_case

STORED = Path(__file__).parents[1] / "data" / "campaign_zones.json"
COUNT = 36
HALF_PLANE_STEPS = 60


@dataclass(frozen=True)
class KnownZone:
    """A slip zone by half-planes.

    Attributes:
        end: time of its end.
        length: of the zone.
        spread: error of the length.
        counts: whether the zone is resolved and leaves a part of the contact in stick.
    """

    end: float
    length: float
    spread: float
    counts: bool


Zones = tuple[tuple[KnownZone, ...], ...]


def known_zones(one: Draw) -> Zones:
    """Zones of both edges, as they are stored if they are."""
    if one.number < COUNT and one == draw(one.number):
        return stored_zones()[one.number]
    return zones_by_half_planes(one)


def zones_by_half_planes(one: Draw) -> Zones:
    """Zones of both edges, solved."""
    result = fretfe.run(parse_case(case_of(one, HALF_PLANE_STEPS)), backend="halfplane")
    times = result.loads.times
    return tuple(
        tuple(
            KnownZone(
                float(times[zone.end]), zone.length, zone.spread, zone.resolved and not zone.gross
            )
            for zone in station.slip_zones
        )
        for station in result.contacts[0].stations
    )


@cache
def stored_zones() -> tuple[Zones, ...]:
    """Zones of the first cases, by their numbers."""
    return tuple(
        tuple(tuple(KnownZone(*zone) for zone in edge) for edge in edges)
        for edges in json.loads(STORED.read_text("utf-8"))
    )


def zone_ending_at(zones: tuple[KnownZone, ...], end: float, tolerance: float) -> KnownZone | None:
    """The zone whose end is nearest to a time and no more than `tolerance` away."""
    if math.isnan(end):
        return zones[-1] if zones else None
    nearest = min(zones, key=lambda zone: abs(zone.end - end), default=None)
    if nearest is None or abs(nearest.end - end) > 1.01 * tolerance:
        return None
    return nearest


def main() -> None:
    """Solve and store the first cases, one a line."""
    lines = [
        json.dumps(
            [[astuple(zone) for zone in edge] for edge in zones_by_half_planes(draw(number))]
        )
        for number in range(COUNT)
    ]
    STORED.write_text("[" + ",\n".join(lines) + "]\n", "utf-8")


if __name__ == "__main__":
    main()
