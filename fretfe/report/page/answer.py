# SPDX-License-Identifier: LGPL-3.0-or-later
"""The answer of a run: edge factors, slip zones, and whether the edge formulas describe them."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

from fretfe.evaluate.contacts import Contact, SlipZone, Station
from fretfe.evaluate.verdicts import AGREES, judge
from fretfe.report.page.tables import count_verdicts
from fretfe.report.texts import marked, number, with_error
from fretfe.results.model import Result

# Slip zones of an edge that are shown: those of the last loading and unloading.
ZONES = 2


@dataclass(frozen=True)
class ZoneAnswer:
    """A slip zone as text.

    Attributes:
        time: of the half cycle.
        found, predicted, ratio: lengths, and the second over the first.
        verdict: one word, or two.
        reason: what the verdict rests on.
    """

    time: str
    found: str
    predicted: str
    ratio: str
    verdict: str
    reason: str


@dataclass(frozen=True)
class EdgeAnswer:
    """An edge as text, at the end of the cycle; `zones` are the last ones in time order."""

    contact: str
    side: str
    position: str
    k_n: str
    k_t_range: str
    uncertain: bool
    zones: tuple[ZoneAnswer, ...]


def edge_answers(run: Result) -> tuple[EdgeAnswer, ...]:
    """One answer for each edge of plane contacts."""
    return tuple(
        _edge_answer(run, contact, edge)
        for contact in run.contacts
        if not contact.solid
        for edge in contact.stations
    )


def _edge_answer(run: Result, contact: Contact, edge: Station) -> EdgeAnswer:
    return EdgeAnswer(
        contact=contact.name,
        side=edge.front,
        position=number(float(edge.position[edge.last])),
        k_n=with_error(edge.reported_k_n, edge.last_k_n[1]),
        k_t_range=with_error(edge.reported_range, edge.k_range_spread),
        uncertain=edge.uncertain and math.isfinite(edge.reported_k_n),
        zones=tuple(_zone_answer(run, edge, zone) for zone in edge.slip_zones[-ZONES:]),
    )


def _zone_answer(run: Result, edge: Station, zone: SlipZone) -> ZoneAnswer:
    verdict, times = judge(edge, zone), run.loads.times
    length = with_error(zone.reported_length, zone.spread)
    ratio = zone.prediction / zone.length if zone.length > 0 else float("nan")
    return ZoneAnswer(
        time=f"{times[zone.start]:g} … {times[zone.end]:g}",
        found="gross" if zone.gross else marked(length, zone.uncertain),
        predicted=number(zone.prediction, 3),
        ratio=number(ratio, 3),
        verdict=verdict.word,
        reason=verdict.reason,
    )


def summary(run: Result, answers: tuple[EdgeAnswer, ...]) -> tuple[str, ...]:
    """The answer in a few sentences: slip zones, or contacts of solids, solution, cycle."""
    irregular = any(e.cycles.irregular for c in run.contacts for e in c.stations)
    first = _solid_text(run) if run.solid else _zone_text(answers, irregular)
    return tuple(text for text in (first, _step_text(run), _cycle_text(run)) if text)


def _solid_text(run: Result) -> str:
    """Fronts and the verdicts on the last slip zones of their stations."""
    fronts = [front for contact in run.contacts for front in contact.fronts]
    if not fronts:
        return "No boundary of a contact area could be found: there are no edge factors."
    stations = [station for front in fronts for station in front.stations]
    words = count_verdicts(stations)
    text = f"{len(fronts)} contact front{'' if len(fronts) == 1 else 's'} with {len(stations)} "
    if not words:
        return f"{text}stations, no slip zones."
    return (
        f"{text}stations. At {words[AGREES]} of {words.total()} the last slip zone found "
        f"{_agreement(words)}"
    )


def _zone_text(answers: tuple[EdgeAnswer, ...], irregular: bool) -> str:
    words = Counter(zone.verdict for answer in answers for zone in answer.zones)
    if not words:
        return f"{len(answers)} contact edges, no slip zones."
    which = f"last {words.total()} half cycles"
    if irregular:
        which = f"{words.total()} half cycles of the worst counted cycles"
    return (
        f"{len(answers)} contact edges. In {words[AGREES]} of the {which} the slip zone found "
        f"{_agreement(words)}"
    )


def _agreement(words: Counter[str]) -> str:
    """End of a sentence on slip zones, with the numbers of those that do not agree."""
    others = ", ".join(f"{count} {word}" for word, count in words.items() if word != AGREES)
    told = f" ({others})" if others else ""
    return f"agrees with the one predicted by the edge factors{told}."


def _step_text(run: Result) -> str:
    solution = run.solution
    if solution is None or run.failure is not None:
        return ""
    worst = float(solution.certificates["worst"].max())
    return (
        f"All {len(solution.times) - 1} load steps are solved; the largest violation of a contact "
        f"condition is {number(worst, 2)} of its scale."
    )


def _cycle_text(run: Result) -> str:
    if run.loads.cycle is None:
        missing = "" if run.solid else ": ranges over it are missing"
        return f"There is no evaluated cycle{missing}."
    changing = [contact.name for contact in run.contacts if not contact.steady]
    if changing:
        return f"The evaluated cycle is not steady, or not known to be, at {', '.join(changing)}."
    return "The evaluated cycle is steady."
