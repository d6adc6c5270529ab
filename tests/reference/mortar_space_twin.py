# SPDX-License-Identifier: LGPL-3.0-or-later
"""A slow twin of the mortar kernel in space in plain Python: the same definition.

Feet and hits come from SciPy's hybrid method, interpolation from `fretfe.mesh.elements`; all
pairs of facets are tried.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from scipy.optimize import root

from fretfe._typing import Array
from fretfe.mesh.elements import KINDS, reference_nodes, shape_slopes, shape_values
from fretfe.surface.overlap import OverlapPoints, Rule

# Definitions that the twin shares with the kernel.
FARTHEST_FOOT, FARTHEST_HIT = 1.0, 0.1
STRAIGHT_EDGE, ON_LINE, SMALLEST_AREA = 1e-4, 1e-10, 1e-10
MOST_PIECES = 8


@dataclass(frozen=True, eq=False)
class Facet:
    nodes: Array
    normals: Array

    @cached_property
    def kind(self) -> tuple[str, int]:
        return KINDS[3, len(self.nodes)]

    @property
    def corners(self) -> Array:
        return reference_nodes(self.kind[0], 1)

    @property
    def size(self) -> float:
        corners = self.nodes[: len(self.corners)]
        return float(np.linalg.norm(corners[:, None] - corners, axis=2).max())

    def at(self, place: Array) -> Array:
        return shape_values(*self.kind, place[None])[0] @ self.nodes

    def direction(self, place: Array) -> Array:
        return shape_values(*self.kind, place[None])[0] @ self.normals

    def tangents(self, place: Array, nodal: Array) -> Array:
        return shape_slopes(*self.kind, place[None])[0] @ nodal

    def outside(self, place: Array) -> float:
        """Largest distance from the sides' lines; negative inside."""
        return max(-side(place) for side in self.sides)

    @property
    def sides(self) -> list[Callable[[Array], float]]:
        low: list[Callable[[Array], float]] = [lambda p: p[0], lambda p: p[1]]
        if self.kind[0] == "triangle":
            return [*low, lambda p: 1 - p[0] - p[1]]
        return [*low, lambda p: 1 - p[0], lambda p: 1 - p[1]]


def solved(function: Callable[[Array], Array], start: Array) -> Array | None:
    """Root of an equation, polished; None if there is none nearby."""
    found = root(function, start, tol=1e-13)
    if np.abs(function(found.x)).max() > 1e-11:
        return None
    return np.asarray(found.x)


@lru_cache(None)
def foot(near: Facet, coordinates: tuple[float, ...]) -> Array:
    """Place whose normal line passes through a point, or as seen from the centre if far away."""
    point = np.array(coordinates)
    centre = near.corners.mean(axis=0)

    def miss(unknown: Array) -> Array:
        return near.at(unknown[:2]) + unknown[2] * near.direction(unknown[:2]) - point

    tangents = near.tangents(centre, near.nodes)
    linear = np.linalg.solve(
        np.vstack([tangents, near.direction(centre)]).T, point - near.at(centre)
    )
    start = np.array([*centre, 0.0]) + linear
    found = solved(miss, start)
    if found is None or near.outside(found[:2]) >= FARTHEST_FOOT:
        return start[:2]
    return found[:2]


def hit(far: Facet, point: Array, normal: Array) -> tuple[Array, float, bool] | None:
    """Place where a line meets a facet, the distance along the line, and whether it faces it."""

    def miss(unknown: Array) -> Array:
        return far.at(unknown[:2]) - point - unknown[2] * normal

    found = solved(miss, np.array([*far.corners.mean(axis=0), 0.0]))
    if found is None or far.outside(found[:2]) > FARTHEST_HIT:
        return None
    outward = np.cross(*far.tangents(found[:2], far.nodes))
    return found[:2], float(found[2]), bool(outward @ normal < 0)


def unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)


def cross(a: Array, b: Array) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def outline(near: Facet, far: Facet) -> list[Array]:
    """Polygon of a facet of the other side in the reference cell of a near one."""
    count = len(far.corners)
    polygon = []
    for i in reversed(range(count)):
        ends = (i + 1) % count, i
        start, stop = (foot(near, tuple(far.nodes[end])) for end in ends)
        length = np.linalg.norm(far.nodes[ends[1]] - far.nodes[ends[0]])
        pieces = 2 * int(np.clip(np.round(length / near.size), 1, MOST_PIECES))
        shares = np.arange(1, pieces)[:, None] / pieces
        places = (1 - shares) * far.corners[ends[0]] + shares * far.corners[ends[1]]
        inner = [foot(near, tuple(far.at(place))) for place in places]
        line = stop - start
        bent = any(abs(cross(line, p - start)) > STRAIGHT_EDGE * (line @ line) for p in inner)
        polygon += [start, *(inner if bent else [])]
    return polygon


def clipped(polygon: list[Array], side: Callable[[Array], float]) -> list[Array]:
    kept = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        da, db = side(a), side(b)
        if da >= 0:
            kept.append(a)
        if (da < 0) != (db < 0):
            kept.append(a + da / (da - db) * (b - a))
    return kept


def simplified(polygon: list[Array]) -> list[Array]:
    """Without vertices on the line of their neighbours."""
    for i, point in enumerate(polygon):
        before, after = polygon[i - 1], polygon[(i + 1) % len(polygon)]
        line, length = after - before, np.linalg.norm(after - before)
        if (
            np.linalg.norm(point - before) <= ON_LINE
            or length <= ON_LINE
            or abs(cross(line, point - before)) <= ON_LINE * length
        ):
            rest = polygon[:i] + polygon[i + 1 :]
            return simplified(rest) if len(rest) > 2 else rest
    return polygon


def samples(polygon: list[Array], square: Rule, triangle: Rule) -> Iterator[tuple[Array, float]]:
    """Places in a polygon and their shares of the reference area."""
    if len(polygon) == 4:
        corners = np.array(polygon)
        values = shape_values("quadrilateral", 1, square[0])
        slopes = shape_slopes("quadrilateral", 1, square[0]) @ corners
        yield from zip(values @ corners, square[1] * np.linalg.det(slopes), strict=True)
        return
    for b, c in pairwise(polygon[1:]):
        corners = np.array([polygon[0], b, c])
        places = shape_values("triangle", 1, triangle[0]) @ corners
        yield from zip(places, triangle[1] * cross(b - corners[0], c - corners[0]), strict=True)


def area(polygon: list[Array]) -> float:
    return sum(cross(a, b) for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True)) / 2


def pair_rows(
    near: Facet, far: Facet, square: Rule, triangle: Rule, max_gap: float
) -> Iterator[Array]:
    """Points of one pair of facets: places on both, weight, gap, normal."""
    polygon = outline(near, far)
    for side in near.sides:
        polygon = clipped(polygon, side)
    polygon = simplified(polygon)
    if len(polygon) < 3 or area(polygon) < SMALLEST_AREA:
        return
    middle = np.mean(polygon, axis=0)
    partner = hit(far, near.at(middle), unit(near.direction(middle)))
    if partner is None or not partner[2] or abs(partner[1]) > max_gap:
        return
    for place, share in samples(polygon, square, triangle):
        normal = unit(near.direction(place))
        found = hit(far, near.at(place), normal)
        if found is not None:
            stretch = np.linalg.norm(np.cross(*near.tangents(place, near.nodes)))
            yield np.array([*place, *found[0], share * stretch, found[1], *normal])


def overlap_points(
    nodes: Array, normals: Array, other: Array, square: Rule, triangle: Rule, max_gap: float
) -> OverlapPoints:
    """The points of the kernel, in its order, of surfaces that are not behind each other."""
    numbers, rows = [], []
    for number2, near in enumerate(map(Facet, nodes, normals)):
        for number1, far in enumerate(map(Facet, other, np.zeros_like(other))):
            for row in pair_rows(near, far, square, triangle, max_gap):
                numbers.append((number1, number2))
                rows.append(row)
    (facet1, facet2), table = np.array(numbers).T, np.array(rows)
    at2, at1, weights, gap = table[:, :2], table[:, 2:4], table[:, 4], table[:, 5]
    return OverlapPoints(facet1, facet2, at1, at2, weights, gap, table[:, 6:])
