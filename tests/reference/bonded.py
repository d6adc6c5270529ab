# SPDX-License-Identifier: LGPL-3.0-or-later
"""Full-stick increments of a contact, and the factors along its fronts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.backends.protocol import DEFAULTS
from fretfe.bodies.definition import Pair
from fretfe.case import Case
from fretfe.contact.full_stick import FullStickSolver, Increments, find_drivers
from fretfe.contact.interface import Place
from fretfe.contact.recorder import Recorder
from fretfe.contact.solve import solve_history
from fretfe.contact.state import unloaded
from fretfe.fem._compat import MPI
from fretfe.fem.fields import FieldSource, Recovery
from fretfe.fem.model import LoadMesh, Model, Request, build_model, step_loads
from fretfe.fem.parallel import Lead
from fretfe.fem.probes import Probe
from fretfe.fem.run import load_history
from fretfe.fem.timing import Clock

Areas = Callable[[Array], list[Bools]]


@dataclass(frozen=True)
class Fields:
    """Fields of full stick in the contact area of a state, or in those given; on rank 0.

    Attributes:
        pair: the contact.
        requests: a field for a unit of each driver.
        drivers: their names.
    """

    pair: Pair
    requests: tuple[Request, ...]
    drivers: tuple[str, ...]


@dataclass(frozen=True)
class Bonded:
    """A solved model, and what rank 0 alone has."""

    model: Model
    seconds: dict[str, float]
    root: Fields | None

    def factors(self, probes: Callable[[Model, Fields], list[Probe]]) -> list[Array] | None:
        """For each probe (R, n, d, J) factors by all drivers, on rank 0. Collective."""
        lead = Lead(self.model.comm, Recovery(self.model))

        def work() -> list[Array]:
            assert self.root is not None
            source = FieldSource(self.model, lead)
            wanted = probes(self.model, self.root)
            found = source.integrals(wanted, self.root.requests, lambda _: None)
            return [np.stack(each, axis=1) for each in found]

        return lead.run(work, share=False)


def bonded(case: Case, load: LoadMesh | None = None, areas: Areas | None = None) -> Bonded:
    """Solve a case of one contact, and its full-stick increments. Collective.

    Args:
        case: the case.
        load: gives the mesh.
        areas: gives the nodes of contact areas from the points of all nodes, instead of solving the
            case: the increments are means over these areas.
    """
    clock = Clock()
    history = load_history(MPI.COMM_WORLD, case, DEFAULTS)
    prepared = build_model(MPI.COMM_WORLD, case, clock, load)
    model = prepared.model
    if model.comm.rank > 0:
        return Bonded(model, clock.seconds, None)
    reduction, march = model.reduction, prepared.march
    (pair,) = reduction.pairs
    loads = [load.channel for load in reduction.definition.loads]
    drivers = find_drivers(reduction.interface, loads)
    if areas is None:
        place = Place(
            pair.name, pair.body1, pair.body2, pair.coupling.surface, pair.coupling.averaging
        )
        steps = step_loads(case, history, reduction)
        recorder = Recorder(march, [place], steps, loads, case.model.degree)
        solve_history(march, recorder, steps, False, DEFAULTS.progress)
        found = [recorder.increments(0)]
    else:
        solver, free = FullStickSolver(march.operator, drivers), unloaded(reduction.interface)
        found = [
            solver.increments(area, free.relative[:, 0])
            for area in areas(pair.coupling.surface.points)
        ]
    mean = Increments.mean(found)
    requests = tuple(
        Request(mean.traction[:, :, j].ravel(), mean.coordinates[:, j], np.zeros(len(loads)))
        for j in range(len(drivers.names))
    )
    return Bonded(model, clock.seconds, Fields(pair, requests, drivers.names))
