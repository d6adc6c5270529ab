# SPDX-License-Identifier: LGPL-3.0-or-later
"""The backend `halfplane`: a semi-analytical solution for half-planes."""

from __future__ import annotations

import time

from fretfe.backends.fields_only import field_obstacles
from fretfe.backends.finite_bodies import size_limit, with_size_errors
from fretfe.backends.protocol import DEFAULTS, RunOptions
from fretfe.case import Case
from fretfe.edges.evaluate import evaluate
from fretfe.edges.limits import contact_limits, with_limit_warnings
from fretfe.edges.separation import separate_patches
from fretfe.halfplane.solver import solve_half_planes
from fretfe.idealise import idealise, obstacles
from fretfe.results.model import Result


class HalfPlaneBackend:
    """Half-planes with any symmetric profile under any history of P, Q, M and sigma0."""

    summary = "semi-analytical half-planes: pads on large blocks, any load history"

    def supports(self, case: Case) -> tuple[str, ...]:
        """Reasons why a case is not a half-plane problem, or asks for fields."""
        return (*obstacles(case), *field_obstacles(case))

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        """Solve a case that is a half-plane problem.

        Raises:
            NotIdealisable: if it is none.
            CaseError: if template, parameters or history are not valid.
        """
        problem = idealise(case, options.history)
        start = time.perf_counter()
        outcome = solve_half_planes(
            problem,
            progress=options.progress,
            until_steady=case.cycle.until_steady,
            storage=options.storage({}),
        )
        solved = time.perf_counter()
        solution = separate_patches(outcome.solution)
        contacts = evaluate(solution, outcome.unit_factors)
        judged = (limit for each in solution.contacts for limit in contact_limits(case, each))
        limits = (*judged, *(size_limit(each.name, problem) for each in contacts))
        return Result(
            case=case,
            loads=solution.loads,
            contacts=with_limit_warnings(
                [with_size_errors(each, problem) for each in contacts], limits
            ),
            limits=limits,
            notes=(*problem.notes, *(each.text for each in solution.repeats)),
            failure=outcome.failure,
            solution=solution,
            seconds={"steps": solved - start, "evaluation": time.perf_counter() - solved},
        )


BACKEND = HalfPlaneBackend()
