# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe backends`; the first process prints."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretfe.cli.options import examples
from fretfe.environment import rank_from_environment

EXAMPLES = examples("fretfe backends", "fretfe backends pad.toml")


def backends(
    case: Annotated[
        Path | None,
        typer.Argument(metavar="CASE", help="Say which backends can solve this case."),
    ] = None,
) -> None:
    """List the installed backends, and why one cannot be used."""
    from rich.console import Console

    from fretfe.backends import installed_backends
    from fretfe.case import load_case
    from fretfe.report.page.listings import backend_table

    # On every rank: a backend that starts MPI when it is imported waits for the others.
    installed = installed_backends()
    if rank_from_environment() > 0:
        return
    read = load_case(case) if case is not None else None
    Console().print(backend_table(installed, read))
