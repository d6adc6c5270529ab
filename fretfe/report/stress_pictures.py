# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of the stress in the bodies: at the load extremes, and enlarged at the contact edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe.report.field_files import EDGES, BodyField
from fretfe.report.picture_frames import (
    STYLE,
    WIDTH,
    draw_bar,
    draw_lines,
    largest_grid,
    name_axes,
    panels,
    set_limits,
    set_title,
    show_image,
)
from fretfe.report.picture_plan import EdgePlace
from fretfe.report.picture_scale import (
    EDGE_ASPECT,
    colour_limit,
    deformation_scale,
    edge_view,
    surroundings,
)
from fretfe.report.picture_source import Source
from fretfe.report.picture_texts import load_text, rounded
from fretfe.report.scene import COLOURS, Scene
from fretfe.report.view import View

# Of the area that is shown, per cent that stay below the last colour.
BODIES_PERCENTAGE, EDGES_PERCENTAGE = 99.8, 98.0

OUTLINE: dict[str, Any] = {"colors": "#202020", "linewidths": 0.7}
UNDEFORMED: dict[str, Any] = {"colors": "#808080", "linewidths": 0.6, "linestyles": "dotted"}
ELEMENTS: dict[str, Any] = {"colors": "#8A8A8A", "linewidths": 0.35}


@dataclass(frozen=True)
class Look:
    """How bodies are drawn, the same at several states.

    Attributes:
        scale: of the displacements.
        limit: stress of the last colour.
        largest: stress in any element.
        view: what is seen.
    """

    scale: float
    limit: float
    largest: float
    view: View


def find_look(source: Source, states: Sequence[int]) -> Look:
    """The look that suits some states."""
    fields = [body for state in states for body in source.bodies(state).values()]
    contacts = [source.result.contact_history(each.name) for each in source.result.contacts]
    scale = deformation_scale(fields, contacts, states)
    limit, largest = colour_limit([(body, None) for body in fields], BODIES_PERCENTAGE)
    view = surroundings([body.deformed(factor) for body in fields for factor in (0.0, scale)])
    return Look(scale, limit, largest, view)


@mpl.rc_context(STYLE)
def draw_bodies(
    source: Source, states: Sequence[int], look: Look, scene: Scene, width: float = WIDTH
) -> Figure:
    """All bodies at some states, one panel each; the picture is `width` inches wide at most."""
    view = look.view
    aspect = float(view.half_size[1] / view.half_size[0])
    grid = largest_grid(len(states), aspect, bar=True, most=width)
    heading = f"Von Mises stress, displacements × {look.scale:g}"
    figure, axes = panels(grid, len(states), heading)
    for panel, state in zip(axes, states, strict=True):
        bodies = list(source.bodies(state).values())
        set_limits(panel, view.origin, view.half_size)
        show_image(panel, scene.image(bodies, look.scale, view, grid.panel))
        draw_lines(panel, [body.points[body.outline] for body in bodies], **UNDEFORMED)
        draw_lines(panel, [body.deformed(look.scale)[body.outline] for body in bodies], **OUTLINE)
        name_axes(panel, "x", "y", source.numbers["units"]["length"])
        set_title(panel, source.when(state), load_text(source.numbers, state))
    draw_bar(figure, grid, COLOURS, look.limit, _bar_label(source))
    return figure


def bodies_caption(source: Source, states: Sequence[int], look: Look) -> str:
    """What the picture of `draw_bodies` shows."""
    times = " and ".join(source.when(state) for state in states)
    drawn = f"drawn {look.scale:g} times as large" if look.scale > 1 else "as they are"
    return (
        f"Von Mises equivalent stress of the bodies at {times}; displacements {drawn}, dotted: "
        f"before deformation. {_colour_text(source, look.limit, look.largest, BODIES_PERCENTAGE)}"
    )


@mpl.rc_context(STYLE)
def draw_edges(source: Source, state: int, edges: Sequence[EdgePlace]) -> tuple[Figure, str]:
    """The surroundings of some contact edges with their elements, and the caption."""
    bodies = source.bodies(state)
    views = [edge_view(source.result.contact_history(edge.contact), edge, bodies) for edge in edges]
    shown = [(body, view) for view, moved in views for body in moved.values()]
    limit, largest = colour_limit(shown, EDGES_PERCENTAGE)
    grid = largest_grid(len(edges), EDGE_ASPECT, bar=True)
    heading = f"Von Mises stress at the contact edges, {source.when(state)}"
    figure, axes = panels(grid, len(edges), heading)
    unit = source.numbers["units"]["length"]
    scene = Scene(limit)
    for panel, edge, (view, moved) in zip(axes, edges, views, strict=True):
        set_limits(panel, view.origin, view.half_size)
        show_image(panel, scene.image(list(moved.values()), 1.0, view, grid.panel))
        for body in moved.values():
            _draw_elements(panel, body, view)
        name_axes(panel, "distance from the edge along x", "along y", unit)
        slip = f"longest slip zone {rounded(edge.slip)} {unit}" if edge.slip > 0 else "no slip zone"
        set_title(panel, f"{edge.contact}, {edge.side} edge", slip)
    scene.close()
    draw_bar(figure, grid, COLOURS, limit, _bar_label(source))
    return figure, (
        f"Von Mises equivalent stress and elements around the contact edges at "
        f"{source.when(state)}, displacements as they are. Each panel is turned into the frame of "
        "its contact, body 2 below; its origin is the edge, on both bodies: a sliding of a whole "
        "body along x is left out. "
        f"{_colour_text(source, limit, largest, EDGES_PERCENTAGE)}"
    )


def _draw_elements(panel: Axes, body: BodyField, view: View) -> None:
    """Outlines of the elements that are seen, and of the body."""
    points = view.local(body.deformed(1.0))
    cells = body.cells[view.overlaps(body.deformed(1.0)[body.cells])]
    edges = points[cells[:, np.array(EDGES[cells.shape[1]])]]
    draw_lines(panel, [edges.reshape(-1, *edges.shape[2:])], **ELEMENTS)
    outline = body.outline[view.overlaps(body.deformed(1.0)[body.outline])]
    draw_lines(panel, [points[outline]], **OUTLINE)


def _bar_label(source: Source) -> str:
    return f"von Mises stress [{source.numbers['units']['stress']}]"


def _colour_text(source: Source, limit: float, largest: float, percentage: float) -> str:
    unit = source.numbers["units"]["stress"]
    if largest <= limit:
        return f"The largest stress is {rounded(largest)} {unit}."
    return (
        f"Colours end at {rounded(limit)} {unit}, which {percentage:g} % of the area shown stay "
        f"below; the largest value in an element is {rounded(largest)} {unit}."
    )
