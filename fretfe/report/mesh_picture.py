# SPDX-License-Identifier: LGPL-3.0-or-later
"""A picture of a plane mesh: the bodies with all their elements, and each contact enlarged."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.report.boundary_labels import SPACING, boundary_labels, column_widths, draw_labels
from fretfe.report.outlines import boundary_curves, cell_outlines
from fretfe.results.model import BodyArrays

STYLE: Any = {"font.size": 9, "axes.linewidth": 0.6, "axes.formatter.useoffset": False}
DPI = 160
# Tints that stay apart in grey; with more bodies they begin again.
TINTS = ("#CFE3F1", "#FBF0D9", "#DDDDDD")
ELEMENTS: dict[str, Any] = {"color": "#707070"}
# Line widths of elements of meshes with fewer cells than this, and with more.
MANY_CELLS, FEW_WIDTH, MANY_WIDTH = 20_000, 0.2, 0.12
# Okabe and Ito's colours; dark and solid under light and dashed, so that both are seen in grey too.
SURFACES: tuple[dict[str, Any], ...] = (
    {"color": "#0072B2", "linewidth": 3.4, "linestyle": "-"},
    {"color": "#E69F00", "linewidth": 1.7, "linestyle": (0, (3.0, 1.5))},
)
BOUNDARY: dict[str, Any] = {"color": "#202020", "linewidth": 1.4, "linestyle": (0, (1.0, 1.0))}

# Inches.
MAIN_HEIGHT = 6.4
# Of the bodies without the names beside them; they are at least as wide as this part of the height.
BODIES_WIDTH, BODIES_ASPECT = 4.8, 0.6
PANEL_WIDTH, PANEL_HEIGHT, TALLEST_PANEL = 3.6, 2.0, 3.6
TITLE_HEIGHT, AXIS_HEIGHT = 0.65, 0.55  # above and below the panel of a contact
LEFT, RIGHT, GAP, TOP = 0.8, 0.2, 0.9, 0.4
LEGEND_ROW, LEGEND_COLUMNS = 0.2, 3
ROWS = 4  # panels below each other before there is another column
# Around the surfaces of a contact and around the bodies, as a fraction of their size.
SURROUNDINGS = 0.08


def write_mesh_picture(path: Path, case: Case, bodies: Mapping[str, BodyArrays]) -> None:
    """Draw the bodies of a plane mesh, and the surroundings of each contact.

    Args:
        path: picture to write; its ending says which format.
        case: names the contacts and the unit of length.
        bodies: plane meshes, by body.
    """
    draw_mesh(case, bodies).savefig(path, dpi=DPI)


@mpl.rc_context(STYLE)
def draw_mesh(case: Case, bodies: Mapping[str, BodyArrays]) -> Figure:
    """The figure of `write_mesh_picture`."""
    columns = -(-len(case.contacts) // ROWS)
    rows = -(-len(case.contacts) // columns)
    labels = boundary_labels(bodies)
    height = max(
        MAIN_HEIGHT,
        rows * (PANEL_HEIGHT + TITLE_HEIGHT + AXIS_HEIGHT),
        (len(labels) / 2 + 3) * SPACING,
    )
    bottom = AXIS_HEIGHT + LEGEND_ROW * _legend_rows(bodies)
    figure = Figure(dpi=DPI)
    FigureCanvasAgg(figure)
    margins = column_widths(figure, labels)
    width = max(BODIES_WIDTH, BODIES_ASPECT * height) + sum(margins)
    figure.set_size_inches(
        LEFT + width + columns * (GAP + PANEL_WIDTH) + RIGHT, bottom + height + TOP
    )
    main = _axes(figure, (LEFT, bottom, width, height), case.units.length)
    points = np.concatenate([body.points for body in bodies.values()])
    _set_view(main, points, (width, height), margins)
    _draw(main, case, bodies)
    draw_labels(main, labels, width, height)
    main.set_title(case.title or "Mesh", loc="left", fontsize=11)
    _draw_contacts(figure, case, bodies, (LEFT + width + GAP, bottom, height, rows))
    _add_legend(figure, bodies)
    return figure


def _draw_contacts(
    figure: Figure,
    case: Case,
    bodies: Mapping[str, BodyArrays],
    grid: tuple[float, float, float, int],
) -> None:
    """One panel for each contact, in a grid: its left, bottom, height and number of rows."""
    left, bottom, height, rows = grid
    cell = (height + AXIS_HEIGHT) / rows
    size = (PANEL_WIDTH, min(cell - TITLE_HEIGHT - AXIS_HEIGHT, TALLEST_PANEL))
    for number, name in enumerate(case.contacts):
        column, row = divmod(number, rows)
        corner = (
            left + column * (PANEL_WIDTH + GAP),
            bottom + height - TITLE_HEIGHT - row * cell - size[1],
        )
        panel = _axes(figure, (*corner, *size), case.units.length)
        _draw_contact(panel, case, name, bodies, size)


def _axes(figure: Figure, box: tuple[float, float, float, float], unit: str) -> Axes:
    """Axes whose left, bottom, width and height are in inches."""
    width, height = figure.get_size_inches()
    left, bottom, wide, high = box
    axes = figure.add_axes((left / width, bottom / height, wide / width, high / height))
    axes.xaxis.set_major_locator(MaxNLocator(4, min_n_ticks=2))
    axes.yaxis.set_major_locator(MaxNLocator(5, min_n_ticks=2))
    axes.tick_params(length=2.5, width=0.6, labelsize=8)
    axes.set_xlabel(f"x [{unit}]", labelpad=2)
    axes.set_ylabel(f"y [{unit}]", labelpad=2)
    return axes


def _set_view(
    axes: Axes, points: Array, size: tuple[float, float], margins: tuple[float, float] = (0.0, 0.0)
) -> None:
    """Limits that show all points at the same scale in x and y.

    Args:
        axes: their limits are set.
        points: (n, 2) what has to be seen.
        size: width and height of the axes in inches.
        margins: inches to keep free on the left and on the right.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    border = SURROUNDINGS * (high - low).max()
    low, high = low - border, high + border
    room = np.array([size[0] - sum(margins), size[1]])
    per_inch = ((high - low) / room).max()
    centre = (low + high) / 2
    left = centre[0] - per_inch * (room[0] / 2 + margins[0])
    axes.set_xlim(left, left + per_inch * size[0])
    axes.set_ylim(centre[1] - per_inch * size[1] / 2, centre[1] + per_inch * size[1] / 2)


def _draw_contact(
    axes: Axes, case: Case, name: str, bodies: Mapping[str, BodyArrays], size: tuple[float, float]
) -> None:
    contact = case.contacts[name]
    surfaces = [contact.surface1, contact.surface2]
    curves = [
        curve
        for body in bodies.values()
        for surface in surfaces
        if surface in body.boundaries
        for curve in boundary_curves(body, surface)
    ]
    _set_view(axes, np.concatenate(curves), size)
    _draw(axes, case, bodies)
    heading = f"{name}\n1: {contact.surface1}\n2: {contact.surface2}"
    axes.set_title(heading, loc="left", fontsize=9, linespacing=1.1, pad=4)


def _draw(axes: Axes, case: Case, bodies: Mapping[str, BodyArrays]) -> None:
    """All that is within the limits of the axes; these stay."""
    limits = np.array([axes.get_xlim(), axes.get_ylim()]).T
    for number, body in enumerate(bodies.values()):
        _draw_cells(axes, body, TINTS[number % len(TINTS)], limits)
    styles = {}
    for contact in case.contacts.values():
        styles[contact.surface1], styles[contact.surface2] = SURFACES
    for body in bodies.values():
        for name in body.boundaries:
            style = styles.get(name, BOUNDARY)
            # Wide lines first: narrow ones are seen upon them.
            order = 4 - style["linewidth"] / 4
            lines = LineCollection(boundary_curves(body, name), capstyle="butt", **_plural(style))
            axes.add_collection(lines, autolim=False)
            lines.set_zorder(order)


def _plural(style: dict[str, Any]) -> dict[str, Any]:
    return {f"{key}s": value for key, value in style.items()}


def _draw_cells(axes: Axes, body: BodyArrays, tint: str, limits: Array) -> None:
    outlines, boxes = cell_outlines(body)
    shown = (boxes[:, 0] < limits[1]).all(axis=1) & (boxes[:, 1] > limits[0]).all(axis=1)
    width = FEW_WIDTH if np.count_nonzero(shown) < MANY_CELLS else MANY_WIDTH
    starts = np.cumsum([len(part) for part in outlines])[:-1]
    for part, seen in zip(outlines, np.split(shown, starts), strict=True):
        axes.add_collection(
            PolyCollection(
                part[seen], facecolors=tint, edgecolors=ELEMENTS["color"], linewidths=width
            ),
            autolim=False,
        )


def _legend_rows(bodies: Mapping[str, BodyArrays]) -> int:
    return -(-(len(bodies) + len(SURFACES) + 1) // LEGEND_COLUMNS)


def _add_legend(figure: Figure, bodies: Mapping[str, BodyArrays]) -> None:
    handles: list[Any] = [
        Patch(
            facecolor=TINTS[number % len(TINTS)],
            edgecolor=ELEMENTS["color"],
            label=f"{name}, {len(body.cells)} {body.cell}s of order {body.order}",
        )
        for number, (name, body) in enumerate(bodies.items())
    ]
    texts = ("surface 1 of a contact", "surface 2 of a contact", "other boundaries with a name")
    handles += [
        Line2D([], [], label=text, **style)
        for text, style in zip(texts, (*SURFACES, BOUNDARY), strict=True)
    ]
    width, height = figure.get_size_inches()
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(LEFT / width, 0.08 / height),
        ncols=LEGEND_COLUMNS,
        frameon=False,
        fontsize=9,
        handlelength=3.5,
        borderaxespad=0.0,
    )
