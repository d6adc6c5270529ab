# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fits of the pressure next to an edge to sampled values, and what many fits agree on.

Next to an edge the nodal values of a discrete traction oscillate, so every fit leaves out the
outermost nodes; how many, and how far a fit reaches inward, is varied.
Errors are estimated from the residual.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from fretfe.analytic._arguments import FloatArray


class SquareRootFit(NamedTuple):
    """Edge and K_N of p = K_N sqrt(s) + ..., with standard errors."""

    position: float
    k_n: float
    error_position: float
    error_k_n: float


def consensus(values: FloatArray, errors: FloatArray, score: FloatArray) -> tuple[float, float]:
    """Return median and spread over the fits whose score is within a factor 2 of the best.

    Args:
        values: (m,) results of the fits.
        errors: (m,) their standard errors.
        score: (m,) non-negative, small is good.

    Returns:
        Median of the values, and their spread: twice the smallest standard error and half the range
        of the values, as root of the sum of squares. With random noise it holds the truth in 95 %
        of all cases or more (measured on Hertz and flat-and-rounded pressures).
    """
    kept = score <= 2.0 * score.min()
    spread = np.hypot(2.0 * errors[kept].min(), np.ptp(values[kept]) / 2)
    return float(np.median(values[kept])), float(spread)


def pressure_windows(nodes: int) -> list[tuple[int, int]]:
    """Return (first, end) of all windows: 2 to 5 outermost nodes left out, growing by a third."""
    windows, length = [], 6
    while length + 5 <= nodes:
        windows += [(drop, drop + length) for drop in (2, 3, 4, 5) if drop + length + 3 <= nodes]
        length = int(np.ceil(1.3 * length))
    return windows


def fit_square_root(s: FloatArray, p: FloatArray) -> SquareRootFit | None:
    """Return edge, K_N and their standard errors from a cubic through p^2, None if it has no edge.

    ``s`` is the distance from the outermost node. Errors of p are taken as equal at all nodes.
    """
    scale = s[-1]
    powers = np.vander(s / scale, 4, increasing=True) / (2 * p[:, None])
    coefficients, _, rank, _ = np.linalg.lstsq(powers, p / 2)
    cubic = Polynomial(coefficients)
    roots = cubic.roots()
    # The edge is the last zero before the window.
    roots = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real < s[0] / scale)]
    if rank < 4 or roots.size == 0 or roots.max() < -1.0 or cubic.deriv()(roots.max()) <= 0.0:
        return None
    root = roots.max()
    slope, curvature = cubic.deriv()(root), cubic.deriv(2)(root)
    order = np.arange(4)
    edge_gradient = -(root**order) / slope
    slope_gradient = order * root ** np.maximum(order - 1, 0) + curvature * edge_gradient
    residual = powers @ coefficients - p / 2
    covariance = np.linalg.pinv(powers.T @ powers) * (residual @ residual) / (s.size - 4)
    k_n = np.sqrt(slope / scale)
    gradients = np.array([scale * edge_gradient, slope_gradient * k_n / (2 * slope)])
    errors = np.sqrt(np.diag(gradients @ covariance @ gradients.T))
    return SquareRootFit(root * scale, float(k_n), float(errors[0]), float(errors[1]))
