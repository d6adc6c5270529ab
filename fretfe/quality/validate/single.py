# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows of one run by itself: two extractions of each factor, and the formulas."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fretfe.evaluate import analyse_tractions
from fretfe.evaluate.contacts import LARGEST_SPREAD, Contact, SlipZone, Station
from fretfe.evaluate.plane.section import plane_front
from fretfe.evaluate.slip import cycle_states
from fretfe.evaluate.verdicts import (
    AGREES,
    BORDER_ELEMENTS,
    BORDER_FRACTION,
    DIFFERS,
    NOT_RESOLVED,
    OUTSIDE,
    judge,
)
from fretfe.quality.validate.rows import Row, Verdict, compared, missing
from fretfe.results.model import Result

# Normal increments below this fraction of the tangential ones leave the edges where they are.
CONSTANT_NORMAL = 0.05
K_N_AGREEMENT = 0.02
# A second K_N whose own bar is wider than this checks nothing.
LOOSE = 0.3
K_T_AGREEMENT = 0.01
SHEAR_AGREEMENT = 0.03
CERTIFIED, BALANCED = 1e-6, 1e-8


def own_rows(result: Result) -> Iterator[Row]:
    """Rows for each plane contact and its stations, and for the solution."""
    for contact in result.contacts:
        if contact.solid:
            continue
        yield from _contact_rows(contact)
        yield from _existence_rows(result, contact)
        for station in contact.stations:
            yield from _station_rows(contact, station)
            yield from _traction_rows(result, contact, station)
    yield from _solution_rows(result)


def limit_rows(result: Result) -> Iterator[Row]:
    """Rows for the limits of the model: beyond one of them nothing is known of the bodies."""
    for limit in result.limits:
        name = limit.contact or "all"
        if math.isnan(limit.found):
            yield missing(name, "", limit.quantity, "not measured: no evaluated cycle or no ΔK_T")
            continue
        reason = f"limit of the model; beyond it {limit.consequence}"
        yield compared(name, "", limit.quantity, limit.found, 0.0, limit.limit, reason, "unknown")


def _contact_rows(contact: Contact) -> Iterator[Row]:
    quantity = "Q by ΔK_T / by ∫q"
    if math.isnan(contact.shear_mismatch):
        yield missing(contact.name, "", quantity, "no cycle, or no shear force in it")
    else:
        yield compared(
            contact.name,
            "",
            quantity,
            1 + contact.shear_mismatch,
            1.0,
            SHEAR_AGREEMENT,
            "no free parameter, but the bodies are not half-planes: outside, use K_T as computed",
            "outside",
        )
    yield steady_row(contact.name, contact.cycle_change)


def steady_row(name: str, change: float) -> Row:
    """Change of the shear of a contact over the evaluated cycle."""
    quantity = "change of q"
    if math.isnan(change):
        reason = "no cycle, no friction, or a backend that gives the steady cycle itself"
        return missing(name, "", quantity, reason)
    reason = "relative to f p_max: the cycle is steady"
    return compared(name, "", quantity, change, 0.0, 1e-3, reason)


def _existence_rows(result: Result, contact: Contact) -> Iterator[Row]:
    """A patch that comes or goes within the cycle: what it does there is not known."""
    cycle = cycle_states(result.loads.cycle)
    existing = np.count_nonzero(contact.normal_force[cycle] > 0)
    if contact.name != contact.pair and 0 < existing < len(cycle):
        reason = f"it exists in {existing} of the {len(cycle)} states: its ranges are unknown"
        yield missing(contact.name, "", "patch in the cycle", reason, "unknown")


def _station_rows(contact: Contact, station: Station) -> Iterator[Row]:
    name, side = contact.name, station.front
    yield from _unknown_rows(contact, station)
    if math.isnan(station.last_k_n[0]):
        return
    yield _moving_row(name, station)
    if math.isnan(station.k_t_range_fitted) or math.isnan(station.k_t_range):
        yield missing(name, side, "ΔK_T, by fit", "there is no second way here")
    else:
        tolerance = K_T_AGREEMENT * station.k_t_range + station.k_range_parts.extraction
        reason = f"{K_T_AGREEMENT:.0%} and the spread over three radii"
        yield compared(
            name,
            side,
            "ΔK_T, by fit",
            station.k_t_range,
            station.k_t_range_fitted,
            tolerance,
            reason,
        )
    yield from _slip_rows(contact, station)


def _moving_row(name: str, station: Station) -> Row:
    """K_N by the pressure and by the movement of the edge, if that is known well enough."""
    quantity, side = "K_N, by moving edge", station.front
    k_n, moved, spread = float(station.k_n[-1]), station.k_n_moved, station.k_n_moved_spread
    if math.isnan(moved):
        reason = (
            "there are no two load levels: the edge does not move, or reaches the end of its "
            "surface; or the bodies are dissimilar and there is friction"
        )
        return missing(name, side, quantity, reason)
    if spread > LOOSE * moved:
        reason = f"the movement of the edge is known to {spread / moved:.0%} only: nothing to check"
        return missing(name, side, quantity, reason)
    # A large error bar must not excuse whatever comes out.
    own = min(float(station.k_n_spread[-1]), LARGEST_SPREAD * k_n)
    tolerance = K_N_AGREEMENT * k_n + own + spread
    reason = (
        f"{K_N_AGREEMENT:.0%}, the error bar of K_N, {LARGEST_SPREAD:.0%} at most, and that of the "
        "movement"
    )
    return compared(name, side, quantity, k_n, moved, tolerance, reason)


def _unknown_rows(contact: Contact, station: Station) -> Iterator[Row]:
    """Numbers that this run should carry and does not; warnings of the contact say why."""
    for quantity, value in (("K_N", station.last_k_n[0]), ("ΔK_T", station.k_t_range)):
        if (
            math.isnan(value)
            and contact.normal_force[station.last] > 0
            and not math.isnan(contact.cycle_change)
        ):
            reason = next(
                (each for each in contact.warnings if quantity in each and "unknown" in each),
                "it is not known in every state of the cycle",
            )
            yield missing(contact.name, station.front, quantity, reason, "unknown")


def _slip_rows(contact: Contact, station: Station) -> Iterator[Row]:
    zones = station.slip_zones[-2:]
    if not zones:
        reason = station.cycles.reason or "the factors are not known through the cycle"
        yield missing(contact.name, station.front, "slip zone", reason)
        return
    for number, zone in enumerate(zones, start=1):
        label = f"d, by formula, half cycle {number}"
        yield asymptote_row(contact.name, station, zone, label)
    if len(zones) == 2:
        # Slip does not repeat itself where both half cycles end.
        tolerance = BORDER_ELEMENTS * station.size + BORDER_FRACTION * max(z.length for z in zones)
        yield compared(
            contact.name,
            station.front,
            "inner end, both ways",
            zones[1].border,
            zones[0].border,
            tolerance,
            "the same material point in a steady cycle, to the accuracy of the border",
        )


def _traction_rows(result: Result, contact: Contact, station: Station) -> Iterator[Row]:
    """Slip zones once more, from where the shear leaves the friction bound.

    What slips in one half cycle of a steady cycle slips back in the other: the shear changes from
    one bound to the other there. The shear itself is at the bound farther inward at the reversal
    that the first loading has reached: that keeps its longer zone.
    """
    if result.solution is None or not station.slip_zones:
        return
    if station.k_i_range > CONSTANT_NORMAL * station.k_t_range:
        reason = "the normal load varies: the shear keeps traces of slip with other edges"
        yield missing(contact.name, station.front, "d, by traction", reason)
        return
    history = result.contact_history(contact.name)
    for number, zone in enumerate(station.slip_zones[-2:], start=1):
        label = f"d, by traction, half cycle {number}"
        if zone.gross or not zone.length > 0:
            continue
        pressure, shear = history.traction[zone.end].T
        if contact.steady:
            shear = (shear - history.traction[zone.start, :, 1]) / 2
        friction = float(history.friction[zone.end])
        analysis = analyse_tractions(history.arc, pressure, shear, friction=friction)
        found = analysis.edges[plane_front(station.front).number].slip_from_traction
        if not found.known:
            yield missing(contact.name, station.front, label, found.remark)
            continue
        tolerance = found.spread + station.size / 2 + BORDER_FRACTION * zone.length
        reason = (
            "by slip, and where the shear, or half its change through a steady half cycle, leaves "
            "the friction bound: error bar, half an element"
        )
        yield compared(
            contact.name, station.front, label, zone.length, found.value, tolerance, reason
        )


def asymptote_row(contact: str, station: Station, zone: SlipZone, label: str) -> Row:
    """The verdict on a slip zone, found and predicted by (11) or (8), as a row called `label`."""
    verdict = judge(station, zone)
    if math.isnan(verdict.tolerance):
        return missing(contact, station.front, label, verdict.reason, row_verdict(verdict.word))
    return Row(
        contact,
        station.front,
        label,
        zone.length,
        zone.prediction,
        verdict.tolerance,
        verdict.reason,
        row_verdict(verdict.word),
    )


def row_verdict(word: str) -> Verdict:
    """The verdict of a row, by the word of a verdict on a slip zone."""
    words: dict[str, Verdict] = {
        AGREES: "pass",
        DIFFERS: "FAIL",
        OUTSIDE: "outside",
        NOT_RESOLVED: "unknown",
    }
    return words.get(word, "-")


def _solution_rows(result: Result) -> Iterator[Row]:
    if result.solution is None:
        return
    certificates = result.solution.certificates
    worst = float(certificates["worst"].max())
    reason = "relative violation of penetration, friction cone, stick, slip direction"
    yield compared("all", "", "contact conditions", worst, 0.0, CERTIFIED, reason)
    scale = float(certificates["force_scale"].max())
    balance = float(certificates["force_imbalance"].max()) / scale
    yield compared("all", "", "balance of forces", balance, 0.0, BALANCED, "relative, any body")
