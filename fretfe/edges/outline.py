# SPDX-License-Identifier: LGPL-3.0-or-later
"""Outlines of a contact area between solids: the lines between its nodes and those around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools, Indices


@dataclass(frozen=True)
class Outline:
    """A line half-way between nodes in contact and nodes outside, one point for each edge crossed.

    Attributes:
        inside, outside: (n,) nodes at both ends of the edges, in order along the line, the contact
            on its right when seen from outside body 2.
        closed: whether the line runs into itself; an open one ends at the border of the surface.
    """

    inside: Indices
    outside: Indices
    closed: bool

    def middles(self, points: Array) -> Array:
        """(n, 3) middles of the edges, of nodes at points (N, 3)."""
        return np.asarray((points[self.inside] + points[self.outside]) / 2)


def outlines(facets: Indices, contact: Bools) -> tuple[Outline, ...]:
    """Outlines of the nodes in contact (N,), longest first.

    Args:
        facets: (F, 3 or 4) nodes, counter-clockwise seen from outside body 2.
        contact: (N,) nodes in contact.
    """
    following = _segments(_triangles(facets), contact)
    lines = []
    for first in sorted(set(following) - set(following.values())):
        lines.append(_walk(following, first, closed=False))
    while following:
        lines.append(_walk(following, min(following), closed=True))
    return tuple(sorted(lines, key=lambda line: -len(line.inside)))


def _triangles(facets: Indices) -> Indices:
    """(m, 3) facets, quadrilaterals cut in two."""
    if facets.shape[1] == 3:
        return facets
    return np.concatenate([facets[:, [0, 1, 2]], facets[:, [0, 2, 3]]])


# An edge from a node in contact to one outside.
Edge = tuple[int, int]


def _segments(triangles: Indices, contact: Bools) -> dict[Edge, Edge]:
    """The crossed edge that follows each crossed edge, the contact on the right."""
    following = {}
    mixed = triangles[np.isin(contact[triangles].sum(axis=1), (1, 2))]
    for triangle in mixed.tolist():
        inside = [bool(contact[node]) for node in triangle]
        odd = inside.index(inside.count(True) == 1)
        alone, after, before = (triangle[(odd + turn) % 3] for turn in range(3))
        if inside[odd]:  # round a node in contact, which stays on the right
            following[alone, before] = (alone, after)
        else:
            following[after, alone] = (before, alone)
    return following


def _walk(following: dict[Edge, Edge], first: Edge, closed: bool) -> Outline:
    """The line that begins at an edge; takes it out of `following`."""
    edges, edge = [first], first
    while edge in following:
        edge = following.pop(edge)
        edges.append(edge)
    nodes = np.array(edges[:-1] if closed else edges, dtype=np.int64)
    return Outline(nodes[:, 0], nodes[:, 1], closed)
