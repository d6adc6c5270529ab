# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads, edge factors and resultants over time, and the path of the loads on each contact."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.edges.front import ContactSummary
from fretfe.loads import History
from fretfe.report.figures.plot import Plot, envelope, legend_above, make_plot
from fretfe.report.source import edge_title, load_unit
from fretfe.report.theme import (
    BLUE,
    CYCLE,
    DOUBLE,
    GREY,
    LOAD,
    ORANGE,
    PALE,
    SINGLE,
    STYLE,
    WIDTH,
)
from fretfe.results.model import Result

FACTORS_INTRO = (
    "K_T belongs to the shear and is positive if the shear on body 2 points inward; K_I belongs to "
    "the changes of the pressure. Both are summed from the first state, as if nothing slipped. "
    "While the contact grows much, the sums are not the factors of its edge. Shaded: the evaluated "
    "cycle."
)
LOADS_INTRO = (
    "Shaded: the evaluated cycle. Load paths are those of the resultants P and Q of each contact, "
    "thick in the evaluated cycle (or everywhere if there is none), with a dot at its first state. "
    "On the dotted lines |Q| = f P the whole contact slides. σ0 is shown if it varies: it is the "
    "tension that gives half-planes the same mean of K_T over the two edges, counted from the "
    "first state."
)
# A tension that varies by less than this fraction of what matters is constant.
CONSTANT = 1e-3


def load_plot(run: Result) -> Plot | None:
    """All loads over time, one panel each; None without loads."""
    if not run.loads.channels:
        return None
    caption = "As prescribed in the case; each dot is a load step."
    height = LOAD * (len(run.loads.channels) + 0.4)
    return make_plot(
        "loads", "Loads", caption, height, lambda figure: _draw_loads(figure, run.case, run.loads)
    )


def draw_loads(case: Case, history: History) -> Figure:
    """One panel for each load, in the units of its history; the evaluated cycle is shaded."""
    with mpl.rc_context(STYLE):
        height = LOAD * (len(history.channels) + 0.4)
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        _draw_loads(figure, case, history)
    return figure


def _draw_loads(figure: Figure, case: Case, history: History) -> None:
    panels = time_panels(figure, len(history.channels), case, history)
    for panel, name, values in zip(panels, history.channels, history.values.T, strict=True):
        shown = envelope(values)
        mark = ".-" if len(shown) == len(values) else "-"
        panel.plot(history.times[shown], values[shown], mark, ms=4, color=BLUE)
        panel.set_ylabel(f"{name} [{load_unit(case, name)}]")


def factor_plot(run: Result, contact: ContactSummary, key: str) -> Plot:
    """K_T and K_I of both edges over time."""

    def draw(figure: Figure) -> None:
        _draw_factors(figure, run.case, run.loads, (contact,), {"k_t": "K_T", "k_i": "K_I"})

    return make_plot(f"{key}-factors", f"Contact {contact.name}", "", DOUBLE, draw)


def draw_factors(case: Case, history: History, contacts: tuple[ContactSummary, ...]) -> Figure:
    """K_N above K_T of every edge; the evaluated cycle is shaded."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, DOUBLE), layout="constrained")
        _draw_factors(figure, case, history, contacts, {"k_n": "K_N", "k_t": "K_T"})
    return figure


def _draw_factors(
    figure: Figure,
    case: Case,
    history: History,
    contacts: tuple[ContactSummary, ...],
    names: dict[str, str],
) -> None:
    """One panel for each factor, by the name of its attribute, with a line for each edge."""
    stress, root = case.units.stress, f"√{case.units.length}"
    panels = time_panels(figure, len(names), case, history)
    edges = [(contact.name, edge) for contact in contacts for edge in contact.stations]
    for panel, (name, label) in zip(panels, names.items(), strict=True):
        for number, (contact, edge) in enumerate(edges):
            title = edge_title(edge) if len(contacts) == 1 else f"{contact}, {edge_title(edge)}"
            values = getattr(edge, name)
            states = envelope(values)
            marks = ("x--", ".-") if len(states) == len(values) else ("--", "-")
            panel.plot(
                history.times[states],
                values[states],
                marks[0 if number % 2 else 1],
                ms=3,
                lw=1.0,
                color=CYCLE[number % len(CYCLE)],
                label=title,
            )
        panel.axhline(0, color=GREY, lw=0.6)
        panel.set_ylabel(f"{label} [{stress}{'/' if name == 'k_n' else '·'}{root}]")
    legend_above(panels[0], columns=2)


def time_panels(figure: Figure, count: int, case: Case, history: History) -> list[Axes]:
    """Panels over time with the evaluated cycle shaded, below each other."""
    panels = list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    for panel in panels:
        panel.set_xlim(0.0, history.times[-1] or 1.0)
        if history.cycle is not None:
            first, last = history.cycle
            panel.axvspan(history.times[first], history.times[last], color=PALE, alpha=0.6, lw=0)
    panels[-1].set_xlabel(f"time [{case.units.time}]")
    return panels


def path_plot(run: Result, contact: ContactSummary, key: str) -> Plot:
    """Path of P and Q, and of Q and the tension if that varies."""
    tension = _tension_varies(run, contact)
    return make_plot(
        f"{key}-path",
        f"Load path, contact {contact.name}",
        "",
        SINGLE,
        lambda figure: _draw_path(figure, run, contact, tension),
    )


def _tension_varies(run: Result, contact: ContactSummary) -> bool:
    """Whether the tension changes K_T, next to what the shear force does.

    By (7a) of the theory guide 4Q/(π a) is the tension that changes it as much as Q.
    """
    first, last = run.loads.evaluated
    tension = contact.effective_tension[first : last + 1]
    a = np.nanmax(contact.half_width, initial=0.0)
    scale = 4 * np.abs(contact.shear_force).max() / (np.pi * a) if a > 0 else 0.0
    return bool(np.ptp(tension) > CONSTANT * max(scale, np.abs(tension).max()))


def _draw_path(figure: Figure, run: Result, contact: ContactSummary, tension: bool) -> None:
    panels = figure.subplots(1, 1 + tension, squeeze=False, sharey=True)[0]
    units = run.case.units
    line_force = f"{units.force}/{units.length}"
    normal, shear = contact.normal_force, contact.shear_force
    _trace(panels[0], run, normal, shear)
    largest = max(float(np.max(normal)), 0.0)
    friction = run.case.contacts[contact.pair].friction
    for sign in (1, -1):
        bound = [0.0, sign * friction * largest]
        panels[0].plot([0.0, largest], bound, color=GREY, lw=0.8, ls=":")
    panels[0].set_xlabel(f"P [{line_force}]")
    panels[0].set_ylabel(f"Q [{line_force}]")
    if tension:
        _trace(panels[1], run, contact.effective_tension, shear)
        panels[1].set_xlabel(f"σ0 [{units.stress}]")


def _trace(axes: Axes, run: Result, x: Array, y: Array) -> None:
    first, last = run.loads.evaluated
    for states, colour, width, line in (
        (slice(0, len(x)), ORANGE, 0.8, "--"),
        (slice(first, last + 1), BLUE, 2.0, "-"),
    ):
        seen = np.union1d(envelope(x[states]), envelope(y[states]))
        axes.plot(x[states][seen], y[states][seen], color=colour, lw=width, ls=line)
    axes.plot(x[first], y[first], "o", color="black", ms=4)
    axes.axhline(0, color=GREY, lw=0.4)
