# SPDX-License-Identifier: LGPL-3.0-or-later
"""The table of the fronts of solids."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from rich.table import Table

from fretfe.case import Case
from fretfe.edges.area import AreaSummary
from fretfe.edges.solid_fronts import SolidStation
from fretfe.edges.solid_verdicts import judge
from fretfe.report.page.listings import plain_table
from fretfe.report.texts import MISSING, number, with_error


def front_table(case: Case, areas: tuple[AreaSummary, ...]) -> Table:
    """Two rows per front of solids: the range along it, and the station of the largest |ΔK|.

    A station is told by its number and its distance along the front; those too near an end are
    left out.
    """
    units = case.units
    title = (
        f"Fronts: lengths in {units.length}, K_N in {units.stress}/√{units.length}, |ΔK| of K_T "
        f"and K_S in {units.stress}·√{units.length}, slip zones of the last half cycle"
    )
    headers = ("front", "K_N", "|ΔK|", "slip", "predicted")
    table = plain_table(title, headers, text=1)
    for area in areas:
        for front in area.fronts:
            judged = front.judged
            if not judged:
                table.add_row(f"{area.name} {front.name}", *[MISSING] * 4)
                table.add_row("  all too near an end")
                continue
            table.add_row(f"{area.name} {front.name}", *_along(judged))
            for word, count in _verdicts(judged).items():
                table.add_row(f"  {count} {word}")
            worst = front.worst
            if worst is not None:
                table.add_row(f"  {worst.number} at {number(worst.arc, 3)}", *_at(worst))
    return table


def _verdicts(stations: tuple[SolidStation, ...]) -> Counter[str]:
    """How many of the last slip zones have each verdict."""
    return Counter(judge(each, each.slip_zones[-1]).word for each in stations if each.slip_zones)


def _along(stations: tuple[SolidStation, ...]) -> tuple[str, ...]:
    """Cells of the range of the numbers of all stations."""
    zones = [each.slip_zones[-1] for each in stations if each.slip_zones]
    return (
        _known_range([each.told_k_n for each in stations], digits=4),
        _known_range([each.told_range for each in stations], digits=3),
        _known_range([zone.told_length for zone in zones], digits=2),
        _known_range([zone.prediction for zone in zones], digits=2),
    )


def _at(station: SolidStation) -> tuple[str, ...]:
    """The same cells of one station, with error bars."""
    zone = station.slip_zones[-1] if station.slip_zones else None
    return (
        with_error(station.told_k_n, float(station.k_n_spread[-1])),
        with_error(station.told_range, station.k_range_spread),
        with_error(zone.told_length, zone.spread) if zone else MISSING,
        number(zone.prediction, 3) if zone else MISSING,
    )


def _known_range(values: Sequence[float], digits: int) -> str:
    """Smallest and largest of the numbers that are known."""
    known = [value for value in values if math.isfinite(value)]
    if not known:
        return MISSING
    ends = [number(end, digits) for end in (min(known), max(known))]
    return ends[0] if ends[0] == ends[1] else "…".join(ends)
