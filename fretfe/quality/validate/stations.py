# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows about the stations of a front of solids, and stations of two fronts in the same place."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.edges.area import AreaSummary
from fretfe.edges.solid_fronts import SolidFront, SolidStation
from fretfe.quality.validate.rows import Row, Verdict, compared, missing

# Share of the stations that must agree, as error bars hold for 95 %.
WITHIN = 0.9
# Share of the stations that a companion must have a number for.
CARRIED = 0.5


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
    area: AreaSummary,
    front: SolidFront,
    quantity: str,
    pairs: Pairs,
    reason: str,
    otherwise: Verdict = "FAIL",
) -> Row:
    """One row for the stations of a front: that of the worst of the best nine tenths of them."""
    known = np.flatnonzero(pairs.known)
    if len(known) < max(CARRIED * len(pairs.values), 1):
        given = f"there is a number to compare at {len(known)} of {len(pairs.values)} stations only"
        return missing(area.name, front.name, quantity, given)
    off = np.abs(pairs.values - pairs.references)[known]
    tolerances = pairs.tolerances[known]
    order = np.argsort(off / np.maximum(tolerances, 1e-300))
    chosen = known[order[math.ceil(WITHIN * len(known)) - 1]]
    inside = np.count_nonzero(off <= tolerances)
    return compared(
        area.name,
        front.name,
        quantity,
        float(pairs.values[chosen]),
        float(pairs.references[chosen]),
        float(pairs.tolerances[chosen]),
        f"{reason}. {inside} of {len(known)} stations agree, {WITHIN:.0%} must; the line is that "
        "of the worst of these",
        otherwise,
    )


def numbers(stations: Sequence[SolidStation], name: str) -> Array:
    """(n,) a number of stations: an attribute, "K_N", or "d" and "d bar" of the last slip zone."""
    return np.array([_number(station, name) for station in stations])


def _number(station: SolidStation, name: str) -> float:
    if name == "K_N":
        return station.told_k_n
    if name == "K_N bar":
        return float(station.k_n_spread[-1])
    if name in ("d", "d bar"):
        zone = station.slip_zones[-1] if station.slip_zones else None
        if zone is None or zone.gross or not zone.resolved:
            return math.nan
        return zone.told_length if name == "d" else zone.spread
    return float(getattr(station, name))


def nearest_front(front: SolidFront, others: Sequence[SolidFront]) -> SolidFront | None:
    """The front among others that runs nearest to the stations of one; None without any."""
    points = front.along("point")

    def distance(other: SolidFront) -> float:
        gaps = np.linalg.norm(points[:, None] - other.along("point"), axis=2)
        return float(gaps.min(axis=1).mean())

    return min(
        (other for other in others if other.closed == front.closed), key=distance, default=None
    )


def at_places(front: SolidFront, points: Array, names: Sequence[str]) -> Iterator[Array]:
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
