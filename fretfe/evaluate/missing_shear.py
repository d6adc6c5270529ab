# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressure by the shear that an edge between unlike bodies misses to sliding.

Between unlike bodies the pressure is a power law with a series in the slip zone only. Where that
ends shear begins to be missing, and the pressure has a part that fits do not know: it is taken off
before, of plane contacts at their nodes, of solids at rows of nodes along their fronts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from fretfe._typing import Array

# Iterations for what missing shear does to the pressure, which hardly depends on where the edge is.
MISSING_ITERATIONS = 2

Fit = TypeVar("Fit")
Missing = TypeVar("Missing")


class MissingShear:
    """Pressure by the shear that an edge misses to sliding, between unlike bodies.

    Next to an edge the pressure and the inward shear q on body 2 obey T[p] + beta q = a smooth
    function, T[p](s) = 1/pi PV int p(t)/(t - s) dt. With q = r p + m, cot(pi lambda) = beta r, and
    F = int m t^-lambda/(t - s) dt over the contact

        p = s^lambda (smooth + beta sin^2(pi lambda) F/pi) - beta sin(pi lambda) cos(pi lambda) m

    m vanishes in the slip zone, where the whole is a power law with a series. At the end of the
    zone F has a kink, and the series ends. Source: Carleman's singular integral equation (F. D.
    Gakhov, Boundary Value Problems, section 21), bounded at the edge; other edges, and what bodies
    do that are no half-planes, are smooth.

    Args:
        x: (n,) places where m is known, increasing.
        dundurs: beta.
    """

    def __init__(self, x: Array, dundurs: float) -> None:
        self._x, self._dundurs = x, dundurs
        self._kernel = self._integrals(x)

    def pressure(self, missing: Array, exponent: Array, inward: int, position: Array) -> Array:
        """(T, n) pressure by F - F(0) and by m; the rest of F belongs to K_N s^lambda.

        Args:
            missing: (T, n) m, linear between its places.
            exponent: (T,) lambda.
            inward: direction into the contact along x, 1 or -1.
            position: (T,) of the edge; nothing is known where it is NaN.
        """
        s = np.fmax(inward * (self._x - position[:, None]), 0.0)
        power = s ** exponent[:, None]
        density = np.divide(missing, power, out=np.zeros_like(missing), where=power > 0)
        far = density @ self._kernel.T
        at_edge = np.einsum("tn,tn->t", density, self._integrals(position))
        square, angle = np.sin(np.pi * exponent) ** 2, np.pi * exponent
        series = power * inward * (far - at_edge[:, None]) / np.pi
        parts = series - missing / np.tan(angle)[:, None]
        return np.nan_to_num(self._dundurs * square[:, None] * parts)

    def _integrals(self, places: Array) -> Array:
        """(m, n) PV int of 1/(x - place) with the hat function of each node, at places (m,)."""
        distance = self._x - places[:, None]
        # u ln|u| - u, the second integral of 1/u.
        second = distance * (np.log(np.where(distance, np.abs(distance), 1.0)) - 1)
        slopes = np.diff(second, axis=1) / np.diff(self._x)
        return np.asarray(np.diff(slopes, prepend=0.0, append=0.0))


def without_missing(
    fit: Fit, missing: Missing, coarser: Sequence[Missing], refit: Callable[[Fit, Missing], Fit]
) -> tuple[Fit, list[Fit]]:
    """The fit to pressures without what missing shear does, and those by coarser missing shear.

    What is between the places is as good as what they tell without every other one: by how much
    the latter fits are off belongs in the error bars.

    Args:
        fit: to the pressure itself.
        missing: shear.
        coarser: the same by some of its places.
        refit: gives the fit without what some shear does, for an edge as of another fit.
    """
    for _ in range(MISSING_ITERATIONS):
        fit = refit(fit, missing)
    return fit, [refit(fit, each) for each in coarser]


def widened(spread: Array, values: Array, others: Sequence[Array]) -> Array:
    """Error bars with what others than the values say, as far as they are known."""
    return np.hypot(spread, np.fmax.reduce([np.abs(each - values) for each in others]))


def without_every_other(x: Array, values: Array) -> tuple[Array, Array]:
    """(T, n) values at places x (n,), linear over every other inner one of them, in both ways."""
    first, second = values.copy(), values.copy()
    for begin, found in ((1, first), (2, second)):
        left = (x[begin + 1 :: 2] - x[begin:-1:2]) / (x[begin + 1 :: 2] - x[begin - 1 : -2 : 2])
        found[:, begin:-1:2] = (
            left * values[:, begin - 1 : -2 : 2] + (1 - left) * values[:, begin + 1 :: 2]
        )
    return first, second
