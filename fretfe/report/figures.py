# SPDX-License-Identifier: LGPL-3.0-or-later
"""Figures of tractions."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Bools
from fretfe.case import Case
from fretfe.edges.extremes import load_extremes
from fretfe.edges.front import ContactSummary
from fretfe.results.solution import ContactHistory, Solution

# Two colours that stay apart for colour-blind readers and in grey (Okabe and Ito).
EXTREME_COLOURS = ("#0072B2", "#D55E00")
PRESSURE_COLOUR = "#555555"
STYLE: Any = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False}


def draw_tractions(case: Case, solution: Solution, contacts: tuple[ContactSummary, ...]) -> Figure:
    """Draw p, f p and q along every contact at the two load extremes, one panel per contact."""
    with mpl.rc_context(STYLE):
        columns = min(2, len(contacts))
        rows = -(-len(contacts) // columns)
        figure = Figure(figsize=(6.4 * columns, 4.2 * rows), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel, history, summary in zip(panels, solution.contacts, contacts, strict=False):
            draw_contact(panel, case, solution, history, summary)
            panel.set_title(f"{summary.name}: {history.body1} on {history.body2}")
            panel.legend(frameon=False, fontsize=8)
        for panel in panels[len(contacts) :]:
            panel.set_axis_off()
    return figure


def draw_contact(
    panel: Axes, case: Case, solution: Solution, history: ContactHistory, summary: ContactSummary
) -> None:
    """Draw p, f p and q along a contact at the two load extremes, without title and legend."""
    stress, length = case.units.stress, case.units.length
    edges = summary.stations
    states = load_extremes([e.k_t for e in edges], [e.k_i for e in edges], solution.cycle)
    for state, colour in zip(states, EXTREME_COLOURS, strict=False):
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
    panel.axhline(0, color=PRESSURE_COLOUR, lw=0.6)
    panel.set_xlabel(f"x along the contact [{length}]")
    panel.set_ylabel(f"p, q [{stress}]")


def _around_contact(history: ContactHistory, state: int) -> Bools:
    """Nodes of the contact at a state and a little beyond."""
    closed = history.arc[history.traction[state, :, 0] > 0]
    if not len(closed):
        return np.ones(len(history.arc), dtype=bool)
    margin = 0.05 * np.ptp(closed)
    return (history.arc >= closed[0] - margin) & (history.arc <= closed[-1] + margin)
