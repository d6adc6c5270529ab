# SPDX-License-Identifier: LGPL-3.0-or-later
"""Texts and numbers of `fretfe edges`: a CSV file of tractions in, edge factors out."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from fretfe.errors import CaseError
from fretfe.evaluate import EdgeAnalysis, Estimate, TractionAnalysis, analyse_tractions
from fretfe.exchange.sign import Sign
from fretfe.exchange.traction_file import Columns, TractionTable, read_tractions
from fretfe.report.texts import MISSING, with_error

ROWS = {
    "position": "position",
    "k_n": "K_N",
    "slip_from_slip": "slip zone, from slip",
    "slip_from_traction": "slip zone, from |q| = f p",
}


def analyse_file(
    path: Path,
    columns: Columns,
    friction: float | None,
    compression: Sign | None,
    *,
    as_json: bool,
) -> None:
    """Print what the tractions in a CSV file tell about the edges of the contact.

    Args:
        path: the file.
        columns: names of its columns that the user gives.
        friction: coefficient f, or None.
        compression: sign of a pressure in the file, or None.
        as_json: print one JSON document in place of tables.

    Raises:
        CaseError: if the file is not as expected, nothing is in contact or f is not positive.
    """
    table = read_tractions(path, columns, compression)
    try:
        analysis = analyse_tractions(table.x, table.p, table.q, table.slip, friction)
    except ValueError as error:
        raise CaseError(f"{path}: {error}") from None
    if as_json:
        print(json.dumps(_as_numbers(path, friction, table, analysis), indent=1, allow_nan=False))
        return
    console = Console()
    for note in table.notes:
        console.print(f"Columns: {note}", highlight=False, markup=False)
    console.print(_edge_table(analysis))
    console.print(_resultant_text(analysis), highlight=False)
    for remark in _remarks(analysis):
        console.print(remark, highlight=False, markup=False)


def _edge_table(analysis: TractionAnalysis) -> Table:
    table = Table(title="Edges", title_justify="left", box=box.SIMPLE, title_style="bold")
    table.add_column("")
    for edge in analysis.edges:
        table.add_column(edge.side, justify="right", no_wrap=True)
    for key, text in ROWS.items():
        table.add_row(text, *(_with_error(getattr(edge, key)) for edge in analysis.edges))
    return table


def _with_error(estimate: Estimate) -> str:
    """Value and error; - if it is not known, ~ before it if there is a remark."""
    if not estimate.known:
        return MISSING
    return ("~" if estimate.remark else "") + with_error(estimate.value, estimate.spread)


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
    for key, text in ROWS.items():
        for edge in analysis.edges:
            remark = getattr(edge, key).remark
            if remark:
                remarks.setdefault(f"{text}: {remark}", []).append(edge.side)
    lines = [
        f"Note: {text}" + ("" if len(sides) == 2 else f" ({sides[0]} edge)")
        for text, sides in remarks.items()
    ]
    return lines + [f"Note: {remark}" for remark in analysis.remarks]


def _as_numbers(
    path: Path, friction: float | None, table: TractionTable, analysis: TractionAnalysis
) -> dict[str, Any]:
    forces = {name: _number(value) for name, value in asdict(analysis.resultants).items()}
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
        value, spread = _number(estimate.value), _number(estimate.spread)
        return {"value": value, "spread": spread, "remark": estimate.remark}

    return {"side": edge.side} | {key: numbers(getattr(edge, key)) for key in ROWS}


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
