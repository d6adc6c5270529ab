# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands about laboratory tests: `fretfe match` and `fretfe strength`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import AsJson, Results, examples
from fretfe.environment import rank_from_environment

if TYPE_CHECKING:
    from rich.table import Table

    from fretfe.strength.margins import Margin, StrengthMap

MATCH_EXAMPLES = examples(
    "fretfe match dovetail --edge left.right --rig rig.toml -o tests",
    "fretfe run tests/flat_rounded.toml -o flat",
    "fretfe match dovetail --edge left.right --rig rig.toml --against flat -o overlay",
)


def match(
    directory: Results,
    edge: Annotated[
        str,
        typer.Option(
            help="Edge of the component: CONTACT.left or CONTACT.right, of solids "
            "CONTACT.FRONT.STATION; CONTACT or CONTACT.FRONT for the worst one there."
        ),
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


STRENGTH_EXAMPLES = examples(
    "fretfe strength tests.csv dovetail --life 1e6",
    "fretfe strength tests.csv dovetail pad --life 2e5 -o map",
)


def strength(
    tests: Annotated[
        Path, typer.Argument(metavar="TESTS", help="CSV file with tests.", show_default=False)
    ],
    results: Annotated[
        list[Path],
        typer.Argument(metavar="DIR...", help="Folders with results.", show_default=False),
    ],
    life: Annotated[float, typer.Option(help="Cycles that the component has to reach.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Folder for figure and numbers; made if missing.",
            show_default=False,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:  # fmt: skip
    """Compare component edges with the strength of tests."""
    if rank_from_environment() > 0:
        return
    import json

    from rich.console import Console

    from fretfe.api import load_result, strength_map
    from fretfe.report.page.listings import print_whole
    from fretfe.strength.files import strength_numbers, write_map

    found = strength_map(tests, [load_result(each) for each in results], life)
    if as_json:
        print(json.dumps(strength_numbers(found), indent=1, allow_nan=False))
    else:
        console, shown = Console(), _shown(found)
        print_whole(_table(found, shown))
        for text in _texts(found, shown):
            console.print(text, highlight=False, markup=False, soft_wrap=True)
    if output is not None:
        files = write_map(found, output)
        if not as_json:
            names = " and ".join(path.name for path in files)
            Console().print(f"{names} in {output}", highlight=False, markup=False, soft_wrap=True)


def _shown(found: StrengthMap) -> list[Margin]:
    """All edges; of a front of solids the station with the smallest margin or largest ΔK."""
    fronts: dict[str, list[Margin]] = {}
    for each in found.margins:
        fronts.setdefault(each.edge.name, []).append(each)
    return [
        min(own, key=lambda each: (bool(each.reason), each.margin, -each.edge.k_t_range))
        for own in fronts.values()
    ]


def _table(found: StrengthMap, shown: Sequence[Margin]) -> Table:
    from rich.markup import escape

    from fretfe.report.page.listings import plain_table
    from fretfe.report.texts import MISSING, number, with_error

    units = found.tests.units
    k_n, k_t = f"{units.stress}/√{units.length}", f"{units.stress}·√{units.length}"
    title = escape(f"Strength at {found.life:g} cycles, K_N in {k_n}, ΔK_T in {k_t}")
    headers = ("edge", "K_N", "ΔK_T", "strength", "margin", "95 % of parts")
    table = plain_table(title, headers, text=1)
    for each in shown:
        edge = each.edge
        interval = f"{each.low:.3g} to {each.high:.3g}" if not each.reason else MISSING
        station = f" {edge.station}" if len(found.margins) > len(shown) else ""
        table.add_row(
            escape(edge.name) + station,
            with_error(edge.k_n, edge.k_n_spread),
            with_error(edge.k_t_range, edge.k_t_range_spread),
            with_error(each.strength, each.strength_spread),
            number(each.margin, 3),
            interval,
        )
    return table


def _texts(found: StrengthMap, shown: Sequence[Margin]) -> list[str]:
    """Fits, what is unknown and why, remarks; what several edges share once."""
    texts = []
    for fit in found.fits:
        c0, c1, c2 = fit.coefficients
        texts.append(
            f"log10 N = {c0:.4g} {c1:+.3g} log10 ΔK_T {c2:+.3g} log10 K_N, scatter "
            f"{fit.scatter:.2g}, from {fit.failures} failures and {fit.runouts} run-outs"
        )
    said: dict[str, list[str]] = {}
    for each in shown:
        if each.reason:
            said.setdefault(f"unknown, because {each.reason}", []).append(each.edge.name)
        if each.tests and each.tests < len(found.tests.life):
            text = f"{each.tests} of {len(found.tests.life)} tests have its friction and material"
            said.setdefault(text, []).append(each.edge.name)
        for remark in each.edge.remarks:
            said.setdefault(remark, []).append(each.edge.name)
    for result in found.without_edges:
        said.setdefault("the result has no edges whose factors are known", []).append(result)
    return texts + [f"Note: {', '.join(names)}: {text}" for text, names in said.items()]
