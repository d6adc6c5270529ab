# SPDX-License-Identifier: LGPL-3.0-or-later
"""Benchmarks, the one comparison that every number goes through, and rows for all readers."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table

from fretfe.case import Case
from fretfe.console import Console
from fretfe.environment import versions
from fretfe.results.model import Result
from fretfe.verdict import Verdict

# Reads one number from what a backend returned.
Measure = Callable[[Result], float]
FAILURES = (Verdict.DIFFERS, Verdict.FAILED, Verdict.NOT_CAUGHT)
SCHEMA = {"name": "fretfe-verify", "version": 2}
TEXTS = ("quantity", "backend")
NUMBERS = ("computed", "reference", "difference", "tolerance")


@dataclass(frozen=True)
class Averaged:
    """A mean of numbers that have error bars.

    Attributes:
        numbers: finds numbers and bars in the results of a backend.
    """

    numbers: Callable[[Result], Sequence[tuple[float, float]]]

    def __call__(self, result: Result) -> float:
        """The mean."""
        return float(np.mean([value for value, _ in self.numbers(result)]))

    def spread(self, result: Result) -> float:
        """The mean of the bars: what errors that all numbers share make of the mean."""
        return float(np.mean([spread for _, spread in self.numbers(result)]))


@dataclass(frozen=True)
class Quantity:
    """One number with a known value.

    Attributes:
        name: what it is.
        reference: its known value.
        scale: what differences and tolerances are fractions of.
        tolerances: largest difference by backend, as a fraction of the scale. A backend that is not
            named here is held to the widest of them.
        measure: finds the number in the results of a backend.
        of_twin: finds the known value in the results of the benchmark's twin; it is the scale too.
    """

    name: str
    reference: float
    scale: float
    tolerances: Mapping[str, float]
    measure: Measure
    of_twin: Measure | None = None

    def against(self, twin: Result | None) -> Quantity:
        """The quantity with its known value, if that is one of the twin's."""
        if twin is None or self.of_twin is None:
            return self
        known = self.of_twin(twin)
        return replace(self, reference=known, scale=abs(known))

    def tolerance(self, backend: str) -> float:
        """Largest difference that a backend may have, as a fraction of the scale."""
        return self.tolerances.get(backend, max(self.tolerances.values()))


@dataclass(frozen=True)
class Benchmark:
    """A case and the known values of some of its numbers.

    Attributes:
        name: of the benchmark.
        source: where the known values come from.
        case: what a backend solves.
        quantities: what is compared.
        control: whether something was spoilt on purpose, so that every comparison has to fail.
        twin: a case with the same answer, which the backend solves too; its numbers are then what
            is known.
    """

    name: str
    source: str
    case: Case
    quantities: tuple[Quantity, ...]
    control: bool = False
    twin: Case | None = None


@dataclass(frozen=True)
class Row:
    """One comparison, or why there is none; numbers that do not exist are None.

    Attributes:
        benchmark, quantity, backend: what was compared.
        computed, reference: the two values.
        difference: (computed - reference)/scale.
        tolerance: largest absolute difference, as a fraction of the scale.
        verdict: of the comparison, or of a negative control.
        reason: why it was skipped, what failed, or what caught the control.
        spread: error bar of the computed value.
    """

    benchmark: str
    quantity: str
    backend: str
    computed: float | None
    reference: float | None
    difference: float | None
    tolerance: float | None
    verdict: Verdict
    reason: str = ""
    spread: float | None = None

    @property
    def failed(self) -> bool:
        """True if this row alone makes the verification fail."""
        return self.verdict in FAILURES


def remark(benchmark: str, backend: str, verdict: Verdict, reason: str, quantity: str = "") -> Row:
    """A row without numbers."""
    return Row(benchmark, quantity, backend, None, None, None, None, verdict, reason)


def compare(benchmark: str, quantity: Quantity, backend: str, result: Result) -> Row:
    """Compare one number of a result with its known value; on rank 0."""
    measure = quantity.measure
    computed = measure(result)
    difference = (computed - quantity.reference) / quantity.scale
    tolerance = quantity.tolerance(backend)
    known = math.isfinite(difference)
    spread = measure.spread(result) if isinstance(measure, Averaged) else math.nan
    agrees = known and abs(difference) <= tolerance
    return Row(
        benchmark=benchmark,
        quantity=quantity.name,
        backend=backend,
        computed=computed if known else None,
        reference=quantity.reference,
        difference=difference if known else None,
        tolerance=tolerance,
        verdict=Verdict.AGREES if agrees else Verdict.DIFFERS,
        reason="" if known else "the backend found no value",
        spread=spread if math.isfinite(spread) else None,
    )


def failed(rows: tuple[Row, ...]) -> bool:
    """True if a verification failed: one row did, or nothing was compared at all."""
    return any(row.failed for row in rows) or all(row.verdict is Verdict.SKIPPED for row in rows)


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
    # Long names take several lines where the terminal is narrow.
    for header in TEXTS:
        table.add_column(header, no_wrap=header == "backend", overflow="fold")
    for header in NUMBERS:
        table.add_column(header, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for row in rows:
        if row.reference is not None:
            computed = "-" if row.computed is None else f"{row.computed:.5g}"
            difference = "-" if row.difference is None else f"{row.difference:+.1e}"
            cells = (computed, f"{row.reference:.5g}", difference, f"{row.tolerance:.1e}")
            table.add_row(row.quantity, row.backend, *cells, row.verdict, style=_style(row))
    return table


def _style(row: Row) -> str:
    return "bold red" if row.failed else "dim" if row.verdict is Verdict.SKIPPED else ""


def print_summary(console: Console, rows: Sequence[Row], seconds: Mapping[str, float]) -> None:
    """Numbers of rows by verdict, and the time of each backend."""
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
    return any(row.verdict is not Verdict.SKIPPED for row in rows)


def as_numbers(rows: Sequence[Row], seconds: Mapping[str, float]) -> dict[str, Any]:
    """Everything in plain Python types; see docs/verify.md."""
    return {
        "schema": SCHEMA,
        "passed": not failed(tuple(rows)),
        "versions": versions(),
        "seconds": dict(seconds),
        "rows": [asdict(row) for row in rows],
    }
