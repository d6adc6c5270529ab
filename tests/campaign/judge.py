# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of the campaign against what they should be: right, flagged or silently wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from campaign.draw import BODY, Draw, case_of

from fretfe.case import parse_case
from fretfe.errors import FretfeError

Verdict = Literal["right", "flagged", "wrong"]
# Steps in a cycle of the runs that give the answers: closed forms, then half-planes.
CLOSED_FORM_STEPS, HALF_PLANE_STEPS = 360, 60
# Bodies BODY half-widths high differ from half-planes by about this multiple of 1/BODY².
FINITE_BODY = 2.0
# The half-plane answers locate a slip border to this fraction of the half-width.
HALF_PLANE_BORDER = 0.004
# A number without a bar is taken to claim this, relative.
CLAIMED = 0.01


@dataclass(frozen=True)
class Judged:
    """One number of one edge.

    Attributes:
        draw: its case.
        edge: "left" or "right".
        quantity: "K_N", "ΔK_T" or "d".
        value: what was computed, NaN if unknown.
        bar: its error bar.
        truth: what it should be.
        allowance: error of the truth itself.
        remark: the warnings about it.
    """

    draw: Draw
    edge: str
    quantity: str
    value: float
    bar: float
    truth: float
    allowance: float
    remark: str

    @property
    def error(self) -> float:
        """|value - truth| beyond the error of the truth."""
        return max(abs(self.value - self.truth) - self.allowance, 0.0)

    @property
    def verdict(self) -> Verdict:
        """Right within the bar; else flagged if it is unknown or was warned of."""
        if self.error <= self.bar:
            return "right"
        return "flagged" if math.isnan(self.value) or self.remark else "wrong"


def judge(one: Draw) -> Iterator[Judged]:
    """Solve a case by finite elements and compare its numbers with the exact ones."""
    import fretfe

    try:
        found = fretfe.run(parse_case(case_of(one))).edges()
    except FretfeError as error:
        found = [{"edge": side, "warnings": str(error)} for side in ("left", "right")]
    exact = fretfe.run(parse_case(case_of(one, CLOSED_FORM_STEPS)), backend="analytic").edges()
    borders = fretfe.run(parse_case(case_of(one, HALF_PLANE_STEPS)), backend="halfplane").edges()
    for edge, truth, border in zip(found, exact, borders, strict=True):
        yield from _judge_edge(one, edge, truth, border)


def _judge_edge(
    one: Draw, edge: dict[str, Any], truth: dict[str, Any], border: dict[str, Any]
) -> Iterator[Judged]:
    finite = FINITE_BODY / BODY**2
    remark = "" if edge.get("resolved", False) else "not resolved"
    remark = "; ".join(text for text in (remark, edge["warnings"]) if text)
    for quantity, key, exact, spread, allowance in (
        ("K_N", "k_n", truth["k_n"], "k_n_spread", finite * abs(truth["k_n"])),
        ("ΔK_T", "k_t_range", truth["k_t_range"], "k_t_range_spread", finite * truth["k_t_range"]),
        ("d", "slip_2", border["slip_2"], "slip_2_spread", HALF_PLANE_BORDER * one.a),
    ):
        value = float(edge.get(key, math.nan))
        bar = float(edge.get(spread, CLAIMED * abs(value)))
        if not math.isnan(exact):
            yield Judged(one, edge["edge"], quantity, value, bar, exact, allowance, remark)
