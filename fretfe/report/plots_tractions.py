# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressure and shear along a contact at the two extremes of the load."""

from __future__ import annotations

from matplotlib.figure import Figure

from fretfe.report.drawing import Plot, legend_above, make_plot
from fretfe.report.figures import draw_contact
from fretfe.report.states import Shown

INTRO = (
    "Means around each node. Dotted: pressure p; dashed, shaded between: friction bound ±f p; "
    "full: shear q on body 2. Where the full line lies on the dashed one the contact slips or has "
    "just slipped. The two states are the extremes of the load: largest and smallest K_T, at the "
    "edge where it varies most, in the evaluated cycle or in the whole history without one."
)


def traction_plot(shown: Shown) -> Plot:
    """p, ±f p and q along a contact."""
    return make_plot(
        f"{shown.key}-tractions", shown.name, "", 3.9, lambda figure: _draw(figure, shown)
    )


def _draw(figure: Figure, shown: Shown) -> None:
    axes = figure.subplots()
    results = shown.results
    assert results.solution is not None
    draw_contact(axes, results.case, results.solution, shown.history, shown.summary)
    legend_above(axes, columns=2)
