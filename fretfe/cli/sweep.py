# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe sweep`; the first process prints."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from fretfe.cli.progress import StepReport
from fretfe.cli.verbosity import Verbosity
from fretfe.errors import ConvergenceError
from fretfe.runner import Runner
from fretfe.sweeps import Sweep, parse_ranges
from fretfe.sweeps.files import FIGURE, TABLE
from fretfe.sweeps.table import MOST_ROWS, sweep_table

NARROWEST = 100
NO_PICTURE = "it takes one or two keys that vary, and a case that was solved"


def sweep_case(
    path: Path,
    vary: Sequence[str],
    directory: Path,
    name: str,
    overrides: Sequence[str] = (),
    verbosity: Verbosity = Verbosity.NORMAL,
    *,
    trust_geo: bool = False,
) -> None:
    """Solve all combinations of values, write and print a table. Collective like the backend.

    Args:
        path: of the case file.
        vary: keys and values, like ``contacts.main.friction=0.1:0.6:11``.
        directory: for table and picture.
        name: of the backend.
        overrides: values in place of those of the file, like ``loads.shear.amplitude=120``.
        verbosity: how much is printed.
        trust_geo: whether a .geo file of the case may run.

    Raises:
        ConvergenceError: if no variant could be solved.
    """
    start = time.perf_counter()
    runner = Runner.find(name)
    if runner.idle:
        return
    case = runner.read_case(path, overrides, trust_geo=trust_geo)
    with StepReport(runner.processes.rank, verbosity, steps=False) as report:
        sweep = runner.sweep(case, parse_ranges(vary), directory, report)
    if runner.processes.rank == 0:
        _print(sweep, directory, time.perf_counter() - start, verbosity)
    if len(sweep.failures) == len(sweep.variants):
        raise ConvergenceError(
            f"no variant could be solved; the first: {sweep.failures[0].failure}"
        )


def _print(sweep: Sweep, directory: Path, seconds: float, verbosity: Verbosity) -> None:
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
