# SPDX-License-Identifier: LGPL-3.0-or-later
"""Along the contacts: tractions, stick and slip, local parameters, stress at the surface."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.case import Case, Units
from fretfe.evaluate.contacts import Contact, SlipZone, Station
from fretfe.evaluate.loaded import NO_LOAD
from fretfe.evaluate.resultants import load_extremes, shear_line
from fretfe.evaluate.slip import SMALLEST_SLIP
from fretfe.evaluate.stress import (
    EdgeStress,
    LocalParameters,
    StressHistory,
    resolved_shear,
    stress_parameters,
)
from fretfe.history.solution import OPEN, SLIP, STICK, ContactHistory, Solution
from fretfe.history.state_array import blocks
from fretfe.report.plotting import Axes, BoundaryNorm, Figure, ListedColormap, Patch
from fretfe.report.source import Shown, edge_title
from fretfe.report.texts import number, with_error, with_prefix
from fretfe.report.theme import (
    BLUE,
    CYCLE,
    DOUBLE,
    GREEN,
    GREY,
    PALE,
    SINGLE,
    SKY,
    VERMILLION,
    Plot,
    envelope,
    finish_edge_column,
    legend_above,
    make_plot,
    plain_axis,
    say,
    sparse,
)

INTRO = (
    "Means around each node. Dashed: pressure p; dotted, with shading between: friction bound ±f "
    "p; solid: shear q on body 2; where bodies move along z, dash-dotted: q_z along it. Where the "
    "solid line, or the length of both together, is on the dotted one, the contact slips or has "
    "just slipped. The two states are the load extremes: largest and smallest K_T at the "
    "edge where it varies most (Q if no edge has it), in the evaluated cycle or, if there is none, "
    "in the whole history."
)
# Of the load extremes, in the order of time.
EXTREMES = (BLUE, VERMILLION)
# Points between a panel and its title for each row of the legend, which stands there.
TITLE_PAD = 50.0 / 3
LOCAL_INTRO = (
    "At the edges, in the evaluated cycle or in the whole history without one. Above: range of "
    "the slip, twice its amplitude. Below: friction work per area; the integral of p over the way "
    "that slips, which times a wear rate is the depth of wear after Archard; and the largest shear "
    "times the range of the slip, the first parameter of Ruiz. Means around each node. They tell "
    "where fretting damages the surface; life depends on the stress below it too."
)
# Body 1 and body 2, as lines and as markers at the edge.
BODY_LINES = ("--", "-")
BODY_MARKERS = ("s", "o")
STRESS_INTRO = (
    "At both edges, largest values in the evaluated cycle, under irregular loads in the worst one; "
    "dashed: body 1, solid: body 2. Above: stress along the surface, at the surface and at the "
    "depths that the case asks for; markers with bars: at the edge itself, where it has a cusp of "
    "which nodes see the less the larger the elements are. Below: the parameter of Smith, Watson "
    "and Topper on its critical plane. At the surface next to an edge it depends on the mesh; at a "
    "depth of a few elements it does not."
)
SLIP_SYSTEMS_INTRO = (
    "Of cubic crystals, at both edges: largest range of the resolved shear stress in the evaluated "
    "cycle, under irregular loads in the worst one, above of the 12 systems {111}⟨110⟩, below of "
    "the 6 systems {001}⟨110⟩; dashed: body 1, solid: body 2. At the surface next to an edge it "
    "depends on the mesh; at a depth of a few elements it does not."
)
SLIP_SYSTEMS = ("{111}⟨110⟩", "{001}⟨110⟩")
# By status, the direction of slip, and whether there is friction; from light to dark in grey too.
KINDS = {
    OPEN: ("open", "#FFFFFF"),
    STICK: ("sticks", PALE),
    SLIP: ("slips, q > 0", SKY),
    SLIP + 1: ("slips, q < 0", VERMILLION),
    SLIP + 2: ("in contact, no friction", "#333333"),
}
# The windows at the edges are this many slip zones wide, and not less than this fraction of the
# half-width.
ZONES = 2.5
NARROWEST = 0.02
# More load steps are not drawn, nor the ends of more slip zones.
MOST_ROWS = 1500
MOST_ZONES = 50
NOT_KEPT = "the states are not kept:\n[output] tractions"
SLIP_INTRO = (
    "Each row is a load step. Body 1 slips over body 2 towards larger x where q > 0, towards "
    "smaller x where q < 0. Lines: the contact edges. Above: the whole contact and history, with "
    "the evaluated cycle between dashed lines. Below: the edges in the evaluated cycle, or in "
    "the whole history if there is none; circles mark the inner ends of the slip zones found, "
    "crosses those predicted. A row in which the load reverses may show slip beyond the circle; it "
    "is too small to count."
)
ENVELOPE_INTRO = (
    " If loads are irregular, the lower panels show how far each point slips to and fro in the "
    "evaluated cycle, or in the whole history if there is none; grey: points that stick at all "
    "times. Circles and crosses belong to the worst counted cycle."
)


def traction_plot(shown: Shown) -> Plot:
    """p, ±f p and q along a contact."""
    run = shown.run
    solution = run.solution

    def draw(figure: Figure) -> None:
        _draw_contact(figure.subplots(), run.case, solution, shown.tractions, shown.summary)

    return make_plot(f"{shown.key}-tractions", shown.title, "", SINGLE, draw)


def draw_tractions(
    panels: list[Axes], case: Case, solution: Solution, contacts: tuple[Contact, ...]
) -> None:
    """Draw p, f p and q along every contact at the two load extremes, one panel per contact."""
    for panel, history, summary in zip(panels, solution.contacts, contacts, strict=True):
        _draw_contact(panel, case, solution, history, summary)
        name_contact(panel, f"{summary.name}: {history.body1} on {history.body2}")


def _draw_contact(
    panel: Axes, case: Case, solution: Solution, history: ContactHistory, summary: Contact
) -> None:
    """Draw p, f p and q along a contact at the two load extremes."""
    for state, colour in zip(load_extremes([summary], solution.cycle), EXTREMES, strict=False):
        shown = _around_contact(history, state)
        pressure, *shears = history.mean_traction[state, shown].T
        bound = history.friction.at(state, shown) * pressure
        time = f"t = {solution.times[state]:g} {case.units.time}"
        draw_lines(panel, history.surface.arc[shown], (pressure, bound, *shears), time, colour)
    finish_lines(panel, f"x along the contact [{case.units.length}]", case.units)


def draw_lines(
    panel: Axes, x: Array, values: Sequence[Array], time: str, colour: str, across: str = "q_z"
) -> None:
    """Draw p, ±f p and q of a state.

    Args:
        panel: to draw in.
        x: (n,) places.
        values: p, f p, q along x, and across it if there is such a shear; (n,) each.
        time: of the state, for the legend.
        colour: of the state.
        across: name of the shear across x.
    """
    pressure, bound, shear, *others = values
    panel.plot(x, pressure, color=colour, lw=1.6, ls=(0, (4, 1.5)), label=f"p, {time}")
    panel.fill_between(x, -bound, bound, color=colour, alpha=0.12, lw=0)
    panel.plot(x, bound, color=colour, lw=1.0, ls=":", label=f"±f p, {time}")
    panel.plot(x, -bound, color=colour, lw=1.0, ls=":")
    panel.plot(x, shear, color=colour, lw=1.6, label=f"q, {time}")
    for each in others:
        panel.plot(x, each, color=colour, lw=1.2, ls="-.", label=f"{across}, {time}")


def finish_lines(panel: Axes, across: str, units: Units) -> None:
    """Names of the axes, and the legend above them."""
    panel.axhline(0, color=GREY, lw=0.6)
    panel.set_xlabel(across)
    panel.set_ylabel(f"p, q [{units.stress}]")
    legend_above(panel, columns=2)


def name_contact(panel: Axes, title: str) -> None:
    """Write a title above the legend."""
    lines = len(panel.get_legend_handles_labels()[1]) // 2
    panel.set_title(title, loc="left", pad=TITLE_PAD * lines)


def _around_contact(history: ContactHistory, state: int) -> Bools:
    """Nodes of the contact at a state and a little beyond."""
    closed = history.surface.arc[history.traction[state, :, 0] > 0]
    if not len(closed):
        return np.ones(len(history.surface.arc), dtype=bool)
    margin = 0.05 * np.ptp(closed)
    return (history.surface.arc >= closed[0] - margin) & (
        history.surface.arc <= closed[-1] + margin
    )


def local_plot(shown: Shown) -> Plot | None:
    """Local parameters along a contact; None if not all states are kept, or nothing slips."""
    if not shown.run.solution.keeps(*shown.run.loads.evaluated):
        return None
    found = shown.run.local_parameters(shown.tractions.name)
    if not (found.slip_range > shown.run.solution.least_slip.max()).any():
        return None
    units = shown.run.case.units
    most = int(np.argmax(found.work))
    scale, unit = with_prefix(units.length, float(found.slip_range.max()))
    caption = (
        f"Most friction work: {number(found.work[most])} {shown.run.unit('density')} at x = "
        f"{number(shown.tractions.surface.arc[most])} {units.length}, where the slip ranges over "
        f"{number(found.slip_range[most] / scale)} {unit}."
    )
    return make_plot(
        f"{shown.key}-local",
        shown.title,
        caption,
        DOUBLE,
        lambda figure: _draw(figure, shown, found),
    )


def _draw(figure: Figure, shown: Shown, found: LocalParameters) -> None:
    units, arc = shown.run.case.units, shown.tractions.surface.arc
    scale, unit = with_prefix(units.length, float(found.slip_range.max()))
    labels = (f"range of slip [{unit}]", f"[{shown.run.unit('density')}]")
    for (top, bottom), _, (low, high) in _edge_columns(figure, shown, labels):
        seen = (arc >= low) & (arc <= high)
        slip = found.slip_range[seen] / scale
        top.plot(arc[seen], slip, ".-", color="black", lw=1.2, ms=4, markevery=sparse(slip))
        for values, colour, style, label in (
            (found.work, BLUE, "-", "friction work"),
            (found.pressed_path, GREEN, "--", "p times slip"),
            (found.ruiz, VERMILLION, ":", "q times range"),
        ):
            bottom.plot(arc[seen], values[seen], style, color=colour, lw=1.4, label=label)
    # Next to the panels that it belongs to.
    figure.legend(*bottom.get_legend_handles_labels(), loc="outside lower center", ncols=3)


def _edge_columns(
    figure: Figure, shown: Shown, labels: tuple[str, str]
) -> Iterator[tuple[Sequence[Axes], Station | None, tuple[float, float]]]:
    """Two panels next to each edge, to be drawn into, with the edge and what is seen of x.

    Without edges they are over all of the contact.
    """
    edges = shown.summary.edges or (None,)
    panels = figure.subplots(2, len(edges), sharex="col", sharey="row", squeeze=False)
    for column, edge in zip(panels.T, edges, strict=True):
        window, title = _limits(shown, np.empty(0)), "the whole contact"
        if edge is not None:
            window, title = edge_window(shown, edge, *shown.run.loads.evaluated), edge_title(edge)
        yield column, edge, window
        finish_edge_column(column, title, window, shown.run.case.units.length)
    for panel, label in zip(panels[:, 0], labels, strict=True):
        panel.set_ylabel(label)


def stress_plot(shown: Shown) -> Plot | None:
    """Stress and its parameter along a contact; None if the run did not write any."""
    if not shown.run.has_stress:
        return None
    history = shown.run.stress_history(shown.tractions.pair)
    edges = [each for each in history.edges if each.contact == shown.tractions.name]
    return make_plot(
        f"{shown.key}-stress",
        shown.title,
        _stress_caption(shown, edges),
        DOUBLE,
        lambda figure: _draw_stress(figure, shown, history, edges),
    )


def _stress_caption(shown: Shown, edges: list[EdgeStress]) -> str:
    unit = shown.run.case.units.stress
    known, missing = [], []
    for each in edges:
        found = each.largest
        if found.reason:
            missing.append(f"not known at the {each.edge} edge of {each.body}: {found.reason}")
        else:
            value = with_error(found.value, found.spread)
            known.append(f"{value} {unit} ({each.edge} edge, {each.body})")
    return "Largest stress along the surface at the edges: " + "; ".join([*known, *missing]) + "."


def _draw_stress(
    figure: Figure, shown: Shown, history: StressHistory, edges: list[EdgeStress]
) -> None:
    units = shown.run.case.units
    labels = (f"σ along the surface [{units.stress}]", f"SWT [{units.stress}]")
    for column, edge, (low, high) in _edge_columns(figure, shown, labels):
        seen = history.at(np.flatnonzero((history.arc >= low) & (history.arc <= high)))
        for place, body in enumerate(seen.bodies):
            found = stress_parameters(seen, place, shown.run.case.bodies[body.name])
            _depth_lines(column, seen, (found.largest_tension, found.swt), place, units.length)
        if edge is not None:
            own = [each for each in edges if each.edge == edge.front]
            _edge_values(column[0], edge, own, history)
    _depth_legend(figure)


def _depth_lines(
    column: Sequence[Axes],
    seen: StressHistory,
    parameters: Sequence[Array],
    number: int,
    length: str,
) -> None:
    """Lines of the parameters (D, N) of one body at all depths, one parameter a panel."""
    for place, depth in enumerate(seen.depths):
        label = f"depth {depth:g} {length}" if depth > 0 else "surface"
        style: dict[str, Any] = {"color": CYCLE[place % len(CYCLE)], "lw": 1.2, "label": label}
        for axes, values in zip(column, parameters, strict=True):
            axes.plot(seen.arc, values[place], BODY_LINES[number], **style)


def _depth_legend(figure: Figure) -> None:
    """One entry a depth: the lines of the body that was drawn last."""
    handles, labels = figure.axes[0].get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    figure.legend(named.values(), named.keys(), loc="outside upper center", ncols=4)


def slip_system_plot(shown: Shown) -> Plot | None:
    """Resolved shear on slip systems along a contact; None without stress of a cubic crystal."""
    if not shown.run.has_stress:
        return None
    run, history = shown.run, shown.run.stress_history(shown.tractions.pair)
    ranges = [resolved_shear(each.stress, run.case.bodies[each.name]) for each in history.bodies]
    found = {place: each for place, each in enumerate(ranges) if np.isfinite(each).any()}
    if not found:
        return None

    def draw(figure: Figure) -> None:
        octahedral, cube = (f"{each} [{run.case.units.stress}]" for each in SLIP_SYSTEMS)
        for column, _, (low, high) in _edge_columns(figure, shown, (octahedral, cube)):
            nodes = np.flatnonzero((history.arc >= low) & (history.arc <= high))
            for place, parts in found.items():
                seen = [each[:, nodes] for each in parts]
                _depth_lines(column, history.at(nodes), seen, place, run.case.units.length)
        _depth_legend(figure)

    texts = [
        f"{history.bodies[place].name}, {systems}: {_largest(values, history, run.case)}"
        for place, parts in found.items()
        for systems, values in zip(SLIP_SYSTEMS, parts, strict=True)
    ]
    caption = "Largest ranges: " + "; ".join(texts) + "."
    return make_plot(f"{shown.key}-slip-systems", shown.title, caption, DOUBLE, draw)


def _largest(values: Array, history: StressHistory, case: Case) -> str:
    """The largest of some stresses (D, N), and where it is."""
    depth, node = np.unravel_index(np.nanargmax(values), values.shape)
    below = f", {number(history.depths[depth])} {case.units.length} below the surface"
    return (
        f"{number(values[depth, node])} {case.units.stress} at x = {number(history.arc[node])} "
        f"{case.units.length}{below if history.depths[depth] > 0 else ''}"
    )


def _edge_values(
    axes: Axes, edge: Station, found: list[EdgeStress], history: StressHistory
) -> None:
    """Markers with bars at the edge, body by body."""
    for place, each in enumerate(found):
        largest = each.largest
        if largest.reason:
            continue
        at = history.states[each.at_largest]
        axes.errorbar(
            [edge.position[at]], [largest.value], [largest.spread], marker=BODY_MARKERS[place],
            ms=4, mfc="white", color="black", capsize=2, lw=1.0,
        )  # fmt: skip


def draw_envelope(
    axes: Axes,
    shown: Shown,
    edge: Station,
    window: tuple[float, float],
    states: tuple[int, int],
    scale: float,
) -> None:
    """Range of the slip, over `scale`, next to an edge between two states, stick shaded."""
    axes.set_xlim(*window)
    solution = shown.run.solution
    if not solution.keeps(*states):
        say(axes, NOT_KEPT)
        return
    arc = shown.tractions.surface.arc
    slip, closed = _slip_range(shown, states)
    slip = slip / scale
    touched = slip > 0
    stuck = closed & (slip <= SMALLEST_SLIP * slip.max(initial=0.0))
    seen = (arc >= window[0]) & (arc <= window[1])
    axes.plot(arc[seen & touched], slip[seen & touched], ".-", ms=4, lw=1.2, color=BLUE)
    top = 1.08 * float(slip[seen].max(initial=0.0)) or 1.0
    axes.fill_between(arc, 0.0, top, where=stuck.tolist(), color=PALE, step="mid", lw=0)
    places = edge.position[states[0] : states[1] + 1]
    for end in {np.nanmin(places), np.nanmax(places)} if np.isfinite(places).any() else ():
        axes.axvline(end, color="black", lw=0.7)
    for zone in edge.slip_zones:
        _mark_zone(axes, edge, zone, 0.0)
    axes.set_ylim(0.0, top)
    plain_axis(axes, "y")


def _slip_range(shown: Shown, states: tuple[int, int]) -> tuple[Array, Bools]:
    """(N,) range of the slip of each node that is in contact at some time, and of those always."""
    tractions, (first, last) = shown.tractions, states
    count, line = len(tractions.surface.arc), shear_line(shown.summary, slice(first, last + 1))
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    always = np.ones(count, dtype=bool)
    for part in blocks(last - first, count):
        rows = slice(first + 1 + part.start, first + 1 + part.stop)
        closed, slip = tractions.status[rows] != OPEN, tractions.slip[rows] @ line
        always &= closed.all(axis=0)
        low = np.minimum(low, np.where(closed, slip, np.inf).min(axis=0))
        high = np.maximum(high, np.where(closed, slip, -np.inf).max(axis=0))
    return np.where(high >= low, high - low, 0.0), always


def slip_plot(shown: Shown) -> Plot:
    """Space-time map of a contact."""
    return make_plot(
        f"{shown.key}-slip", shown.title, "", DOUBLE, lambda figure: _draw_slip(figure, shown)
    )


def _draw_slip(figure: Figure, shown: Shown) -> None:
    near = [edge.front for edge in shown.summary.edges]
    rows: list[Any] = [["whole"] * len(near), near] if near else [["whole"]]
    panels = figure.subplot_mosaic(rows)
    times, units = shown.run.loads.times, shown.run.case.units
    first, last = shown.run.loads.evaluated
    positions = np.array([edge.position for edge in shown.summary.edges])
    _status_map(panels["whole"], shown, *_limits(shown, positions), (0, len(times) - 1))
    panels["whole"].set_ylim(times[0], times[-1])
    if shown.run.loads.cycle is not None:
        for time in times[[first, last]]:
            panels["whole"].axhline(time, color="black", lw=0.8, ls="--")
    irregular = any(edge.cycles.irregular for edge in shown.summary.edges)
    scale, unit = 1.0, units.length
    if irregular and shown.run.solution.keeps(first, last):
        scale, unit = with_prefix(unit, float(_slip_range(shown, (first, last))[0].max()))
    for edge in shown.summary.edges:
        axes = panels[edge.front]
        window = edge_window(shown, edge, first, last)
        if irregular:
            draw_envelope(axes, shown, edge, window, (first, last), scale)
        else:
            _status_map(axes, shown, *window, (first, last))
            zones = [zone for zone in edge.slip_zones if first < zone.end <= last]
            for zone in zones if len(zones) <= MOST_ZONES else ():
                _mark_zone(axes, edge, zone, times[zone.end])
            axes.set_ylim(times[first], times[last])
        axes.set_title(edge_title(edge))
        axes.tick_params(axis="x", labelrotation=30)
    for axes in panels.values():
        axes.set_xlabel(f"x [{units.length}]")
    panels["whole"].set_ylabel(f"time [{units.time}]")
    for front in near[:1]:
        below = f"range of slip [{unit}]" if irregular else f"time [{units.time}]"
        panels[front].set_ylabel(below)
    handles = [
        Patch(facecolor=colour, edgecolor="black", lw=0.4, label=name)
        for kind, (name, colour) in KINDS.items()
        if kind <= SLIP + 1 or not shown.tractions.friction.acts[1:].all()
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=3)


def _limits(shown: Shown, positions: Array) -> tuple[float, float]:
    """Limits of what was in contact at any time, and a little beyond."""
    arc, known = shown.tractions.surface.arc, positions[np.isfinite(positions)]
    touched = np.zeros(len(arc), dtype=bool)
    solution = shown.run.solution
    kept = np.arange(len(solution.times)) if solution.kept is None else solution.kept
    for part in blocks(len(kept), len(arc)):
        touched |= np.any(shown.tractions.status[kept[part]] != OPEN, axis=0)
    closed = arc[touched]
    places = np.concatenate([known, closed]) if len(closed) else arc
    margin = 0.04 * float(np.ptp(places) or np.ptp(arc))
    return max(places.min() - margin, arc[0]), min(places.max() + margin, arc[-1])


def edge_window(shown: Shown, edge: Station, first: int, last: int) -> tuple[float, float]:
    """Places that an edge and its slip zones reach in some states, and as much again."""
    places = edge.position[first : last + 1]
    half_width = np.nanmax(shown.summary.half_width, initial=0.0)
    zones = [zone for zone in edge.slip_zones[-2:] if zone.end > first]
    both = [length for z in zones for length in (z.length, edge.told_prediction(z))]
    lengths = [length for length in both if length > 0]
    depth = ZONES * max(lengths, default=0.0)
    if not np.isfinite(places).any() or any(zone.gross for zone in zones):
        return _limits(shown, np.array([each.position for each in shown.summary.edges]))
    low, high = np.nanmin(places), np.nanmax(places)
    depth = min(max(depth, high - low, NARROWEST * half_width), 2 * half_width)
    if depth == 0:  # no half-width is known
        return _limits(shown, places)
    below, above = (0.25 * depth, depth)[:: int(edge.inward)]
    return low - below, high + above


def _status_map(axes: Axes, shown: Shown, low: float, high: float, states: tuple[int, int]) -> None:
    """Colours of all nodes in the steps between two states, and the lines of the edges."""
    tractions, times = shown.tractions, shown.run.loads.times
    solution = shown.run.solution
    axes.set_xlim(low, high)
    if not solution.keeps(states[0] + 1, states[1]):
        say(axes, NOT_KEPT)
        return
    # Of a long history some steps, evenly spread: each row reaches from the one below.
    rows = np.unique(np.linspace(*states, min(states[1] - states[0], MOST_ROWS) + 1).astype(int))
    steps = rows[1:]
    kind = tractions.status[steps].astype(int)
    line = shear_line(shown.summary, slice(states[0], states[1] + 1))
    backward = tractions.traction[steps][..., 1:] @ line < 0
    kind = np.where((kind == SLIP) & backward, SLIP + 1, kind)
    frictionless = tractions.friction.at(steps) == 0
    kind = np.where(frictionless & (kind != OPEN), SLIP + 2, kind)
    # What still touches without a force slips in no direction.
    force = shown.summary.normal_force
    kind[~(force[steps] > NO_LOAD * np.nanmax(force, initial=0.0))] = OPEN
    arc = tractions.surface.arc
    borders = np.concatenate([[arc[0]], (arc[1:] + arc[:-1]) / 2, [arc[-1]]])
    seen = np.flatnonzero((borders[1:] >= low) & (borders[:-1] <= high))
    if not len(seen):
        say(axes, "No node of the surface is near this edge.")
        return
    nodes = slice(seen[0], seen[-1] + 1)
    axes.pcolormesh(
        borders[seen[0] : seen[-1] + 2],
        times[rows],
        kind[:, nodes],
        cmap=ListedColormap([colour for _, colour in KINDS.values()]),
        norm=BoundaryNorm(np.arange(len(KINDS) + 1) - 0.5, len(KINDS)),
        rasterized=True,
    )
    for edge in shown.summary.edges:
        seen = envelope(edge.position)
        axes.plot(edge.position[seen], times[seen], color="black", lw=0.7)


def _mark_zone(axes: Axes, edge: Station, zone: SlipZone, height: float) -> None:
    """The inner end of a slip zone as found and as predicted."""
    for length, mark in ((zone.length, "o"), (edge.told_prediction(zone), "x")):
        place = edge.position[zone.end] + edge.inward * length
        (point,) = axes.plot(place, height, mark, mfc="none", color="black", ms=6)
        # Whole at the first and last state too, beyond the frame.
        point.set(clip_on=False, in_layout=False)
