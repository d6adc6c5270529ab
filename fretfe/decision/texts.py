# SPDX-License-Identifier: LGPL-3.0-or-later
"""An assessment in words: the same sentences and table for the terminal and for the page."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from fretfe.decision.assessment import Assessment, Criterion, EdgeAssessment, Judgement, Rule
from fretfe.decision.short_cracks import first_length
from fretfe.report.texts import MISSING, number, percent, plain_table, rounded
from fretfe.strength.margins import survival_text

if TYPE_CHECKING:
    from rich.table import Table


def known_criteria(found: Assessment) -> list[Rule]:
    """Those that are known of some edge."""
    every = [each.criterion for each in found.edges[0].judgements] if found.edges else []
    return [each for each in every if any(not edge.of(each).reason for edge in found.edges)]


def margin_tables(found: Assessment) -> tuple[Table, ...]:
    """Smallest margins, then all of them; none if no margin is known."""
    return () if found.worst is None else (_governing_table(found), _margin_table(found))


def _margin_table(found: Assessment) -> Table:
    """Margins of all edges, those side by side that are known somewhere."""
    from rich.markup import escape

    shown = known_criteria(found)
    headers = ("edge", "body", *(escape(each.value.replace(" ", "\n")) for each in shown))
    table = plain_table(
        "All margins (>: infinite, but for error bars; ≤: at most)", headers, text=2
    )
    table.padding = 0  # All criteria in 80 characters.
    for edge in found.edges:
        table.add_row(
            escape(f"{edge.contact} {edge.edge}"),
            escape(edge.body),
            *(_least(edge.of(each)) for each in shown),
        )
    return table


def _governing_table(found: Assessment) -> Table:
    """The smallest margin of each edge that has one, with its interval."""
    from rich.markup import escape

    table = plain_table("Smallest margins", ("edge", "body", "governs", "margin", "interval"), 3)
    for edge in found.edges:
        if (least := edge.governing) is None:
            continue
        table.add_row(
            escape(f"{edge.contact} {edge.edge}{_station(least)}"),
            escape(edge.body),
            escape(least.criterion.value),
            _margin(least),
            _interval(least) or MISSING,
        )
    return table


def _station(judgement: Judgement) -> str:
    """Its number, of a sub-model the free end; empty in the plane."""
    if judgement.end:
        return f".{judgement.end.rpartition('.')[2]}"
    return f".{judgement.station}" if judgement.station >= 0 else ""


def _margin(judgement: Judgement) -> str:
    """With a mark where it may be less beyond the places that are judged."""
    if judgement.reason:
        return MISSING
    return f"{'≤ ' * judgement.outermost}{_factor(judgement.margin)}"


def _least(judgement: Judgement) -> str:
    """The margin; of an infinite one the low end of its interval, if that is finite."""
    if math.isinf(judgement.margin) and math.isfinite(judgement.low):
        return f"> {rounded(judgement.low)}"
    return _margin(judgement)


def _interval(judgement: Judgement) -> str:
    """Its two ends; empty where they are unknown."""
    if math.isnan(judgement.low):
        return ""
    if judgement.outermost:
        return f"up to {_factor(judgement.high)}"
    return f"{_factor(judgement.low)} to {_factor(judgement.high)}"


def _factor(value: float) -> str:
    return "∞" if math.isinf(value) else rounded(value)


def answer(found: Assessment) -> Iterator[str]:
    """The worst edge and its criterion, how sure that is, and what would make it surer."""
    if found.worst is None:
        yield "No margin of any edge is known; the reasons stand below"
        return
    edge, judgement = found.worst
    interval = _interval(judgement)
    sure = f" ({interval})" if interval else ""
    yield (
        f"Worst is body {edge.body} at {_at(edge, judgement, found.units.length)} of {edge.contact}"
        f"{_place(judgement.place, found.units.length)}: "
        f"margin {_margin(judgement)}{sure} by {judgement.criterion.value}, so it "
        f"{_verdict(judgement)}"
    )
    lost = sum(each.governing is None for each in found.edges)
    if lost:
        yield f"{lost} of {len(found.edges)} bodies at edges are not judged and may be worse"
    if stations := sum(map(_count, found.edges)):
        yield (
            f"{stations} stations of both bodies are not judged, such as those at ends, and may be "
            "worse"
        )
    yield f"How sure: {'; '.join(_sureness(found, edge, judgement))}"
    yield f"To be surer: {'; '.join(_wanted(found, edge))}"


def _at(edge: EdgeAssessment, judgement: Judgement, unit: str) -> str:
    if judgement.end:
        return f"{edge.edge}, {rounded(judgement.to_end)} {unit} from the free end {judgement.end},"
    if judgement.station < 0:
        return f"the {edge.edge} edge"
    return f"station {judgement.station} of {edge.edge}"


def _count(edge: EdgeAssessment) -> int:
    """Number of stations that are not judged, of a front of which others are."""
    return sum(map(len, edge.lost.values())) if edge.governing is not None else 0


def _verdict(judgement: Judgement) -> str:
    """A margin against 1, as far as its interval allows."""
    words: dict[Rule, str] = {
        Criterion.TESTS: "survive the life asked for",
        Criterion.ARREST: "stop its cracks",
    }
    kept = words.get(judgement.criterion, "endure")
    if judgement.high < 1:
        return f"is not expected to {kept}"
    return f"is expected to {kept}" if judgement.low > 1 else f"may or may not {kept}"


def _place(place: float, unit: str) -> str:
    if math.isnan(place):
        return ""
    if place == 0:
        return ", at the edge itself"
    return f", {rounded(abs(place))} {unit} {'inside' if place > 0 else 'outside'} of it"


def _sureness(found: Assessment, edge: EdgeAssessment, judgement: Judgement) -> Iterator[str]:
    if math.isnan(judgement.low):
        lack = "extremes within steps" if edge.single_steps else "error bars of the edge"
        yield f"{lack} are not known"
    elif judgement.criterion is Criterion.TESTS:
        yield "95 % of single parts are in this interval"
        if edge.survival is not None:
            yield survival_text(edge.survival)
    else:
        yield (
            "the interval is that of the computed stress, "
            f"{percent(edge.bar, int(edge.bar < 0.01))} by K_N and ΔK_T and "
            f"{rounded(edge.spread, 2)} {found.units.stress} by what the body adds; "
            "scatter of the material is not in it"
        )
    low, high = found.range_of(edge, judgement.criterion)
    if math.isfinite(low):
        yield (
            f"over {len(found.others) + 1} results, friction {_span(found.frictions)}, the margin "
            f"is {_span((low, high))}"
        )
    elif found.others:
        yield "it is not known of all results"
    worse = [(other, other.worst) for other in found.others]
    known = [(other, worst) for other, worst in worse if worst is not None]
    if known:
        other, (at, least) = min(known, key=lambda each: each[1][1].margin)
        if least.margin < (low if math.isfinite(low) else judgement.margin):
            yield (
                f"the smallest margin of all results is {_factor(least.margin)}, at {at.contact} "
                f"{at.edge} {at.body} of {other.result} by {least.criterion.value}"
            )


def _span(ends: tuple[float, float]) -> str:
    low, high = map(_factor, ends)
    return low if low == high else f"{low} to {high}"


def _wanted(found: Assessment, edge: EdgeAssessment) -> Iterator[str]:
    """Steps that would make the margin of an edge surer, the nearest at hand first."""
    if not found.others:
        yield (
            f"run the smallest and largest likely friction (here {_span(found.frictions)} at edges;"
            " --set contacts.*.friction=..., a table scaled as a whole) and add their folders"
        )
    coarse = [f"stress is known to {percent(edge.bar, 0)} there"] if _uncertain(edge) else []
    if any(_short_elements(found, edge)):
        coarse.append("cracks shorter than an element are left out")
    if coarse:
        yield f"refine at this edge: {', and '.join(coarse)}"
    if edge.arrest is not None and math.isinf(edge.arrest.deepest.stop) and not edge.solid:
        yield "stress at larger depths: cracks may stop there"
    if edge.of(Criterion.TESTS).reason:
        yield "fretting tests at such K_N and ΔK_T"
    lost = [each.criterion.value for each in edge.judgements[1:] if each.reason]
    if lost:
        yield f"what these need: {', '.join(lost)}"


def details(found: Assessment) -> Iterator[str]:
    """Cracks, what is unknown and why, remarks; what several edges share once."""
    said: dict[str, list[EdgeAssessment]] = {}
    for edge in found.edges:
        survival = edge.survival
        for texts in (
            [] if survival is None else [survival_text(survival)],
            _cracks(edge, found.units.length),
            _short_elements(found, edge),
            _within_element(found, edge),
            _damage(edge, found.units.length),
            _outermost(edge, found.units.length),
            _single_steps(edge),
            _plane(edge, found.units.length),
            _unknown(edge),
        ):
            for text in texts:
                said.setdefault(text, []).append(edge)
    for text, own in said.items():
        yield f"{'All edges' if len(own) == len(found.edges) else _names(own)}: {text}"
    if math.isfinite(found.length):
        length = f"{rounded(found.length)} {found.units.length}"
        yield f"Critical distance L = {length}; source of the data: {found.source}"
    yield from (f"Note: {text}" for text in found.remarks)


def _names(own: list[EdgeAssessment]) -> str:
    """Edges, with the body where it is one of both."""
    bodies: dict[str, list[str]] = {}
    for edge in own:
        bodies.setdefault(f"{edge.contact} {edge.edge}", []).append(edge.body)
    return ", ".join(f"{at} {each[0]}" if len(each) == 1 else at for at, each in bodies.items())


def _cracks(edge: EdgeAssessment, unit: str) -> Iterator[str]:
    """Start, arrest and life of cracks, in words."""
    arrest = edge.arrest
    if arrest is None:
        return
    crack = arrest.deepest
    at, shortest = f"{crack.angle:g}°", f"{rounded(crack.lengths[0])} {unit}"
    if math.isinf(crack.stop):
        yield (
            f"a crack at {at} grows through {rounded(crack.lengths[-1])} {unit}, as far as the "
            "stress is known"
        )
    elif crack.stop > 0:
        yield f"cracks start and stop, the last one at {at} after {rounded(crack.stop)} {unit}"
    elif math.isnan(arrest.start):
        yield f"cracks stop before {shortest}, if they start"
    elif math.isinf(arrest.start):
        yield f"no crack of {shortest} grows: its faces stay closed"
    else:
        yield f"no crack of {shortest} grows, up to {_factor(arrest.start)} times the stress"
    if arrest.largest > arrest.margin:
        crack = arrest.critical
        end, more = ("the contact surface ends", "extend the surface") if crack.cut else (
            "the known stress ends", "none is known deeper" if edge.solid else
            "stress at larger depths",
        )  # fmt: skip
        yield (
            f"the margin is that of a crack at {crack.angle:g}°, followed over "
            f"{rounded(crack.lengths[-1])} {unit}, where {end}; it is up to "
            f"{_factor(arrest.largest)} if that stops beyond: {more}"
        )
    if math.isfinite(edge.life):
        yield f"{number(edge.life, 2)} cycles between the lengths of fatigue.growth"


def _damage(edge: EdgeAssessment, unit: str) -> Iterator[str]:
    """The damage of counted cycles, and how often it makes one."""
    found = edge.damage
    if found is None:
        return
    if found.reason:
        yield f"damage by Miner is unknown: {found.reason}"
        return
    ends = list(dict.fromkeys(number(each, 3) for each in (found.low, found.high)))
    yield (
        f"damage by Miner {' to '.join(ends)} a repetition{_place(found.place, unit)}, over "
        f"{found.cycles:g} counted cycles, each with the SWT life of smooth specimens at L/2: 1 "
        f"after {number(1 / found.high, 2)} repetitions{' or more' * (len(ends) > 1)}"
    )


def _outermost(edge: EdgeAssessment, unit: str) -> Iterator[str]:
    """Criteria that do not fall away from the edge."""
    places: dict[str, list[str]] = {}
    for each in edge.judgements:
        if each.outermost:
            places.setdefault(_place(each.place, unit), []).append(each.criterion.value)
    for place, names in places.items():
        yield (
            f"{', '.join(names)}: worst at the outermost place judged{place}, so the margin is at "
            "most this one, and may be less beyond"
        )


def _single_steps(edge: EdgeAssessment) -> Iterator[str]:
    """That nothing tells what stress does within steps."""
    if edge.single_steps:
        yield (
            "P changes in single steps between turns of the loads, and stress may be worse within "
            "them: no interval is known; 2 steps or more each are needed, 8 are better"
        )


def _plane(edge: EdgeAssessment, unit: str) -> Iterator[str]:
    """The limit of plane fields across fronts of solids."""
    if edge.straight < math.inf and math.isfinite(edge.depth):
        yield (
            f"fields are taken as plane down to {rounded(edge.depth)} {unit}, "
            f"{percent(edge.depth / edge.straight, 0)} of the radius of the front or of the "
            "distance from its end: that holds where this is small"
        )


def _uncertain(edge: EdgeAssessment) -> bool:
    """True if smaller elements are worth it: all margins are in doubt by as much."""
    return edge.bar > 0.1


def _short_elements(found: Assessment, edge: EdgeAssessment) -> Iterator[str]:
    """Lengths of cracks that are left out because elements are larger."""
    arrest = edge.arrest
    if arrest is not None and math.isnan(arrest.start):
        unit, shortest = found.units.length, arrest.deepest.lengths[0]
        yield (
            f"cracks are judged from the length of an element on, {rounded(shortest)} {unit}; it "
            f"is unknown whether those of a0/10 = {rounded(first_length(arrest.a0))} {unit} grow: "
            "slip zones have too few elements"
        )


def _within_element(found: Assessment, edge: EdgeAssessment) -> Iterator[str]:
    """That criteria look at stress within an element, where that is of tractions alone."""
    if found.length / 2 < edge.element:
        unit = found.units.length
        yield (
            f"the stress at L/2 = {rounded(found.length / 2, 2)} {unit} is looked at within an "
            f"element, {rounded(edge.element, 2)} {unit}: by tractions between nodes"
        )


def _unknown(edge: EdgeAssessment) -> Iterator[str]:
    """Reasons for what is unknown, each with its criteria, or with the stations of a front."""
    for reason, stations in edge.lost.items():
        yield f"stations {', '.join(map(str, stations))} unknown: {reason}"
    reasons: dict[str, list[str]] = {}
    for each in edge.judgements:
        if each.reason and each.reason not in edge.lost:
            reasons.setdefault(each.reason, []).append(each.criterion.value)
    yield from (f"unknown ({'; '.join(names)}): {text}" for text, names in reasons.items())
    if _uncertain(edge):
        yield f"the stress is known to {percent(edge.bar, 0)} only: refine at the edge"
