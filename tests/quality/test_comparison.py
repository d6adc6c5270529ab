# SPDX-License-Identifier: LGPL-3.0-or-later
"""The comparison that every number of the verification goes through."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fretfe.loads import History
from fretfe.quality.comparison import Quantity, Row, compare, failed, remark
from fretfe.quality.cycles import TENSION_ONLY, loop_case
from fretfe.results.model import Result
from fretfe.verdict import Verdict

RESULT = Result(loop_case(TENSION_ONLY), History((), np.zeros(1), np.zeros((1, 0)), None), (), None)


def quantity(value: float) -> Quantity:
    tolerances = {"good": 0.01, "coarse": 0.1}
    return Quantity("K_N", 4.0, 2.0, tolerances, lambda _: value)


@pytest.mark.parametrize(
    ("value", "backend", "difference", "verdict"),
    [
        (4.015, "good", 0.0075, "agrees"),
        (3.985, "good", -0.0075, "agrees"),
        (4.03, "good", 0.015, "differs"),
        (3.97, "good", -0.015, "differs"),
        (4.03, "coarse", 0.015, "agrees"),
        (4.19, "foreign", 0.095, "agrees"),
        (4.21, "foreign", 0.105, "differs"),
    ],
)
def test_difference_is_a_fraction_of_the_scale(
    value: float, backend: str, difference: float, verdict: str
) -> None:
    row = compare("benchmark", quantity(value), backend, RESULT)
    assert (row.computed, row.reference, row.verdict) == (value, 4.0, verdict)
    assert row.difference == pytest.approx(difference)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_value_is_a_failure(value: float) -> None:
    row = compare("benchmark", quantity(value), "good", RESULT)
    assert (row.computed, row.difference, row.verdict) == (None, None, "differs")
    assert "no value" in row.reason


def rows(*verdicts: Verdict) -> tuple[Row, ...]:
    return tuple(remark("benchmark", "backend", verdict, "") for verdict in verdicts)


@pytest.mark.parametrize(
    ("verdicts", "expected"),
    [
        ((Verdict.AGREES, Verdict.SKIPPED, Verdict.CAUGHT), False),
        ((Verdict.AGREES, Verdict.DIFFERS), True),
        ((Verdict.AGREES, Verdict.NOT_CAUGHT), True),
        ((Verdict.SKIPPED, Verdict.SKIPPED), True),
        ((), True),
    ],
    ids=["good", "one fails", "control not caught", "nothing run", "no rows"],
)
def test_a_verification_fails(verdicts: tuple[Verdict, ...], expected: bool) -> None:
    assert failed(rows(*verdicts)) is expected
