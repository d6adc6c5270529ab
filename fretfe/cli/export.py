# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe export`; the first process works."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretfe.cli.options import Results, examples
from fretfe.environment import rank_from_environment

EXAMPLES = examples("fretfe export pad -o pad_csv")


def export(
    results: Results,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for the tables; made if missing.")
    ],
    fatemi_socie: Annotated[
        tuple[float, float] | None,
        typer.Option(
            metavar="K YIELD",
            help="k and yield stress of Fatemi and Socie; for runs with [output] stress_depths.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Write the numbers of a run as CSV files."""
    if rank_from_environment() > 0:
        return
    from rich.console import Console

    from fretfe.api import load_result
    from fretfe.exchange.export import export_result

    result = load_result(results)
    console = Console()
    for each in export_result(result, output, fatemi_socie):
        rows = f"{each.rows} row{'s' if each.rows != 1 else ''}"
        console.print(f"{each.path}: {rows}", highlight=False, markup=False, soft_wrap=True)
    if result.failure is not None:
        console.print(f"Note: the run is not complete: {result.failure}", markup=False)
