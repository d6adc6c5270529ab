# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve a case with finite elements, from its geometry to a `Solution`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fretfe.case import Case, check_dimension, complaint
from fretfe.contact.march import March, StepResult
from fretfe.contact.recorder import Place, Recorder
from fretfe.errors import CaseError, ConvergenceError, ModelError
from fretfe.evaluate import ContactSummary, evaluate
from fretfe.evaluate.extremes import load_extremes
from fretfe.fem._compat import MPI, release
from fretfe.fem.balance import force_balance
from fretfe.fem.contact_checks import check_contacts
from fretfe.fem.extraction import add_integrals
from fretfe.fem.fields import write_fields
from fretfe.fem.mesh_groups import check_groups
from fretfe.fem.meshing import Mesh, SetSizes, mesh_template, read_mesh
from fretfe.fem.model import Model, step_loads
from fretfe.fem.parallel import on_root
from fretfe.fem.timing import Clock
from fretfe.loads import History
from fretfe.solution import Solution
from fretfe.templates import Template, find_template

Progress = Callable[[int, int, StepResult], None]
LoadMesh = Callable[[], Mesh]


@dataclass(frozen=True)
class Outcome:
    """What solving a case produced; the same on all ranks but for what only rank 0 has.

    Attributes:
        solution: all accepted steps; rank 0 only.
        contacts: its evaluation.
        mesh: the bodies' meshes; rank 0 only.
        failure: why the history was not finished, or None.
        seconds: wall time of each phase on this rank.
    """

    solution: Solution | None
    contacts: tuple[ContactSummary, ...]
    mesh: Mesh | None
    failure: ConvergenceError | None
    seconds: dict[str, float]


def load_mesh(case: Case, size: SetSizes | None = None) -> Mesh:
    """Read or make the mesh of a case and check it against the case. Serial.

    Args:
        case: validated case.
        size: sets element sizes in place of those of the geometry.

    Raises:
        CaseError: if the template or its parameters are not valid, a direction does not fit, or the
            geometry has a mesh already and sizes are to be set.
        MeshError: if there is no valid mesh with all the groups that the case names, or its contact
            surfaces overlap or do not face each other.
    """
    geometry = case.geometry
    if geometry.template is not None:
        template = find_template(geometry.template)
        if size is not None:
            _refuse_sizes(case, template)
        mesh = mesh_template(template, geometry.parameters, geometry.order, size)
    else:
        assert geometry.file is not None
        if size is not None:
            raise CaseError(
                complaint(
                    case.source,
                    ("edges", "tolerance"),
                    f"expected a geometry that can be meshed again, found the mesh "
                    f"{geometry.file!r}",
                )
            )
        mesh = read_mesh(case.resolve(geometry.file))
    check_groups(mesh, case)
    check_dimension(case, mesh.dimension)
    if mesh.dimension == 2:
        check_contacts(mesh, case)
    return mesh


def _refuse_sizes(case: Case, template: Template) -> None:
    """A mesh that refines itself takes no element sizes."""
    given = [each.name for each in template.parameters if each.is_mesh_size]
    given = [name for name in given if name in case.geometry.parameters]
    if given:
        text = f"expected no element sizes together with edges.tolerance, found {', '.join(given)}"
        raise CaseError(complaint(case.source, ("geometry", "parameters"), text))


def solve(
    comm: MPI.Comm,
    case: Case,
    history: History,
    fields: Path | None,
    progress: Progress,
    load: LoadMesh | None = None,
) -> Outcome:
    """Solve the load history of a case and evaluate it. Collective.

    Args:
        comm: communicator.
        case: validated case, the same on all ranks.
        history: its load history, the same on all ranks.
        fields: folder for the fields that the case asks for; None writes none.
        progress: called on rank 0 with each accepted step, the number of steps, and its result.
        load: gives the mesh, called on rank 0; None for `load_mesh`.

    Raises:
        FretfeError: for whatever keeps the history from being started; see `Outcome.failure` for
            a history that was not finished.
    """
    own = load or partial(load_mesh, case)
    outcome, meshes = _solve(comm, case, history, fields, progress, own)
    release(meshes)
    return outcome


def _solve(
    comm: MPI.Comm,
    case: Case,
    history: History,
    fields: Path | None,
    progress: Progress,
    load: LoadMesh,
) -> tuple[Outcome, list[Any]]:
    """Outcome, and the meshes whose models nobody refers to any more."""
    clock = Clock()
    with clock("mesh"):
        mesh = on_root(comm, load, share=False)
    model = Model(comm, case, mesh, clock)
    with clock("steps"):
        marched = on_root(comm, lambda: _march(model, case, history, progress), share=False)
    failure = comm.bcast(marched.failure if marched else None)
    solution = _solution(model, history, marched.recorder) if marched else None
    recorder, march = (marched.recorder, marched.march) if marched else (None, None)
    with clock("edge integrals"):
        solution = add_integrals(model, case, recorder, march, solution)
    with clock("evaluation"):
        contacts = on_root(comm, lambda: evaluate(solution) if solution else ())
        assert contacts is not None
    if fields is not None:
        with clock("fields"):
            chosen = _field_states(case, history, solution, contacts) if solution else None
            _write_fields(model, history, recorder, chosen, fields)
    meshes = [body.elastic.mesh for body in model.bodies.values()]
    return Outcome(solution, contacts, mesh, failure, clock.seconds), meshes


def _solution(model: Model, history: History, recorder: Recorder) -> Solution:
    reduction = model.reduction
    assert reduction is not None
    return recorder.solution(history, force_balance(reduction, recorder.states, recorder.steps))


@dataclass(frozen=True)
class _Marched:
    """The accepted steps, what solved them, and why there are not more of them."""

    march: March
    recorder: Recorder
    failure: ConvergenceError | None


def _march(model: Model, case: Case, history: History, progress: Progress) -> _Marched:
    """Solve all steps; one that fails ends the history and keeps what was computed."""
    reduction = model.reduction
    assert reduction is not None
    steps = step_loads(case, history, reduction.interface, reduction.plan)
    march = March(reduction.interface)
    places = [Place(p.name, p.body1, p.body2, p.coupling) for p in reduction.pairs]
    channels = [load.channel for load in reduction.plan.loads]
    recorder = Recorder(march, places, steps, channels, case.model.degree)
    try:
        for number, result in enumerate(march.run(steps), start=1):
            recorder.add(result)
            progress(number, len(steps) - 1, result)
    except ConvergenceError as failure:
        return _Marched(march, recorder, failure)
    _require_contact(recorder)
    return _Marched(march, recorder, None)


def _require_contact(recorder: Recorder) -> None:
    """A history in which contact never carries anything is a mistake in the case."""
    if recorder.contact_carries():
        return
    adrift = recorder.bodies_with_free_motions()
    reason = (
        f"nothing but contact holds {' and '.join(repr(name) for name in adrift)}, which gave way: "
        "support it, or press it against the other body with a force"
        if adrift and recorder.smallest_gap() <= recorder.gap_round_off()
        else f"the smallest gap on the way was {recorder.smallest_gap():.6g}. Check the signs and "
        "sizes of the loads that should bring the bodies together, and their place in the mesh"
    )
    raise ModelError(f"no contact surfaces pressed on each other in any step: {reason}.")


def _write_fields(
    model: Model,
    history: History,
    recorder: Recorder | None,
    chosen: list[int] | None,
    directory: Path,
) -> None:
    """Write displacement and stress of the chosen states, which rank 0 has. Collective."""
    states = model.comm.bcast(chosen)
    if not states:
        return
    requests = recorder.requests(states) if recorder else None
    write_fields(model, model.recover(requests), history.times[states], directory)


def _field_states(
    case: Case, history: History, solution: Solution, contacts: tuple[ContactSummary, ...]
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
        edges = [edge for contact in contacts for edge in contact.edges]
        states = load_extremes([e.k_t for e in edges], [e.k_i for e in edges], solution.cycle)
        return sorted({*states, *solved[-1:]} & set(solved))
    return [state for state in (history.step(time) for time in wanted) if state in solved]
