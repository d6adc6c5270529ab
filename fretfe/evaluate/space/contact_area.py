# SPDX-License-Identifier: LGPL-3.0-or-later
"""Areas in contact between solids, and reasons why they have no front."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fretfe._typing import Bools
from fretfe.evaluate.space.sectors import outlines
from fretfe.history.solution import ContactHistory
from fretfe.reason import Kind, Reason

# Edges between nodes in contact and nodes outside that an outline has at least: a closed one might
# go round a node that happens to be open.
FEWEST_CROSSED = {True: 12, False: 4}
# Elements over the width of a round contact and of a long one: fits of two orders reach six
# inward, and no farther than to .9 of a radius of curvature or 1.5 times the half-width.
WANTED_ACROSS = {True: 14, False: 8}
# Part of its surface that a contact leaves open at least, or its border is that of the surface.
LEFT = 0.05


def why_no_fronts(contact: ContactHistory, state: int) -> Reason:
    """Reason why a contact has no fronts in a state."""
    assert contact.surface.facets is not None
    *_, area = contact_areas(contact, state)
    if not area.any():
        return Reason(Kind.NO_CONTACT, 0, 1)
    lines = outlines(contact.surface.facets, area)
    if not lines or contact.surface.weights[~area].sum() < LEFT * contact.surface.weights.sum():
        return Reason(Kind.NO_BORDER)
    line = lines[0]
    width, size = _width(contact, area, closed=line.closed)
    elements = round(width / size) if size > 0 else 0
    wanted = WANTED_ACROSS[line.closed]
    if elements < wanted:
        return Reason(Kind.NARROW, elements, wanted)
    ends = line.middles(contact.surface.points)[[0, -1]]
    if not line.closed and np.linalg.norm(ends[1] - ends[0]) < width:
        return Reason(Kind.CUT, round(float(np.linalg.norm(ends[1] - ends[0])) / size), elements)
    if len(line.inside) < FEWEST_CROSSED[line.closed]:
        return Reason(Kind.SHORT_BORDER, len(line.inside), FEWEST_CROSSED[line.closed])
    return Reason(Kind.NO_CURVE, elements)


def _width(contact: ContactHistory, area: Bools, *, closed: bool) -> tuple[float, float]:
    """Width of the ellipse, or strip, with the second moments of an area (N,); elements across."""
    assert contact.surface.facets is not None
    points, weights = contact.surface.points[area], contact.surface.weights[area]
    offset = points - weights @ points / weights.sum()
    # From the normal to the longest axis.
    moments, axes = np.linalg.eigh((weights * offset.T) @ offset / weights.sum())
    inside = contact.surface.facets[area[contact.surface.facets].any(axis=1)]
    extents = np.ptp(contact.surface.points[inside] @ axes[:, 1], axis=1)
    width = math.sqrt((16 if closed else 12) * max(float(moments[1]), 0.0))
    return width, float(np.median(extents))


def contact_areas(contact: ContactHistory, state: int) -> Iterator[Bools]:
    """(N,) nodes under pressure, and then those too around which only such nodes carry something.

    Where the tractions have more nodes than the bodies can follow, nodal pressures flicker: open
    nodes stand between others that carry twice the pressure, and no border is that of the contact.
    Means around nodes do not; beyond a border, which they reach by a node, they are taken back.
    """
    assert contact.surface.facets is not None
    pressed = np.asarray(contact.traction[state][:, 0] > 0)
    yield pressed
    corners = contact.surface.facets
    carried = np.asarray(contact.mean_traction[state][:, 0] > 0)
    filled = carried.copy()
    filled[corners[~carried[corners].all(axis=1)].ravel()] = False
    if (filled & ~pressed).any():
        yield pressed | filled
