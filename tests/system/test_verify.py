# SPDX-License-Identifier: LGPL-3.0-or-later
"""The benchmarks and negative controls through finite elements."""

from __future__ import annotations

import json
from functools import cache

import pytest
from campaign.extent import LONG
from harness.launch import fretfe

from fretfe.backends import Installed
from fretfe.fem.backend import BACKEND
from fretfe.quality import verification
from fretfe.quality.comparison import Benchmark, Row
from fretfe.quality.verification import benchmarks, controls, run_benchmark

BENCHMARKS = {benchmark.name: benchmark for benchmark in benchmarks() if benchmark.case}
CONTROLS = {control.name: control for control in controls()}
# One of each kind that runs in about a second; the whole table takes twenty.
QUICK = (
    "fretting specimen, f = 0.85",
    "loop Q 0.15, tension 0.3, lag 45°",
    "moment, Hertz",
    "sliding wedge block",
)


@cache
def rows_of(name: str) -> tuple[Row, ...]:
    """Of a benchmark or control, which is run once."""
    return run_benchmark((BENCHMARKS | CONTROLS)[name], Installed("fem", "", BACKEND))


def check(name: str) -> None:
    rows = rows_of(name)
    assert [row for row in rows if row.verdict != "agrees"] == []
    assert len(rows) == len(BENCHMARKS[name].quantities)


@pytest.mark.mpi
@pytest.mark.parametrize("name", QUICK)
def test_benchmark_passes(name: str) -> None:
    check(name)


@pytest.mark.parametrize("name", CONTROLS)
def test_control_is_caught(name: str) -> None:
    (row,) = rows_of(name)
    assert row.verdict == "caught", row.reason


@pytest.mark.slow
@pytest.mark.skipif(not LONG, reason="CI runs all of them for the verification book")
def test_every_benchmark_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    """On one process: on two they are the same to round-off, as those are that are tested above."""

    def once(benchmark: Benchmark, installed: Installed) -> tuple[Row, ...]:
        solved = benchmark.name in BENCHMARKS | CONTROLS
        return rows_of(benchmark.name) if solved else run_benchmark(benchmark, installed)

    monkeypatch.setattr(verification, "run_benchmark", once)
    done = fretfe("verify", "--backend", "fem", "--json")
    assert done.returncode == 0, done.stdout + done.stderr
    rows = json.loads(done.stdout)["rows"]
    agreed = {row["benchmark"] for row in rows if row["verdict"] == "agrees"}
    assert agreed >= BENCHMARKS.keys()
