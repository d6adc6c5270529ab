# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normal contact of a symmetric profile that is given as a table, such as a measured one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import xlogy

from fretfe._typing import Array
from fretfe.analytic._numerics import check_positive, check_range, solve_half_width

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_FEWEST_POINTS = 4


def tabulated_profile(x: ArrayLike, gap: ArrayLike, e_star: float) -> TabulatedProfile:
    """Return the profile through a table of the gap.

    Args:
        x: (n,) increasing positions, from 0 or over the full width of a symmetric table.
        gap: (n,) gap at these, 0 at x = 0 and nowhere falling away from it.
        e_star: composite modulus.

    Raises:
        ValueError: if the table has fewer than 4 points on a side, its positions do not increase,
            it has no point at x = 0 with gap 0, is not symmetric, or its gap falls with |x|.
    """
    position, height = np.asarray(x, dtype=np.float64), np.asarray(gap, dtype=np.float64)
    if position.ndim != 1 or position.shape != height.shape:
        raise ValueError(
            f"x and gap must be of the same length, found shapes {position.shape}, {height.shape}"
        )
    if not np.all(np.isfinite(position) & np.isfinite(height)):
        raise ValueError("x and gap must be finite, found nan or inf")
    if np.any(np.diff(position) <= 0.0):
        row = int(np.argmax(np.diff(position) <= 0.0))
        raise ValueError(f"x must increase, found {position[row]:g}, {position[row + 1]:g}")
    if position.size and position[0] < 0.0:
        position, height = _right_half(position, height)
    if position.size < _FEWEST_POINTS:
        raise ValueError(
            f"x must have at least {_FEWEST_POINTS} points from 0, found {position.size}"
        )
    if position[0] != 0.0 or height[0] != 0.0:
        raise ValueError(
            f"the table must have gap 0 at x = 0, found gap {height[0]:g} at {position[0]:g}"
        )
    if np.any(np.diff(height) < 0.0):
        row = int(np.argmax(np.diff(height) < 0.0))
        raise ValueError(
            f"gap must not fall with |x|, found {height[row]:g} at {position[row]:g} "
            f"and {height[row + 1]:g} at {position[row + 1]:g}"
        )
    # Brings SciPy's optimisers along, which nothing else here needs.
    from scipy.interpolate import CubicSpline

    return TabulatedProfile(CubicSpline(position, height, bc_type=((1, 0.0), "not-a-knot")), e_star)


def _right_half(position: Array, height: Array) -> tuple[Array, Array]:
    """Return the part x >= 0 of a table that is symmetric up to rounding in its text form."""
    mirrored = np.abs(position + position[::-1]) <= 1e-6 * position[-1]
    even = np.abs(height - height[::-1]) <= 1e-6 * np.max(np.abs(height))
    if not np.all(mirrored & even):
        row = int(np.argmin(mirrored & even))
        raise ValueError(
            f"a table from x < 0 must be symmetric, found gap {height[row]:g} at {position[row]:g} "
            f"and {height[-1 - row]:g} at {position[-1 - row]:g}"
        )
    middle = position.size // 2
    return position[middle:], height[middle:]


@dataclass(frozen=True)
class TabulatedProfile:
    """The cubic spline through the right half of a table, with slope 0 at x = 0.

    A spline rather than a monotone interpolation, because the pressure follows from g'': it is
    continuous and piecewise linear here, and jumps or vanishes at the points of a monotone one. The
    spline is exact for parabolas. Where the curvature of the gap jumps, as at the end of a flat,
    it overshoots by 5 % of the slope gained over one spacing h, over some spacings: the error is of
    the order h in the pressure there and h^3 in the load and in K_N. Noise must be smoothed
    beforehand; a corner at x = 0 is rounded over h.

    Between the points g'' = alpha + beta t; with A = sqrt(a^2 - t^2), B = sqrt(a^2 - x^2)

        P    = E* int_0^a A g'' dt           P' = E* a int_0^a g''/A dt
        p(x) = (E*/pi) int_0^a g'' ln[(A + B)/sqrt|t^2 - x^2|] dt

    (the formulas of ``fretfe.analytic.profiles`` by parts), integrated in closed form. All methods
    take arrays of any shape and raise a ValueError beyond the table, except ``gap`` and
    ``gap_slope``, which are NaN there.
    """

    spline: CubicSpline
    e_star: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_positive("e_star", self.e_star)

    @property
    def kinks(self) -> tuple[float, ...]:
        """None: g'' is continuous. The end of a flat is not told apart from other points."""
        return ()

    @property
    def inner_points(self) -> tuple[float, ...]:
        """The points between the ends of the table, where g''' jumps."""
        return tuple(float(point) for point in self.spline.x[1:-1])

    @property
    def largest_half_width(self) -> float:
        """End of the table."""
        return float(self.spline.x[-1])

    def gap(self, x: ArrayLike) -> Array:
        """Return g(x), NaN beyond the table."""
        return self.spline(np.abs(np.asarray(x, dtype=np.float64)), extrapolate=False)

    def gap_slope(self, x: ArrayLike) -> Array:
        """Return g'(x), odd in x, NaN beyond the table."""
        position = np.asarray(x, dtype=np.float64)
        return np.sign(position) * self.spline(np.abs(position), 1, extrapolate=False)

    def load(self, half_width: ArrayLike) -> Array:
        """Return P(a)."""
        a = self._check_half_width(half_width)[..., None]
        t = np.minimum(self.spline.x, a)
        height = np.sqrt((a - t) * (a + t))
        constant = (t * height + a**2 * self._angle(t, a)) / 2.0
        return self.e_star * self._sum(constant, -(height**3) / 3.0)

    def load_slope(self, half_width: ArrayLike) -> Array:
        """Return dP/da."""
        a = self._check_half_width(half_width)[..., None]
        t = np.minimum(self.spline.x, a)
        height = np.sqrt((a - t) * (a + t))
        return self.e_star * a[..., 0] * self._sum(self._angle(t, a), -height)

    def half_width(self, load: ArrayLike) -> Array:
        """Return a at a load P >= 0.

        Raises:
            ValueError: if the load is negative, or so large that a lies beyond the table.
        """
        points = self.spline.x
        loads = self.load(points)
        force = check_range("load", load, low=0.0)
        # Room for round-off in a load that was computed from the last point.
        if np.any(force > loads[-1] * (1.0 + 1e-12)):
            raise ValueError(
                f"load must not exceed {loads[-1]:g}, at which the contact reaches the end of the "
                f"table at {points[-1]:g}, found {np.max(force):g}"
            )
        force = np.minimum(force, loads[-1])
        # The last point whose load is not above: on a flat the spline has loads of both signs.
        least_beyond = np.minimum.accumulate(loads[::-1])[::-1]
        row = np.searchsorted(least_beyond, force, side="right") - 1
        high = points[np.minimum(row + 1, points.size - 1)]
        return solve_half_width(self.load, self.load_slope, force, points[row], high)

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> Array:
        """Return p(x), zero outside the contact."""
        a = self._check_half_width(half_width)
        distance, a = np.broadcast_arrays(np.abs(np.asarray(x, dtype=np.float64)), a)
        inside = distance < a
        found = np.zeros(a.shape)
        found[inside] = (
            self.e_star
            / np.pi
            * self._sum(
                *_kernels(
                    distance[inside][:, None],
                    np.minimum(self.spline.x, a[inside][:, None]),
                    a[inside][:, None],
                )
            )
        )
        return found

    def _check_half_width(self, half_width: ArrayLike) -> Array:
        return check_range("half_width", half_width, low=0.0, high=self.largest_half_width)

    def _angle(self, t: Array, a: Array) -> Array:
        return np.arcsin(np.divide(t, a, out=np.zeros_like(t), where=a > 0.0))

    def _sum(self, constant: Array, linear: Array) -> Array:
        """Return the integral of kernel times g'' from the primitives (..., n) at the points.

        Args:
            constant: primitive of the kernel.
            linear: primitive of t times the kernel.
        """
        slope, at_start = self.spline.derivative(2).c
        at_zero = at_start - slope * self.spline.x[:-1]
        return np.sum(at_zero * np.diff(constant) + slope * np.diff(linear), axis=-1)


def _kernels(x: Array, t: Array, a: Array) -> tuple[Array, Array]:
    """Return the primitives over t of the kernel of the pressure and of t times it, 0 <= x < a."""
    at_t, at_x = np.sqrt((a - t) * (a + t)), np.sqrt((a - x) * (a + x))
    distance = np.abs((t - x) * (t + x))
    constant = xlogy(t, at_t + at_x) - xlogy(x, (x * at_t + t * at_x) / a)
    constant += at_x * np.arcsin(t / a) - xlogy(t - x, distance) / 2.0
    squares = (t - x) * (t + x)
    linear = xlogy(squares, at_t + at_x) / 2.0 - xlogy(squares, distance) / 4.0 - at_t * at_x / 2.0
    return constant, linear
