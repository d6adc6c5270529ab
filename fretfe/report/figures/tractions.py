# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressure and shear along the contacts at the two extremes of the load."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Bools
from fretfe.case import Case
from fretfe.edges.extremes import load_extremes
from fretfe.edges.front import ContactSummary
from fretfe.report.figures.plot import Plot, legend_above, make_plot
from fretfe.report.source import Shown
from fretfe.report.theme import BLUE, GREY, SINGLE, STYLE, VERMILLION, WIDTH
from fretfe.results.solution import ContactHistory, Solution

INTRO = (
    "Means around each node. Dotted: pressure p; dashed, with shading between: friction bound ±f "
    "p; solid: shear q on body 2. Where the solid line lies on the dashed one, the contact slips "
    "or has just slipped. The two states are the load extremes: largest and smallest K_T at the "
    "edge where it varies most, in the evaluated cycle or, if there is none, in the whole history."
)


# Points between a panel and its title: the three rows of the legend stand there.
TITLE_PAD = 50.0


def traction_plot(shown: Shown) -> Plot:
    """p, ±f p and q along a contact."""
    run = shown.run
    assert run.solution is not None
    solution = run.solution

    def draw(figure: Figure) -> None:
        _draw_contact(figure.subplots(), run.case, solution, shown.tractions, shown.summary)

    return make_plot(f"{shown.key}-tractions", shown.title, "", SINGLE, draw)


def draw_tractions(case: Case, solution: Solution, contacts: tuple[ContactSummary, ...]) -> Figure:
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
    panel: Axes, case: Case, solution: Solution, history: ContactHistory, summary: ContactSummary
) -> None:
    """Draw p, f p and q along a contact at the two load extremes."""
    stress, length = case.units.stress, case.units.length
    edges = summary.stations
    states = load_extremes([e.k_t for e in edges], [e.k_i for e in edges], solution.cycle)
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
