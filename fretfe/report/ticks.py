# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ticks of plots, drawn as a line and some texts for each axis.

Matplotlib makes five artists for each tick and asks all of them in each pass of a layout: that took
more than half of the time of a plot. Places and numbers are still those of its locators and
formatters, and both axes look as the style says of ticks of x.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.report.plotting import (
    TICKDOWN,
    TICKLEFT,
    Axes,
    Axis,
    Figure,
    FontProperties,
    Line2D,
    LineCollection,
    NullLocator,
    ScaledTranslation,
    mpl,
    text_to_path,
)


@dataclass(frozen=True)
class _Ticks:
    """Ticks of one axis.

    Attributes:
        axes: that has it.
        which: "x" or "y".
        major, minor: places that are seen.
        numbers: texts at the major ones; empty ones if they are not shown.
    """

    axes: Axes
    which: str
    major: Array
    minor: Array
    numbers: Sequence[str]

    @property
    def axis(self) -> Axis:
        """Axis of Matplotlib."""
        axis: Axis = getattr(self.axes, f"{self.which}axis")
        return axis

    @property
    def rotation(self) -> float:
        """Degrees by which the numbers are turned."""
        return float(self.axis.get_tick_params().get("rotation", 0.0))

    def depth(self) -> float:
        """Points from the axes to the far side of the numbers."""
        turned, size = math.radians(self.rotation), mpl.rcParams["xtick.labelsize"]
        font = FontProperties(family=mpl.rcParams["font.family"], size=size)
        # A line of text has the height of letters that reach highest and lowest.
        sizes = [text_to_path.get_text_width_height_descent(n, font, False) for n in self.numbers]
        height = text_to_path.get_text_width_height_descent("lp", font, False)[1]
        along, across = abs(math.cos(turned)), abs(math.sin(turned))
        if self.which == "x":
            along, across = across, along
        reach = max((width * along for width, _, _ in sizes), default=0.0) + height * across
        return _beyond_marks() + reach if any(self.numbers) else mpl.rcParams["xtick.major.size"]


def _beyond_marks() -> float:
    """Points from the axes to the near side of the numbers."""
    return mpl.rcParams["xtick.major.size"] + mpl.rcParams["xtick.major.pad"]


def draw_ticks(figure: Figure) -> None:
    """Draw the ticks of all axes whose limits are final, and place the names of the axes.

    Names of panels below or beside each other are aligned. Axes with ticks on other sides, or with
    a factor that all numbers share, are left to Matplotlib.
    """
    found = [
        ticks
        for axes in figure.axes
        for which in "xy"
        if (ticks := _ticks(axes, which)) is not None
    ]
    # Panels may share locators: none is taken away before all have been asked.
    for ticks in found:
        ticks.axes.autoscale(False)
        ticks.axis.set_major_locator(NullLocator())
        ticks.axis.set_minor_locator(NullLocator())
    depths: dict[tuple[str, int], float] = {}
    for ticks in found:
        place = _place(ticks)
        depths[place] = max(depths.get(place, 0.0), ticks.depth())
    for ticks in found:
        _draw(ticks)
        _place_name(ticks, depths[_place(ticks)])


def _ticks(axes: Axes, which: str) -> _Ticks | None:
    """Ticks of an axis; None where Matplotlib has to draw them."""
    axis: Axis = getattr(axes, f"{which}axis")
    sides, side = axis.get_tick_params(), {"x": "bottom", "y": "left"}[which]
    if not axes.axison or not sides[side] or axes.get_subplotspec() is None:
        return None
    places, formatter = (
        np.asarray(axis.get_majorticklocs(), dtype=float),
        axis.get_major_formatter(),
    )
    numbers = formatter.format_ticks(places.tolist())
    if formatter.get_offset():
        return None
    major = _seen(axis, places)
    minor = np.asarray(axis.get_minorticklocs(), dtype=float)
    shown = np.where(sides[f"label{side}"], np.array(numbers, dtype=str), "")[major].tolist()
    return _Ticks(axes, which, places[major], minor[_seen(axis, minor)], shown)


def _seen(axis: Axis, places: Array) -> Array:
    """True for places (n,) within the limits of an axis."""
    low, high = np.sort(axis.get_transform().transform(np.asarray(axis.get_view_interval())))
    at, margin = axis.get_transform().transform(places), 1e-9 * (high - low)
    return np.asarray((at >= low - margin) & (at <= high + margin))


def _place(ticks: _Ticks) -> tuple[str, int]:
    """Panels whose names of axes are aligned: those of a column for y, of a row for x."""
    cells = ticks.axes.get_subplotspec()
    assert cells is not None
    return ticks.which, cells.colspan.start if ticks.which == "y" else cells.rowspan.stop


def _draw(ticks: _Ticks) -> None:
    axes, across = ticks.axes, ticks.which == "x"
    transform = axes.get_xaxis_transform() if across else axes.get_yaxis_transform()
    look = mpl.rcParams
    for places, length, width in (
        (ticks.major, look["xtick.major.size"], look["xtick.major.width"]),
        (ticks.minor, look["xtick.minor.size"], look["xtick.minor.width"]),
    ):
        ends = places, np.zeros(len(places))
        marks: Any = {"marker": TICKDOWN if across else TICKLEFT, "ms": length, "mew": width}
        line = Line2D(
            *(ends if across else ends[::-1]), ls="", color="black", transform=transform,
            clip_on=False, **marks,
        )  # fmt: skip
        line.set_in_layout(False)
        axes.add_artist(line)
    _draw_grid(ticks)
    place = axes.get_xaxis_text1_transform if across else axes.get_yaxis_text1_transform
    moved, vertical, horizontal = place(_beyond_marks())
    style: Any = {
        "transform": moved, "va": vertical, "ha": horizontal, "rotation": ticks.rotation,
        "size": look["xtick.labelsize"],
    }  # fmt: skip
    for at, number in zip(ticks.major, ticks.numbers, strict=True):
        if number:
            x, y = (at, 0.0) if across else (0.0, at)
            axes.text(x, y, number, **style)


def _draw_grid(ticks: _Ticks) -> None:
    """Lines across the axes at the major ticks, where they were asked for."""
    look = ticks.axis.get_tick_params()
    if not look["gridOn"]:
        return
    axes, across = ticks.axes, ticks.which == "x"
    ends = np.stack(np.broadcast_arrays(ticks.major[:, None], [0.0, 1.0]), axis=-1)
    axes.add_collection(
        LineCollection(
            list(ends if across else ends[..., ::-1]), colors=look["grid_color"],
            linewidths=look["grid_lw"], zorder=0.5,
            transform=axes.get_xaxis_transform() if across else axes.get_yaxis_transform(),
        ),
        autolim=False,
    )  # fmt: skip


def _place_name(ticks: _Ticks, depth: float) -> None:
    """Put the name of an axis beyond numbers that reach so many points from the axes."""
    figure = ticks.axes.get_figure(root=True)
    assert figure is not None
    away = -(depth + ticks.axis.labelpad) / 72
    across = ticks.which == "x"
    offset = (0.0, away) if across else (away, 0.0)
    moved = ticks.axes.transAxes + ScaledTranslation(*offset, figure.dpi_scale_trans)
    ticks.axis.set_label_coords(*((0.5, 0.0) if across else (0.0, 0.5)), transform=moved)
