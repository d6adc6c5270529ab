# SPDX-License-Identifier: LGPL-3.0-or-later
"""A run with a backend: its steps, and what it writes in its folder, in an order without mixtures.

Under MPI every process calls the same methods of `Runner` in the same order; those of `Work` are
serial, on the first process only. What draws, sweeps and validates is imported by the functions
that need it: a run starts without it.
"""

from __future__ import annotations

import json
import shutil
import signal
import time
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

from fretfe.backends import (
    Backend,
    Observer,
    OneProcess,
    Processes,
    RunOptions,
    find_backend,
    processes_of,
)
from fretfe.backends.protocol import DEFAULTS, SILENT, StopOnly
from fretfe.bodies.input_files import input_digests, input_files
from fretfe.case import Case, as_written, case_text
from fretfe.case.overrides import by_key
from fretfe.environment import memory_shortage, missing_package, versions
from fretfe.errors import (
    FaultError,
    FretfeError,
    MemoryShortError,
    ModelError,
    OutputError,
    StoppedError,
)
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
from fretfe.files import disk_reason, remove_unfinished, replace_text, stranger_in, sync_path
from fretfe.history.stream import STATES
from fretfe.results.field_files import FIELDS
from fretfe.results.hdf5_file import STRESSES
from fretfe.results.model import Result
from fretfe.results.reader import read_result
from fretfe.results.run_folder import FINISHED, KEY, LOCK, MARK, locked, read_mark, write_mark
from fretfe.results.writer import (
    NUMBERS,
    PICTURES,
    RESULT_FILES,
    SWEEP_FILES,
    prepare_directory,
    remove_pictures,
    remove_results,
    write_results,
)

if TYPE_CHECKING:
    from fretfe.mesh.mesh import Mesh
    from fretfe.quality.validation import Validation
    from fretfe.report.page.html import Plots
    from fretfe.sweeps import Solved, Sweep

CASE_COPY = "case.toml"
ROWS = "validation.json"
# Keys of a case that a run may be continued without: they change no state.
FREE_KEYS = ("title", "output")
# Packages whose versions must not change within a run; those of a backend stand with its states.
VERSIONS = ("fretfe",)
MOST_CHANGES = 5
# Names in a results folder under which a run removes or replaces what it finds.
TAKEN = {*RESULT_FILES, *SWEEP_FILES, CASE_COPY, LOCK, MARK, PICTURES, ROWS, STATES}
# Seconds between two notes of the last step: at least so many times what the last one took.
NOTE_SECONDS = 1.0
SPARING = 50.0


class Work:
    """A run in its folder, which `run_folder.locked` keeps others from.

    Args:
        directory: existing folder.
        command: "run", "sweep" or "validate".
        backend: its name.
        case: to be solved.
        varied: what a sweep varies.
        cases: that it solves; the one without these.

    Attributes:
        directory: of the run.
        known: the numbers that were found in it, on the process that has read them.
    """

    def __init__(
        self,
        directory: Path,
        command: str,
        backend: str,
        case: Case,
        varied: Mapping[str, Any] | None = None,
        cases: Sequence[Case] = (),
    ) -> None:
        self.directory = directory
        self.known: Result | None = None
        self._case = case
        self._cases = cases or (case,)
        # What tells the result that was written last from another one of this run.
        self._written: object = None
        self._begun = False
        self._mark: dict[str, Any] = {
            "doing": "starting",
            "complete": False,
            "step": 0,
            "steps": 0,
            "reason": "",
            "command": command,
            "backend": backend,
            "versions": {name: versions()[name] for name in VERSIONS},
            "varied": {key: list(map(str, values)) for key, values in (varied or {}).items()},
            "case": _plain(case),
        }

    def require_apart(self) -> None:
        """Check that nothing that the case reads would be removed, or written through.

        Raises:
            OutputError: if it would.
        """
        own = self.directory.resolve()
        inputs = {path: key for case in self._cases for path, key in input_files(case).items()}
        for path, key in inputs.items():
            if path.is_relative_to(own) and path.relative_to(own).parts[0] in TAKEN:
                raise OutputError(
                    f"{self.directory}: expected another folder than that with files of the case, "
                    f"found {path} ({key}), which the run would remove"
                )
        for name in (STATES, PICTURES):
            if (found := stranger_in(self.directory / name)) is not None:
                raise OutputError(
                    f"{found}: expected a file or a folder of a run, found a link or a pipe, "
                    "through which the run would write to another place"
                )

    def begin(self, *, resume: bool) -> bool:
        """Take the folder for this run; with `resume` go on with the one in it, if there is one.

        Returns:
            True if the run in it is complete.

        Raises:
            OutputError: if another case would be written over the case file, or the run in the
                folder is another one.
        """
        target = self.directory / CASE_COPY
        copied = target.resolve() == self._case.source.resolve()
        if copied and not as_written(self._case):
            raise OutputError(
                f"{self.directory}: expected another folder than that of the case file, found "
                f"{target}, which the case with other values would replace"
            )
        self.require_apart()
        digests = (input_digests(each).items() for each in self._cases)
        self._mark["inputs"] = dict(chain.from_iterable(digests))
        before = read_mark(self.directory) if resume else None
        if before is not None:
            self._require_same(before)
            if before["complete"] and before["doing"] == FINISHED:
                return True
            self._mark |= {"step": before.get("step", 0), "steps": before.get("steps", 0)}
        else:
            self._note("starting")
        try:
            remove_unfinished(self.directory)
            if before is None:
                self._clear()
            if not copied:
                replace_text(target, case_text(self._case))
        except OSError as error:
            raise self._cannot(error) from error
        self._note("solving")
        return False

    def _clear(self) -> None:
        """Remove what an earlier run has left."""
        remove_results(self.directory)
        remove_pictures(self.directory)
        for name in (ROWS, *SWEEP_FILES):
            (self.directory / name).unlink(missing_ok=True)
        self._remove_states()

    def _remove_states(self) -> None:
        states = self.directory / STATES
        if states.is_dir():
            shutil.rmtree(states)

    def _require_same(self, before: Mapping[str, Any]) -> None:
        try:
            changes = list(_changes(before, self._mark))
        except RecursionError:
            changes = [f"{MARK} has brackets in brackets"]
        if changes:
            more = f" and {len(changes) - MOST_CHANGES} more" if len(changes) > MOST_CHANGES else ""
            raise OutputError(
                f"{self.directory}: the run there cannot be continued, as it is another one: "
                f"{'; '.join(changes[:MOST_CHANGES])}{more}. Run the case without --resume"
            )

    def _note(self, doing: str, **more: Any) -> None:
        self._begun = True
        self._mark |= {"doing": doing, **more}
        write_mark(self.directory, self._mark)

    def step(self, number: int, count: int) -> None:
        """Note the last accepted step; the next one tells if that fails."""
        self._mark |= {"step": number, "steps": count}
        try:
            write_mark(self.directory, self._mark)
        except OutputError:
            return

    def numbers(self, result: Result) -> None:
        """Write the numbers of a result in place of those before, if they are not there."""
        this = result.notes, result.failure, result.refinement, result.faults
        if self._written == this:
            return
        self._note("writing results", step=len(result.loads.times) - 1)
        guarded(NUMBERS, partial(write_results, self.directory, result), self._unwritten)
        self._written = this
        self._note("solving")

    def _unwritten(self, fault: Fault) -> NoReturn:
        raise FaultError(
            f"{self.directory / NUMBERS}: not written: {fault.reason}. The steps that were solved "
            "are kept: the same command with --resume goes on from them"
        )

    def close(self, result: Result) -> None:
        """Write the numbers of the last result and say that it is all.

        States stay if a signal ended the run.
        """
        self.numbers(result)
        complete = result.failure is None
        self.finish(complete=complete, resumable=isinstance(result.failure, StoppedError))

    def read_known(self) -> Result | None:
        """Read what the run has written so far into `known`; for other processes, without arrays.

        None if it has not written all of its numbers.
        """
        try:
            self.known = read_result(self.directory)
        except OutputError:
            return None
        return replace(self.known, root_solution=None, bodies={})

    def finish(self, *, complete: bool, resumable: bool = False) -> None:
        """Say that all is written, once it is on the disk.

        States that a later run could go on from stay if it could.

        Args:
            complete: whether everything was solved.
            resumable: whether it would be worth while to go on.
        """
        try:
            for path in self.directory.iterdir():
                if path.is_file():
                    sync_path(path)
            self._note(FINISHED, complete=complete)
            if not resumable:
                self._remove_states()
        except OSError as error:
            raise self._cannot(error) from error

    def fail(self, reason: str) -> None:
        """Say why there are no results; on a full disk nothing can be said."""
        if not self._begun:
            return
        try:
            self._note("solving", reason=reason)
        except OutputError:
            return

    def fail_elsewhere(self, reason: str) -> None:
        """As `fail`, on a process of which the first one does not know that it has failed."""
        with suppress(OutputError):
            if (mark := read_mark(self.directory)) is not None:
                del mark[KEY]
                write_mark(self.directory, {**mark, "reason": reason})

    def _cannot(self, error: OSError) -> OutputError:
        return OutputError(f"{self.directory}: cannot be written: {disk_reason(error)}")


class StepNotes(Observer):
    """Passes everything on, and notes the last accepted step in the folder from time to time.

    Args:
        observer: to pass it on to.
        work: the run.
    """

    def __init__(self, observer: Observer, work: Work) -> None:
        self._observer = observer
        self._work = work
        self._next = 0.0

    def step(self, number: int, count: int, text: str) -> None:
        """Note a step."""
        begin = time.monotonic()
        if begin >= self._next:
            self._work.step(number, count)
            end = time.monotonic()
            self._next = end + max(NOTE_SECONDS, SPARING * (end - begin))
        self._observer.step(number, count, text)

    def phase(self, text: str) -> None:
        """Pass it on."""
        self._observer.phase(text)

    def announce(self, text: str) -> None:
        """Pass it on."""
        self._observer.announce(text)

    def doing(self, text: str) -> None:
        """Pass it on."""
        self._observer.doing(text)

    def stop(self) -> signal.Signals | None:
        """Ask the other one."""
        return self._observer.stop()


def _plain(case: Case) -> dict[str, Any]:
    """The case in plain types, the same from its own file and from the copy in the folder."""
    return tomllib.loads(case_text(case))


def _changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Differences of two runs that matter, in words."""
    for key in ("command", "backend", "versions", "varied", "case"):
        start = "" if key == "case" else key
        one, other = (by_key(each.get(key), start) for each in (before, now))
        for name in {**one, **other}:
            if name.split(".")[0] in FREE_KEYS or one.get(name) == other.get(name):
                continue
            yield f"{name} was {one.get(name, 'not given')}, is {other.get(name, 'not given')}"
    one, other = (dict(each.get("inputs", {})) for each in (before, now))
    for path in {**one, **other}:
        if one.get(path) != other.get(path):
            yield f"{path} has changed since it was read" if path in one else f"{path} is read too"


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
        return processes_of(self.backend)

    @property
    def idle(self) -> bool:
        """True on processes that a launcher has started beside a backend that runs on one."""
        return isinstance(self.processes, OneProcess) and self.processes.rank > 0

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
            ModelError: with all reasons why not.
        """
        supports = self.backend.supports
        self.processes.on_root(lambda: require_support(self.name, case, supports(case)))

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
            The result with its `failure`, if there is one, its `faults`, and the wall time of
            writing.

        Raises:
            FretfeError: for whatever keeps the history from being started.
        """
        with collecting(output) as collected:
            result = self._run(case, output, observer, resume, mesh)
            return replace(result, faults=self._all_faults(result, collected))

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
        with self._at_work(Work(output, "run", self.name, case), options.observer) as work:
            if self.processes.on_root(lambda: work.begin(resume=resume)):
                known = self._known(work)
                if known is not None:
                    return known
            options = self._stored(options, work, resume=resume)
            if case.output.fields != "none":
                options = replace(options, fields=output / FIELDS)
            options = replace(options, stress=output / STRESSES)
            result = self.backend.solve(case, options)
            begin = time.perf_counter()
            result = self._with_run(replace(result, backend=self.name, directory=output))
            result = replace(result, faults=faults_so_far())
            self.write(lambda: work.close(result))
        writing = time.perf_counter() - begin
        return replace(result, seconds={**result.seconds, "writing": writing})

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

    def sweep(
        self,
        case: Case,
        vary: Mapping[str, Sequence[Any]],
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
            found = replace(
                result, backend=self.name, directory=work.directory, faults=faults_so_far()
            )
            self.write(lambda: work.numbers(found))

        first = self.processes.rank == 0
        return replace(
            options,
            observer=StepNotes(options.observer, work) if first else options.observer,
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
        return None if self.idle else self.processes.on_root(work)

    def _shown(self, observer: Observer) -> Observer:
        return observer if self.processes.rank == 0 else StopOnly(observer)


def require_support(backend: str, case: Case, reasons: Sequence[str]) -> None:
    """Raise the reasons why a backend cannot solve a case, if there are any.

    Raises:
        ModelError: with all of them.
    """
    if reasons:
        raise ModelError(
            f"{case.source}: the backend {backend!r} cannot solve this case:\n"
            + "\n".join(f"  {reason}" for reason in reasons)
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


def draw_report(directory: Path) -> Drawn:
    """Draw the pictures of results and write their report; on the first process.

    What cannot be made takes nothing away from the results. Plots are drawn while other processes
    draw pictures, if cores are idle.
    """
    from fretfe.report.pictures.folder import make_pictures
    from fretfe.results.reader import load_result

    seconds: dict[str, float] = {}
    problems: list[str] = []
    failures: list[FretfeError] = []
    plots: list[Plots] = []

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

        plots.append(draw_plots(run))

    def draw_ahead(run: Result) -> None:
        attempt("report", partial(draw, run))

    with collecting(directory) as collected:
        try:
            with locked(directory):
                attempt("pictures", lambda: make_pictures(directory, draw_ahead))
                if "report" not in seconds:
                    attempt("report", lambda: draw(load_result(directory)))
                else:
                    seconds["pictures"] -= seconds["report"]
                if plots:
                    from fretfe.report.page.html import write_report

                    attempt("report", lambda: write_report(directory, plots[0]))
        except OutputError as error:
            failures.append(error)
    return Drawn(seconds, tuple(problems), tuple(collected.faults), next(iter(failures), None))
