# SPDX-License-Identifier: LGPL-3.0-or-later
"""Margins of the edges of contacts by each criterion that the data at hand allow.

A margin is the factor of all stresses up to which the criterion is kept. Each criterion asks
another question: tests of fretting, the arrest of cracks that have started, the endurance of smooth
specimens under the stress at a critical distance. Where one of them cannot be answered, it says
why; nothing is extrapolated.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fretfe.case import Body, isotropic
from fretfe.decision.assessment import (
    Assessment,
    Criterion,
    EdgeAssessment,
    Judgement,
    OtherCriterion,
    Rule,
)
from fretfe.decision.damage import Damage, counted_damage
from fretfe.decision.end_parts import EndPart, end_parts
from fretfe.decision.field import EdgeField, edge_field, edgeless, error_of_tractions
from fretfe.decision.front_stations import along_fronts, worst_of
from fretfe.decision.material import FatigueData, fatigue_data
from fretfe.decision.short_cracks import Arrest, crack_drive, first_length, judge_arrest
from fretfe.decision.thresholds import critical_length, growth_life, short_length
from fretfe.decision.worst_places import Limits, worst_places
from fretfe.errors import CaseError, FretfeError
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.stress import worst_states
from fretfe.plugins import PlugIn, plug_ins, what
from fretfe.results.model import Result
from fretfe.strength.margins import Margin, result_labels, strength_map

# Of tests, by contact, edge or front, and number of the station.
Margins = dict[tuple[str, str, int], Margin]
# Entry points of other criteria: functions of an `EdgeField`, its `Station` and `FatigueData` that
# return the margin.
GROUP = "fretfe.criteria"


@dataclass(frozen=True)
class _Asked:
    """By which margins are asked for.

    Attributes:
        data: of the material.
        margins: of tests.
        others: criteria of other packages.
    """

    data: FatigueData
    margins: Margins
    others: tuple[PlugIn, ...]


def assess(
    result: Result,
    material: Path | str,
    tests: Path | str | None = None,
    life: float | None = None,
    others: Sequence[Result] = (),
) -> Assessment:
    """Judge the edges of contacts, of solids their fronts, by all criteria that the data allow.

    Args:
        result: with the stress of its bodies, if these are meshed.
        material: file with a table `[fatigue]`.
        tests: CSV file of fretting tests.
        life: cycles that the tests are asked for; given with these, and only then.
        others: results of the same contacts with other friction, or with anything else that is
            not known well: what it changes.

    Raises:
        CaseError: if a file is not as expected, other results have no contact of this one or
            are the same ones again, or only one of tests and life is given.
    """
    for number, other in enumerate(others):
        _require_alike(result, other)
        if any(_same_folder(each, other) for each in (result, *others[:number])):
            raise CaseError(f"{other.directory}: expected other results, found this folder twice")
    found = _assess(result, material, tests, life)
    return replace(found, others=tuple(_assess(each, material, tests, life) for each in others))


def _require_alike(result: Result, other: Result) -> None:
    """Refuse another result with which a margin has no range.

    Raises:
        CaseError: if it has no contact of that name, or other units.
    """
    one, two = result_labels([result, other])
    if not {each.name for each in result.contacts} & {each.name for each in other.contacts}:
        raise CaseError(f"{two}: expected contacts of {one}, found none of them")
    if other.solid != result.solid:
        plane, solid = (two, one) if result.solid else (one, two)
        raise CaseError(f"expected plane results or solids, found {plane} plane, {solid} solid")
    if other.case.units != result.case.units:
        raise CaseError(f"{two}: expected the units of {one}, found others")


def _same_folder(one: Result, other: Result) -> bool:
    if one.directory is None or other.directory is None:
        return False
    return one.directory.resolve() == other.directory.resolve()


def _assess(
    result: Result, material: Path | str, tests: Path | str | None, life: float | None
) -> Assessment:
    """Margins of one result."""
    if (tests is None) != (life is None):
        raise CaseError("expected a file of tests together with a life, found only one of them")
    data = fatigue_data(Path(material), result.case.units)
    margins: Margins = {}
    if tests is not None and life is not None:
        found = strength_map(tests, [result], life).margins
        margins = {(each.edge.contact, each.edge.edge, each.edge.station): each for each in found}
    parts = tuple(end_parts(result))
    asked = _Asked(data, margins, tuple(plug_ins(GROUP)))
    edges = tuple(_edges(result, asked, parts))
    return Assessment(
        result=result_labels([result])[0],
        material=data.path,
        source=data.source,
        length=_length(data),
        edges=edges,
        remarks=(*_remarks(result, data, edges), *map(_end_remark, parts)),
        units=result.case.units,
    )


def _length(data: FatigueData) -> float:
    if data.threshold is None or data.limit is None:
        return math.nan
    return critical_length(data.threshold, data.limit)


def _edges(result: Result, asked: _Asked, parts: Sequence[EndPart]) -> Iterator[EdgeAssessment]:
    for contact in result.contacts:
        pair = next(each for each in result.solution.contacts if each.pair == contact.pair)
        bodies = pair.body1, pair.body2
        if result.solid:
            yield from _fronts(result, contact, bodies, asked, parts)
            continue
        for station in contact.edges:
            margin = asked.margins.get(_name(contact, station))
            by_tests = _by_tests(margin, given=bool(asked.margins))
            for number, body in enumerate(bodies):
                reason = asked.data.disagreement(result.case.bodies[body])
                field = reason or edge_field(result, contact, station, number)
                yield replace(
                    _edge(result, (contact, station, body), asked, field, by_tests),
                    survival=None if margin is None else margin.survival,
                    damage=_damage(result, (contact, station, number), asked.data, field),
                )


def _damage(
    result: Result, at: tuple[Contact, Station, int], data: FatigueData, field: EdgeField | str
) -> Damage | None:
    """Of the counted cycles of an edge in one of its bodies, if lives are given."""
    if data.life is None:
        return None
    if isinstance(field, str):
        return Damage(reason=field)
    contact, station, number = at
    counted = station.cycles
    first, last = result.solution.loads.evaluated
    if len(counted.count) and not counted.closed:
        ends = np.append(counted.start, counted.end)
        first, last = int(ends.min()), int(ends.max())
    whole = np.arange(first, last + 1)
    if not np.isin(whole, field.states).all():
        if result.has_stress:
            return Damage(reason="the stress of meshed bodies is that of the worst counted cycle")
        found = edge_field(result, *at, whole)
        if isinstance(found, str):
            return Damage(reason=found)
        field = found
    length = _length(data)
    if not 2 * length <= field.reach(0.0):
        return Damage(reason="the stress at the critical distance is not known")
    pair = next(each for each in result.solution.contacts if each.pair == contact.pair)
    body = isotropic(result.case.bodies[(pair.body1, pair.body2)[number]])
    assert body is not None
    return counted_damage(field, station, data.life, body, length)


def _name(contact: Contact, station: Station) -> tuple[str, str, int]:
    """Key of a station among `Margins`."""
    return contact.name, station.front, station.number


def _fronts(
    result: Result, contact: Contact, bodies: Sequence[str], asked: _Asked, parts: Sequence[EndPart]
) -> Iterator[EdgeAssessment]:
    """Both bodies at each front of solids."""
    own, margins = [each for each in parts if each.end.contact is contact], asked.margins
    for found in along_fronts(result, contact, own):
        body, front = bodies[found.body], found.front
        tests = {
            ("", each.number): _by_tests(margins.get(_name(contact, each)), given=bool(margins))
            for each in front.stations
        }
        reason = asked.data.disagreement(result.case.bodies[body])
        edges = {
            place: _edge(
                result,
                (contact, station, body),
                asked,
                reason or field,
                tests.get(place, tests["", 0]),
            )
            for place, (station, field) in found.judged.items()
        }
        worst = worst_of(edges, tests, own)
        at = margins.get((contact.name, front.name, worst.judgements[0].station))
        yield replace(
            worst,
            lost={} if reason else _by_reason(found.lost),
            survival=None if at is None else at.survival,
            damage=None
            if asked.data.life is None
            else Damage(reason="the stress of solids is that of one cycle"),
        )


def _by_reason(lost: dict[int, str]) -> dict[str, tuple[int, ...]]:
    """Stations that are not judged, those together that share a reason."""
    reasons = dict.fromkeys(lost.values())
    return {text: tuple(key for key, own in lost.items() if own == text) for text in reasons}


def _edge(
    result: Result,
    at: tuple[Contact, Station, str],
    asked: _Asked,
    field: EdgeField | str,
    by_tests: Judgement,
) -> EdgeAssessment:
    (contact, station, name), data = at, asked.data
    if isinstance(field, str):
        others = [Judgement(each, reason=field) for each in [*Criterion][1:]]
        others += [Judgement(OtherCriterion(each.name), reason=field) for each in asked.others]
        return EdgeAssessment(
            contact.name, station.front, name, station.friction, (by_tests, *others), None,
            math.nan, math.nan, math.nan,
        )  # fmt: skip
    bars = _Bars.of(field, station, data)
    body = isotropic(result.case.bodies[name])
    assert body is not None
    arrest, life, place = _worst_arrest(field, data)
    judgements = [by_tests, _by_arrest(arrest, bars, place, _arrest_steps(arrest, field, data))]
    judgements += _by_distances(field, station, data, body, bars)
    judgements += _by_others(field, station, asked, bars)
    known = None if isinstance(arrest, str) else arrest
    return EdgeAssessment(
        contact.name, station.front, name, station.friction, tuple(judgements), known, life,
        bars.relative, field.smooth.spread, depth=field.reach(0.0), element=field.size,
        single_steps=field.other is None,
        straight=_straight(station) if contact.solid else math.inf,
    )  # fmt: skip


def _straight(station: Station) -> float:
    """As of `EdgeAssessment`, of one station."""
    curved = abs(station.curvature)
    # Of fronts that do not end the distance is infinite, or empty after it was stored.
    to_end = math.inf if math.isnan(station.to_end) else station.to_end
    return min(to_end, 1 / curved if curved > 0 else math.inf)


@dataclass(frozen=True)
class _Bars:
    """Errors of all stresses at an edge: in proportion to them, and over the fatigue limit."""

    relative: float
    absolute: float

    @classmethod
    def of(cls, field: EdgeField, station: Station, data: FatigueData) -> _Bars:
        """By the bars of ΔK_T and K_N, and by that of the stress beside the tractions."""
        amplitude = math.nan if data.limit is None else data.limit.stress_range / 2
        return cls(error_of_tractions(station), field.smooth.spread / amplitude)

    def around(
        self,
        criterion: Rule,
        margin: float,
        place: float = math.nan,
        weight: float = 1.0,
        steps: float = 0.0,
    ) -> Judgement:
        """A margin with its interval: of stresses over what is endured, the margin's inverse.

        Of that an absolute error of the stress changes as much times the weight, and extremes
        between states add what steps do.
        """
        used = 1 / margin
        bar = math.hypot(self.relative * used, weight * self.absolute, steps)
        if not math.isfinite(bar):
            return Judgement(criterion, margin, place=place)
        low, high = used + bar, used - bar
        return Judgement(
            criterion,
            margin,
            1 / low if low > 0 else math.inf,
            1 / high if high > 0 else math.inf,
            place,
        )


def _by_tests(margin: Margin | None, *, given: bool) -> Judgement:
    if margin is None:
        reason = "the tests have no margin for it" if given else "no fretting tests are given"
        return Judgement(Criterion.TESTS, reason=reason)
    if margin.reason:
        return Judgement(Criterion.TESTS, reason=margin.reason)
    return Judgement(Criterion.TESTS, margin.margin, margin.low, margin.high)


def _worst_arrest(field: EdgeField, data: FatigueData) -> tuple[Arrest | str, float, float]:
    """As of `_arrest`, of the cracks with the smaller margin, and where they start.

    NaN of those from the outermost place of the edge.
    """
    (arrest, life), *others = (_arrest(each, data) for each in field.starts)
    place = math.nan
    for other, own in others:
        if isinstance(arrest, str):
            break
        if isinstance(other, str) or other.margin < arrest.margin:
            arrest, life, place = other, own, field.pulled
    return arrest, life, place


def _arrest(field: EdgeField, data: FatigueData) -> tuple[Arrest | str, float]:
    """Arrest of cracks, and the life of the deepest one between two lengths."""
    if data.threshold is None or data.limit is None:
        return "fatigue.threshold and fatigue.limit are not both given", math.nan
    if not math.isfinite(_length(data)):
        return f"the threshold is not known at the R of the limit, {data.limit.ratio:g}", math.nan
    shortest = max(first_length(short_length(data.threshold, data.limit)), field.finest)
    if shortest >= field.reach(0.0):
        return (
            f"the stress is known down to {field.reach(0.0):.3g}, less than the shortest cracks of "
            f"interest have: {shortest:.3g}"
        ), math.nan
    drive = crack_drive(field, shortest)
    found = judge_arrest(drive, data.threshold, data.limit)
    if isinstance(found, str) or data.growth is None or data.lengths is None:
        return found, math.nan
    return found, _life(found, data)


def _life(arrest: Arrest, data: FatigueData) -> float:
    """Cycles between the lengths of the material file; infinite if the crack stops before."""
    assert data.growth is not None and data.lengths is not None
    crack = arrest.deepest
    if crack.stop < data.lengths[1]:
        return math.inf
    return growth_life(crack.lengths, crack.ranges, data.growth, *data.lengths)


def _arrest_steps(arrest: Arrest | str, field: EdgeField, data: FatigueData) -> float:
    """Change of the inverse margin by every other state; NaN where these do not tell."""
    if isinstance(arrest, str) or field.coarser is None:
        return math.nan
    coarse, _, _ = _worst_arrest(field.coarser, data)
    return math.nan if isinstance(coarse, str) else abs(1 / arrest.margin - 1 / coarse.margin)


def _by_arrest(arrest: Arrest | str, bars: _Bars, place: float, steps: float) -> Judgement:
    if isinstance(arrest, str):
        return Judgement(Criterion.ARREST, reason=arrest)
    # Cracks that leave what is known before they are nearest to stopping may stop beyond.
    found = bars.around(Criterion.ARREST, arrest.margin, place, steps=steps)
    return replace(found, high=bars.around(Criterion.ARREST, arrest.largest, steps=steps).high)


def _by_distances(
    field: EdgeField, station: Station, data: FatigueData, body: Body, bars: _Bars
) -> Iterator[Judgement]:
    length = _length(data)
    reason = ""
    if not math.isfinite(length) or data.limit is None:
        reason = "the critical distance needs fatigue.threshold and fatigue.limit, at one R"
    elif 2 * length > field.reach(0.0):
        reason = (
            f"the stress is needed down to {2 * length:.3g} and known to {field.reach(0.0):.3g}"
        )
    elif length < field.finest:
        reason = (
            f"L is {length:.3g}, less than an element at the edge, {field.finest:.3g}, and slip "
            "zones have too few elements"
        )
    if reason or data.limit is None:
        yield from (Judgement(each, reason=reason) for each in list(Criterion)[2:])
        return
    found = worst_places(field, station, Limits(data.limit, data.torsion, body, length))
    for criterion in list(Criterion)[2:]:
        if (worst := found.get(criterion)) is None:
            yield Judgement(criterion, reason="fatigue.torsion is not given")
            continue
        margin = 1 / worst.used if worst.used > 0 else math.inf
        judgement = bars.around(criterion, margin, worst.place, worst.weight, worst.steps)
        # Beyond the outermost place it may be worse.
        low = 0.0 if worst.outermost else judgement.low
        yield replace(judgement, low=low, outermost=worst.outermost)


def _by_others(
    field: EdgeField, station: Station, asked: _Asked, bars: _Bars
) -> Iterator[Judgement]:
    """By the criteria of other packages; one that fails has no margin."""
    for each in asked.others:
        criterion = OtherCriterion(each.name)
        try:
            margin = each.call(field, station, asked.data)
        except FretfeError as error:
            yield Judgement(criterion, reason=str(error))
            continue
        wrong = f"{each.title}: expected a positive margin, found {what(margin)}"
        good = isinstance(margin, int | float) and margin > 0
        yield bars.around(criterion, margin) if good else Judgement(criterion, reason=wrong)


def _remarks(result: Result, data: FatigueData, edges: tuple[EdgeAssessment, ...]) -> Iterator[str]:
    """Things that the margins leave out, in words."""
    if sliding := [each.name for each in result.contacts if each.sliding_share > 0]:
        names = ", ".join(sliding)
        yield f"the whole contact slides, and wear is left out: {names}"
    if unsteady := [each.name for each in result.contacts if not each.steady]:
        yield f"the cycle is not steady: {', '.join(unsteady)}"
    for each in result.contacts:
        if reason := edgeless(each):
            yield f"{each.name}: {reason}"
    if len(worst_states(result.solution, result.contacts)):
        yield "the loads are irregular: judged are the states through the worst counted cycle"
    if result.backend == "halfplane":
        yield "the bodies are half-planes: what their shape adds to the stress is left out"
    if data.growth is None and any(each.arrest is not None for each in edges):
        yield "no life of cracks: fatigue.growth is not given"


def _end_remark(part: EndPart) -> str:
    """Of what the sub-model of a free end does not show."""
    if part.reason:
        return f"the sub-model of {part.end.name} is left out: {part.reason}"
    return (
        f"nearer than {min(part.distances.values()):.3g} to the free end {part.end.name} nothing "
        "is judged, and it may be worse"
    )
