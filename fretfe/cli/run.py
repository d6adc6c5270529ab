# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the commands of the command line do that any backend can serve; rank 0 prints."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from fretfe.backends import (
    EdgeHistories,
    Installed,
    ParallelBackend,
    RunOptions,
    backend_names,
    find_backend,
    installed_backends,
)
from fretfe.case import Case, load_case
from fretfe.cli.progress import StepReport
from fretfe.cli.verbosity import Verbosity
from fretfe.environment import rank_from_environment
from fretfe.errors import CaseError
from fretfe.quality.verify.benchmarks import benchmarks
from fretfe.quality.verify.controls import controls
from fretfe.quality.verify.model import Row, failed
from fretfe.quality.verify.report import as_numbers, print_rows, print_summary
from fretfe.quality.verify.run import run_benchmark
from fretfe.report.tables import (
    backend_table,
    contact_table,
    edge_table,
    limit_table,
    mesh_table,
    timing_table,
)
from fretfe.results.solution import Solution
from fretfe.results.writer import FIELDS
from fretfe.runner import (
    OneProcess,
    draw_report,
    prepare_folder,
    processes_of,
    read_case,
    require_supported,
    write_numbers,
)


def run_case(
    path: Path,
    directory: Path,
    name: str,
    overrides: Sequence[str] = (),
    verbosity: Verbosity = Verbosity.NORMAL,
    *,
    timings: bool = False,
    report: bool = True,
    trust_geo: bool = False,
) -> None:
    """Solve a case, write everything, print the edges. Collective if the backend is parallel.

    Args:
        path: of the case file.
        directory: for the results.
        name: of the backend.
        overrides: values in place of those of the file, like ``loads.shear.amplitude=120``.
        verbosity: how much is printed.
        timings: whether the wall time of each phase is, too; it always is if verbose.
        report: whether report.html is made, with its pictures.
        trust_geo: whether a .geo file of the case may run.
    """
    start = time.perf_counter()
    backend = find_backend(name)
    processes = processes_of(backend)
    if isinstance(processes, OneProcess) and processes.rank > 0:
        return
    case = processes.on_root(lambda: read_case(path, overrides, trust_geo=trust_geo))
    assert case is not None
    processes.on_root(lambda: require_supported(backend, name, case))
    fields = None if case.output.fields == "none" else directory / FIELDS
    processes.on_root(lambda: prepare_folder(directory, case))
    with StepReport(processes.rank, verbosity) as shown:
        result = backend.solve(
            case, RunOptions(fields=fields, progress=shown.step, announce=shown.announce)
        )
    processes.on_root(
        lambda: _finish(case, name, result, directory, start, verbosity, timings, report)
    )
    if result.failure is not None:
        raise result.failure


def _finish(
    case: Case,
    backend: str,
    result: EdgeHistories,
    directory: Path,
    start: float,
    verbosity: Verbosity,
    timings: bool,
    report: bool,
) -> None:
    """Write and print, the numbers before anything is drawn; on rank 0."""
    begin = time.perf_counter()
    write_numbers(case, backend, result, directory)
    seconds = {**result.seconds, "writing": time.perf_counter() - begin}
    quiet = verbosity is Verbosity.QUIET
    console = Console(stderr=quiet)
    if not quiet:
        _print_numbers(console, case, result)
    _print_warnings(console, result)
    if report:
        if not quiet:
            print("Drawing the report ...", flush=True)
        drawn = draw_report(directory)
        seconds |= drawn.seconds
        for problem in drawn.problems:
            console.print(f"Warning: {problem}", highlight=False, markup=False, soft_wrap=True)
    if quiet:
        return
    if timings or verbosity is Verbosity.VERBOSE:
        console.print(timing_table(seconds))
    steps = _step_text(result.solution)
    text = f"{len(result.history.times) - 1} steps{steps}, {time.perf_counter() - start:.1f} s"
    console.print(text, highlight=False, soft_wrap=True)
    console.print(f"Results in {directory}", highlight=False, soft_wrap=True)


def _print_numbers(console: Console, case: Case, result: EdgeHistories) -> None:
    console.print(contact_table(case, result.history.cycle, result.contacts))
    console.print(edge_table(case, result.contacts))
    if result.refinement is not None:
        console.print(mesh_table(result.refinement))
        console.print(limit_table(result.refinement))
    for note in result.notes:
        console.print(f"Note: {note}", highlight=False, markup=False)


def _step_text(solution: Solution | None) -> str:
    if solution is None:
        return ""
    return (
        f", {solution.iterations[1:].mean():.1f} iterations a step, largest violation of a contact "
        f"condition {solution.certificates['worst'].max():.1e}"
    )


def _print_warnings(console: Console, result: EdgeHistories) -> None:
    refinement = result.refinement
    if refinement is not None and not refinement.converged:
        text = f"Warning: the mesh is not fine enough for edges.tolerance: {refinement.reason}"
        console.print(text, highlight=False, markup=False)
    for contact in result.contacts:
        for warning in contact.warnings:
            console.print(f"Warning: {contact.name}: {warning}", highlight=False, markup=False)


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
