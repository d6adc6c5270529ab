# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe edges`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretfe.cli.options import AsJson, examples
from fretfe.exchange.sign import Sign

EXAMPLES = examples(
    "fretfe edges tractions.csv --friction 0.6",
    "fretfe edges abaqus.csv --friction 0.6",
    "fretfe edges tractions.csv --x arc --p pressure --q shear --json",
)


def edges(
    table: Annotated[Path, typer.Argument(help="CSV file with a header.", show_default=False)],
    friction: Annotated[float | None, typer.Option(help="Friction coefficient.")] = None,
    x: Annotated[
        str | None, typer.Option(help="Column with the positions along the contact.")
    ] = None,
    p: Annotated[str | None, typer.Option(help="Column with the pressure.")] = None,
    q: Annotated[str | None, typer.Option(help="Column with the shear.")] = None,
    slip: Annotated[str | None, typer.Option(help="Column with the slip.")] = None,
    compression: Annotated[
        Sign | None,
        typer.Option(metavar="SIGN", help="Sign of a pressure in the file: positive or negative."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Find edges, K_N and slip zones in tractions of any program.

    Columns are x, p, q and slip, or those that finite-element programs write.
    """
    from fretfe.cli.edges_report import analyse_file
    from fretfe.exchange.column_names import Columns

    analyse_file(table, Columns(x, p, q, slip), friction, compression, as_json=as_json)
