# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reasons why no front of a contact between solids is known."""

from __future__ import annotations

import math

import numpy as np

from fretfe._typing import Bools
from fretfe.evaluate.space.fronts import FEWEST_CROSSED, contact_areas
from fretfe.evaluate.space.sectors import outlines
from fretfe.evaluate.withheld import Lack, Withheld
from fretfe.history.solution import ContactHistory

# Elements over the width of a round contact and of a long one: fits of two orders reach six
# inward, and no farther than to .9 of a radius of curvature or 1.5 times the half-width.
WANTED_ACROSS = {True: 14, False: 8}
# Part of its surface that a contact leaves open at least, or its border is that of the surface.
LEFT = 0.05


def why_no_fronts(contact: ContactHistory, state: int) -> Withheld:
    """Reason why a contact has no fronts in a state."""
    assert contact.surface.facets is not None
    *_, area = contact_areas(contact, state)
    if not area.any():
        return Withheld(Lack.PARTED, 0, 1)
    lines = outlines(contact.surface.facets, area)
    if not lines or contact.surface.weights[~area].sum() < LEFT * contact.surface.weights.sum():
        return Withheld(Lack.NO_BORDER)
    line = lines[0]
    width, size = _width(contact, area, closed=line.closed)
    elements, wanted = round(width / size), WANTED_ACROSS[line.closed]
    if elements < wanted:
        return Withheld(Lack.NARROW, elements, wanted)
    ends = line.middles(contact.surface.points)[[0, -1]]
    if not line.closed and np.linalg.norm(ends[1] - ends[0]) < width:
        return Withheld(Lack.CUT, round(float(np.linalg.norm(ends[1] - ends[0])) / size), elements)
    if len(line.inside) < FEWEST_CROSSED[line.closed]:
        return Withheld(Lack.SHORT_BORDER, len(line.inside), FEWEST_CROSSED[line.closed])
    return Withheld(Lack.NO_CURVE, elements)


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
