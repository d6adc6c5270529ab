# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands that exchange numbers with other programs: `fretfe edges`, `compare` and `export`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import AsJson, Results, examples
from fretfe.environment import rank_from_environment
from fretfe.exchange.sign import Sign

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from fretfe.exchange.comparison import Comparison

EDGES_EXAMPLES = examples(
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
    from fretfe.exchange.traction_file import Columns

    analyse_file(table, Columns(x, p, q, slip), friction, compression, as_json=as_json)


COMPARE_EXAMPLES = examples(
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


EXPORT_EXAMPLES = examples("fretfe export pad -o pad_csv")


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
