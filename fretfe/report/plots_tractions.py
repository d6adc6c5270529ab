# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressure and shear along a contact at the two extremes of the load."""

from __future__ import annotations

from matplotlib.figure import Figure

from fretfe.report.drawing import BLUE, GREY, VERMILLION, Plot, legend_above, make_plot
from fretfe.report.states import Shown, around_contact, edge_extremes, time_text

INTRO = (
    "Means around each node. Dotted: pressure p; dashed, shaded between: friction bound ±f p; "
    "full: shear q on body 2. Where the full line lies on the dashed one the contact slips or has "
    "just slipped. The two states are those in which K_T of the left edge is largest and smallest "
    "in the evaluated cycle; without a cycle the one in which it is largest in magnitude, and the "
    "last."
)


def traction_plot(shown: Shown) -> Plot:
    """p, ±f p and q along a contact."""
    return make_plot(
        f"{shown.key}-tractions", shown.name, "", 3.9, lambda figure: _draw(figure, shown)
    )


def _draw(figure: Figure, shown: Shown) -> None:
    axes = figure.subplots()
    units, history = shown.results.case.units, shown.history
    states = edge_extremes(shown.results.result, shown.summary.edges[0])
    for state, colour in zip(states, (BLUE, VERMILLION), strict=False):
        time = time_text(shown.results, state)
        nodes = around_contact(history, state)
        x = history.arc[nodes]
        pressure, shear = history.mean_traction[state, nodes, :2].T
        bound = history.friction[state] * pressure
        axes.plot(x, pressure, color=colour, lw=1.0, ls=":", label=f"p, {time}")
        axes.fill_between(x, -bound, bound, color=colour, alpha=0.1, lw=0)
        axes.plot(x, bound, color=colour, lw=0.8, ls="--", label=f"±f p, {time}")
        axes.plot(x, -bound, color=colour, lw=0.8, ls="--")
        axes.plot(x, shear, color=colour, lw=1.7, label=f"q, {time}")
    axes.axhline(0, color=GREY, lw=0.6)
    axes.set_xlabel(f"x along the contact [{units.length}]")
    axes.set_ylabel(f"p, q [{units.stress}]")
    legend_above(axes, columns=2)
