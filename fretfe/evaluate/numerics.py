# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numerics of the evaluation: means of many fits, sums of increments, fits of polynomials."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array, Bools, Indices, Positions

# Weight of a systematic error of known shape, in the selection and in the interval.
SYSTEMATIC = 2.0
# Order of the highest polynomial: one more than the highest that is used, to compare with.
HIGHEST = 5
POWERS = np.arange(HIGHEST + 1)
# Newton's method for the root: iterations at most, and steps that are none, in window lengths.
ITERATIONS = 12
ROUND_OFF = 1e-15
# Loads that differ by less than this part of the largest are equal: the last one decides.
EQUAL_LOADS = 1e-6
# Edges may stand so many elements outside the outermost node.
FARTHEST = 3.0
# Pressures of a fit are taken as this part of their error at least: weights stay finite.
SMALLEST_PRESSURE = 0.3


def average(
    values: Array, errors: Array, shifts: Array, misfit: Array, interval: ArrayLike
) -> tuple[Array, Array, Array]:
    """Return means (...), error bars (...) and weights (..., windows, orders - 1).

    Weights go with the inverse fourth power of a pessimistic error: the standard error, the
    systematic error, and what the next order over the same window changes, as root of the sum of
    squares. In the error bar that change counts only as far as it exceeds its own scatter, and the
    scatter of the fits about their mean is added. A bar is half the width of an interval that is
    meant to hold the truth with 95 % (measured: docs/edges.md); NaN and infinity without a fit.

    Args:
        values: (..., windows, orders) NaN where there is no fit.
        errors: (..., windows, orders) standard errors.
        shifts: (..., windows, orders) systematic errors.
        misfit: (..., windows, orders) chi^2 over degrees of freedom.
        interval: (...) half-width of the 95 % interval over the estimated error. Less than 1.96, as
            the scatter of the fits about their mean counts in full.
    """
    changes = np.diff(values) ** 2
    bias = np.maximum(changes - np.diff(errors**2), 0.0)
    values, shifts = values[..., :-1], shifts[..., :-1]
    misfit = np.maximum(misfit[..., :-1], 1.0)
    variance = errors[..., :-1] ** 2 * misfit
    # The misfit once more: where all orders fail alike, none of them shows by how much.
    squares = variance * misfit + changes + (SYSTEMATIC * shifts) ** 2
    known = np.isfinite(squares)
    found, weights = known.any(axis=(-2, -1)), _weights(squares, known)

    def mean(part: Array) -> Array:
        return np.sum(weights * part, axis=(-2, -1), where=known)

    means = mean(values)
    scatter = (values - means[..., None, None]) ** 2
    square = (
        np.square(interval) * mean(variance + bias + scatter) + (SYSTEMATIC * mean(shifts)) ** 2
    )
    return np.where(found, means, np.nan), np.where(found, np.sqrt(square), np.inf), weights


def _weights(squares: Array, known: Bools) -> Array:
    """Return weights that go with the inverse square of known numbers and add up to 1."""
    best = np.min(squares, axis=(-2, -1), keepdims=True, where=known, initial=np.inf)
    weights = np.divide(best, squares, where=known, out=np.zeros_like(squares)) ** 2
    found = known.any(axis=(-2, -1))
    weights[found] /= weights[found].sum(axis=(-2, -1), keepdims=True)
    return weights


def most_loaded(force: Array, states: Indices) -> int:
    """The state of the largest P of some states, the last of equal ones.

    Args:
        force: (T,) P.
        states: one at least.
    """
    loads = force[states]
    return int(states[np.flatnonzero(loads >= (1 - EQUAL_LOADS) * loads.max())[-1]])


def count_up(increments: Array, cycle: tuple[int, int] | None) -> Array:
    """(T, ...) sums of the increments of all steps, counted from where all of them are known.

    That is the first state, or the last state up to the beginning of the cycle (to the end without
    one) at which an unknown step ends; it is NaN before. A step of the cycle that is unknown leaves
    nothing known behind it.

    Args:
        increments: (T-1, ...) of the steps; NaN where unknown.
        cycle: its first and last state, or None.
    """
    flat = increments.reshape(len(increments), math.prod(increments.shape[1:]))
    unknown = ~np.isfinite(flat)
    unknown[cycle[0] if cycle is not None else len(flat) :] = False
    sums = np.full((len(flat) + 1, flat.shape[1]), np.nan)
    for column, (steps, gaps) in enumerate(zip(flat.T, unknown.T, strict=True)):
        start = int(np.flatnonzero(gaps)[-1]) + 1 if gaps.any() else 0
        sums[start:, column] = np.concatenate([[0.0], np.cumsum(steps[start:])])
    return sums.reshape(-1, *increments.shape[1:])


def last_known(values: Array, cycle: Indices) -> float:
    """The last of values (T,) that is known, up to the end of the cycle; NaN if none is."""
    values = values[: cycle[-1] + 1] if len(cycle) else values
    known = values[np.isfinite(values)]
    return float(known[-1]) if len(known) else np.nan


def rising_zero(coefficients: Array, inverse: Array, farthest: float) -> tuple[float, float]:
    """Zero next to 0 of a polynomial that rises, and its standard error; NaN without one.

    Args:
        coefficients: (m,) of the powers from 0 on.
        inverse: (m, n) that gives them from n values over their errors.
        farthest: the zero from 0.
    """
    powers, zero, slope = np.arange(len(coefficients)), 0.0, 1.0
    for _ in range(10):  # Newton
        slope = float(coefficients[1:] @ (powers[1:] * zero ** powers[:-1]))
        if not slope > 0 or abs(zero) > farthest:
            return np.nan, np.nan
        zero -= float(coefficients @ zero**powers) / slope
    return zero, float(np.linalg.norm(zero**powers @ inverse)) / slope


def pressure_moments(x: Array, p: Array, centre: Array) -> Array:
    """Return (T,) moments of piecewise-linear pressures (T, n) at x (n,) about centres (T,)."""
    arm, left, right = x - centre[:, None], p[:, :-1], p[:, 1:]
    moments = arm[:, :-1] * (2 * left + right) + arm[:, 1:] * (left + 2 * right)
    return np.asarray(moments @ np.diff(x) / 6)


def weighted_triangles(s: Array, p: Array, errors: Array, tails: Array) -> Array:
    """Return triangular factors of (1, z, ... z^5, p^2, tail), z = s/s_last, over 2 p errors.

    Args:
        s: (T, l) distances from the outermost node, l >= 6.
        p: (T, l) pressures.
        errors: (T, l) their standard deviations.
        tails: (T, l) systematic errors of p.

    Returns:
        (T, 8, 8). The p in the weights is that of a cubic fit: samples there would bias it. With m
        for it, p - sqrt(C) = (2 m p - m^2 - C)/(2 m) to first order, C the polynomial.
    """
    z, least = s / s[:, -1:], SMALLEST_PRESSURE * errors
    powers = np.stack([np.ones_like(z), z, z**2, z**3, z**4, z**5], axis=-1)
    cubic, m = powers[..., :4], np.maximum(p, least)
    for _ in range(2):
        triangles = _triangles([cubic, _squared(m, p)], m, errors)
        cubics = np.linalg.solve(triangles[:, :4, :4], triangles[:, :4, 4:])
        m = np.maximum(np.sqrt(np.maximum((cubic @ cubics)[..., 0], 0.0)), least)
    return _triangles([powers, _squared(m, p), (2 * m * tails)[..., None]], m, errors)


def _squared(m: Array, p: Array) -> Array:
    return (2 * m * p - m**2)[..., None]


def _triangles(parts: list[Array], m: Array, errors: Array) -> Array:
    """Return triangular factors of columns (T, l, ...) over 2 m errors."""
    columns = np.concatenate(parts, axis=-1) / (2 * m * errors)[..., None]
    missing = columns.shape[-1] - columns.shape[-2]
    if missing > 0:
        columns = np.pad(columns, ((0, 0), (0, missing), (0, 0)))
    return np.asarray(np.linalg.qr(columns, mode="r"))


def edge_terms(
    triangles: Array, order: int, length: Positions, scale: Array, bounds: Array
) -> Array:
    """Return (7, T) edge, K_N, their standard errors, their systematic errors, and chi^2/nu.

    Args:
        triangles: (T, 8, 8) from ``weighted_triangles``.
        order: of the polynomial, 2 to 5.
        length: (T,) numbers of nodes in the windows, at least order + 3.
        scale: (T,) lengths s_last of the windows.
        bounds: (2, T) smallest and largest edge; NaN is returned for others.
    """
    size = order + 1
    inverse = np.linalg.inv(triangles[:, :size, :size])
    coefficients, shifts = np.moveaxis(inverse @ triangles[:, :size, 6:], -1, 0)
    root = _root(coefficients, bounds / scale)
    position, k_n, gradients = _edge(coefficients, root, scale)
    errors = np.linalg.norm(gradients @ inverse, axis=-1)
    systematic = (gradients @ shifts[..., None])[..., 0]
    misfit = np.sum(triangles[:, size:7, 6] ** 2, axis=1) / (length - size)
    return np.stack([position, k_n, *errors.T, *systematic.T, misfit])


def _root(coefficients: Array, bounds: Array) -> Array:
    """Return (m,) the root of polynomials (m, k) next to 0, by Newton's method; NaN outside."""
    root = np.zeros(len(coefficients))
    with np.errstate(all="ignore"):  # what runs away is not within the bounds
        for _ in range(ITERATIONS):
            value, slope = _value_and_slope(coefficients, root)
            step = value / slope
            root = root - step
            if not (np.abs(step) > ROUND_OFF).any():
                break
        value, slope = _value_and_slope(coefficients, root)
        tolerance = 1e-9 * np.abs(coefficients).max(axis=1)
        found = (root >= bounds[0]) & (root < bounds[1]) & (np.abs(value) < tolerance) & (slope > 0)
    return np.where(found, root, np.nan)


def _value_and_slope(coefficients: Array, z: Array) -> tuple[Array, Array]:
    """Return value (m,) and slope (m,) of polynomials (m, k) at z (m,), by Horner's rule."""
    value, slope = coefficients[:, -1], np.zeros(len(z))
    for column in coefficients.T[-2::-1]:
        slope = slope * z + value
        value = value * z + column
    return value, slope


def _edge(coefficients: Array, root: Array, scale: Array) -> tuple[Array, Array, Array]:
    """Return edge (m,), K_N (m,), and their gradients (m, 2, k) by the coefficients (m, k)."""
    orders = np.arange(coefficients.shape[1])
    powers = root[:, None] ** orders
    derivatives = orders * root[:, None] ** np.maximum(orders - 1, 0)
    slope = np.sum(coefficients * derivatives, axis=1)
    curvature = np.sum(
        coefficients * orders * (orders - 1) * root[:, None] ** np.maximum(orders - 2, 0), axis=1
    )
    k_n = np.sqrt(slope / scale)
    edge_gradient = -powers / slope[:, None]
    slope_gradient = derivatives + curvature[:, None] * edge_gradient
    gradients = [scale[:, None] * edge_gradient, slope_gradient * (k_n / (2 * slope))[:, None]]
    return root * scale, k_n, np.stack(gradients, axis=1)


def consensus(values: Array, errors: Array, score: Array) -> tuple[Array, Array]:
    """Return median and spread over the fits whose score is within a factor 2 of the best.

    Args:
        values: (..., m) results of m fits of each of any number of quantities.
        errors: (..., m) their standard errors.
        score: (..., m) non-negative, small is good; NaN where there is no fit.

    Returns:
        Medians (...) of the values, and their spreads (...): twice the smallest standard error and
        half the range of the values, as root of the sum of squares. With random noise it holds the
        truth in 95 % of all cases or more (measured on Hertz and flat-and-rounded pressures).
        NaN and infinity without any fit.
    """
    found = np.isfinite(score).any(axis=-1)
    medians, spreads = np.full(found.shape, np.nan), np.full(found.shape, np.inf)
    if found.any():
        medians[found], spreads[found] = _agreed(values[found], errors[found], score[found])
    return medians, spreads


def _agreed(values: Array, errors: Array, score: Array) -> tuple[Array, Array]:
    """Return medians and spreads (r,) of quantities that have a fit; arguments (r, m)."""
    kept = score <= 2.0 * np.nanmin(score, axis=1, keepdims=True)
    ordered = np.sort(np.where(kept, values, np.inf), axis=1)
    count, rows = kept.sum(axis=1), np.arange(len(kept))
    medians = (ordered[rows, (count - 1) // 2] + ordered[rows, count // 2]) / 2
    ranges = ordered[rows, count - 1] - ordered[:, 0]
    error = np.where(kept, errors, np.inf).min(axis=1)
    return medians, np.hypot(2.0 * error, ranges / 2)
