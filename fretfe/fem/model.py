# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a case and its mesh to condensed bodies and the interface problem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from dolfinx import fem

from fretfe._typing import Array
from fretfe.bodies.definition import BodyDefinition, ModelDefinition, define_model
from fretfe.bodies.pairs import Pair, contact_surfaces, couple_contacts
from fretfe.case import Case
from fretfe.contact.interface import Interface, coordinate_range
from fretfe.contact.state import ContactState, StepLoads
from fretfe.fem._compat import MPI
from fretfe.fem.condensation import Body
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.parallel import on_root
from fretfe.fem.reduction import ReducedBody, build_interface
from fretfe.fem.timing import Clock
from fretfe.loads import History
from fretfe.mesh.mesh import Mesh


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


def step_loads(
    case: Case, history: History, interface: Interface, definition: ModelDefinition
) -> list[StepLoads]:
    """Loads of every step of a history; forces are per unit thickness."""
    column = {name: number for number, name in enumerate(history.channels)}
    rotations = {load.channel for load in definition.loads if load.kind == "rotation"}
    steps = []
    for time, values in zip(history.times, history.values, strict=True):
        amplitudes = np.array([values[column[load.channel]] for load in definition.loads])
        # The body force goes with the square of the angular speed.
        squared = np.array([load.channel in rotations for load in definition.loads], dtype=bool)
        amplitudes[squared] **= 2
        steps.append(
            StepLoads(
                amplitudes=amplitudes,
                values=np.array(
                    [
                        values[column[c.channel]] / _per_thickness(case, c.control)
                        if c.channel
                        else 0.0
                        for c in interface.coordinates
                    ]
                ),
                friction=_friction(case, interface, time),
            )
        )
    return steps


def _per_thickness(case: Case, control: str) -> float:
    """Forces on platens are given for the whole thickness; displacements are not divided."""
    return case.model.thickness if control == "force" else 1.0


def _friction(case: Case, interface: Interface, time: float) -> Array:
    """(N,) friction coefficient at the nodes in the step that ends at a time."""
    friction = np.zeros(interface.size)
    for name, nodes in interface.contacts.items():
        contact = case.contacts[name]
        friction[nodes] = contact.friction if time > contact.friction_from else 0.0
    return friction
