# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run a case on meshes made in a test, on any number of ranks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from cases.marching import march_through
from harness.petsc_garbage import replace_meshes

from fretfe._typing import Array
from fretfe.case import parse_case
from fretfe.contact.march import March, StepResult
from fretfe.contact.state import StepLoads
from fretfe.fem._compat import MPI
from fretfe.fem.model import Model, Request, step_loads
from fretfe.fem.parallel import on_root
from fretfe.fem.timing import Clock
from fretfe.loads import build_history
from fretfe.mesh.mesh import BodyMesh, Mesh


@dataclass(frozen=True)
class Run:
    """All accepted steps; the tractions on every rank, the rest on rank 0.

    tractions: (steps, N, 2) nodal pressure and shear on body 2.
    forces: (steps, m) forces that the constrained boundaries exert.
    """

    model: Model
    steps: Sequence[StepLoads]
    results: list[StepResult]
    tractions: Array
    forces: dict[str, Array]

    def fields(self, step: int) -> dict[str, Any]:
        """Displacement of each body that this rank has. Collective."""
        model = self.model
        share = on_root(
            model.comm,
            lambda: model.share(Request.of(self.results[step].state, self.steps[step + 1])),
        )
        (fields,) = model.recover_fields([share])
        return fields

    def stress(self, step: int) -> dict[str, Array]:
        """(n, 2, 2) stress at the nodes of the elements of this rank, by body. Collective."""
        stresses = {
            name: self.model.bodies[name].elastic.element_stresses(field).reshape(-1, 4)
            for name, field in self.fields(step).items()
        }
        return {name: each[:, [[0, 3], [3, 1]]] for name, each in stresses.items()}

    def displacement(self, step: int, body: str, where: Callable[[Array], Array]) -> Array:
        """(n, 2) displacements of this rank's nodes where a function of x (3, n) is true."""
        fields = self.fields(step)
        if body not in fields:
            return np.empty((0, 2))
        nodes = self.model.bodies[body].elastic.space.tabulate_dof_coordinates()
        values: Array = fields[body].x.array.reshape(-1, 2)
        return values[where(nodes.T)]


def run(data: dict[str, Any], *meshes: BodyMesh) -> Run:
    """Solve a case without its geometry table. Collective."""
    comm = MPI.COMM_WORLD
    case = parse_case({"geometry": {"file": "none.msh"}, **data})
    history = build_history(case)
    mesh = Mesh({m.name: m for m in meshes}) if comm.rank == 0 else None
    model = Model(comm, case, mesh, Clock())
    replace_meshes(*(body.elastic.mesh for body in model.bodies.values()))
    steps: Sequence[StepLoads] = []
    results: list[StepResult] = []
    tractions, forces = None, None
    if comm.rank == 0:
        interface = model.reduction.interface
        steps = step_loads(case, history, model.reduction)
        results = list(march_through(March(interface), steps))
        roots = interface.roots[:, None]
        tractions = np.array([result.state.traction / roots for result in results])
        labels = [c.label for c in interface.coordinates]
        table = np.array([result.state.forces for result in results]).T
        forces = dict(zip(labels, table, strict=True))
    return Run(model, steps, results, *comm.bcast((tractions, forces)))


def ramp(value: float, steps: int = 2) -> list[dict[str, Any]]:
    """History that goes to a value in one unit of time."""
    return [{"ramp": value, "until": 1.0, "steps": steps}]
