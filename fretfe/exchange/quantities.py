# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of the edges and contacts of two results, pair by pair."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from fretfe.case import Units
from fretfe.edges.area import AreaSummary
from fretfe.edges.front import ContactSummary, SlipZone, Station
from fretfe.edges.front_means import front_means
from fretfe.edges.refinement import StationValues
from fretfe.exchange.compared import QuantityPair
from fretfe.report.source import work_unit
from fretfe.results.model import Result

# Slip zones are those of the last two half cycles, in the order of time.
K_N, K_T, ZONES = "K_N", "ΔK_T", ("d_1", "d_2")
# Times that differ by less than this fraction of the clock are the same.
SAME_TIME = 1e-6
Pairs = Sequence[tuple[Any, Any]]


class Number(NamedTuple):
    """A number of one result: what it is, its unit, its value, its error bar."""

    quantity: str
    unit: str
    value: float
    spread: float = math.nan


def quantity_pairs(first: Result, second: Result, pairs: Pairs) -> Iterator[QuantityPair]:
    """Numbers of all contacts that belong together."""
    units = first.case.units
    means = [_means(each) for each in (first, second)]
    for one, two in pairs:
        if isinstance(one, AreaSummary):
            yield from _paired(one.name, "", _area(one, first), _area(two, second))
            for front, values in means[0].get(one.name, {}).items():
                if other := means[1].get(two.name, {}).get(front):
                    mine = _front(values, units)
                    yield from _paired(one.name, front, mine, _front(other, units))
            continue
        mine, other_numbers = (_contact(each, units) for each in (one, two))
        yield from _paired(one.name, "", mine, other_numbers)
        for edge, partner in zip(one.stations, two.stations, strict=True):
            numbers = (_edge(each, result) for each, result in ((edge, first), (partner, second)))
            yield from _paired(one.name, edge.front, *numbers)


def _paired(
    contact: str, edge: str, first: Sequence[Number], second: Sequence[Number]
) -> Iterator[QuantityPair]:
    for mine, other in zip(first, second, strict=True):
        if math.isfinite(mine.value) or math.isfinite(other.value):
            yield QuantityPair(
                contact, edge, mine.quantity, mine.unit,
                mine.value, other.value, mine.spread, other.spread,
            )  # fmt: skip


def _contact(contact: ContactSummary, units: Units) -> list[Number]:
    return [Number("half-width", units.length, float(contact.half_width[-1]))]


def _edge(edge: Station, result: Result) -> list[Number]:
    units = result.case.units
    zones: list[SlipZone | None] = [None, None, *edge.slip_zones][-2:]
    return [
        Number(K_N, f"{units.stress}/√{units.length}", edge.told_k_n, float(edge.k_n_spread[-1])),
        Number(K_T, f"{units.stress}·√{units.length}", edge.told_range, edge.k_t_range_spread),
        *(
            Number(name, units.length, zone.told_length, zone.spread)
            if zone
            else Number(name, units.length, math.nan)
            for name, zone in zip(ZONES, zones, strict=True)
        ),
        Number("friction work", work_unit(result), edge.dissipation),
    ]


def _area(area: AreaSummary, result: Result) -> list[Number]:
    units = result.case.units
    return [
        Number("P", units.force, float(area.normal_force[-1])),
        Number("contact area", f"{units.length}²", float(area.contact_area[-1])),
        Number("stick area", f"{units.length}²", float(area.stick_area[-1])),
        Number("largest p", units.stress, float(area.largest_pressure[-1])),
        Number("friction work", work_unit(result), area.dissipation),
    ]


def _means(result: Result) -> dict[str, dict[str, StationValues]]:
    """Means along the fronts of solids, by contact and front."""
    found: dict[str, dict[str, StationValues]] = {}
    if result.areas and result.solution is not None:
        for each in front_means(result.areas, result.solution):
            found.setdefault(each.contact, {})[each.front] = each
    return found


def _front(values: StationValues, units: Units) -> list[Number]:
    slip = values.slip or (math.nan, math.nan)
    return [
        Number(f"mean {K_N}", f"{units.stress}/√{units.length}", values.k_n),
        Number("mean ΔK", f"{units.stress}·√{units.length}", values.k_t),
        *(
            Number(f"mean {name}", units.length, length)
            for name, length in zip(ZONES, slip, strict=True)
        ),
    ]


def zone_notes(first: Result, second: Result, pairs: Pairs) -> Iterator[str]:
    """Edges whose last slip zones are those of half cycles that end at other times."""
    clock = max(float(each.loads.times[-1]) for each in (first, second))
    for one, two in pairs:
        if isinstance(one, AreaSummary):
            continue
        for edge, partner in zip(one.stations, two.stations, strict=True):
            if not (edge.slip_zones and partner.slip_zones):
                continue
            ends = [
                float(result.loads.times[each.slip_zones[-1].end])
                for result, each in ((first, edge), (second, partner))
            ]
            if abs(ends[1] - ends[0]) > SAME_TIME * clock:
                yield (
                    f"{one.name} {edge.front}: the last slip zones end at t = {ends[0]:g} and "
                    f"t = {ends[1]:g}"
                )
