# SPDX-License-Identifier: LGPL-3.0-or-later
"""Compliance of a pair of half-planes under piecewise-linear tractions, integrated exactly.

Tractions are sums of hat functions on graded nodes x_0 < ... < x_{n+1}; the two outermost nodes
carry none. The relative displacement of the surfaces, for pressure and shear alike,

    w(x) = -(2/(pi E*)) int t(y) ln(|x - y|/L) dy

(Johnson 1985, sections 2.3 and 2.4, for both bodies), is weighted with the same hats. L only adds a
rigid motion; a large one makes the compliance positive definite.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fretfe._typing import Array, Bools

# Pairs of hats nearer than this many elements are integrated in closed form. Further apart the
# closed form loses digits to cancellation, and Gauss points are exact to 1e-11.
NEAR = 6.0
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)


class HatFunctions:
    """Hat functions on the inner nodes of a grid, with their Gauss points.

    Args:
        grid: (n + 2,) increasing nodes, the outermost two without traction.
    """

    def __init__(self, grid: Array) -> None:
        self.grid = grid
        lengths = np.diff(grid)
        middle = (grid[1:] + grid[:-1]) / 2
        self._points = (middle[:, None] + lengths[:, None] / 2 * POINTS).ravel()
        weights = lengths[:, None] / 2 * WEIGHTS
        rising = weights * (1 + POINTS) / 2
        falling = weights - rising
        self._tests = np.zeros((len(grid), self._points.size))
        for k in range(len(POINTS)):
            columns = np.arange(len(lengths)) * len(POINTS) + k
            self._tests[np.arange(len(lengths)), columns] = falling[:, k]
            self._tests[np.arange(1, len(grid)), columns] = rising[:, k]
        self._tests = self._tests[1:-1]

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
        return np.asarray(self._tests @ function(self._points))

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

    def _near(self) -> Bools:
        reach = NEAR * np.maximum(np.diff(self.grid)[1:], np.diff(self.grid)[:-1])
        return np.abs(self.nodes[:, None] - self.nodes) < np.maximum.outer(reach, reach)

    def _by_points(self, distance: float) -> Array:
        """(n, n) integrals of -ln(|x - y|/L), wrong where hats share an element."""
        r = np.abs(self._points[:, None] - self._points)
        np.fill_diagonal(r, distance)
        return np.asarray(-self._tests @ np.log(r / distance) @ self._tests.T)

    def _closed_form(self) -> Array:
        """(n, n) integrals of -ln|x - y|: fourth differences of a fourth integral."""
        r = np.abs(self.grid[:, None] - self.grid)
        logarithm = np.log(np.where(r > 0, r, 1.0))
        fourth_integral = r**4 / 24 * (logarithm - 25 / 12)
        h = np.diff(self.grid)
        rows = np.arange(len(self.nodes))
        second = np.zeros((len(rows), len(self.grid)))
        second[rows, rows] = 1 / h[:-1]
        second[rows, rows + 1] = -1 / h[:-1] - 1 / h[1:]
        second[rows, rows + 2] = 1 / h[1:]
        return np.asarray(-second @ fourth_integral @ second.T)
