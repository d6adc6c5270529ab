# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables of a run, and its answer.

The tables are those of contacts, edges, fronts of solids and worst counted cycles. The answer tells
edge factors, slip zones, and whether the edge formulas describe them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from fretfe._typing import Array
from fretfe.evaluate.contacts import Contact, Front, SlipZone, Station, reported
from fretfe.evaluate.edge_tractions import edge_nodes
from fretfe.evaluate.headline import shown_stations
from fretfe.evaluate.refinement import KINDS, Refinement
from fretfe.evaluate.verdicts import Judgement, judge, longest_verdict
from fretfe.reason import Kind
from fretfe.report.page.ends import end_lines
from fretfe.report.texts import (
    MISSING,
    marked,
    number,
    percent,
    plain_table,
    rounded,
    with_error,
    with_prefix,
)
from fretfe.results.end_answers import read_answers
from fretfe.results.first_lines import counted_from, or_bound
from fretfe.results.model import Result
from fretfe.results.quantities import K_N, K_RANGE

HEADERS = (
    *("contact", "edge", "cycles", "from t", "to t"),
    *("ΔK_T", "mean K_T", "count", "d predicted"),
)
# Slip zones of an edge that are shown: those of the last loading and unloading.
ZONES = 2


def station_table(run: Result) -> Table | None:
    """The stations: a row per edge of plane contacts, some rows per front of solids.

    None where no front is known, or no contact is left.
    """
    if not any(contact.fronts for contact in run.contacts):
        return None
    edges = [edge for contact in run.contacts for edge in contact.edges]
    if not run.solid and not any(np.isfinite(edge.position[edge.decisive]) for edge in edges):
        return None
    return _front_table(run) if run.solid else _edge_table(run)


def _edge_table(run: Result) -> Table:
    """One row per contact edge, with the slip zones of the last two half cycles.

    The prediction follows the load loop where there is a cycle, else it is that of first loading.
    """
    ranges = range_name(run)
    title = (
        f"Contact edges: x and slip zones in {run.unit('length')}, K_N in {run.unit('k_n')}, "
        f"{ranges} in {run.unit('k_t')}"
    )
    headers = ("contact", "edge", "x", "K_N", ranges, "slip zones", "predicted")
    table = plain_table(title, headers, text=2)
    for contact in run.contacts:
        for edge in contact.edges:
            table.add_row(contact.name, _marked(run, contact, edge, edge.front), *_edge_cells(edge))
    return table


def is_worst(run: Result, contact: Contact, station: Station) -> bool:
    """True for the edge or station of the first lines."""
    worst = run.headline.worst
    return worst is not None and worst.name == contact.name_of(station)


def _marked(run: Result, contact: Contact, station: Station, name: str) -> str:
    """The name of an edge or a station in tables, with * if it is that of the first lines."""
    return f"{name} *" if is_worst(run, contact, station) else name


def range_name(run: Result) -> str:
    """ΔK_T; |ΔK| of the vector (K_T, K_S) where plane bodies move along z."""
    sheared = any(station.k_s_range > 0 for each in run.contacts for station in each.stations)
    return "|ΔK|" if sheared else "ΔK_T"


def _edge_cells(edge: Station) -> list[str]:
    zones = edge.slip_zones[-2:]
    # ~ marks a length that is not resolved, or known to a tenth at best.
    measured = [
        or_bound(zone, marked(number(zone.reported_length, 3), zone.uncertain)) for zone in zones
    ]
    predicted = [edge.told_prediction(zone) for zone in zones if not zone.gross]
    known = " / ".join(number(each, 3) for each in predicted if math.isfinite(each)) or MISSING
    return [
        number(edge.position[edge.decisive]),
        marked(number(edge.reported_k_n), edge.uncertain),
        marked(number(edge.reported_range), edge.uncertain_range),
        (" / ".join(measured) or MISSING) + counted_from(edge, zones, "\n"),
        marked(known, edge.uncertain or edge.uncertain_range),
    ]


def contact_table(run: Result) -> Table:
    """One row per contact: forces over the cycle, its size at the end, whether that is steady.

    Of solids a row for each patch, and one for the friction work along the fronts.
    """
    evaluated = run.loads.cycle
    forces = [each for c in run.contacts for each in (c.normal_force, c.shear_force)]
    largest = max((float(np.abs(each).max(initial=0.0)) for each in forces), default=0.0)
    scale, force = with_prefix(run.unit("force"), largest)
    if run.solid:
        title = (
            f"Contacts: P, |Q| in {force}, area in contact and what of it sticks at the end in "
            f"{run.unit('area')}, largest pressure in {run.unit('stress')}, friction work in "
            f"{run.unit('work')}, at fronts by the plane problems"
        )
        headers = ["P", "|Q|", "area", "sticks", "p_max", "work", "steady"]
    else:
        title = f"Contacts: P, Q in {force}, half-width in {run.unit('length')}"
        headers = ["P", "Q", "half-width", "steady", "Δq/(f p_max)"]
    # More than one stand nowhere else with their numbers.
    slides = sum(each.sliding_share > 0 for each in run.contacts) > 1
    if slides:
        title += f"; how far all of it slides, in {run.unit('length')}"
        headers.append("slides")
    table = plain_table(title, ("contact", *headers), text=1)
    cycle = slice(evaluated[0], evaluated[1] + 1) if evaluated else slice(None)
    last = evaluated[1] if evaluated else -1
    for contact in run.contacts:
        whole = [number(contact.sliding_range, 3) if contact.sliding_share > 0 else MISSING]
        row = (
            _solid_cells(contact, cycle, last, scale)
            if contact.solid
            else _plane_cells(contact, scale)
        )
        table.add_row(contact.name, *row, *(whole if slides else ()))
        for patch in contact.patches:
            carried = patch.normal_force, np.linalg.norm(patch.shear_force, axis=1)
            ranges = [_range(each[cycle] / scale, digits=3) for each in carried]
            area = number(patch.contact_area[last], 3)
            table.add_row(f"  {patch.name}", *ranges, area, *[MISSING] * (len(headers) - 3))
        if math.isfinite(contact.local_dissipation):
            cells_of_work = [MISSING] * len(headers)
            cells_of_work[headers.index("work")] = number(contact.local_dissipation, 3)
            table.add_row("  at fronts", *cells_of_work)
    return table


def _plane_cells(contact: Contact, scale: float) -> tuple[str, ...]:
    # The image of a half model's edge has no state that decides.
    known = (each for each in contact.stations if math.isfinite(each.decisive_k_n[0]))
    state = next(known, contact.stations[0]).decisive
    return (
        *_forces(contact, scale, 4),
        number(contact.half_width[state]),
        _steady(contact),
        number(contact.cycle_change),
    )


def _forces(contact: Contact, scale: float, digits: int) -> tuple[str, str]:
    """Ranges of P and Q, states within steps among them."""
    normal = contact.smallest_normal_force, contact.largest_normal_force
    shear = contact.smallest_shear_force, contact.largest_shear_force
    p, q = (_range(np.array(each) / scale, digits) for each in (normal, shear))
    return p, q


def _solid_cells(contact: Contact, cycle: slice, last: int, scale: float) -> tuple[str, ...]:
    return (
        *_forces(contact, scale, 3),
        number(contact.contact_area[last], 3),
        number(contact.stick_area[last], 3),
        number(contact.largest_pressure[cycle].max()),
        _work_cell(contact.reported_dissipation, contact.dissipation_spread),
        _steady(contact),
    )


def _work_cell(work: float, bar: float) -> str:
    """Friction work over its error bar, where it has one: the table is wide."""
    told = math.isfinite(work) and bar > 0
    return number(work, 3) + (f"\n± {number(bar, 2)}" if told else "")


def _steady(contact: Contact) -> str:
    if not math.isfinite(contact.cycle_change):
        return MISSING
    return "yes" if contact.steady else "no"


def refinement_tables(refinement: Refinement | None) -> list[Table]:
    """Tables of a run that refined its mesh itself; none if it did not, or knows no mesh."""
    if refinement is None or not refinement.passes:
        return []
    limits = _limit_table if refinement.limits else _reached_table
    return [_mesh_table(refinement), limits(refinement)]


def _mesh_table(refinement: Refinement) -> Table:
    """One row per mesh of a run that refined its mesh itself, with the changes from the last."""
    headers = ("mesh", "unknowns", "smallest element", "resolved", "K_N", "ΔK", "slip zones")
    table = plain_table("Changes from mesh to mesh", headers, text=0)
    for place, done in enumerate(refinement.passes, start=1):
        table.add_row(
            str(place),
            str(done.unknowns),
            number(done.smallest_element, 3),
            "yes" if done.resolved else "no",
            *(percent(done.of_kind(kind)) for kind in KINDS[:2]),
            percent(done.of_kind(KINDS[2])) if any(x.slip for x in done.stations) else MISSING,
        )
    return table


def _reached_table(refinement: Refinement) -> Table:
    """The largest last changes along each front of solids, and the stations."""
    headers = ("contact", "front", "value", "station", "found", "change")
    table = plain_table("Largest changes from the mesh before", headers, text=3)
    for each in refinement.passes[-1].changes:
        place = each.contact, each.front, each.quantity, str(each.station)
        table.add_row(*place, number(each.value), percent(each.change))
    return table


def _limit_table(refinement: Refinement) -> Table:
    """Limits that the values at each edge tend to over the sequence of meshes."""
    headers = ("contact", "edge", "K_N", "ΔK", "slip zones")
    table = plain_table("Limits that the meshes tend to", headers, text=2)
    for edge, limits in refinement.limits:
        told = [with_error(reported(*limit), limit.spread) for limit in limits]
        table.add_row(edge.contact, edge.front, *told[:2], " / ".join(told[2:]) or MISSING)
    return table


def timing_table(seconds: Mapping[str, float]) -> Table:
    """Wall time of each phase, in the order of their start."""
    table = plain_table("Timings", ("phase", "seconds"), text=1)
    for phase, value in seconds.items():
        table.add_row(phase, f"{value:.3f}")
    table.add_row("total", f"{sum(seconds.values()):.3f}")
    return table


def _range(values: Array, digits: int = 4) -> str:
    if not np.isfinite(values).all():
        return MISSING
    # a constant, and forces of thousands, without an exponent
    ends = [rounded(float(each), digits) for each in (values.min(), values.max())]
    return " … ".join(dict.fromkeys(ends))


def cycle_table(run: Result) -> Table | None:
    """One row per edge with its worst cycle; None if the loads of all edges are regular.

    `cycles` are all that were counted. An edge whose loads are regular, or whose cycles could not
    be counted, has its number of cycles only.
    """
    edges = shown_stations(run.contacts)
    if not any(edge.cycles.irregular for _, edge in edges):
        return None
    title = (
        f"Worst counted cycles: t in {run.unit('time')}, K_T in {run.unit('k_t')}, d in "
        f"{run.unit('length')}"
    )
    table = plain_table(title, HEADERS, text=2)
    for contact, edge in edges:
        table.add_row(contact.name, edge.front, *_cells(run, edge))
    return table


def _cells(run: Result, edge: Station) -> list[str]:
    cycles, times = edge.cycles, run.loads.times
    if not len(cycles.count):
        return [cycles.reason, *[MISSING] * (len(HEADERS) - 3)]
    worst = cycles.worst
    return [
        number(float(cycles.count.sum())),
        *(number(float(times[states[worst]])) for states in (cycles.start, cycles.end)),
        *(number(float(each[worst])) for each in (cycles.k_t_range, cycles.k_t_mean, cycles.count)),
        number(float(cycles.slip[worst]), 3),
    ]


def _front_table(run: Result) -> Table:
    """Two rows per front of solids: the range along it, and the station of the largest |ΔK|.

    The slip zones of the last two half cycles stand below each other. A station is told by its
    number and its distance along the front; those too near an end are left out. Slip zones are
    those by the plane problems, by the nodes where there is none.
    """
    title = (
        f"Fronts: lengths in {run.unit('length')}, K_N in {run.unit('k_n')}, |ΔK| of K_T "
        f"and K_S in {run.unit('k_t')}, slip zones of the last two half cycles, "
        "one below the other"
    )
    headers = ("front", "K_N", "|ΔK|", "slip", "predicted")
    table = plain_table(title, headers, text=1)
    for contact in run.contacts:
        for front in contact.fronts:
            judged = front.judged
            owner = contact.patches[front.patch - 1].name if front.patch else contact.name
            if not judged:
                table.add_row(f"{owner} {front.name}", *[MISSING] * 4)
                table.add_row("  all too near an end")
                continue
            table.add_row(f"{owner} {front.name}", *_along(judged))
            if front.lost:
                table.add_row("  cannot be followed")
            worst = front.worst
            if worst is not None:
                name = f"  {worst.number} at {number(worst.arc, 3)}"
                table.add_row(_marked(run, contact, worst, name), *_at(worst))
    return table


def _along(stations: tuple[Station, ...]) -> tuple[str, ...]:
    """Cells of the range of the numbers of all stations."""
    halves = [
        [(each, each.slip_zones[half]) for each in stations if len(each.slip_zones) >= -half]
        for half in range(-ZONES, 0)
    ]
    lines = [pairs for pairs in halves if pairs]
    return (
        _known_range([each.reported_k_n for each in stations], digits=4),
        _known_range([each.reported_range for each in stations], digits=3),
        _lines(_known_range([zone.told[0] for _, zone in each], digits=2) for each in lines),
        _lines(_known_range([e.told_prediction(z) for e, z in each], digits=2) for each in lines),
    )


def _lines(texts: Iterable[str]) -> str:
    """Texts below each other; missing without any."""
    return "\n".join(texts) or MISSING


def _at(station: Station) -> tuple[str, ...]:
    """The same cells of one station, with error bars."""
    zones = station.slip_zones[-ZONES:]
    return (
        *(with_error(*each.read(station)) for each in (K_N, K_RANGE)),
        _lines(or_bound(zone, with_error(*zone.told)) for zone in zones),
        _lines(number(station.told_prediction(zone), 3) for zone in zones),
    )


def _known_range(values: Sequence[float], digits: int) -> str:
    """Smallest and largest of the numbers that are known."""
    known = [value for value in values if math.isfinite(value)]
    if not known:
        return MISSING
    ends = [number(end, digits) for end in (min(known), max(known))]
    return ends[0] if ends[0] == ends[1] else " … ".join(ends)


@dataclass(frozen=True)
class ZoneAnswer:
    """A slip zone as text.

    Attributes:
        time: of the half cycle.
        found, predicted, ratio: lengths, and the second over the first.
        judged: verdict on it, with its reason.
        told: whether it is that of the first lines.
    """

    time: str
    found: str
    predicted: str
    ratio: str
    judged: Judgement
    told: bool


EdgeAnswer = tuple[Contact, Station, tuple[ZoneAnswer, ...]]


def edge_answers(run: Result) -> tuple[EdgeAnswer, ...]:
    """The edges of plane contacts with their last slip zones, or why none is known."""
    return tuple(
        (
            contact,
            edge,
            tuple(_zone_answer(run, contact, edge, zone) for zone in edge.slip_zones[-ZONES:])
            or (ZoneAnswer(MISSING, MISSING, MISSING, MISSING, longest_verdict(edge), False),),
        )
        for contact in run.contacts
        if not contact.solid
        for edge in contact.edges
    )


def _zone_answer(run: Result, contact: Contact, edge: Station, zone: SlipZone) -> ZoneAnswer:
    times = run.loads.times
    length = with_error(zone.reported_length, zone.spread)
    predicted = math.nan if zone.gross else edge.told_prediction(zone)
    ratio = predicted / zone.length if zone.length > 0 else float("nan")
    return ZoneAnswer(
        time=f"{times[zone.start]:g} … {times[zone.end]:g}",
        found=or_bound(zone, marked(length, zone.uncertain) + counted_from(edge, [zone], "\n")),
        predicted=marked(number(predicted, 3), edge.uncertain or edge.uncertain_range),
        ratio=number(ratio, 3),
        judged=judge(edge, zone),
        told=is_worst(run, contact, edge) and zone is edge.longest_zone,
    )


def summary(run: Result) -> tuple[str, ...]:
    """The answer in a few sentences: the first lines, fronts of solids, solution."""
    fronts = front_texts(run) if run.solid else ()
    return tuple(filter(None, (*run.headline.sentences.lines, *fronts, _step_text(run))))


def front_texts(run: Result) -> tuple[str, ...]:
    """The friction work of fronts of solids that is not told, and the ends of open fronts."""
    named = [(contact, front) for contact in run.contacts for front in contact.fronts]
    ends = (" ".join(end_lines(run, answer)) for answer in read_answers(run))
    return tuple(filter(None, (_work_text(run), _end_text(run, named), *ends)))


def _place(run: Result, contact: Contact, station: Station) -> str:
    point = ", ".join(number(float(x), 3) for x in station.point)
    along = f"{number(station.arc, 3)} {run.case.units.length} along the front"
    return f"station {contact.name_of(station)}, {along} at ({point})"


def _work_text(run: Result) -> str:
    """Friction work that is unknown, and the parts of fronts that it leaves out; empty if none."""
    parts = []
    texts = [
        f"The friction work of {each.name} is {work_words(each)}."
        for each in run.contacts
        if math.isfinite(each.dissipation) and math.isnan(each.reported_dissipation)
    ]
    for contact in run.contacts:
        lost = [station for station in contact.stations if not math.isfinite(station.local.work)]
        if lost and math.isfinite(contact.local_dissipation):
            ends = sum(station.end for station in lost)
            parts.append(
                f"{1 - contact.local_share:.0%} of the length at {contact.name} ({len(lost)} of "
                f"{len(contact.stations)} stations, {ends} of them near a free end)"
            )
    if parts:
        texts.append(
            "The friction work at fronts leaves out the parts whose stations have no plane "
            f"problem: {', '.join(parts)}. The work of the nodes is that of the whole contact."
        )
    return " ".join(texts)


def work_words(contact: Contact) -> str:
    """Friction work of a contact with its error bar, or why it is unknown."""
    work, bar = contact.reported_dissipation, contact.dissipation_spread
    if math.isfinite(work):
        return with_error(work, bar)
    zones = [(zone, each.size) for each in contact.edges for zone in each.evaluated_zones]
    elements = max(
        (zone.told[0] / size for zone, size in zones if zone.told[0] * size > 0), default=0.0
    )
    seen = (
        f"slip zones have {number(elements, 2)} elements at most"
        if elements
        else "no slip zone is seen"
    )
    if math.isinf(bar):
        return f"unknown, because nodes do not show how far slip goes: {seen}"
    return f"unknown, because its error bar of {number(bar, 2)} exceeds it: {seen}"


def _end_text(run: Result, named: Sequence[tuple[Contact, Front]]) -> str:
    """The largest |ΔK| near the ends of open fronts, and the slip of the nodes at that end."""
    ends = [
        (contact, front, station)
        for contact, front in named
        for station in front.stations
        if station.end
    ]
    if not ends:
        return ""
    texts = [
        "Ends of open fronts are outside the edge formulas: the fields there are not those of an "
        "edge."
    ]
    known = [each for each in ends if math.isfinite(each[2].k_range)]
    if known:
        contact, front, station = max(known, key=lambda each: each[2].k_range)
        texts.append(
            f"The largest |ΔK| is {with_error(station.k_range, station.k_range_spread)} "
            f"{run.unit('k_t')}, by radii, elements and steps, at {_place(run, contact, station)}."
        )
    else:
        contact, front, station = max(
            ends, key=lambda each: np.nanmax([-1.0, *(s.k_range for s in each[1].judged)])
        )
    short = [each[2].to_end for each in ends if each[2].lack.kind is Kind.FREE_END]
    if short:
        texts.append(
            f"Nearer to free ends than {number(max(short), 2)} {run.unit('length')} |ΔK| is "
            "unknown, and may be larger than anywhere else: elements are longer than that along "
            "the front. Make elements shorter there (of layers by end_size)."
        )
    if run.case.geometry.solid is None:
        texts.append(
            "Parts around ends are made of extruded bodies only: no sub-model shows what is nearer."
        )
    return " ".join([*texts, _end_slip(run, contact, front, station)])


def _end_slip(run: Result, contact: Contact, front: Front, station: Station) -> str:
    """Largest slip and friction work of the nodes next to the stations at an end of a front."""
    if not run.solution.keeps(*run.loads.evaluated):
        return "Slip and friction work there are unknown, because not all tractions are kept."
    first, history = station.arc < front.length / 2, run.contact_history(contact.name)
    reach = (-station.size, station.depth)
    # An element along the front may be longer than what belongs to a station.
    near = np.concatenate([
        edge_nodes(history, front, each, each.last, reach).nodes
        for each in front.stations
        if each.end and (each.arc < front.length / 2) == first
    ])  # fmt: skip
    if not len(near):
        return "Slip and friction work there are unknown, because no node lies next to it."
    moved = run.local_parameters(contact.name)
    slip, work = (float(each[near].max()) for each in (moved.slip_range, moved.work))
    return (
        f"Nodes at this end slip by up to {number(slip, 3)} {run.unit('length')}, with a friction "
        f"work of up to {number(work, 3)} {run.unit('density')}."
    )


def _step_text(run: Result) -> str:
    solution = run.solution
    if run.failure is not None:
        return ""
    worst = float(solution.certificates["worst"].max())
    return (
        f"All {len(solution.times) - 1} load steps are solved; the largest violation of a contact "
        f"condition is {number(worst, 2)} of its scale."
    )
