# SPDX-License-Identifier: LGPL-3.0-or-later
"""Negative controls: benchmarks that are spoilt on purpose and have to fail.

A comparison that accepts one of them would accept anything. They go through the same comparison as
all the others, with the known values of the unspoilt loop.
"""

from __future__ import annotations

from dataclasses import replace

from fretfe.case import Case
from fretfe.quality.verify.loops import (
    FRICTION,
    LAGGING,
    TENSION_ONLY,
    factor_ranges,
    loop_case,
    slip_lengths,
)
from fretfe.quality.verify.measures import LEFT, RIGHT
from fretfe.quality.verify.model import Benchmark, Measure, Quantity, Row, remark
from fretfe.results.model import Result


def controls() -> tuple[Benchmark, ...]:
    """All negative controls."""
    wrong_sign = replace(LAGGING, tension=-LAGGING.tension)
    first_loading = tuple(
        replace(quantity, measure=_first_loading_law(side))
        for side, quantity in zip((LEFT, RIGHT), slip_lengths(LAGGING), strict=True)
    )
    return (
        # Without friction a shear force would move the pad away: this loop has none.
        _control(
            "no friction",
            loop_case(TENSION_ONLY, friction=0.0),
            (*slip_lengths(TENSION_ONLY), *factor_ranges(TENSION_ONLY)),
        ),
        _control("tension of the wrong sign", loop_case(wrong_sign), slip_lengths(LAGGING)),
        _control("law of first loading in a cycle", loop_case(LAGGING), first_loading),
    )


def _control(name: str, case: Case, quantities: tuple[Quantity, ...]) -> Benchmark:
    source = "spoilt on purpose: every comparison has to fail"
    return Benchmark(f"control: {name}", source, case, quantities, control=True)


def _first_loading_law(side: int) -> Measure:
    """2 ΔK_T/(f K_N) in place of the slip length that the backend found."""

    def measure(result: Result) -> float:
        station = result.contacts[0].stations[side]
        return float(2 * station.k_t_range / (FRICTION * station.k_n[-1]))

    return measure


def judge(rows: tuple[Row, ...]) -> Row:
    """The verdict on a control from its comparisons, at least one."""
    first = rows[0]
    accepted = [row.quantity for row in rows if row.verdict != "fail"]
    if accepted:
        reason = f"accepted: {', '.join(accepted)}"
        return remark(first.benchmark, first.backend, "NOT CAUGHT", reason)
    found = ", ".join(
        f"{row.quantity} {'-' if row.computed is None else f'{row.computed:.4g}'} "
        f"for {row.reference:.4g}"
        for row in rows
    )
    return remark(first.benchmark, first.backend, "caught", found)
