# SPDX-License-Identifier: LGPL-3.0-or-later
"""Figures over time: the loads, and the factors of the contact edges."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe.case import Case
from fretfe.edges.front import ContactSummary
from fretfe.loads import History
from fretfe.report.figures import STYLE

# Okabe and Ito's colours; lines beyond them begin again.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
WIDTH, PANEL_HEIGHT = 6.4, 2.4


def draw_loads(case: Case, history: History) -> Figure:
    """One panel for each load, in the units of its history; the evaluated cycle is shaded."""
    with mpl.rc_context(STYLE):
        figure, panels = _panels(len(history.channels))
        fill_loads(panels, case, history)
    return figure


def fill_loads(panels: list[Axes], case: Case, history: History) -> None:
    """Draw each load into a panel of its own."""
    for number, (name, panel) in enumerate(zip(history.channels, panels, strict=True)):
        panel.plot(history.times, history.values[:, number], color=COLOURS[0], marker=".", ms=4)
        panel.set_ylabel(f"{name} [{_unit(case, name)}]")
    _finish(case, history, panels)


def draw_factors(case: Case, history: History, contacts: tuple[ContactSummary, ...]) -> Figure:
    """K_N above K_T of every edge; the evaluated cycle is shaded."""
    units = case.units
    with mpl.rc_context(STYLE):
        figure, panels = _panels(2)
        edges = [(contact.name, edge) for contact in contacts for edge in contact.stations]
        for number, (name, edge) in enumerate(edges):
            colour, label = COLOURS[number % len(COLOURS)], f"{name}, {edge.front} edge"
            panels[0].plot(history.times, edge.k_n, color=colour, label=label)
            panels[1].plot(history.times, edge.k_t, color=colour)
        panels[0].set_ylabel(f"K_N [{units.stress}/√{units.length}]")
        panels[1].set_ylabel(f"K_T [{units.stress}·√{units.length}]")
        panels[0].legend(frameon=False, fontsize=8)
        _finish(case, history, panels)
    return figure


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(WIDTH, 0.5 + PANEL_HEIGHT * count), layout="constrained")
    return figure, list(figure.subplots(count, 1, sharex=True, squeeze=False).ravel())


def _finish(case: Case, history: History, panels: list[Axes]) -> None:
    for panel in panels:
        if history.cycle is not None:
            first, last = (float(history.times[state]) for state in history.cycle)
            panel.axvspan(first, last, color="#000000", alpha=0.06, lw=0)
    panels[-1].set_xlabel(f"t [{case.units.time}]")


def _unit(case: Case, name: str) -> str:
    """Unit of a load's history."""
    load, units = case.loads[name], case.units
    if load.type == "traction":
        return units.stress
    if load.type == "rotation":
        return f"1/{units.time}"
    prescribed = load.type == "displacement" or load.control == "displacement"
    return units.length if prescribed else units.force
