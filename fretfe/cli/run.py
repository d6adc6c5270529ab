# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe run`; the first process prints."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from fretfe.cli.progress import StepReport
from fretfe.cli.verbosity import Verbosity
from fretfe.report.tables import contact_table, edge_table, limit_table, mesh_table, timing_table
from fretfe.results.model import Result
from fretfe.results.solution import Solution
from fretfe.runner import Runner, draw_report


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
    runner = Runner.find(name)
    if runner.idle:
        return
    case = runner.read_case(path, overrides, trust_geo=trust_geo)
    with StepReport(runner.processes.rank, verbosity) as shown:
        result = runner.run(case, directory, shown)
    timed = timings or verbosity is Verbosity.VERBOSE
    runner.write(lambda: _finish(result, directory, start, verbosity, timed, report))
    if result.failure is not None:
        raise result.failure


def _finish(
    result: Result, directory: Path, start: float, verbosity: Verbosity, timed: bool, report: bool
) -> None:
    """Print, the numbers before anything is drawn; on the first process."""
    seconds = dict(result.seconds)
    quiet = verbosity is Verbosity.QUIET
    console = Console(stderr=quiet)
    if not quiet:
        _print_numbers(console, result)
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
    if timed:
        console.print(timing_table(seconds))
    steps = _step_text(result.solution)
    text = f"{len(result.loads.times) - 1} steps{steps}, {time.perf_counter() - start:.1f} s"
    console.print(text, highlight=False, soft_wrap=True)
    console.print(f"Results in {directory}", highlight=False, soft_wrap=True)


def _print_numbers(console: Console, result: Result) -> None:
    console.print(contact_table(result.case, result.loads.cycle, result.contacts))
    console.print(edge_table(result.case, result.contacts))
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
