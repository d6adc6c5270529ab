# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables for the terminal of what is installed; they import nothing that computes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.measure import Measurement
from rich.table import Table

if TYPE_CHECKING:
    from fretfe.backends import Installed
    from fretfe.case import Case
    from fretfe.mesh.templates import Parameter, Template

# Characters in a line of a table, more than any has.
WIDEST = 1000


def plain_table(title: str, headers: tuple[str, ...], text: int) -> Table:
    """An empty table whose first `text` columns hold text and the others numbers."""
    table = Table(title=title, title_justify="left", box=box.SIMPLE, title_style="bold")
    table.pad_edge = False
    table.padding = (0, 1, 0, 0)
    for place, header in enumerate(headers):
        table.add_column(header, justify="left" if place < text else "right", no_wrap=True)
    return table


def print_whole(table: Table) -> None:
    """Print a table as wide as it is: a narrow terminal wraps lines rather than cuts numbers."""
    console = Console()
    width = Measurement.get(console, console.options.update(max_width=WIDEST), table).maximum
    Console(width=max(width, console.width)).print(table)


def backend_table(backends: tuple[Installed, ...], case: Case | None) -> Table:
    """One row per backend: what it solves, or why it cannot be used or cannot solve the case."""
    table = Table(title="Backends", title_justify="left", box=box.SIMPLE, title_style="bold")
    for header in ("backend", "usable", "package", "what it solves, or why not"):
        table.add_column(header, overflow="fold")
    for installed in backends:
        usable, text = _usable(installed, case)
        table.add_row(installed.name, usable, installed.package, escape(text))
    return table


def _usable(installed: Installed, case: Case | None) -> tuple[str, str]:
    if installed.backend is None:
        return "no", installed.reason
    try:
        reasons = installed.backend.supports(case) if case is not None else ()
    except Exception as error:  # one backend must not hide the others
        reasons = (str(error),)
    return ("no", "\n".join(reasons)) if reasons else ("yes", installed.backend.summary)


def template_table(templates: Sequence[Template]) -> Table:
    """One row per geometry template."""
    table = plain_table("Templates", ("template",), text=1)
    table.add_column("geometry")
    for template in templates:
        table.add_row(template.name, escape(template.summary))
    return table


def parameter_table(template: Template) -> Table:
    """One row per parameter of a template."""
    title = f"Template {template.name}\n{escape(template.summary)}"
    table = plain_table(title, ("parameter", "default", "range", "unit"), text=1)
    table.add_column("meaning")
    table.columns[3].justify = "left"
    for each in template.parameters:
        limits, unit = _range_and_unit(each)
        table.add_row(each.name, f"{each.default:g}", limits, unit, escape(each.description))
    return table


def parameter_rows(template: Template) -> str:
    """The parameters of a template as a table in Markdown."""
    lines = ["| parameter | default | range | unit | meaning |", "|---|---|---|---|---|"]
    for each in template.parameters:
        limits, unit = _range_and_unit(each)
        lines.append(
            f"| `{each.name}` | {each.default:g} | {limits} | {unit} | {each.description} |"
        )
    return "\n".join(lines) + "\n"


def _range_and_unit(parameter: Parameter) -> tuple[str, str]:
    limits = f"{parameter.minimum:g} … {parameter.maximum:g}"
    unit = "" if parameter.unit == "-" else parameter.unit
    return limits + (", whole" if parameter.whole else ""), unit
