# SPDX-License-Identifier: LGPL-3.0-or-later
"""The first lines of a run, in the terminal, in the report and in notebooks: `Result.headline`."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from fretfe.caution import Subject, places
from fretfe.evaluate.contacts import LARGEST_SPREAD, Contact, SlipZone, Station
from fretfe.evaluate.headline import (
    SAME,
    Headline,
    Sentences,
    ToldZone,
    Trust,
    WorstPlace,
    larger_half_cycle,
    longest_zone,
    worst_station,
)
from fretfe.evaluate.stress import worst_counted
from fretfe.evaluate.verdicts import longest_verdict
from fretfe.evaluate.withheld import withheld
from fretfe.loads import cycle_words
from fretfe.reason import Kind
from fretfe.report.texts import number, percent, with_error
from fretfe.results.end_answers import Meeting, both_ways, meeting_at, nearest_range
from fretfe.results.front_ends import end_beside
from fretfe.results.model import Result
from fretfe.results.quantities import K_N, K_RANGE, Reported
from fretfe.verdict import Verdict

# Largest P over that in the state of K_N from which on both are told.
FAR_LARGER = 1.5


def headline_of(run: Result) -> Headline:
    """The answer of a run, with its first lines."""
    edges = [each for contact in run.contacts for each in contact.edges]
    verdicts = Counter(longest_verdict(each).verdict for each in edges)
    worst, longest = worst_station(run.contacts), longest_zone(run.contacts)
    larger = larger_half_cycle(run.contacts)
    doubts = () if worst is None else tuple(_doubts(run, *worst))
    return Headline(
        worst=None if worst is None else _worst(run, *worst),
        longest=None if longest is None else ToldZone.of(*longest),
        larger="" if larger is None else larger[0].name_of(larger[1]),
        trust=Trust.UNKNOWN if worst is None else Trust.DOUBTED if doubts else Trust.TRUSTED,
        doubts=doubts,
        verdicts=dict(verdicts),
        sentences=Sentences(
            larger="" if larger is None else _larger(run, *larger),
            worst=_nothing(run) if worst is None else _numbers(run, *worst),
            longer=_longer(run, longest, worst),
            trust="" if worst is None else _trust(*worst, doubts),
            sliding=_sliding(run),
            agreement=_agreement(run),
            cycle=cycle_sentences(run),
            half=_half_model(run),
        ),
    )


def _worst(run: Result, contact: Contact, station: Station) -> WorstPlace:
    zone, state = station.longest_zone, station.decisive % len(run.loads.times)
    place = station.arc if contact.solid else float(station.position[state])
    told = None if zone is None else ToldZone.of(contact, station, zone)
    at = contact.name_of(station), place, state, float(run.loads.times[state])
    return WorstPlace(*at, *K_N.read(station), *K_RANGE.read(station), told)


def _longer(
    run: Result,
    longest: tuple[Contact, Station, SlipZone] | None,
    worst: tuple[Contact, Station] | None,
) -> str:
    """The longest slip zone in words, if it is longer than that of the worst place."""
    own = None if worst is None else worst[1].longest_zone
    if longest is None or worst is None or own is None or longest[2] is own:
        return ""
    if own.gross or math.isnan(own.told[0]):
        return ""
    ranges = worst[1].reported_range, worst[1].largest_range
    criterion = _range_symbol(*worst) if np.isfinite(ranges).any() else "K_N"
    return (
        f"Worst is the largest {criterion}; the longest known slip zone is at "
        f"{_place(run, *longest[:2])}: {_zone_words(run, *longest[1:])}."
    )


def _zone_words(run: Result, station: Station, zone: SlipZone) -> str:
    """The longest slip zone of a station beside its prediction, in words."""
    found = _known(or_bound(zone, with_error(*zone.told)), run.unit("length"))
    verdict = longest_verdict(station).verdict
    return f"d {found}{counted_from(station, [zone], ' ')} ({_compared(run, station, verdict)})"


def _larger(run: Result, contact: Contact, station: Station) -> str:
    """The largest half cycle of all, in words."""
    start, end = (run.loads.times[each] for each in (station.largest_start, station.largest_end))
    beyond = run.loads.cycle is not None and not station.first < station.largest_end <= station.last
    return (
        f"Largest half cycle{' without sliding' if station.slides else ' of the history'}"
        f"{', outside of the evaluated cycle' if beyond else ''}: {contact.name_of(station)}, "
        f"t = {start:.6g} to {end:.6g} {run.case.units.time}: "
        f"equivalent {_shear_symbol(contact, station)} {number(station.largest_range)} "
        f"{run.unit('k_t')} by the memory of the edge{_largest_slip(run, station)}."
    )


def _largest_slip(run: Result, station: Station) -> str:
    """Slip zone of the largest half cycle in words, as found if it is; empty if it is not known."""
    zones = [each for each in station.slip_zones if each.end == station.largest_end]
    if not math.isfinite(station.largest_slip) or any(each.unknown for each in zones):
        return ""
    told, unit = f"predicted {number(station.largest_slip, 3)}", run.unit("length")
    zones = [each for each in zones if each.resolved or math.isfinite(each.reported_local)]
    found = [each.told for each in zones if math.isfinite(each.told[0])]
    return f", d {with_error(*max(found))} {unit} ({told})" if found else f", d {told} {unit}"


def _nothing(run: Result) -> str:
    """Words in place of the worst edge where neither K_N nor a range is known."""
    reasons = [
        (why.finer, f"{contact.name_of(station)}: {why.text}")
        for contact in run.contacts
        for station in contact.edges
        if (why := withheld(station))
    ]
    if reasons:
        # Of several edges the one that needs the smallest elements: those do for all.
        _, text = max(reasons, key=lambda each: each[0])
        return f"No edge has a known K_N or range of K_T ({text})."
    return " ".join(_without_fronts(run, each) for each in run.contacts if not each.edges)


def _without_fronts(run: Result, contact: Contact) -> str:
    """The reason for which a contact has no edges or fronts, and what else is known of it."""
    first, last = run.loads.evaluated
    state = first + int(np.argmax(contact.normal_force[first : last + 1]))
    if not contact.normal_force[state] > 0:
        return f"{contact.name}: nothing presses it, so that it has no edge factors."
    known = (
        f"P = {number(contact.normal_force[state])} {run.unit('force')}",
        f"{number(contact.contact_area[state], 3)} {run.unit('area')} in contact",
        f"largest pressure {number(contact.largest_pressure[state])} {run.unit('stress')}",
    )
    when = f"t = {run.loads.times[state]:.6g} {run.case.units.time}"
    why = contact.lack.text or "it carries no force at the end of the cycle"
    if not contact.solid:
        why = "both bodies go on behind both ends of its surface"
    return f"{contact.name}: no edge factors, as {why}. At {when} {', '.join(known)}."


def _numbers(run: Result, contact: Contact, station: Station) -> str:
    zone = station.longest_zone
    k_n, k_range = (with_error(*each.read(station)) for each in (K_N, K_RANGE))
    time = f"{run.loads.times[station.decisive]:.6g} {run.case.units.time}"
    texts = [f"K_N {_known(k_n, run.unit('k_n'))} at t = {time}{_lighter(run, contact, station)}"]
    if run.loads.cycle is not None and station.friction != 0:
        told = _known(k_range, run.unit("k_t")) + _of_another(run, station)
        texts.append(f"{_range_symbol(contact, station)} {told}")
    if zone is not None and zone.gross:
        texts.append("the whole contact slides there")
    elif zone is not None:
        texts.append(_zone_words(run, station, zone))
    end = end_beside(run, station)
    near = "" if end is None else _by_parts(run, contact, station) + nearest_range(run, end)
    worst = "Worst of the fronts that are known" if _lost(run) else "Worst"
    return f"{worst}: {_place(run, contact, station)}: {', '.join(texts)}{near}."


def _of_another(run: Result, station: Station) -> str:
    """The half cycles of a range and of a slip zone, in words, where they are not one; or empty."""
    zone, end, times = station.longest_zone, station.equivalent_end, run.loads.times
    if not (station.moves and end and zone) or zone.start < end <= zone.end + 1:
        return ""
    until = f"{times[zone.end]:.6g} {run.case.units.time}"
    return f" (in the half cycle to t = {times[end]:.6g}, d in that to {until})"


def _lighter(run: Result, contact: Contact, station: Station) -> str:
    """P in the state of K_N, in words, where the cycle has a far larger one; else empty."""
    here, most = float(contact.normal_force[station.decisive]), contact.largest_normal_force
    if not most > FAR_LARGER * here:
        return ""
    return f" (where P is {number(here)}, of up to {number(most)} {run.unit('force')})"


def _lost(run: Result) -> list[Subject]:
    """Contacts of solids with a border but no front, and borders of them without a front."""
    contacts = (each for each in run.contacts if each.lack.lost and not each.fronts)
    fronts = (
        Subject(contact.name, front.name)
        for contact in run.contacts
        for front in contact.fronts
        if front.lost
    )
    return [*(Subject(each.name) for each in contacts), *fronts]


def _by_parts(run: Result, contact: Contact, station: Station) -> str:
    """K_N and |ΔK| at a station by sub-models around an end, in words; empty without them."""
    met = meeting_at(run, contact.name_of(station))
    if met is None or not met.agrees:
        return ""
    k_n, k_range = (with_error(each.part, each.part_spread) for each in (met.k_n, met.k_range))
    unit = run.unit("k_t")
    return f"; by sub-models there K_N {_known(k_n, run.unit('k_n'))}, |ΔK| {k_range} {unit}"


def counted_from(station: Station, zones: Sequence[SlipZone], before: str) -> str:
    """Places of the edge as slip zones end, behind a text, if it is reported elsewhere."""
    here = float(station.position[station.decisive])
    places = [float(station.position[zone.end]) for zone in zones]
    lengths = [SAME * zone.reported_length for zone in zones]
    if not any(abs(each - here) > d for each, d in zip(places, lengths, strict=True)):
        return ""
    return f"{before}from {' / '.join(map(number, places))}"


def or_bound(zone: SlipZone, length: str) -> str:
    """A length as text; its upper bound where no node slips."""
    if zone.gross:
        return "gross"
    bounded = zone.length == 0 < zone.spread < math.inf and math.isnan(zone.reported_local)
    return f"< {number(zone.spread, 2)}" if bounded else length


def _shear_symbol(contact: Contact, station: Station) -> str:
    return "|ΔK|" if contact.solid or station.k_s_range > 0 else "ΔK_T"


def _range_symbol(contact: Contact, station: Station) -> str:
    return ("equivalent " if station.moves else "") + _shear_symbol(contact, station)


def _known(text: str, unit: str) -> str:
    return "unknown" if text == "-" else f"{text} {unit}"


def _compared(run: Result, station: Station, verdict: Verdict) -> str:
    zone = station.longest_zone
    assert zone is not None
    predicted = station.told_prediction(zone)
    if _still(station):
        return "nothing slips, none predicted"
    if math.isnan(predicted):
        return f"without a prediction, {verdict}"
    return f"predicted {number(predicted, 3)}: {verdict}"


def _place(run: Result, contact: Contact, station: Station) -> str:
    unit = run.case.units.length
    if not contact.solid:
        x = number(float(station.position[station.decisive]))
        return f"{contact.name}, {station.front} edge, x = {x} {unit}"
    name, end = contact.name_of(station), end_beside(run, station)
    if end is None:
        return f"station {name}, {number(station.arc, 3)} {unit} along the front"
    return f"station {name}, {number(station.to_end, 3)} {unit} from the free end {end.name}"


def _trust(contact: Contact, station: Station, doubts: tuple[str, ...]) -> str:
    if not doubts:
        steady = "the cycle is steady, " if contact.steady else ""
        once = " for this history" if station.friction and not contact.steady else ""
        slides = ", but K_T is no measure where all slides" if station.slides else ""
        return f"To be trusted{once}: {steady}the mesh resolves it, no limit is exceeded{slides}."
    return f"Not to be trusted as it stands: {'; '.join(doubts)}."


def _doubts(run: Result, contact: Contact, station: Station) -> Iterator[str]:
    """Reasons to doubt the numbers of a station."""
    zone, judgement = station.longest_zone, longest_verdict(station)
    agrees, still = judgement.verdict is Verdict.AGREES, station.friction == 0 or _still(station)
    if lost_ones := _lost(run):
        yield f"nothing is known of {places(lost_ones)}, which may be worse"
    if run.failure is not None:
        yield Kind.INCOMPLETE.seen
    elif not (run.loads.cycle or still or station.largest_range >= 0):
        yield Kind.NO_CYCLE.seen
    # Of these numbers slip alone depends on what was before; it may agree with what does not.
    elif not (contact.steady or agrees) and math.isfinite(contact.cycle_change):
        yield "the cycle is not steady"
    met = meeting_at(run, contact.name_of(station))
    if met is not None and not met.agrees:
        yield f"run and sub-model differ there: {both_ways(met)}"
    ranged = run.loads.cycle is not None and station.friction != 0 and not station.slides
    wanted = [("K_N", K_N), *([(_range_symbol(contact, station), K_RANGE)] if ranged else [])]
    for symbol, quantity in wanted:
        value, bar = _better(quantity, station, met)
        if math.isnan(value):
            own = withheld(station, k_n=quantity is K_N, ranged=quantity is K_RANGE)
            yield own.text or f"{symbol} is unknown"
        elif value > 0 and bar > LARGEST_SPREAD * value:
            yield f"{symbol} is known to {percent(bar / value, 0)} only"
    if any(each.kind is Kind.WITHIN_STEP for each in contact.warnings):
        yield "P is largest within a step, and K_N not that of it: see the warning"
    # What nodes do not show the plane problem next to the station does.
    shown = zone is None or zone.resolved or math.isfinite(zone.reported_local)
    if judgement.verdict is Verdict.NOT_RESOLVED or not shown:
        hiding = "steps do" if zone is not None and zone.within_step else "mesh does"
        yield f"the {hiding} not resolve the slip zone"
    elif judgement.verdict is Verdict.DIFFERS and station.coupling == 0:
        yield "the slip zone found is not the one predicted"
    elif zone is not None and judgement.verdict is Verdict.UNKNOWN and not withheld(station):
        yield f"the slip zone is compared with nothing: {judgement.reason}"
    exceeded = [each for each in run.limits if each.exceeded or each.doubtful]
    if exceeded:
        kinds = dict.fromkeys(each.caution.kind.heading for each in exceeded)
        yield f"outside the limits of the model ({', '.join(kinds)})"
    if run.faults or any(each.kind is Kind.FAULT for each in run.warnings):
        yield "an error of fretfe left numbers unknown"


def _better(quantity: Reported, station: Station, met: Meeting | None) -> tuple[float, float]:
    """A number of a station and its bar, by the run or by sub-models that know it better."""
    value, bar = quantity.read(station)
    if met is None or not met.agrees:
        return value, bar
    own = met.k_n if quantity is K_N else met.k_range
    return (own.part, own.part_spread) if own.part_spread < bar or math.isnan(bar) else (value, bar)


def _sliding(run: Result) -> str:
    """Contacts of which all slips at a time: their count, and the one that slides farthest."""
    sliding = [each for each in run.contacts if each.sliding_share > 0]
    if not sliding:
        return ""
    worst = max(sliding, key=lambda each: each.sliding_range)
    text = (
        f"{worst.name} in {_share(worst.sliding_share)} of the time, by "
        f"{number(worst.sliding_range, 3)} {run.unit('length')}, friction work "
        + _known(with_error(worst.reported_dissipation, worst.dissipation_spread), run.unit("work"))
    )
    what = "cycle" if run.loads.cycle is not None else "history"
    count = f"{len(sliding)} of {len(run.contacts)} contacts, farthest " if sliding[1:] else ""
    return f"Slide{'' if count else 's'} as a whole in the {what}: {count}{text}."


def _share(part: float) -> str:
    return percent(part, 0) if part >= 0.01 else "less than 1%"


def _agreement(run: Result) -> str:
    """Count of edges or stations whose longest zone agrees with the prediction."""
    stations = [each for contact in run.contacts for each in contact.edges]
    if not stations:
        return ""
    if all(each.friction == 0 for each in stations):
        return f"{len(stations)} {_what(run, len(stations))} without friction."
    still = sum(map(_still, stations))
    words = Counter(longest_verdict(each).verdict for each in stations if not _still(each))
    del words[Verdict.NO_ZONE]
    rest = f"At {still} of {len(stations)} {_what(run, len(stations))} nothing slips, as predicted."
    if still and not words:
        return rest
    if not words:
        zones = "slip zones unknown" if any(e.lack.whole for e in stations) else "no slip zones"
        return f"{len(stations)} {_what(run, len(stations))}, {zones}."
    others = ", ".join(f"{n} {word}" for word, n in words.items() if word is not Verdict.AGREES)
    return (
        f"At {words[Verdict.AGREES]} of {words.total()} {_what(run, words.total())} the longest "
        f"slip zone agrees with the prediction of the edge factors{f' ({others})' * bool(others)}."
        f"{f' {rest}' if still else ''}"
    )


def _still(station: Station) -> bool:
    """True if nothing slips at a station in the cycle, and no formula has anything slip."""
    return station.still and longest_verdict(station).verdict is Verdict.AGREES


def _what(run: Result, count: int) -> str:
    return ("station" if run.solid else "edge") + ("" if count == 1 else "s")


def _half_model(run: Result) -> str:
    """Contacts that end at a plane of symmetry, of which only the half is there."""
    names = [each.name for each in run.contacts if 0 < len(each.edges) < len(each.stations)]
    if not names:
        return ""
    return f"Half model: {', '.join(names)} ends at a plane of symmetry; P and Q are the half."


def cycle_sentences(run: Result) -> str:
    """The cycle that a run was evaluated for, and the worst counted one of irregular loads."""
    loads, steps = run.loads, len(run.loads.times) - 1
    worst = _worst_cycle(run)
    if loads.cycle is not None:
        first, last = loads.cycle
        behind = f"; the {steps - last} behind it do not count" if last < steps else ""
        text = f"Evaluated cycle: {cycle_words(loads, run.case.units.time)}"
        return f"{text} (steps {first + 1} to {last} of {steps}{behind}).{worst}"
    if run.failure is not None:
        return f"There is no evaluated cycle, as not all steps are solved.{worst}"
    told = "" if run.solid or worst else " Ranges over it are missing."
    reason = (
        "no load is a wave or a repeated table, nor do all return to zero with friction all along"
    )
    return f"There is no evaluated cycle: {reason}, and [cycle] gives none.{worst or told}"


def _worst_cycle(run: Result) -> str:
    """The worst counted cycle of all edges or stations; empty if the loads are regular."""
    counted = worst_counted(run.contacts)
    if counted is None:
        return ""
    contact, edge = counted
    worst, times = edge.cycles.worst, run.loads.times
    ends = sorted(float(times[each[worst]]) for each in (edge.cycles.start, edge.cycles.end))
    start, end = (number(each, 6) for each in ends)
    return (
        " Loads are irregular: slip zones are the longest of each edge but for first loading, the "
        f"largest K_T range is at {contact.name_of(edge)}, t = {start} to {end} {run.unit('time')}."
    )
