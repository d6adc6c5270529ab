# SPDX-License-Identifier: LGPL-3.0-or-later
"""What `fretfe sweep` does; rank 0 writes and prints."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from fretfe.backends import RunOptions, find_backend
from fretfe.backends.protocol import mute
from fretfe.cli.progress import StepReport
from fretfe.cli.verbosity import Verbosity
from fretfe.errors import ConvergenceError
from fretfe.runner import OneProcess, processes_of, read_case, write_case
from fretfe.sweeps import Sweep, make_variants, parse_ranges, run_sweep
from fretfe.sweeps.files import FIGURE, TABLE, write_files
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
    backend = find_backend(name)
    processes = processes_of(backend)
    if isinstance(processes, OneProcess) and processes.rank > 0:
        return
    case = processes.on_root(lambda: read_case(path, overrides, trust_geo=trust_geo))
    assert case is not None
    variants = processes.on_root(lambda: make_variants(case, parse_ranges(vary)))
    assert variants is not None
    processes.on_root(lambda: write_case(directory, case))
    with StepReport(processes.rank, verbosity, steps=False) as report:
        announce = report.announce if processes.rank == 0 else mute
        sweep = run_sweep(variants, backend, RunOptions(progress=report.step, announce=announce))
    drawn = processes.on_root(lambda: write_files(sweep, directory))
    if processes.rank == 0:
        _print(sweep, directory, bool(drawn), time.perf_counter() - start, verbosity)
    if len(sweep.failures) == len(sweep.variants):
        raise ConvergenceError(
            f"no variant could be solved; the first: {sweep.failures[0].failure}"
        )


def _print(
    sweep: Sweep, directory: Path, drawn: bool, seconds: float, verbosity: Verbosity
) -> None:
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
    files = f"{TABLE} and {FIGURE}" if drawn else f"{TABLE} (no picture: {NO_PICTURE})"
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
