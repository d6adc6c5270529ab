# SPDX-License-Identifier: LGPL-3.0-or-later
"""The order of nodes along a line of which only their coordinates are known."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import CaseError

# Nodes of a contact line; the time that it takes grows with their square.
MOST_NODES = 20_000
# Ends of a line that are nearer to one another than this many of its longest steps close it.
CLOSED = 1.5


def order_along(points: Array, pressure: Array) -> Indices:
    """(n,) the nodes of a line from one end to the other, each next to its neighbours.

    They are neighbours in the shortest tree that joins all of them, which is the line itself as
    long as no part of it comes nearer to another than its nodes are apart. It may turn back or go
    round. One that is closed begins in the middle of the longest stretch without contact.

    Args:
        points: (n, d).
        pressure: (n,).

    Raises:
        CaseError: the nodes are on no line, too many, or in contact all round.
    """
    if len(points) > MOST_NODES:
        raise CaseError(
            f"expected at most {MOST_NODES:,} nodes along a line, found {len(points):,}"
        )
    parents, steps = _shortest_tree(points)
    neighbours: list[list[int]] = [[] for _ in points]
    for node, parent in enumerate(parents[1:].tolist(), start=1):
        neighbours[node].append(parent)
        neighbours[parent].append(node)
    if branches := [node for node, others in enumerate(neighbours) if len(others) > 2]:
        at = ", ".join(f"{value:.6g}" for value in points[branches[0]])
        raise CaseError(
            f"expected the nodes of one line, found a branch at ({at}), as of several surfaces or "
            "of a surface of solids"
        )
    order = [next(node for node, others in enumerate(neighbours) if len(others) < 2)]
    while len(order) < len(points):
        behind = order[-2:-1]
        order += [node for node in neighbours[order[-1]] if node not in behind]
    found = np.array(order)
    gap = float(np.linalg.norm(points[found[-1]] - points[found[0]]))
    if len(found) > 2 and gap < CLOSED * steps.max() and pressure[found[[0, -1]]].max() > 0:
        found = _opened(found, pressure)
    return found if _ahead(points[found], found) else found[::-1]


def _shortest_tree(points: Array) -> tuple[Indices, Array]:
    """(n,) the node that each is joined to, and how far that is (Prim); the first has none."""
    count = len(points)
    parents, nearest = np.zeros(count, dtype=np.int64), np.full(count, np.inf)
    steps, left = np.zeros(count), np.ones(count, dtype=bool)
    node, left[0] = 0, False
    for _ in range(count - 1):
        away = np.linalg.norm(points - points[node], axis=1)
        nearer = left & (away < nearest)
        nearest[nearer], parents[nearer] = away[nearer], node
        node = int(np.where(left, nearest, np.inf).argmin())
        steps[node], left[node] = nearest[node], False
    return parents, steps


def _opened(order: Indices, pressure: Array) -> Indices:
    """The nodes of a closed line, from the middle of the longest stretch without contact on."""
    free = pressure[order] <= 0
    if not free.any():
        raise CaseError("expected nodes out of contact on a closed line, found pressure all round")
    turned = np.roll(order, -int(np.flatnonzero(~free)[0]))
    free = pressure[turned] <= 0
    begins = np.flatnonzero(free & ~np.roll(free, 1))
    ends = np.flatnonzero(free & ~np.roll(free, -1))
    longest = int((ends - begins).argmax())
    return np.roll(turned, -int(begins[longest] + ends[longest] + 1) // 2)


def _ahead(places: Array, rows: Indices) -> bool:
    """True if the coordinate that varies most increases from end to end, or else the row does."""
    extent = np.ptp(places, axis=0)
    most = int(extent.argmax())
    way = float(places[-1, most] - places[0, most])
    return way > 0 if abs(way) > 0.1 * extent[most] else bool(rows[-1] > rows[0])
