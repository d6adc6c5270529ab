# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a case and its mesh to condensed bodies and the interface problem, for many histories."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from dolfinx import fem
from scipy import sparse

from fretfe._typing import Array, Indices
from fretfe.bodies.beginning import Beginning
from fretfe.bodies.continued import coupled_contacts
from fretfe.bodies.definition import (
    BodyDefinition,
    ModelDefinition,
    Pair,
    contact_surfaces,
    model_notes,
)
from fretfe.bodies.loads.strain import surface_temperatures
from fretfe.bodies.rigid_modes import held_model
from fretfe.case import Case
from fretfe.contact.interface import Interface, coordinate_range
from fretfe.contact.march import March
from fretfe.contact.recorder import Recorder
from fretfe.contact.state import ContactState, StepLoads, StepTable
from fretfe.fem._compat import MPI
from fretfe.fem.bordered import unsymmetric_because
from fretfe.fem.condensation import Body, CondensedBody
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.interaction_integral import Forms
from fretfe.fem.parallel import find_group, on_root, together
from fretfe.fem.reduction import ReducedBody, build_interface, weighted_operator
from fretfe.fem.timing import Clock
from fretfe.loads import History
from fretfe.loads.friction import read_coefficients
from fretfe.mesh.cost import Amount, BodySizes, estimate_cost, refuse_too_large
from fretfe.mesh.mesh import BodyMesh, Mesh, body_unknowns
from fretfe.surface.checks import load_mesh
from fretfe.surface.friction import Friction

LoadMesh = Callable[[], Mesh]

# Of notes; the reason follows.
LARGER_FACTORS = "the factors of the bodies are LU, which takes more time and memory"


@dataclass(frozen=True)
class Reduction:
    """The interface problem, and the way back from it to the bodies; rank 0 only."""

    definition: ModelDefinition
    interface: Interface
    bodies: dict[str, ReducedBody]
    pairs: tuple[Pair, ...]


@dataclass(frozen=True)
class Request:
    """A displacement field to recover: weighted tractions (N*d,), coordinates, load amplitudes."""

    traction: Array
    coordinates: Array
    amplitudes: Array

    @classmethod
    def of(cls, state: ContactState, loads: StepLoads) -> Request:
        """The field of a solved state."""
        return cls(state.traction.ravel(), state.coordinates, loads.amplitudes)


# Of a field, for each body: the arguments of `Body.recover`.
Share = dict[str, tuple[Array, Array, Array]]


@dataclass(frozen=True)
class _Task:
    """One body for the group that condenses it: what its first rank needs to know."""

    mesh: BodyMesh
    points: Array
    operator: sparse.csr_matrix


class Model:
    """The bodies of a case, condensed, and their interface problem.

    Args:
        comm: communicator; construction is collective.
        case: validated case, the same on all ranks.
        mesh: bodies' meshes on rank 0, None elsewhere.
        clock: for timings.

    Attributes:
        comm: all ranks.
        case: the case.
        surfaces: all contact surfaces, by name.
        bodies: those that the group of this rank has.
        forms: of the integrals at their edges, kept for the next history: building one takes longer
            than integrating.
        notes: what a reader of the results should know, in words.
        on_disk: whether factors are in files.
    """

    def __init__(self, comm: MPI.Comm, case: Case, mesh: Mesh | None, clock: Clock) -> None:
        self.comm = comm
        self.case = case
        definition = on_root(comm, lambda: held_model(case, mesh))  # type: ignore[arg-type]

        def coupled() -> tuple[Pair, ...]:
            assert mesh is not None
            return coupled_contacts(case, definition, mesh, surfaces)

        with clock("surfaces"):
            surfaces = on_root(comm, lambda: contact_surfaces(definition, mesh))  # type: ignore[arg-type]
            self.surfaces = surfaces
            pairs = on_root(comm, coupled, share=False)
            machines = comm.allgather(MPI.Get_processor_name())
            beside = machines.count(machines[0])
            self.on_disk = on_root(comm, lambda: _factors_on_disk(case, mesh, pairs, beside))  # type: ignore[arg-type]
        why = unsymmetric_because()
        notes = on_root(comm, lambda: model_notes(case, definition, mesh))  # type: ignore[arg-type]
        larger = (f"{LARGER_FACTORS}: {why}",) if why else ()
        self.notes: tuple[str, ...] = (*larger, *notes)
        self.forms: Forms = {}
        self._definition = definition
        work = comm.bcast(_work(definition, mesh, case.model.degree) if mesh else None)
        self._group = find_group(comm, work)
        tasks = self._hand_out(mesh, pairs)
        self.bodies = together(comm, lambda: self._condense(tasks, clock))
        with clock("interface"):
            condensed = self._collect()
            self._reduction = on_root(
                comm, lambda: self._reduce(definition, pairs, condensed), share=False
            )

    @property
    def reduction(self) -> Reduction:
        """The interface problem; on rank 0."""
        assert self._reduction is not None
        return self._reduction

    @property
    def dimension(self) -> int:
        """Number of coordinates, 2 or 3."""
        return next(iter(self.surfaces.values())).dimension

    @property
    def components(self) -> int:
        """Number of components of the displacement."""
        return self._definition.components

    def _hand_out(self, mesh: Mesh | None, pairs: tuple[Pair, ...] | None) -> dict[int, _Task]:
        """Send each body to the first rank of its group; returns those of this rank. Collective."""
        tasks = {}
        for number, root in enumerate(self._group.roots):
            if mesh is not None and pairs is not None:
                task = self._task(self._definition.bodies[number], mesh, pairs)
                if root == 0:
                    tasks[number] = task
                else:
                    self.comm.send(task, root, tag=number)
            elif self.comm.rank == root:
                tasks[number] = self.comm.recv(source=0, tag=number)
        return tasks

    def _task(self, body: BodyDefinition, mesh: Mesh, pairs: tuple[Pair, ...]) -> _Task:
        degree = self.case.model.degree
        points = [self.surfaces[name].displacement_points(degree) for name in body.surfaces]
        return _Task(mesh.bodies[body.name], np.vstack(points), weighted_operator(body.name, pairs))

    def _condense(self, tasks: dict[int, _Task], clock: Clock) -> dict[str, Body]:
        """The bodies of this rank's group."""
        comm, bodies = self._group.comm, {}
        for number in self._group.bodies:
            body, task = self._definition.bodies[number], tasks.get(number)
            with clock("assembly"):
                own = task.mesh if task else None
                elastic = ElasticBody(
                    comm, own, body.material, self.case.model.degree, body.components
                )
            points, operator = comm.bcast((task.points, task.operator) if task else None)
            loads = list(self._definition.loads)
            bodies[body.name] = Body(
                elastic,
                list(body.constraints),
                loads,
                points,
                operator,
                clock,
                body.tie or body.bond,
                on_disk=self.on_disk,
            )
        return bodies

    def _collect(self) -> list[CondensedBody]:
        """All condensed bodies, in the order of the case; on rank 0. Collective."""
        condensed: list[CondensedBody] = []
        for number, root in enumerate(self._group.roots):
            name = self._definition.bodies[number].name
            own = self.bodies[name].condensed if name in self.bodies else None
            if root > 0 and self.comm.rank == root:
                self.comm.send(own, 0, tag=number)
                self.bodies[name].condensed = None  # as large as the interface
            elif self.comm.rank == 0:
                found = own if root == 0 else self.comm.recv(source=root, tag=number)
                assert found is not None
                condensed.append(found)
        return condensed

    def _reduce(
        self,
        definition: ModelDefinition,
        pairs: tuple[Pair, ...] | None,
        condensed: list[CondensedBody],
    ) -> Reduction:
        assert pairs is not None
        coordinates = [c for body in definition.bodies for c in body.coordinates]
        interface, reduced = build_interface(condensed, list(pairs), coordinates, definition.loads)
        return Reduction(definition, interface, reduced, pairs)

    def body_definition(self, body: str) -> BodyDefinition:
        """Definition of a body by its name."""
        return next(definition for definition in self._definition.bodies if definition.name == body)

    def recover_fields(self, shares: Sequence[Share]) -> list[dict[str, fem.Function]]:
        """Displacement fields of the bodies of this rank's group. Collective.

        Args:
            shares: of the fields, the same on all ranks.
        """
        fields = {
            name: body.recover([share[name] for share in shares])
            for name, body in self.bodies.items()
        }
        return [{name: found[i] for name, found in fields.items()} for i in range(len(shares))]

    def share(self, request: Request) -> Share:
        """Arguments with which each body recovers a field; on rank 0."""
        coordinates = self.reduction.interface.coordinates
        return {
            name: (
                request.traction[body.rows],
                request.coordinates[coordinate_range(coordinates, name)],
                request.amplitudes,
            )
            for name, body in self.reduction.bodies.items()
        }


def _factors_on_disk(case: Case, mesh: Mesh, pairs: tuple[Pair, ...], ranks: int) -> bool:
    """Tell whether memory is short enough for factors on disk; on rank 0.

    Raises:
        ModelError: if the model cannot fit into memory even then.
    """
    nodes = sum(len(pair.coupling.surface.weights) for pair in pairs)
    bodies = BodySizes.of(mesh, case.model.degree, case.components(mesh.dimension))
    cost = estimate_cost(bodies, nodes, Amount(), ranks)
    refuse_too_large(cost)
    return cost.on_disk


def _work(definition: ModelDefinition, mesh: Mesh, degree: int) -> list[float]:
    """Estimates of the time that the factorisation of each body takes."""
    power = 1.5 if mesh.dimension == 2 else 2.0
    bodies = (mesh.bodies[body.name] for body in definition.bodies)
    return [float(body_unknowns(body, degree)) ** power for body in bodies]


def step_loads(
    case: Case,
    history: History,
    reduction: Reduction,
    beginning: Beginning | None = None,
    steps: Indices | None = None,
) -> StepTable:
    """Loads of every state of a history; total forces become those per unit thickness.

    Args:
        case: the case.
        history: its loads, in T states.
        reduction: the interface problem.
        beginning: states of another run, which have its friction.
        steps: (T,) number of the step in which each state lies; None if they are ends of steps.
    """
    thickness = case.model.thickness
    values = dict(zip(history.channels, history.values.T, strict=True))
    count = len(history.times)
    amplitudes = [
        load.amplitudes(values[load.channel]) / (thickness if load.total else 1.0)
        for load in reduction.definition.loads
    ]
    moved = [
        c.amplitudes(values[c.channel]) / (thickness if c.control == "force" else 1.0)
        if c.channel
        else np.zeros(count)
        for c in reduction.interface.coordinates
    ]
    numbers = np.arange(count) if steps is None else steps

    def friction(pair: Pair) -> Friction:
        given = read_coefficients(case, pair.name)
        surface, heat = pair.coupling.surface, None
        if given.temperature is not None:
            bodies, loads = (pair.body1, pair.body2), reduction.definition.loads
            heat = surface_temperatures(case, loads, bodies, surface.points, history)
        own = Friction.of(given, history.times, surface, heat)
        return own if beginning is None else beginning.friction(pair.name, own, numbers)

    def within(steps: Indices, shares: Array) -> StepTable:
        return step_loads(case, history.divided(steps, shares), reduction, beginning, steps)

    return StepTable(
        amplitudes=np.array(amplitudes).reshape(-1, count).T,
        values=np.array(moved).reshape(-1, count).T,
        friction=tuple(friction(pair) for pair in reduction.pairs),
        within=within,
    )


@dataclass(frozen=True)
class Marched:
    """A history that was solved on a model.

    Attributes:
        recorder: its states.
        written: its last step by the loads as written; after it slip may have been extrapolated.
        until_steady: whether it ended with steps that repeat others.
    """

    recorder: Recorder
    written: int
    until_steady: bool


class Prepared:
    """A mesh, its model, and what marches through load histories on it.

    Args:
        mesh: on rank 0, None elsewhere.
        model: the condensed bodies.

    Attributes:
        last: the last history that was solved, on rank 0: the next one may begin like it.
    """

    def __init__(self, mesh: Mesh | None, model: Model) -> None:
        self._mesh, self.model = mesh, model
        self.last: Marched | None = None

    @property
    def mesh(self) -> Mesh:
        """The mesh; on rank 0."""
        assert self._mesh is not None
        return self._mesh

    @cached_property
    def march(self) -> March:
        """Marches through load histories; on rank 0."""
        return March(self.model.reduction.interface)

    def settle(self) -> None:
        """Have copies of this process only read what they share a file of; on rank 0."""
        if self.last is not None:
            self.last.recorder.settle()

    @property
    def digest(self) -> str:
        """Text that is equal for the same mesh; on rank 0."""
        found = hashlib.sha256()
        for name, body in self.mesh.bodies.items():
            found.update(repr((name, body.cell, body.order, body.cells.shape)).encode())
            for values in (body.points, body.cells, *body.boundaries.values()):
                found.update(np.ascontiguousarray(values).tobytes())
        return found.hexdigest()

    @property
    def meshes(self) -> list[Any]:
        """DOLFINx's meshes of the bodies."""
        return [body.elastic.mesh for body in self.model.bodies.values()]


def build_model(comm: MPI.Comm, case: Case, clock: Clock, load: LoadMesh | None = None) -> Prepared:
    """Mesh and model of a case. Collective.

    Args:
        comm: communicator.
        case: validated case, the same on all ranks.
        clock: for timings.
        load: gives the mesh, called on rank 0; None for `load_mesh`.

    Raises:
        FretfeError: if there is no mesh or no model for the case.
    """
    with clock("mesh"):
        mesh = on_root(comm, load or partial(load_mesh, case), share=False)
    return Prepared(mesh, Model(comm, case, mesh, clock))
