# SPDX-License-Identifier: LGPL-3.0-or-later
"""Range checks of arguments, quadrature with kinks, the half-width at a load; for many states."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array

Side = Literal["left", "right"]
_MAX_ITERATIONS = 100


def check_range(
    name: str,
    value: ArrayLike,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    open_low: bool = False,
) -> Array:
    """Return ``value`` as a float array if every entry lies in the range.

    Args:
        name: name of the argument, used in the message.
        value: scalar or array of any shape.
        low: smallest valid value.
        high: largest valid value (included).
        open_low: whether ``low`` itself is excluded.

    Raises:
        ValueError: if an entry is outside the range or not a number.
    """
    array = np.asarray(value, dtype=np.float64)
    above = array > low if open_low else array >= low
    valid = above & (array <= high)
    if not np.all(valid):
        found = array[~valid].flat[0]
        bracket = "(" if open_low or low == -math.inf else "["
        close = ")" if high == math.inf else "]"
        raise ValueError(f"{name} must lie in {bracket}{low:g}, {high:g}{close}, found {found:g}")
    return array


def check_positive(name: str, value: ArrayLike) -> Array:
    """Return ``value`` as a float array of any shape if every entry is positive.

    Raises:
        ValueError: if an entry is zero, negative or not a number.
    """
    return check_range(name, value, low=0.0, open_low=True)


def side_sign(side: Side) -> float:
    """Return +1 at the left edge and -1 at the right one: the direction inward along x.

    Raises:
        ValueError: if ``side`` is neither "left" nor "right".
    """
    if side not in get_args(Side):
        raise ValueError(f"side must be 'left' or 'right', found {side!r}")
    return 1.0 if side == "left" else -1.0


@dataclass(frozen=True)
class _UnitRule:
    """Points and weights on 0 ... 1, all (count,)."""

    points: Array
    weights: Array

    @classmethod
    def smooth(cls, count: int, length: int) -> _UnitRule:
        """Return the Gauss-Legendre rule, filled up to a length with points of no weight."""
        points, weights = np.polynomial.legendre.leggauss(count)
        padding = (0, length - count)
        points = np.pad((points + 1.0) / 2.0, padding, constant_values=0.5)
        return cls(points, np.pad(weights / 2.0, padding))

    def graded(self) -> _UnitRule:
        """Return it in u^4: a root or another power of the distance from 0 becomes smooth."""
        return _UnitRule(self.points**4, 4.0 * self.points**3 * self.weights)


SMOOTH = _UnitRule.smooth(16, 16)
# Few points where the integrand is smooth: divided differences lose their digits next to an edge.
_FEW_PIECES = (_UnitRule.smooth(16, 40), _UnitRule.smooth(40, 40).graded())
# The pieces between the points of a table are short, and its gap is a cubic there.
_MANY_PIECES = (_UnitRule.smooth(10, 10), _UnitRule.smooth(10, 10).graded())
_MANY = 20


def graded_rule(bounds: Array, smooth_ends: tuple[float, ...]) -> tuple[Array, Array]:
    """Return nodes and weights of a Gauss-Legendre rule on pieces, dense next to the kinks.

    Each piece is halved; the nodes of a half are graded to its outer end, unless that end is one of
    ``smooth_ends``. Close to 1e-12 if the integrand is analytic inside the pieces and has powers
    of the distance above 0 at their ends.

    Args:
        bounds: (..., m) non-decreasing ends of the pieces; a piece may have no length.
        smooth_ends: values of bounds at which the integrand is smooth.

    Returns:
        Nodes and weights, both (..., nodes).
    """
    low, high = bounds[..., :-1], bounds[..., 1:]
    ends = np.concatenate([low, high], axis=-1)[..., None]
    reach = np.concatenate([high - low, low - high], axis=-1)[..., None] / 2.0
    smooth = np.isin(ends, smooth_ends)
    even, graded = _MANY_PIECES if low.shape[-1] > _MANY else _FEW_PIECES
    nodes = ends + reach * np.where(smooth, even.points, graded.points)
    weights = np.abs(reach) * np.where(smooth, even.weights, graded.weights)
    shape = (*bounds.shape[:-1], -1)
    return nodes.reshape(shape), weights.reshape(shape)


def solve_half_width(
    load: Callable[[Array], Array],
    load_slope: Callable[[Array], Array],
    force: Array,
    low: Array,
    high: Array,
) -> Array:
    """Return a with P(a) = force, by Newton's method in logarithms, bisection where that leaves.

    ln[P(a) - P(low)] is nearly linear in ln(a - low): exactly so for gaps that are powers.

    Args:
        load: P(a) of an array of half-widths.
        load_slope: dP/da.
        force: loads, any shape.
        low: half-widths of the same shape with P(low) <= force.
        high: half-widths of the same shape with P(high) >= force; may be infinite.

    Raises:
        ValueError: if some load is not reached.
    """
    base = load(low)
    needed = force - base
    loaded = needed > 0.0
    needed = np.where(loaded, needed, 1.0)
    lower = np.full(force.shape, -np.inf)
    upper = np.log(np.where(loaded & (high > low), high - low, np.inf))
    position = np.where(np.isfinite(upper), upper, np.log(np.where(low > 0.0, low, 1.0)))
    for _ in range(_MAX_ITERATIONS):
        a = np.where(loaded, np.minimum(low + np.exp(position), high), low)
        reach = a - low
        excess = load(a) - base
        below = excess < needed
        lower = np.where(below, np.maximum(lower, position), lower)
        upper = np.where(below, upper, np.minimum(upper, position))
        position = position + _log_newton(excess, needed, load_slope(a) * reach)
        position = _keep_between(lower, upper, position)
        moved = np.abs(np.exp(position) - reach) > 1e-15 * a
        if not np.any(moved & loaded):
            break
    a = np.where(loaded, np.minimum(low + np.exp(position), high), low)
    # Next to a flat the load itself has only nine digits.
    missed = loaded & (np.abs(load(a) - force) > 1e-8 * np.maximum(force, needed))
    if np.any(missed):
        found = force[missed].flat[0]
        raise ValueError(f"load must be reached at some half-width, found none for {found:g}")
    return a


def _log_newton(excess: Array, needed: Array, rise: Array) -> Array:
    """Return the step of the logarithm of the reach; 1 where the load does not rise yet."""
    rising = (excess > 0.0) & (rise > 0.0)
    ratio = np.divide(needed, excess, out=np.ones_like(excess), where=rising)
    order = np.divide(excess, rise, out=np.ones_like(excess), where=rising)
    return np.where(rising, np.log(ratio) * order, 1.0)


def _keep_between(lower: Array, upper: Array, trial: Array) -> Array:
    """Return the trial, or a point well inside the bracket if the trial is not within it."""
    open_low, open_high = np.isinf(lower), np.isinf(upper)
    first = np.where(open_low, np.where(open_high, trial, upper) - 2.0, lower)
    last = np.where(open_high, np.where(open_low, trial, lower) + 2.0, upper)
    inside = (trial >= lower) & (trial <= upper)
    return np.where(inside, trial, (first + last) / 2.0)
