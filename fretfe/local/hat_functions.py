# SPDX-License-Identifier: LGPL-3.0-or-later
"""Compliance of a pair of half-planes under piecewise-linear tractions, on a graded grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools

# Pairs of hats nearer than this many elements are integrated in closed form. Further apart the
# closed form loses digits to cancellation, and Gauss points are exact to 1e-11.
NEAR = 6.0
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
# The grid ends this fraction of the contact outside its edges, which leaves room for errors of the
# edges; the outermost nodes carry no traction.
MARGIN = 0.01
# Elements at an edge are this much smaller than elements a governing length away from it.
FINEST = 0.05
# An edge that travels gets at least this many times its travel resolved like the edge itself.
TRAVEL = 1 / 3
SAMPLES = 20_001


class HatFunctions:
    """Hat functions on the inner nodes of a grid, with their Gauss points.

    Args:
        grid: (n + 2,) increasing nodes, the outermost two without traction.
    """

    def __init__(self, grid: Array) -> None:
        self.grid = grid
        lengths = np.diff(grid)
        middle = (grid[1:] + grid[:-1]) / 2
        self.points = (middle[:, None] + lengths[:, None] / 2 * POINTS).ravel()
        weights = lengths[:, None] / 2 * WEIGHTS
        rising = weights * (1 + POINTS) / 2
        falling = weights - rising
        self.tests = np.zeros((len(grid), self.points.size))
        for k in range(len(POINTS)):
            columns = np.arange(len(lengths)) * len(POINTS) + k
            self.tests[np.arange(len(lengths)), columns] = falling[:, k]
            self.tests[np.arange(1, len(grid)), columns] = rising[:, k]
        self.tests = self.tests[1:-1]

    @property
    def nodes(self) -> Array:
        """(n,) nodes that carry tractions."""
        return self.grid[1:-1]

    @property
    def weights(self) -> Array:
        """(n,) integrals of the hats."""
        return (self.grid[2:] - self.grid[:-2]) / 2

    def integrate(self, function: Callable[[Array], Array]) -> Array:
        """(n,) integrals of the hats with a function of x that is smooth within the elements."""
        return np.asarray(self.tests @ function(self.points))

    def averaging(self) -> Array:
        """(n, n) means of a piecewise-linear field around each node, from its nodal values."""
        lengths = np.diff(self.grid)
        mass = np.diag((lengths[:-1] + lengths[1:]) / 3)
        inner = lengths[1:-1] / 6
        return (mass + np.diag(inner, 1) + np.diag(inner, -1)) / self.weights[:, None]

    def compliance(self, distance: float) -> Array:
        """(n, n) weighted relative displacement for unit nodal tractions and E* = 1.

        Args:
            distance: L.
        """
        near = self._near()
        logarithm = np.where(near, self._closed_form(), self._by_points(distance))
        shift = np.where(near, np.log(distance), 0.0)
        return 2 / np.pi * (logarithm + shift * np.outer(self.weights, self.weights))

    def coupling(self) -> Array:
        """(n, n) weighted relative displacement by unit nodal tractions across, for E* and beta 1.

        Of unlike bodies pressure moves points along the interface, and shear moves them across it:
        the relative displacement across, positive where it opens, by the shear on body 2; that of
        body 2 along the interface by the pressure is the transposed matrix. Up to a rigid motion.
        """
        before = np.sign(self.nodes[:, None] - self.nodes) * np.outer(self.weights, self.weights)
        difference = self.grid[:, None] - self.grid
        fourth_integral = np.sign(difference) * difference**4 / 24
        apart = np.abs(np.subtract.outer(*[np.arange(len(self.nodes))] * 2))
        return np.where(apart > 1, before, self._doubly_integrated(fourth_integral))

    def _near(self) -> Bools:
        reach = NEAR * np.maximum(np.diff(self.grid)[1:], np.diff(self.grid)[:-1])
        return np.abs(self.nodes[:, None] - self.nodes) < np.maximum.outer(reach, reach)

    def _by_points(self, distance: float) -> Array:
        """(n, n) integrals of -ln(|x - y|/L), wrong where hats share an element."""
        r = np.abs(self.points[:, None] - self.points)
        np.fill_diagonal(r, distance)
        return np.asarray(-self.tests @ np.log(r / distance) @ self.tests.T)

    def _closed_form(self) -> Array:
        """(n, n) integrals of -ln|x - y|: fourth differences of a fourth integral."""
        r = np.abs(self.grid[:, None] - self.grid)
        logarithm = np.log(np.where(r > 0, r, 1.0))
        return -self._doubly_integrated(r**4 / 24 * (logarithm - 25 / 12))

    def _doubly_integrated(self, fourth_integral: Array) -> Array:
        """(n, n) integrals of a kernel over pairs of hats, from its fourth integral on the grid."""
        h = np.diff(self.grid)
        rows = np.arange(len(self.nodes))
        second = np.zeros((len(rows), len(self.grid)))
        second[rows, rows] = 1 / h[:-1]
        second[rows, rows + 1] = -1 / h[:-1] - 1 / h[1:]
        second[rows, rows + 2] = 1 / h[1:]
        return np.asarray(second @ fourth_integral @ second.T)


@dataclass(frozen=True)
class EdgeRange:
    """Range of positions of one edge under the loads that the grid resolves.

    Attributes:
        low, high: extreme positions.
        length: distance over which the pressure changes near the edge: the half-width, or the
            rounded part.
    """

    low: float
    high: float
    length: float

    def size(self, x: Array) -> Array:
        """Relative element size at x, by its distance to the range.

        Grows with the square root of the distance, as the tractions do, and from the governing
        length on with the distance itself.
        """
        distance = np.maximum(np.maximum(self.low - x, x - self.high), 0.0)
        finest = max(FINEST * self.length, TRAVEL * (self.high - self.low))
        near = np.sqrt(distance * self.length + finest**2) / self.length
        return np.where(distance > self.length, (1 + distance / self.length) / 2, near)


def graded_grid(
    edges: tuple[EdgeRange, EdgeRange], reach: tuple[float, float], kinks: Array, elements: int
) -> Array:
    """(elements + 1,) increasing nodes from the left end of the reach to the right one.

    Args:
        edges: left and right edge.
        reach: largest extent of the contact in the whole history.
        kinks: positions that get a node: those where the profile is not smooth.
        elements: number of elements.
    """
    margin = MARGIN * (reach[1] - reach[0]) / 2
    x = np.linspace(reach[0] - margin, reach[1] + margin, SAMPLES)
    density = 1 / np.minimum(edges[0].size(x), edges[1].size(x))
    cumulative = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    nodes = np.interp(np.linspace(0.0, cumulative[-1], elements + 1), cumulative, x)
    nodes = (nodes - nodes[::-1]) / 2 if np.allclose(x, -x[::-1]) else nodes
    for kink in kinks[(kinks > nodes[1]) & (kinks < nodes[-2])]:
        nodes[np.argmin(np.abs(nodes - kink))] = kink
    return nodes
