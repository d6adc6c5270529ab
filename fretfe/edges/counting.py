# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories that add up increments, of which some may be unknown."""

from __future__ import annotations

import math

import numpy as np

from fretfe._typing import Array


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
