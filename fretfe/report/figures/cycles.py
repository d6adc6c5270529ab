# SPDX-License-Identifier: LGPL-3.0-or-later
"""Counted cycles of an edge under irregular loads: numbers by range, and from where to where."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fretfe.evaluate.contacts import CountedCycles, Station
from fretfe.report.figures.plot import Plot, log_axis, make_plot, plain_axis
from fretfe.report.source import Shown, edge_title
from fretfe.report.texts import number
from fretfe.report.theme import BLUE, COLOURS, DOUBLE, GREY, VERMILLION

# Classes of ranges, and of K_T from and to.
CLASSES = 32
INTRO = (
    "Cycles of K_T, or of K_T ∓ f K_I where P varies, counted by the rainflow method (ASTM E1049). "
    "Above: the number of cycles in each class of ΔK_T; dashed: the worst cycle. Below: K_T at the "
    "reversals at which cycles begin and end; circle: the worst cycle, line: cycles without a "
    "range. The table has the worst cycle of each edge; cycles.csv has all of them."
)


def cycle_plot(shown: Shown, edge: Station) -> Plot | None:
    """Histogram and from-to matrix of an edge; None if its loads are regular."""
    if not edge.cycles.irregular:
        return None
    count = float(edge.cycles.count.sum())
    where = "each repetition" if edge.cycles.closed else "the history"
    return make_plot(
        f"{shown.key}-{edge.front}-cycles",
        f"Contact {shown.summary.name}, {edge_title(edge)}",
        f"{number(count)} cycles in {where}.",
        DOUBLE,
        lambda figure: _draw(figure, shown, edge),
    )


def _draw(figure: Figure, shown: Shown, edge: Station) -> None:
    top, bottom = figure.subplots(2, 1, height_ratios=(2, 3))
    units = shown.run.case.units
    unit = f"[{units.stress}·√{units.length}]"
    _histogram(top, edge.cycles)
    top.set_xlabel(f"ΔK_T {unit}")
    top.set_ylabel("cycles")
    _matrix(figure, bottom, edge)
    bottom.set_xlabel(f"to K_T {unit}")
    bottom.set_ylabel(f"from K_T {unit}")


def _histogram(axes: Axes, cycles: CountedCycles) -> None:
    """Counts by classes of the range; logarithmic, as small cycles are many."""
    counts, borders = np.histogram(
        cycles.k_t_range, CLASSES, (0.0, cycles.k_t_range.max()), weights=cycles.count
    )
    axes.bar(borders[:-1], counts, np.diff(borders), align="edge", color=BLUE, ec="white", lw=0.4)
    axes.set_ylim(0.4, 1.6 * max(counts.max(), 1.0))
    log_axis(axes, "y")
    axes.set_xlim(0.0, 1.04 * borders[-1])
    axes.axvline(cycles.k_t_range[cycles.worst], color=VERMILLION, ls="--", lw=1.0)
    plain_axis(axes, "x")


def _matrix(figure: Figure, axes: Axes, edge: Station) -> None:
    cycles = edge.cycles
    begin, end = edge.k_t[cycles.start], edge.k_t[cycles.end]
    limits = (min(begin.min(), end.min()), max(begin.max(), end.max()))
    counts, rows, columns = np.histogram2d(
        begin, end, CLASSES, (limits, limits), weights=cycles.count
    )
    image = axes.pcolormesh(
        columns,
        rows,
        np.ma.masked_equal(counts, 0.0),
        cmap=f"{COLOURS}_r",
        vmin=0.0,
        rasterized=True,
    )
    axes.plot(limits, limits, color=GREY, lw=0.6)
    worst = end[cycles.worst], begin[cycles.worst]
    (point,) = axes.plot(*worst, "o", mfc="none", color=VERMILLION, ms=8)
    # Whole in a corner too, where the worst cycle is.
    point.set(clip_on=False, in_layout=False)
    axes.set_aspect("equal")
    for which in ("x", "y"):
        plain_axis(axes, which)
    bar = figure.colorbar(image, ax=axes, label="cycles")
    bar.ax.yaxis.set_major_locator(MaxNLocator(4, integer=True))
