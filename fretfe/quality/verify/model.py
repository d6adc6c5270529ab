# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a benchmark is, and the one comparison that every number goes through."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from fretfe.case import Case
from fretfe.results.model import Result

# Reads one number from what a backend returned.
Measure = Callable[[Result], float]
Verdict = Literal["pass", "fail", "skipped", "caught", "NOT CAUGHT"]
FAILURES: tuple[Verdict, ...] = ("fail", "NOT CAUGHT")


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
        needs_tractions: whether that takes tractions, which not every backend has.
    """

    name: str
    reference: float
    scale: float
    tolerances: Mapping[str, float]
    measure: Measure
    needs_tractions: bool = False

    def tolerance(self, backend: str) -> float:
        """Largest difference that a backend may have, as a fraction of the scale."""
        return self.tolerances.get(backend, max(self.tolerances.values()))


@dataclass(frozen=True)
class Benchmark:
    """A case and the known values of some of its numbers.

    Attributes:
        name: of the benchmark.
        source: where the known values come from.
        case: what a backend solves; None if there is none, for the reason in `left_out`.
        quantities: what is compared.
        left_out: why it is not run at all; empty if it is.
        control: whether something was spoilt on purpose, so that every comparison has to fail.
    """

    name: str
    source: str
    case: Case | None
    quantities: tuple[Quantity, ...]
    left_out: str = ""
    control: bool = False


@dataclass(frozen=True)
class Row:
    """One comparison, or why there is none; numbers that do not exist are None.

    Attributes:
        benchmark, quantity, backend: what was compared.
        computed, reference: the two values.
        difference: (computed - reference)/scale.
        tolerance: largest absolute difference, as a fraction of the scale.
        verdict: "pass" or "fail"; "skipped" with a reason; of a negative control "caught" or
            "NOT CAUGHT".
        reason: why it was skipped, what failed, or what caught the control.
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

    @property
    def failed(self) -> bool:
        """Whether this row alone makes the verification fail."""
        return self.verdict in FAILURES


def remark(benchmark: str, backend: str, verdict: Verdict, reason: str, quantity: str = "") -> Row:
    """A row without numbers."""
    return Row(benchmark, quantity, backend, None, None, None, None, verdict, reason)


def compare(benchmark: str, quantity: Quantity, backend: str, result: Result) -> Row:
    """Compare one number of a result with its known value; on rank 0."""
    if quantity.needs_tractions and result.solution is None:
        reason = "the backend gives no tractions"
        return remark(benchmark, backend, "skipped", reason, quantity.name)
    computed = quantity.measure(result)
    difference = (computed - quantity.reference) / quantity.scale
    tolerance = quantity.tolerance(backend)
    known = math.isfinite(difference)
    return Row(
        benchmark=benchmark,
        quantity=quantity.name,
        backend=backend,
        computed=computed if known else None,
        reference=quantity.reference,
        difference=difference if known else None,
        tolerance=tolerance,
        verdict="pass" if known and abs(difference) <= tolerance else "fail",
        reason="" if known else "the backend found no value",
    )


def failed(rows: tuple[Row, ...]) -> bool:
    """Whether a verification failed: one row did, or nothing was compared at all."""
    return any(row.failed for row in rows) or all(row.verdict == "skipped" for row in rows)
