# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that half-planes would need for the factors of a plane contact."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.edges import effective_bulk_tension, shear_force_from_factors
from fretfe.evaluate.numerics import count_up
from fretfe.history.solution import ContactHistory, Solution
from fretfe.history.state_array import blocks


def tension_history(k_t: Array, half_width: Array, cycle: tuple[int, int] | None) -> Array:
    """(T,) effective bulk tension, counted like K_T.

    Args:
        k_t: (2, T) at the left and the right front.
        half_width: (T,), NaN without contact.
        cycle: its first and last state, or None.
    """
    steps, a = _steps(k_t, half_width)
    return count_up(effective_bulk_tension(steps[0], steps[1], a), cycle)


def shear_mismatch(
    k_t: Array, half_width: Array, shear_force: Array, cycle: tuple[int, int] | None
) -> float:
    """(range of Q that half-planes need for K_T at the two fronts)/(range of Q) - 1; NaN if none.

    Args:
        k_t: (2, T) at the left and the right front.
        half_width: (T,), NaN without contact.
        shear_force: (T,) Q of full stick.
        cycle: its first and last state, or None.
    """
    if cycle is None:
        return np.nan
    states = slice(cycle[0], cycle[1] + 1)
    if np.ptp(shear_force[states]) <= 1e-9 * np.abs(shear_force).max():
        return np.nan
    steps, a = _steps(k_t, half_width)
    needed = count_up(shear_force_from_factors(steps[0], steps[1], a), cycle)
    return float(np.ptp(needed[states]) / np.ptp(shear_force[states]) - 1)


def full_stick_shear_force(solution: Solution, contact: ContactHistory) -> Array:
    """(T,) Q of the increments of full stick, added up over the steps like K_T.

    Where slip changes how the loads divide between several contacts, this is not the Q of the
    contact itself, but the one that belongs to K_T. Without increments it is the Q of the contact.
    """
    increments, weights = contact.full_stick, contact.surface.weights
    if not len(increments.fields):
        parts = blocks(len(contact.traction), contact.traction[0].size)
        return np.concatenate([contact.traction[part, :, 1] @ weights for part in parts])
    # Area -1, the last entry, is that of states without contact.
    parts = blocks(len(increments.fields), increments.fields[0].size)
    units = np.concatenate(
        [np.einsum("n,unj->uj", weights, increments.fields[part, :, 1]) for part in parts]
    )
    units = np.vstack([units, np.zeros(units.shape[1])])[increments.area]
    known = increments.area >= 0
    pairs = known[1:].astype(float) + known[:-1]
    mean = (units[1:] + units[:-1]) / np.maximum(pairs, 1.0)[:, None]
    steps = np.einsum("tj,tj->t", mean, np.diff(solution.driver_values, axis=0))
    return count_up(steps * contact.friction.acts[1:], solution.cycle)


def _steps(k_t: Array, half_width: Array) -> tuple[Array, Array]:
    """(2, T-1) increments of K_T, and (T-1,) half-width in the middle of each step."""
    a = (half_width[1:] + half_width[:-1]) / 2
    # From no contact to the first one: that of the first one.
    a = np.where(np.isfinite(a), a, half_width[1:])
    return np.diff(k_t, axis=1), np.where(np.isfinite(a), a, 1.0)
