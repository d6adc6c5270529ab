# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs, sweeps and validations with a backend: what happens in which order, and on which process.

Under MPI every process calls the same methods of `Runner` in the same order; those of
`fretfe.work.Work` are serial, on the first process only. What draws, sweeps and validates is
imported by the functions that need it: a run starts without it.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from fretfe._typing import Array
from fretfe.backends import Backend, Observer, Processes, RunOptions, find_backend
from fretfe.backends.protocol import DEFAULTS, SILENT, StopOnly
from fretfe.case import Case, stiffness_doubts
from fretfe.environment import few_threads, memory_shortage, missing_package
from fretfe.errors import CaseError, FretfeError, MemoryShortError, OutputError
from fretfe.faults import (
    Collected,
    Fault,
    collecting,
    faults_so_far,
    guarded,
    said,
    trace_of,
    write_traceback,
)
from fretfe.files import replace_text, writing
from fretfe.history.stream import STATES
from fretfe.results.field_files import FIELDS
from fretfe.results.hdf5_file import STRESSES
from fretfe.results.model import Result
from fretfe.results.run_folder import locked
from fretfe.results.writer import ENDS, prepare_directory, remove_old_report
from fretfe.work import ROWS, RUN, StepNotes, Work

if TYPE_CHECKING:
    from fretfe.exchange.submodel import Submodel
    from fretfe.mesh.mesh import Mesh
    from fretfe.quality.validation import Validation
    from fretfe.report.page.html import Sections
    from fretfe.results.end_answers import EndAnswer
    from fretfe.results.front_ends import FrontEnd
    from fretfe.sweeps import Solved, Sweep

T = TypeVar("T")


@dataclass(frozen=True)
class Runner:
    """Runs cases with one backend.

    Attributes:
        name: of the backend.
        backend: that solves the cases.
    """

    name: str
    backend: Backend

    @classmethod
    def find(cls, name: str) -> Runner:
        """Return the runner of an installed backend.

        Raises:
            CaseError: if no backend of this name is installed.
            DependencyError: if it cannot be used.
        """
        return cls(name, find_backend(name))

    @property
    def processes(self) -> Processes:
        """The processes that take part."""
        return self.backend.processes

    def read_case(self, read: Callable[[], Case]) -> Case:
        """Read a case on the first process, for all.

        Args:
            read: reads it, as `load_case`.

        Raises:
            CaseError: if the case is not valid.
        """
        return self.processes.on_root(read)

    def require_support(self, case: Case) -> None:
        """Check that the backend can solve a case.

        Raises:
            CaseError: with all reasons why not.
            ModelError: if these are of the model.
        """
        self.processes.on_root(lambda: require_support(self.name, self.backend, case))

    @few_threads()
    def run(
        self,
        case: Case,
        output: Path | None = None,
        observer: Observer = SILENT,
        *,
        resume: bool = False,
        mesh: Callable[[Case], Mesh] | None = None,
    ) -> Result:
        """Solve a case and write its numbers, but no report.

        Args:
            case: to be solved.
            output: folder for the files; None writes nothing.
            observer: follows the run.
            resume: whether to go on with the run of this case in the folder, if there is one.
            mesh: gives the mesh of the case on the first process, if it is there already.

        Returns:
            The result with its `failure`, if any, its `faults`, and the wall time of writing.

        Raises:
            FretfeError: for whatever keeps the history from being started.
        """
        output = None if self.processes.idle else output  # process 0 has the folder
        with collecting(output) as collected:
            result = self._run(case, output, observer, resume, mesh)
            result = replace(result, faults=self._all_faults(result, collected))
        if case.edges.ends and output is not None and result.failure is None:
            try:
                self._solve_worst_end(output, observer)
            except FretfeError as error:  # the numbers of the run stay
                result = replace(result, notes=(*result.notes, f"No numbers at an end: {error}"))
        return result

    def _solve_worst_end(self, directory: Path, observer: Observer) -> None:
        """Solve parts around the worst free end of a run, unless that was done before."""
        from fretfe.exchange.submodel import write_submodel
        from fretfe.results.end_answers import read_answers
        from fretfe.results.front_ends import worst_end
        from fretfe.results.reader import load_result

        def wanted() -> str:
            run = load_result(directory)
            end = worst_end(run)
            return "" if end is None or read_answers(run) else end.name

        name = self.processes.on_root(wanted)
        if name:
            folder = directory / ENDS / name
            self.solve_end(directory, lambda run: write_submodel(run, name, folder), None, observer)

    def _run(
        self,
        case: Case,
        output: Path | None,
        observer: Observer,
        resume: bool,
        mesh: Callable[[Case], Mesh] | None,
    ) -> Result:
        """As `run`; the faults are those of the result so far."""
        self.require_support(case)
        options = RunOptions(observer=self._shown(observer), mesh=mesh)
        if output is None:
            return self._with_run(replace(self.backend.solve(case, options), backend=self.name))
        with self._at_work(Work(output, RUN, self.name, case), options.observer) as work:
            if self.processes.on_root(lambda: work.begin(resume=resume)):
                known = self._known(work)
                if known is not None:
                    return known
            options = self._stored(options, work, resume=resume)
            if case.output.fields != "none" or case.edges.ends:
                options = replace(options, fields=output / FIELDS)
            options = replace(options, stress=output / STRESSES)
            result = self.backend.solve(case, options)
            begin = time.perf_counter()
            result = self._with_run(replace(result, backend=self.name, directory=output))
            result = replace(result, faults=faults_so_far())
            self.write(lambda: work.close(result))
        seconds = {**result.seconds, "writing": time.perf_counter() - begin}
        return replace(result, seconds=seconds)

    def _all_faults(self, result: Result, collected: Collected) -> tuple[Fault, ...]:
        """The faults of a result that was read or made, the same on all processes. Collective."""
        known = (*result.faults, *collected.faults)
        return self.processes.on_root(lambda: tuple(dict.fromkeys(known)))

    def _with_run(self, result: Result) -> Result:
        """A result with notes that compare it with another run, whose displacements move cuts."""
        if not result.case.cut_loads:
            return result

        def notes() -> tuple[str, ...]:
            from fretfe.quality.global_run import carried_notes, followed_notes, traction_notes

            return (*carried_notes(result), *traction_notes(result), *followed_notes(result))

        def attempted() -> tuple[str, ...]:
            return guarded("comparison with the other run", notes, lambda fault: (fault.text,))

        return replace(result, notes=(*result.notes, *self.processes.on_root(attempted)))

    @few_threads()
    def sweep(
        self,
        case: Case,
        vary: Mapping[str, Sequence[Any] | Array],
        output: Path | None = None,
        observer: Observer = SILENT,
        *,
        resume: bool = False,
    ) -> Sweep:
        """Solve all combinations of values; write table and picture.

        Args:
            case: with all that does not vary.
            vary: values by key.
            output: folder for the files; None writes nothing.
            observer: follows the runs; each case is announced when it is done.
            resume: whether to go on with the sweep of these values in the folder, if there is one.

        Raises:
            FretfeError: before any work, if a combination is not a valid case.
        """
        from fretfe.sweeps import make_variants, run_sweep
        from fretfe.sweeps.table import SolvedFile, write_files

        variants = self.processes.on_root(lambda: make_variants(case, vary))
        options = RunOptions(observer=self._shown(observer))
        if output is None:
            with collecting():
                return run_sweep(variants, self.backend, options)
        cases = [variant.case for variant in variants]
        work = Work(output, "sweep", self.name, case, vary, cases)
        with self._at_work(work, options.observer), collecting(output):
            self.write(lambda: work.begin(resume=resume))
            options = replace(self._stored(options, work, resume=resume), keep=DEFAULTS.keep)
            file = SolvedFile(output)
            known = self.processes.on_root(lambda: file.read(variants) if resume else {})

            def note(number: int, solved: Solved) -> None:
                self.write(lambda: file.add(number, solved))

            sweep = run_sweep(variants, self.backend, options, known, note)
            drawn = self.write(lambda: (write_files(sweep, output), faults_so_far())) or (False, ())
            sweep = replace(sweep, late_faults=drawn[1])
            stopped = sweep.stopped is not None
            self.write(lambda: work.finish(complete=not stopped, resumable=stopped))
        return sweep

    @few_threads()
    def validate(
        self,
        case: Case,
        output: Path | None = None,
        observer: Observer = SILENT,
        *,
        resume: bool = False,
    ) -> Validation:
        """Run a case and its companions; write the results of the case, and the rows.

        Args:
            case: to be validated.
            output: folder for the files; None writes nothing.
            observer: follows the runs; each is a phase.
            resume: whether to go on with the validation in the folder, if there is one.

        Raises:
            FretfeError: if the case itself cannot be solved.
        """
        with collecting(output) as collected:
            found = self._validate(case, output, observer, resume)
            faults = self._all_faults(found.result, collected)
            return replace(found, result=replace(found.result, faults=faults))

    def _validate(
        self, case: Case, output: Path | None, observer: Observer, resume: bool
    ) -> Validation:
        """As `validate`; the faults are those of the result so far."""
        from fretfe.quality.validation import validate

        self.require_support(case)
        options = RunOptions(observer=self._shown(observer))
        if output is None:
            found = validate(case, self.backend, options)
            return replace(found, result=replace(found.result, backend=self.name))
        with self._at_work(Work(output, "validate", self.name, case), options.observer) as work:
            self.write(lambda: work.begin(resume=resume))
            found = validate(case, self.backend, self._stored(options, work, resume=resume))
            faults = faults_so_far()
            result = replace(found.result, backend=self.name, directory=output, faults=faults)
            validation = replace(found, result=result)
            self.write(lambda: _write_rows(output, validation))
            self.write(lambda: work.close(result))
        return validation

    def solve_end(
        self,
        directory: Path,
        write: Callable[[Result], Submodel],
        length: float | None = None,
        observer: Observer = SILENT,
    ) -> EndAnswer:
        """Solve two parts around a free end beside their cases, and write the answer there.

        Args:
            directory: of the run.
            write: the cases; on the first process.
            length: of the front next to the end, as for `end_answer`.
            observer: follows the runs.

        Raises:
            FretfeError: if the part is around something else, or one cannot be solved.
        """
        from fretfe.quality.ends import end_answer, write_answer
        from fretfe.results.reader import load_result

        known: list[tuple[Result, FrontEnd]] = []

        def cases() -> tuple[Case, ...]:
            run = load_result(directory)
            found = write(run)
            if found.end is None:
                raise CaseError("--run: expected a free end of a front (--around)")
            known.append((run, found.end))
            return found.cases

        solved = []
        for case in self.processes.on_root(cases):
            solved.append(self.run(case, case.source.with_suffix(""), observer))
            if (failure := solved[-1].failure) is not None:
                raise failure
        fine, coarse = solved

        def answer() -> EndAnswer:
            run, end = known[0]
            found = end_answer(run, end.name, fine, coarse, length)
            write_answer(run, found, fine.case.source.parent)
            return found

        return self.processes.on_root(answer)

    @contextmanager
    def _at_work(self, work: Work, observer: Observer) -> Iterator[Work]:
        """Keep the folder of a run from others; note in it why a run failed.

        Raises:
            OutputError: if another process is at work there.
        """
        held = ExitStack()

        def take() -> None:
            prepare_directory(work.directory)
            held.enter_context(locked(work.directory, observer.announce))

        with held:
            self.write(take)
            try:
                yield work
            except FretfeError as error:
                if self.processes.rank == 0:
                    work.fail(str(error))
                raise
            except Exception as error:
                reason = f"fretfe itself failed ({said(error)})"
                if self.processes.rank > 0:
                    work.fail_elsewhere(reason)
                else:
                    work.fail(reason)
                    write_traceback(work.directory, "run", trace_of(error))
                raise

    def _stored(self, options: RunOptions, work: Work, *, resume: bool) -> RunOptions:
        """Options with which a run keeps what it has solved in its folder."""

        def keep(result: Result) -> None:
            found = replace(result, backend=self.name, directory=work.directory)
            self.write(lambda: work.numbers(replace(found, faults=faults_so_far())))

        return replace(
            options,
            observer=options.observer if self.processes.rank else StepNotes(options.observer, work),
            states=work.directory / STATES,
            resume=resume,
            before=self._known(work) if resume else None,
            keep=keep,
        )

    def _known(self, work: Work) -> Result | None:
        """The numbers in a folder; on other processes than the first without arrays."""
        shared = self.processes.on_root(work.read_known)
        return work.known or shared

    def write(self, work: Callable[[], T]) -> T | None:
        """Do `work` on the first process; a backend that runs on one runs on each of them."""
        return None if self.processes.idle else self.processes.on_root(work)

    def _shown(self, observer: Observer) -> Observer:
        return observer if self.processes.rank == 0 else StopOnly(observer)


def require_support(name: str, backend: Backend, case: Case) -> None:
    """Raise the reasons why a backend cannot solve a case, if there are any.

    Raises:
        FretfeError: with all of them, first constants in another unit, which may be behind them.
    """
    if reasons := backend.supports(case):
        raise backend.refusal(case)(
            f"{case.source}: the backend {name!r} cannot solve this case:\n"
            + "\n".join(f"  {reason}" for reason in (*stiffness_doubts(case), *reasons))
        )


def _write_rows(directory: Path, validation: Validation) -> None:
    from fretfe.quality.validation import as_numbers

    text = json.dumps(as_numbers(validation), indent=1, allow_nan=False)
    replace_text(directory / ROWS, text + "\n")


@dataclass(frozen=True)
class Drawn:
    """Outcome of drawing a report.

    Attributes:
        seconds: wall time of each phase.
        problems: what is missing and why, in words.
        faults: errors of fretfe itself among the reasons.
        failure: the first reason that lies with files or memory, which is none of the problems.
    """

    seconds: dict[str, float]
    problems: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()
    failure: FretfeError | None = None


def draw_report(directory: Path, say: Callable[[str], None] = lambda _: None) -> Drawn:
    """Draw the pictures of results and write their report; on the first process.

    What cannot be made takes nothing away from the results. Plots are drawn while other processes
    draw pictures, if cores are idle.

    Args:
        directory: results folder.
        say: what is being drawn.
    """
    from fretfe.report.pictures.folder import make_pictures
    from fretfe.results.reader import load_result

    seconds: dict[str, float] = {}
    problems: list[str] = []
    failures: list[FretfeError] = []
    plots: list[Sections] = []

    def attempt(phase: str, make: Callable[[], object]) -> None:
        begin = time.perf_counter()
        try:
            guarded(phase, make, lambda fault: problems.append(fault.text))
        except FretfeError as error:
            failures.append(error)
        except Exception as error:
            if reason := memory_shortage(error):
                failures.append(MemoryShortError(reason))
            else:
                problems.append(f"no {phase}: {missing_package(error)}")
        seconds[phase] = seconds.get(phase, 0.0) + time.perf_counter() - begin

    def draw(run: Result) -> None:
        # Imported while other processes draw.
        from fretfe.report.page.html import draw_plots

        say("figures of the report")
        plots.append(draw_plots(run))

    def draw_ahead(run: Result) -> None:
        attempt("report", partial(draw, run))

    with collecting(directory) as collected:
        try:
            with locked(directory):
                attempt("pictures", lambda: make_pictures(directory, draw_ahead, say))
                if "report" not in seconds:
                    attempt("report", lambda: draw(load_result(directory)))
                else:
                    seconds["pictures"] -= seconds["report"]
                if plots:
                    from fretfe.report.page.html import write_report

                    attempt("report", lambda: write_report(directory, plots[0]))
                with writing(directory, "the report"):
                    remove_old_report(directory)
        except OutputError as error:
            failures.append(error)
    return Drawn(seconds, tuple(problems), tuple(collected.faults), next(iter(failures), None))
