# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe compare`; the first process works."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import AsJson, examples
from fretfe.environment import rank_from_environment

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from fretfe.exchange.comparison import Comparison

EXAMPLES = examples(
    "fretfe compare pad pad_fine",
    "fretfe compare pad pad_fine -o difference",
)


def compare(
    first: Annotated[
        Path, typer.Argument(metavar="DIR1", help="Folder with results.", show_default=False)
    ],
    second: Annotated[
        Path, typer.Argument(metavar="DIR2", help="Folder with other results.", show_default=False)
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Folder for figures and numbers; made if missing.",
            show_default=False,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:  # fmt: skip
    """Compare two results: edges, tractions, histories."""
    if rank_from_environment() > 0:
        return
    import json

    from rich.console import Console

    from fretfe import api
    from fretfe.exchange.comparison_files import comparison_numbers, write_comparison

    comparison = api.compare(api.load_result(first), api.load_result(second))
    if as_json:
        print(json.dumps(comparison_numbers(comparison), indent=1, allow_nan=False))
    else:
        _print(Console(), comparison)
    if output is not None:
        files = write_comparison(comparison, output)
        if not as_json:
            names = ", ".join(path.name for path in files)
            Console().print(f"{names} in {output}", highlight=False, markup=False, soft_wrap=True)


def _print(console: Console, comparison: Comparison) -> None:
    from fretfe.report.page.listings import print_whole
    from fretfe.report.texts import number, percent

    print_whole(_numbers(comparison))
    for each in comparison.tractions:
        console.print(
            f"{each.contact}, {each.extreme}: p differs by {percent(each.pressure_difference)}, "
            f"q by {percent(each.shear_difference)} of f p (root mean square)",
            highlight=False,
            markup=False,
            soft_wrap=True,
        )
    for history in comparison.histories:
        place = " ".join(filter(None, (history.contact, history.edge)))
        differs = (
            f"differs by {percent(history.difference)} at most at {history.common} common times"
            if history.common
            else "has no common times"
        )
        value = number(abs(history.first).max(initial=0.0))
        console.print(
            f"{place}: {history.quantity} over time ({value} {history.unit}) {differs}",
            highlight=False,
            markup=False,
            soft_wrap=True,
        )
    for note in comparison.notes:
        console.print(f"Note: {note}", highlight=False, markup=False, soft_wrap=True)


def _numbers(comparison: Comparison) -> Table:
    from rich.markup import escape

    from fretfe.report.page.listings import plain_table
    from fretfe.report.texts import percent, with_error

    labels = [escape(label) for label in comparison.labels]
    headers = ("", "", *labels, "difference", "within bars")
    table = plain_table("Comparison", headers, text=2)
    words = {True: "yes", False: "no", None: "-"}
    for each in comparison.quantities:
        difference = percent(each.difference)
        if each.agrees is not None:
            difference += f" ± {percent(each.difference_spread)}"
        table.add_row(
            " ".join(filter(None, (each.contact, each.edge))),
            f"{each.quantity} {escape(f'[{each.unit}]')}",
            with_error(each.first, each.first_spread),
            with_error(each.second, each.second_spread),
            difference, words[each.agrees],
        )  # fmt: skip
    return table
