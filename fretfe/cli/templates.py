# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe templates`; the first process prints."""

from __future__ import annotations

from typing import Annotated

import typer

from fretfe.cli.options import examples
from fretfe.environment import rank_from_environment

EXAMPLES = examples("fretfe templates", "fretfe templates dovetail")


def templates(
    name: Annotated[
        str | None, typer.Argument(help="Template whose parameters are listed.")
    ] = None,
) -> None:
    """List the geometry templates, or the parameters of one of them."""
    from rich.console import Console

    from fretfe.mesh.templates import find_template, template_names
    from fretfe.report.page.listings import parameter_table, template_table

    if name is None:
        table = template_table([find_template(each) for each in template_names()])
    else:
        table = parameter_table(find_template(name, "NAME"))
    if rank_from_environment() == 0:
        Console().print(table)
