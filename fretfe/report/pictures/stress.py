# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of the stress in the bodies: at the load extremes, and enlarged at the contact edges."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.history.solution import ContactHistory
from fretfe.report.pictures.fields import CORNERS, EDGES, BodyField, Fields, Scene
from fretfe.report.pictures.panels import (
    View,
    draw_lines,
    name_axes,
    panel_pixels,
    panels,
    set_limits,
    settle,
    show_image,
)
from fretfe.report.pictures.plan import EdgePlace
from fretfe.report.source import loading, when
from fretfe.report.texts import rounded
from fretfe.report.theme import (
    COLOURS,
    ELEMENTS,
    FRAMED,
    OUTLINE,
    PICTURE_WIDTH,
    UNDEFORMED,
)

# Of the area that is shown, per cent that stay below the last colour.
BODIES_PERCENTAGE, EDGES_PERCENTAGE = 99.8, 98.0

# Largest displacement that is drawn, and largest overlap of the bodies, as fractions of their size.
DRAWN_DISPLACEMENT, DRAWN_OVERLAP = 0.04, 0.003
# Around the bodies, as a fraction of their size.
BORDER = 0.03
# Half the width of the view of an edge: in slip zones, and at most in half-widths of the contact.
SLIP_ZONES, LARGEST_VIEW = 3.0, 0.3
# And at least in elements.
FEWEST_ELEMENTS = 10.0
# Height of the view of an edge over its width.
EDGE_ASPECT = 0.8
# Height of the colour bar over its width.
BAR_ASPECT = 28


@dataclass(frozen=True)
class Look:
    """Look of bodies, the same at several states.

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


def find_look(source: Fields, states: Sequence[int]) -> Look:
    """The look that suits some states."""
    fields = [body for state in states for body in source.bodies(state).values()]
    assert source.run.solution is not None
    scale = deformation_scale(fields, source.run.solution.contacts, states)
    limit, largest = colour_limit([(body, None) for body in fields], BODIES_PERCENTAGE)
    view = surroundings([body.deformed(factor) for body in fields for factor in (0.0, scale)])
    return Look(scale, limit, largest, view)


@mpl.rc_context(FRAMED)
def draw_bodies(
    source: Fields, states: Sequence[int], look: Look, scene: Scene, width: float = PICTURE_WIDTH
) -> Figure:
    """All bodies at some states, one panel each; the picture is `width` inches wide at most."""
    run, view = source.run, look.view
    figure, axes = panels(len(states), view.aspect, width=width)
    for panel, state in zip(axes, states, strict=True):
        set_limits(panel, view)
        name_axes(panel, "x", "y", run.case.units.length)
        panel.set_title(f"{when(run, state)}\n{loading(run, state)}")
    add_bar(figure, axes, look.limit, run.case.units.stress)
    settle(figure, axes, view.aspect, f"Von Mises stress, displacements × {look.scale:g}")
    for panel, state in zip(axes, states, strict=True):
        bodies = list(source.bodies(state).values())
        show_image(panel, scene.image(bodies, look.scale, view, panel_pixels(panel)))
        draw_lines(panel, [body.grid.points[body.grid.outline] for body in bodies], **UNDEFORMED)
        draw_lines(
            panel, [body.deformed(look.scale)[body.grid.outline] for body in bodies], **OUTLINE
        )
    return figure


def add_bar(figure: Figure, axes: Sequence[Axes], limit: float, unit: str) -> None:
    """The colour bar of all panels; colours end where stresses may go on."""
    colours = ScalarMappable(Normalize(0.0, limit), COLOURS)
    bar = figure.colorbar(colours, ax=axes, extend="max", aspect=BAR_ASPECT, pad=0.02)
    bar.set_label(f"von Mises stress [{unit}]", labelpad=6)


def bodies_caption(source: Fields, states: Sequence[int], look: Look) -> str:
    """Caption of the picture of `draw_bodies`."""
    times = " and ".join(when(source.run, state) for state in states)
    drawn = f"enlarged {look.scale:g} times" if look.scale > 1 else "in true size"
    return (
        f"Von Mises equivalent stress of the bodies at {times}; displacements {drawn}, dotted: "
        f"before deformation. {_colour_text(source, look.limit, look.largest, BODIES_PERCENTAGE)}"
    )


@mpl.rc_context(FRAMED)
def draw_edges(source: Fields, state: int, edges: Sequence[EdgePlace]) -> tuple[Figure, str]:
    """The surroundings of some contact edges with their elements, and the caption."""
    run, bodies = source.run, source.bodies(state)
    assert run.solution is not None
    contacts = {contact.name: contact for contact in run.solution.contacts}
    views = [edge_view(contacts[edge.contact], edge, bodies) for edge in edges]
    shown = [(body, view) for view, moved in views for body in moved.values()]
    limit, largest = colour_limit(shown, EDGES_PERCENTAGE)
    figure, axes = panels(len(edges), EDGE_ASPECT)
    unit = run.case.units.length
    for panel, edge, (view, _) in zip(axes, edges, views, strict=True):
        set_limits(panel, view)
        name_axes(panel, "distance from the edge along x", "along y", unit)
        slip = f"longest slip zone {rounded(edge.slip)} {unit}" if edge.slip > 0 else "no slip zone"
        panel.set_title(f"{edge.title}\n{slip}")
    add_bar(figure, axes, limit, run.case.units.stress)
    settle(figure, axes, EDGE_ASPECT, f"Von Mises stress at the contact edges, {when(run, state)}")
    scene = Scene(limit)
    for panel, (view, moved) in zip(axes, views, strict=True):
        show_image(panel, scene.image(list(moved.values()), 1.0, view, panel_pixels(panel)))
        for body in moved.values():
            _draw_elements(panel, body, view)
    scene.close()
    return figure, (
        f"Von Mises equivalent stress and elements around the contact edges at "
        f"{when(run, state)}, displacements in true size. Each panel is turned into the frame of "
        "its contact, with body 2 below; its origin is the edge, on both bodies, so sliding of a "
        "whole body along x is not visible. "
        f"{_colour_text(source, limit, largest, EDGES_PERCENTAGE)}"
    )


def _draw_elements(panel: Axes, body: BodyField, view: View) -> None:
    """Outlines of the elements that are seen, and of the body."""
    points = view.local(body.deformed(1.0))
    cells = body.grid.cells[view.overlaps(body.deformed(1.0)[body.grid.cells])]
    edges = points[cells[:, np.array(EDGES[cells.shape[1]])]]
    draw_lines(panel, [edges.reshape(-1, *edges.shape[2:])], **ELEMENTS)
    outline = body.grid.outline[view.overlaps(body.deformed(1.0)[body.grid.outline])]
    draw_lines(panel, [points[outline]], **OUTLINE)


def _colour_text(source: Fields, limit: float, largest: float, percentage: float) -> str:
    unit = source.run.case.units.stress
    if largest <= limit:
        return f"The largest stress is {rounded(largest)} {unit}."
    return (
        f"Colours end at {rounded(limit)} {unit}, which is not exceeded in {percentage:g} % of the "
        f"area shown; the largest value in an element is {rounded(largest)} {unit}."
    )


def deformation_scale(
    fields: Sequence[BodyField], contacts: Sequence[ContactHistory], states: Sequence[int]
) -> float:
    """Round factor of the displacements that shows them and lets no bodies overlap visibly.

    Where a contact closes from the initial gap g0 to the gap g, displacements drawn s times leave
    the gap g0 − s (g0 − g). Its negative must be small.

    Args:
        fields: of all bodies at all states that are drawn.
        contacts: between them.
        states: that are drawn.
    """
    size = float(np.ptp(np.concatenate([body.grid.points for body in fields]), axis=0).max())
    largest = max(float(np.linalg.norm(body.displacement, axis=1).max()) for body in fields)
    scales = [DRAWN_DISPLACEMENT * size / largest] if largest > 0 else [1.0]
    for contact in contacts:
        for state in states:
            closing = contact.gap[0] - contact.gap[state]
            closes = closing > 0
            limits = (contact.gap[0] + DRAWN_OVERLAP * size)[closes] / closing[closes]
            scales += limits[limits > 0].tolist()
    return max(round_down(min(scales)), 1.0)


def round_down(value: float) -> float:
    """The next smaller one of the numbers 1, 2 and 5 times powers of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-12)) * power


def round_up(value: float) -> float:
    """The next larger number with two digits."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / power * (1 - 1e-12)) * power


def colour_limit(
    shown: Sequence[tuple[BodyField, View | None]], percentage: float
) -> tuple[float, float]:
    """Stress of the last colour, and the largest stress in what is shown.

    What counts is the area that has a stress, not the number of elements, of which most are at the
    contact edges, where stresses have no bounds.

    Args:
        shown: bodies, and what is seen of them: elements that reach into the view, or all.
        percentage: of the area that stays below the last colour.
    """
    stresses, areas = [], []
    for body, view in shown:
        corners = body.deformed(1.0)[body.grid.cells[:, : CORNERS[body.grid.cells.shape[1]]]]
        seen = np.ones(len(corners), bool) if view is None else view.overlaps(corners)
        stresses.append(body.von_mises[body.grid.cells[seen]].max(axis=1))
        areas.append(polygon_areas(corners[seen]))
    return limit_of(np.concatenate(stresses), np.concatenate(areas), percentage)


def limit_of(stress: Array, area: Array, percentage: float) -> tuple[float, float]:
    """As `colour_limit`, for the stresses (m,) and areas, or volumes, of elements."""
    if not len(stress) or stress.max() <= 0:
        return 1.0, 0.0
    order = np.argsort(stress)
    below = np.cumsum(area[order]) / area.sum()
    number = min(int(np.searchsorted(below, percentage / 100)), len(order) - 1)
    return round_up(float(stress[order][number])), float(stress.max())


def polygon_areas(corners: Array) -> Array:
    """(m,) areas of polygons (m, k, 2)."""
    following = np.roll(corners, -1, axis=1)
    doubled = corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0]
    return np.abs(doubled.sum(axis=1)) / 2


def surroundings(points: Sequence[Array]) -> View:
    """The upright view that shows all points (n, 2)."""
    every = np.concatenate(points)
    low, high = every.min(axis=0), every.max(axis=0)
    border = BORDER * float((high - low).max())
    centre, half_size = (low + high) / 2, (high - low) / 2 + border
    return View(centre, half_size, np.array([0.0, 1.0]), centre)


def edge_view(
    contact: ContactHistory, edge: EdgePlace, bodies: Mapping[str, BodyField]
) -> tuple[View, dict[str, BodyField]]:
    """The surroundings of an edge at its displaced place, body 2 below, and the bodies there.

    Wide enough for its slip zone, or for a part of the contact where nothing slips; never so narrow
    that single elements are all that is seen. The two bodies are moved along x so that the places
    of the edge on both of them are in the middle: contact is between places that are opposite to
    each other before deformation (small sliding), and a body that slid as a whole would hide that.
    """
    number = int(np.abs(contact.arc - edge.position).argmin())
    point = np.array([np.interp(edge.position, contact.arc, x) for x in contact.points.T])
    element = float(np.diff(contact.arc[max(number - 1, 0) : number + 2]).max())
    most = LARGEST_VIEW * edge.half_width
    wanted = SLIP_ZONES * edge.slip if edge.slip > 0 else most
    half = max(min(wanted, most), FEWEST_ELEMENTS * element)
    normal = contact.frames[number, 0]
    lower = bodies[contact.body2]
    height = (lower.deformed(1.0)[nearest_node(point, lower)] - point) @ normal
    view = View(point + height * normal, np.array([half, EDGE_ASPECT * half]), normal)
    moved = dict(bodies)
    for name in (contact.body1, contact.body2):
        body = bodies[name]
        along = body.displacement[nearest_node(point, body)] @ view.tangent
        moved[name] = replace(body, displacement=body.displacement - along * view.tangent)
    return view, moved


def nearest_node(point: Array, body: BodyField) -> int:
    """The node next to a place (2,) before deformation."""
    return int(np.linalg.norm(body.grid.points - point, axis=1).argmin())
