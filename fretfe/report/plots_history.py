# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads, edge factors and resultants over time, and the path of the loads on each contact."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.edges.front import ContactSummary
from fretfe.report.drawing import (
    BLUE,
    GREY,
    ORANGE,
    PALE,
    VERMILLION,
    Plot,
    legend_above,
    make_plot,
)
from fretfe.report.histories import fill_loads
from fretfe.report.states import span
from fretfe.results.reader import Results

FACTORS_INTRO = (
    "K_T belongs to the shear and is positive if that on body 2 points inward; K_I belongs to the "
    "changes of the pressure. Both are summed up from the first state, as if nothing slipped. "
    "While the contact grows much the sums are not the factors of its edge. Shaded: the evaluated "
    "cycle."
)
LOADS_INTRO = (
    "Shaded: the evaluated cycle. Load paths are those of the resultants P and Q of each contact, "
    "thick in the evaluated cycle, or everywhere without one, whose first state is the dot; on the "
    "dotted lines |Q| = f P the whole contact slides. σ0 is shown where it varies: the tension "
    "that gives half-planes the same mean of K_T over the two edges, counted from the first state."
)
# A tension that varies by less than this fraction of what matters is constant.
CONSTANT = 1e-3
# Inches for each load.
PANEL = 1.5


def load_plot(results: Results) -> Plot | None:
    """All loads over time, one panel each; None without loads."""
    history = results.result.history
    count = len(history.channels)
    if not count:
        return None
    return make_plot(
        "loads",
        "Loads",
        "As the case prescribes them; each dot is a load step.",
        0.6 + PANEL * count,
        lambda figure: _draw_loads(figure, results),
    )


def _draw_loads(figure: Figure, results: Results) -> None:
    history = results.result.history
    panels = figure.subplots(len(history.channels), 1, sharex=True, squeeze=False)[:, 0]
    fill_loads(list(panels), results.case, history)


def _over_time(axes: Axes, results: Results) -> None:
    """Shade the evaluated cycle."""
    history = results.result.history
    axes.set_xlim(0.0, history.times[-1] or 1.0)
    if history.cycle is not None:
        first, last = history.cycle
        axes.axvspan(history.times[first], history.times[last], color=PALE, lw=0)


def factor_plot(results: Results, contact: ContactSummary, key: str) -> Plot:
    """K_T and K_I of both edges over time."""
    return make_plot(
        f"{key}-factors",
        f"Contact {contact.name}",
        "",
        4.2,
        lambda figure: _draw_factors(figure, results, contact),
    )


def _draw_factors(figure: Figure, results: Results, contact: ContactSummary) -> None:
    panels = figure.subplots(2, 1, sharex=True)
    times, units = results.result.history.times, results.case.units
    for axes, name, label in zip(panels, ("k_t", "k_i"), ("K_T", "K_I"), strict=True):
        _over_time(axes, results)
        for edge, colour, style in zip(
            contact.stations, (BLUE, VERMILLION), (".-", "x--"), strict=True
        ):
            values = getattr(edge, name)
            axes.plot(times, values, style, ms=3, lw=1.0, color=colour, label=f"{edge.front} edge")
        axes.axhline(0, color=GREY, lw=0.6)
        axes.set_ylabel(f"{label} [{units.stress}·√{units.length}]")
    legend_above(panels[0], columns=2)
    panels[1].set_xlabel(f"time [{units.time}]")


def path_plot(results: Results, contact: ContactSummary, key: str) -> Plot:
    """Path of P and Q, and of Q and the tension if that varies."""
    tension = _tension_varies(results, contact)
    return make_plot(
        f"{key}-path",
        f"Load path, contact {contact.name}",
        "",
        3.4,
        lambda figure: _draw_path(figure, results, contact, tension),
    )


def _tension_varies(results: Results, contact: ContactSummary) -> bool:
    """Whether the tension changes K_T, next to what the shear force does.

    By (7a) of the theory guide 4Q/(π a) is the tension that changes it as much as Q.
    """
    first, last = span(results.result)
    tension = contact.effective_tension[first : last + 1]
    a = np.nanmax(contact.half_width, initial=0.0)
    scale = 4 * np.abs(contact.shear_force).max() / (np.pi * a) if a > 0 else 0.0
    return bool(np.ptp(tension) > CONSTANT * max(scale, np.abs(tension).max()))


def _draw_path(figure: Figure, results: Results, contact: ContactSummary, tension: bool) -> None:
    panels = figure.subplots(1, 1 + tension, squeeze=False, sharey=True)[0]
    units = results.case.units
    line_force = f"{units.force}/{units.length}"
    normal, shear = contact.normal_force, contact.shear_force
    _trace(panels[0], results, normal, shear)
    largest = max(float(np.max(normal)), 0.0)
    friction = results.case.contacts[contact.name].friction
    for sign in (1, -1):
        bound = [0.0, sign * friction * largest]
        panels[0].plot([0.0, largest], bound, color=GREY, lw=0.8, ls=":")
    panels[0].set_xlabel(f"P [{line_force}]")
    panels[0].set_ylabel(f"Q [{line_force}]")
    if tension:
        _trace(panels[1], results, contact.effective_tension, shear)
        panels[1].set_xlabel(f"σ0 [{units.stress}]")


def _trace(axes: Axes, results: Results, x: Array, y: Array) -> None:
    first, last = span(results.result)
    axes.plot(x, y, color=ORANGE, lw=0.8, ls="--")
    axes.plot(x[first : last + 1], y[first : last + 1], color=BLUE, lw=2.0)
    axes.plot(x[first], y[first], "o", color="black", ms=4)
    axes.axhline(0, color=GREY, lw=0.4)
