# SPDX-License-Identifier: LGPL-3.0-or-later
"""Comparisons of a validation, their verdicts, and all of them as a table and as plain data."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Verdict = Literal["pass", "FAIL", "outside", "depends", "unknown", "-"]


@dataclass(frozen=True)
class Row:
    """A number, what it is compared with, and what follows.

    Attributes:
        contact: name of the contact.
        edge: "left", "right", of solids a front; "" for the contact as a whole.
        quantity: what is compared.
        value: the number.
        reference: what it should be.
        tolerance: largest acceptable |value - reference|, in the same unit.
        reason: where the tolerance comes from, or why there is no comparison.
        verdict: "pass"; "FAIL"; "outside" the range of the formula, which is an answer and no
            failure; "depends" on how the cycle was reached; "unknown" if the run does not carry
            the number; "-" if there is nothing to compare.
    """

    contact: str
    edge: str
    quantity: str
    value: float
    reference: float
    tolerance: float
    reason: str
    verdict: Verdict

    @property
    def where(self) -> str:
        """Contact and edge or front, for people."""
        edge = f"{self.edge} edge" if self.edge in ("left", "right") else self.edge
        return f"{self.contact}, {edge}" if edge else self.contact

    @property
    def difference(self) -> float:
        """Value less reference."""
        return self.value - self.reference


def compared(
    contact: str,
    edge: str,
    quantity: str,
    value: float,
    reference: float,
    tolerance: float,
    reason: str,
    otherwise: Verdict = "FAIL",
) -> Row:
    """A row whose verdict is "pass" within the tolerance and `otherwise` outside.

    A value or reference that does not exist gives "-", unless the two are both expected: then NaN
    on one side only is no agreement.
    """
    verdict: Verdict = otherwise
    if math.isnan(value) and math.isnan(reference):
        verdict = "-"
    elif abs(value - reference) <= tolerance:
        verdict = "pass"
    return Row(contact, edge, quantity, value, reference, tolerance, reason, verdict)


def missing(contact: str, edge: str, quantity: str, reason: str, verdict: Verdict = "-") -> Row:
    """A row without a comparison."""
    return Row(contact, edge, quantity, math.nan, math.nan, math.nan, reason, verdict)
