# SPDX-License-Identifier: LGPL-3.0-or-later
"""The backend `fem`: finite elements, any geometry; collective over all MPI processes."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

from fretfe.backends import EdgeHistories, Processes, RunOptions
from fretfe.backends.protocol import DEFAULTS
from fretfe.case import Case
from fretfe.contact.march import StepResult
from fretfe.evaluate import ContactSummary, evaluate
from fretfe.fem import _compat
from fretfe.fem._compat import MPI
from fretfe.fem.parallel import on_root
from fretfe.fem.run import solve
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
        outcome = solve(comm, case, history, options.fields, report)
        start = time.perf_counter()
        shared = on_root(comm, lambda: _evaluate(outcome.solution))
        assert shared is not None
        history, contacts = shared
        return EdgeHistories(
            history=history,
            contacts=contacts,
            failure=outcome.failure,
            solution=outcome.solution,
            bodies=outcome.mesh.bodies if outcome.mesh else {},
            versions=_compat.versions(),
            seconds={**outcome.seconds, "evaluation": time.perf_counter() - start},
            ranks=comm.size,
        )


def _evaluate(solution: Solution | None) -> tuple[History, tuple[ContactSummary, ...]]:
    """The states that were solved, and what they mean; on rank 0."""
    assert solution is not None
    history = History(solution.channels, solution.times, solution.values, solution.cycle)
    return history, evaluate(solution)


BACKEND = FemBackend()
