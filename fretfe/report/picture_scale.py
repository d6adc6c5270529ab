# SPDX-License-Identifier: LGPL-3.0-or-later
"""What pictures of stress show: how large displacements, which colours, which surroundings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fretfe._typing import Array
from fretfe.report.field_files import CORNERS, BodyField
from fretfe.report.picture_plan import EdgePlace
from fretfe.report.view import View, view_of_box
from fretfe.results.solution import ContactHistory

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
    size = float(np.ptp(np.concatenate([body.points for body in fields]), axis=0).max())
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
        corners = body.deformed(1.0)[body.cells[:, : CORNERS[body.cells.shape[1]]]]
        seen = np.ones(len(corners), bool) if view is None else view.overlaps(corners)
        stresses.append(body.von_mises[body.cells[seen]].max(axis=1))
        areas.append(polygon_areas(corners[seen]))
    stress, area = np.concatenate(stresses), np.concatenate(areas)
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
    return view_of_box(low - border, high + border)


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
    return int(np.linalg.norm(body.points - point, axis=1).argmin())
