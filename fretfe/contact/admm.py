# SPDX-License-Identifier: LGPL-3.0-or-later
"""The slow method that converges where Newton's does not.

Fixed point on the friction bound: with the bound f p taken from the last pressure, the step is a
convex problem (pressures not negative, shear within a fixed disc), which the alternating direction
method of multipliers solves from any start in any dimension. The bound is then renewed until it
settles. The result serves as a start for Newton, which makes it exact.
"""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.contact.operator import InterfaceOperator
from fretfe.contact.state import OPEN, SLIP, STICK, Status, StepLoads

MAX_BOUNDS = 40
ITERATIONS_PER_BOUND = 150
# The status of the nodes is all that Newton needs; it settles long before the tractions do.
TRACTION_TOLERANCE = 1e-5
OVER_RELAXATION = 1.6


def status_by_fixed_point(
    operator: InterfaceOperator, loads: StepLoads, reference: Array, start: Array
) -> tuple[Status, Array]:
    """Status and shear direction of all nodes at the end of a step, to the method's tolerance.

    Args:
        operator: solves linear systems of the interface problem.
        loads: loads at the end of the step.
        reference: (N, d-1) tangential displacement before the step.
        start: (N, d) tractions to start from.
    """
    solve = _Proximal(operator, loads, reference)
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
    direction = np.zeros_like(traction[:, 1:])
    moving = (status == SLIP) & (shear > 0)
    direction[moving] = traction[moving, 1:] / shear[moving, None]
    return status, direction


class _Proximal:
    """Minimiser of the elastic energy plus a quadratic penalty on the distance to a target."""

    def __init__(self, operator: InterfaceOperator, loads: StepLoads, reference: Array) -> None:
        interface = operator.interface
        known, released = interface.prescribed, ~interface.prescribed
        free = (interface.gap + interface.loads @ loads.amplitudes).reshape(len(reference), -1)
        free[:, 1:] -= reference
        free = free.ravel() + interface.motion[:, known] @ loads.values[known]
        forces = (interface.coordinate_loads @ loads.amplitudes)[released]
        forces += loads.values[released]
        forces -= interface.stiffness[np.ix_(released, known)] @ loads.values[known]
        self._penalty = interface.compliance.level
        self._layer = operator.regularised(self._penalty)
        self._offset = self._layer.tractions(-free, -forces)
        self._no_forces = np.zeros_like(forces)

    def __call__(self, target: Array) -> Array:
        stretch = self._penalty * target.ravel()
        elastic = self._layer.tractions(stretch, self._no_forces)
        return (elastic + self._offset).reshape(target.shape)


def _project(traction: Array, bound: Array) -> Array:
    """Nearest tractions with no tension and shear within the bound."""
    projected = traction.copy()
    projected[:, 0] = np.maximum(traction[:, 0], 0.0)
    length = np.linalg.norm(traction[:, 1:], axis=1)
    excess = length > bound
    projected[excess, 1:] *= (bound[excess] / length[excess])[:, None]
    return projected
