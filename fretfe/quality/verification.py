# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run benchmarks through backends, and those that are spoilt on purpose and have to fail."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from fretfe.backends import SILENT, Backend, Installed, Observer, backend_names, installed_backends
from fretfe.backends.protocol import DEFAULT
from fretfe.case import Case
from fretfe.environment import few_threads
from fretfe.errors import CaseError, FretfeError
from fretfe.quality.comparison import Benchmark, Measure, Quantity, Row, compare, failed, remark
from fretfe.quality.cycles import (
    FRICTION,
    LAGGING,
    TENSION_ONLY,
    cyclic_shear,
    factor_ranges,
    loop_benchmarks,
    loop_case,
    rocking,
    slip_lengths,
    unlike_bodies,
    varying_normal_load,
)
from fretfe.quality.loading import (
    cylinder_on_block,
    fretting_specimens,
    pushed_plate,
    sliding_wedge,
    two_cylinders,
    unloaded_cylinder,
)
from fretfe.quality.solids import (
    cattaneo_sphere,
    extruded_pad,
    sheared_ellipse,
    sheared_sphere,
    twisted_sphere,
)
from fretfe.results.model import Result
from fretfe.verdict import Verdict

# Called with each benchmark and its rows.
Show = Callable[[Benchmark, Sequence[Row]], None]


def controls() -> tuple[Benchmark, ...]:
    """All negative controls."""
    wrong_sign = replace(LAGGING, tension=-LAGGING.tension)
    first_loading = tuple(
        replace(quantity, measure=_first_loading_law(side))
        for side, quantity in enumerate(slip_lengths(LAGGING))
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
    accepted = [row.quantity for row in rows if row.verdict is not Verdict.DIFFERS]
    if accepted:
        reason = f"accepted: {', '.join(accepted)}"
        return remark(first.benchmark, first.backend, Verdict.NOT_CAUGHT, reason)
    found = ", ".join(
        f"{row.quantity} {'-' if row.computed is None else f'{row.computed:.4g}'} "
        f"for {row.reference:.4g}"
        for row in rows
    )
    return remark(first.benchmark, first.backend, Verdict.CAUGHT, found)


def benchmarks() -> tuple[Benchmark, ...]:
    """All benchmarks, in the order in which they are run."""
    return tuple(each for _, family in families() for each in family)


def families() -> Iterator[tuple[str, tuple[Benchmark, ...]]]:
    """Benchmarks of one problem each, with its description."""
    makers: tuple[Callable[[], Benchmark | tuple[Benchmark, ...]], ...] = (
        two_cylinders,
        cylinder_on_block,
        fretting_specimens,
        loop_benchmarks,
        cyclic_shear,
        unlike_bodies,
        varying_normal_load,
        rocking,
        unloaded_cylinder,
        sliding_wedge,
        pushed_plate,
        sheared_sphere,
        cattaneo_sphere,
        twisted_sphere,
        sheared_ellipse,
        extruded_pad,
    )
    for make in makers:
        made = make()
        yield inspect.getdoc(make) or "", made if isinstance(made, tuple) else (made,)


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


@few_threads()
def verify(
    names: Sequence[str] = (), observer: Observer = SILENT, show: Show | None = None
) -> Verification:
    """Run all benchmarks and negative controls. Collective if one of the backends is parallel.

    Args:
        names: of the backends; empty for all that are installed.
        observer: is told of each benchmark with each backend, as a phase.
        show: called with each benchmark and its rows.

    One that is named here, or is the default and nobody chose others, fails if it cannot be used.

    Raises:
        CaseError: if no backend of one of these names is installed.
    """
    chosen = _choose(names)
    rows: list[Row] = []
    seconds = {installed.name: 0.0 for installed in chosen}
    for benchmark in (*benchmarks(), *controls()):
        found: list[Row] = []
        for installed in chosen:
            if installed.processes.idle:
                continue
            start = time.perf_counter()
            if installed.processes.rank == 0:
                observer.phase(f"{benchmark.name}: {installed.name}")
            required = installed.name in (names or (DEFAULT,))
            found += run_benchmark(benchmark, installed, required=required)
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
    active = [each.processes for each in chosen if not each.processes.idle]
    for processes in active:
        passed = processes.on_root(partial(bool, passed))
    return passed or not active


def run_benchmark(
    benchmark: Benchmark, installed: Installed, *, required: bool = False
) -> tuple[Row, ...]:
    """Compare a backend's numbers with the known ones. Collective over the backend's processes.

    Whatever a backend raises becomes a row, but for one thing: an error that is none of fretfe's
    own, in a backend that runs on several processes, may have happened on one of them alone. The
    others would wait for it, so it ends the run.
    """
    backend = installed.backend
    expected = FretfeError if installed.processes.shared else Exception
    try:
        if backend is None:
            verdict = Verdict.FAILED if required else Verdict.SKIPPED
            return (remark(benchmark.name, installed.name, verdict, installed.reason),)
        if reasons := backend.supports(benchmark.case):
            return (remark(benchmark.name, installed.name, Verdict.SKIPPED, "; ".join(reasons)),)
        twin = None if benchmark.twin is None else _solve(backend, benchmark.twin)
        result = _solve(backend, benchmark.case)
        rows = installed.processes.on_root(
            lambda: tuple(
                compare(benchmark.name, quantity.against(twin), installed.name, result)
                for quantity in benchmark.quantities
            )
        )
        return (judge(rows),) if benchmark.control else rows
    except expected as error:
        return (_failure(benchmark, installed.name, error),)


def _solve(backend: Backend, case: Case) -> Result:
    """The result of a backend; whatever failed is raised."""
    result = backend.solve(case)
    if result.failure is not None:
        raise result.failure
    return result


def _failure(benchmark: Benchmark, name: str, error: Exception) -> Row:
    """A backend may refuse to solve a control, but not crash over it."""
    refused = isinstance(error, FretfeError)
    verdict = Verdict.FAILED
    if benchmark.control:
        verdict = Verdict.CAUGHT if refused else Verdict.NOT_CAUGHT
    text = str(error) if refused else f"{type(error).__name__}: {error}"
    return remark(benchmark.name, name, verdict, text)
