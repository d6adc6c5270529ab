# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve a case with finite elements, from its geometry to a `Result`."""

from __future__ import annotations

from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.backends.protocol import DEFAULTS, RunOptions
from fretfe.bodies.definition import Pair
from fretfe.case import Case
from fretfe.contact.interface import Place
from fretfe.contact.recorder import Recorder
from fretfe.contact.solve import solve_history
from fretfe.errors import ConvergenceError, FretfeError, ModelError, OutputError, StoppedError
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.evaluate import Tracks, evaluate
from fretfe.evaluate.limits import ModelLimit, with_limit_warnings
from fretfe.evaluate.plane.patches_in_time import separate_patches
from fretfe.evaluate.resultants import load_extremes
from fretfe.evaluate.step_ends import division_notes, step_ends
from fretfe.fem import _compat
from fretfe.fem._compat import MPI
from fretfe.fem.extraction import add_integrals
from fretfe.fem.fields import FieldOutput
from fretfe.fem.limits import (
    balance,
    farthest_states,
    imbalance,
    model_limits,
    unpaired_penetration,
)
from fretfe.fem.model import LoadMesh, Model, Prepared, build_model, step_loads
from fretfe.fem.parallel import SharedStop, on_root, release
from fretfe.fem.probes import state_requests
from fretfe.fem.stress_output import refuse_solids, write_stress
from fretfe.fem.timing import Clock
from fretfe.history.solution import Solution
from fretfe.loads import History, build_history
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result


def solve(
    comm: MPI.Comm, case: Case, options: RunOptions = DEFAULTS, load: LoadMesh | None = None
) -> Result:
    """Solve the load history of a case and evaluate it. Collective.

    Args:
        comm: communicator.
        case: validated case, the same on all ranks.
        options: file for fields, other loads, observer.
        load: gives the mesh, called on rank 0; None for `load_mesh`.

    Raises:
        FretfeError: for whatever keeps the history from being started; see `Result.failure` for
            a history that was not finished.
    """
    result, meshes = _solve(comm, case, options, load)
    release(meshes)
    return result


def _solve(
    comm: MPI.Comm, case: Case, options: RunOptions, load: LoadMesh | None
) -> tuple[Result, list[Any]]:
    """Result, and the meshes whose models nobody refers to any more."""
    clock = Clock(options.doing)
    history = load_history(comm, case, options)
    prepared = build_model(comm, case, clock, load)
    return solve_prepared(prepared, case, history, options, clock), prepared.meshes


def load_history(comm: MPI.Comm, case: Case, options: RunOptions) -> History:
    """Load history of a run, that of the case unless there is another one. Collective."""
    return on_root(comm, lambda: options.history or build_history(case))


def solve_prepared(
    prepared: Prepared, case: Case, history: History, options: RunOptions, clock: Clock
) -> Result:
    """Solve a load history with a model that is there. Collective.

    Args:
        prepared: mesh and model of a case that differs in friction and load histories at most.
        case: as for `solve`.
        history: the loads, the same on all ranks.
        options: file for fields, and observer.
        clock: for timings, of the preparation too if that belongs to this case.

    Raises:
        FretfeError: as for `solve`.
    """
    model, mesh = prepared.model, prepared.mesh
    comm = model.comm
    refuse_solids(case, model.dimension)
    with clock("steps"):
        marched = _march_on_root(prepared, case, history, options)
    failure = comm.bcast(marched.failure if marched else None)
    recorder = marched.recorder if marched else None
    solution = _solution(model, history, marched.recorder) if marched else None
    with clock("edge integrals"):
        tracks = on_root(comm, lambda: _fronts(case, solution), share=False)
        solution = add_integrals(model, recorder, prepared.march, solution, tracks, options.doing)
    with clock("evaluation"):
        found = _evaluate(model, recorder, solution, tracks)
        failure = failure or on_root(comm, lambda: imbalance(solution) if solution else None)
    divided = division_notes(solution.ends) if solution else ()
    if solution is not None and (ends := step_ends(solution)):
        solution = ends.solution(solution)
    notes = model.notes + on_root(comm, lambda: _notes(mesh, divided, solution))
    result = Result(
        case=case,
        loads=comm.bcast(solution.loads if solution else None),
        contacts=found.contacts,
        solution=solution,
        notes=notes,
        failure=failure,
        limits=found.limits,
        bodies=mesh.bodies if mesh else {},
        versions=_compat.versions(),
        seconds=clock.seconds,
        ranks=comm.size,
    )
    options.keep(result)
    if options.stress is not None and case.output.stress_depths:
        with clock("stress near the contacts"):
            notes += _write_stress(model, recorder, solution, found, options.stress)
    if options.fields is None:
        return replace(result, notes=notes)
    with clock("fields"):
        chosen = _field_states(case, history, solution, found) if solution else None
        notes += _write_fields(model, history, recorder, chosen, options)
    return replace(result, notes=notes)


@dataclass(frozen=True)
class _Evaluation:
    """The contacts and the limits of the model."""

    contacts: tuple[Contact, ...] = ()
    limits: tuple[ModelLimit, ...] = ()


def _fronts(case: Case, solution: Solution | None) -> Tracks | None:
    """The fronts of all contacts of solids through the history; None in the plane."""
    if solution is None or solution.dimension == 2:
        return None
    # Imported where it is needed: SciPy's interpolation takes a second.
    from fretfe.evaluate.space.fronts import follow_fronts

    return {
        each.name: follow_fronts(solution, each, case.edges.stations) for each in solution.contacts
    }


def _evaluate(
    model: Model, recorder: Recorder | None, solution: Solution | None, tracks: Tracks | None
) -> _Evaluation:
    """The contacts, with warnings where the model does not hold, and its limits. Collective.

    Nothing on ranks other than 0, which has the solution.
    """
    depths = _penetration(model, recorder)

    def work() -> _Evaluation:
        if recorder is None or solution is None:
            return _Evaluation()
        contacts = evaluate(solution, tracks=tracks)
        limits = model_limits(model, recorder, solution, contacts, depths)
        contacts, ends = with_limit_warnings(contacts, limits), step_ends(solution)
        return _Evaluation(ends.contacts(solution, contacts) if ends else contacts, limits)

    return on_root(model.comm, work)


def _notes(
    mesh: Mesh | None, divided: tuple[str, ...], solution: Solution | None
) -> tuple[str, ...]:
    """Notes on the mesh, and on steps that were divided or not solved; in words."""
    repeats = solution.repeats if solution else ()
    return (*(mesh.notes if mesh else ()), *divided, *(each.text for each in repeats))


def _penetration(model: Model, recorder: Recorder | None) -> dict[str, float]:
    """Unpaired penetration of each contact; empty but on rank 0. Collective."""
    pairs = model.reduction.pairs if model.reduction and recorder else ()
    chosen = [farthest_states(model, pair, recorder) for pair in pairs] if recorder else []
    requests = state_requests(recorder, [int(each) for states in chosen for each in states])
    moved = model.surface_displacements(requests) or []
    ends = np.cumsum([len(states) for states in chosen])
    return {
        pair.name: unpaired_penetration(model, pair, moved[end - len(states) : end])
        for pair, states, end in zip(pairs, chosen, ends, strict=True)
    }


def _solution(model: Model, history: History, recorder: Recorder) -> Solution:
    reduction = model.reduction
    assert reduction is not None
    solution = recorder.solution(history, balance(reduction, recorder.blocks()))
    return separate_patches(solution) if model.dimension == 2 else solution


@dataclass(frozen=True)
class _Marched:
    """The accepted steps, and why there are not more of them."""

    recorder: Recorder
    failure: ConvergenceError | None


def _march_on_root(
    prepared: Prepared, case: Case, history: History, options: RunOptions
) -> _Marched | None:
    """Solve all steps; on ranks other than 0, from which signals come too, None. Collective."""
    comm = prepared.model.comm
    stop = SharedStop(comm, options.observer)
    heeding = replace(options, observer=stop)
    try:
        marched = on_root(
            comm,
            lambda: _march(prepared, case, history, heeding),
            share=False,
            waiting=stop.send,
        )
    except FretfeError:  # raised on all ranks, as nothing else is
        stop.close()
        raise
    stop.close()
    return marched


def _march(prepared: Prepared, case: Case, history: History, options: RunOptions) -> _Marched:
    """Solve all steps; one that fails ends the history and keeps what was computed."""
    reduction, march = prepared.model.reduction, prepared.march
    assert reduction is not None
    assert march is not None
    steps = step_loads(case, history, reduction.interface, reduction.definition)
    places = [_place(prepared.model, pair) for pair in reduction.pairs]
    channels = [load.channel for load in reduction.definition.loads]
    storage = options.storage({**_compat.versions(), "mesh": prepared.digest})
    recorder = Recorder(march, places, steps, channels, case.model.degree, storage)
    if recorder.steps_done:
        options.announce(f"continued after step {recorder.steps_done} of {len(steps) - 1}")
    try:
        solve_history(march, recorder, steps, case.cycle.until_steady, options.progress)
    except ConvergenceError as failure:
        if recorder.contact_carries or isinstance(failure, StoppedError):
            return _Marched(recorder, failure)
        hint = "Until then no surfaces pressed on each other: check the signs of the loads."
        return _Marched(recorder, ConvergenceError(f"{failure} {hint}"))
    _require_contact(recorder)
    return _Marched(recorder, None)


def _place(model: Model, pair: Pair) -> Place:
    facets = pair.coupling.facets if model.dimension == 3 else None
    return Place(pair.name, pair.body1, pair.body2, pair.coupling, facets)


def _require_contact(recorder: Recorder) -> None:
    """A history in which contact never carries anything is a mistake in the case."""
    if recorder.contact_carries:
        return
    adrift = recorder.bodies_restrained_by_contact
    reason = (
        f"nothing but contact holds {' and '.join(repr(name) for name in adrift)}, which gave way: "
        "support it, or press it against the other body with a force"
        if adrift and recorder.smallest_gap <= recorder.gap_round_off
        else f"the smallest gap on the way was {recorder.smallest_gap:.6g}. Check the signs and "
        "sizes of the loads that should bring the bodies together, and their place in the mesh"
    )
    raise ModelError(f"no contact surfaces pressed on each other in any step: {reason}.")


def _write_fields(
    model: Model,
    history: History,
    recorder: Recorder | None,
    chosen: list[int] | None,
    options: RunOptions,
) -> tuple[str, ...]:
    """Write the fields of the chosen states, which rank 0 has. Collective.

    Returns:
        Why they could not be written: no reason to lose the numbers.
    """
    states, path = model.comm.bcast(chosen), options.fields
    if not states or path is None:
        return ()
    try:
        with closing(FieldOutput(model, path)) as output:
            for number, state in enumerate(states, start=1):
                options.doing(f"fields: state {number} of {len(states)}")
                (displacements,) = model.recover_fields(state_requests(recorder, [state]))
                output.add(float(history.times[state]), displacements)
    except OutputError as error:
        on_root(model.comm, partial(_remove, path))
        return (str(error),)
    return ()


def _write_stress(
    model: Model,
    recorder: Recorder | None,
    solution: Solution | None,
    found: _Evaluation,
    path: Path,
) -> tuple[str, ...]:
    """Write the stress near the contacts of a history that has steps. Collective.

    Returns:
        Why it could not be written: no reason to lose the numbers.
    """
    if not model.comm.bcast(solution is not None and len(solution.times) > 1):
        return ()
    try:
        write_stress(model, recorder, solution, found.contacts, path)
    except OutputError as error:
        return (str(error),)
    return ()


def _remove(path: Path) -> None:
    """Remove a file that is not whole; one that cannot be removed stays."""
    with suppress(OSError):
        path.unlink(missing_ok=True)


def _field_states(
    case: Case, history: History, solution: Solution, found: _Evaluation
) -> list[int]:
    """Solved states whose fields the case asks for."""
    solved = range(1, len(solution.times))
    wanted = case.output.fields
    if wanted == "none":
        return []
    if wanted == "all":
        return list(solved)
    if wanted == "last":
        return list(solved[-1:])
    if wanted == "extremes":
        states = load_extremes(found.contacts, solution.cycle)
        return sorted({*states, *solved[-1:]} & set(solved))
    return [state for state in (history.step(time) for time in wanted) if state in solved]
