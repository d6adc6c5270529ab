# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands that exchange numbers with other programs: `edges`, `compare`, `export`, `submodel`."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fretfe.cli.options import AsJson, Results, TrustGeo, decimal, examples, positive
from fretfe.environment import rank_from_environment
from fretfe.errors import CaseError
from fretfe.files import json_value
from fretfe.report.texts import (
    MISSING,
    marked,
    number,
    percent,
    plain_table,
    print_whole,
    with_error,
)

if TYPE_CHECKING:
    from rich.table import Table

    from fretfe.evaluate import EdgeAnalysis, Estimate, TractionAnalysis
    from fretfe.exchange.comparison import Comparison
    from fretfe.exchange.submodel import Submodel
    from fretfe.exchange.traction_file import TractionTable
    from fretfe.results.model import Result


class Sign(StrEnum):
    """Of a normal stress in compression."""

    POSITIVE = "positive"
    NEGATIVE = "negative"


# What is found at an edge, by the name of its attribute.
EDGE_ROWS = {
    "position": "position",
    "k_n": "K_N",
    "slip_from_slip": "slip zone, from slip",
    "slip_from_traction": "slip zone, from |q| = f p",
}

EDGES_EXAMPLES = examples(
    "fretfe edges tractions.csv --friction 0.6",
    "fretfe edges abaqus.csv --friction 0.6",
    "fretfe edges tractions.csv --x arc --p pressure --q shear --json",
)


def edges(
    table: Annotated[Path, typer.Argument(help="CSV file with a header.", show_default=False)],
    friction: Annotated[
        float | None, typer.Option(parser=decimal, help="Friction coefficient.")
    ] = None,
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
    from fretfe.console import Console
    from fretfe.errors import CaseError
    from fretfe.evaluate import analyse_tractions
    from fretfe.exchange.traction_columns import Columns
    from fretfe.exchange.traction_file import read_tractions

    read = read_tractions(table, Columns(x, p, q, slip), compression)
    try:
        analysis = analyse_tractions(read.x, read.p, read.q, read.slip, friction)
    except ValueError as error:
        raise CaseError(f"{table}: {error}") from None
    if as_json:
        numbers = _edges_numbers(table, friction, read, analysis)
        print(json.dumps(numbers, indent=1, allow_nan=False))
        return
    console = Console()
    for note in read.notes:
        console.print(f"Columns: {note}", highlight=False, markup=False)
    print_whole(_edge_table(analysis))
    console.print(_resultant_text(analysis), highlight=False)
    for remark in _remarks(analysis):
        console.print(remark, highlight=False, markup=False)


def _edge_table(analysis: TractionAnalysis) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(title="Edges", title_justify="left", box=box.SIMPLE, title_style="bold")
    table.add_column("")
    for edge in analysis.edges:
        table.add_column(edge.side, justify="right", no_wrap=True)
    for key, text in EDGE_ROWS.items():
        table.add_row(text, *(_with_error(getattr(edge, key)) for edge in analysis.edges))
    return table


def _with_error(estimate: Estimate) -> str:
    """Value and error; - if it is not known, ~ before it if there is a remark."""
    text = with_error(estimate.value, estimate.spread)
    return marked(text, bool(estimate.remark)) if estimate.known else MISSING


def _resultant_text(analysis: TractionAnalysis) -> str:
    forces = analysis.resultants
    shear = "-" if math.isnan(forces.shear_force) else f"{forces.shear_force:.6g}"
    return (
        f"P = {forces.normal_force:.6g}, Q = {shear}, M = {forces.moment:.6g} about "
        f"x = {analysis.centre:.6g}"
    )


def _remarks(analysis: TractionAnalysis) -> list[str]:
    """One line for each thing that is not known or uncertain, then those on the contact."""
    remarks: dict[str, list[str]] = {}
    for key, text in EDGE_ROWS.items():
        for edge in analysis.edges:
            remark = getattr(edge, key).remark
            if remark:
                remarks.setdefault(f"{text}: {remark}", []).append(edge.side)
    lines = [
        f"Note: {text}" + ("" if len(sides) == 2 else f" ({sides[0]} edge)")
        for text, sides in remarks.items()
    ]
    return lines + [f"Note: {remark}" for remark in analysis.remarks]


def _edges_numbers(
    path: Path, friction: float | None, table: TractionTable, analysis: TractionAnalysis
) -> dict[str, Any]:
    forces = json_value(asdict(analysis.resultants))
    return {
        "schema": {"name": "fretfe-edges", "version": 1},
        "file": str(path),
        "friction": friction,
        "columns": table.columns,
        **forces,
        "centre": analysis.centre,
        "edges": [_edge_numbers(edge) for edge in analysis.edges],
        "remarks": [*table.notes, *analysis.remarks],
    }


def _edge_numbers(edge: EdgeAnalysis) -> dict[str, Any]:
    def numbers(estimate: Estimate) -> dict[str, Any]:
        value, spread = json_value(estimate.value), json_value(estimate.spread)
        return {"value": value, "spread": spread, "remark": estimate.remark}

    return {"side": edge.side} | {key: numbers(getattr(edge, key)) for key in EDGE_ROWS}


COMPARE_EXAMPLES = examples(
    "fretfe compare pad pad_fine", "fretfe compare pad pad_fine -o difference"
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

    from fretfe import api
    from fretfe.exchange.comparison_files import comparison_numbers, write_comparison

    comparison = api.compare(api.load_result(first), api.load_result(second))
    if as_json:
        print(json.dumps(comparison_numbers(comparison), indent=1, allow_nan=False))
    else:
        _print_comparison(comparison)
    if output is not None:
        files = write_comparison(comparison, output)
        if not as_json:
            names = ", ".join(path.name for path in files)
            print(f"{names} in {output}")


def _print_comparison(comparison: Comparison) -> None:
    import numpy as np

    print_whole(_comparison_table(comparison))
    for each in comparison.tractions:
        print(
            f"{each.contact}, {each.extreme}: p differs by {percent(each.pressure_difference)}, "
            f"q by {percent(each.shear_difference)} of f p (root mean square)"
        )
    for history in comparison.histories:
        place = " ".join(filter(None, (history.contact, history.edge)))
        differs = (
            f"differs by {percent(history.difference)} at most at {history.common} common times"
            if history.common
            else "has no common times"
        )
        # Without contact there is no value.
        value = number(float(np.nanmax(abs(history.first), initial=0.0)))
        print(f"{place}: {history.quantity} over time ({value} {history.unit}) {differs}")
    for note in comparison.notes:
        print(f"Note: {note}")


def _comparison_table(comparison: Comparison) -> Table:
    from rich.markup import escape

    from fretfe.verdict import Verdict

    labels = [escape(label) for label in comparison.labels]
    headers = ("", "", *labels, "difference", "verdict")
    table = plain_table("Comparison", headers, text=2)
    for each in comparison.quantities:
        difference = percent(each.difference)
        if each.verdict is not Verdict.UNKNOWN:
            difference += f" ± {percent(each.difference_spread)}"
        table.add_row(
            " ".join(filter(None, (each.contact, each.edge))),
            f"{each.quantity} {escape(f'[{each.unit}]')}",
            with_error(each.first, each.first_spread),
            with_error(each.second, each.second_spread),
            difference, each.verdict,
        )  # fmt: skip
    return table


EXPORT_EXAMPLES = examples(
    "fretfe export pad -o pad_csv", "fretfe export pad -o pad_csv --depth 0.05 --depth 0.1"
)


def export(
    results: Results,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for the tables; made if missing.")
    ],
    fatemi_socie: Annotated[
        tuple[float, float] | None,
        typer.Option(
            parser=decimal,
            metavar="K YIELD",
            help="k and yield stress of Fatemi and Socie; for runs with [output] stress_depths.",
            show_default=False,
        ),
    ] = None,
    depth: Annotated[
        list[float] | None,
        typer.Option(
            parser=decimal,
            help="Distance from edges and stations at which the history of the stress is written; "
            "can be given several times.",
            show_default=False,
        ),
    ] = None,
    angle: Annotated[
        list[float] | None,
        typer.Option(
            parser=decimal,
            help="Of these places from the inward normal, -80 to 80 degrees, positive under the "
            "contact; likewise.",
            show_default="0",
        ),
    ] = None,
) -> None:
    """Write the numbers of a run as CSV files."""
    if rank_from_environment() > 0:
        return
    from fretfe.api import load_result
    from fretfe.console import Console
    from fretfe.decision.stress_histories import (
        edge_histories,
        history_table,
        parameter_table,
        write_histories,
    )
    from fretfe.exchange.export import export_result

    if angle and not depth:
        raise CaseError("--angle: expected --depth beside it, found none")
    result = load_result(results)
    histories = edge_histories(result, depth, angle or [0.0]) if depth else ()
    more = (
        [history_table(result, histories), parameter_table(result, histories, fatemi_socie)]
        if histories
        else []
    )
    console = Console()
    for each in export_result(result, output, fatemi_socie, more):
        rows = f"{each.rows} row{'s' if each.rows != 1 else ''}"
        print(f"{each.path}: {rows}")
    if histories:
        print(write_histories(result, histories, output))
    for history in histories:
        if history.reason:
            name = f"{history.contact} {history.edge} {history.body}".rstrip()
            console.print(f"Note: {name}: {history.reason}", markup=False, highlight=False)
    if result.failure is not None:
        console.print(f"Note: the run is not complete: {result.failure}", markup=False)


SUBMODEL_EXAMPLES = examples(
    "fretfe run dovetail.toml -o global --set output.fields=all",
    "fretfe submodel global --around left --radius 6 -o flank",
    "fretfe run flank/submodel.toml -o fine",
)


def submodel(
    results: Results,
    around: Annotated[
        str,
        typer.Option(
            help="CONTACT, or an edge: CONTACT.left or CONTACT.right, of solids "
            "CONTACT.FRONT.STATION, CONTACT.FRONT for the worst one there, CONTACT.FRONT.start and "
            "CONTACT.FRONT.end for its free ends."
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Folder for the case; made if missing. With --run: ends/END in that of the run.",
            show_default=False,
        ),
    ] = None,
    radius: Annotated[
        float | None,
        typer.Option(
            parser=positive,
            help="Radius of the part.",
            show_default="3 times the distance of the contact's edges, at a free end that to the "
            "middle of the contact",
        ),
    ] = None,
    size: Annotated[
        float | None,
        typer.Option(
            parser=positive,
            help="Size of the elements at contact edges.",
            show_default="a quarter of the run's, at a free end half or 1/1.4",
        ),
    ] = None,
    solve: Annotated[
        bool,
        typer.Option("--run", help="Around a free end: solve the part, and say what is there."),
    ] = False,
    length: Annotated[
        float | None,
        typer.Option(
            parser=positive, help="Of the front next to the end.", show_default="2 slip zones"
        ),
    ] = None,
    trust_geo: TrustGeo = False,
) -> None:
    """Write the case of a part of a solved case, with finer elements.

    The displacements of the run, which has to keep those of all steps, move its cuts.
    """
    if rank_from_environment() > 0 and not solve:
        return
    from fretfe.api import load_result
    from fretfe.exchange.submodel import told, write_submodel
    from fretfe.results.writer import ANSWER, ENDS

    folder = output or results / ENDS / around
    if output is None and not solve:
        raise CaseError("--output: expected a folder for the case, found none")

    def write(result: Result) -> Submodel:
        found = write_submodel(result, around, folder, radius, size, trust_geo=trust_geo)
        for line in told(found, result.case.units.length):
            print(line)
        for case in found.cases:
            print(f"Case {case.source}", flush=True)
        return found

    if not solve:
        write(load_result(results))
        return
    from fretfe.cli.progress import StepReport
    from fretfe.report.page.ends import end_lines, end_table
    from fretfe.runner import Runner

    runner = Runner.find("fem")
    if runner.processes.idle:
        return
    with StepReport(runner.processes.rank, steps=False) as shown:
        answer = runner.solve_end(results, write, length, shown)
    if runner.processes.rank == 0:
        run = load_result(results)
        for line in end_lines(run, answer):
            print(line)
        print_whole(end_table(run, answer))
        print(folder / ANSWER)
