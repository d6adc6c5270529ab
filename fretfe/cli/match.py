# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe match`; the first process works."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretfe.cli.options import Results, examples
from fretfe.environment import rank_from_environment

EXAMPLES = examples(
    "fretfe match dovetail --edge left.right --rig rig.toml -o tests",
    "fretfe run tests/flat_rounded.toml -o flat",
    "fretfe match dovetail --edge left.right --rig rig.toml --against flat -o overlay",
)


def match(
    directory: Results,
    edge: Annotated[
        str, typer.Option(help="Edge of the component: CONTACT.left or CONTACT.right.")
    ],
    rig: Annotated[Path, typer.Option(help="Rig file (TOML): what the laboratory can do.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for cases and numbers.")],
    against: Annotated[
        list[Path] | None,
        typer.Option(
            help="Folder with results of a test to lay over the component; can be given several "
            "times.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Find laboratory tests with the edge factors of a component.

    With --against, compare solved tests with the component, and correct their loads.
    """
    if rank_from_environment() > 0:
        return
    from fretfe.cli.match_report import report_match

    report_match(directory, edge, rig, output, tuple(against or ()))
