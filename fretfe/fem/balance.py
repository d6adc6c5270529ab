# SPDX-License-Identifier: LGPL-3.0-or-later
"""Balance of forces and moments of the bodies: reactions, applied loads and contact forces."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.definition import BodyDefinition
from fretfe.contact.interface import coordinate_range
from fretfe.contact.recorder import StateBlock
from fretfe.fem.model import Reduction


def balance(reduction: Reduction, blocks: Iterable[StateBlock]) -> dict[str, Array]:
    """(T,) largest sums of all forces and moments on a body, and their scales, by name.

    The scale of the forces is the largest of them, that of the moments the largest force on a body
    times its size.

    Args:
        reduction: the bodies.
        blocks: all solved states.
    """
    found: dict[str, list[Array]] = {}
    for block in blocks:
        bodies = [_body_balance(reduction, each, block) for each in reduction.definition.bodies]
        for name in bodies[0]:
            largest = np.array([body[name] for body in bodies]).max(axis=0)
            found.setdefault(name, []).append(largest)
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _body_balance(
    reduction: Reduction, definition: BodyDefinition, block: StateBlock
) -> dict[str, Array]:
    body = reduction.bodies[definition.name]
    own = coordinate_range(reduction.interface.coordinates, definition.name)
    coordinates = block.coordinates[:, own]
    parts = np.stack(
        [
            _reactions(reduction, definition, block.forces[:, own]),
            block.amplitudes @ body.body.load_resultants.T,
            body.contact_forces(block.traction),
        ]
    )
    largest = np.abs(parts).max(axis=(0, 2))
    return {
        "force_imbalance": np.abs(parts.sum(axis=0)).max(axis=1),
        "force_scale": largest,
        "moment_imbalance": np.abs(body.moments(block.traction, coordinates, block.amplitudes)).max(
            axis=1
        ),
        "moment_scale": largest * body.body.size,
    }


def _reactions(reduction: Reduction, definition: BodyDefinition, forces: Array) -> Array:
    """(n, d) sum of the forces (n, m) that the constrained boundaries exert on a body."""
    d, count = reduction.interface.components, len(definition.constraints)
    directions = np.array([c.direction for c in definition.constraints]).reshape(count, d)
    # Rigid modes restrained by contact come last, and no force acts on them.
    return np.asarray(forces[:, :count] @ directions)
