# SPDX-License-Identifier: LGPL-3.0-or-later
"""The backend `halfplane`: a semi-analytical solution for half-planes in place of finite bodies."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain

from fretfe.backends.protocol import DEFAULTS, Backend, RunOptions, field_obstacles
from fretfe.case import Case
from fretfe.errors import CaseError, ConvergenceError, FretfeError, ModelError
from fretfe.evaluate.contacts import Contact, Station, fronts_of
from fretfe.evaluate.evaluate import evaluate, unknown_contacts, with_patches
from fretfe.evaluate.limits import (
    ModelLimit,
    contact_limits,
    friction_limits,
    unlike_notes,
    with_limit_warnings,
)
from fretfe.evaluate.step_ends import at_step_ends, division_notes
from fretfe.faults import guarded
from fretfe.halfplane.solver import solve_half_planes
from fretfe.history.solution import Solution
from fretfe.idealise import HalfPlaneProblem, idealise, obstacles
from fretfe.idealise.problem import left_out_by_stretch
from fretfe.reason import Kind
from fretfe.results.model import Result

# Error of K_N or K_T from which the factors of half-planes are not those of the bodies, and of the
# longest slip zone, by what P stretches different bodies, from which its length is not.
LARGEST_SIZE_ERROR = 0.01
LARGEST_STRETCH = 0.05


def with_size_errors(summary: Contact, problem: HalfPlaneProblem) -> Contact:
    """The same contact with error bars that hold the factors of the finite bodies as well."""
    stretch = left_out_by_stretch(problem)
    stations = (_wider(station, problem, *stretch) for station in summary.stations)
    return replace(summary, fronts=fronts_of(stations))


def _wider(station: Station, problem: HalfPlaneProblem, k_t: float, length: float) -> Station:
    """A station with what size and slope of the bodies do, and what their stretch does to both."""
    parts = station.k_range_parts
    size = problem.k_t_error * station.k_t_range + k_t
    parts = replace(parts, discretisation=parts.discretisation + size)
    zones = (
        replace(zone, spread=zone.spread + problem.slip_error * zone.length + length)
        for zone in station.slip_zones
    )
    return replace(
        station,
        k_n_spread=station.k_n_spread + problem.k_n_error * station.k_n,
        k_range_spread=parts.total,
        k_range_parts=parts,
        slip_zones=tuple(zones),
    )


def size_limits(contact: Contact, problem: HalfPlaneProblem) -> Iterator[ModelLimit]:
    """Errors of a contact that the size of the bodies makes.

    The larger one of K_N and K_T, and between different bodies that of the longest slip zone, or of
    the half-width without any, by their stretch under P.
    """
    yield ModelLimit(
        contact.name,
        Kind.BODY_SIZE,
        "error of K_N or ΔK_T because the bodies are not half-planes",
        max(problem.k_n_error, problem.k_t_error),
        LARGEST_SIZE_ERROR,
    )
    _, change = left_out_by_stretch(problem)
    if not change:
        return
    lengths = [zone.length for each in contact.stations for zone in each.slip_zones]
    longest = max((each for each in lengths if each > 0), default=contact.half_width[-1])
    yield ModelLimit(
        contact.name,
        Kind.BODY_STRETCH,
        "error of the slip zones because P stretches different bodies by different amounts",
        change / float(longest),
        LARGEST_STRETCH,
    )


def _limits(
    case: Case, solution: Solution, contacts: Sequence[Contact], problem: HalfPlaneProblem
) -> tuple[ModelLimit, ...]:
    """Limits of the model, of the contacts and of the size of the bodies."""
    bodies, plane = case.bodies, case.model.plane
    own = (limit for each in solution.contacts for limit in contact_limits(bodies, plane, each))
    rough = (
        limit
        for contact, history in zip(contacts, solution.contacts, strict=True)
        for limit in friction_limits(contact, history, solution.cycle)
    )
    return (*own, *rough, *chain.from_iterable(size_limits(each, problem) for each in contacts))


class HalfPlaneBackend(Backend):
    """Half-planes with any symmetric profile under any history of P, Q, M and sigma0."""

    summary = "semi-analytical half-planes: pads on large blocks, any load history"

    def supports(self, case: Case) -> tuple[str, ...]:
        """Reasons why a case is not a half-plane problem, or asks for fields."""
        return (*obstacles(case), *field_obstacles(case))

    def refusal(self, case: Case) -> type[FretfeError]:
        """That of the model or the step where the contact opens or slides, else of the case."""
        try:
            idealise(case)
        except (ModelError, ConvergenceError) as error:
            return type(error)
        except CaseError:
            pass
        return CaseError

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
        solution, lost = with_patches(outcome.solution)
        told = case.edges.reference_length
        contacts = (
            unknown_contacts(solution, lost)
            if lost
            else evaluate(solution, outcome.unit_factors, reference_length=told)
        )
        divided = division_notes(solution)
        notes = (*problem.notes, *divided, *(each.text for each in solution.repeats))
        if problem.dundurs:
            beta = f"Dundurs' beta = {problem.dundurs:.3g}"
            notes = (*notes, f"pressure and shear depend on each other ({beta})")
        found = guarded("notes", lambda: tuple(unlike_notes(told, contacts)), lambda _: ())
        notes = (*notes, *found)
        limits = guarded(
            "limits of the model", lambda: _limits(case, solution, contacts, problem), lambda _: ()
        )
        # Without what the size of the bodies does to them the error bars are too small.
        contacts = guarded(
            "error bars by the size of the bodies",
            lambda: tuple(with_size_errors(each, problem) for each in contacts),
            partial(unknown_contacts, solution),
        )
        contacts = with_limit_warnings(contacts, limits)
        solution, contacts = at_step_ends(solution, contacts)
        return Result(
            case=case,
            loads=solution.loads,
            contacts=contacts,
            limits=limits,
            notes=notes,
            failure=outcome.failure,
            root_solution=solution,
            seconds={"steps": solved - start, "evaluation": time.perf_counter() - solved},
        )


BACKEND = HalfPlaneBackend()
