# SPDX-License-Identifier: LGPL-3.0-or-later
"""The slow method that converges where Newton does not.

Fixed point on the friction bound: with the bound f p taken from the last pressure, the step is a
convex problem (pressures not negative, shear within a fixed disc), which the alternating direction
method of multipliers solves from any start in any dimension. The bound is then renewed until it
settles. The result serves as a start for Newton, which makes it exact.
"""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.contact.interface import Interface, coordinate_scale
from fretfe.contact.state import OPEN, SLIP, STICK, Status, StepLoads

MAX_BOUNDS = 40
ITERATIONS_PER_BOUND = 150
# The status of the nodes is all that Newton needs; it settles long before the tractions do.
TRACTION_TOLERANCE = 1e-5
OVER_RELAXATION = 1.6


def status_by_fixed_point(
    interface: Interface, loads: StepLoads, reference: Array, start: Array
) -> tuple[Status, Array]:
    """Status and shear direction of all nodes at the end of a step, to the method's tolerance.

    Args:
        interface: the interface problem.
        loads: loads at the end of the step.
        reference: (N, d-1) tangential displacement before the step.
        start: (N, d) tractions to start from.
    """
    d = interface.components
    solve = _Proximal(interface, loads, reference)
    traction, multiplier = start.copy(), np.zeros_like(start)
    # Stuck at first: with a bound too low for the loads the convex problem has no solution, and its
    # iteration drifts away.
    bound = np.where(loads.friction > 0, np.inf, 0.0)
    for _ in range(MAX_BOUNDS):
        before = traction.copy()
        for _ in range(ITERATIONS_PER_BOUND):
            free = solve(traction - multiplier)
            relaxed = OVER_RELAXATION * free + (1 - OVER_RELAXATION) * traction
            traction = _project(relaxed + multiplier, bound)
            multiplier += relaxed - traction
        bound = loads.friction * traction[:, 0]
        scale = np.abs(traction).max(initial=np.finfo(float).tiny)
        if np.abs(traction - before).max() < TRACTION_TOLERANCE * scale:
            break
    shear = np.linalg.norm(traction[:, 1:], axis=1)
    on_bound = shear >= bound * (1 - TRACTION_TOLERANCE)
    status = np.where(traction[:, 0] <= 0, OPEN, np.where(on_bound, SLIP, STICK)).astype(np.int8)
    direction = np.zeros((len(traction), d - 1))
    moving = (status == SLIP) & (shear > 0)
    direction[moving] = traction[moving, 1:] / shear[moving, None]
    return status, direction


class _Proximal:
    """Minimiser of the elastic energy plus a quadratic penalty on the distance to a target."""

    def __init__(self, interface: Interface, loads: StepLoads, reference: Array) -> None:
        d, n = interface.components, interface.size * interface.components
        held = interface.prescribed
        released = np.flatnonzero(~held)
        free = (interface.gap + interface.loads @ loads.amplitudes).reshape(-1, d)
        free[:, 1:] -= reference
        free = free.ravel() + interface.motion[:, held] @ loads.values[held]
        forces = (interface.coordinate_loads @ loads.amplitudes)[released]
        forces += loads.values[released]
        forces -= interface.stiffness[np.ix_(released, held)] @ loads.values[held]
        self._penalty = np.trace(interface.compliance) / n
        scale = coordinate_scale(interface)[released] * self._penalty
        matrix = np.zeros((n + len(released), n + len(released)))
        matrix[:n, :n] = interface.compliance + self._penalty * np.eye(n)
        matrix[:n, n:] = interface.motion[:, released] * scale
        matrix[n:, :n] = matrix[:n, n:].T
        matrix[n:, n:] = -interface.stiffness[np.ix_(released, released)] * np.outer(scale, scale)
        inverse = np.linalg.inv(matrix)
        self._response = self._penalty * inverse[:n, :n]
        self._offset = -inverse[:n] @ np.concatenate([free, forces * scale])

    def __call__(self, target: Array) -> Array:
        return (self._response @ target.ravel() + self._offset).reshape(target.shape)


def _project(traction: Array, bound: Array) -> Array:
    """Nearest tractions with no tension and shear within the bound."""
    projected = traction.copy()
    projected[:, 0] = np.maximum(traction[:, 0], 0.0)
    length = np.linalg.norm(traction[:, 1:], axis=1)
    excess = length > bound
    projected[excess, 1:] *= (bound[excess] / length[excess])[:, None]
    return projected
