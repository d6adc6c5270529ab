# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows of a companion run: its numbers against those of the case."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.verdicts import BORDER_ELEMENTS, BORDER_FRACTION
from fretfe.quality.validate.rows import Row, Verdict, compared, missing
from fretfe.quality.validate.variants import COARSER, MEAN, MESH, START
from fretfe.results.model import Result

# Halving the elements would change a first-order quantity by this many times the difference.
EXTRAPOLATION = 1 / (COARSER - 1)
MESH_TOLERANCE = 0.02
STEADY_REASONS = {
    MEAN: "the mean of K_T does not count in a steady cycle",
    START: "the steady cycle forgets how it was reached, unless the whole contact slid",
}
SLIP_TOLERANCE = 0.05


def companion_rows(name: str, result: Result, other: Result) -> Iterator[Row]:
    """Rows for each station, the companion's numbers as references."""
    for contact in result.contacts:
        twin = _twin(contact, other)
        if twin is None:
            reason = "the companion has no patch there at its end"
            verdict: Verdict = "unknown" if contact.normal_force[-1] > 0 else "-"
            yield missing(contact.name, "", name, reason, verdict)
            continue
        for station, reference in zip(contact.stations, twin.stations, strict=True):
            if name == MESH:
                yield from _mesh_rows(contact.name, station, reference)
            else:
                yield from _slip_rows(name, contact.name, station, reference)


def _twin(contact: Contact, other: Result) -> Contact | None:
    """The contact of a companion that is in the same place at the end; None if there is none.

    What patches are called depends on the order in which they appear, and may differ.
    """
    twins = [each for each in other.contacts if each.pair == contact.pair]
    if contact.name == contact.pair and len(twins) == 1:
        return twins[0]
    for each in twins:
        (centre, half_width), (other_centre, _) = _place(contact), _place(each)
        if abs(other_centre - centre) < half_width:
            return each
    return None


def _place(contact: Contact) -> tuple[float, float]:
    """Centre and half-width at the end of the cycle."""
    last = contact.stations[0].last
    return float(contact.centre[last]), float(contact.half_width[last])


def _slip_rows(name: str, contact: str, station: Station, other: Station) -> Iterator[Row]:
    """The same steady slip zone, whatever the mean and the way to it."""
    otherwise: Verdict = "depends" if name == START else "FAIL"
    length, reference = _length(station), _length(other)
    tolerance = BORDER_ELEMENTS * station.size + BORDER_FRACTION * (length if length > 0 else 0.0)
    yield compared(
        contact,
        station.front,
        f"d {name}",
        length,
        reference,
        tolerance,
        STEADY_REASONS[name],
        otherwise,
    )


def _mesh_rows(contact: str, station: Station, coarse: Station) -> Iterator[Row]:
    """Extrapolated error of each number, first order."""
    reason = f"elements {COARSER:g} times as large: the error of the case is about twice the change"
    for quantity, value, reference, share in (
        ("K_N", station.last_k_n[0], coarse.last_k_n[0], MESH_TOLERANCE),
        ("ΔK_T", station.k_t_range, coarse.k_t_range, MESH_TOLERANCE),
    ):
        if math.isnan(value) or math.isnan(reference):
            given = "the coarser mesh does not carry this number"
            yield missing(contact, station.front, f"{quantity} {MESH}", given)
            continue
        tolerance = share * abs(value) / EXTRAPOLATION
        yield compared(
            contact, station.front, f"{quantity} {MESH}", value, reference, tolerance, reason
        )
    length, reference = _length(station), _length(coarse)
    if coarse.slip_zones and not math.isnan(length):
        tolerance = (
            SLIP_TOLERANCE * length / EXTRAPOLATION + BORDER_ELEMENTS * COARSER * station.size
        )
        yield compared(contact, station.front, f"d {MESH}", length, reference, tolerance, reason)


def _length(station: Station) -> float:
    return station.slip_zones[-1].length if station.slip_zones else math.nan
