# SPDX-License-Identifier: LGPL-3.0-or-later
"""Balance of forces and moments of the bodies: reactions, applied loads and contact forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.definition import BodyDefinition
from fretfe.contact.interface import coordinate_range
from fretfe.contact.state import ContactState, StepLoads
from fretfe.fem.model import Reduction


def balance(
    reduction: Reduction, states: Sequence[ContactState], steps: Sequence[StepLoads]
) -> dict[str, Array]:
    """(T,) largest sums of all forces and moments on a body, and their scales, by name.

    The scale of the forces is the largest of them, that of the moments the largest force on a body
    times its size.

    Args:
        reduction: the bodies.
        states: (T,) solved states.
        steps: (T,) their loads.
    """
    found = {
        f"{kind}_{part}": np.zeros(len(states))
        for kind in ("force", "moment")
        for part in ("imbalance", "scale")
    }
    for definition in reduction.definition.bodies:
        for name, values in _body_balance(reduction, definition, states, steps).items():
            found[name] = np.maximum(found[name], values)
    return found


def _body_balance(
    reduction: Reduction,
    definition: BodyDefinition,
    states: Sequence[ContactState],
    steps: Sequence[StepLoads],
) -> dict[str, Array]:
    body = reduction.bodies[definition.name]
    amplitudes = np.array([step.amplitudes for step in steps])
    tractions = np.array([state.traction.ravel() for state in states])
    own = coordinate_range(reduction.interface.coordinates, definition.name)
    coordinates = np.array([state.coordinates[own] for state in states])
    parts = np.stack(
        [
            _reactions(reduction, definition, states),
            amplitudes @ body.body.load_resultants.T,
            body.contact_forces(tractions),
        ]
    )
    largest = np.abs(parts).max(axis=(0, 2))
    return {
        "force_imbalance": np.abs(parts.sum(axis=0)).max(axis=1),
        "force_scale": largest,
        "moment_imbalance": np.abs(body.moments(tractions, coordinates, amplitudes)).max(axis=1),
        "moment_scale": largest * body.body.moments.size,
    }


def _reactions(
    reduction: Reduction, definition: BodyDefinition, states: Sequence[ContactState]
) -> Array:
    """(T, d) sum of the forces that the constrained boundaries exert on a body."""
    d, count = reduction.interface.components, len(definition.constraints)
    own = coordinate_range(reduction.interface.coordinates, definition.name)
    directions = np.array([c.direction for c in definition.constraints]).reshape(count, d)
    # Rigid modes restrained by contact come last, and no force acts on them.
    return np.array([state.forces[own][:count] @ directions for state in states])
