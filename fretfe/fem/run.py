# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve a case with finite elements, from its geometry to a `Result`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.backends.protocol import DEFAULTS, RunOptions
from fretfe.bodies.beginning import read_beginning
from fretfe.bodies.carried import require_carried
from fretfe.bodies.continued import softest_layer
from fretfe.bodies.definition import ModelDefinition, Pair, require_possible
from fretfe.bodies.expected import pulled_off, require_pressed
from fretfe.bodies.loads.files import checked_history
from fretfe.case import Case, Wave, case_notes
from fretfe.contact.interface import Place, Resultant
from fretfe.contact.recorder import Recorder
from fretfe.contact.solve import extrapolate_slip, solve_history
from fretfe.contact.state import StepLoads
from fretfe.errors import ConvergenceError, ModelError, OutputError, StoppedError
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.cycles import cycle_changes, may_become_steady
from fretfe.evaluate.evaluate import Tracks, evaluate, unknown_contacts, with_patches
from fretfe.evaluate.friction_work import work_settles
from fretfe.evaluate.limits import (
    ModelLimit,
    unlike_notes,
    with_crossed_spreads,
    with_cut_spreads,
    with_limit_warnings,
)
from fretfe.evaluate.resultants import load_extremes
from fretfe.evaluate.step_ends import at_step_ends, division_notes
from fretfe.evaluate.withheld import untouched_hint
from fretfe.faults import Fault, guarded
from fretfe.fem import _compat
from fretfe.fem._compat import MPI
from fretfe.fem.extraction import add_integrals
from fretfe.fem.fields import FieldOutput, FieldSource, Recovery
from fretfe.fem.limits import (
    balance,
    farthest_states,
    friction_notes,
    imbalance,
    model_limits,
    opened,
    unpaired_penetration,
)
from fretfe.fem.model import LoadMesh, Marched, Model, Prepared, build_model, step_loads
from fretfe.fem.parallel import Lead, SharedStop, on_root, release, use_waiting_cores
from fretfe.fem.probes import state_requests
from fretfe.fem.station_stress import write_stations
from fretfe.fem.stress_output import write_stress
from fretfe.fem.timing import Clock
from fretfe.history.solution import Solution
from fretfe.idealise.bodies import coupled_beta
from fretfe.loads import AddedCycles, History, most_added, told_states
from fretfe.materials.moduli import contact_modulus
from fretfe.mesh.mesh import Mesh, growth_inward
from fretfe.results.field_files import COLUMNS, DISPLACEMENTS
from fretfe.results.model import Result
from fretfe.surface.checks import load_mesh


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
    prepared = build_model(comm, case, clock, partial(_pressed, case, history, load))
    return solve_prepared(prepared, case, history, options, clock), prepared.meshes


def _pressed(case: Case, history: History, load: LoadMesh | None) -> Mesh:
    """The mesh of a case whose contacts and supports may carry the loads."""
    mesh = load() if load is not None else load_mesh(case)
    require_pressed(case, mesh, history)
    require_carried(case, mesh, history)
    return mesh


def load_history(comm: MPI.Comm, case: Case, options: RunOptions) -> History:
    """Load history of a run, that of the case unless there is another one. Collective."""
    return on_root(comm, lambda: options.history or checked_history(case))


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
    model = prepared.model
    comm = model.comm
    use_waiting_cores(comm)
    with SharedStop(comm, options.observer) as stop:
        lead = Lead(comm, Recovery(model), stop.send)
        heeding = replace(options, observer=stop)
        run = _Run(prepared, case, history, heeding, clock, FieldSource(model, lead))
        result = _without_states(comm, lead.run(run.evaluate, share=False))
        options.keep(result)
        return replace(result, notes=result.notes + lead.run(run.write))


def _cut_notes(case: Case, definition: ModelDefinition, solution: Solution) -> Iterator[str]:
    """Largest resultants on boundaries that another run moves, in words."""
    known = [each for body in definition.bodies for each in body.coordinates]
    solid, units = solution.dimension == 3, case.units
    force, moment = units.force, f"{units.force}·{units.length}"
    if not solid:
        force, moment = (f"{unit}/{units.length}" for unit in (force, moment))
    for name in case.cut_loads:
        largest = []
        for wanted in (Resultant(name, "force"), Resultant(name, "moment")):
            given = {each.label for each in known if each.resultant == wanted}
            columns = [label in given for label in solution.coordinates]
            own = np.asarray(solution.forces)[:, columns]
            largest.append(float(np.linalg.norm(own, axis=1).max()))
        yield (
            f"loads.{name}: the largest force on the cut is {largest[0]:.4g} {force}, the "
            f"largest moment about the middle of its extent {largest[1]:.4g} {moment}; those "
            "of the other run should be the same"
        )


def _without_states(comm: MPI.Comm, result: Result | None) -> Result:
    """The result of rank 0; the others have all of it but what may be large. Collective."""
    light = replace(result, root_solution=None, bodies={}) if result is not None else None
    shared: Result = comm.bcast(light)
    return result or shared


class _Run:
    """A history on a model, solved, evaluated and written; rank 0 only.

    Args:
        prepared: the model.
        case: as for `solve_prepared`.
        history: the loads.
        options: files, and observer.
        clock: for timings.
        fields: answers with fields of the solved states.
    """

    def __init__(
        self,
        prepared: Prepared,
        case: Case,
        history: History,
        options: RunOptions,
        clock: Clock,
        fields: FieldSource,
    ) -> None:
        self._prepared, self._model, self._case = prepared, prepared.model, case
        self._history, self._options = history, options
        self._written = len(history.times) - 1
        self._clock, self._fields = clock, fields
        self._recorder: Recorder
        self._solution: Solution
        self._contacts: tuple[Contact, ...]

    def evaluate(self) -> Result:
        """Solve the history and evaluate it."""
        model, case, clock = self._model, self._case, self._clock
        with clock("steps"):
            marched = _march(self._prepared, case, self._history, self._options)
            recorder = self._recorder = marched.recorder
            added = _added_note(case, self._history, marched.history)
            self._history = marched.history
            solution, lost = _solution(model, self._history, recorder)
        with clock("edge integrals"):
            tracks = _fronts(case, solution)
            if not lost:
                solution = self._with_integrals(solution, tracks)
        with clock("evaluation"):
            contacts, limits = (
                (unknown_contacts(solution, lost), ())
                if lost
                else self._evaluated(solution, tracks)
            )
            failure = marched.failure or guarded(
                "balance of forces", lambda: imbalance(solution), lambda _: None
            )
        if tracks is not None and case.edges.local:
            with clock("local problems"):
                contacts = self._local_problems(solution, contacts)
        divided = division_notes(solution)
        solution, contacts = at_step_ends(solution, contacts)
        self._solution, self._contacts = solution, contacts
        repeats, told = (each.text for each in solution.repeats), case.edges.reference_length
        # Of contacts without friction there is none.
        left = float(np.fmax.reduce([0.0, *(each.cycle_change for each in contacts)]))
        return Result(
            case=case,
            loads=solution.loads,
            contacts=contacts,
            root_solution=solution,
            notes=(
                *case_notes(case),
                *model.notes,
                *_cut_notes(case, model.reduction.definition, solution),
                *self._prepared.mesh.notes,
                *divided,
                *repeats,
                *(f"{each}; it changes shear by {left:.2g} of friction's bound" for each in added),
                *guarded("notes", lambda: tuple(unlike_notes(told, contacts)), lambda _: ()),
                *guarded("notes", lambda: tuple(friction_notes(model, solution)), lambda _: ()),
            ),
            failure=failure,
            limits=limits,
            bodies=self._prepared.mesh.bodies,
            versions=_compat.versions(),
            seconds=clock.seconds,
            ranks=model.comm.size,
        )

    def _with_integrals(self, solution: Solution, tracks: Tracks | None) -> Solution:
        """The solution with its interaction integrals; K_T has no error bar without them."""
        say, march = self._options.doing, self._prepared.march
        arguments = self._fields, self._recorder, march, solution, tracks, say
        return guarded(
            "edge integrals", lambda: add_integrals(self._model, *arguments), lambda _: solution
        )

    def _evaluated(
        self, solution: Solution, tracks: Tracks | None
    ) -> tuple[tuple[Contact, ...], tuple[ModelLimit, ...]]:
        """The contacts, and the limits of the model."""
        recorder, told = self._recorder, self._case.edges.reference_length
        contacts = evaluate(solution, tracks=tracks, reference_length=told)

        def measured() -> tuple[ModelLimit, ...]:
            depths = self._penetration()
            return tuple(model_limits(self._model, recorder, solution, contacts, depths))

        limits = guarded("limits of the model", measured, lambda _: ())
        unknown = partial(unknown_contacts, solution)
        crossed = guarded(
            "error bars by cross compliances",
            lambda: with_crossed_spreads(
                contacts, solution.contacts, self._case.bodies, self._case.model.plane
            ),
            unknown,
        )
        warned = with_limit_warnings(crossed, limits)
        # Without the error bars of the cuts nothing is known.
        return guarded(
            "error bars by cuts",
            lambda: with_cut_spreads(warned, recorder, solution.cycle),
            unknown,
        ), limits

    def _local_problems(
        self, solution: Solution, contacts: tuple[Contact, ...]
    ) -> tuple[Contact, ...]:
        """Contacts of solids with the plane problems of their stations."""
        # Imported where it is needed: SciPy's interpolation takes a second.
        from fretfe.evaluate.space.local import add_local_problems

        bodies, share = self._case.bodies, self._fields.edge_slip
        return guarded(
            "plane problems next to the fronts",
            lambda: add_local_problems(solution, contacts, bodies, share),
            lambda _: contacts,
        )

    def write(self) -> tuple[str, ...]:
        """Write what the case asks for of the fields.

        Returns:
            Why it could not be written: no reason to lose the numbers.
        """
        notes: tuple[str, ...] = ()
        if self._options.stress is not None and self._case.output.stress_depths:
            notes += self._attempt(
                "stress near the contacts", partial(self._write_stress, self._options.stress)
            )
        if self._options.fields is not None:
            path, every = self._options.fields, (*COLUMNS,)
            notes += self._attempt(
                "fields", partial(self._write_fields, path, self._field_states(), every)
            )
            if self._case.edges.ends and self._case.output.fields != "all":
                arguments = path.with_name(DISPLACEMENTS), self._told_states(), every[:1]
                notes += self._attempt("displacements", partial(self._write_fields, *arguments))
        return notes

    def _attempt(self, phase: str, write: Callable[[], tuple[str, ...]]) -> tuple[str, ...]:
        with self._clock(phase):
            return guarded(phase, write, lambda fault: (fault.text,))

    def _penetration(self) -> dict[str, float]:
        """Unpaired penetration of each contact."""
        model, recorder, pairs = self._model, self._recorder, self._model.reduction.pairs
        chosen = [farthest_states(model, pair, recorder) for pair in pairs]
        requests = state_requests(recorder, [int(each) for states in chosen for each in states])
        moved = iter(self._fields.surface_displacements(requests))
        return {
            pair.name: unpaired_penetration(model, pair, list(islice(moved, len(states))))
            for pair, states in zip(pairs, chosen, strict=True)
        }

    def _write_stress(self, path: Path) -> tuple[str, ...]:
        if len(self._solution.times) == 1:
            return ()
        arguments = self._recorder, self._solution, self._contacts, path
        write = write_stations if self._model.dimension == 3 else write_stress
        try:
            write(self._model, self._fields, *arguments)
        except OutputError as error:
            return (str(error),)
        return ()

    def _write_fields(
        self, path: Path, states: list[int], names: tuple[str, ...]
    ) -> tuple[str, ...]:
        if not states:
            return ()
        try:
            with closing(FieldOutput(self._fields, path, names)) as output:
                self._options.doing(f"fields: {len(states)} of {len(self._history.times)}")
                at_once = output.states_at_once
                for first in range(0, len(states), at_once):
                    some = states[first : first + at_once]
                    times = self._history.times[some].tolist()
                    output.add(times, state_requests(self._recorder, some))
        except OutputError as error:
            with suppress(OSError):  # one that cannot be removed stays
                path.unlink(missing_ok=True)
            return (str(error),)
        return ()

    def _told_states(self) -> list[int]:
        return [int(each) for each in told_states(self._history, self._written)]

    def _field_states(self) -> list[int]:
        """Solved states whose fields the case asks for."""
        solved = range(1, len(self._solution.times))
        wanted = self._case.output.fields
        if wanted == "none":
            return []
        if wanted == "all":
            return self._told_states()
        if wanted == "last":
            return list(solved[-1:])
        if wanted == "extremes":
            states = load_extremes(self._contacts, self._solution.cycle)
            return sorted({*states, *solved[-1:]} & set(solved))
        return [state for state in (self._history.step(time) for time in wanted) if state in solved]


def _fronts(case: Case, solution: Solution) -> Tracks | None:
    """The fronts of all contacts of solids through the history; None in the plane."""
    if solution.dimension == 2:
        return None
    # Imported where it is needed: SciPy's interpolation takes a second.
    from fretfe.evaluate.space.fronts import follow_fronts

    found = {
        each.name: guarded(
            f"fronts of contact {each.name}",
            partial(follow_fronts, solution, each, case.edges.stations),
            lambda _: None,
        )
        for each in solution.contacts
    }
    return {name: tracks for name, tracks in found.items() if tracks is not None}


def _solution(model: Model, history: History, recorder: Recorder) -> tuple[Solution, Fault | None]:
    """The solution, in the plane with its patches; why these are not told, where fretfe fails."""
    solution = recorder.solution(history, balance(model.reduction, recorder.blocks()))
    return with_patches(solution) if model.dimension == 2 else (solution, None)


@dataclass(frozen=True)
class _Marched:
    """The accepted steps with their loads, and why there are not more of them."""

    recorder: Recorder
    history: History
    failure: ConvergenceError | None


def _march(prepared: Prepared, case: Case, history: History, options: RunOptions) -> _Marched:
    """Solve all steps; one that fails ends the history and keeps what was computed."""
    reduction, march = prepared.model.reduction, prepared.march
    cycles = AddedCycles(history, most_added(case, history, prepared.model.dimension))
    require_possible(case, reduction.definition, cycles.longest)
    beginning = read_beginning(case, history)
    places = [_place(prepared, pair) for pair in reduction.pairs]
    if beginning is not None:
        beginning.require_same(prepared.mesh.bodies, reduction.interface, places)
    steps = step_loads(case, cycles.longest, reduction, beginning)
    channels = [load.label for load in reduction.definition.loads]
    identity = {"mesh": prepared.digest, "values at points": reduction.definition.digest}
    storage = options.storage({**_compat.versions(), **identity})
    recorder = Recorder(march, places, steps, channels, case.model.degree, storage)
    if recorder.steps_done:
        until = next(end for end in cycles.ends if end >= recorder.steps_done)
        options.announce(f"continued after step {recorder.steps_done} of {until}")
    failure: ConvergenceError | None = None
    until_steady, last = case.cycle.until_steady, prepared.last
    like = last.recorder if last is not None else None
    if last is not None and last.until_steady == until_steady and not recorder.steps_done:
        recorder.begin_like(last.recorder, min(last.written, cycles.written))
    if beginning is not None and recorder.steps_done < beginning.last:
        known = beginning.states(reduction.interface, places)
        recorder.begin_with(each for each in known if each.step > recorder.steps_done)
    prepared.last = Marched(recorder, cycles.written, until_steady)
    try:
        for added, end in enumerate(cycles.ends):
            if recorder.steps_done <= end:
                progress = options.progress
                solve_history(march, recorder, steps[: end + 1], until_steady, progress, like)
                if _enough(cycles, added, recorder, options):
                    break
    except ConvergenceError as error:
        failure = error
        if not isinstance(error, StoppedError):
            done = recorder.steps_done
            hint = (
                opened(recorder.solution(cycles.solved(done), {}))
                or pulled_off(case, prepared.mesh, cycles.longest, done + 1)
                if recorder.contact_carries
                else _never_pressed(steps[done + 1])
            )
            failure = ConvergenceError(f"{error} {hint}") if hint else error
    else:
        _require_contact(case, recorder, prepared.model.dimension)
    return _Marched(recorder, cycles.solved(recorder.steps_done), failure)


def _enough(cycles: AddedCycles, added: int, recorder: Recorder, options: RunOptions) -> bool:
    """Tell whether no cycles follow so many added ones, and extrapolate slip if it is time."""
    if added + 1 == len(cycles.ends):
        return True
    if not cycles.extrapolated(added - 1) and _steady(recorder, cycles, options):
        return True
    if cycles.extrapolated(added):
        extrapolate_slip(recorder, cycles.period)
    return False


def _added_note(case: Case, written: History, solved: History) -> tuple[str, ...]:
    """Say how many cycles the loads as written have, how many were added, and which one counts."""
    steps = len(solved.times) - len(written.times)
    if written.cycle is None or solved.cycle is None or steps == 0:
        return ()
    (first, last), ends = written.cycle, solved.times[list(solved.cycle)]
    period = float(written.times[last] - written.times[first])
    pieces = (load.history[-1] for load in case.loads.values())
    waves = (piece.cycles * piece.period for piece in pieces if isinstance(piece, Wave))
    asked, added = max(waves) / period, steps / (last - first)
    evaluated = asked + (solved.cycle[1] - last) / (last - first)
    return (
        f"the loads of the case have {_cycles(asked)}. {_cycles(added)} like the last one "
        f"{'was' if added == 1 else 'were'} added, because the shear still changed from cycle to "
        f"cycle. The results are those of cycle {evaluated:.3g} of {asked + added:.3g}, from "
        f"t = {ends[0]:.6g} to {ends[1]:.6g} {case.units.time}",
    )


def _cycles(count: float) -> str:
    return f"{count:.3g} cycle{'' if count == 1 else 's'}"


def _steady(recorder: Recorder, cycles: AddedCycles, options: RunOptions) -> bool:
    """True if the last cycle is steady, or more of them would not make it so."""
    solution = recorder.solution(cycles.solved(recorder.steps_done), {})
    changes = [cycle_changes(solution, contact) for contact in solution.contacts]
    settled = all(work_settles(solution, contact) for contact in solution.contacts)
    if settled and not may_become_steady(changes):
        return True
    worst = float(np.fmax.reduce([each[0] for each in changes]))
    options.announce(f"not steady: shear changes by {worst:.2g} of its bound; more are solved")
    return False


def _place(prepared: Prepared, pair: Pair) -> Place:
    model, coupling, names = prepared.model, pair.coupling, (pair.name, pair.body1, pair.body2)
    surface = replace(
        coupling.surface,
        dundurs=coupled_beta(model.case, *names),
        growth=_growth(prepared.mesh, pair),
        layer=softest_layer(model.case, pair) * _modulus(model.case, pair)
        if pair.layer.any()
        else None,
    )
    return Place(*names, surface, coupling.averaging)


def _modulus(case: Case, pair: Pair) -> float:
    """E* of a contact."""
    bodies = case.bodies[pair.body1], case.bodies[pair.body2]
    return contact_modulus(*bodies, case.model.plane, pair.coupling.surface.mean_normal)


def _growth(mesh: Mesh, pair: Pair) -> float:
    """Growth of the elements of the bodies inward from a plane contact, the larger of both."""
    surface = pair.coupling.surface
    if surface.facets is not None:
        return 0.0
    sizes = np.gradient(surface.arc)
    bodies = (mesh.bodies[name] for name in (pair.body1, pair.body2))
    return max(growth_inward(body, surface.points, sizes) for body in bodies)


def _require_contact(case: Case, recorder: Recorder, dimension: int) -> None:
    """A history in which contact never carries anything is a mistake in the case."""
    if recorder.contact_carries:
        return
    loose = [name for name, load in case.loads.items() if load.loosens]
    adrift = recorder.bodies_restrained_by_contact
    weights = np.concatenate([each.surface.weights for each in recorder.places])
    reason = (
        f"nothing but contact holds {' and '.join(repr(name) for name in adrift)}, which gave way: "
        "support it, or press it against the other body with a force"
        if adrift and recorder.smallest_gap <= recorder.gap_round_off
        else f"the smallest gap on the way was {max(recorder.smallest_gap, 0.0):.6g}. "
        + untouched_hint(recorder.first_gap, recorder.smallest_gap, weights, dimension)
    )
    if loose:
        reason += (
            f". Across the tie of loads.{loose[0]} no force is carried but its own, which other "
            "loads find no way around: control its overlap"
        )
    raise ModelError(f"no contact surfaces pressed on each other in any step: {reason}.")


def _never_pressed(failed: StepLoads) -> str:
    """Hint for a history that ended in a step before any surfaces pressed on each other."""
    if not failed.friction.any():
        return (
            "No friction acts in this step: what would slide has to wait until 'friction_from' is "
            "over, or a support has to hold it."
        )
    return (
        "Until then no surfaces pressed on each other: press them together in the first step, "
        "before or with other loads, and check the signs of the loads."
    )
