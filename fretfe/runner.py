# SPDX-License-Identifier: LGPL-3.0-or-later
"""A backend, and what every run with it does before and after it solves.

Under MPI every process calls the same methods in the same order. What draws, sweeps and validates
is imported by the functions that need it: a run starts without it.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from fretfe.backends import (
    Backend,
    Observer,
    OneProcess,
    Processes,
    RunOptions,
    find_backend,
    processes_of,
)
from fretfe.backends.observer import SILENT
from fretfe.case import Case, as_written, case_text, load_case, parse_assignments
from fretfe.errors import FretfeError, ModelError, OutputError
from fretfe.results.field_file import FIELDS
from fretfe.results.model import Result
from fretfe.results.stream import STREAM
from fretfe.results.writer import (
    REPORT,
    prepare_directory,
    remove_fields,
    remove_pictures,
    write_results,
)

if TYPE_CHECKING:
    from fretfe.quality.validate import Validation
    from fretfe.report.page.sections import Plots
    from fretfe.sweeps import Sweep

T = TypeVar("T")
CASE_COPY, ROWS = "case.toml", "validation.json"


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

    def read_case(self, path: Path, overrides: Sequence[str] = (), *, trust_geo: bool) -> Case:
        """Read a case file on the first process, for all.

        Args:
            path: of the case file.
            overrides: values in place of its own, like ``loads.shear.amplitude=120``.
            trust_geo: whether a .geo file of the case may run.

        Raises:
            CaseError: if the case is not valid.
        """
        return self.processes.on_root(
            lambda: load_case(path, parse_assignments(overrides), trust_geo=trust_geo)
        )

    def require_support(self, case: Case) -> None:
        """Check that the backend can solve a case.

        Raises:
            ModelError: with all reasons why not.
        """
        supports = self.backend.supports
        self.processes.on_root(lambda: require_support(self.name, case, supports(case)))

    def run(self, case: Case, output: Path | None = None, observer: Observer = SILENT) -> Result:
        """Solve a case and write its numbers, but no report.

        Args:
            case: to be solved.
            output: folder for the files; None writes nothing.
            observer: follows the run.

        Returns:
            The result with its `failure`, if there is one, and the wall time of writing.

        Raises:
            FretfeError: for whatever keeps the history from being started.
        """
        self.require_support(case)
        options = RunOptions(observer=self._shown(observer), states=output)
        if output is None:
            return replace(self.backend.solve(case, options), backend=self.name)
        self.write(lambda: _prepare_folder(output, case))
        if case.output.fields != "none":
            options = replace(options, fields=output / FIELDS)
        try:
            result = replace(self.backend.solve(case, options), backend=self.name, directory=output)
        except FretfeError:
            # There are no results that its states would belong to.
            (output / STREAM).unlink(missing_ok=True)
            raise
        begin = time.perf_counter()
        self.write(lambda: _write_numbers(output, result))
        return replace(result, seconds={**result.seconds, "writing": time.perf_counter() - begin})

    def sweep(
        self,
        case: Case,
        vary: Mapping[str, Sequence[Any]],
        output: Path | None = None,
        observer: Observer = SILENT,
    ) -> Sweep:
        """Solve all combinations of values; write table and picture.

        Args:
            case: with all that does not vary.
            vary: values by key.
            output: folder for the files; None writes nothing.
            observer: follows the runs; each case is announced when it is done.

        Raises:
            FretfeError: before any work, if a combination is not a valid case.
        """
        from fretfe.sweeps import make_variants, run_sweep
        from fretfe.sweeps.files import write_files

        variants = self.processes.on_root(lambda: make_variants(case, vary))
        if output is not None:
            self.write(lambda: _write_case(output, case))
        sweep = run_sweep(variants, self.backend, RunOptions(observer=self._shown(observer)))
        if output is not None:
            self.write(lambda: write_files(sweep, output))
        return sweep

    def validate(
        self, case: Case, output: Path | None = None, observer: Observer = SILENT
    ) -> Validation:
        """Run a case and its companions; write the results of the case, and the rows.

        Args:
            case: to be validated.
            output: folder for the files; None writes nothing.
            observer: follows the runs; each is a phase.

        Raises:
            FretfeError: if the case itself cannot be solved.
        """
        from fretfe.quality.validate import validate

        self.require_support(case)
        if output is not None:
            self.write(lambda: prepare_directory(output))
        found = validate(case, self.backend, RunOptions(observer=self._shown(observer)))
        if output is None:
            return replace(found, result=replace(found.result, backend=self.name))
        result = replace(found.result, backend=self.name, directory=output)
        validation = replace(found, result=result)
        self.write(lambda: _write_validation(output, validation))
        return validation

    def write(self, work: Callable[[], T]) -> T | None:
        """Do `work` on the first process; a backend that runs on one runs on each of them."""
        return None if self.idle else self.processes.on_root(work)

    def _shown(self, observer: Observer) -> Observer:
        return observer if self.processes.rank == 0 else SILENT


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


def _prepare_folder(directory: Path, case: Case) -> None:
    """Make the folder for results, without pictures and fields of an earlier run.

    Raises:
        OutputError: as for `_write_case`.
    """
    _write_case(directory, case)
    # They would not belong to these results.
    remove_pictures(directory)
    remove_fields(directory)


def _write_case(directory: Path, case: Case) -> None:
    """Write the case as it is run into a folder, so that it can be run again; make the folder.

    Raises:
        OutputError: if that is not possible, or another case would be written over the case file.
    """
    prepare_directory(directory)
    target = directory / CASE_COPY
    if target.resolve() != case.source.resolve():
        target.write_text(case_text(case), encoding="utf-8")
    elif not as_written(case):
        raise OutputError(
            f"{directory}: expected another folder than that of the case file, found {target}, "
            "which the case with other values would replace"
        )


def _write_numbers(directory: Path, result: Result) -> None:
    # A report of an earlier run would not belong to these results.
    (directory / REPORT).unlink(missing_ok=True)
    write_results(directory, result)


def _write_validation(directory: Path, validation: Validation) -> None:
    from fretfe.quality.validate.report import as_numbers

    write_results(directory, validation.result)
    text = json.dumps(as_numbers(validation), indent=1, allow_nan=False)
    (directory / ROWS).write_text(text + "\n", encoding="utf-8")


@dataclass(frozen=True)
class Drawn:
    """Outcome of drawing a report.

    Attributes:
        seconds: wall time of each phase.
        problems: what is missing and why, in words.
    """

    seconds: dict[str, float]
    problems: tuple[str, ...]


def draw_report(directory: Path) -> Drawn:
    """Draw the pictures of results and write their report; on the first process.

    What cannot be made takes nothing away from the results. Plots are drawn while other processes
    draw pictures, if cores are idle.
    """
    from fretfe.report.page.html import write_report
    from fretfe.report.page.sections import draw_plots
    from fretfe.report.pictures.folder import make_pictures
    from fretfe.results.reader import load_result

    seconds: dict[str, float] = {}
    problems: list[str] = []
    plots: list[Plots] = []

    def attempt(phase: str, make: Callable[[], object]) -> None:
        begin = time.perf_counter()
        try:
            make()
        except Exception as error:
            problems.append(f"no {phase}: {type(error).__name__}: {error}")
        seconds[phase] = seconds.get(phase, 0.0) + time.perf_counter() - begin

    def draw_ahead() -> None:
        attempt("report", lambda: plots.append(draw_plots(load_result(directory))))

    attempt("pictures", lambda: make_pictures(directory, draw_ahead))
    if "report" not in seconds:
        draw_ahead()
    else:
        seconds["pictures"] -= seconds["report"]
    if plots:
        attempt("report", lambda: write_report(directory, plots[0]))
    return Drawn(seconds, tuple(problems))
