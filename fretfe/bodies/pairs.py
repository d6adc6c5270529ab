# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces of the bodies, and their coupling."""

from __future__ import annotations

from dataclasses import dataclass

from fretfe.bodies.definition import ModelDefinition
from fretfe.case import Case
from fretfe.mesh.mesh import Mesh
from fretfe.surface.mortar import Coupling, couple
from fretfe.surface.surface import Surface, build_surface


@dataclass(frozen=True)
class Pair:
    """One contact: its name, its bodies and its coupling."""

    name: str
    body1: str
    body2: str
    coupling: Coupling


def contact_surfaces(definition: ModelDefinition, mesh: Mesh) -> dict[str, Surface]:
    """All contact surfaces, oriented, by name."""
    return {
        name: build_surface(mesh.bodies[body.name], name)
        for body in definition.bodies
        for name in body.surfaces
    }


def couple_contacts(case: Case, surfaces: dict[str, Surface]) -> tuple[Pair, ...]:
    """The contact pairs of a case, in its order."""
    pairs = []
    for name, contact in case.contacts.items():
        first, second = surfaces[contact.surface1], surfaces[contact.surface2]
        coupling = couple(name, first, second, contact.multipliers, case.model.degree)
        pairs.append(Pair(name, first.body, second.body, coupling))
    return tuple(pairs)
