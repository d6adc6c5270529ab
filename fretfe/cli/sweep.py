# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe sweep`; the first process prints."""

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
    from fretfe.sweeps import Sweep

NARROWEST = 100
NO_PICTURE = "it takes one or two keys that vary, and a case that was solved"

EXAMPLES = examples(
    "fretfe sweep pad.toml -o mu --vary contacts.main.friction=0.3:0.8:11",
    "fretfe sweep pad.toml -o map --vary contacts.main.friction=0.4,0.6,0.8 \\",
    "    --vary loads.shear.amplitude=20:80:4",
)


def sweep(
    case: CaseFile,
    vary: Annotated[
        list[str],
        typer.Option(
            metavar="KEY=VALUES",
            help="START:STOP:COUNT or A,B,C; several times for all combinations.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for table and picture; made if missing.")
    ],
    backend: Backend = "fem",
    overrides: Overrides = None,
    resume: Resume = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    trust_geo: TrustGeo = False,
) -> None:
    """Solve a case with many values of some keys: a table, a picture.

    Friction and load histories need no new factorisation: they are cheap to vary.
    """
    from fretfe.cli.progress import StepReport
    from fretfe.runner import Runner
    from fretfe.sweeps import parse_ranges, require_apart

    verbosity, start = verbosity_of(quiet, verbose), time.perf_counter()
    runner = Runner.find(backend)
    if runner.idle:
        return
    ranges = parse_ranges(vary)
    read = runner.read_case(case, overrides or (), trust_geo=trust_geo)
    first = {key: values[0] for key, values in ranges.items()}
    runner.processes.on_root(lambda: require_apart(case, overrides or (), first))
    with StepReport(runner.processes.rank, verbosity, steps=False) as report:
        found = runner.sweep(read, ranges, output, report, resume=resume)
    if runner.processes.rank == 0:
        _print(found, output, time.perf_counter() - start, verbosity)
    _raise_failure(found)


def _raise_failure(sweep: Sweep) -> None:
    """End with the exit code of a signal, or with that of steps without a solution.

    Raises:
        ConvergenceError: if no case was solved, or not all because of a signal.
    """
    from fretfe.errors import ConvergenceError

    if sweep.stopped is not None:
        raise sweep.stopped
    if len(sweep.failures) == len(sweep.variants):
        raise ConvergenceError(
            f"no variant could be solved; the first: {sweep.failures[0].failure}"
        )


def _print(sweep: Sweep, directory: Path, seconds: float, verbosity: Verbosity) -> None:
    from rich.console import Console

    from fretfe.sweeps.table import FIGURE, MOST_ROWS, TABLE, sweep_table

    quiet = verbosity is Verbosity.QUIET
    # Wide enough for all columns: a narrow terminal wraps lines rather than cuts numbers.
    console = Console(width=max(Console().width, NARROWEST), stderr=quiet)
    if not quiet:
        console.print(sweep_table(sweep))
        rows = len(sweep.records())
        if rows > MOST_ROWS:
            console.print(f"The first {MOST_ROWS} of {rows} rows; all are in {TABLE}.")
        for note in sweep.notes:
            console.print(f"Note: {note}", highlight=False, markup=False)
    for text in _warnings(sweep):
        console.print(f"Warning: {text}", highlight=False, markup=False)
    if quiet:
        return
    console.print(_cost(sweep, seconds), highlight=False)
    files = (
        f"{TABLE} and {FIGURE}"
        if (directory / FIGURE).exists()
        else f"{TABLE} (no picture: {NO_PICTURE})"
    )
    console.print(f"{files} in {directory}", highlight=False, soft_wrap=True)


def _warnings(sweep: Sweep) -> list[str]:
    """Each warning of the edges once with the number of cases, and each case that failed."""
    counts: dict[str, int] = {}
    for each in sweep.variants:
        found = {(edge["contact"], edge["warnings"]) for edge in each.edges if edge["warnings"]}
        for contact, text in sorted(found):
            counts[f"{contact}: {text}"] = counts.get(f"{contact}: {text}", 0) + 1
    count = len(sweep.variants)
    texts = [f"{text} ({number} of {count} variants)" for text, number in counts.items()]
    for each in sweep.failures:
        values = ", ".join(f"{key} = {value}" for key, value in each.values.items())
        texts.append(f"{values}: {each.failure}")
    return texts


def _cost(sweep: Sweep, seconds: float) -> str:
    each = sorted(variant.seconds for variant in sweep.variants)
    failed = f", {len(sweep.failures)} failed" if sweep.failures else ""
    return (
        f"{len(each)} variants{failed}, {seconds:.1f} s: {each[0]:.2g} to {each[-1]:.2g} s each, "
        f"median {each[len(each) // 2]:.2g} s"
    )
