#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Times and memory of runs, phases, ranks, start-up, sweeps and reports: `make bench`.

Prints the tables of docs/performance.md; `tools/bench.py TABLE ... CASE ...` prints some tables, or
some cases of them. Times of one table come from one hour and one machine; ratios to a plain
factorisation of the same stiffness, measured in the same process, compare machines.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
TESTS, DEMOS = ROOT / "tests", ROOT / "demos"
BIN = Path(sys.executable).parent
# Element size at the contact and growth of the sizes; a cylinder on a block.
CYLINDERS = ((0.02, 0.15), (0.01, 0.1), (0.005, 0.05))
# Elements over the radius of the contact; a sphere on a block.
SPHERES = (8, 12)
# Runs and factorisations that take turns, or commands; the shortest of each counts. Once where that
# takes minutes.
ROUNDS, LONG = 3, ("sphere, a/12", "dovetail of solids")
RANKS = (1, 2, 4)
BY_RANKS = ("B1, h = 0.01", "B1, h = 0.005", "dovetail demo", *LONG)
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
# From the phases that `fretfe run --timings` prints.
PHASES = (
    *("mesh", "assembly", "condensation", "load columns", "interface", "steps", "edge integrals"),
    *("evaluation", "local problems"),
)
BEGUN = "import fretfe.cli.app, fretfe.surface.ahead"
IMPORTS = "import fretfe.cli.progress, fretfe.runner, fretfe.fem.backend"
WAVE = "loads.pull.history.3.amplitude"
# Values of further cases of a sweep.
FRICTIONS, AMPLITUDES = (0.5, 0.52, 0.55, 0.58), (500, 520, 550, 580)


def write_cylinder(size: float, growth: float, folder: Path) -> Path:
    """Write the benchmark of a cylinder, mesh and case file."""
    from cases_b1 import b1_case
    from meshes_b1 import write_b1

    write_b1(folder / "b1.msh", order=2, h=size, growth=growth)
    return write_case(b1_case(folder / "b1.msh", 2, 5.0, "finer"), folder)


def write_sphere(elements: int, folder: Path) -> Path:
    """Write the case of a sphere on a block under two cycles of shear force."""
    from cycled_sphere import FRICTION, cycles, tables

    data = tables(FRICTION, shear=cycles())
    data["geometry"]["parameters"]["size"] = 1 / elements
    return write_case(data, folder)


def write_case(data: dict[str, Any], folder: Path) -> Path:
    """Write a case file."""
    from fretfe.case import case_text, parse_case

    path = folder / "case.toml"
    path.write_text(case_text(parse_case(data)))
    return path


def demo(name: str, _: Path) -> Path:
    """The case file of a demo."""
    return DEMOS / f"{name}.toml"


CASES: dict[str, Callable[[Path], Path]] = {
    **{f"B1, h = {size:g}": partial(write_cylinder, size, growth) for size, growth in CYLINDERS},
    "dovetail demo": partial(demo, "dovetail"),
    **{f"sphere, a/{elements}": partial(write_sphere, elements) for elements in SPHERES},
    "dovetail of solids": partial(demo, "dovetail_solid"),
}


def shortest(works: Sequence[Callable[[], object]], count: int) -> list[float]:
    """Shortest times of some works that take turns, so that a slow minute hits all of them alike.

    Processor time outside the kernel, which no other process changes much.
    """

    def seconds(work: Callable[[], object]) -> float:
        start = os.times().user
        work()
        return os.times().user - start

    rounds = [[seconds(work) for work in works] for _ in range(count)]
    return [min(times) for times in zip(*rounds, strict=True)]


def measure(path: Path, count: int) -> dict[str, Any]:
    """Runs without imports, and plain factorisations of their stiffness, in this process."""
    from fretfe.case import load_case
    from fretfe.fem._compat import MPI
    from fretfe.fem.backend import BACKEND
    from fretfe.fem.model import Model
    from fretfe.fem.timing import Clock
    from fretfe.results.model import Result
    from fretfe.results.writer import write_results
    from fretfe.surface.checks import load_mesh

    case = load_case(path)
    results: list[Result] = []
    with tempfile.TemporaryDirectory() as folder:

        def run() -> None:
            results[:] = [replace(BACKEND.solve(case), backend="fem")]
            write_results(Path(folder), results[0])

        run()  # forms are compiled, files are read
        model = Model(MPI.COMM_WORLD, case, load_mesh(case), Clock())
        unknowns, factorise = factorisation(model)
        run_time, factorisation_time = shortest([run, factorise], count)
    return {
        "unknowns": unknowns,
        "tractions": model.dimension * model.reduction.interface.size,
        "steps": len(results[0].loads.times) - 1,
        "run": run_time,
        "factorisation": factorisation_time,
        "seconds": results[0].seconds,
    }


def factorisation(model: Any) -> tuple[int, Callable[[], None]]:
    """Unknowns of the bodies of a model, and a plain factorisation of their stiffness."""
    from scipy.sparse import block_diag, csr_matrix

    from fretfe.fem._compat import MPI, PETSc

    stiffness = [body.stiffness for body in model.bodies.values()]
    whole = block_diag([csr_matrix(each.getValuesCSR()[::-1]) for each in stiffness]).tocsr()
    matrix = PETSc.Mat().createAIJ(whole.shape, csr=(whole.indptr, whole.indices, whole.data))
    matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)

    def factorise() -> None:
        factor = PETSc.PC().create(MPI.COMM_WORLD)
        factor.setOperators(matrix)
        factor.setType("cholesky")
        factor.setFactorSolverType("mumps")
        factor.setUp()
        factor.destroy()

    return whole.shape[0], factorise


def count_of(name: str) -> int:
    """How often a case is run."""
    return 1 if name in LONG else ROUNDS


@cache
def measured(name: str, path: Path) -> dict[str, Any]:
    """`in_a_process`, once for each case."""
    return in_a_process(path, count_of(name))


def in_a_process(path: Path, count: int = ROUNDS) -> dict[str, Any]:
    """`measure` in a process of its own, with one thread."""
    command = [sys.executable, __file__, "--measure", str(path), str(count)]
    environment = {**os.environ, **ONE_THREAD}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


@dataclass(frozen=True)
class Spent:
    """What a command took.

    Attributes:
        wall: seconds.
        processor: seconds of all its processes.
        memory: GB of the largest of them.
    """

    wall: float
    processor: float
    memory: float


def spent(command: Sequence[str | Path]) -> Spent:
    """Run a command, with one thread in each of its processes."""
    start = time.perf_counter()
    quiet = subprocess.DEVNULL
    environment = {**os.environ, **ONE_THREAD}
    process = subprocess.Popen(command, stdout=quiet, stderr=quiet, env=environment)
    _, status, used = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status):
        raise RuntimeError(f"{' '.join(map(str, command))} ended with {status}")
    wall = time.perf_counter() - start
    return Spent(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 2**20)


def least(*words: str | Path, count: int = ROUNDS, ranks: int = 1) -> Spent:
    """The shortest of some runs of a command."""
    launcher: list[str | Path] = [BIN / "mpirun", "-n", str(ranks)] if ranks > 1 else []
    return min((spent([*launcher, *words]) for _ in range(count)), key=lambda each: each.wall)


def fretfe(*words: str | Path, count: int = ROUNDS, ranks: int = 1) -> Spent:
    """A command of fretfe."""
    return least(BIN / "fretfe", *words, count=count, ranks=ranks)


def run(path: Path, count: int, ranks: int = 1) -> Spent:
    """A whole `fretfe run` without report."""
    with tempfile.TemporaryDirectory() as output:
        words = ("run", path, "-o", output, "--no-report", "-q")
        return fretfe(*words, count=count, ranks=ranks)


Cases = Mapping[str, Path]


def rows_of_runs(cases: Cases) -> Iterator[tuple[str, ...]]:
    """Whole runs over one factorisation; then their phases."""
    yield (
        *("case", "unknowns", "tractions", "whole run, s", "GB", "after imports, s"),
        *("one factorisation, s", "ratio", "a step, ms"),
    )
    for name, path in cases.items():
        found, whole = measured(name, path), run(path, count_of(name))
        yield (
            name,
            f"{found['unknowns']}",
            f"{found['tractions']}",
            f"{whole.wall:.1f}",
            f"{whole.memory:.2f}",
            f"{found['run']:.2f}",
            f"{found['factorisation']:.2f}",
            f"{found['run'] / found['factorisation']:.1f}",
            f"{1e3 * found['seconds']['steps'] / found['steps']:.1f}",
        )


def rows_of_phases(cases: Cases) -> Iterator[tuple[str, ...]]:
    """Seconds of each phase of the last run in a process, and of one factorisation there."""
    yield ("case", *PHASES, "one factorisation")
    for name, path in cases.items():
        found = measured(name, path)
        phases = (found["seconds"].get(each, 0.0) for each in PHASES)
        yield (name, *(f"{each:.2f}" for each in phases), f"{found['factorisation']:.2f}")


def rows_of_ranks(cases: Cases) -> Iterator[tuple[str, ...]]:
    """Wall time over that of one rank, processor time, and memory of the largest rank."""
    yield (
        *("case", "ranks", "whole run, s", "of 1 rank", "processor, s"),
        *("processor over one factorisation", "GB of a rank"),
    )
    for name in (each for each in BY_RANKS if each in cases):
        path, count = cases[name], count_of(name)
        factorisation = measured(name, path)["factorisation"]
        one = run(path, count)
        for ranks in RANKS:
            each = one if ranks == 1 else run(path, count, ranks)
            yield (
                name,
                f"{ranks}",
                f"{each.wall:.1f}",
                f"{each.wall / one.wall:.2f}",
                f"{each.processor:.1f}",
                f"{each.processor / factorisation:.1f}",
                f"{each.memory:.2f}",
            )


def rows_of_commands(_: Cases) -> Iterator[tuple[str, ...]]:
    """Start-up, a further case of a sweep, and a report: wall and processor time."""
    yield ("command", "wall, s", "processor, s", "processor over DOLFINx alone")
    python, dovetail = sys.executable, demo("dovetail", ROOT)
    alone = least(python, "-c", "import fretfe.fem._compat")
    with tempfile.TemporaryDirectory() as output:
        done = Path(output) / "run"
        fretfe("run", dovetail, "-o", done, "--no-report", "-q")
        commands = {
            "DOLFINx alone": alone,
            "imports until a mesh is begun": least(python, "-c", BEGUN),
            "imports of a plane run": least(python, "-c", IMPORTS),
            "fretfe --help": fretfe("--help"),
            "fretfe check, hertz demo": fretfe("check", demo("hertz", ROOT)),
            "fretfe report, dovetail demo": fretfe("report", done),
            "a further friction coefficient": further("contacts.*.friction=0.6", *FRICTIONS),
            "a further last segment of the loads": further(f"{WAVE}=600", *AMPLITUDES),
        }
    for name, each in commands.items():
        ratio = each.processor / alone.processor
        yield (name, f"{each.wall:.2f}", f"{each.processor:.2f}", f"{ratio:.2f}")


def further(first: str, *others: float) -> Spent:
    """What each case of a sweep of the dovetail demo takes but the first one."""
    more = ",".join([first, *map(str, others)])
    with tempfile.TemporaryDirectory() as output:
        words = ("sweep", demo("dovetail", ROOT), "-q", "-o", output, "--vary")
        one, all_of_them = (fretfe(*words, vary) for vary in (first, more))
    return Spent(
        (all_of_them.wall - one.wall) / len(others),
        (all_of_them.processor - one.processor) / len(others),
        all_of_them.memory,
    )


TABLES: dict[str, Callable[[Cases], Iterator[tuple[str, ...]]]] = {
    "runs": rows_of_runs,
    "phases": rows_of_phases,
    "ranks": rows_of_ranks,
    "commands": rows_of_commands,
}


def main(words: Sequence[str]) -> None:
    """Measure and print tables, those of some names, with cases of some names."""
    if unknown := set(words) - {*TABLES, *CASES}:
        known = ", ".join([*TABLES, *CASES])
        sys.exit(f"expected tables and cases ({known}), found {', '.join(sorted(unknown))}")
    with tempfile.TemporaryDirectory() as folder:
        cases = {}
        for number, name in enumerate([each for each in CASES if each in words] or CASES):
            place = Path(folder) / str(number)
            place.mkdir()
            cases[name] = CASES[name](place)
        for name in [each for each in TABLES if each in words] or TABLES:
            print(f"\n{name}\n")
            for number, row in enumerate(TABLES[name](cases)):
                print(f"| {' | '.join(row)} |", flush=True)
                if number == 0:
                    print(f"|{'---|' * len(row)}")


if __name__ == "__main__":
    sys.path.insert(0, str(TESTS))
    if sys.argv[1:2] == ["--measure"]:
        print(json.dumps(measure(Path(sys.argv[2]), int(sys.argv[3]))))
    else:
        main(sys.argv[1:])
