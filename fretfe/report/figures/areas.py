# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forces, areas, pressure and friction work of contacts of solids over time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.edges.area import AreaSummary
from fretfe.report.figures.history import time_panels
from fretfe.report.figures.plot import Plot, envelope, legend_above, make_plot
from fretfe.report.source import force_unit, work_unit
from fretfe.report.theme import BLUE, DOUBLE, GREEN, GREY, VERMILLION
from fretfe.results.model import Result

INTRO = (
    "P is the integral of the pressure, Q that of the shear that body 1 exerts on body 2, in the "
    "axes of the case. Each node counts with its whole area, so the areas grow in steps of an "
    "element. The largest pressure is a mean around a node; friction work is that of the step to "
    "each state. Shaded: the evaluated cycle."
)
# Of lines that are told apart.
STYLES = ((BLUE, "-", "o"), (VERMILLION, "--", "s"), (GREEN, ":", "^"))


def force_plot(run: Result, area: AreaSummary, key: str) -> Plot:
    """P above the components of Q."""

    def draw(figure: Figure) -> None:
        normal, shear = time_panels(figure, 2, run.case, run.loads)
        _lines(normal, run, {"P": area.normal_force})
        _lines(shear, run, dict(zip(("Q_x", "Q_y", "Q_z"), area.shear_force.T, strict=True)))
        normal.set_ylabel(f"P [{force_unit(run)}]")
        shear.set_ylabel(f"Q [{force_unit(run)}]")
        legend_above(shear, columns=3)

    return make_plot(f"{key}-forces", f"Forces, contact {area.name}", "", DOUBLE, draw)


def area_plot(run: Result, area: AreaSummary, key: str) -> Plot:
    """Areas, largest pressure and friction work, below each other."""
    units = run.case.units

    def draw(figure: Figure) -> None:
        areas, pressure, work = time_panels(figure, 3, run.case, run.loads)
        _lines(areas, run, {"in contact": area.contact_area, "sticks": area.stick_area})
        _lines(pressure, run, {"p_max": area.largest_pressure})
        _lines(work, run, {"work": area.work})
        areas.set_ylabel(f"area [{units.length}²]")
        pressure.set_ylabel(f"p_max [{units.stress}]")
        work.set_ylabel(f"work [{work_unit(run)}]")
        legend_above(areas, columns=2)
        figure.align_ylabels()

    return make_plot(
        f"{key}-areas", f"Areas, pressure and work, contact {area.name}", "", DOUBLE, draw
    )


def _lines(axes: Axes, run: Result, lines: Mapping[str, Array]) -> None:
    """Lines over time, by their labels."""
    for (label, values), (colour, line, mark) in zip(lines.items(), STYLES, strict=False):
        shown = envelope(values)
        marked = mark if len(shown) == len(values) else ""
        axes.plot(
            run.loads.times[shown], values[shown], ls=line, marker=marked, ms=2.5, lw=1.1,
            color=colour, label=label,
        )  # fmt: skip
    if any(np.min(values) < 0 for values in lines.values()):
        axes.axhline(0, color=GREY, lw=0.6)
