# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressure, shear and local parameters of fretting along the contacts."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Bools
from fretfe.case import Case
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.resultants import load_extremes
from fretfe.evaluate.stress import LocalParameters
from fretfe.history.solution import ContactHistory, Solution
from fretfe.report.figures.plot import Plot, finish_edge_column, legend_above, make_plot
from fretfe.report.figures.slip import edge_window
from fretfe.report.source import Shown, edge_title
from fretfe.report.texts import number
from fretfe.report.theme import BLUE, DOUBLE, GREEN, GREY, SINGLE, STYLE, VERMILLION, WIDTH

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
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH * columns, SINGLE * rows), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel, history, summary in zip(panels, solution.contacts, contacts, strict=False):
            _draw_contact(panel, case, solution, history, summary)
            title = f"{summary.name}: {history.body1} on {history.body2}"
            panel.set_title(title, loc="left", pad=TITLE_PAD)
        for panel in panels[len(contacts) :]:
            panel.set_axis_off()
    return figure


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
