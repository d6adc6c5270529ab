# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command that turns stress into a decision: `fretfe assess`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import AsJson, Results, examples
from fretfe.environment import rank_from_environment
from fretfe.report.texts import MISSING, number, percent, plain_table, print_whole, rounded

if TYPE_CHECKING:
    from rich.table import Table

    from fretfe.decision.assess import Assessment, EdgeAssessment, Judgement

ASSESS_EXAMPLES = examples(
    "fretfe assess dovetail --material alloy.toml",
    "fretfe assess dovetail --material alloy.toml --tests tests.csv --life 1e6",
)


def assess(
    directory: Results,
    material: Annotated[
        Path, typer.Option(help="Material file (TOML) with a table [fatigue].", show_default=False)
    ],
    tests: Annotated[
        Path | None, typer.Option(help="CSV file with fretting tests.", show_default=False)
    ] = None,
    life: Annotated[
        float | None,
        typer.Option(help="Cycles that the tests are asked for.", show_default=False),
    ] = None,
    at_least: Annotated[
        float | None,
        typer.Option(
            help="End with exit code 1 if the smallest margin is less, or unknown.",
            show_default=False,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Judge plane edges by tests, arrest of cracks and endurance."""
    if rank_from_environment() > 0:
        return
    import json

    from fretfe.api import assess as judge
    from fretfe.api import load_result
    from fretfe.decision.assess import assessment_numbers

    found = judge(load_result(directory), material, tests, life)
    if as_json:
        print(json.dumps(assessment_numbers(found), indent=1, allow_nan=False))
    else:
        print_whole(_table(found))
        for text in _texts(found):
            print(text)
    if at_least is not None and not (found.worst and found.worst[1].margin >= at_least):
        raise typer.Exit(1)


def _table(found: Assessment) -> Table:
    """Margins of all edges, those side by side that are known somewhere."""
    from rich.markup import escape

    from fretfe.decision.assess import Criterion

    shown = [each for each in Criterion if any(not edge.of(each).reason for edge in found.edges)]
    title = escape(f"Margins of {found.result} by {found.material.name}")
    headers = ("edge", "body", *(each.value for each in shown), "governs")
    table = plain_table(title, headers, text=2)
    for edge in found.edges:
        governing = edge.governing
        table.add_row(
            escape(f"{edge.contact} {edge.edge}"),
            escape(edge.body),
            *(_margin(edge.of(each)) for each in shown),
            MISSING if governing is None else governing.criterion.value,
        )
    return table


def _margin(judgement: Judgement) -> str:
    if judgement.reason:
        return MISSING
    return "∞" if math.isinf(judgement.margin) else rounded(judgement.margin)


def _texts(found: Assessment) -> Iterator[str]:
    """The worst edge, cracks, what is unknown and why, remarks; what several edges share once."""
    yield _verdict(found)
    said: dict[str, list[str]] = {}
    for edge in found.edges:
        name = f"{edge.contact} {edge.edge} {edge.body}"
        for text in (*_cracks(edge), *_unknown(edge)):
            said.setdefault(text, []).append(name)
    for text, names in said.items():
        everywhere = len(names) == len(found.edges)
        yield text if everywhere else f"{', '.join(names)}: {text}"
    if math.isfinite(found.length):
        yield f"Critical distance L = {rounded(found.length)}, from: {found.source}"
    yield from (f"Note: {text}" for text in found.remarks)


def _verdict(found: Assessment) -> str:
    if found.worst is None:
        return "Nothing is known of any edge"
    edge, judgement = found.worst
    at = "" if math.isnan(judgement.place) else f", {_place(judgement.place)}"
    sure = "" if math.isnan(judgement.low) else (
        f" ({rounded(judgement.low)} to {rounded(judgement.high)} by its error bars)"
    )  # fmt: skip
    return (
        f"Worst is {edge.contact} {edge.edge}, {edge.body}{at}: margin {_margin(judgement)}{sure} "
        f"by {judgement.criterion.value}"
    )


def _place(place: float) -> str:
    if place == 0:
        return "at the edge"
    return f"{rounded(abs(place))} {'inside' if place > 0 else 'outside'} of the edge"


def _cracks(edge: EdgeAssessment) -> Iterator[str]:
    """Start, arrest and life of cracks, in words."""
    arrest = edge.arrest
    if arrest is None:
        return
    start = "∞" if math.isinf(arrest.start) else rounded(arrest.start)
    if arrest.length == 0:
        yield f"no crack starts, up to {start} times the stress"
    elif math.isinf(arrest.length):
        yield (
            f"a crack at {arrest.angle:g}° grows through {rounded(arrest.longest)}, as far as the "
            "stress is known"
        )
    else:
        yield f"cracks start and stop, at {arrest.angle:g}° after {rounded(arrest.length)}"
    if math.isfinite(edge.life):
        yield f"{number(edge.life, 2)} cycles between the lengths of fatigue.growth"


def _unknown(edge: EdgeAssessment) -> Iterator[str]:
    """Reasons for what is unknown, each with its criteria."""
    reasons: dict[str, list[str]] = {}
    for each in edge.judgements:
        if each.reason:
            reasons.setdefault(each.reason, []).append(each.criterion.value)
    yield from (f"Unknown ({'; '.join(names)}): {text}" for text, names in reasons.items())
    if edge.bar > 0.1:
        yield f"the stress is known to {percent(edge.bar, 0)} only: refine at the edge"
