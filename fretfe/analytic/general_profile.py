# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normal contact of a symmetric profile that is given by the slope of its gap, by quadrature."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.analytic._numerics import check_positive, check_range, graded_rule, solve_half_width

_RIGHT_ANGLE = np.pi / 2.0
# Bounds the memory of the quadrature: some megabytes per array.
_BLOCK = 4096
# Stands for 0 where the slope may not be evaluated at 0 itself.
_NEXT_TO_ZERO = 1e-150


@dataclass(frozen=True)
class GeneralProfile:
    """Any symmetric profile with g'(t) >= 0, by quadrature; all methods take arrays of any shape.

    With t = a sin(angle), angle from 0 to pi/2:

        P(a)  = E* a int sin g'(t) dangle
        P'(a) = E* int [g'(a) - sin g'(t)]/cos^2 dangle
        p(x)  = (E*/pi) sqrt(a^2 - x^2) int [t g'(t) - x g'(x)]/(t^2 - x^2) dangle

    (the inversion of the integral equation of the half-plane, Johnson 1985, with the principal
    value taken out; the two halves of the contact added). Relative accuracy about 1e-12 for gaps
    that are smooth between the kinks and for powers like |x|^1.5; less where the pressure has or
    almost has a logarithm: 1e-6 at 1e-6 a from a corner, 1e-3 at the centre of |x|^1.2. The contact
    is one interval if g' does not decrease.

    Args:
        slope: g'(t) as a function of an array of t > 0.
        e_star: composite modulus.
        kinks: positions t >= 0 where g' or one of its derivatives jumps or is infinite.
    """

    slope: Callable[[Array], ArrayLike]
    e_star: float
    kinks: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_positive("e_star", self.e_star)
        check_range("kinks", self.kinks, low=0.0)

    def gap(self, x: ArrayLike) -> Array:
        """Return g(x), the integral of the slope from 0 to |x|."""
        distance = np.abs(np.asarray(x, dtype=np.float64))
        bounds = np.minimum([0.0, *sorted(self.kinks), np.inf], distance[..., None])
        nodes, weights = graded_rule(bounds, ())
        return np.sum(weights * self._slope_at(nodes), axis=-1)

    def gap_slope(self, x: ArrayLike) -> Array:
        """Return g'(x), odd in x."""
        position = np.asarray(x, dtype=np.float64)
        return np.sign(position) * self._slope_at(np.abs(position))

    def load(self, half_width: ArrayLike) -> Array:
        """Return P(a)."""
        a = check_range("half_width", half_width, low=0.0)
        width = np.maximum(a, _NEXT_TO_ZERO)
        angle, weight = self._rule(width)
        slope = self._slope_at(width[..., None] * np.sin(angle))
        return self.e_star * a * np.sum(weight * np.sin(angle) * slope, axis=-1)

    def load_slope(self, half_width: ArrayLike) -> Array:
        """Return dP/da."""
        width = np.maximum(check_range("half_width", half_width, low=0.0), _NEXT_TO_ZERO)
        angle, weight = self._rule(width)
        slope = self._slope_at(width[..., None] * np.sin(angle))
        fall = self._slope_at(width)[..., None] - np.sin(angle) * slope
        return self.e_star * np.sum(weight * fall / np.cos(angle) ** 2, axis=-1)

    def half_width(self, load: ArrayLike) -> Array:
        """Return a at a load P >= 0; at P = 0 the half-width of the flat, 0 if there is none."""
        force = check_range("load", load, low=0.0)
        starts = np.array([0.0, *sorted(self.kinks)])
        reached = np.maximum.accumulate(self.load(starts))
        low = starts[np.searchsorted(reached, force, side="right") - 1]
        return solve_half_width(
            self.load, self.load_slope, force, low, np.full(force.shape, np.inf)
        )

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> Array:
        """Return p(x), zero outside; not meaningful at a corner, where it is infinite."""
        a = check_range("half_width", half_width, low=0.0)
        distance, width = np.broadcast_arrays(np.abs(np.asarray(x, dtype=np.float64)), a)
        inside = distance < width
        found = np.zeros(distance.shape)
        at, within = distance[inside], width[inside]
        blocks = range(0, at.size, _BLOCK)
        parts = [self._inside(at[i : i + _BLOCK], within[i : i + _BLOCK]) for i in blocks]
        found[inside] = np.concatenate([np.zeros(0), *parts])
        return found

    def _inside(self, x: Array, a: Array) -> Array:
        """Return p(x) for 0 <= x < a, both (n,)."""
        place = np.arcsin(x / a)[:, None]
        angle, weight = self._rule(a, place)
        sine = np.sin(angle)
        excess = sine * self._slope_at(a[:, None] * sine)
        excess -= np.sin(place) * self._slope_at(x)[:, None]
        # The difference of the squares of the sines; 0 at most in a piece of no length.
        squares = np.sin(angle - place) * np.sin(angle + place)
        quotient = np.divide(excess, squares, out=np.zeros_like(excess), where=squares != 0.0)
        return self.e_star / np.pi * np.cos(place[:, 0]) * np.sum(weight * quotient, axis=-1)

    def _rule(self, a: Array, *places: Array) -> tuple[Array, Array]:
        """Return angles and weights over 0 ... pi/2, split at the kinks and further places."""
        sines = np.minimum(np.asarray(self.kinks), a[..., None]) / a[..., None]
        ends = np.broadcast_to([0.0, _RIGHT_ANGLE], (*a.shape, 2))
        bounds = np.concatenate([ends, np.arcsin(sines), *places], axis=-1)
        return graded_rule(np.sort(bounds, axis=-1), (_RIGHT_ANGLE,))

    def _slope_at(self, t: Array) -> Array:
        slope = np.asarray(self.slope(np.maximum(t, _NEXT_TO_ZERO)), dtype=np.float64)
        return np.broadcast_to(slope, t.shape)
