# SPDX-License-Identifier: LGPL-3.0-or-later
"""Full-stick increments of the last state of a case, and the factors along its fronts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.backends.protocol import DEFAULTS
from fretfe.bodies.pairs import Pair
from fretfe.case import Case
from fretfe.contact.recorder import Place, Recorder
from fretfe.contact.solve import solve_history
from fretfe.fem._compat import MPI
from fretfe.fem.model import Model, Request, step_loads
from fretfe.fem.probes import Probe, measure
from fretfe.fem.run import LoadMesh, build_model, load_history
from fretfe.fem.timing import Clock


@dataclass(frozen=True)
class Increments:
    """Fields of full stick in the contact area of the last state; on rank 0.

    Attributes:
        pair: the contact.
        traction: (N, 3) weighted tractions of the state.
        requests: a field for a unit of each driver.
        drivers: their names.
    """

    pair: Pair
    traction: Array
    requests: tuple[Request, ...]
    drivers: tuple[str, ...]


@dataclass(frozen=True)
class Bonded:
    """A solved model, and what rank 0 alone has."""

    model: Model
    seconds: dict[str, float]
    root: Increments | None

    def factors(self, probes: Callable[[Model, Increments], list[Probe]]) -> list[Array] | None:
        """For each probe (R, n, d, J) factors by all drivers, on rank 0. Collective."""
        wanted = probes(self.model, self.root) if self.root else None
        found = measure(self.model, wanted, self.root.requests if self.root else None)
        return None if found is None else [np.stack(each, axis=1) for each in found]


def bonded(case: Case, load: LoadMesh | None = None) -> Bonded:
    """Solve a case of one contact. Collective."""
    clock = Clock()
    history = load_history(MPI.COMM_WORLD, case, DEFAULTS)
    prepared = build_model(MPI.COMM_WORLD, case, clock, load)
    model, reduction = prepared.model, prepared.model.reduction
    if reduction is None or prepared.march is None:
        return Bonded(model, clock.seconds, None)
    steps = step_loads(case, history, reduction.interface, reduction.definition)
    (pair,) = reduction.pairs
    place = Place(pair.name, pair.body1, pair.body2, pair.coupling, pair.coupling.facets)
    channels = [load.channel for load in reduction.definition.loads]
    recorder = Recorder(prepared.march, [place], steps, channels, case.model.degree)
    solve_history(prepared.march, recorder, steps, False, DEFAULTS.progress)
    increments = recorder.increments(0)
    none = np.zeros(len(channels))
    requests = tuple(
        Request(traction.ravel(), coordinates, none)
        for traction, coordinates in zip(
            np.moveaxis(increments.traction, 2, 0), increments.coordinates.T, strict=True
        )
    )
    root = Increments(pair, recorder.last.traction, requests, recorder.drivers.names)
    return Bonded(model, clock.seconds, root)
