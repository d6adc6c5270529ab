# SPDX-License-Identifier: LGPL-3.0-or-later
"""Figures of edges, and of contacts of solids with their fronts.

Tractions next to an edge stand with the asymptotes K_N √s and ΔK_T/√s. The shear of a contact that
slips has no term in 1/√s. K_T belongs to the contact that is kept from slipping: shown are
therefore its increments, summed up over the steps like K_T itself, and the true change of the
shear, which follows them beyond the slip zone and stays at the friction bound in it. Besides:
counted cycles of an edge; forces, areas and work of solids, factors and slip zones along their
fronts, and tractions next to one station of each contact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.case import Units
from fretfe.evaluate.contacts import (
    Contact,
    Front,
    HalfSpaceRatios,
    SlipZone,
    Station,
    reported,
)
from fretfe.evaluate.edge_tractions import HalfCycleEnd, half_cycle_ends
from fretfe.evaluate.plane.section import plane_front
from fretfe.history.solution import Solution
from fretfe.report.figures.history import rows_of, time_panels
from fretfe.report.page.ends import end_lines
from fretfe.report.plotting import Axes, Figure
from fretfe.report.source import Shown, edge_title, when
from fretfe.report.texts import MISSING, number, with_error
from fretfe.report.theme import (
    BLUE,
    DOUBLE,
    GREEN,
    GREY,
    ORANGE,
    PALE,
    SINGLE,
    TRIPLE,
    VERMILLION,
    Plot,
    envelope,
    legend_above,
    log_axis,
    make_plot,
    plain_axis,
    say_if_unknown,
    sparse,
)
from fretfe.results.end_answers import EndAnswer
from fretfe.results.front_ends import find_end, known_numbers
from fretfe.results.model import Result
from fretfe.results.quantities import K_N, K_RANGE, Reported

# Decades below the half-width that are shown at most.
DECADES = 4
# Edges that move by less than this fraction of the half-width stay where they are.
SMALL_MOVE = 1e-3
INTRO = (
    "Each edge in the half cycle of its longest slip zone, that of the first lines; s is the "
    "distance from the edge in the later of its two states. All axes are logarithmic, so "
    "asymptotes are straight lines. Above: the pressure and its asymptote K_N √s. Below, positive "
    "in the sense of ΔK_T: the change of the shear between the two states; the same in full stick, "
    "summed over the steps like K_T, and its asymptote ΔK_T/√s; and the most that friction allows, "
    "f times the pressure of the later state less the shear of the earlier one. In a contact that "
    "slips, the shear does not go like 1/√s: its change follows the line of full stick far from "
    "the edge and the friction bound in the slip zone, which ends where it leaves the bound. An "
    "edge that moves between the two has no asymptotes nearer than that."
)
# Classes of ranges, and of K_T from and to.
CLASSES = 32
CYCLES_INTRO = (
    "Cycles of K_T, or of K_T ∓ f K_I where P varies, counted by the rainflow method (ASTM E1049). "
    "Above: the number of cycles in each class of ΔK_T; dashed: the worst cycle. Below: K_T at the "
    "reversals at which cycles begin and end; circle: the worst cycle, line: cycles without a "
    "range. The table has the worst cycle of each edge; cycles.csv has all of them."
)
AREAS_INTRO = (
    "P is the integral of the pressure, Q that of the shear that body 1 exerts on body 2, in the "
    "axes of the case. Each node counts with its whole area, so the areas grow in steps of an "
    "element. The largest pressure is a mean around a node; friction work is that of the step to "
    "each state. Shaded: the evaluated cycle."
)
# Of lines that are told apart.
STYLES = ((BLUE, "-", "o"), (VERMILLION, "--", "s"), (GREEN, ":", "^"))
FRONTS_INTRO = (
    "Stations along the boundary of the contact area, over their distance along it. K_N is that of "
    "the largest P; ΔK_T, ΔK_S and their vector sum |ΔK| are ranges over the evaluated cycle. "
    "Error bars are meant to contain the true value with a probability of 95 %. d is the width of "
    "the slip zone, inward, in the half cycle of the cycle where it is longest at the "
    "station: by the plane problem next to each station, "
    "whose error bar is the band around the line; by the formula, from K_N and |ΔK| alone; and by "
    "the slip of the nodes of the solids, where there are enough of them in the zone. Grey: "
    "stations too near a free end, where there is neither plane problem nor formula."
)
ENDS_INTRO = (
    "Two sub-models around a free end, driven by the run, with small elements there; those of the "
    "coarser one are twice as long. |ΔK| over the distance from the end, as far as it means "
    "something. Next to the end the nodes tell: the largest of their ranges of slip, friction work "
    "and tractions in the evaluated cycle, and the mean along the front; bars are by the "
    "difference of the two."
)
STATIONS_INTRO = (
    "The worst station of each contact, which the first lines tell of the whole run, or the worst "
    "of those with a plane problem, in the half cycle of its longest slip zone: at the two ends of "
    "that half cycle, over the distance from the front as it is then. Lines: the plane problem "
    "next to the station. Marks: the nodes of the solids nearest to it, as means over an element "
    "or so, which are too coarse to follow a short slip zone. Above: the pressure. Below: the "
    "shear along the direction in which (K_T, K_S) varies most; dotted: the friction bounds ±f p. "
    "Behind the slip zone the lines are pale, because there the plane problem describes the "
    "contact less and less. It has a pressure of its own there, and does not know the shear that "
    "was left there by what slid before the evaluated cycle: only the change of the shear from one "
    "state to the other counts."
)
# Of a figure next to a station: slip zones and elements that it shows, at most to the middle.
ZONES_SHOWN = 4
ELEMENTS_SHOWN = 6


@dataclass(frozen=True)
class _Near:
    """Curves that are drawn next to one edge.

    Attributes:
        edge: the edge.
        earlier, later: states between which the longest slip zone of the edge arises.
        line: (d - 1,) of ΔK in terms of the shear along the arc and, where bodies move along z, z.
        range: |ΔK|.
        moved: by how much the edge moves between the two.
    """

    edge: Station
    earlier: int
    later: int
    line: Array
    range: float
    moved: float


def edge_plot(shown: Shown, edge: Station) -> Plot | None:
    """Asymptotes and tractions at one edge; None if there is no edge or nothing to compare."""
    near = _near(shown, edge)
    if near is None:
        return None
    times = [when(shown.run, state) for state in (near.earlier, near.later)]
    moves = near.moved > SMALL_MOVE * shown.summary.half_width[near.later]
    far = f"; the edge moves by {near.moved:.2g} {shown.run.case.units.length}" if moves else ""
    caption = f"From {times[0]} to {times[1]}{far}."
    return make_plot(
        f"{shown.key}-{edge.front}",
        f"Contact {shown.summary.name}, {edge_title(edge)}",
        caption,
        DOUBLE,
        lambda figure: _draw(figure, shown, near),
    )


def _near(shown: Shown, edge: Station) -> _Near | None:
    zone = edge.longest_zone
    if zone is None or not np.isfinite([edge.position[zone.end], edge.k_n[zone.end]]).all():
        return None
    # What is not known before the first state with friction is nothing.
    change = float(edge.k_along[zone.end] - np.nan_to_num(edge.k_along[zone.start]))
    size = shown.tractions.slip.shape[2]
    line = np.sign(change) * plane_front(edge.front).axis(edge.direction, size)
    moved = abs(edge.position[zone.end] - edge.position[zone.start])
    if change == 0.0:
        return None
    near = _Near(edge, zone.start, zone.end, line, abs(change), float(np.nan_to_num(moved)))
    # A coarse contact may have no node inward of its edge.
    return near if _behind(shown, near)[1].any() else None


def _behind(shown: Shown, near: _Near) -> tuple[Array, Bools, float]:
    """Distances of all nodes from the edge, those up to the half-width that count, and that."""
    s = near.edge.inward * (shown.tractions.surface.arc - near.edge.position[near.later])
    half_width = float(shown.summary.half_width[near.later])
    inside = (s > max(10.0**-DECADES * half_width, _smallest(s))) & (s < half_width)
    return s, inside, half_width


def _draw(figure: Figure, shown: Shown, near: _Near) -> None:
    top, bottom = figure.subplots(2, 1, sharex=True)
    units = shown.run.case.units
    s, inside, half_width = _behind(shown, near)
    line = np.geomspace(s[inside].min(), half_width, 60)
    p = shown.tractions.mean_traction[near.later, inside, 0]
    nodes: Any = {"ms": 4, "lw": 0.8, "color": BLUE, "markevery": sparse(_positive(p))}
    top.plot(s[inside], _positive(p), ".-", label="p, mean at the nodes", **nodes)
    k_n = reported(near.edge.k_n[near.later], near.edge.k_n_spread[near.later])
    if math.isfinite(k_n):
        top.plot(line, k_n * np.sqrt(line), "--", color=VERMILLION, label="K_N √s")
    _shear(bottom, shown, near, s, inside, line)
    _zone_lines(bottom, shown, near)
    for axes in (top, bottom):
        log_axis(axes, "x")
        log_axis(axes, "y")
        axes.grid(True, color=PALE, lw=0.5)
    top.set_ylabel(f"p [{units.stress}]")
    bottom.set_ylabel(f"change of q [{units.stress}]")
    bottom.set_xlabel(f"distance s from the {edge_title(near.edge)} [{units.length}]")
    legend_above(top, columns=2)
    legend_above(bottom, columns=2)


def _smallest(s: Array) -> float:
    """Half an element at the edge: means around nodes know nothing nearer than that."""
    nearest = int(np.argmin(np.abs(s)))
    sizes = np.abs(np.diff(s[max(nearest - 1, 0) : nearest + 2]))
    return float(sizes.max(initial=0.0)) / 2


def _shear(axes: Axes, shown: Shown, near: _Near, s: Array, inside: Bools, line: Array) -> None:
    tractions = shown.tractions
    before, after = (tractions.mean_traction[state, inside] for state in (near.earlier, near.later))
    change = (after[:, 1:] - before[:, 1:]) @ near.line
    friction = tractions.friction.at(near.later, inside)
    bound = friction * after[:, 0] - before[:, 1:] @ near.line
    s = s[inside]
    nodes: Any = {"ms": 4, "lw": 1.2, "color": BLUE, "markevery": sparse(_positive(change))}
    axes.plot(s, _positive(change), ".-", label="change of q", **nodes)
    axes.plot(s, _positive(bound), ":", color=GREY, label="friction bound")
    solution = shown.run.solution
    stuck = _stuck_change(solution, shown, near)
    if stuck is not None:
        axes.plot(
            s, _positive(stuck[inside] @ near.line), "-.", color=GREEN, label="the same, full stick"
        )
    if shown.run.loads.cycle is None or math.isfinite(near.edge.reported_range):
        label = "ΔK_T/√s" if len(near.line) == 1 else "ΔK/√s"
        axes.plot(line, near.range / np.sqrt(line), "--", color=VERMILLION, label=label)
    finite = np.concatenate([_positive(change), _positive(bound)])
    finite = finite[np.isfinite(finite)]
    if len(finite):
        axes.set_ylim(finite.min() / 2, 3 * max(finite.max(), near.range / np.sqrt(line[-1])))


def _stuck_change(solution: Solution, shown: Shown, near: _Near) -> Array | None:
    """(N, d - 1) shear that the stuck contact gains between the two states.

    Each step with the mean of the unit fields of the areas before and after it, as for K_T.
    """
    full_stick = shown.tractions.full_stick
    if not len(full_stick.fields) or not solution.keeps(near.earlier, near.later):
        return None
    # What the drivers do on each area, altogether.
    drive: dict[int, Array] = {}
    for state in range(near.earlier + 1, near.later + 1):
        areas = [int(area) for area in full_stick.area[state - 1 : state + 1] if area >= 0]
        if areas and shown.tractions.friction.acts[state]:
            step = solution.driver_values[state] - solution.driver_values[state - 1]
            for area in areas:
                drive[area] = drive.get(area, np.zeros_like(step)) + step / len(areas)
    total = np.zeros(shown.tractions.slip.shape[1:])
    for area, amount in drive.items():
        total += full_stick.fields[area, :, 1:] @ amount
    return total


def _zone_lines(axes: Axes, shown: Shown, near: _Near) -> None:
    """The slip zone that ends at the later state, found and predicted."""
    zone = near.edge.longest_zone
    assert zone is not None
    predicted = near.edge.told_prediction(zone)
    lengths = ((zone.length, "-", "d found"), (predicted, "--", "d predicted"))
    for length, style, label in lengths:
        if np.isfinite(length) and length > 0:
            axes.axvline(length, color="black", lw=0.9, ls=style, label=label)


def _positive(values: Array) -> Array:
    return np.where(values > 0, values, np.nan)


def cycle_plot(shown: Shown, edge: Station) -> Plot | None:
    """Histogram of the cycles of an edge; None if its loads are regular."""
    if not edge.cycles.irregular:
        return None
    where = "each repetition" if edge.cycles.closed else "the history"
    return make_plot(
        f"{shown.key}-{edge.front}-cycles",
        f"Contact {shown.summary.name}, {edge_title(edge)}",
        f"{number(float(edge.cycles.count.sum()))} cycles in {where}.",
        SINGLE,
        lambda figure: _draw_cycles(figure, shown, edge),
    )


def _draw_cycles(figure: Figure, shown: Shown, edge: Station) -> None:
    """Counts by classes of the range; logarithmic, as small cycles are many."""
    axes, cycles = figure.subplots(), edge.cycles
    counts, borders = np.histogram(
        cycles.k_t_range, CLASSES, (0.0, cycles.k_t_range.max()), weights=cycles.count
    )
    axes.bar(borders[:-1], counts, np.diff(borders), align="edge", color=BLUE, ec="white", lw=0.4)
    axes.set_ylim(0.4, 1.6 * max(counts.max(), 1.0))
    log_axis(axes, "y")
    axes.set_xlim(0.0, 1.04 * borders[-1])
    axes.axvline(cycles.k_t_range[cycles.worst], color=VERMILLION, ls="--", lw=1.0)
    plain_axis(axes, "x")
    axes.set_xlabel(f"ΔK_T [{shown.run.unit('k_t')}]")
    axes.set_ylabel("cycles")


def force_plot(run: Result, area: Contact, key: str) -> Plot:
    """P above the components of Q."""

    def draw(figure: Figure) -> None:
        panels = normal, shear = rows_of(figure, 2)
        time_panels(panels, run.case, run.loads)
        _lines(normal, run, {"P": area.normal_force})
        _lines(shear, run, dict(zip(("Q_x", "Q_y", "Q_z"), area.shear_force.T, strict=True)))
        normal.set_ylabel(run.axis_label("normal_force"))
        shear.set_ylabel(run.axis_label("shear_force"))
        legend_above(shear, columns=3)

    return make_plot(f"{key}-forces", f"Forces, contact {area.name}", "", DOUBLE, draw)


def area_plot(run: Result, area: Contact, key: str) -> Plot:
    """Areas, largest pressure and friction work, below each other."""

    def draw(figure: Figure) -> None:
        panels = areas, pressure, work = rows_of(figure, 3)
        time_panels(panels, run.case, run.loads)
        _lines(areas, run, {"in contact": area.contact_area, "sticks": area.stick_area})
        _lines(pressure, run, {"p_max": area.largest_pressure})
        _lines(work, run, {"work": area.work})
        areas.set_ylabel(run.axis_label("contact_area"))
        pressure.set_ylabel(run.axis_label("largest_pressure"))
        work.set_ylabel(run.axis_label("work"))
        legend_above(areas, columns=2)

    return make_plot(
        f"{key}-areas", f"Areas, pressure and work, contact {area.name}", "", DOUBLE, draw
    )


def _lines(axes: Axes, run: Result, lines: Mapping[str, Array]) -> None:
    """Lines over time, by their labels."""
    for (label, values), (colour, line, mark) in zip(lines.items(), STYLES, strict=False):
        shown = envelope(values)
        marked = mark if len(shown) == len(values) else ""
        axes.plot(
            run.loads.times[shown], values[shown], ls=line, marker=marked, ms=2.5, lw=1.1,
            color=colour, label=label,
        )  # fmt: skip
    if any(np.min(values) < 0 for values in lines.values()):
        axes.axhline(0, color=GREY, lw=0.6)


def front_plot(run: Result, area: Contact, front: Front, key: str) -> Plot:
    """K_N, the ranges of K_T and K_S, and slip zones along one front, below each other."""
    has_zones = any(station.slip_zones for station in front.stations)
    has_ranges = bool(np.isfinite(front.along("k_range")).any())

    def draw(figure: Figure) -> None:
        count = 1 + has_ranges + has_zones
        panels = list(np.atleast_1d(figure.subplots(count, 1, sharex=True)))
        _bars(panels[0], front, K_N, "K_N", BLUE)
        panels[0].set_ylabel(run.axis_label("k_n"))
        panels[0].set_ylim(bottom=0.0)
        if has_ranges:
            _ranges(panels[1], front)
            panels[1].set_ylabel(f"ΔK [{run.unit('k_t')}]")
        if has_zones:
            _zones(panels[-1], front)
            panels[-1].set_ylabel(f"d [{run.unit('length')}]")
        half = front.length / len(front.stations) / 2
        for axes in panels:
            for station in front.stations:
                if station.end:
                    low, high = station.arc - half, station.arc + half
                    axes.axvspan(low, high, color=GREY, alpha=0.2, lw=0)
            plain_axis(axes, "y")
            say_if_unknown(axes)
        panels[-1].set_xlabel(f"distance along {front.name} [{run.unit('length')}]")

    title = f"{front.name.capitalize()} of contact {area.name}"
    return make_plot(f"{key}-front", title, _half_spaces(front.half_space_ratios), TRIPLE, draw)


def end_plot(run: Result, answer: EndAnswer, key: str) -> Plot | None:
    """|ΔK| near the end of a front by the run and by both sub-models; None without any."""
    end = find_end(run, answer.name)
    assert end is not None
    table = known_numbers(end)
    if not len(answer.distance):
        return None
    table = table[:, table[0] <= 1.5 * answer.distance[-1]]

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        axes.errorbar(table[0], table[1], table[2], fmt="s", color=GREY, label="run")
        axes.plot(answer.distance, answer.coarser, "--", color=BLUE, label="coarser sub-model")
        found = answer.distance, answer.k_range, answer.k_range_spread
        axes.errorbar(*found, fmt="o", color=VERMILLION, label="finer sub-model")
        axes.set_xlabel(f"distance from {answer.name} [{run.unit('length')}]")
        axes.set_ylabel(f"|ΔK| [{run.unit('k_t')}]")
        axes.set_xlim(left=0.0)
        axes.legend()

    caption = " ".join(end_lines(run, answer))
    return make_plot(key, f"Free end {answer.name}", caption, SINGLE, draw)


def _half_spaces(found: HalfSpaceRatios) -> str:
    """The factors against those of half-spaces, in words; empty if there is nothing to tell."""
    ratios = {
        "K_T and K_S due to Q": found.shear,
        "K_S due to torsion": found.twist,
        "K_I due to P": found.normal,
        "K_N from dP/da": found.pressure,
    }
    told = [f"{name} {ratio:.3f}" for name, ratio in ratios.items() if np.isfinite(ratio)]
    if not told:
        return ""
    axes = " and ".join(number(float(each)) for each in found.half_axes)
    return (
        f"Factors over those of half-spaces with an elliptical contact, half-axes {axes}, under "
        f"the same forces, on average along the front: {', '.join(told)}. For bodies of finite "
        "size the ratios differ from 1 by some per cent."
    )


def _ranges(axes: Axes, front: Front) -> None:
    arc = front.along("arc")
    _bars(axes, front, K_RANGE, "|ΔK|", VERMILLION)
    axes.plot(arc, front.along("k_t_range"), "--", color=GREEN, lw=1.1, label="ΔK_T")
    axes.plot(arc, front.along("k_s_range"), ":", color=ORANGE, lw=1.3, label="ΔK_S")
    axes.set_ylim(bottom=0.0)
    legend_above(axes, columns=3)


def _zones(axes: Axes, front: Front) -> None:
    """Slip zones by the plane problems with their band, by the formula, and by nodes."""
    arc = front.along("arc")
    local, band, predicted, nodes, spread = np.array(
        [_lengths(station) for station in front.stations]
    ).T
    if np.isfinite(local).any():
        axes.fill_between(arc, local - band, local + band, color=BLUE, alpha=0.2, lw=0)
        axes.plot(arc, local, ".-", ms=4, lw=1.1, color=BLUE, label="plane problem")
        known = np.pad(np.isfinite(local), 1)
        alone = known[1:-1] & ~known[:-2] & ~known[2:]  # has no band
        axes.errorbar(arc[alone], local[alone], band[alone], fmt="none", ecolor=BLUE, alpha=0.4)
    axes.plot(arc, predicted, "--", color=VERMILLION, lw=1.1, label="formula")
    if np.isfinite(nodes).any():
        axes.errorbar(
            arc, nodes, spread, fmt="s", ms=3, elinewidth=0.6, color=GREEN, mfc="white",
            label="nodes", zorder=1.5,
        )  # fmt: skip
    axes.set_ylim(bottom=0.0)
    legend_above(axes, columns=3)


def _lengths(station: Station) -> tuple[float, ...]:
    """The longer slip zone by plane problem and bar, formula, nodes that resolve it and bar.

    None of them describes what is near a free end.
    """
    zone = station.longest_zone
    if zone is None or station.end:
        return (math.nan,) * 5
    nodes = (zone.reported_length, zone.spread) if zone.resolved else (math.nan, math.nan)
    return (zone.reported_local, zone.local_spread, station.told_prediction(zone), *nodes)


def station_plot(shown: Shown, front: Front, station: Station) -> Plot | None:
    """Tractions next to a station of solids; None without its plane problem."""
    ends = half_cycle_ends(shown.tractions, front, station, shown.run.loads.times)
    if not ends:
        return None
    units, zone = shown.run.case.units, station.longest_zone
    assert zone is not None

    def draw(figure: Figure) -> None:
        top, bottom = figure.subplots(2, 1, sharex=True)
        draw_half_cycle(top, bottom, ends, station.size, units)

    caption = (
        f"{number(station.arc, 3)} {units.length} along the front. The length of the slip zone is "
        f"{_by_plane_problem(station, zone, units)}. An element across the front is "
        f"{number(station.size, 2)} {units.length}."
    )
    title = f"Station {shown.summary.name_of(station)}"
    key = f"{shown.key}-{station.front.replace(' ', '-')}-{station.number}"
    return make_plot(key, title, caption, DOUBLE, draw)


def _by_plane_problem(station: Station, zone: SlipZone, units: Units) -> str:
    """The length of a slip zone by the plane problem and by the formula, in words."""
    told = with_error(zone.reported_local, zone.local_spread)
    length = f"{told} {units.length}" if told != MISSING else "known to no better than half of it"
    predicted = number(station.told_prediction(zone), 3)
    formula = "unknown" if predicted == MISSING else f"{predicted} {units.length}"
    return f"{length} by the plane problem, {formula} by the formula"


def draw_half_cycle(
    top: Axes, bottom: Axes, ends: Sequence[HalfCycleEnd], size: float, units: Units
) -> None:
    """Tractions next to a station at the ends of a half cycle, nodes as marks.

    Args:
        top: for p.
        bottom: for q.
        ends: in time order; at least one.
        size: of an element across the front.
        units: of the case.
    """
    for end, style in zip(ends, STYLES, strict=False):
        _draw_end(top, bottom, end, style, f"t = {end.time:.6g} {units.time}")
    top.plot([], [], color=GREY, ls="", marker="o", ms=3.5, mfc="white", label="nodes")
    longest = max((end.slip for end in ends if math.isfinite(end.slip)), default=0.0)
    reach = max(ZONES_SHOWN * longest, ELEMENTS_SHOWN * size)
    bottom.set_xlim(-size, min(reach, *(float(end.plane.s[-1]) for end in ends)))
    _fit_heights(top, bottom)
    bottom.axhline(0, color=GREY, lw=0.6)
    top.set_ylabel(f"p [{units.stress}]")
    bottom.set_ylabel(f"q [{units.stress}]")
    bottom.set_xlabel(f"distance from the front [{units.length}]")
    legend_above(top, columns=3)


def _draw_end(
    top: Axes, bottom: Axes, end: HalfCycleEnd, style: tuple[str, str, str], label: str
) -> None:
    """One state: lines are pale behind the slip zone, where the mean of the shear is not known."""
    colour, line, mark = style
    marks: Any = {"ls": "", "marker": mark, "ms": 3.5, "mfc": "white", "color": colour}
    pale: Any = {"color": colour, "lw": 1.0, "alpha": 0.35}
    s, border = end.plane.s, int(np.count_nonzero(end.plane.s <= end.slip))
    slips, sticks = slice(border), slice(max(border - 1, 0), None)
    top.plot([], [], line, color=colour, lw=1.8, label=label)
    for axes, values, nodes in (
        (top, end.plane.pressure, end.nodes.pressure),
        (bottom, end.plane.shear, end.nodes.shear),
    ):
        axes.plot(s[slips], values[slips], line, color=colour, lw=1.8)
        axes.plot(s[sticks], values[sticks], line, **pale)
        axes.plot(end.nodes.s, nodes, **marks)
    for sign in (end.friction, -end.friction):
        bottom.plot(s[sticks], sign * end.plane.pressure[sticks], ":", **pale)


def _fit_heights(top: Axes, bottom: Axes) -> None:
    """Limits by what is seen of the lines, p from zero."""
    low, high = bottom.get_xlim()
    for axes in (top, bottom):
        seen = [
            y[(x >= low) & (x <= high)]
            for x, y in (np.asarray(line.get_data(), dtype=float) for line in axes.lines)
            if len(x)
        ]
        heights = np.concatenate(seen)
        most = 1.06 * float(np.abs(heights).max())
        axes.set_ylim(0.0 if axes is top else -most, most)
        plain_axis(axes, "y")


def _bars(axes: Axes, front: Front, quantity: Reported, label: str, colour: str) -> None:
    values, spread = np.array([quantity.read(station) for station in front.stations]).T
    shown = np.where(np.isfinite(spread), spread, 0.0)
    look: Any = {"fmt": "o-", "ms": 2.5, "lw": 1.0, "elinewidth": 0.7, "color": colour}
    axes.errorbar(front.along("arc"), values, shown, label=label, **look)
