# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows for people and for programs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from fretfe.environment import versions
from fretfe.quality.verify.model import FAILURES, Benchmark, Row, failed

SCHEMA = {"name": "fretfe-verify", "version": 1}
TEXTS, NUMBERS = ("quantity", "backend"), ("computed", "reference", "difference", "tolerance")


def print_rows(console: Console, benchmark: Benchmark, rows: Sequence[Row]) -> None:
    """A table of one benchmark, one row for each comparison; reasons below it."""
    console.print(f"[bold]{escape(benchmark.name)}[/bold] ({escape(benchmark.source)})")
    if any(row.reference is not None for row in rows):
        console.print(_table(rows))
    for row in rows:
        if row.reference is None:
            where = " ".join(filter(None, (row.backend, row.quantity)))
            text = f"  {where}: {row.verdict}: {row.reason}"
            console.print(text, style=_style(row), highlight=False, markup=False)
    console.print()


def _table(rows: Sequence[Row]) -> Table:
    table = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
    for header in TEXTS:
        table.add_column(header, no_wrap=True)
    for header in NUMBERS:
        table.add_column(header, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for row in rows:
        if row.reference is not None:
            computed = "-" if row.computed is None else f"{row.computed:.6g}"
            difference = "-" if row.difference is None else f"{row.difference:+.1e}"
            cells = (computed, f"{row.reference:.6g}", difference, f"{row.tolerance:.1e}")
            table.add_row(row.quantity, row.backend, *cells, row.verdict, style=_style(row))
    return table


def _style(row: Row) -> str:
    return "bold red" if row.failed else "dim" if row.verdict == "skipped" else ""


def print_summary(console: Console, rows: Sequence[Row], seconds: Mapping[str, float]) -> None:
    """How many rows have which verdict, and how long each backend took."""
    counts = Counter(row.verdict for row in rows)
    text = ", ".join(f"{number} {verdict}" for verdict, number in counts.items())
    times = ", ".join(f"{name} {value:.1f} s" for name, value in seconds.items())
    console.print(f"{text}; {times}", highlight=False)
    for row in rows:
        if row.verdict in FAILURES:
            where = ", ".join(filter(None, (row.benchmark, row.quantity, row.backend)))
            console.print(f"{row.verdict}: {where}", style=_style(row), highlight=False)
    if failed(tuple(rows)):
        console.print("The verification failed." if _compared(rows) else "Nothing was verified.")


def _compared(rows: Sequence[Row]) -> bool:
    return any(row.verdict != "skipped" for row in rows)


def as_numbers(rows: Sequence[Row], seconds: Mapping[str, float]) -> dict[str, Any]:
    """Everything in plain Python types; see docs/verify.md."""
    return {
        "schema": SCHEMA,
        "passed": not failed(tuple(rows)),
        "versions": versions(),
        "seconds": dict(seconds),
        "rows": [asdict(row) for row in rows],
    }
