# SPDX-License-Identifier: LGPL-3.0-or-later
"""The commands `fretfe validate` and `fretfe verify`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    examples,
    verbosity_of,
)
from fretfe.environment import rank_from_environment

if TYPE_CHECKING:
    from fretfe.quality.validation import Validation

NARROWEST = 100

VALIDATE_EXAMPLES = examples("fretfe validate pad.toml", "fretfe validate pad.toml -o pad --json")


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
    if runner.idle:
        return
    read = runner.read_case(case, overrides or (), trust_geo=trust_geo)
    with PhaseReport(case.name, runner.processes.rank, verbosity) as report:
        found = runner.validate(read, output, report, resume=resume)
    silent = verbosity is Verbosity.QUIET and found.passed
    if runner.processes.rank == 0 and (as_json or not silent):
        _print(found, as_json)
    if not found.passed:
        raise typer.Exit(1)


def _print(validation: Validation, as_json: bool) -> None:
    from rich.console import Console

    from fretfe.quality.validation import as_numbers, print_validation

    if as_json:
        print(json.dumps(as_numbers(validation), indent=1, allow_nan=False), flush=True)
    else:
        # Wide enough for all columns: a narrow terminal wraps lines rather than cuts numbers.
        print_validation(Console(width=max(Console().width, NARROWEST)), validation)


VERIFY_EXAMPLES = examples("fretfe verify", "fretfe verify --backend halfplane --backend analytic")


def verify(
    backend: Annotated[
        list[str] | None, typer.Option(help="Only this backend; can be given several times.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run benchmarks with known answers.

    Exit code 1 if one of them fails.
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
