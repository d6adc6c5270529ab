# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plots as SVG that can stand in a page next to each other: ids of their own, no dates."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator

from fretfe._typing import Array, Indices
from fretfe.report.theme import GREY, MAP_DPI, STYLE, WIDTH

# A logarithmic axis over less than this factor has numbers between the powers of ten.
FEW_DECADES = 200
# Dots per inch of everything but images in an SVG file.
SVG_DPI = 72
# A long history is drawn by its extremes in so many parts, more than a figure has pixels.
BINS = 800
# Nothing of the day or the machine: the same results give the same file.
METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


@dataclass(frozen=True)
class Plot:
    """A plot in a page.

    Attributes:
        title: what it shows, in a few words.
        caption: what is said of it alone; may be empty.
        svg: the drawing, an `svg` element.
    """

    title: str
    caption: str
    svg: str


def make_plot(
    key: str, title: str, caption: str, height: float, draw: Callable[[Figure], None]
) -> Plot:
    """Draw a plot.

    Args:
        key: starts all ids in the drawing; a letter, then letters, digits and hyphens.
        title: of the plot.
        caption: what is said of it alone; may be empty.
        height: in inches; the width is the same for all.
        draw: draws into an empty figure.
    """
    with mpl.rc_context({**STYLE, "svg.hashsalt": key}), warnings.catch_warnings():
        # A unit in letters that the font does not have is drawn as boxes.
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        return Plot(title, caption, _svg(make_figure(WIDTH, height, draw), key))


def make_figure(width: float, height: float, draw: Callable[[Figure], None]) -> Figure:
    """Draw a figure of this size in inches in the style of all of them."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        draw(figure)
    return figure


def _svg(figure: Figure, key: str) -> str:
    """A figure as an `svg` element; all ids in it begin with the key."""
    canvas = FigureCanvasSVG(figure)
    # Everything has its place first; `Figure.savefig` would draw all of it once more for that.
    layout = figure.get_layout_engine()
    assert layout is not None
    figure.set_dpi(SVG_DPI)
    layout.execute(figure)
    figure.set_layout_engine("none")
    figure.set_dpi(MAP_DPI)
    buffer = io.StringIO()
    canvas.print_svg(buffer, metadata=METADATA)
    return _inline(buffer.getvalue(), key)


def _inline(svg: str, key: str) -> str:
    """The `svg` element of a file, with the key before all ids and references to them."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->|<style.*?</style>", "", svg, flags=re.DOTALL)
    # Hundredths of a point, a seventh of a thousandth of the width, are not to be seen.
    svg = re.sub(r' d="[^"]*"', lambda path: _shortened(path[0]), svg)
    svg = re.sub(r'\bid="', f'id="{key}-', svg)
    svg = re.sub(r'href="#', f'href="#{key}-', svg)
    svg = svg.replace("url(#", f"url(#{key}-")
    return re.sub(r"\n\s*\n+|\n +", "\n", svg).strip()


def _shortened(path: str) -> str:
    """Coordinates of a path to two decimals."""
    return re.sub(r"-?\d+\.\d{3,}", lambda found: f"{float(found[0]):.2f}", path)


def envelope(values: Array | Indices) -> Indices:
    """(m,) places of values (n,), increasing, that draw the same line: of many the extremes.

    All places if they are few; else the smallest and largest value of each of `BINS` parts.
    """
    count = len(values)
    if count <= 4 * BINS:
        return np.arange(count)
    known = np.where(np.isfinite(values), values, 0.0)
    parts = [slice(*part) for part in pairwise(np.linspace(0, count, BINS + 1).astype(int))]
    extremes = [
        part.start + np.array([known[part].argmin(), known[part].argmax()]) for part in parts
    ]
    return np.unique(np.concatenate([[0, count - 1], *extremes]))


def log_axis(axes: Axes, which: str) -> None:
    """A logarithmic axis, "x" or "y", with plain numbers; its limits must be known."""
    getattr(axes, f"set_{which}scale")("log")
    axis = getattr(axes, f"{which}axis")
    low, high = axis.get_view_interval()
    few = high < FEW_DECADES * low
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,), numticks=7))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(FuncFormatter(lambda *_: ""))


def plain_axis(axes: Axes, which: str) -> None:
    """A linear axis, "x" or "y", with whole numbers at its ticks: no factor or offset aside."""
    axis = getattr(axes, f"{which}axis")
    axis.set_major_locator(MaxNLocator(5))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))


def finish_edge_column(
    column: Sequence[Axes], title: str, limits: tuple[float, float], length: str
) -> None:
    """Title, zero lines and axes of panels above each other, over the place next to an edge."""
    column[0].set_title(title)
    column[-1].set_xlim(*limits)
    column[-1].set_xlabel(f"x [{length}]")
    column[-1].tick_params(axis="x", labelrotation=30)
    for axes in column:
        axes.axhline(0.0, color=GREY, lw=0.6)
        plain_axis(axes, "y")


def legend_above(axes: Axes, columns: int) -> None:
    """A legend above the axes, where it hides nothing."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.2)
