# SPDX-License-Identifier: LGPL-3.0-or-later
"""The backend `fem`: finite elements, any geometry; collective over all MPI processes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TypeVar

from fretfe.backends import EdgeHistories, Processes, RunOptions, Session
from fretfe.backends.protocol import DEFAULTS, Announce
from fretfe.case import Case
from fretfe.contact.march import StepResult
from fretfe.fem import _compat
from fretfe.fem._compat import MPI
from fretfe.fem.model_cache import KeptModel, model_key
from fretfe.fem.parallel import on_root
from fretfe.fem.refine import Evaluated, refine
from fretfe.fem.run import LoadMesh, Outcome, Progress, solve
from fretfe.loads import History, build_history
from fretfe.mesh.groups import count_unknowns
from fretfe.mesh.mesh import Mesh
from fretfe.results.solution import Solution
from fretfe.surface.load import load_mesh

T = TypeVar("T")
NO_SOLIDS = (
    "geometry.solid: expected a plane case, found a solid: contact in three dimensions is not "
    "solved yet; `fretfe mesh` writes the mesh",
)
SolveCase = Callable[[Case, History, Path | None, Progress, LoadMesh], Outcome]


class MpiProcesses:
    """All processes of MPI's world."""

    @property
    def rank(self) -> int:
        """Number of this process."""
        return int(MPI.COMM_WORLD.rank)

    def on_root(self, work: Callable[[], T]) -> T | None:
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
        """Every plane case; what is wrong with a mesh is found when it is read."""
        return NO_SOLIDS if case.geometry.solid is not None else ()

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> EdgeHistories:
        """Edge histories of a case. Collective.

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
        self._kept = KeptModel(MPI.COMM_WORLD)

    def group(self, case: Case) -> str:
        """Equal for cases that share a model."""
        return model_key(case)

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> EdgeHistories:
        """As `FemBackend.solve`. Collective."""
        return _solve(case, options, self._kept.solve)

    def close(self) -> None:
        """Give the model back. Collective."""
        self._kept.drop()


def _solve(case: Case, options: RunOptions, solve_case: SolveCase) -> EdgeHistories:
    """Solve and evaluate a case, on one mesh by `solve_case`. Collective."""

    def report(number: int, count: int, result: StepResult) -> None:
        options.progress(number, count, result.summary)

    comm = MPI.COMM_WORLD
    history = on_root(comm, lambda: options.history or build_history(case))
    assert history is not None
    if case.edges is not None:
        solved = refine(comm, case, history, options.fields, report, options.announce)
    else:
        load = partial(_load, case, options.announce)
        solved = Evaluated(solve_case(case, history, options.fields, report, load))
    outcome = solved.outcome
    return EdgeHistories(
        history=_solved_history(comm, outcome),
        contacts=outcome.contacts,
        failure=outcome.failure,
        solution=outcome.solution,
        bodies=outcome.mesh.bodies if outcome.mesh else {},
        versions=_compat.versions(),
        seconds=outcome.seconds,
        ranks=comm.size,
        refinement=solved.refinement,
    )


def _load(case: Case, announce: Announce) -> Mesh:
    """The mesh of a case; its size tells how long it takes until the first step is solved."""
    mesh = load_mesh(case)
    unknowns = count_unknowns(mesh, case.model.degree)
    announce(f"mesh: {unknowns} unknowns; the bodies are condensed before the first step")
    return mesh


def _solved_history(comm: MPI.Comm, outcome: Outcome) -> History:
    """The states that were solved. Collective."""

    def history() -> History:
        solution = _solution(outcome)
        return History(solution.channels, solution.times, solution.values, solution.cycle)

    shared = on_root(comm, history)
    assert shared is not None
    return shared


def _solution(outcome: Outcome) -> Solution:
    """On rank 0."""
    assert outcome.solution is not None
    return outcome.solution


BACKEND = FemBackend()
