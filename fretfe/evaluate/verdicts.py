# SPDX-License-Identifier: LGPL-3.0-or-later
"""Verdicts on slip zones of stations: as found, against what the factors predict."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fretfe.evaluate.contacts import LARGEST_SPREAD, LARGEST_TURNING, SlipZone, Station
from fretfe.evaluate.withheld import with_bar, withheld
from fretfe.faults import guarded
from fretfe.reason import Kind
from fretfe.report.texts import rounded
from fretfe.verdict import Verdict

# The expected error of the formulas is a first-order estimate: trusted within this factor, and not
# at all where it is large.
ESTIMATE_FACTOR = 1.5
LARGEST_ERROR = 0.1
# A slip zone is located to about a tenth of an element, and to this fraction of its length.
BORDER_ELEMENTS = 0.2
BORDER_FRACTION = 0.02
# Predicted lengths from the front behind which the flank begins, and mean shear there over f p from
# which the contact nearly slides.
FLANK = 1.5
NEAR_SLIDING = 0.95
# Error of the formulas between unlike bodies, over f |beta|: measured on half-planes with beta up
# to .2, f = .3 and .8, slip both ways and mean shear up to .6 f P.
COUPLED = 0.7
# Error bars and elements that leave more of the length open than this check nothing.
LOOSE = 0.3
# Part of f p that may act across that line before: more of it leaves an eighth less for the shear
# along it, and slip zones that are longer by as much.
LARGEST_ACROSS = 0.5
# Elements over a slip zone from which they are not too few for its border.
FEWEST_ELEMENTS = 4


@dataclass(frozen=True)
class Judgement:
    """Verdict of a station's slip zone on the formulas, with its reason.

    Attributes:
        verdict: of the comparison.
        reason: in words.
        tolerance: largest difference of the lengths at which they agree; NaN without a comparison.
    """

    verdict: Verdict
    reason: str
    tolerance: float = math.nan


def longest_verdict(station: Station) -> Judgement:
    """The verdict on the longest slip zone of the cycle at a station, or why it has none."""
    if (zone := station.longest_zone) is not None:
        return judge(station, zone)
    if reason := withheld(station):
        return Judgement(Verdict.UNKNOWN, reason.text)
    if station.friction > 0 and not station.undriven:
        return Judgement(Verdict.UNKNOWN, "no zone is told: nothing is known of a half cycle")
    return Judgement(Verdict.NO_ZONE, "there is no friction, or neither K_T nor K_S varies")


def expected_error(station: Station, length: float) -> float:
    """Relative error, without sign, that (9) and (11) are expected to have for a slip zone.

    First order: half the length times the relative growth of dP/da with a, which is d/(2a) for
    Hertz, d/(2(a - b)) or less for a flat with rounded ends, nothing for a wedge, d/a for a circle.
    """
    return 0.5 * length * abs(station.stiffening)


def judge(station: Station, zone: SlipZone) -> Judgement:
    """Compare a slip zone with its prediction by (11) or (8), where both can be trusted.

    The tolerance is the sum of the error that the formula is expected to have, of the error bars of
    K_N, of the range and of the length, as if they were independent, and of what an element hides.

    At a station of solids whose plane problem is solved the length is that of the plane problem;
    the slip of the solids' elements, where they resolve it, must be the same. Where fretfe fails
    in that the verdict is unknown.
    """
    return guarded(
        f"verdict at {station.front}, station {station.number}",
        lambda: _judge(station, zone),
        lambda fault: Judgement(Verdict.UNKNOWN, fault.reason),
    )


def _judge(station: Station, zone: SlipZone) -> Judgement:
    if zone.unknown:
        return Judgement(
            Verdict.UNKNOWN,
            "the coefficient falls in the half cycle: points slip though no load changes, and no "
            "factor shows that",
        )
    if (excuse := _excuse(station, zone)) is not None:
        return excuse
    if _still(zone):
        return _judge_still(station, zone)
    if math.isfinite(zone.reported_local):
        nodes = beside_nodes(station, zone)
        return nodes if nodes.verdict == Verdict.DIFFERS else beside_formula(station, zone)
    # An edge that moves is described over the longer of the two zones, which ends where it was.
    last = station.slip_zones[-2:]
    lengths = [each.length for each in last if not (each.gross or each.unknown)]
    longest = max([*lengths, zone.length])
    error, vague = expected_error(station, longest), 0.5 * longest * station.stiffening_spread
    if math.isnan(error):
        return Judgement(
            Verdict.NO_VERDICT,
            "the expected error of the formula is not known: the edge does not move",
        )
    bars = math.hypot(station.k_n_spread[zone.end] / station.k_n[zone.end], station.range_error)
    of_length = math.hypot(BORDER_FRACTION, vague) * zone.length
    within = math.hypot(bars * zone.prediction, zone.spread, of_length)
    unlike = COUPLED * station.coupling
    within += BORDER_ELEMENTS * station.size + unlike * zone.length
    if not math.isfinite(within):
        return Judgement(Verdict.UNKNOWN, "K_N has no error bar at the end of the half cycle")
    if within > LOOSE * max(zone.length, zone.prediction):
        share = within / max(zone.length, zone.prediction)
        return Judgement(
            Verdict.UNKNOWN,
            f"error bars and elements leave {share:.0%} of the length open, more than {LOOSE:.0%}: "
            "nothing to check",
        )
    reason = (
        f"the asymptote's own error at the longer of the two lengths, about {error:.1%} ± "
        f"{vague:.1%}, error bars of K_N and of the range, {bars:.1%}, and of the length, "
        f"{rounded(zone.spread)}, and {BORDER_ELEMENTS:g} elements"
    )
    if unlike:
        reason += f"; unlike bodies, {unlike:.1%}"
    return _beside_formula(zone.length, zone.prediction, error, within, reason)


def _still(zone: SlipZone) -> bool:
    """True if no slip is found: by the plane problem, or by nodes that would show it."""
    if math.isfinite(zone.reported_local):
        return zone.local == 0
    return zone.resolved and zone.length == 0


def _judge_still(station: Station, zone: SlipZone) -> Judgement:
    """Compare no slip with its prediction: none either, or so little that nobody could tell."""
    local, unseen = math.isfinite(zone.reported_local), zone.told[1]
    if local and (nodes := beside_nodes(station, zone)).verdict == Verdict.DIFFERS:
        return nodes
    of_k_n = float(station.k_n_spread[zone.end] / station.k_n[zone.end])
    most = (zone.prediction + _range_bar(station, zone)) * (1 + of_k_n)
    if not math.isfinite(most):
        return Judgement(
            Verdict.UNKNOWN, f"nothing slips; {withheld(station).text or 'nothing is predicted'}"
        )
    found = f"nothing slips, or over less than {rounded(unseen, 2)}"
    within = math.hypot(unseen, BORDER_ELEMENTS * station.size)
    if not math.isfinite(within):
        return Judgement(Verdict.UNKNOWN, "no node slips, but that has no error bar")
    if zone.prediction > within:
        return Judgement(
            Verdict.DIFFERS, f"{found}, though {rounded(zone.prediction, 2)} is predicted", within
        )
    if most > within or zone.prediction > BORDER_FRACTION * within:
        return Judgement(
            Verdict.UNKNOWN, f"{found}; up to {rounded(most, 2)} may be predicted: nothing to check"
        )
    return Judgement(
        Verdict.AGREES, f"{found}, and at most {rounded(most, 2)} is predicted", within
    )


def _range_bar(station: Station, zone: SlipZone) -> float:
    """Length of a slip zone that the error bar of the range stands for."""
    # Without a cycle there is no range, but a prediction of first loading.
    most = station.told_range[1]
    if math.isnan(station.k_range) or station.k_range_spread == 0:
        return 0.0
    return float(most / (station.friction * station.k_n[zone.end]))


def _beside_formula(
    length: float, prediction: float, error: float, within: float, reason: str
) -> Judgement:
    """Compare a length with a prediction whose formula is expected to have a relative error.

    Args:
        length: found.
        prediction: by the formula.
        error: expected of it.
        within: what both may differ by besides.
        reason: what the verdict rests on.
    """
    # An estimate of a large error is none: it must not excuse whatever comes out.
    tolerance = ESTIMATE_FACTOR * min(error, LARGEST_ERROR) * length + within
    if abs(length - prediction) <= tolerance:
        return Judgement(Verdict.AGREES, reason, tolerance)
    if error > LARGEST_ERROR:
        reason += ". Long against the edge's own length: use the computed length"
        return Judgement(Verdict.OUTSIDE, reason, tolerance)
    return Judgement(Verdict.DIFFERS, reason, tolerance)


def beside_nodes(station: Station, zone: SlipZone) -> Judgement:
    """Compare the length by the plane problem with the slip of the nodes, if that is resolved."""
    if not zone.resolved or zone.gross:
        return Judgement(Verdict.NO_VERDICT, f"nodes tell no length: {_unresolved(station, zone)}")
    open_between = math.hypot(zone.spread, zone.local_spread) + BORDER_ELEMENTS * station.size
    found = f"nodes slip over {with_bar(zone.length, zone.spread)}, but {_by_plane_problem(zone)}"
    if abs(zone.length - zone.local) > open_between:
        reason = f"{found}: K_N, K_T and K_S do not describe what happens there"
        return Judgement(Verdict.DIFFERS, reason, open_between)
    reason = f"both error bars, and {BORDER_ELEMENTS:g} elements"
    return Judgement(Verdict.AGREES, reason, open_between)


def beside_formula(station: Station, zone: SlipZone) -> Judgement:
    """Compare the length by the plane problem with (11) or (8)."""
    found = _by_plane_problem(zone)
    if without := _no_formula(station, zone):
        seen = "which the slip of the nodes confirms" if zone.resolved else "by that alone"
        return Judgement(
            Verdict.AGREES if zone.resolved else Verdict.NO_VERDICT, f"{without}; {found}, {seen}"
        )
    lengths = [each.local for each in station.slip_zones[-2:] if math.isfinite(each.local)]
    error = expected_error(station, max([*lengths, zone.local]))
    unlike = COUPLED * station.coupling
    within = math.hypot(zone.local_spread, BORDER_FRACTION * zone.local) + unlike * zone.local
    reason = f"{found}; the asymptote's own error there is about {error:.1%}"
    if unlike:
        reason += f"; unlike bodies, {unlike:.1%}"
    return _beside_formula(zone.local, zone.prediction, error, within, reason)


def _by_plane_problem(zone: SlipZone) -> str:
    return f"{with_bar(zone.local, zone.local_spread)} by the plane problem next to the front"


def _no_formula(station: Station, zone: SlipZone) -> str:
    """Reason why there is no formula for a slip zone, in words; empty if there is."""
    if station.turning > LARGEST_TURNING:
        return "the direction of K_T and K_S turns: there is no formula"
    if math.isnan(zone.prediction):
        return "there is no prediction outside a closed cycle"
    return ""


def _unresolved(station: Station, zone: SlipZone) -> str:
    """Reason why the mesh or the steps do not resolve a slip zone, in words."""
    size = station.size
    if zone.within_step:
        longer = f"is up to {rounded(zone.missed, 2)} longer within a step: make shorter steps"
        return f"its inner end is known {_known(zone.spread)}, since it {longer}"
    if zone.hides:
        known = math.isfinite(zone.spread)
        longest = f"shorter than {rounded(zone.spread, 2)}" if known else "of any length"
        return f"no node slips, but a zone {longest} may lie between the nodes"
    if station.turning > LARGEST_TURNING and zone.length > 0:
        return (
            "the direction of slip turns, so that its onset is of no known power, and the area "
            f"that slips gives its inner end {_known(zone.spread)}"
        )
    if zone.length > 0 and size > 0 and zone.length >= FEWEST_ELEMENTS * size:
        return (
            f"its inner end is known {_known(zone.spread)}, of {rounded(zone.length)} or "
            f"{zone.length / size:.0f} elements: slip does not fall evenly towards it, or nodes "
            "slip behind it"
        )
    covered = f": {zone.length / size:.1f} of {rounded(size, 2)}" if size > 0 <= zone.length else ""
    return f"too few elements over the slip zone{covered}, {FEWEST_ELEMENTS} are wanted"


def _known(spread: float) -> str:
    """The words for how well a length is known."""
    return f"to ± {rounded(spread, 2)} only" if math.isfinite(spread) else "without an error bar"


def _excuse(station: Station, zone: SlipZone) -> Judgement | None:
    """Judgement where there is nothing to compare; None where there is."""
    if station.end:
        return Judgement(Verdict.END, Kind.NEAR_END.seen)
    if zone.across > LARGEST_ACROSS:
        return Judgement(
            Verdict.NO_VERDICT,
            f"{zone.across:.0%} of f p acts across the direction of K_T and K_S before the half "
            "cycle, as after the contact has slid as a whole: the formulas are for shear that is "
            "far below f p there, and slip reaches farther",
        )
    if zone.gross:
        return Judgement(Verdict.GROSS, "the whole contact slips: there is no slip zone")
    if zone.flank >= NEAR_SLIDING:
        return Judgement(
            Verdict.NO_VERDICT,
            f"the shear is {zone.flank:.0%} of f p all over the flank behind the predicted zone, "
            "as where the contact has slid as a whole: the formulas are for shear that is far "
            "below f p there",
        )
    local = math.isfinite(zone.reported_local)
    if not local and (not zone.resolved or (math.isnan(zone.reported_length) and zone.length > 0)):
        return Judgement(Verdict.NOT_RESOLVED, _unresolved(station, zone))
    if math.isnan(zone.prediction) and not local:
        lost = withheld(station).text
        if not lost and math.isfinite(station.k_n[zone.end]):
            sure = station.coupling > 0 or station.turning > LARGEST_TURNING
            if sure or station.at_rest(zone.start, zone.end):
                return Judgement(Verdict.NO_VERDICT, _no_formula(station, zone))
            lost = "several loads move with P, and nothing tells d but the nodes: it goes by steps"
        return Judgement(Verdict.UNKNOWN, lost or "K_N is not known at the end of the half cycle")
    # The formulas take K_N of the state in which the half cycle ends.
    k_n, spread = float(station.k_n[zone.end]), float(station.k_n_spread[zone.end])
    if spread > LARGEST_SPREAD * k_n and not local and not _still(zone):
        bar = f"{spread / k_n:.0%}, more than {LARGEST_SPREAD:.0%}"
        bar = f"an error bar of {bar}" if math.isfinite(spread) else "no error bar"
        return Judgement(
            Verdict.UNKNOWN, f"K_N at the end of the half cycle, {rounded(k_n)}, has {bar}"
        )
    still = _still(zone)
    # Without a cycle there is no range, but a prediction of first loading.
    if math.isfinite(station.k_range) and not still and math.isnan(station.reported_range):
        return Judgement(Verdict.UNKNOWN, withheld(station).text)
    if local and not still and zone.local_spread > LOOSE * zone.local:
        return Judgement(
            Verdict.UNKNOWN,
            "the plane problem next to the front gives "
            f"{with_bar(zone.local, zone.local_spread)}: its error bar leaves more than "
            f"{LOOSE:.0%} open",
        )
    if station.turning > LARGEST_TURNING and not local:
        return Judgement(Verdict.NO_VERDICT, _no_formula(station, zone))
    return None
