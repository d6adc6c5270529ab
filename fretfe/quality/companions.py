# SPDX-License-Identifier: LGPL-3.0-or-later
"""Companions of a case, by another mean, another start, another mesh, and rows against them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, parse_case
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.evaluate.partners import contact_partners, front_partners
from fretfe.evaluate.refinement import at_places, numbers
from fretfe.evaluate.verdicts import BORDER_ELEMENTS, BORDER_FRACTION
from fretfe.loads import History
from fretfe.mesh.templates import find_template
from fretfe.quality.global_run import NEARER, second_cut
from fretfe.quality.rows import CONSTANT_NORMAL, Pairs, Place, Row, subjects
from fretfe.results.model import Result
from fretfe.results.quantities import K_N, K_RANGE, Reported
from fretfe.verdict import Verdict

MEAN = "about another mean"
START = "from another start"
MESH = "on a coarser mesh"
FINE = "on a finer mesh"
CUT = "by a second cut inside"

# The mean moves by this fraction of the range of each load.
MEAN_SHIFT = 0.1
# The other start goes this much beyond the extremes of the cycle.
OVERLOAD = 0.15
# Elements of the other mesh over those of the case: a coarser one costs less than half. Solids with
# fewer elements than this over the half-width get a finer one: a coarser one may show no fronts.
COARSER = 1.5
FINER = 1 / 1.4
FEWEST_ELEMENTS = 12.0
MESHES = {MESH: COARSER, FINE: FINER}
CYCLES = 2
EXCURSION_STEPS = 6
# Why the steady slip zone is the same, and the verdict if it is not.
STEADY: dict[str, tuple[str, Verdict]] = {
    MEAN: ("the mean of K_T does not count in a steady cycle", Verdict.DIFFERS),
    START: (
        "the steady cycle forgets how it was reached, unless the whole contact slid",
        Verdict.DEPENDS,
    ),
}
# Halving the elements would change a first-order quantity by this many times the difference.
EXTRAPOLATION = 1 / (COARSER - 1)
MESH_TOLERANCE = 0.02
SLIP_TOLERANCE = 0.05
# What a cut does to ΔK_T falls with the fourth power of its distance: the case has so much of the
# change to the second cut.
CUT_SHARE = 1 / (NEARER**-4 - 1)
# No more than this part of a number counts of its own error bar: it must not excuse whatever comes.
LARGEST_BAR = 0.1


@dataclass(frozen=True)
class Variant:
    """A companion run.

    Attributes:
        name: what it checks.
        case: to solve.
        history: of its loads, None for that of the case.
    """

    name: str
    case: Case
    history: History | None


def make_variants(case: Case, result: Result) -> tuple[list[Variant], dict[str, str]]:
    """The companions of a case that make sense, and for the others the reason why they do not."""
    variants, reasons = [], {}
    if case.cut_loads:
        reasons[MEAN] = reasons[START] = "the loads are positions in another run"
        inner = second_cut(result)
        if isinstance(inner, str):
            reasons[CUT] = inner
        else:
            variants.append(Variant(CUT, inner, None))
    elif result.loads.cycle is None:
        reasons[MEAN] = reasons[START] = "no cycle to evaluate"
    else:
        if _constant_normal(result):
            variants.append(Variant(MEAN, case, shifted(result.loads)))
        else:
            reasons[MEAN] = "the pressure at the edges varies: another mean is another cycle"
        variants.append(Variant(START, case, overloaded(result.loads)))
    mesh = FINE if _few_elements(result) else MESH
    other = resized(case, MESHES[mesh])
    if case.edges.tolerance is not None:
        reasons[MESH] = "the mesh refined itself: see the changes from mesh to mesh"
    elif other is not None:
        variants.append(Variant(mesh, other, None))
    else:
        reasons[MESH] = "a mesh file: compare with a finer mesh of your own"
    if not result.bodies:
        variants = [variant for variant in variants if variant.name not in MESHES]
        reasons[MESH] = "no mesh"
    return variants, reasons


def _constant_normal(result: Result) -> bool:
    plane = all(
        float(station.k_i_range) <= CONSTANT_NORMAL * float(station.k_range)
        for contact in result.contacts
        if not contact.solid
        for station in contact.stations
    )
    # Factors at single stations of solids scatter by about as much as the limit.
    return plane and all(
        np.median(front.along("k_i_range")) <= CONSTANT_NORMAL * np.median(front.along("k_range"))
        for contact in result.contacts
        if contact.solid
        for front in contact.fronts
    )


def shifted(history: History) -> History:
    """The cycle again about a mean that is nearer to zero, or a little higher if it is zero."""
    first, last = _cycle(history)
    loads = history.values[first : last + 1]
    ranges, means = np.ptp(loads, axis=0), (loads.max(axis=0) + loads.min(axis=0)) / 2
    return _continued(history, loads - np.where(means > 0, 1.0, -1.0) * MEAN_SHIFT * ranges)


def overloaded(history: History) -> History:
    """The cycle again after an excursion beyond both of its extremes."""
    first, last = _cycle(history)
    loads = history.values[first : last + 1]
    mean = (loads.max(axis=0) + loads.min(axis=0)) / 2
    larger = mean + (1 + OVERLOAD) * (loads - mean)
    chosen = np.unique(np.linspace(0, len(loads) - 1, 4 * EXCURSION_STEPS + 1).round().astype(int))
    return _continued(history, loads, larger[chosen])


def _cycle(history: History) -> tuple[int, int]:
    assert history.cycle is not None
    return history.cycle


def _continued(history: History, loads: Array, before: Array | None = None) -> History:
    """The history to the start of its cycle, an excursion (k, C), and cycles of loads (n, C)."""
    first, _ = _cycle(history)
    parts = [history.values[: first + 1]]
    parts += [] if before is None else [before]
    parts += [loads] + [loads[1:]] * (CYCLES - 1)
    values = np.vstack(parts)
    step = history.times[-1] / (len(history.times) - 1)
    added = np.arange(1, len(values) - first) * step
    times = np.concatenate([history.times[: first + 1], history.times[first] + added])
    return History(history.channels, times, values, (len(values) - len(loads), len(values) - 1))


def _few_elements(result: Result) -> bool:
    """True if some front of solids has so few elements that fewer may not show it."""
    counts = [
        np.nanmedian([min(each.depth, each.length) / each.size for each in front.judged])
        for contact in result.contacts
        if contact.solid
        for front in contact.fronts
        if front.judged
    ]
    return min(counts, default=math.inf) < FEWEST_ELEMENTS


def resized(case: Case, factor: float) -> Case | None:
    """The same case with larger elements by a factor; None where it does not give their sizes."""
    data = case.as_tables()
    if case.geometry.solid is not None:
        solid = case.geometry.solid
        layers = max(1, round(solid.layers / factor))
        data["geometry"]["solid"]["layers"] = layers
        if solid.end_size is not None:
            thickest = solid.length / layers
            data["geometry"]["solid"]["end_size"] = min(factor * solid.end_size, thickest)
    if case.geometry.size is not None:
        data["geometry"]["size"] = factor * case.geometry.size
    elif case.geometry.template is not None:
        given = case.geometry.parameters
        sizes = {
            parameter.name: factor * given.get(parameter.name, parameter.default)
            for parameter in find_template(
                case.geometry.template, length=case.units.length
            ).parameters
            if parameter.name.endswith("size")
        }
        data["geometry"]["parameters"] = {**given, **sizes}
    else:
        return None
    return parse_case(data, source=case.source, trust_geo=case.trust_geo)


def companion_rows(name: str, result: Result, other: Result) -> Iterator[Row]:
    """Rows for each front, the numbers of the companion in the same places as references."""
    twins = contact_partners(result.contacts, other.contacts)
    for contact, twin in zip(result.contacts, twins, strict=True):
        if twin is None:
            reason = "the companion has no patch there at its end"
            pressed = contact.normal_force[-1] > 0
            verdict = Verdict.UNKNOWN if pressed else Verdict.NO_VERDICT
            yield Place(contact.name).missing(name, reason, verdict)
        elif contact.solid:
            partners = front_partners(contact.fronts, twin.fronts)
            for front, partner in zip(contact.fronts, partners, strict=True):
                yield from _front_rows(name, contact, front, partner)
        else:
            for station, reference in zip(contact.stations, twin.stations, strict=True):
                yield from _edge_rows(name, contact, station, reference)


def _edge_rows(name: str, contact: Contact, station: Station, other: Station) -> Iterator[Row]:
    """Rows of the only station of a plane front."""
    at, length, reference = Place(contact.name, station.front), _length(station), _length(other)
    if name in STEADY:
        share = BORDER_FRACTION * (length if length > 0 else 0.0)
        tolerance = BORDER_ELEMENTS * station.size + share
        yield at.compared(f"d {name}", length, reference, tolerance, *STEADY[name])
        return
    if name == CUT:
        for each in MESH_QUANTITIES:
            (value, own), (reference, twin) = map(each.read, (station, other))
            allowed, reason = _allowed(name, each.symbol, value, own, twin)
            yield at.compared(f"{each.symbol} {name}", value, reference, float(allowed), reason)
        return
    # Extrapolated error of each number, first order.
    reason = f"elements {COARSER:g} times as large: the error of the case is about twice the change"
    for quantity, value, coarse in (
        ("K_N", station.decisive_k_n[0], other.decisive_k_n[0]),
        ("ΔK_T", station.k_range, other.k_range),
    ):
        label = f"{quantity} {MESH}"
        if math.isnan(value) or math.isnan(coarse):
            yield at.missing(label, "the coarser mesh does not carry this number")
        else:
            tolerance = MESH_TOLERANCE * abs(value) / EXTRAPOLATION
            yield at.compared(label, value, coarse, tolerance, reason)
    if other.slip_zones and not math.isnan(length):
        tolerance = SLIP_TOLERANCE * length / EXTRAPOLATION
        tolerance += BORDER_ELEMENTS * COARSER * station.size
        yield at.compared(f"d {MESH}", length, reference, tolerance, reason)


def _length(station: Station) -> float:
    """Length of the longer slip zone, as the nodes have it."""
    zone = station.longest_zone
    return zone.length if zone else math.nan


def _front_rows(name: str, contact: Contact, front: Front, twin: Front | None) -> Iterator[Row]:
    """Rows of a front of solids, against the nearest one of the companion."""
    at, stations = Place(contact.name, front.name), front.judged
    if twin is None:
        yield at.missing(name, "the companion has no such front at the end of its cycle")
        return
    if not stations:
        return
    places = np.array([station.point for station in stations])
    if name in STEADY:
        values, (references,) = numbers(stations, reported_d), at_places(twin, places, [reported_d])
        sizes = numbers(stations, lambda each: each.size)
        pairs = Pairs(values, references, BORDER_ELEMENTS * sizes + BORDER_FRACTION * values)
        yield at.over_stations(f"d {name}", pairs, *STEADY[name])
        return
    for subject, chosen in subjects(contact, front):
        points = np.array([station.point for station in chosen])
        for each in MESH_QUANTITIES:
            measures = [each.value, each.spread]
            values, bars = (numbers(chosen, measure) for measure in measures)
            references, other = at_places(twin, points, measures)
            allowed, reason = _allowed(name, each.symbol, values, bars, other)
            pairs = Pairs(values, references, allowed)
            yield subject.over_stations(f"{each.symbol} {name}", pairs, reason)


def _allowed(
    name: str, quantity: str, values: Array | float, bars: Array | float, others: Array | float
) -> tuple[Array, str]:
    """Largest differences of a number of stations from a companion with error bars, and why."""
    # Slip zones of a fraction of their front need not be known to a tenth of themselves.
    own = bars if quantity == "d" else np.minimum(bars, LARGEST_BAR * np.abs(values))
    both = np.hypot(own, others)
    if name != CUT:
        reason = f"elements {MESHES[name]:.2g} times as large: the error bars of both meshes, that "
        return both, reason + f"of a factor of the case {LARGEST_BAR:.0%} at most"
    reason = f"cuts at {NEARER:.2g} of the distance, the error bars of both"
    if quantity != "ΔK":
        return both, reason
    reason += (
        f", and {MESH_TOLERANCE:.0%} of ΔK: what the slip of the run does to it at a cut falls "
        f"with the fourth power of the distance, so that the case has {CUT_SHARE:.2g} of the change"
    )
    return both + MESH_TOLERANCE * np.abs(values), reason


def reported_d(station: Station) -> float:
    """Length of the longer slip zone; NaN where it is not resolved or the whole contact slides."""
    zone = station.longest_zone
    return math.nan if zone is None or zone.gross or not zone.resolved else zone.reported_length


def _told_d(station: Station) -> tuple[float, float]:
    """Length of the longer slip zone and its error bar, by the plane problem or by the nodes."""
    zone = station.longest_zone
    return (math.nan, math.nan) if zone is None or zone.gross else zone.told


# Numbers of a station and their error bars.
MESH_QUANTITIES = (K_N, K_RANGE, Reported("d", "length", _told_d))
