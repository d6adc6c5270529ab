# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cache of one model from case to case, until a case needs another one. Collective.

Friction, load histories and the evaluated cycle do not enter the model: mesh, stiffness,
factorisations and condensed bodies stay, and so does the factorised interface.
"""

from __future__ import annotations

from typing import Any

from fretfe.backends.protocol import RunOptions
from fretfe.case import Case
from fretfe.fem._compat import MPI
from fretfe.fem.parallel import release
from fretfe.fem.prepared import LoadMesh, Prepared, build_model
from fretfe.fem.run import load_history, solve_prepared
from fretfe.fem.timing import Clock
from fretfe.results.model import Result

# Keys of a case that do not enter its model.
FREE: dict[str, Any] = {
    "title": True,
    "units": True,
    "cycle": True,
    "output": True,
    "contacts": {"__all__": {"friction", "friction_from"}},
    "loads": {"__all__": {"history"}},
}


def model_key(case: Case) -> str:
    """Text that is equal for two cases that can be solved with one model."""
    file = case.geometry.file
    # The label of the unit of length decides how a STEP file is read.
    place = f"{case.resolve(file).absolute()} {case.units.length} " if file is not None else ""
    return place + repr(case.model_dump(mode="json", exclude=FREE))


class ModelCache:
    """Solves cases one after the other; builds a model only if the one that it has does not fit."""

    def __init__(self, comm: MPI.Comm) -> None:
        self._comm = comm
        self._key = ""
        self._prepared: Prepared | None = None

    def solve(self, case: Case, options: RunOptions, load: LoadMesh) -> Result:
        """Solve the load history of a case; arguments and errors as `fretfe.fem.run.solve`."""
        clock, key = Clock(), model_key(case)
        history = load_history(self._comm, case, options)
        if self._prepared is None or key != self._key:
            self.clear()
            self._prepared = build_model(self._comm, case, clock, load)
            self._key = key
        return solve_prepared(self._prepared, case, history, options, clock)

    def clear(self) -> None:
        """Give the model back."""
        meshes = self._prepared.meshes if self._prepared is not None else []
        self._prepared = None
        release(meshes)
