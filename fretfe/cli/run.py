# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe run`; the first process prints."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import (
    Backend,
    CaseFile,
    Overrides,
    Quiet,
    Resume,
    TrustGeo,
    Verbose,
    Verbosity,
    examples,
    verbosity_of,
)

if TYPE_CHECKING:
    from rich.console import Console

    from fretfe.history.solution import Solution
    from fretfe.results.model import Result

EXAMPLES = examples(
    "fretfe run pad.toml -o pad",
    "fretfe run pad.toml -o pad70 --set loads.shear.amplitude=70",
    "fretfe run pad.toml -o half --backend halfplane",
    "mpirun -n 4 fretfe run pad.toml -o pad",
)


def run(
    case: CaseFile,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for the results; made if missing.")
    ],
    backend: Backend = "fem",
    overrides: Overrides = None,
    resume: Resume = False,
    timings: Annotated[
        bool, typer.Option("--timings", help="Print the wall time of each phase.")
    ] = False,
    report: Annotated[
        bool, typer.Option("--report/--no-report", help="Make report.html in the folder.")
    ] = True,
    quiet: Quiet = False,
    verbose: Verbose = False,
    trust_geo: TrustGeo = False,
) -> None:
    """Solve a case and write its results."""
    from fretfe.cli.progress import StepReport
    from fretfe.runner import Runner

    verbosity, start = verbosity_of(quiet, verbose), time.perf_counter()
    runner = Runner.find(backend)
    if runner.idle:
        return
    read = runner.read_case(case, overrides or (), trust_geo=trust_geo)
    with StepReport(runner.processes.rank, verbosity) as shown:
        result = runner.run(read, output, shown, resume=resume)
    timed = timings or verbosity is Verbosity.VERBOSE
    runner.write(lambda: _finish(result, output, start, verbosity, timed, report))
    if result.failure is not None:
        raise result.failure


def _finish(
    result: Result, directory: Path, start: float, verbosity: Verbosity, timed: bool, report: bool
) -> None:
    """Print, the numbers before anything is drawn; on the first process."""
    from rich.console import Console

    from fretfe.report.page.tables import timing_table
    from fretfe.runner import draw_report

    seconds = dict(result.seconds)
    quiet = verbosity is Verbosity.QUIET
    console = Console(stderr=quiet)
    if not quiet:
        _print_numbers(console, result)
    _print_warnings(console, result)
    if report:
        if not quiet:
            print("Drawing the pictures and the report ...", flush=True)
        drawn = draw_report(directory)
        seconds |= drawn.seconds
        for problem in drawn.problems:
            console.print(f"Warning: {problem}", highlight=False, markup=False, soft_wrap=True)
    if quiet:
        return
    if timed:
        console.print(timing_table(seconds))
    steps = _step_text(result.solution)
    text = f"{len(result.loads.times) - 1} steps{steps}, {time.perf_counter() - start:.1f} s"
    console.print(text, highlight=False, soft_wrap=True)
    console.print(f"Results in {directory}", highlight=False, soft_wrap=True)


def _print_numbers(console: Console, result: Result) -> None:
    from fretfe.report.page.tables import (
        contact_table,
        cycle_table,
        limit_table,
        mesh_table,
        station_table,
    )

    console.print(contact_table(result))
    for table in (station_table(result), cycle_table(result)):
        if table is not None:
            console.print(table)
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


def _print_warnings(console: Console, result: Result) -> None:
    refinement = result.refinement
    if refinement is not None and not refinement.converged:
        text = f"Warning: the mesh is not fine enough for edges.tolerance: {refinement.reason}"
        console.print(text, highlight=False, markup=False)
    for contact in result.contacts:
        for warning in contact.warnings:
            console.print(f"Warning: {contact.name}: {warning}", highlight=False, markup=False)
