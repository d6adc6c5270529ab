# SPDX-License-Identifier: LGPL-3.0-or-later
"""A slow twin of the mortar kernel in plain Python: other algorithms, the same definition.

Feet of points are found with Brent's method between sampled changes of sign, hits of a line with a
facet as roots of a polynomial; all geometry is relative to the point in question.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial import polynomial
from scipy.optimize import brentq

from fretfe._typing import Array
from fretfe.surface.overlap import OverlapPoints

SAMPLES = 33
# Facet ends belong to two facets.
END_TOLERANCE = 1e-9
SHORTEST_SEGMENT = 1e-10
# Leading coefficients this small say that a facet with a middle node is straight.
ROUND_OFF = 1e-14
# Coefficients in t of the Lagrange functions on [0, 1]: (end, end[, middle]) x (1, t[, t^2]).
SHAPES = {
    2: np.array([[1.0, -1.0], [0.0, 1.0]]),
    3: np.array([[1.0, -3.0, 2.0], [0.0, -1.0, 2.0], [0.0, 4.0, -4.0]]),
}


@dataclass(frozen=True)
class Hit:
    facet: int
    eta: float
    gap: float


def coefficients(nodal: Array) -> Array:
    """(2, k) polynomial coefficients of both components of a facet's interpolation."""
    return nodal.T @ SHAPES[len(nodal)]


def at(nodal: Array, t: float) -> Array:
    return np.array([polynomial.polyval(t, c) for c in coefficients(nodal)])


def slope(nodal: Array, t: float) -> Array:
    return np.array([polynomial.polyval(t, polynomial.polyder(c)) for c in coefficients(nodal)])


def unit(v: Array) -> Array:
    return v / np.hypot(*v)


def cross(a: Array, b: Array) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def crossings(shifted: Array, normal: Array) -> Array:
    """Reference coordinates where a facet, seen from a point, crosses the normal line."""
    x, y = coefficients(shifted)
    miss = x * normal[1] - y * normal[0]
    roots = polynomial.polyroots(polynomial.polytrim(miss, ROUND_OFF * np.abs(miss).max()))
    roots = np.real(roots[np.isreal(roots)])
    # Eigenvalues of a nearly linear polynomial are good to 1e-12 only.
    derivative = polynomial.polyder(miss)
    return roots - polynomial.polyval(roots, miss) / polynomial.polyval(roots, derivative)


def feet(nodes: Array, normals: Array, point: Array) -> list[float]:
    """Reference coordinates in (0, 1) whose normal line passes through the point."""
    shifted = nodes - point

    def miss(t: float) -> float:
        return cross(at(shifted, t), unit(at(normals, t)))

    t = np.linspace(0.0, 1.0, SAMPLES)
    values = np.array([miss(s) for s in t])
    changes = np.flatnonzero(values[:-1] * values[1:] < 0)
    found = [brentq(miss, t[i], t[i + 1], xtol=1e-15, rtol=1e-14) for i in changes]
    return found + [float(s) for s in t[1:-1][values[1:-1] == 0]]


def hits(other: Array, point: Array, normal: Array) -> list[Hit]:
    """Where the line through a point meets the facets that face it."""
    found = []
    for number, facet in enumerate(other):
        shifted = facet - point
        for eta in crossings(shifted, normal):
            tangent = slope(shifted, eta)
            inside = -END_TOLERANCE < eta < 1 + END_TOLERANCE
            if inside and tangent[1] * normal[0] < tangent[0] * normal[1]:
                found.append(Hit(number, float(eta), float(at(shifted, eta) @ normal)))
    return found


def overlap_points(
    nodes: Array, normals: Array, other: Array, points: Array, weights: Array, max_gap: float
) -> OverlapPoints:
    """The points of the kernel, in its order, with all pairs of facets tried."""
    numbers, rows = [], []
    ends = np.unique(other[:, :2].reshape(-1, 2), axis=0)
    for number, (facet, field) in enumerate(zip(nodes, normals, strict=True)):
        at_feet = [
            t
            for end in ends
            for t in feet(facet, field, end)
            if np.hypot(*(at(facet - end, t))) <= max_gap
        ]
        cuts = np.array(sorted([0.0, 1.0, *at_feet]))
        for start, stop in pairwise(cuts):
            if stop - start < SHORTEST_SEGMENT:
                continue
            middle = (start + stop) / 2
            partners = hits(other, at(facet, middle), unit(at(field, middle)))
            partners = [hit for hit in partners if abs(hit.gap) <= max_gap]
            if not partners:
                continue
            partner = min(partners, key=lambda hit: abs(hit.gap)).facet
            for point, weight in zip(points, weights, strict=True):
                xi = start + (stop - start) * point
                normal = unit(at(field, xi))
                hit = nearest_root(other[partner], at(facet, xi), normal)
                arc = np.hypot(*slope(facet, xi))
                measure = weight * (stop - start) * arc
                numbers.append((partner, number))
                rows.append((hit.eta, xi, measure, hit.gap, *normal))
    (facet1, facet2), table = np.array(numbers).T, np.array(rows)
    at1, at2, measures, gaps = table[:, :1], table[:, 1:2], table[:, 2], table[:, 3]
    return OverlapPoints(facet1, facet2, at1, at2, measures, gaps, table[:, 4:])


def nearest_root(facet: Array, point: Array, normal: Array) -> Hit:
    """Where the line meets one facet, on it or (by round-off) next to it."""
    shifted = facet - point
    eta = float(min(crossings(shifted, normal), key=lambda t: abs(t - 0.5)))
    return Hit(0, eta, float(at(shifted, eta) @ normal))
