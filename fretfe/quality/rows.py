# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows of a validation: comparisons with verdicts, and those of one run by itself.

A front of a plane contact has one station and a row for each of its numbers. A front of solids has
one row for a number of all of its stations.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.evaluate import analyse_tractions
from fretfe.evaluate.contacts import LARGEST_SPREAD, Contact, Front, SlipZone, Station, worst_of
from fretfe.evaluate.plane.evaluate import NEARLY_ALONG_Z
from fretfe.evaluate.plane.section import plane_front
from fretfe.evaluate.refinement import numbers
from fretfe.evaluate.slip import cycle_states
from fretfe.evaluate.verdicts import (
    BORDER_ELEMENTS,
    BORDER_FRACTION,
    Judgement,
    beside_formula,
    beside_nodes,
    judge,
    longest_verdict,
)
from fretfe.evaluate.withheld import k_n_lack, range_lack
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result
from fretfe.verdict import Verdict

# Of a row, by the verdict on a slip zone; `NO_VERDICT` for all others.
VERDICTS = {
    Verdict.AGREES: Verdict.AGREES,
    Verdict.DIFFERS: Verdict.DIFFERS,
    Verdict.OUTSIDE: Verdict.OUTSIDE,
    Verdict.NOT_RESOLVED: Verdict.UNKNOWN,
}
# Normal increments below this fraction of the tangential ones leave the edges where they are.
CONSTANT_NORMAL = 0.05
K_N_AGREEMENT = 0.02
# A second K_N whose own bar is wider than this checks nothing.
LOOSE = 0.3
K_T_AGREEMENT = 0.01
SHEAR_AGREEMENT = 0.03
# Ranges of K_T and K_S that other reaches of the integrals give, relative to the largest along the
# front.
REACH_AGREEMENT = 0.02
STEADY = 1e-3
CERTIFIED = 1e-6
BALANCED = 1e-8
# Share of the stations that must agree, as error bars hold for 95 %.
WITHIN = 0.9
# Share of the stations that must have a number to compare.
CARRIED = 0.5


@dataclass(frozen=True)
class Row:
    """A number, what it is compared with, and what follows.

    Attributes:
        contact: name of the contact.
        edge: "left", "right", of solids a front; "" for the contact as a whole.
        quantity: what is compared.
        value: the number.
        reference: what it should be.
        tolerance: largest acceptable |value - reference|, in the same unit.
        reason: where the tolerance comes from, or why there is no comparison.
        verdict: of the comparison.
    """

    contact: str
    edge: str
    quantity: str
    value: float
    reference: float
    tolerance: float
    reason: str
    verdict: Verdict

    @property
    def where(self) -> str:
        """Contact and edge or front, for people."""
        edge = f"{self.edge} edge" if self.edge in ("left", "right") else self.edge
        return f"{self.contact}, {edge}" if edge else self.contact

    @property
    def difference(self) -> float:
        """Value less reference."""
        return self.value - self.reference


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


@dataclass(frozen=True)
class Place:
    """Subject of rows: the whole case, a contact, or an edge or front of it."""

    contact: str = "all"
    edge: str = ""

    def compared(
        self,
        quantity: str,
        value: float,
        reference: float,
        tolerance: float,
        reason: str,
        otherwise: Verdict = Verdict.DIFFERS,
    ) -> Row:
        """A row that agrees within the tolerance, and has the verdict `otherwise` outside.

        A value or reference that does not exist gives no verdict, unless the two are both expected:
        then NaN on one side only is no agreement.
        """
        verdict: Verdict = otherwise
        if math.isnan(value) and math.isnan(reference):
            verdict = Verdict.NO_VERDICT
        elif abs(value - reference) <= tolerance:
            verdict = Verdict.AGREES
        return Row(self.contact, self.edge, quantity, value, reference, tolerance, reason, verdict)

    def missing(self, quantity: str, reason: str, verdict: Verdict = Verdict.NO_VERDICT) -> Row:
        """A row without a comparison."""
        none = math.nan
        return Row(self.contact, self.edge, quantity, none, none, none, reason, verdict)

    def over_stations(
        self, quantity: str, pairs: Pairs, reason: str, otherwise: Verdict = Verdict.DIFFERS
    ) -> Row:
        """One row for many stations: that of the worst of the best nine tenths of them."""
        known = np.flatnonzero(pairs.known)
        count = len(pairs.values)
        if len(known) < max(CARRIED * count, 1):
            given = f"there is a number to compare at {len(known)} of {count} stations only"
            return self.missing(quantity, given)
        off = np.abs(pairs.values - pairs.references)[known]
        tolerances = pairs.tolerances[known]
        order = np.argsort(off / np.maximum(tolerances, 1e-300))
        chosen = known[order[math.ceil(WITHIN * len(known)) - 1]]
        inside = np.count_nonzero(off <= tolerances)
        if count > 1:
            reason += (
                f". {inside} of {len(known)} stations agree, {WITHIN:.0%} must; the line is that "
                "of the worst of these"
            )
        return self.compared(
            quantity,
            float(pairs.values[chosen]),
            float(pairs.references[chosen]),
            float(pairs.tolerances[chosen]),
            reason,
            otherwise,
        )


EVERYWHERE = Place()


def own_rows(result: Result) -> Iterator[Row]:
    """Rows for each contact and its fronts, and for the solution."""
    if result.solid:
        yield from _solution_rows(result)
    for contact in result.contacts:
        yield from _contact_rows(result, contact)
        for front in contact.fronts:
            if contact.solid:
                yield from _front_rows(contact, front)
            else:
                yield from _edge_rows(result, contact, front.stations[0])
    if not result.solid:
        yield from _solution_rows(result)


def limit_rows(result: Result) -> Iterator[Row]:
    """Rows for the limits of the model: beyond one of them nothing is known of the bodies."""
    for limit in result.limits:
        at = Place(limit.contact or "all")
        if math.isnan(limit.found):
            cycle = result.loads.cycle is not None
            why = "ΔK_T is unknown, or none" if cycle else "no evaluated cycle"
            yield at.missing(limit.quantity, f"not measured: {why}")
            continue
        reason = f"limit of the model; beyond it {limit.consequence}"
        yield at.compared(limit.quantity, limit.found, 0.0, limit.limit, reason, Verdict.UNKNOWN)


def hertz_rows(result: Result) -> Iterator[Row]:
    """K_N at the station of the largest |ΔK| of each front of solids, whose mesh is there."""
    # Imported where it is needed: a report of plane bodies does without the kernels of surfaces.
    from fretfe.bodies.expected import hertz_contact
    from fretfe.surface.checks import initial_gaps

    if not result.bodies or not result.solid:
        return
    gaps = initial_gaps(Mesh(dict(result.bodies)), result.case)
    for contact in result.contacts:
        worst = [_worst(contact, front) for front in contact.fronts]
        for at, station in filter(None, worst):
            between = result.case.contacts[contact.pair]
            if between.layer is not None or between.gap is not None:
                yield at.missing("K_N, by Hertz", "a layer or a gap lies between the surfaces")
                continue
            force = float(contact.normal_force[station.decisive])
            expected = hertz_contact(result.case, contact.pair, gaps[contact.pair], force)
            if expected is None:
                reason = "the gap is neither that of a paraboloid nor of a cylinder"
                yield at.missing("K_N, by Hertz", reason)
                continue
            k_n, bar = station.decisive_k_n
            known = expected.k_n(station.curvature)
            reason = f"its error bar and {SHEAR_AGREEMENT:.0%}, as the bodies are not half-spaces"
            tolerance = math.hypot(bar, SHEAR_AGREEMENT * known)
            yield at.compared("K_N, by Hertz", k_n, known, tolerance, reason, Verdict.OUTSIDE)


def _solution_rows(result: Result) -> Iterator[Row]:
    certificates = result.solution.certificates
    worst = float(certificates["worst"].max())
    reason = "relative violation of penetration, friction cone, stick, slip direction"
    yield EVERYWHERE.compared("contact conditions", worst, 0.0, CERTIFIED, reason)
    scale = float(certificates["force_scale"].max())
    balance = float(certificates["force_imbalance"].max()) / scale
    yield EVERYWHERE.compared("balance of forces", balance, 0.0, BALANCED, "relative, any body")


def _contact_rows(result: Result, contact: Contact) -> Iterator[Row]:
    at = Place(contact.name)
    if not contact.solid:
        yield _shear_row(at, contact, cyclic=result.loads.cycle is not None)
    quantity, change = "change of q", contact.cycle_change
    if math.isnan(change):
        yield at.missing(quantity, _no_change(result, contact))
    else:
        given = "relative to the friction bound: the cycle is steady"
        yield at.compared(quantity, change, 0.0, STEADY, given)
    if contact.solid and not contact.fronts and contact.normal_force[-1] > 0:
        reason = contact.lack.text or "nobody looked for them"
        yield at.missing("fronts", reason, Verdict.UNKNOWN)
    if contact.name != contact.pair:
        # A patch that comes or goes within the cycle: what it does there is not known.
        cycle = cycle_states(result.loads.cycle)
        existing = np.count_nonzero(contact.normal_force[cycle] > 0)
        unknown = any(math.isnan(each.k_range) for each in contact.stations)
        if 0 < existing < len(cycle) and unknown:
            given = f"it exists in {existing} of the {len(cycle)} states: its ranges are unknown"
            yield at.missing("patch in the cycle", given, Verdict.UNKNOWN)


def _no_change(result: Result, contact: Contact) -> str:
    """The reason why the shear of two cycles is not compared."""
    if result.loads.cycle is None:
        return "no cycle"
    pressed = contact.normal_force[result.loads.cycle[1]] > 0
    return "no friction" if pressed else "no pressure at the end of the cycle"


def _shear_row(at: Place, contact: Contact, *, cyclic: bool) -> Row:
    """Range of Q by the factors of half-planes, over that by the tractions."""
    quantity, mismatch = "Q by ΔK_T / by ∫q", contact.shear_mismatch
    if math.isnan(mismatch):
        return at.missing(quantity, _no_shear(contact) if cyclic else "no cycle")
    reason = "no free parameter, but the bodies are not half-planes: outside, use K_T as computed"
    return at.compared(quantity, 1 + mismatch, 1.0, SHEAR_AGREEMENT, reason, Verdict.OUTSIDE)


def _no_shear(contact: Contact) -> str:
    """The reason why Q of a cycle is not compared with the factors."""
    for station in contact.stations:
        if math.isnan(station.k_range):
            return f"ΔK_T of the {station.front} edge is not known: {range_lack(station).text}"
        if abs(station.k_angle) >= NEARLY_ALONG_Z:
            return "shear acts along z"
    return "no shear force in the cycle"


def _edge_rows(result: Result, contact: Contact, station: Station) -> Iterator[Row]:
    """Rows of the only station of a plane front."""
    at = Place(contact.name, station.front)
    yield from _unknown_rows(at, contact, station)
    if not math.isnan(station.decisive_k_n[0]):
        yield _moving_row(at, station)
        yield _fit_row(at, station)
        yield from _zone_rows(at, station)
    yield from _traction_rows(at, result, contact, station)


def _unknown_rows(at: Place, contact: Contact, station: Station) -> Iterator[Row]:
    """Numbers that this run should carry and does not, and why."""
    carried = contact.normal_force[station.decisive] > 0 and not math.isnan(contact.cycle_change)
    if not carried or station.lack.whole:
        return
    if math.isnan(station.decisive_k_n[0]):
        yield at.missing("K_N", k_n_lack(station).text, Verdict.UNKNOWN)
    if math.isnan(station.k_range):
        yield at.missing("ΔK_T", range_lack(station).text, Verdict.UNKNOWN)


def _moving_row(at: Place, station: Station) -> Row:
    """K_N by the pressure and by the movement of the edge, if that is known well enough."""
    quantity = "K_N, by moving edge"
    k_n, moved, spread = float(station.k_n[-1]), station.k_n_moved, station.k_n_moved_spread
    if math.isnan(moved):
        reason = (
            "there are no two load levels: the edge does not move, or reaches the end of its "
            "surface; or the bodies are dissimilar and there is friction"
        )
        return at.missing(quantity, reason)
    if spread > LOOSE * moved:
        reason = f"the movement of the edge is known to {spread / moved:.0%} only: nothing to check"
        return at.missing(quantity, reason)
    # A large error bar must not excuse whatever comes out.
    own = min(float(station.k_n_spread[-1]), LARGEST_SPREAD * k_n)
    reason = (
        f"{K_N_AGREEMENT:.0%}, the error bar of K_N, {LARGEST_SPREAD:.0%} at most, and that of the "
        "movement"
    )
    return at.compared(quantity, k_n, moved, K_N_AGREEMENT * k_n + own + spread, reason)


def _fit_row(at: Place, station: Station) -> Row:
    """Range of K_T by interaction integrals and by fits to tractions."""
    quantity, value, fitted = "ΔK_T, by fit", station.k_range, station.k_t_range_fitted
    if math.isnan(fitted) or math.isnan(value):
        return at.missing(quantity, "there is no second way here")
    tolerance = K_T_AGREEMENT * value + station.k_range_parts.extraction
    reason = f"{K_T_AGREEMENT:.0%} and the spread over three radii"
    return at.compared(quantity, value, fitted, tolerance, reason)


def _zone_rows(at: Place, station: Station) -> Iterator[Row]:
    """The last two slip zones, found and predicted, and their inner ends."""
    zones = station.slip_zones[-2:]
    if not zones:
        reason = station.cycles.reason or "the factors are not known through the cycle"
        yield at.missing("slip zone", reason)
    for number, zone in enumerate(zones, start=1):
        verdict = judge(station, zone)
        word = VERDICTS.get(verdict.verdict, Verdict.NO_VERDICT)
        label = f"d, by formula, half cycle {number}"
        if math.isnan(verdict.tolerance):
            yield at.missing(label, verdict.reason, word)
        else:
            yield at.compared(
                label, zone.length, zone.prediction, verdict.tolerance, verdict.reason, word
            )
    # Without slip the inner end is the edge, which P moves.
    if len(zones) == 2 and not any(zone.length == 0 for zone in zones):
        # Slip does not repeat itself where both half cycles end.
        tolerance = BORDER_ELEMENTS * station.size + BORDER_FRACTION * max(z.length for z in zones)
        reason = "the same material point in a steady cycle, to the accuracy of the border"
        first, second = (zone.border for zone in zones)
        yield at.compared("inner end, both ways", second, first, tolerance, reason)


def _traction_rows(at: Place, result: Result, contact: Contact, station: Station) -> Iterator[Row]:
    """Slip zones once more, from where the shear leaves the friction bound.

    What slips in one half cycle of a steady cycle slips back in the other: the shear changes from
    one bound to the other there. The shear itself is at the bound farther inward at the reversal
    that the first loading has reached: that keeps its longer zone.
    """
    if not station.slip_zones:
        return
    if station.k_i_range > CONSTANT_NORMAL * station.k_range:
        reason = "the normal load varies: the shear keeps traces of slip with other edges"
        yield at.missing("d, by traction", reason)
        return
    history, front = result.contact_history(contact.name), plane_front(station.front)
    line = front.inward * front.axis(station.direction, history.slip.shape[2])
    for number, zone in enumerate(station.slip_zones[-2:], start=1):
        label = f"d, by traction, half cycle {number}"
        if zone.gross or not zone.length > 0:
            continue
        pressure, shear = history.traction[zone.end][:, 0], history.traction[zone.end][:, 1:]
        if contact.steady:
            shear = (shear - history.traction[zone.start][:, 1:]) / 2
        analysis = analyse_tractions(
            history.surface.arc, pressure, shear @ line, friction=station.friction
        )
        found = analysis.edges[front.number].slip_from_traction
        if not found.known:
            yield at.missing(label, found.remark)
            continue
        tolerance = found.spread + station.size / 2 + BORDER_FRACTION * zone.length
        reason = (
            "by slip, and where the shear, or half its change through a steady half cycle, leaves "
            "the friction bound: error bar, half an element"
        )
        yield at.compared(label, zone.length, found.value, tolerance, reason)


def _front_rows(contact: Contact, front: Front) -> Iterator[Row]:
    """Rows of a front of solids, over those of its stations that are not near its ends."""
    at, stations = Place(contact.name, front.name), front.judged
    if not stations:
        yield at.missing("stations", "all of them are near its ends")
        return
    told = {"K_N": k_n_lack}
    if np.isfinite(contact.cycle_change):
        told["ΔK"] = range_lack
    for quantity, lack in told.items():
        reasons = [each.text for station in stations if (each := lack(station))]
        if len(reasons) > (1 - WITHIN) * len(stations):
            text = (
                f"not known to within half of it at {len(reasons)} of {len(stations)} stations, as "
                f"{reasons[len(reasons) // 2]}"
            )
            yield at.missing(quantity, text, Verdict.UNKNOWN)
    yield from _half_space_rows(at, front)
    ranges = numbers(stations, lambda each: each.k_range)
    spread = numbers(stations, lambda each: each.k_range_parts.extraction)
    largest = np.nanmax(ranges, initial=0.0)
    pairs = Pairs(ranges, ranges + spread, np.full(len(ranges), REACH_AGREEMENT * largest))
    reason = f"half the spread over reaches and lengths, {REACH_AGREEMENT:.0%} of the largest"
    yield at.over_stations("ΔK, other reach", pairs, reason)
    for place, chosen in subjects(contact, front):
        yield from _slip_rows(place, chosen)


def subjects(contact: Contact, front: Front) -> Iterator[tuple[Place, tuple[Station, ...]]]:
    """Subjects of rows about a front of solids: its stations, and that of the largest |ΔK|."""
    if front.judged:
        yield Place(contact.name, front.name), front.judged
    if worst := _worst(contact, front):
        yield worst[0], worst[1:]


def _worst(contact: Contact, front: Front) -> tuple[Place, Station] | None:
    """The station of the largest |ΔK| that slips like an edge, as a subject of rows, if any."""
    station = worst_of(each for each in front.judged if np.isfinite(each.reported_range))
    if station is None:
        return None
    return Place(contact.name, f"{front.name}, station {station.number}"), station


def _half_space_rows(at: Place, front: Front) -> Iterator[Row]:
    """Factors around an elliptical front over those of half-spaces under the same forces."""
    ratios = front.half_space_ratios
    if ratios.reason:
        yield at.missing("K_N and ΔK, by half-spaces", ratios.reason)
        return
    reason = "no free parameter, but the bodies are not half-spaces: outside, use K as computed"
    for quantity, ratio in (("K_N", ratios.pressure), ("K_T, K_S", ratios.shear)):
        label = f"{quantity} / by half-spaces"
        yield at.compared(label, ratio, 1.0, SHEAR_AGREEMENT, reason, Verdict.OUTSIDE)


def _slip_rows(at: Place, stations: Sequence[Station]) -> Iterator[Row]:
    """Slip zones by the plane problems, or by the nodes, with formulas, and with one another."""
    for half in (1, 2):
        zones = [(each, each.slip_zones[half - 3]) for each in stations if len(each.slip_zones) > 1]
        label = f"d, by formula, half cycle {half}"
        if zones:
            yield _zone_row(at, label, zones, _formula_pair)
        else:
            yield at.missing(label, longest_verdict(stations[len(stations) // 2]).reason)
    longer = [(each, zone) for each in stations if (zone := each.longest_zone)]
    solved = [(each, zone) for each, zone in longer if math.isfinite(zone.reported_local)]
    if solved:
        yield _zone_row(at, "d, plane problem, by nodes", solved, _nodes_pair)


# A judgement, and what it compares.
Pair = tuple[Judgement, float, float]


def _formula_pair(station: Station, zone: SlipZone) -> Pair:
    verdict = judge(station, zone)
    if verdict.verdict is Verdict.DIFFERS and math.isfinite(zone.reported_local):
        # It may be the slip of the nodes that differs.
        verdict = beside_formula(station, zone)
    return verdict, zone.told[0], zone.prediction


def _nodes_pair(station: Station, zone: SlipZone) -> Pair:
    return beside_nodes(station, zone), zone.local, zone.length


def _zone_row(
    at: Place,
    label: str,
    zones: Sequence[tuple[Station, SlipZone]],
    compare: Callable[[Station, SlipZone], Pair],
) -> Row:
    """Slip zones and what they are compared with, at the stations where that is possible.

    Where it is not the most frequent word, and a reason for it.
    """
    pairs = [compare(station, zone) for station, zone in zones]
    known = [
        (length, reference, verdict.tolerance)
        for verdict, length, reference in pairs
        if math.isfinite(verdict.tolerance)
    ]
    verdicts = [verdict for verdict, _, _ in pairs]
    if not known:
        ((word, _),) = Counter(each.verdict for each in verdicts).most_common(1)
        reason = next(each.reason for each in verdicts if each.verdict == word)
        return at.missing(label, f"{word}: {reason}", VERDICTS.get(word, Verdict.NO_VERDICT))
    if len(pairs) == 1:
        (verdict,) = verdicts
        return at.compared(
            label, *known[0], verdict.reason, VERDICTS.get(verdict.verdict, Verdict.DIFFERS)
        )
    reason = "the error bars, a fifth of an element of nodes, and the formula's own error"
    return at.over_stations(label, Pairs(*np.transpose(known)), reason)
