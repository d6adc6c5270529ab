# SPDX-License-Identifier: LGPL-3.0-or-later
"""Force balance of the bodies: reactions, applied loads and contact forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretfe._typing import Array
from fretfe.contact.interface import coordinate_range
from fretfe.contact.state import ContactState, StepLoads
from fretfe.fem.definition import BodyDefinition
from fretfe.fem.model import Reduction


def force_balance(
    reduction: Reduction, states: Sequence[ContactState], steps: Sequence[StepLoads]
) -> dict[str, Array]:
    """(T,) largest sum of all forces on a body, and the largest force, by name.

    Args:
        reduction: the bodies.
        states: (T,) solved states.
        steps: (T,) their loads.
    """
    imbalance, scale = np.zeros(len(states)), np.zeros(len(states))
    amplitudes = np.array([step.amplitudes for step in steps])
    tractions = np.array([state.traction.ravel() for state in states])
    for definition in reduction.definition.bodies:
        body = reduction.bodies[definition.name]
        parts = np.stack(
            [
                _reactions(reduction, definition, states),
                amplitudes @ body.body.load_resultants.T,
                body.contact_forces(tractions),
            ]
        )
        imbalance = np.maximum(imbalance, np.abs(parts.sum(axis=0)).max(axis=1))
        scale = np.maximum(scale, np.abs(parts).max(axis=(0, 2)))
    return {"force_imbalance": imbalance, "force_scale": scale}


def _reactions(
    reduction: Reduction, definition: BodyDefinition, states: Sequence[ContactState]
) -> Array:
    """(T, d) sum of the forces that the constrained boundaries exert on a body."""
    d, count = reduction.interface.components, len(definition.constraints)
    own = coordinate_range(reduction.interface.coordinates, definition.name)
    directions = np.array([c.direction for c in definition.constraints]).reshape(count, d)
    # Rigid modes restrained by contact come last, and no force acts on them.
    return np.array([state.forces[own][:count] @ directions for state in states])
