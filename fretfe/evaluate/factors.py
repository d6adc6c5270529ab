# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories of the edges of a contact: position and K_N by fits, K_T and K_I by increments.

K_T and K_I are counted from the first state: they add up the companion increments over the steps,
each with the mean of the contact areas before and after it. K_T counts only steps with friction.
"""

from __future__ import annotations

from dataclasses import astuple, fields

import numpy as np
import numpy.typing as npt

from fretfe.edges import OVERHANG, EdgeFit, Side, bonded_factors, edge_factor_k_t, fit_edge
from fretfe.solution import ContactHistory, Solution

Array = npt.NDArray[np.float64]
SIDES: tuple[Side, Side] = ("left", "right")
# Fewer nodes than this in contact cannot be fitted.
FEWEST_NODES = 16


def edge_fits(contact: ContactHistory) -> tuple[EdgeFit, EdgeFit]:
    """(T,) position and K_N with their spreads at both edges; NaN where they cannot be fitted."""
    pressure = contact.traction[:, :, 0]
    fitted = np.count_nonzero(pressure > 0, axis=1) >= FEWEST_NODES
    left, right = (_full(fit_edge(contact.arc, pressure[fitted], side), fitted) for side in SIDES)
    return left, right


def _full(fit: EdgeFit, fitted: npt.NDArray[np.bool_]) -> EdgeFit:
    """The fit of some states as one of all (T,) states, NaN in the others."""
    parts = np.full((len(fields(EdgeFit)), len(fitted)), np.nan)
    parts[:, fitted] = astuple(fit)
    return EdgeFit(*parts)


def edge_histories(solution: Solution, contact: ContactHistory, positions: Array) -> Array:
    """(2, T, 2) K_T and K_I at both edges, whose positions are (2, T)."""
    count = len(solution.times)
    units = _unit_factors(solution, contact, positions)
    histories = np.zeros((2, count, 2))
    for state in range(1, count):
        step = solution.driver_values[state] - solution.driver_values[state - 1]
        known = [units[s] for s in (state - 1, state) if np.isfinite(units[s]).all()]
        increment = np.mean(known, axis=0) @ step if known else np.zeros((2, 2))
        increment[:, 0] *= contact.friction[state] > 0
        histories[:, state] = histories[:, state - 1] + increment
    return histories


def _unit_factors(solution: Solution, contact: ContactHistory, positions: Array) -> Array:
    """(T, 2, 2, J) edge, factor (K_T, K_I) for a unit of each driver; NaN where unknown."""
    factors = np.full((len(solution.times), 2, 2, len(solution.drivers)), np.nan)
    areas = np.where(positions[1] > positions[0], contact.bonded.area, -1)
    for area in np.unique(areas[areas >= 0]):
        states = np.flatnonzero(areas == area)
        factors[states] = _area_factors(
            contact.arc,
            contact.bonded.fields[area],
            positions[:, states].T,
            OVERHANG[solution.degree],
        )
    return factors


def _area_factors(arc: Array, fields: Array, edges: Array, overhang: float) -> Array:
    """(S, 2, 2, J) unit factors of S states with the same contact area.

    Args:
        arc: (N,) nodes.
        fields: (N, d, J) traction for a unit of each driver.
        edges: (S, 2) positions.
        overhang: of the increments.
    """
    factors = np.zeros((len(edges), 2, 2, fields.shape[2]))
    increments = fields[:, [1, 0]].transpose(1, 2, 0)  # shear gives K_T, pressure gives K_I
    largest = np.abs(fields).max(axis=(0, 1))
    # Less than that is round-off, for instance of a distant load.
    effective = np.abs(increments).max(axis=2) > 1e-9 * largest
    if not effective.any():
        return factors
    fits = bonded_factors(arc, increments[effective], edges, overhang)
    for i, (side, fit) in enumerate(zip(SIDES, fits, strict=True)):
        factors[:, i, effective] = fit.k
        factors[:, i, 0] = edge_factor_k_t(factors[:, i, 0], side)
    return factors
