# SPDX-License-Identifier: LGPL-3.0-or-later
"""The part of the pressure of half-planes that a given gap makes.

A patch from m - a to m + a over a gap of the slope g'(m + a z) = sum b_n T_n(z) has, with
r = sqrt(1 - z^2), the pressure (Cauchy integrals of Chebyshev's polynomials)

    p = r S(z),   S = E*/2 (b_1 U_0(z) + b_2 U_1(z) + ...)

Of S the given gap has all but the first two terms, which are those of the force and the moment of
the pressure itself: what other patches, and bodies that are no half-planes, add is smooth. Over S,
less these two terms as a factor, the pressure falls like a root all over the patch, so that
polynomials hold over any window; of a parabola they are what they were. The initial gap of a mesh
takes no part: next to fine edges its slope is round-off of the geometry.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools


@dataclass(frozen=True)
class GapSeries:
    """S of the patches of T states, one in each, along a line over a given gap.

    Attributes:
        arc: (N,) nodes.
        gap: (N,) there, times E*.
        pressure: (T, N) of these patches alone.
        beside: (T, N) forces on the nodes of others, over pi/2.
        count: of terms of S: that of the nodes in the longest patch.
    """

    arc: Array
    gap: Array
    pressure: Array
    beside: Array
    count: int

    @classmethod
    def of(cls, arc: Array, gap: Array, inside: Bools, pressure: Array) -> GapSeries:
        """That of pressures over a gap.

        Args:
            arc: (N,) nodes.
            gap: (N,) there, times E*.
            inside: (T, N) nodes of the patches.
            pressure: (T, N), also of other patches.
        """
        lengths = (np.diff(arc, prepend=arc[0]) + np.diff(arc, append=arc[-1])) / 2
        others = 2 / np.pi * np.where(inside, 0.0, pressure) * lengths
        count = max(int(inside.sum(axis=1).max()), 3)
        return cls(arc, gap, np.where(inside, pressure, 0.0), others, count)

    def over(self, edges: Array, at: Array, every: int = 1) -> Array:
        """(T, m) S over its first two terms at places (T, m), constant outside of the patches.

        Args:
            edges: (2, T) of the patches.
            at: (T, m) places.
            every: the nodes at which the gap is known: all, or every other one.
        """
        middle, half = edges.mean(axis=0), np.ptp(edges, axis=0) / 2
        z = np.clip((at - middle[:, None]) / half[:, None], -1.0, 1.0)
        return _divided(self._series(middle, half, every), z)

    def _series(self, middle: Array, half: Array, every: int) -> Array:
        """(T, n) coefficients of S, the first two by force and moment of the pressure."""
        # Imported where it is needed: SciPy's interpolation takes a second.
        from scipy.interpolate import CubicSpline

        angle = np.pi * (np.arange(self.count) + 0.5) / self.count
        at = middle[:, None] + half[:, None] * np.cos(angle)
        slopes = CubicSpline(self.arc[::every], self.gap[::every], bc_type="natural")(at, 1)
        for state in np.flatnonzero(self.beside.any(axis=1)):
            nodes = np.flatnonzero(self.beside[state])
            slopes[state] -= 1 / (at[state, :, None] - self.arc[nodes]) @ self.beside[state, nodes]
        series = slopes @ np.cos(angle[:, None] * np.arange(1, self.count)) / self.count
        moments = self.pressure * (self.arc - middle[:, None])
        series[:, 0] = 2 / np.pi * np.trapezoid(self.pressure, self.arc, axis=1) / half
        series[:, 1] = 4 / np.pi * np.trapezoid(moments, self.arc, axis=1) / half**2
        return np.asarray(series)


def _divided(series: Array, z: Array) -> Array:
    """(T, m) sums of a series (T, n) of U at z (T, m), over their first two terms."""
    last = before = np.zeros_like(z)
    for column in series.T[::-1]:  # Clenshaw
        last, before = column[:, None] + 2 * z * last - before, last
    first = series[:, :1] + 2 * z * series[:, 1:2]
    return np.divide(last, first, out=np.full_like(z, np.nan), where=first != 0)
