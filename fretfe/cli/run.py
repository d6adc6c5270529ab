# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands that solve: `fretfe run`, `sweep`, `validate` and `verify`; the first process prints."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TypeVar

import typer

from fretfe.cli.options import (
    AsJson,
    Backend,
    CaseFile,
    Overrides,
    Quiet,
    Resume,
    TrustGeo,
    Verbose,
    Verbosity,
    count,
    examples,
    verbosity_of,
)
from fretfe.environment import idle_cores, launched, launcher, rank_from_environment
from fretfe.errors import DependencyError
from fretfe.faults import Fault, guarded, require_none

if TYPE_CHECKING:
    from fretfe.case import Case
    from fretfe.console import Console
    from fretfe.history.solution import Solution
    from fretfe.quality.validation import Validation
    from fretfe.results.model import Result
    from fretfe.runner import Drawn
    from fretfe.surface.ahead import CaseAhead
    from fretfe.sweeps import Sweep

T = TypeVar("T")

RUN_EXAMPLES = examples(
    "fretfe run pad.toml -o pad",
    "fretfe run pad.toml -o pad70 --set loads.shear.amplitude=70",
    "fretfe run pad.toml -o half --backend halfplane",
    "fretfe run pad.toml -o pad --ranks 4",
)
# The backend that needs a mesh.
MESHES = "fem"
# Variants of a sweep that a warning names.
MOST_NAMED = 3
NO_PICTURE = "it takes a case of plane bodies that was solved"

SWEEP_EXAMPLES = examples(
    "fretfe sweep pad.toml -o mu --vary contacts.main.friction=0.3:0.8:11",
    "fretfe sweep pad.toml -o map --vary contacts.main.friction=0.4,0.6,0.8 \\",
    "    --vary loads.shear.amplitude=20:80:4",
)

VALIDATE_EXAMPLES = examples("fretfe validate pad.toml", "fretfe validate pad.toml -o pad --json")


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
    ranks: Annotated[
        int, typer.Option(parser=count, help="Processes to run on; starts the right mpirun.")
    ] = 1,
) -> None:
    """Solve a case and write its results."""
    if ranks > 1:
        _start_ranks(ranks)
    verbosity, start = verbosity_of(quiet, verbose), time.perf_counter()
    if not rank_from_environment() and verbosity is not Verbosity.QUIET:
        _say(f"reading {case} and loading the backend {backend}")
    reader = _reader(case, overrides, trust_geo=trust_geo)
    # A run that goes on may be complete.
    ahead = _begun(reader) if backend == MESHES and not resume else None
    from fretfe.cli.progress import StepReport
    from fretfe.runner import Runner

    runner = Runner.find(backend)
    if runner.processes.idle:
        return
    read = runner.read_case(ahead.case if ahead else reader)
    mesh = ahead.mesh if ahead else None
    if not (resume or runner.processes.rank or verbosity is Verbosity.QUIET):
        _announce_replacement(output)
    with StepReport(runner.processes.rank, verbosity) as shown:
        result = runner.run(read, output, shown, resume=resume, mesh=mesh)
    timed = timings or verbosity is Verbosity.VERBOSE
    ended = runner.write(lambda: _finish_run(result, output, start, verbosity, timed, report))
    failure = result.failure or (ended.failure if ended is not None else None)
    if failure is not None:
        raise failure
    require_none((*result.faults, *(ended.faults if ended else ())), output)


def _start_ranks(ranks: int) -> NoReturn:
    """Run this command on several processes, in place of this one."""
    cores, mpirun = idle_cores() + 1, launcher()
    if launched():
        raise typer.BadParameter("--ranks: expected a command without mpirun, which started this")
    if ranks > cores:
        raise typer.BadParameter(f"--ranks: expected at most {cores}, the cores, found {ranks}")
    if mpirun is None:
        raise DependencyError("--ranks: expected mpirun beside Python or in PATH, found none")
    words = [each for each in sys.argv[1:] if not each.startswith("--ranks=")]
    if "--ranks" in words:
        place = words.index("--ranks")
        del words[place : place + 2]
    sys.stdout.flush()
    # Modules are not looked for in the working folder (-P), as by the command fretfe.
    os.execv(mpirun, [mpirun, "-n", str(ranks), sys.executable, "-P", "-m", "fretfe", *words])


def _announce_replacement(directory: Path) -> None:
    """Say so if there are results in the folder of a run."""
    from fretfe.results.writer import NUMBERS

    if (directory / NUMBERS).exists():
        print(f"This run replaces the results in {directory}", flush=True)


def _reader(path: Path, overrides: list[str] | None, *, trust_geo: bool) -> Callable[[], Case]:
    """Reader of a case file, with values in place of its own, and of the files of its loads."""
    from fretfe.bodies.loads.files import checked_history
    from fretfe.case import load_case, parse_assignments

    assigned = parse_assignments(overrides or ())

    def read() -> Case:
        case = load_case(path, assigned, trust_geo=trust_geo)
        checked_history(case)
        return case

    return read


def _begun(read: Callable[[], Case]) -> CaseAhead | None:
    """The case with its mesh in the making, on the first process."""
    if rank_from_environment():
        return None
    from fretfe.surface.ahead import CaseAhead

    return CaseAhead(read)


def _finish_run(
    result: Result, directory: Path, start: float, verbosity: Verbosity, timed: bool, report: bool
) -> Drawn:
    """Print, the numbers before anything is drawn, and say what failed; on the first process."""
    from fretfe.console import Console
    from fretfe.faults import collecting
    from fretfe.report.page.tables import timing_table
    from fretfe.results.writer import remove_old_report
    from fretfe.runner import Drawn, draw_report

    quiet = verbosity is Verbosity.QUIET
    console = Console(stderr=quiet)
    with collecting(directory) as collected:
        if not quiet:
            _print_numbers(console, result)
        _print_warnings(console, result)
    drawn = Drawn({})
    if report:
        if not quiet:
            _say("Drawing the pictures and the report")
        drawn = draw_report(directory, _silent if quiet else _say)
        for problem in drawn.problems:
            console.print(f"Warning: {problem}", highlight=False, markup=False, soft_wrap=True)
    else:
        remove_old_report(directory)
    drawn = replace(drawn, faults=(*collected.faults, *drawn.faults))
    if quiet:
        return drawn
    if timed:
        console.print(timing_table({**result.seconds, **drawn.seconds}))
    steps = _step_text(result.solution)
    print(f"{len(result.loads.times) - 1} steps{steps}, {time.perf_counter() - start:.1f} s")
    print(f"Results in {directory}")
    return drawn


def _say(text: str) -> None:
    """Name what is being done."""
    print(f"{text} ...", flush=True)


def _silent(_: str) -> None:
    """Say nothing."""


def _print_numbers(console: Console, result: Result) -> None:
    from fretfe.report.page.ends import end_tables
    from fretfe.report.page.tables import (
        contact_table,
        cycle_table,
        front_texts,
        refinement_tables,
        station_table,
    )
    from fretfe.report.texts import print_whole

    def shown(name: str, make: Callable[[], T]) -> T | None:
        def failed(fault: Fault) -> None:
            console.print(fault.text, highlight=False, markup=False)

        return guarded(name, make, failed)

    first = shown("first lines", lambda: result.headline.sentences.lines) or ()
    fronts = shown("worst stations", lambda: front_texts(result)) if result.solid else ()
    for text in (*first, *(fronts or ())):
        console.print(text, highlight=False, markup=False)
    tables = [
        shown("table of contacts", lambda: contact_table(result)),
        shown("table of edges", lambda: station_table(result)),
        shown("table of counted cycles", lambda: cycle_table(result)),
        *(shown("tables of free ends", lambda: end_tables(result)) or ()),
        *(shown("table of meshes", lambda: refinement_tables(result.refinement)) or ()),
    ]
    for table in tables:
        if table is not None:
            print_whole(table)
    for note in result.notes:
        console.print(f"Note: {note}", highlight=False, markup=False)


def _step_text(solution: Solution) -> str:
    if len(solution.iterations) < 2:  # the unloaded state alone
        return ""
    return (
        f", {solution.iterations[1:].mean():.1f} iterations a step, largest violation of a contact "
        f"condition {solution.certificates['worst'].max():.1e}"
    )


def _print_warnings(console: Console, result: Result) -> None:
    from fretfe.caution import grouped

    for group in grouped(result.warnings):
        console.print(f"Warning: {group.line}", highlight=False, markup=False)


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
    if runner.processes.idle:
        return
    ranges = parse_ranges(vary)
    read = runner.read_case(_reader(case, overrides, trust_geo=trust_geo))
    first = {key: values[0] for key, values in ranges.items()}
    runner.processes.on_root(lambda: require_apart(case, overrides or (), first))
    with StepReport(runner.processes.rank, verbosity, steps=False) as report:
        found = runner.sweep(read, ranges, output, report, resume=resume)
    if runner.processes.rank == 0:
        _print_sweep(found, output, time.perf_counter() - start, verbosity)
    _raise_failure(found)
    require_none(found.faults, output)


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


def _print_sweep(sweep: Sweep, directory: Path, seconds: float, verbosity: Verbosity) -> None:
    from fretfe.console import Console
    from fretfe.report.texts import print_whole
    from fretfe.sweeps.table import FIGURE, MOST_ROWS, TABLE, sweep_table

    quiet = verbosity is Verbosity.QUIET
    console = Console(stderr=quiet)
    if not quiet:
        print_whole(sweep_table(sweep))
        rows = len(sweep.records())
        if rows > MOST_ROWS:
            console.print(f"The first {MOST_ROWS} of {rows} rows; all are in {TABLE}.")
        for note in sweep.notes:
            console.print(f"Note: {note}", highlight=False, markup=False)
    for text in _sweep_warnings(sweep):
        console.print(f"Warning: {text}", highlight=False, markup=False)
    if quiet:
        return
    console.print(_cost(sweep, seconds), highlight=False)
    files = (
        f"{TABLE} and {FIGURE}"
        if (directory / FIGURE).exists()
        else f"{TABLE} (no picture: {NO_PICTURE})"
    )
    print(f"{files} in {directory}")


def _sweep_warnings(sweep: Sweep) -> list[str]:
    """Each kind of warning once with the number of cases, and each case that failed."""
    from fretfe.caution import grouped

    texts, count = [], len(sweep.variants)
    for group in grouped(warning for each in sweep.variants for warning in each.warnings):
        names = [
            _variant(each.values)
            for each in sweep.variants
            if any(warning.kind is group.kind for warning in each.warnings)
        ]
        where = f"{len(names)} of {count} variants: {'; '.join(names[:MOST_NAMED])}"
        texts.append(f"{group.line} ({where}{'; ...' if len(names) > MOST_NAMED else ''})")
    return [*texts, *(f"{_variant(each.values)}: {each.failure}" for each in sweep.failures)]


def _variant(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} = {value}" for key, value in values.items())


def _cost(sweep: Sweep, seconds: float) -> str:
    each = sorted(variant.seconds for variant in sweep.variants)
    failed = f", {len(sweep.failures)} failed" if sweep.failures else ""
    return (
        f"{len(each)} variants{failed}, {seconds:.1f} s: {each[0]:.2g} to {each[-1]:.2g} s each, "
        f"median {each[len(each) // 2]:.2g} s"
    )


def validate(
    case: CaseFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for the results.")
    ] = None,
    backend: Backend = "fem",
    overrides: Overrides = None,
    resume: Resume = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: AsJson = False,
    trust_geo: TrustGeo = False,
) -> None:
    """Run a case and its companions: can its numbers be trusted?

    Exit code 1 if a comparison fails.
    """
    from fretfe.cli.progress import PhaseReport
    from fretfe.runner import Runner

    verbosity = verbosity_of(quiet, verbose)
    runner = Runner.find(backend)
    if runner.processes.idle:
        return
    read = runner.read_case(_reader(case, overrides, trust_geo=trust_geo))
    with PhaseReport(case.name, runner.processes.rank, verbosity) as report:
        found = runner.validate(read, output, report, resume=resume)
    silent = verbosity is Verbosity.QUIET and found.passed
    if runner.processes.rank == 0 and (as_json or not silent):
        _print_validation(found, as_json)
    require_none(found.result.faults, output)
    if not found.passed:
        raise typer.Exit(1)


def _print_validation(validation: Validation, as_json: bool) -> None:
    from fretfe.console import Console
    from fretfe.quality.validation import as_numbers, print_validation

    if as_json:
        print(json.dumps(as_numbers(validation), indent=1, allow_nan=False), flush=True)
    else:
        print_validation(Console(), validation)


VERIFY_EXAMPLES = examples("fretfe verify", "fretfe verify --backend halfplane")


def verify(
    backend: Annotated[
        list[str] | None, typer.Option(help="Only this backend; can be given several times.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run benchmarks with known answers.

    Exit code 1 if one of them fails, or if fem cannot be used and no backend was chosen.
    """
    from fretfe.cli.progress import BenchmarkReport
    from fretfe.quality.comparison import as_numbers, print_summary
    from fretfe.quality.verification import verify as run_all

    first = rank_from_environment() == 0
    report = BenchmarkReport(quiet=as_json or not first)
    found = run_all(backend or (), report, report.show)
    print_summary(report.console, found.rows, found.seconds)
    if as_json and first:
        numbers = as_numbers(found.rows, found.seconds)
        print(json.dumps(numbers, indent=1, allow_nan=False), flush=True)
    if not found.passed:
        raise typer.Exit(1)
