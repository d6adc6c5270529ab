# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run one benchmark through one backend."""

from __future__ import annotations

import sys

from fretfe.backends import Backend, Installed, ParallelBackend, Processes
from fretfe.errors import FretfeError
from fretfe.quality.verify.controls import judge
from fretfe.quality.verify.model import Benchmark, Row, Verdict, compare, remark


def run_benchmark(
    benchmark: Benchmark, installed: Installed, processes: Processes
) -> tuple[Row, ...]:
    """Compare a backend's numbers with the known ones. Collective over the backend's processes.

    Whatever a backend raises becomes a row, but for one thing: an error that is none of fretfe's
    own, in a backend that runs on several processes, may have happened on one of them alone. The
    others would wait for it, so it ends the run.
    """
    backend = installed.backend
    several = isinstance(backend, ParallelBackend) and not _alone()
    expected = FretfeError if several else Exception
    try:
        reason = _why_not(benchmark, installed)
        if reason or backend is None:
            return (remark(benchmark.name, installed.name, "skipped", reason),)
        return _comparisons(benchmark, installed.name, backend, processes)
    except expected as error:
        return (_failure(benchmark, installed.name, error),)


def _alone() -> bool:
    """Whether MPI is in use and this is its only process; a parallel backend has loaded it."""
    mpi = sys.modules.get("mpi4py.MPI")
    return mpi is not None and mpi.COMM_WORLD.size == 1


def _why_not(benchmark: Benchmark, installed: Installed) -> str:
    """Why a benchmark is not run; empty if it is."""
    if benchmark.case is None:
        return benchmark.left_out
    if installed.backend is None:
        return installed.reason
    return "; ".join(installed.backend.supports(benchmark.case))


def _comparisons(
    benchmark: Benchmark, name: str, backend: Backend, processes: Processes
) -> tuple[Row, ...]:
    assert benchmark.case is not None
    result = backend.solve(benchmark.case)
    if result.failure is not None:
        raise result.failure
    rows = processes.on_root(
        lambda: tuple(
            compare(benchmark.name, quantity, name, result) for quantity in benchmark.quantities
        )
    )
    assert rows is not None
    return (judge(rows),) if benchmark.control else rows


def _failure(benchmark: Benchmark, name: str, error: Exception) -> Row:
    """A backend may refuse to solve a control, but not crash over it."""
    refused = isinstance(error, FretfeError)
    verdict: Verdict = "fail"
    if benchmark.control:
        verdict = "caught" if refused else "NOT CAUGHT"
    text = str(error) if refused else f"{type(error).__name__}: {error}"
    return remark(benchmark.name, name, verdict, text)
