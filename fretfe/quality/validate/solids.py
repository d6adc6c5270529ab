# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows of a run of solids, by itself and against a companion: one for each front."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.evaluate.verdicts import (
    BORDER_ELEMENTS,
    BORDER_FRACTION,
    judge,
    last_verdict,
    withheld,
)
from fretfe.quality.validate.compare import STEADY_REASONS
from fretfe.quality.validate.rows import Row, Verdict, compared, missing
from fretfe.quality.validate.single import row_verdict, steady_row
from fretfe.quality.validate.variants import COARSER, MESH, START
from fretfe.results.model import Result

# Share of the stations that must agree, as error bars hold for 95 %.
WITHIN = 0.9
# Share of the stations that a companion must have a number for.
CARRIED = 0.5
# Ranges of K_T and K_S that other reaches of the integrals give, relative to the largest along the
# front.
REACH_AGREEMENT = 0.02
# No more than this part of a number counts of its own error bar: it must not excuse whatever comes.
LARGEST_BAR = 0.1


@dataclass(frozen=True)
class Pairs:
    """Numbers of n stations and what they are compared with; NaN where there is none.

    Attributes:
        values: (n,) the numbers.
        references: (n,) what they should be.
        tolerances: (n,) largest acceptable differences.
    """

    values: Array
    references: Array
    tolerances: Array

    @property
    def known(self) -> Bools:
        """(n,) where there is something to compare."""
        return np.asarray(np.isfinite(self.values + self.references + self.tolerances))


def front_row(
    contact: Contact,
    front: Front,
    quantity: str,
    pairs: Pairs,
    reason: str,
    otherwise: Verdict = "FAIL",
) -> Row:
    """One row for the stations of a front: that of the worst of the best nine tenths of them."""
    known = np.flatnonzero(pairs.known)
    if len(known) < max(CARRIED * len(pairs.values), 1):
        given = f"there is a number to compare at {len(known)} of {len(pairs.values)} stations only"
        return missing(contact.name, front.name, quantity, given)
    off = np.abs(pairs.values - pairs.references)[known]
    tolerances = pairs.tolerances[known]
    order = np.argsort(off / np.maximum(tolerances, 1e-300))
    chosen = known[order[math.ceil(WITHIN * len(known)) - 1]]
    inside = np.count_nonzero(off <= tolerances)
    return compared(
        contact.name,
        front.name,
        quantity,
        float(pairs.values[chosen]),
        float(pairs.references[chosen]),
        float(pairs.tolerances[chosen]),
        f"{reason}. {inside} of {len(known)} stations agree, {WITHIN:.0%} must; the line is that "
        "of the worst of these",
        otherwise,
    )


def numbers(stations: Sequence[Station], name: str) -> Array:
    """(n,) a number of stations: an attribute, "K_N", or "d" and "d bar" of the last slip zone."""
    return np.array([_number(station, name) for station in stations])


def _number(station: Station, name: str) -> float:
    if name == "K_N":
        return station.reported_k_n
    if name == "K_N bar":
        return station.last_k_n[1]
    if name in ("d", "d bar"):
        zone = station.slip_zones[-1] if station.slip_zones else None
        if zone is None or zone.gross or not zone.resolved:
            return math.nan
        return zone.reported_length if name == "d" else zone.spread
    return float(getattr(station, name))


def nearest_front(front: Front, others: Sequence[Front]) -> Front | None:
    """The front among others that runs nearest to the stations of one; None without any."""
    points = front.along("point")

    def distance(other: Front) -> float:
        gaps = np.linalg.norm(points[:, None] - other.along("point"), axis=2)
        return float(gaps.min(axis=1).mean())

    return min(
        (other for other in others if other.closed == front.closed), key=distance, default=None
    )


def at_places(front: Front, points: Array, names: Sequence[str]) -> Iterator[Array]:
    """Numbers (n,) of a front at the places of its line that are nearest to points (n, 3).

    Linear between the stations; NaN where a neighbour has none, or is an end.
    """
    places = front.along("point")
    ends = np.roll(places, -1, axis=0) if front.closed else places[1:]
    starts = places[: len(ends)]
    lines = ends - starts
    share = np.einsum("nmd,md->nm", points[:, None] - starts, lines) / np.sum(lines**2, axis=1)
    share = np.clip(share, 0.0, 1.0)
    gaps = np.linalg.norm(starts + share[..., None] * lines - points[:, None], axis=2)
    first = gaps.argmin(axis=1)
    part = share[np.arange(len(points)), first]
    second = (first + 1) % len(places)
    for name in names:
        values = numbers(front.stations, name)
        values[front.along("end").astype(bool)] = np.nan
        # A place on a station needs no neighbour.
        terms = (part < 1, (1 - part) * values[first]), (part > 0, part * values[second])
        yield np.sum([np.where(used, term, 0.0) for used, term in terms], axis=0)


def solid_rows(result: Result) -> Iterator[Row]:
    """Rows for each contact and front of a run of solids."""
    for contact in result.contacts:
        if not contact.solid:
            continue
        yield steady_row(contact.name, contact.cycle_change)
        if not contact.fronts and contact.normal_force[-1] > 0:
            yield missing(contact.name, "", "fronts", _reason(contact, "cannot be told"), "unknown")
        for front in contact.fronts:
            yield from _front_rows(contact, front)


def _reason(contact: Contact, word: str) -> str:
    return next((text for text in contact.warnings if word in text), "too few elements in contact")


def _front_rows(contact: Contact, front: Front) -> Iterator[Row]:
    stations = front.judged
    if not stations:
        yield missing(contact.name, front.name, "stations", "all of them are near its ends")
        return
    told = {"K_N": numbers(stations, "K_N")}
    if np.isfinite(contact.cycle_change):
        told["ΔK"] = numbers(stations, "reported_range")
    for quantity, values in told.items():
        unknown = np.count_nonzero(np.isnan(values))
        if unknown > (1 - WITHIN) * len(values):
            reasons = [each for station in stations if (each := withheld(station))]
            text = (
                f"not known to within half of it at {unknown} of {len(values)} stations, as "
                f"{reasons[len(reasons) // 2]}"
            )
            yield missing(contact.name, front.name, quantity, text, "unknown")
    ranges, spread = numbers(stations, "k_range"), _extraction(front)
    largest = np.nanmax(ranges, initial=0.0)
    pairs = Pairs(ranges, ranges + spread, np.full(len(ranges), REACH_AGREEMENT * largest))
    reason = f"half the spread over reaches and lengths, {REACH_AGREEMENT:.0%} of the largest"
    yield front_row(contact, front, "ΔK, other reach", pairs, reason)
    yield from _formula_rows(contact, front)


def _extraction(front: Front) -> Array:
    return np.array([station.k_range_parts.extraction for station in front.judged])


def _formula_rows(contact: Contact, front: Front) -> Iterator[Row]:
    """The last two slip zones, found and predicted, at the stations where formulas hold."""
    for half in (1, 2):
        label = f"d, by formula, half cycle {half}"
        zones = [
            (each, each.slip_zones[half - 3]) for each in front.judged if len(each.slip_zones) > 1
        ]
        verdicts = [judge(station, zone) for station, zone in zones]
        known = [place for place, each in enumerate(verdicts) if np.isfinite(each.tolerance)]
        if not known:
            yield _no_formula(
                contact, front, label, [(each.word, each.reason) for each in verdicts]
            )
            continue
        pairs = Pairs(
            np.array([zones[place][1].length for place in known]),
            np.array([zones[place][1].prediction for place in known]),
            np.array([verdicts[place].tolerance for place in known]),
        )
        reason = "the formula's own error, the error bars, and a fifth of an element"
        yield front_row(contact, front, label, pairs, reason)


def _no_formula(contact: Contact, front: Front, label: str, excuses: list[tuple[str, str]]) -> Row:
    """Verdict where nothing can be compared: the most frequent word, and a reason for it."""
    if not excuses:
        own = last_verdict(front.judged[len(front.judged) // 2])
        return missing(contact.name, front.name, label, own.reason)
    ((word, _),) = Counter(word for word, _ in excuses).most_common(1)
    reason = next(text for each, text in excuses if each == word)
    return missing(contact.name, front.name, label, f"{word}: {reason}", row_verdict(word))


def solid_companion_rows(name: str, result: Result, other: Result) -> Iterator[Row]:
    """Rows for each front, the numbers of the companion in the same places as references."""
    partners = {each.name: each for each in other.contacts}
    for contact in result.contacts:
        for front in contact.fronts:
            twin = nearest_front(front, partners[contact.name].fronts)
            if twin is None:
                reason = "the companion has no such front at the end of its cycle"
                yield missing(contact.name, front.name, name, reason)
            elif front.judged:
                yield from _compared(name, contact, front, twin)


def _compared(name: str, contact: Contact, front: Front, twin: Front) -> Iterator[Row]:
    if name == MESH:
        for label, value, bar in (
            ("K_N", "K_N", "K_N bar"),
            ("ΔK", "reported_range", "k_range_spread"),
            ("d", "d", "d bar"),
        ):
            yield _mesh_row(f"{label} {name}", contact, front, twin, value, bar)
        return
    places = np.array([station.point for station in front.judged])
    values, (reference,) = numbers(front.judged, "d"), at_places(twin, places, ["d"])
    sizes = numbers(front.judged, "size")
    pairs = Pairs(values, reference, BORDER_ELEMENTS * sizes + BORDER_FRACTION * values)
    otherwise: Verdict = "depends" if name == START else "FAIL"
    yield front_row(contact, front, f"d {name}", pairs, STEADY_REASONS[name], otherwise)


def _mesh_row(label: str, contact: Contact, front: Front, twin: Front, value: str, bar: str) -> Row:
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
    return front_row(contact, front, label, Pairs(values, references, np.hypot(own, other)), reason)
