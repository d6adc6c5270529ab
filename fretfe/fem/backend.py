# SPDX-License-Identifier: LGPL-3.0-or-later
"""The backend `fem`: finite elements, any geometry; collective over all MPI processes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from fretfe.backends import EdgeHistories, Processes, RunOptions
from fretfe.backends.protocol import DEFAULTS
from fretfe.case import Case
from fretfe.contact.march import StepResult
from fretfe.fem import _compat
from fretfe.fem._compat import MPI
from fretfe.fem.parallel import on_root
from fretfe.fem.refine import Evaluated, refine
from fretfe.fem.run import Outcome, Progress, solve
from fretfe.loads import History, build_history
from fretfe.solution import Solution

T = TypeVar("T")


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
        """Every valid case; what is wrong with a mesh is found when it is read."""
        return ()

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> EdgeHistories:
        """Edge histories of a case. Collective.

        Raises:
            FretfeError: for whatever keeps the history from being started, on all ranks.
        """

        def report(number: int, count: int, result: StepResult) -> None:
            options.progress(number, count, result.summary)

        comm = MPI.COMM_WORLD
        history = on_root(comm, lambda: options.history or build_history(case))
        assert history is not None
        solved = _solve(comm, case, history, options, report)
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


def _solve(
    comm: MPI.Comm, case: Case, history: History, options: RunOptions, progress: Progress
) -> Evaluated:
    """Solve and evaluate a case on the mesh it asks for. Collective."""
    if case.edges is not None:
        return refine(comm, case, history, options.fields, progress, options.announce)
    return Evaluated(solve(comm, case, history, options.fields, progress))


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
