# SPDX-License-Identifier: LGPL-3.0-or-later
"""A validation as a table and as plain data."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from fretfe.quality.validate.rows import Row
from fretfe.quality.validate.run import Validation


def print_validation(console: Console, validation: Validation) -> None:
    """Print a line per row, the reasons they refer to by number, and the summary."""
    reasons = list(dict.fromkeys(row.reason for row in validation.rows))
    table = Table(title="Validation", title_justify="left", box=box.SIMPLE, title_style="bold")
    table.pad_edge = False
    table.padding = (0, 1, 0, 0)
    for header in ("where", "quantity"):
        table.add_column(header, no_wrap=True)
    for header in ("value", "reference", "difference", "tolerance", "why"):
        table.add_column(header, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for row in validation.rows:
        numbers = (row.value, row.reference, row.difference, row.tolerance)
        names = map(escape, (row.where, row.quantity))
        why = str(reasons.index(row.reason) + 1)
        table.add_row(*names, *map(_number, numbers), why, row.verdict)
    console.print(table)
    for number, reason in enumerate(reasons, start=1):
        console.print(f"{number:3d}. {reason}", highlight=False, markup=False)
    console.print(summary(validation), highlight=False)


def summary(validation: Validation) -> str:
    """Numbers of rows by verdict, and their meaning."""
    counts = {
        verdict: sum(row.verdict == verdict for row in validation.rows)
        for verdict in ("pass", "FAIL", "outside", "depends", "unknown", "-")
    }
    text = (
        f"{counts['pass']} agree, {counts['FAIL']} fail, {counts['outside']} outside the range of "
        f"a formula, {counts['depends']} depend on the start, {counts['-']} not applicable."
    )
    if counts["unknown"]:
        return (
            f"{text} {counts['unknown']} unknown: nothing can be said of this case before they are "
            "known."
        )
    if counts["FAIL"]:
        return f"{text} Do not use these numbers before the failures are understood."
    if counts["outside"]:
        return f"{text} Use the computed numbers where a formula is outside its range."
    if not counts["pass"]:
        return f"{text} Nothing was compared."
    return f"{text} The edge description holds for this case."


def as_numbers(validation: Validation) -> dict[str, Any]:
    """The rows in plain types; numbers that do not exist are None."""
    return {
        "schema": {"name": "fretfe-validation", "version": 1},
        "passed": validation.passed,
        "rows": [_plain(row) for row in validation.rows],
    }


def _plain(row: Row) -> dict[str, Any]:
    values = {**asdict(row), "difference": row.difference}
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in values.items()
    }


def _number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "-"
