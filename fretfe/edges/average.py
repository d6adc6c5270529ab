# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mean of many fits of one quantity, weighted by their estimated errors."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array, Bools

# Weight of a systematic error of known shape, in the selection and in the interval.
SYSTEMATIC = 2.0


def average(
    values: Array,
    errors: Array,
    shifts: Array,
    misfit: Array,
    interval: ArrayLike,
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
