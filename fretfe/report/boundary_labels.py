# SPDX-License-Identifier: LGPL-3.0-or-later
"""Names of boundaries in two columns left and right of the bodies, each with a line to its place.

Sizes are in inches; nothing overlaps because the columns are as wide as their longest name and the
names in them keep their distance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D

from fretfe._typing import Array
from fretfe.results.model import BodyArrays

SPACING = 0.2
MARGIN = 0.12
# Height of a name above or below its place, if there is room.
OFFSET = 0.18
# Room for the lines between a column and the bodies.
LEADERS = 0.45
CLEARANCE = 0.05


@dataclass(frozen=True)
class Label:
    """The name of a boundary, and a place (2,) on it."""

    text: str
    place: Array


def boundary_labels(bodies: Mapping[str, BodyArrays]) -> list[Label]:
    """One label for each boundary of each body, at the facet nearest to the boundary's centre."""
    labels = []
    for body in bodies.values():
        for name, facets in body.boundaries.items():
            middles = body.points[facets[:, :2]].mean(axis=1)
            centre = (middles.min(axis=0) + middles.max(axis=0)) / 2
            nearest = np.linalg.norm(middles - centre, axis=1).argmin()
            labels.append(Label(name, body.points[facets[nearest, 0]]))
    return labels


def columns(labels: Sequence[Label]) -> tuple[list[Label], list[Label]]:
    """The left and the right half of the labels, each from bottom to top."""
    ordered = sorted(labels, key=lambda label: (label.place[0], label.place[1]))
    half = (len(ordered) + 1) // 2
    left, right = (
        sorted(part, key=lambda label: (label.place[1], label.text))
        for part in (ordered[:half], ordered[half:])
    )
    return left, right


def column_widths(figure: Figure, labels: Sequence[Label]) -> tuple[float, float]:
    """Width of both columns with their margins, in inches."""
    left, right = (
        MARGIN + _longest(figure, column) + LEADERS if column else MARGIN
        for column in columns(labels)
    )
    return left, right


def draw_labels(axes: Axes, labels: Sequence[Label], width: float, height: float) -> None:
    """Write the labels into axes of this size, whose limits are set."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    to_inches = axes.transData + axes.transAxes.inverted() + Affine2D().scale(width, height)
    from_inches = Affine2D().scale(1 / width, 1 / height) + axes.transAxes
    left, right = columns(labels)
    for column, sign, edge, align in ((left, 1, 0.0, "left"), (right, -1, width, "right")):
        places = [to_inches.transform(label.place) for label in column]
        # Lines to horizontal boundaries must not lie upon them.
        wanted = [y + (OFFSET if y > height / 2 else -OFFSET) for _, y in places]
        heights = spread(np.array(wanted), SPACING, SPACING, height - SPACING)
        knee = edge + sign * (MARGIN + _longest(figure, column) + CLEARANCE)
        for label, place, y in zip(column, places, heights, strict=True):
            x = edge + sign * MARGIN
            axes.text(x, y, label.text, transform=from_inches, ha=align, va="center")
            end = x + sign * (_width(figure, label.text) + CLEARANCE)
            line = np.array([(end, y), (knee, y), place])
            axes.plot(*line.T, transform=from_inches, color="black", linewidth=0.5)
            axes.plot(*place, ".", transform=from_inches, color="black", markersize=3, zorder=5)


def spread(wanted: Array, spacing: float, low: float, high: float) -> Array:
    """Places (n,) near sorted wanted ones, at least `spacing` apart, from `low` to `high`.

    If there is no room for that, they go beyond `low`.
    """
    places = wanted.copy()
    for i in range(len(places)):
        places[i] = max(places[i], places[i - 1] + spacing if i else low)
    for i in reversed(range(len(places))):
        limit = places[i + 1] - spacing if i + 1 < len(places) else high
        places[i] = min(places[i], limit)
    return places


def _longest(figure: Figure, labels: Sequence[Label]) -> float:
    return max((_width(figure, label.text) for label in labels), default=0.0)


def _width(figure: Figure, text: str) -> float:
    """Width of a text in the current font, in inches."""
    probe = figure.text(0.0, 0.0, text)
    width = probe.get_window_extent().width / figure.dpi
    probe.remove()
    return float(width)
