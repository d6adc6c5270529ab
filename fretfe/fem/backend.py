# SPDX-License-Identifier: LGPL-3.0-or-later
"""The backend `fem`: finite elements, any geometry; collective over all MPI processes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeVar

from fretfe.backends.protocol import DEFAULTS, Processes, RunOptions, Session
from fretfe.case import Case
from fretfe.edges.foresight import coarse_contacts
from fretfe.fem._compat import MPI
from fretfe.fem.model_cache import ModelCache, model_key
from fretfe.fem.parallel import on_root
from fretfe.fem.prepared import LoadMesh
from fretfe.fem.refine import refine
from fretfe.fem.room import secure_work_space
from fretfe.fem.run import solve
from fretfe.loads import build_history
from fretfe.mesh.groups import count_unknowns
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result
from fretfe.surface.load import load_mesh

T = TypeVar("T")
SolveCase = Callable[[Case, RunOptions, LoadMesh], Result]


class MpiProcesses:
    """All processes of MPI's world."""

    @property
    def rank(self) -> int:
        """Number of this process."""
        return int(MPI.COMM_WORLD.rank)

    def on_root(self, work: Callable[[], T]) -> T:
        """Do `work` on rank 0 and give its result, or its error, to all. Collective."""
        return on_root(MPI.COMM_WORLD, work)


class FemBackend:
    """The augmented-Lagrangian contact model in DOLFINx."""

    summary = "finite elements (DOLFINx): any two-body geometry"

    @property
    def processes(self) -> Processes:
        """All processes of MPI's world."""
        return MpiProcesses()

    def supports(self, case: Case) -> tuple[str, ...]:
        """Every case; what is wrong with a mesh is found when it is read."""
        return ()

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        """Solve a case. Collective.

        Raises:
            FretfeError: for whatever keeps the history from being started, on all ranks.
        """
        return _solve(case, options, partial(solve, MPI.COMM_WORLD))

    def session(self) -> Session:
        """Solves cases one after the other, with one model as long as it fits."""
        return FemSession()


class FemSession:
    """Cases that share a model: it is built once for those that follow each other."""

    def __init__(self) -> None:
        self._cache = ModelCache(MPI.COMM_WORLD)

    def group(self, case: Case) -> str:
        """Equal for cases that share a model."""
        return model_key(case)

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        """As `FemBackend.solve`. Collective."""
        return _solve(case, options, self._cache.solve)

    def close(self) -> None:
        """Give the model back. Collective."""
        self._cache.clear()


def _solve(case: Case, options: RunOptions, solve_case: SolveCase) -> Result:
    """Solve and evaluate a case, on one mesh by `solve_case`. Collective."""
    secure_work_space(MPI.COMM_WORLD)
    if case.edges.tolerance is not None:
        return refine(MPI.COMM_WORLD, case, options)
    return solve_case(case, options, partial(_load, case, options))


def _load(case: Case, options: RunOptions) -> Mesh:
    """The mesh of a case; its size tells how long it takes until the first step is solved."""
    mesh = load_mesh(case)
    unknowns = count_unknowns(mesh, case.model.degree)
    options.announce(f"mesh: {unknowns} unknowns; the bodies are condensed before the first step")
    if mesh.dimension == 2:
        for warning in coarse_contacts(case, mesh, options.history or build_history(case)):
            options.announce(f"Warning: {warning}")
    return mesh


BACKEND = FemBackend()
