# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows of a run of solids, by itself and against a companion: one for each front and number."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from fretfe._typing import Array
from fretfe.edges.area import AreaSummary
from fretfe.edges.solid_fronts import SolidFront
from fretfe.edges.solid_verdicts import OUTSIDE, judge
from fretfe.quality.validate.compare import STEADY_REASONS
from fretfe.quality.validate.rows import Row, Verdict, missing
from fretfe.quality.validate.single import BORDER_ELEMENTS, BORDER_FRACTION, steady_row
from fretfe.quality.validate.stations import (
    WITHIN,
    Pairs,
    at_places,
    front_row,
    nearest_front,
    numbers,
)
from fretfe.quality.validate.variants import COARSER, MESH, START
from fretfe.results.model import Result

# Ranges of K_T and K_S that other reaches of the integrals give, relative to the largest along the
# front.
REACH_AGREEMENT = 0.02
# No more than this part of a number counts of its own error bar: it must not excuse whatever comes.
LARGEST_BAR = 0.1


def solid_rows(result: Result) -> Iterator[Row]:
    """Rows for each contact and front of a run of solids."""
    for area in result.areas:
        yield steady_row(area.name, area.cycle_change)
        if not area.fronts and area.normal_force[-1] > 0:
            yield missing(area.name, "", "fronts", _reason(area, "cannot be told"), "unknown")
        for front in area.fronts:
            yield from _front_rows(area, front)


def _reason(area: AreaSummary, word: str) -> str:
    return next((text for text in area.warnings if word in text), "too few elements in contact")


def _front_rows(area: AreaSummary, front: SolidFront) -> Iterator[Row]:
    stations = front.judged
    if not stations:
        yield missing(area.name, front.name, "stations", "all of them are near its ends")
        return
    told = {"K_N": numbers(stations, "K_N")}
    if np.isfinite(area.cycle_change):
        told["ΔK"] = numbers(stations, "told_range")
    for quantity, values in told.items():
        unknown = np.count_nonzero(np.isnan(values))
        if unknown > (1 - WITHIN) * len(values):
            text = (
                f"not known to within half of it at {unknown} of {len(values)} stations: take "
                "smaller elements along the front"
            )
            yield missing(area.name, front.name, quantity, text, "unknown")
    ranges, spread = numbers(stations, "k_range"), _extraction(front)
    largest = np.nanmax(ranges, initial=0.0)
    pairs = Pairs(ranges, ranges + spread, np.full(len(ranges), REACH_AGREEMENT * largest))
    reason = f"half the spread over reaches and lengths, {REACH_AGREEMENT:.0%} of the largest"
    yield front_row(area, front, "ΔK, other reach", pairs, reason)
    yield from _formula_rows(area, front)


def _extraction(front: SolidFront) -> Array:
    return np.array([station.k_range_parts.extraction for station in front.judged])


def _formula_rows(area: AreaSummary, front: SolidFront) -> Iterator[Row]:
    """The last two slip zones, found and predicted, at the stations where formulas hold."""
    for half in (1, 2):
        label = f"d, by formula, half cycle {half}"
        zones = [
            (each, each.slip_zones[half - 3]) for each in front.judged if len(each.slip_zones) > 1
        ]
        verdicts = [judge(station, zone) for station, zone in zones]
        known = [place for place, each in enumerate(verdicts) if np.isfinite(each.tolerance)]
        if not known:
            yield _no_formula(area, front, label, [(each.word, each.reason) for each in verdicts])
            continue
        pairs = Pairs(
            np.array([zones[place][1].length for place in known]),
            np.array([zones[place][1].prediction for place in known]),
            np.array([verdicts[place].tolerance for place in known]),
        )
        reason = "the formula's own error, the error bars, and a fifth of an element"
        yield front_row(area, front, label, pairs, reason)


def _no_formula(
    area: AreaSummary, front: SolidFront, label: str, excuses: list[tuple[str, str]]
) -> Row:
    """The most frequent reason why there is nothing to compare."""
    if not excuses:
        return missing(area.name, front.name, label, "no friction, or factors that are not known")
    (word, reason), _ = Counter(excuses).most_common(1)[0]
    verdict: Verdict = "outside" if word == OUTSIDE else "-"
    return missing(area.name, front.name, label, f"{word}: {reason}", verdict)


def solid_companion_rows(name: str, result: Result, other: Result) -> Iterator[Row]:
    """Rows for each front, the numbers of the companion in the same places as references."""
    areas = {area.name: area for area in other.areas}
    for area in result.areas:
        for front in area.fronts:
            twin = nearest_front(front, areas[area.name].fronts)
            if twin is None:
                reason = "the companion has no such front at the end of its cycle"
                yield missing(area.name, front.name, name, reason)
            elif front.judged:
                yield from _compared(name, area, front, twin)


def _compared(name: str, area: AreaSummary, front: SolidFront, twin: SolidFront) -> Iterator[Row]:
    if name == MESH:
        for label, value, bar in (
            ("K_N", "K_N", "K_N bar"),
            ("ΔK", "told_range", "k_range_spread"),
            ("d", "d", "d bar"),
        ):
            yield _mesh_row(f"{label} {name}", area, front, twin, value, bar)
        return
    places = np.array([station.point for station in front.judged])
    values, (reference,) = numbers(front.judged, "d"), at_places(twin, places, ["d"])
    sizes = numbers(front.judged, "size")
    pairs = Pairs(values, reference, BORDER_ELEMENTS * sizes + BORDER_FRACTION * values)
    otherwise: Verdict = "depends" if name == START else "FAIL"
    yield front_row(area, front, f"d {name}", pairs, STEADY_REASONS[name], otherwise)


def _mesh_row(
    label: str, area: AreaSummary, front: SolidFront, twin: SolidFront, value: str, bar: str
) -> Row:
    """A number of the stations on two meshes, within both error bars."""
    places = np.array([station.point for station in front.judged])
    values, bars = (numbers(front.judged, each) for each in (value, bar))
    references, other = at_places(twin, places, [value, bar])
    # Slip zones of a fraction of their front need not be known to a tenth of themselves.
    own = bars if value == "d" else np.minimum(bars, LARGEST_BAR * np.abs(values))
    reason = (
        f"elements {COARSER:g} times as large: the error bars of both meshes, that of a factor of "
        f"the case {LARGEST_BAR:.0%} at most"
    )
    return front_row(area, front, label, Pairs(values, references, np.hypot(own, other)), reason)
