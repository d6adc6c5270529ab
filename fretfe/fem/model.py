# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a case and its mesh to condensed bodies and the interface problem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from dolfinx import fem

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.contact.interface import Interface, coordinate_range
from fretfe.contact.state import ContactState, StepLoads, StepTable
from fretfe.fem._compat import MPI
from fretfe.fem.condensation import Body
from fretfe.fem.definition import BodyDefinition, ModelDefinition, define_model
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.parallel import on_root
from fretfe.fem.reduction import Pair, ReducedBody, build_interface
from fretfe.fem.timing import Clock
from fretfe.loads import History
from fretfe.mesh.mesh import Mesh
from fretfe.surface.mortar import couple
from fretfe.surface.surface import Surface, build_surface


@dataclass(frozen=True)
class Reduction:
    """The interface problem, and the way back from it to the bodies; rank 0 only."""

    definition: ModelDefinition
    interface: Interface
    bodies: dict[str, ReducedBody]
    pairs: tuple[Pair, ...]


class Model:
    """The bodies of a case, condensed, and their interface problem.

    Args:
        comm: communicator; construction is collective.
        case: validated case, the same on all ranks.
        mesh: bodies' meshes on rank 0, None elsewhere.
        clock: for timings.
    """

    def __init__(self, comm: MPI.Comm, case: Case, mesh: Mesh | None, clock: Clock) -> None:
        self.comm = comm
        self.case = case
        degree = case.model.degree
        definition = on_root(comm, lambda: define_model(case, mesh))  # type: ignore[arg-type]
        with clock("surfaces"):
            surfaces = on_root(comm, lambda: contact_surfaces(definition, mesh))  # type: ignore[arg-type]
            self.surfaces = surfaces
            pairs = on_root(comm, lambda: couple_contacts(case, surfaces), share=False)
        self._definition = definition
        self.bodies: dict[str, Body] = {}
        for body in definition.bodies:
            with clock("assembly"):
                own = mesh.bodies[body.name] if mesh else None
                elastic = ElasticBody(comm, own, body.material, degree)
            points = np.vstack([surfaces[s].displacement_points(degree) for s in body.surfaces])
            self.bodies[body.name] = Body(
                elastic, list(body.constraints), list(definition.loads), points, clock
            )
        with clock("interface"):
            self.reduction = on_root(comm, lambda: self._reduce(definition, pairs), share=False)

    def _reduce(self, definition: ModelDefinition, pairs: tuple[Pair, ...] | None) -> Reduction:
        assert pairs is not None
        condensed = [b.condensed for b in self.bodies.values() if b.condensed is not None]
        coordinates = [c for body in definition.bodies for c in body.coordinates]
        interface, reduced = build_interface(condensed, list(pairs), coordinates)
        return Reduction(definition, interface, reduced, pairs)

    def body_definition(self, body: str) -> BodyDefinition:
        """Definition of a body by its name."""
        return next(definition for definition in self._definition.bodies if definition.name == body)

    def recover(
        self, states: Sequence[tuple[ContactState, StepLoads]] | None
    ) -> list[dict[str, fem.Function]]:
        """Displacement fields of solved steps, by body. Collective; `states` on rank 0 only."""
        return self.recover_fields(
            [(s.traction.ravel(), s.coordinates, loads.amplitudes) for s, loads in states]
            if states is not None
            else None
        )

    def recover_fields(
        self, requests: Sequence[tuple[Array, Array, Array]] | None
    ) -> list[dict[str, fem.Function]]:
        """Displacement fields, by body. Collective.

        Args:
            requests: weighted tractions (N*d,), coordinates (m,) and load amplitudes (l,) of each
                field; on rank 0, None elsewhere.
        """
        retained = self.comm.bcast(
            [self._retained(*request) for request in requests] if requests is not None else None
        )
        return [
            {name: self.bodies[name].recover(*arguments) for name, arguments in field.items()}
            for field in retained
        ]

    def _retained(
        self, traction: Array, coordinates: Array, amplitudes: Array
    ) -> dict[str, tuple[Array, Array, Array]]:
        """Surface displacements, constraint amplitudes and load amplitudes of each body."""
        assert self.reduction is not None
        retained = {}
        for name, body in self.reduction.bodies.items():
            own = coordinates[coordinate_range(self.reduction.interface.coordinates, name)]
            surface = body.surface_displacement(traction, own, amplitudes)
            retained[name] = (surface, own[: body.body.coupling.shape[1]], amplitudes)
        return retained


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


def step_loads(
    case: Case, history: History, interface: Interface, definition: ModelDefinition
) -> StepTable:
    """Loads of every step of a history; forces are per unit thickness."""
    values = dict(zip(history.channels, history.values.T, strict=True))
    count, contacts = len(history.times), [case.contacts[name] for name in interface.contacts]
    # The body force goes with the square of the angular speed.
    amplitudes = [
        values[load.channel] ** 2 if load.kind == "rotation" else values[load.channel]
        for load in definition.loads
    ]
    moved = [
        values[c.channel] / _per_thickness(case, c.control) if c.channel else np.zeros(count)
        for c in interface.coordinates
    ]
    friction = [
        np.where(history.times > contact.friction_from, contact.friction, 0.0)
        for contact in contacts
    ]
    return StepTable(
        amplitudes=np.array(amplitudes).reshape(-1, count).T,
        values=np.array(moved).reshape(-1, count).T,
        friction=np.array(friction).T,
        sizes=np.array([nodes.stop - nodes.start for nodes in interface.contacts.values()]),
    )


def _per_thickness(case: Case, control: str) -> float:
    """Forces on platens are given for the whole thickness; displacements are not divided."""
    return case.model.thickness if control == "force" else 1.0
