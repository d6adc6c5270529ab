# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe verify`; the first process prints."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fretfe.cli.options import AsJson, examples
from fretfe.environment import rank_from_environment

EXAMPLES = examples("fretfe verify", "fretfe verify --backend halfplane --backend analytic")


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
    from fretfe.quality.verify.model import as_numbers, print_summary
    from fretfe.quality.verify.run import verify as run_all

    first = rank_from_environment() == 0
    report = BenchmarkReport(quiet=as_json or not first)
    found = run_all(backend or (), report, report.show)
    print_summary(report.console, found.rows, found.seconds)
    if as_json and first:
        numbers = as_numbers(found.rows, found.seconds)
        print(json.dumps(numbers, indent=1, allow_nan=False), flush=True)
    if not found.passed:
        raise typer.Exit(1)
