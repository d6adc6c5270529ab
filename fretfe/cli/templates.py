# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe templates`."""

from __future__ import annotations

from rich.console import Console

from fretfe.environment import rank_from_environment
from fretfe.geometry.templates import find_template, template_names
from fretfe.report.tables import parameter_table, template_table


def show_templates(name: str | None) -> None:
    """Print one line per template, or the parameters of one; on rank 0.

    Raises:
        CaseError: there is no template of this name.
    """
    if name is None:
        table = template_table([find_template(each) for each in template_names()])
    else:
        table = parameter_table(find_template(name, "NAME"))
    if rank_from_environment() == 0:
        Console().print(table)
