# SPDX-License-Identifier: LGPL-3.0-or-later
"""Weighted fits of polynomials to squared pressures, solved as stacks of small matrices."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Positions

# Order of the highest polynomial: one more than the highest that is used, to compare with.
HIGHEST = 5
POWERS = np.arange(HIGHEST + 1)
# Newton's method for the root: iterations at most, and steps that are none, in window lengths.
ITERATIONS, ROUND_OFF = 12, 1e-15
# Edges may stand so many elements outside the outermost node.
FARTHEST = 3.0
# Pressures of a fit are taken as this part of their error at least: weights stay finite.
SMALLEST_PRESSURE = 0.3


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
