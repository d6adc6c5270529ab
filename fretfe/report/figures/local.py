# SPDX-License-Identifier: LGPL-3.0-or-later
"""Local parameters of fretting along the contacts, in the evaluated cycle."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from fretfe.edges.local_parameters import LocalParameters
from fretfe.report.figures.plot import Plot, make_plot, plain_axis
from fretfe.report.figures.slip import edge_window
from fretfe.report.source import Shown, edge_title
from fretfe.report.texts import number
from fretfe.report.theme import BLUE, DOUBLE, GREEN, GREY, VERMILLION

INTRO = (
    "At both edges, in the evaluated cycle or in the whole history without one. Above: range of "
    "the slip, twice its amplitude. Below: friction work per area; the integral of p over the way "
    "that slips, which times a wear rate is the depth of wear after Archard; and the largest shear "
    "times the range of the slip, the first parameter of Ruiz. Means around each node. They tell "
    "where fretting damages the surface; life depends on the stress below it too."
)


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
        top.set_title(edge_title(edge))
        bottom.set_xlim(low, high)
        bottom.set_xlabel(f"x [{units.length}]")
        bottom.tick_params(axis="x", labelrotation=30)
        for axes in column:
            axes.axhline(0.0, color=GREY, lw=0.6)
            plain_axis(axes, "y")
    panels[0, 0].set_ylabel(f"range of slip [{units.length}]")
    panels[1, 0].set_ylabel(f"[{units.force}/{units.length}]")
    handles, labels = panels[1, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
