# SPDX-License-Identifier: LGPL-3.0-or-later
"""Verdicts on slip zones at stations of solids: as found, against what the factors predict."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from fretfe.evaluate.contacts import LARGEST_SPREAD, SlipZone, Station

# The formulas are the first term of a series in d over the length of the edge's own pressure; its
# error is trusted within a factor, and beyond a size not at all.
ESTIMATE_FACTOR, LARGEST_ERROR = 1.5, 0.1
# Besides the error bars: what the mesh may hide, in elements.
WITHIN_ELEMENT = 0.2
# The formulas hold for loads on a line: range across the direction of (K_T, K_S) over that along.
LARGEST_TURNING = 0.1

# Part of f p that may act across that line before: more of it leaves an eighth less for the shear
# along it, and slip zones that are longer by as much.
LARGEST_ACROSS = 0.5
# Elements over a slip zone from which they are not too few for its border.
FEWEST_ELEMENTS = 4
# What the parts of the error bar of a range stand for.
PARTS = {
    "extraction": "the radii of the integral disagree",
    "discretisation": "the front is somewhere within an element, or elements along it are long",
    "steps": "K_T and K_S may go farther between the steps: take more steps per cycle",
}

AGREES, DIFFERS, OUTSIDE, NO_VERDICT = "agrees", "differs", "outside", "no verdict"
NOT_RESOLVED, GROSS, END, UNKNOWN = "not resolved", "gross", "end", "unknown"
NO_ZONE = "no slip zone"


@dataclass(frozen=True)
class Verdict:
    """Verdict of a station's slip zone on the formulas.

    Attributes:
        word: one of those of this module.
        reason: in words.
        tolerance: largest difference of the lengths at which they agree; NaN without a comparison.
    """

    word: str
    reason: str
    tolerance: float = math.nan


def last_verdict(station: Station) -> Verdict:
    """The verdict on the last slip zone of a station, or why it has none."""
    if station.slip_zones:
        return judge(station, station.slip_zones[-1])
    reason = withheld(station)
    if reason:
        return Verdict(UNKNOWN, reason)
    return Verdict(NO_ZONE, "there is no friction, or neither K_T nor K_S varies")


def withheld(station: Station) -> str:
    """Reason why K_N or the range of (K_T, K_S) of a station is not told; empty if both are."""
    return "; ".join(filter(None, (_no_k_n(station), _no_range(station))))


def _no_k_n(station: Station) -> str:
    k_n, spread = station.last_k_n
    if math.isfinite(station.told_k_n):
        return ""
    if math.isnan(k_n):
        return "K_N is not known, since the pressure next to the front has no fit"
    return f"K_N is {k_n:.3g} ± {spread:.2g}, an error bar of more than half of it"


def _no_range(station: Station) -> str:
    if math.isfinite(station.told_range):
        return ""
    if math.isnan(station.k_range):
        known = np.isfinite(station.k_t + station.k_s)[: station.last + 1 or None]
        unknown = np.flatnonzero(~known)
        if not len(unknown):
            return "there is no evaluated cycle, and no range of K_T and K_S"
        return (
            f"K_T and K_S are not known in {len(unknown)} of {len(known)} states, last in state "
            f"{unknown[-1]}: the front cannot be found there, or moves to where nothing was "
            "integrated"
        )
    parts = asdict(station.k_range_parts)
    if math.isnan(station.k_range_spread):
        lost = " and ".join(name for name, part in parts.items() if math.isnan(part))
        return f"the range of K_T and K_S has no error bar ({lost or 'nothing to compare with'})"
    largest = max(parts, key=lambda name: parts[name])
    return (
        f"the range of K_T and K_S is {station.k_range:.3g} ± {station.k_range_spread:.2g}, an "
        f"error bar of more than half of it: {PARTS.get(largest, largest)}"
    )


def judge(station: Station, zone: SlipZone) -> Verdict:
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


def _unresolved(station: Station, zone: SlipZone) -> str:
    elements = zone.length / station.size
    if zone.length > 0 and elements >= FEWEST_ELEMENTS:
        return (
            f"the inner end of the slip zone is known to ± {zone.spread:.2g} only, of "
            f"{zone.length:.3g} or {elements:.0f} elements: slip does not fall evenly towards it"
        )
    return f"too few elements over the slip zone: {elements:.1f}, {FEWEST_ELEMENTS} are wanted"


def _excuse(station: Station, zone: SlipZone) -> tuple[str, str]:
    """Word and reason if there is nothing to compare; two empty texts if there is."""
    if station.end:
        return (
            END,
            "within a local length of a free end, where the fields are not those of an edge",
        )
    if zone.across > LARGEST_ACROSS:
        return (
            NO_VERDICT,
            f"{zone.across:.0%} of f p acts across the direction of K_T and K_S before the half "
            "cycle, as after the contact has slid as a whole: the formulas are for shear that is "
            "far below f p there, and slip reaches farther",
        )
    if zone.gross:
        return GROSS, "the contact slips as far as its middle"
    if not zone.resolved or (math.isnan(zone.told_length) and zone.length > 0):
        return NOT_RESOLVED, _unresolved(station, zone)
    if math.isnan(zone.prediction):
        reason = "K_N or the range of K_T and K_S is not known through the half cycle"
        return UNKNOWN, withheld(station) or reason
    k_n, spread = station.last_k_n
    if not (spread <= LARGEST_SPREAD * k_n and station.k_range_spread <= 0.5 * station.k_range):
        large = f"K_N has an error bar of {spread / k_n:.0%}, more than {LARGEST_SPREAD:.0%}"
        return UNKNOWN, withheld(station) or large
    if station.turning > LARGEST_TURNING:
        return NO_VERDICT, "the direction of K_T and K_S turns: there is no formula"
    return "", ""
