# SPDX-License-Identifier: LGPL-3.0-or-later
"""Verdicts on slip zones at stations of solids: as found, against what the factors predict."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fretfe.edges.front import SlipZone
from fretfe.edges.solid_fronts import SolidStation

# The formulas are the first term of a series in d over the length of the edge's own pressure; its
# error is trusted within a factor, and beyond a size not at all.
ESTIMATE_FACTOR, LARGEST_ERROR = 1.5, 0.1
# Besides the error bars: what the mesh may hide, in elements.
WITHIN_ELEMENT = 0.2
# The formulas hold for loads on a line: range across the direction of (K_T, K_S) over that along.
LARGEST_TURNING = 0.1

AGREES, DIFFERS, OUTSIDE, NO_VERDICT = "agrees", "differs", "outside", "no verdict"
NOT_RESOLVED, GROSS, END, UNKNOWN = "not resolved", "gross", "end", "unknown"


@dataclass(frozen=True)
class Verdict:
    """What a station's slip zone says of the formulas.

    Attributes:
        word: one of those of this module.
        reason: in words.
        tolerance: largest difference of the lengths at which they agree; NaN without a comparison.
    """

    word: str
    reason: str
    tolerance: float = math.nan


def judge(station: SolidStation, zone: SlipZone) -> Verdict:
    """Compare a slip zone with its prediction, where the station and the zone allow it."""
    word, reason = _excuse(station, zone)
    if word:
        return Verdict(word, reason)
    predicted = zone.prediction
    expected = zone.length / station.length
    if expected > LARGEST_ERROR:
        return Verdict(
            OUTSIDE,
            f"the zone is {expected:.0%} of the length over which the edge determines the "
            f"pressure, more than {LARGEST_ERROR:.0%}: the formulas say only about how long it is",
        )
    relative = math.hypot(
        station.k_n_spread[zone.end] / station.k_n[zone.end],
        station.k_range_spread / station.k_range if station.k_range > 0 else 0.0,
    )
    tolerance = (
        ESTIMATE_FACTOR * expected * zone.length
        + relative * predicted
        + zone.spread
        + WITHIN_ELEMENT * station.size
    )
    reason = (
        f"first-order error of the formulas {expected:.1%}, error bars of K_N and of the range "
        f"{relative:.1%}, of the length {zone.spread:.3g}, and {WITHIN_ELEMENT:g} elements"
    )
    word = AGREES if abs(zone.length - predicted) <= tolerance else DIFFERS
    return Verdict(word, reason, tolerance)


def _excuse(station: SolidStation, zone: SlipZone) -> tuple[str, str]:
    """Why there is nothing to compare, as a word and a reason; two empty texts if there is."""
    if station.end:
        return (
            END,
            "within a local length of a free end, where the fields are not those of an edge",
        )
    if zone.gross:
        return GROSS, "the contact slips as far as its middle"
    if not zone.resolved or (math.isnan(zone.told_length) and zone.length > 0):
        return NOT_RESOLVED, "too few elements over the slip zone"
    if math.isnan(zone.prediction):
        return UNKNOWN, "K_N or the range of K_T and K_S is not known through the half cycle"
    if station.uncertain or not station.k_range_spread <= 0.5 * station.k_range:
        return UNKNOWN, "K_N or the range of K_T and K_S has a large error bar"
    if station.turning > LARGEST_TURNING:
        return NO_VERDICT, "the direction of K_T and K_S turns: there is no formula"
    return "", ""
