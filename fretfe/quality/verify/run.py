# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run benchmarks through backends."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fretfe.backends import (
    SILENT,
    Backend,
    Installed,
    Observer,
    OneProcess,
    ParallelBackend,
    Processes,
    backend_names,
    installed_backends,
    processes_of,
)
from fretfe.errors import CaseError, FretfeError
from fretfe.quality.verify.benchmarks import benchmarks
from fretfe.quality.verify.controls import controls, judge
from fretfe.quality.verify.model import Benchmark, Row, Verdict, compare, failed, remark

# Called with each benchmark and its rows.
Show = Callable[[Benchmark, Sequence[Row]], None]


@dataclass(frozen=True)
class Verification:
    """Comparisons of all benchmarks and negative controls.

    Attributes:
        rows: the comparisons.
        seconds: wall time by backend.
        passed: no comparison failed; the same on all processes of a parallel backend.
    """

    rows: tuple[Row, ...]
    seconds: dict[str, float]
    passed: bool


def verify(
    names: Sequence[str] = (), observer: Observer = SILENT, show: Show | None = None
) -> Verification:
    """Run all benchmarks and negative controls. Collective if one of the backends is parallel.

    Args:
        names: of the backends; empty for all that are installed.
        observer: is told of each benchmark with each backend, as a phase.
        show: called with each benchmark and its rows.

    Raises:
        CaseError: if no backend of one of these names is installed.
    """
    chosen = _choose(names)
    rows: list[Row] = []
    seconds = {installed.name: 0.0 for installed in chosen}
    for benchmark in (*benchmarks(), *controls()):
        found: list[Row] = []
        for installed in chosen:
            processes = processes_of(installed.backend)
            if isinstance(processes, OneProcess) and processes.rank > 0:
                continue
            start = time.perf_counter()
            if processes.rank == 0:
                observer.phase(f"{benchmark.name}: {installed.name}")
            found += run_benchmark(benchmark, installed, processes)
            seconds[installed.name] += time.perf_counter() - start
        if show is not None:
            show(benchmark, found)
        rows += found
    return Verification(tuple(rows), seconds, _agree(chosen, not failed(tuple(rows))))


def _choose(names: Sequence[str]) -> tuple[Installed, ...]:
    unknown = sorted(set(names) - set(backend_names()))
    if unknown:
        raise CaseError(
            f"expected names of installed backends ({', '.join(backend_names())}), found "
            + ", ".join(repr(name) for name in unknown)
        )
    return tuple(each for each in installed_backends() if not names or each.name in names)


def _agree(chosen: Sequence[Installed], passed: bool) -> bool:
    """Give the verdict of rank 0 to all processes: the others have not run every backend."""
    for installed in chosen:
        if isinstance(installed.backend, ParallelBackend):
            return processes_of(installed.backend).on_root(lambda: passed)
    return passed or OneProcess().rank > 0


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
    return (judge(rows),) if benchmark.control else rows


def _failure(benchmark: Benchmark, name: str, error: Exception) -> Row:
    """A backend may refuse to solve a control, but not crash over it."""
    refused = isinstance(error, FretfeError)
    verdict: Verdict = "fail"
    if benchmark.control:
        verdict = "caught" if refused else "NOT CAUGHT"
    text = str(error) if refused else f"{type(error).__name__}: {error}"
    return remark(benchmark.name, name, verdict, text)
