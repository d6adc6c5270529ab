# SPDX-License-Identifier: LGPL-3.0-or-later
"""Along the contacts: tractions, local parameters of fretting, and the stress at the surface."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Bools
from fretfe.case import Case
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.resultants import load_extremes
from fretfe.evaluate.stress import (
    EdgeStress,
    LocalParameters,
    StressHistory,
    StressParameters,
    stress_parameters,
)
from fretfe.history.solution import ContactHistory, Solution
from fretfe.report.figures.plot import (
    Plot,
    finish_edge_column,
    legend_above,
    make_figure,
    make_plot,
)
from fretfe.report.figures.slip import edge_window
from fretfe.report.source import Shown, edge_title
from fretfe.report.texts import number, with_error
from fretfe.report.theme import BLUE, CYCLE, DOUBLE, GREEN, GREY, SINGLE, VERMILLION, WIDTH

INTRO = (
    "Means around each node. Dotted: pressure p; dashed, with shading between: friction bound ±f "
    "p; solid: shear q on body 2. Where the solid line lies on the dashed one, the contact slips "
    "or has just slipped. The two states are the load extremes: largest and smallest K_T at the "
    "edge where it varies most, in the evaluated cycle or, if there is none, in the whole history."
)
# Points between a panel and its title: the three rows of the legend stand there.
TITLE_PAD = 50.0
LOCAL_INTRO = (
    "At both edges, in the evaluated cycle or in the whole history without one. Above: range of "
    "the slip, twice its amplitude. Below: friction work per area; the integral of p over the way "
    "that slips, which times a wear rate is the depth of wear after Archard; and the largest shear "
    "times the range of the slip, the first parameter of Ruiz. Means around each node. They tell "
    "where fretting damages the surface; life depends on the stress below it too."
)
# Body 1 and body 2, as lines and as markers at the edge.
BODY_LINES, BODY_MARKERS = ("--", "-"), ("s", "o")
STRESS_INTRO = (
    "At both edges, largest values in the evaluated cycle, under irregular loads in the worst one; "
    "dashed: body 1, solid: body 2. Above: stress along the surface, at the surface and at the "
    "depths that the case asks for; markers with bars: at the edge itself, where it has a cusp of "
    "which nodes see the less the larger the elements are. Below: the parameter of Smith, Watson "
    "and Topper on its critical plane. At the surface next to an edge it depends on the mesh; at a "
    "depth of a few elements it does not."
)


def traction_plot(shown: Shown) -> Plot:
    """p, ±f p and q along a contact."""
    run = shown.run
    assert run.solution is not None
    solution = run.solution

    def draw(figure: Figure) -> None:
        _draw_contact(figure.subplots(), run.case, solution, shown.tractions, shown.summary)

    return make_plot(f"{shown.key}-tractions", shown.title, "", SINGLE, draw)


def draw_tractions(case: Case, solution: Solution, contacts: tuple[Contact, ...]) -> Figure:
    """Draw p, f p and q along every contact at the two load extremes, one panel per contact."""
    columns = min(2, len(contacts))
    rows = -(-len(contacts) // columns)

    def draw(figure: Figure) -> None:
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel, history, summary in zip(panels, solution.contacts, contacts, strict=False):
            _draw_contact(panel, case, solution, history, summary)
            title = f"{summary.name}: {history.body1} on {history.body2}"
            panel.set_title(title, loc="left", pad=TITLE_PAD)
        for panel in panels[len(contacts) :]:
            panel.set_axis_off()

    return make_figure(WIDTH * columns, SINGLE * rows, draw)


def _draw_contact(
    panel: Axes, case: Case, solution: Solution, history: ContactHistory, summary: Contact
) -> None:
    """Draw p, f p and q along a contact at the two load extremes."""
    stress, length = case.units.stress, case.units.length
    states = load_extremes([summary], solution.cycle)
    for state, colour in zip(states, (BLUE, VERMILLION), strict=False):
        time = f"t = {solution.times[state]:g} {case.units.time}"
        shown = _around_contact(history, state)
        x = history.arc[shown]
        pressure, shear = history.mean_traction[state, shown, :2].T
        bound = history.friction[state] * pressure
        panel.plot(x, pressure, color=colour, lw=0.8, ls=":", label=f"p, {time}")
        panel.fill_between(x, -bound, bound, color=colour, alpha=0.12, lw=0)
        panel.plot(x, bound, color=colour, lw=0.8, ls="--", label=f"±f p, {time}")
        panel.plot(x, -bound, color=colour, lw=0.8, ls="--")
        panel.plot(x, shear, color=colour, lw=1.6, label=f"q, {time}")
    panel.axhline(0, color=GREY, lw=0.6)
    panel.set_xlabel(f"x along the contact [{length}]")
    panel.set_ylabel(f"p, q [{stress}]")
    legend_above(panel, columns=2)


def _around_contact(history: ContactHistory, state: int) -> Bools:
    """Nodes of the contact at a state and a little beyond."""
    closed = history.arc[history.traction[state, :, 0] > 0]
    if not len(closed):
        return np.ones(len(history.arc), dtype=bool)
    margin = 0.05 * np.ptp(closed)
    return (history.arc >= closed[0] - margin) & (history.arc <= closed[-1] + margin)


def local_plot(shown: Shown) -> Plot | None:
    """Local parameters along a contact; None if not all states are kept, or nothing slips."""
    assert shown.run.solution is not None
    if not shown.run.solution.keeps(*shown.run.loads.evaluated):
        return None
    found = shown.run.local_parameters(shown.tractions.name)
    if not found.slip_range.any():
        return None
    units = shown.run.case.units
    most = int(np.argmax(found.work))
    caption = (
        f"Most friction work: {number(found.work[most])} {units.force}/{units.length} at "
        f"x = {number(shown.tractions.arc[most])} {units.length}, where the slip ranges over "
        f"{number(found.slip_range[most])} {units.length}."
    )
    return make_plot(
        f"{shown.key}-local",
        shown.title,
        caption,
        DOUBLE,
        lambda figure: _draw(figure, shown, found),
    )


def _draw(figure: Figure, shown: Shown, found: LocalParameters) -> None:
    panels = figure.subplots(2, 2, sharex="col", sharey="row")
    units, arc = shown.run.case.units, shown.tractions.arc
    for column, edge in zip(panels.T, shown.summary.stations, strict=True):
        top, bottom = column
        low, high = edge_window(shown, edge, *shown.run.loads.evaluated)
        seen = (arc >= low) & (arc <= high)
        top.plot(arc[seen], found.slip_range[seen], ".-", color=BLUE, lw=1.2, ms=4)
        for values, colour, style, label in (
            (found.work, BLUE, "-", "friction work"),
            (found.pressed_path, GREEN, "--", "p times slip"),
            (found.ruiz, VERMILLION, ":", "q times range"),
        ):
            bottom.plot(arc[seen], values[seen], style, color=colour, lw=1.4, label=label)
        finish_edge_column(column, edge_title(edge), (low, high), units.length)
    panels[0, 0].set_ylabel(f"range of slip [{units.length}]")
    panels[1, 0].set_ylabel(f"[{units.force}/{units.length}]")
    handles, labels = panels[1, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)


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
    known = [each for each in edges if not each.reason]
    texts = [
        f"{with_error(*each.largest)} {unit} ({each.edge} edge, {each.body})" for each in known
    ]
    missing = [
        f"not known at the {each.edge} edge of {each.body}: {each.reason}"
        for each in edges
        if each.reason
    ]
    return "Largest stress along the surface at the edges: " + "; ".join([*texts, *missing]) + "."


def _draw_stress(
    figure: Figure, shown: Shown, history: StressHistory, edges: list[EdgeStress]
) -> None:
    panels = figure.subplots(2, 2, sharex="col", sharey="row")
    units = shown.run.case.units
    for column, edge in zip(panels.T, shown.summary.stations, strict=True):
        top, bottom = column
        low, high = edge_window(shown, edge, *shown.run.loads.evaluated)
        seen = history.at(np.flatnonzero((history.arc >= low) & (history.arc <= high)))
        for place, body in enumerate(seen.bodies):
            material = shown.run.case.bodies[body.name]
            found = stress_parameters(seen, place, material)
            _stress_lines(top, bottom, seen, found, place, units.length)
        _edge_values(top, edge, [each for each in edges if each.edge == edge.front], history)
        finish_edge_column(column, edge_title(edge), (low, high), units.length)
    panels[0, 0].set_ylabel(f"σ along the surface [{units.stress}]")
    panels[1, 0].set_ylabel(f"SWT [{units.stress}]")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4)


def _stress_lines(
    top: Axes, bottom: Axes, seen: StressHistory, found: StressParameters, number: int, length: str
) -> None:
    """Lines of one body at all depths."""
    for place, depth in enumerate(found.depths):
        colour = CYCLE[place % len(CYCLE)]
        text = f"depth {depth:g} {length}" if depth > 0 else "surface"
        label = text if number == 1 else None
        for axes, values in ((top, found.largest_tension), (bottom, found.swt)):
            axes.plot(
                seen.arc, values[place], BODY_LINES[number], color=colour, lw=1.2, label=label
            )


def _edge_values(
    axes: Axes, edge: Station, found: list[EdgeStress], history: StressHistory
) -> None:
    """Markers with bars at the edge, body by body."""
    for place, each in enumerate(found):
        if each.reason:
            continue
        value, spread = each.largest
        at = history.states[int(np.nanargmax(each.value))]
        axes.errorbar(
            [edge.position[at]], [value], [spread], marker=BODY_MARKERS[place], ms=4, mfc="white",
            color=CYCLE[0], capsize=2, lw=1.0,
        )  # fmt: skip
