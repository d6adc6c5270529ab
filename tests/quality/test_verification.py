# SPDX-License-Identifier: LGPL-3.0-or-later
"""One benchmark through one backend: whatever happens becomes a row."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import pytest

from fretfe.backends import Backend, Installed, Processes, RunOptions
from fretfe.backends.protocol import DEFAULTS
from fretfe.case import Case
from fretfe.errors import ConvergenceError, ModelError
from fretfe.loads import History
from fretfe.quality import verification
from fretfe.quality.comparison import Benchmark, Quantity, Row
from fretfe.quality.cycles import TENSION_ONLY, loop_case
from fretfe.quality.verification import run_benchmark
from fretfe.results.model import Result
from fretfe.verdict import Verdict

T = TypeVar("T")
RESULT = Result(loop_case(TENSION_ONLY), History((), np.zeros(1), np.zeros((1, 0)), None), (), None)


@dataclass
class Stub(Backend):
    """A backend that returns or raises what it is told to."""

    outcome: Result | Exception = RESULT
    reasons: tuple[str, ...] = ()
    summary: str = "stub"

    def supports(self, case: Case) -> tuple[str, ...]:
        return self.reasons

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome


class Several(Processes):
    """More than one process."""

    shared = True


class ParallelStub(Stub):
    """The same on several processes."""

    processes = Several()


def benchmark(*values: float, control: bool = False) -> Benchmark:
    """Quantities whose known value is 1."""
    quantities = tuple(
        Quantity(f"quantity {i}", 1.0, 1.0, {"stub": 0.01}, lambda _, value=value: value)  # type: ignore[misc]
        for i, value in enumerate(values)
    )
    return Benchmark("name", "source", loop_case(TENSION_ONLY), quantities, control=control)


def run(
    backend: Stub | None, *values: float, control: bool = False, reason: str = ""
) -> tuple[Row, ...]:
    installed = Installed("stub", "package 1.0", backend, reason)
    return run_benchmark(benchmark(*values, control=control), installed)


def test_every_quantity_gets_a_row() -> None:
    rows = run(Stub(), 1.0, 2.0)
    assert [row.quantity for row in rows] == ["quantity 0", "quantity 1"]
    assert [row.verdict for row in rows] == ["agrees", "differs"]


def test_backend_that_cannot_be_used_is_skipped() -> None:
    (row,) = run(None, 1.0, reason="No module named 'dolfinx'")
    assert (row.verdict, row.reason) == ("skipped", "No module named 'dolfinx'")


def test_case_that_is_not_supported_is_skipped() -> None:
    (row,) = run(Stub(reasons=("no tension", "no shear")), 1.0)
    assert (row.verdict, row.reason) == ("skipped", "no tension; no shear")


ERRORS = [
    (ModelError("nothing holds the pad"), "nothing holds the pad"),
    (ZeroDivisionError("by zero"), "ZeroDivisionError: by zero"),
]


@pytest.mark.parametrize(("error", "text"), ERRORS, ids=["refusal", "crash"])
def test_error_is_a_failed_row(error: Exception, text: str) -> None:
    (row,) = run(Stub(error), 1.0)
    assert (row.verdict, row.reason) == ("failed", text)


def test_history_that_was_not_finished_is_a_failed_row() -> None:
    result = replace(RESULT, failure=ConvergenceError("step 3 has no solution"))
    (row,) = run(Stub(result), 1.0)
    assert (row.verdict, row.reason) == ("failed", "step 3 has no solution")


def test_refusal_on_several_processes_is_a_failed_row() -> None:
    (row,) = run(ParallelStub(ModelError("refused")), 1.0)
    assert row.verdict == "failed"


def test_known_values_of_a_twin() -> None:
    """The twin is solved first, and its numbers are what is known."""

    @dataclass
    class Numbered(Stub):
        """Takes the friction of the case for a result."""

        def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
            return replace(RESULT, case=case)

    def friction(result: Result) -> float:
        found = result.case.contacts["main"].friction
        assert isinstance(found, float)
        return found

    case, twin = loop_case(TENSION_ONLY, friction=0.303), loop_case(TENSION_ONLY, friction=0.3)
    same = Quantity("friction", np.nan, np.nan, {"stub": 0.02}, friction, of_twin=friction)
    given = Benchmark("name", "source", case, (same,), twin=twin)
    (row,) = run_benchmark(given, Installed("stub", "package 1.0", Numbered()))
    assert (row.computed, row.reference, row.verdict) == (0.303, 0.3, "agrees")
    assert row.difference == pytest.approx(0.01)


def test_crash_on_several_processes_ends_the_run() -> None:
    # It may have happened on one process alone, for which the others would wait.
    with pytest.raises(ZeroDivisionError):
        run(ParallelStub(ZeroDivisionError()), 1.0)


@pytest.mark.parametrize(
    ("values", "verdict", "words"),
    [
        ((2.0, 3.0), "caught", "quantity 0 2 for 1"),
        ((2.0, 1.0), "not caught", "accepted: quantity 1"),
        ((1.0, 1.0), "not caught", "accepted: quantity 0, quantity 1"),
        ((float("nan"),), "caught", "quantity 0 - for 1"),
    ],
)
def test_control_has_to_fail_in_every_comparison(
    values: tuple[float, ...], verdict: str, words: str
) -> None:
    (row,) = run(Stub(), *values, control=True)
    assert row.verdict == verdict
    assert words in row.reason


@pytest.mark.parametrize(
    ("error", "verdict"), [(ERRORS[0][0], "caught"), (ERRORS[1][0], "not caught")]
)
def test_control_may_be_refused_but_not_crash(error: Exception, verdict: str) -> None:
    (row,) = run(Stub(error), 1.0, control=True)
    assert row.verdict == verdict


@pytest.mark.parametrize(
    ("names", "verdict"),
    [((), Verdict.FAILED), (("fem",), Verdict.FAILED), (("stub",), Verdict.AGREES)],
    ids=["nobody chose", "chosen", "another was chosen"],
)
def test_a_backend_that_cannot_be_used_fails_unless_others_were_chosen(
    monkeypatch: pytest.MonkeyPatch, names: tuple[str, ...], verdict: Verdict
) -> None:
    installed = (Installed("fem", "fretfe", None, "no DOLFINx"), Installed("stub", "own", Stub()))
    monkeypatch.setattr(verification, "installed_backends", lambda: installed)
    monkeypatch.setattr(verification, "backend_names", lambda: ("fem", "stub"))
    monkeypatch.setattr(verification, "benchmarks", lambda: (benchmark(1.0),))
    monkeypatch.setattr(verification, "controls", lambda: ())
    found = verification.verify(names)
    assert found.rows[0].verdict is verdict
    assert found.passed == (verdict is Verdict.AGREES)
