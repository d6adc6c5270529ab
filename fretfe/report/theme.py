# SPDX-License-Identifier: LGPL-3.0-or-later
"""One look for all figures and pictures, and plots as SVG that stand in a page.

Colours are those of Okabe and Ito, which stay apart for colour-blind readers. Lines that mean
different things differ in their style too, for print in grey. Plots stand in a page next to each
other: they have ids of their own, and no dates.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.files import replacing
from fretfe.report.plotting import (
    AutoLocator,
    Axes,
    Figure,
    FigureCanvasSVG,
    FuncFormatter,
    LogLocator,
    MaxNLocator,
    NullFormatter,
    NullLocator,
    mpl,
    withStroke,
)
from fretfe.report.texts import RAISED

BLUE = "#0072B2"
VERMILLION = "#D55E00"
GREEN = "#009E73"
ORANGE = "#E69F00"
SKY = "#56B4E9"
PURPLE = "#CC79A7"
GREY = "#555555"
PALE = "#E4E4E4"
# Of lines of equal rank; with more of them the colours begin again, with other markers.
CYCLE = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
MARKERS = "os^Dv"
# Perceptually uniform, and in order for colour-blind readers and in grey.
COLOURS = "viridis"
# Tints of bodies, which stay apart in grey; with more bodies they begin again.
TINTS = ("#CFE3F1", "#FBF0D9", "#DDDDDD")
# Lines of bodies and elements, as arguments of a collection.
OUTLINE: dict[str, Any] = {"colors": "#202020", "linewidths": 0.7}
UNDEFORMED: dict[str, Any] = {"colors": "#808080", "linewidths": 0.6, "linestyles": "dotted"}
ELEMENTS: dict[str, Any] = {"colors": "#8A8A8A", "linewidths": 0.5}
# Dark and solid under light and dashed, so that both surfaces of a contact are seen in grey too.
SURFACES: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "linewidth": 3.4, "linestyle": "-"},
    {"color": ORANGE, "linewidth": 1.7, "linestyle": (0, (3.0, 1.5))},
)
BOUNDARY: dict[str, Any] = {"color": "#202020", "linewidth": 1.4, "linestyle": (0, (1.0, 1.0))}
# Light around dark lines and texts: they are seen on every colour.
HALO: Any = [withStroke(linewidth=2.4, foreground="white")]

# Inches. A plot of the page, of which three stand side by side (96 pixels an inch), and a picture,
# of which two do.
WIDTH = 3.7
PICTURE_WIDTH = 5.8
PICTURE_HEIGHT = 6.0
# Height of a plot with little in it, of one panel, of each load, of two and of three panels.
LOW = 2.3
SINGLE = 2.6
LOAD = 1.2
DOUBLE = 3.7
TRIPLE = 4.9
# Dots per inch of maps within plots, of pictures, and of figures that are files of their own.
MAP_DPI = 200
PICTURE_DPI = 240
FILE_DPI = 150
# Points: headings, and texts that come second.
HEADING = 11.0
SMALL_TEXT = 7.8

STYLE: Any = {
    "font.size": 8.5,
    "font.family": "DejaVu Sans",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.titlesize": 8.5,
    "axes.formatter.useoffset": False,
    "figure.titlesize": HEADING,
    "xtick.labelsize": 8.5,
    "xtick.major.width": 0.7,
    "ytick.labelsize": 8.5,
    "ytick.major.width": 0.7,
    "legend.frameon": False,
    "legend.fontsize": SMALL_TEXT,
    "legend.columnspacing": 1.2,
    "legend.handlelength": 2.0,
    "lines.linewidth": 1.4,
    # Names and units are a user's: a dollar sign in them starts no formula.
    "text.parse_math": False,
    # Text as outlines: looks the same everywhere, whatever fonts there are.
    "svg.fonttype": "path",
    "svg.image_inline": True,
}
# Around maps and images of bodies: a frame, and small ticks.
FRAMED: Any = {
    **STYLE,
    "figure.constrained_layout.h_pad": 0.08,
    "figure.constrained_layout.w_pad": 0.08,
    "font.size": 8.0,
    "figure.titlesize": 9.0,
    "axes.spines.top": True,
    "axes.spines.right": True,
    "axes.titlesize": 8.0,
    "axes.titlelocation": "left",
    "axes.titlepad": 4.0,
    "axes.labelpad": 2.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.fontsize": 8.0,
    "legend.handlelength": 3.0,
}
# Intervals of linear axes.
TICKS = 5
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
        for axes in figure.axes:
            _finish(axes)
        figure.align_labels()
    return figure


def _finish(axes: Axes) -> None:
    for axis in (axes.xaxis, axes.yaxis):
        if isinstance(locator := axis.get_major_locator(), AutoLocator):
            locator.set_params(nbins=TICKS)
    for spine in axes.spines.values():
        # It ends where its axes do; to find that out takes its ticks anew each time.
        spine.set_in_layout(False)


def draw_in(
    ax: Axes | Iterable[Axes] | None,
    count: int,
    columns: int,
    height: float,
    draw: Callable[[list[Axes]], None],
    *,
    sharex: bool = False,
) -> tuple[Axes, ...]:
    """Draw in axes of a user, or in a new figure of pyplot, which notebooks and `show` display.

    Args:
        ax: the axes, or None for a new figure.
        count: of panels.
        columns: of a new figure.
        height: of each of its rows in inches.
        draw: draws into the panels.
        sharex: whether the panels of a new figure have one axis across.

    Returns:
        The panels.

    Raises:
        OutputError: if the axes are more or fewer.
    """
    with mpl.rc_context(STYLE):
        if ax is None:
            from matplotlib import pyplot as plt

            rows = -(-count // columns)
            figure = plt.figure(figsize=(WIDTH * columns, height * rows), layout="constrained")
            every = figure.subplots(rows, columns, sharex=sharex, squeeze=False).ravel()
            panels = list(every[:count])
            for panel in every[count:]:
                panel.remove()
        else:
            panels = [ax] if isinstance(ax, Axes) else list(np.ravel(np.array(ax, dtype=object)))
        if len(panels) != count or not all(isinstance(each, Axes) for each in panels):
            raise OutputError(f"ax: expected {count} axes, one for each panel, found {len(panels)}")
        draw(panels)
        for axes in panels:
            _finish(axes)
    return tuple(panels)


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


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure that is a file of its own.

    Args:
        figure: to be written.
        path: of the file; its ending says which format.

    Raises:
        OSError: if it cannot be written.
    """
    with replacing(path, path.suffix) as new:
        figure.savefig(new, dpi=FILE_DPI)


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


def sparse(values: Array) -> float | None:
    """Part of a panel's diagonal within which a line over values (n,) has one mark.

    None, for all marks, if no value is known: Matplotlib fails to space those of no points.
    """
    return 0.012 if np.isfinite(values).any() else None


def log_axis(axes: Axes, which: str) -> None:
    """A logarithmic axis, "x" or "y", with plain numbers; its limits must be known."""
    getattr(axes, f"set_{which}scale")("log")
    axis = getattr(axes, f"{which}axis")
    low, high = axis.get_view_interval()
    few = high < FEW_DECADES * low
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,), numticks=7))
    axis.set_major_formatter(FuncFormatter(lambda value, _: _power(value)))
    # No more than show the axis to be logarithmic.
    axis.set_minor_locator(NullLocator() if few else LogLocator(subs=(2.0, 5.0), numticks=7))
    axis.set_minor_formatter(NullFormatter())


def _power(value: float) -> str:
    """A number at a tick; small and large powers of ten as such."""
    if 1e-4 < abs(value) < 1e6:
        return f"{value:g}"
    digit, _, exponent = f"{value:.0e}".partition("e")
    factor = "" if digit == "1" else f"{digit}·"
    return f"{factor}10{str(int(exponent)).translate(RAISED)}"


def plain_axis(axes: Axes, which: str) -> None:
    """A linear axis, "x" or "y", with whole numbers at its ticks: no factor or offset aside."""
    axis = getattr(axes, f"{which}axis")
    axis.set_major_locator(MaxNLocator(TICKS))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))


def say(axes: Axes, text: str) -> None:
    """A text in the middle of axes that show nothing else."""
    style: Any = {"ha": "center", "va": "center", "bbox": {"fc": "white", "ec": "none"}}
    axes.text(0.5, 0.5, text, transform=axes.transAxes, **style)


def say_if_unknown(axes: Axes, least: int = 1) -> None:
    """Say so in axes none of whose lines has so many known values; their numbers mean nothing."""
    values = (np.asarray(line.get_ydata(), dtype=float) for line in axes.lines)
    if max((np.count_nonzero(np.isfinite(each)) for each in values), default=0) < least:
        say(axes, "unknown: the warnings say why")
        axes.set_yticks([])


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
