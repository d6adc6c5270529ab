# SPDX-License-Identifier: LGPL-3.0-or-later
"""Lines to draw of a plane mesh: outlines of its cells, and its boundaries as continuous curves."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.results.model import BodyArrays

CORNERS = {"triangle": 3, "quadrilateral": 4}
# Straight pieces that a curved edge is drawn with.
CURVE_PIECES = 6
# Edges whose middle is off their chord by less than this fraction of it are drawn straight.
VISIBLE_BULGE = 1e-3


def cell_outlines(body: BodyArrays) -> tuple[list[Array], Array]:
    """The outlines of all cells, and the boxes (m, 2, 2) with their lowest and highest corners.

    Returns:
        Arrays (cells, places, 2): one of the cells with straight edges and, if there are any, one
        of those with curved edges. The boxes are in the same order.
    """
    corners = CORNERS[body.cell]
    straight = body.points[body.cells[:, :corners]]
    parts = [straight]
    if body.order == 2:
        ends = np.roll(straight, -1, axis=1)
        middles = body.points[body.cells[:, corners : 2 * corners]]
        curved = _bulges(straight, ends, middles).any(axis=1)
        edges = [each[curved] for each in (straight, ends, middles)]
        outlines = _along(*edges)[..., :-1, :].reshape(-1, corners * CURVE_PIECES, 2)
        parts = [straight[~curved], *([outlines] if curved.any() else [])]
    boxes = [np.stack([part.min(axis=1), part.max(axis=1)], axis=1) for part in parts]
    return parts, np.concatenate(boxes)


def boundary_curves(body: BodyArrays, name: str) -> list[Array]:
    """The boundary of this name as curves (n, 2), one for each connected piece."""
    facets = body.boundaries[name]
    return [_curve(body.points, facets[chain]) for chain in _chains(facets)]


def _curve(points: Array, facets: Indices) -> Array:
    first, last = points[facets[:, 0]], points[facets[:, 1]]
    if facets.shape[1] == 2:
        return np.concatenate([first, last[-1:]])
    places = _along(first, last, points[facets[:, 2]])
    return np.concatenate([places[:, :-1].reshape(-1, 2), last[-1:]])


def _chains(facets: Indices) -> list[list[int]]:
    """The facets of each connected piece in the order in which they follow each other."""
    by_start = {int(start): number for number, start in enumerate(facets[:, 0])}
    starts = np.setdiff1d(facets[:, 0], facets[:, 1])
    chains = []
    while by_start:
        node = next((int(s) for s in starts if int(s) in by_start), next(iter(by_start)))
        chain = []
        while node in by_start:
            chain.append(by_start.pop(node))
            node = int(facets[chain[-1], 1])
        chains.append(chain)
    return chains


def _bulges(first: Array, last: Array, middle: Array) -> Bools:
    """Whether edges are visibly curved."""
    bulge = np.linalg.norm(middle - (first + last) / 2, axis=-1)
    return bulge > VISIBLE_BULGE * np.linalg.norm(last - first, axis=-1)


def _along(first: Array, last: Array, middle: Array) -> Array:
    """(..., CURVE_PIECES + 1, 2) places along quadratic edges (..., 2)."""
    t = np.linspace(0.0, 1.0, CURVE_PIECES + 1)[:, None]
    first, last, middle = (each[..., None, :] for each in (first, last, middle))
    return first * (1 - t) * (1 - 2 * t) + last * t * (2 * t - 1) + middle * 4 * t * (1 - t)
