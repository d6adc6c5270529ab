# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the commands of the command line do that any backend can serve; rank 0 prints."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeRemainingColumn,
)

from fretfe.backends import (
    Backend,
    EdgeHistories,
    Installed,
    ParallelBackend,
    Processes,
    RunOptions,
    backend_names,
    find_backend,
    installed_backends,
)
from fretfe.case import Case, load_case
from fretfe.environment import rank_from_environment
from fretfe.errors import CaseError, ModelError
from fretfe.report.page import REPORT, write_report
from fretfe.report.tables import (
    backend_table,
    contact_table,
    edge_table,
    limit_table,
    mesh_table,
    timing_table,
)
from fretfe.results import prepare_directory, write_results
from fretfe.solution import Solution
from fretfe.verify.benchmarks import benchmarks
from fretfe.verify.controls import controls
from fretfe.verify.model import Row, failed
from fretfe.verify.report import as_numbers, print_rows, print_summary
from fretfe.verify.run import run_benchmark

T = TypeVar("T")
FIELDS, CASE_COPY = "fields", "case.toml"


class OneProcess:
    """A backend that runs on one process; others that a launcher started have nothing to do."""

    @property
    def rank(self) -> int:
        """Number of this process, as the launcher announces it."""
        return rank_from_environment()

    def on_root(self, work: Callable[[], T]) -> T | None:
        """Do `work`."""
        return work()


def run_case(path: Path, directory: Path, name: str, *, timings: bool, report: bool) -> None:
    """Solve a case, write everything, print the edges. Collective if the backend is parallel."""
    start = time.perf_counter()
    backend = find_backend(name)
    processes = processes_of(backend)
    if isinstance(processes, OneProcess) and processes.rank > 0:
        return
    case = processes.on_root(lambda: load_case(path))
    assert case is not None
    processes.on_root(lambda: require_supported(backend, name, case))
    fields = None if case.output.fields == "none" else directory / FIELDS
    processes.on_root(lambda: _prepare(directory, path))
    with StepReport(processes.rank) as shown:
        result = backend.solve(
            case, RunOptions(fields=fields, progress=shown.step, announce=shown.announce)
        )
    processes.on_root(lambda: _finish(case, name, result, directory, start, timings, report))
    if result.failure is not None:
        raise result.failure


def processes_of(backend: Backend | None) -> Processes:
    """The processes that a backend runs on."""
    return backend.processes if isinstance(backend, ParallelBackend) else OneProcess()


def require_supported(backend: Backend, name: str, case: Case) -> None:
    """Check that a backend can solve a case.

    Raises:
        ModelError: with all reasons why not.
    """
    reasons = backend.supports(case)
    if reasons:
        raise ModelError(
            f"{case.source}: the backend {name!r} cannot solve this case:\n"
            + "\n".join(f"  {reason}" for reason in reasons)
        )


def _prepare(directory: Path, case_file: Path) -> None:
    prepare_directory(directory)
    target = directory / CASE_COPY
    if target.resolve() != case_file.resolve():
        shutil.copyfile(case_file, target)


def _finish(
    case: Case,
    backend: str,
    result: EdgeHistories,
    directory: Path,
    start: float,
    timings: bool,
    report: bool,
) -> None:
    """Write and print; on rank 0."""
    begin = time.perf_counter()
    # A report of an earlier run would not belong to these results.
    (directory / REPORT).unlink(missing_ok=True)
    write_results(directory, case, backend, result)
    failure = _make_report(directory) if report else ""
    writing = time.perf_counter() - begin
    console = Console()
    console.print(contact_table(case, result.history.cycle, result.contacts))
    console.print(edge_table(case, result.contacts))
    if result.refinement is not None:
        console.print(mesh_table(result.refinement))
        console.print(limit_table(result.refinement))
    _print_remarks(console, result)
    if failure:
        console.print(f"Warning: no report: {failure}", highlight=False, markup=False)
    if timings:
        console.print(timing_table({**result.seconds, "writing": writing}))
    steps = _step_text(result.solution)
    text = f"{len(result.history.times) - 1} steps{steps}, {time.perf_counter() - start:.1f} s"
    console.print(text, highlight=False)
    console.print(f"Results in {directory}", highlight=False, soft_wrap=True)


def _make_report(directory: Path) -> str:
    """Make the report; why there is none, or nothing. The results are there in any case."""
    try:
        write_report(directory)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def _step_text(solution: Solution | None) -> str:
    if solution is None:
        return ""
    return (
        f", {solution.iterations[1:].mean():.1f} iterations a step, largest violation of a contact "
        f"condition {solution.certificates['worst'].max():.1e}"
    )


def _print_remarks(console: Console, result: EdgeHistories) -> None:
    refinement = result.refinement
    if refinement is not None and not refinement.converged:
        text = f"Warning: the mesh is not fine enough for edges.tolerance: {refinement.reason}"
        console.print(text, highlight=False, markup=False)
    for note in result.notes:
        console.print(f"Note: {note}", highlight=False, markup=False)
    for contact in result.contacts:
        for warning in contact.warnings:
            console.print(f"Warning: {contact.name}: {warning}", highlight=False, markup=False)


class StepReport:
    """Progress on rank 0: a bar on a terminal, otherwise a line per step, or nothing if quiet."""

    def __init__(self, rank: int, *, quiet: bool = False) -> None:
        self._quiet = quiet
        console = Console(stderr=True)
        self._bar: Progress | None = None
        self._task: TaskID | None = None
        if console.is_terminal and rank == 0:
            columns = (
                TextColumn("steps"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
            )
            self._bar = Progress(*columns, console=console, transient=True)

    def __enter__(self) -> StepReport:
        """Show the bar."""
        if self._bar is not None:
            self._bar.start()
            self._task = self._bar.add_task("steps", total=None)
        return self

    def __exit__(self, *_: object) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()

    def step(self, number: int, count: int, text: str) -> None:
        """Report an accepted step."""
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=number, total=count)
            return
        if not self._quiet:
            print(f"step {number}/{count}: {text}", flush=True)

    def announce(self, text: str) -> None:
        """Say what begins or has ended."""
        if self._bar is not None:
            self._bar.console.print(text, highlight=False, markup=False)
        elif not self._quiet:
            print(text, flush=True)


def show_backends(path: Path | None) -> None:
    """List the installed backends and why one cannot be used, or cannot solve a case."""
    # On every rank: a backend that starts MPI when it is imported waits for the others.
    backends = installed_backends()
    if rank_from_environment() > 0:
        return
    case = load_case(path) if path is not None else None
    Console().print(backend_table(backends, case))


def verify_backends(names: Sequence[str], *, as_json: bool) -> bool:
    """Run all benchmarks and negative controls, print the comparisons, and say whether all is well.

    Collective if one of the backends is parallel.

    Args:
        names: of the backends; empty for all that are installed.
        as_json: print one JSON document at the end in place of tables.

    Raises:
        CaseError: if no backend of one of these names is installed.
    """
    chosen = _choose(names)
    rows: list[Row] = []
    seconds = {installed.name: 0.0 for installed in chosen}
    shown = OneProcess().rank == 0 and not as_json
    console, status = Console(quiet=not shown), Console(stderr=True, quiet=not shown)
    for benchmark in (*benchmarks(), *controls()):
        found: list[Row] = []
        for installed in chosen:
            processes = processes_of(installed.backend)
            if isinstance(processes, OneProcess) and processes.rank > 0:
                continue
            start = time.perf_counter()
            with status.status(f"{benchmark.name}: {installed.name}"):
                found += run_benchmark(benchmark, installed, processes)
            seconds[installed.name] += time.perf_counter() - start
        print_rows(console, benchmark, found)
        rows += found
    print_summary(console, rows, seconds)
    if as_json and OneProcess().rank == 0:
        print(json.dumps(as_numbers(rows, seconds), indent=1, allow_nan=False), flush=True)
    return _agree(chosen, not failed(tuple(rows)))


def _choose(names: Sequence[str]) -> tuple[Installed, ...]:
    unknown = sorted(set(names) - set(backend_names()))
    if unknown:
        raise CaseError(
            f"expected names of installed backends ({', '.join(backend_names())}), found "
            + ", ".join(repr(name) for name in unknown)
        )
    return tuple(each for each in installed_backends() if not names or each.name in names)


def _agree(chosen: Sequence[Installed], passed: bool) -> bool:
    """What rank 0 found, on all processes: the others have not run every backend."""
    for installed in chosen:
        if isinstance(installed.backend, ParallelBackend):
            return bool(processes_of(installed.backend).on_root(lambda: passed))
    return passed or OneProcess().rank > 0
