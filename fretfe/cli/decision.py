# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command that turns stress into a decision: `fretfe assess`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretfe.cli.options import AsJson, examples, positive
from fretfe.environment import rank_from_environment
from fretfe.report.texts import print_whole

ASSESS_EXAMPLES = examples(
    "fretfe assess dovetail --material alloy.toml",
    "fretfe assess dovetail --material alloy.toml --tests tests.csv --life 1e6 -o decision",
    "fretfe assess dovetail dovetail_f0.5 dovetail_f0.7 --material alloy.toml",
)


def assess(
    directories: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR...",
            help="Folder with results, then those with other friction, whose range is printed.",
            show_default=False,
        ),
    ],
    material: Annotated[
        Path, typer.Option(help="Material file (TOML) with a table [fatigue].", show_default=False)
    ],
    tests: Annotated[
        Path | None, typer.Option(help="CSV file with fretting tests.", show_default=False)
    ] = None,
    life: Annotated[
        float | None,
        typer.Option(parser=positive, help="Cycles that tests are asked for.", show_default=False),
    ] = None,
    at_least: Annotated[
        float | None,
        typer.Option(
            parser=positive,
            help="End with exit code 1 if a margin is less or unknown.",
            show_default=False,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Folder for page and numbers; made if missing.",
            show_default=False,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:  # fmt: skip
    """Judge edges and fronts by tests, arrest of cracks and endurance."""
    if rank_from_environment() > 0:
        return
    import json

    from fretfe.api import assess as judge
    from fretfe.api import load_result
    from fretfe.decision.record import assessment_numbers
    from fretfe.decision.texts import answer, details, margin_tables

    result, *others = map(load_result, directories)
    found = judge(result, material, tests, life, others)
    if as_json:
        print(json.dumps(assessment_numbers(found), indent=1, allow_nan=False))
    else:
        for text in answer(found):
            print(text)
        for table in margin_tables(found):
            print_whole(table)
        for text in details(found):
            print(text)
    if output is not None:
        from fretfe.decision.page import write_assessment

        page, numbers = write_assessment(found, output)
        if not as_json:
            print(f"{page.name} and {numbers.name} in {output}")
    if at_least is not None and not found.keeps(at_least):
        raise typer.Exit(1)
