#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Times and memory of runs, phases, factors, ranks, start-up, sweeps and reports: `make bench`.

Prints the tables of docs/performance.md; `tools/bench.py TABLE ... CASE ...` prints some tables, or
some cases of them. Times of one table come from one hour and one machine; ratios to a plain
factorisation of the same stiffness, measured in the same process, compare machines. What fails is
told in its row, and the rest goes on.
"""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
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
# Seconds after which a command is ended.
LONGEST = 1800.0
RANKS = (1, 2, 4)
BY_RANKS = ("B1, h = 0.01", "B1, h = 0.005", "dovetail demo", "sphere, a/8", *LONG)
BY_FACTORS, KINDS = ("B1, h = 0.005", "sphere, a/12"), ("lu", "symmetric")
BY_MEMORY = ("B1, h = 0.005", *LONG)
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
# What `fretfe check` says of memory, in GB.
ESTIMATE = re.compile(r"about ([\d.]+) GB")
# What this file does in processes of its own.
MEASURE, RANK = "--measure", "--rank"

Row = tuple[str, ...]
# Who some rows of a table are about, and what makes them, without that.
Part = tuple[str, Callable[[], Iterable[Row]]]


def write_cylinder(size: float, growth: float, folder: Path) -> Path:
    """Write the benchmark of a cylinder, mesh and case file."""
    from cases.b1 import b1_case
    from cases.b1_meshes import write_b1

    write_b1(folder / "b1.msh", order=2, h=size, growth=growth)
    return write_case(b1_case(folder / "b1.msh", 2, 5.0, "finer"), folder)


def write_sphere(elements: int, folder: Path) -> Path:
    """Write the case of a sphere on a block under two cycles of shear force."""
    from cases.cycled_sphere import FRICTION, cycles, tables

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


@cache
def working_folder() -> tempfile.TemporaryDirectory[str]:
    """A folder that goes with this process."""
    return tempfile.TemporaryDirectory(prefix="fretfe-bench-")


@cache
def case_file(name: str) -> Path:
    """The file of a case."""
    place = Path(working_folder().name) / f"case-{list(CASES).index(name)}"
    place.mkdir(exist_ok=True)
    return CASES[name](place)


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

        if count > 1:
            run()  # forms are compiled, files are read
        model = Model(MPI.COMM_WORLD, case, load_mesh(case), Clock())
        unknowns, factorise = factorisation(model)
        run_time, factorisation_time = shortest([run, factorise], count)
    return {
        "unknowns": unknowns,
        "tractions": model.components * model.reduction.interface.size,
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


def spent(command: Sequence[str | Path], **more: str) -> Spent:
    """Run a command, with one thread in each of its processes and more in its environment.

    Raises:
        RuntimeError: if it fails, or takes too long; with the last thing that it said.
    """
    start = time.perf_counter()
    environment = {**os.environ, **ONE_THREAD, **more}
    with tempfile.TemporaryFile("w+") as said:
        quiet = subprocess.DEVNULL
        process = subprocess.Popen(command, stdout=quiet, stderr=said, env=environment)
        alarm = threading.Timer(LONGEST, process.terminate)
        alarm.start()
        _, status, used = os.wait4(process.pid, 0)
        alarm.cancel()
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            said.seek(0)
            lines = said.read().split("\n")
            last = next((line for line in reversed(lines) if line.strip()), "nothing said")
            raise RuntimeError(f"exit code {process.returncode} after {wall:.0f} s: {last}")
    return Spent(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 2**20)


def least(*words: str | Path) -> Spent:
    """The shortest of some runs of a command."""
    return min((spent(words) for _ in range(ROUNDS)), key=lambda each: each.wall)


def fretfe(*words: str | Path) -> Spent:
    """The shortest of some runs of a command of fretfe."""
    return least(BIN / "fretfe", *words)


@dataclass(frozen=True)
class Run:
    """What a whole `fretfe run` without report took.

    Attributes:
        whole: all of it.
        ranks: each of its ranks.
        seconds: wall time of each phase.
    """

    whole: Spent
    ranks: tuple[Spent, ...]
    seconds: Mapping[str, float]


def run_once(path: Path, ranks: int = 1, **more: str) -> Run:
    """Run a case on some ranks, with more in its environment."""
    with tempfile.TemporaryDirectory() as output, tempfile.TemporaryDirectory() as notes:
        words = ["run", str(path), "-o", output, "--no-report", "-q"]
        if ranks == 1:
            each = [whole := spent([str(BIN / "fretfe"), *words], **more)]
        else:
            launched = [str(BIN / "mpirun"), "-n", str(ranks), sys.executable, __file__]
            whole = spent([*launched, RANK, notes, *words], **more)
            each = [Spent(**json.loads(note.read_text())) for note in Path(notes).iterdir()]
        numbers = json.loads((Path(output) / "results.json").read_text())
    return Run(whole, tuple(each), numbers["seconds"])


def run_as_rank(notes: Path, words: Sequence[str]) -> None:
    """A command of fretfe on a rank, which notes what it took."""
    from fretfe.__main__ import main as command

    start = time.perf_counter()
    sys.argv[1:] = words
    try:
        command()
    finally:
        used = resource.getrusage(resource.RUSAGE_SELF)
        wall = time.perf_counter() - start
        own = Spent(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 2**20)
        (notes / f"{os.getpid()}").write_text(json.dumps(asdict(own)))


@cache
def run(name: str, ranks: int) -> Run:
    """The shortest of some runs of a case; once for all tables."""
    runs = (run_once(case_file(name), ranks) for _ in range(count_of(name)))
    return min(runs, key=lambda each: each.whole.wall)


def in_a_process(path: Path, count: int) -> dict[str, Any]:
    """`measure` in a process of its own with one thread."""
    command = [sys.executable, __file__, MEASURE, str(path), str(count)]
    environment = {**os.environ, **ONE_THREAD}
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment, timeout=LONGEST, check=False
    )
    if done.returncode:
        raise RuntimeError(f"exit code {done.returncode}: {done.stderr.strip()[-300:]}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


@cache
def measured(name: str) -> dict[str, Any]:
    """`in_a_process` for a case, once for all tables."""
    return in_a_process(case_file(name), count_of(name))


def rows_of_run(name: str) -> Iterator[Row]:
    """A whole run over one factorisation, and its memory beside what was estimated."""
    # The whole run first: it compiles what is not compiled yet.
    run(name, 1)
    found, whole = measured(name), run(name, 1).whole
    checked = subprocess.run(
        [BIN / "fretfe", "check", case_file(name)], capture_output=True, text=True, check=True
    )
    estimate = ESTIMATE.search(checked.stdout)
    yield (
        f"{found['unknowns']}",
        f"{found['tractions']}",
        f"{whole.wall:.1f}",
        f"{whole.memory:.2f}",
        estimate[1] if estimate else "",
        f"{found['run']:.2f}",
        f"{found['factorisation']:.2f}",
        f"{found['run'] / found['factorisation']:.1f}",
        f"{1e3 * found['seconds']['steps'] / found['steps']:.1f}",
    )


def rows_of_phases(name: str) -> Iterator[Row]:
    """Seconds of each phase of the last run in a process, and of one factorisation there."""
    found = measured(name)
    phases = (found["seconds"].get(each, 0.0) for each in PHASES)
    yield (*(f"{each:.2f}" for each in phases), f"{found['factorisation']:.2f}")


def rows_of_factors(name: str) -> Iterator[Row]:
    """LU and symmetric factors in turn: condensation, whole run and memory, and their ratios."""
    runs: dict[str, list[Run]] = {kind: [] for kind in KINDS}
    for _ in range(count_of(name)):
        for kind, each in runs.items():
            each.append(run_once(case_file(name), FRETFE_FACTORS=kind))
    best = [min(each, key=lambda run: run.whole.processor) for each in runs.values()]
    for what, values in {
        "condensation, s of wall": [each.seconds["condensation"] for each in best],
        "whole run, s of processor": [each.whole.processor for each in best],
        "peak memory, GB": [each.whole.memory for each in best],
    }.items():
        lu, symmetric = values
        yield what, f"{lu:.2f}", f"{symmetric:.2f}", f"{symmetric / lu:.2f}"


def rows_of_memory(name: str) -> Iterator[Row]:
    """Resident memory of a run at the end of each phase, and most within it."""
    with tempfile.TemporaryDirectory() as output:
        words = ["run", str(case_file(name)), "-o", output, "--no-report"]
        command = [str(BIN / "fretfe"), *words]
        # Lines come when they are printed.
        environment = {**os.environ, **ONE_THREAD, "PYTHONUNBUFFERED": "1"}
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, text=True, env=environment
        ) as process:
            assert process.stdout is not None
            process_files, phase = Path(f"/proc/{process.pid}"), "start"
            for line in process.stdout:
                begun = phase_of(line)
                if begun is None or begun == phase:
                    continue
                status = (process_files / "status").read_text()
                now, most = (
                    int(value) // 1024
                    for value in re.findall(r"Vm(?:RSS|HWM):\s*(\d+) kB", status)[::-1]
                )
                yield phase, f"{now}", f"{most}"
                # From now on the largest value is that of the next phase.
                (process_files / "clear_refs").write_text("5")
                phase = begun
        if process.returncode:
            raise RuntimeError(f"exit code {process.returncode}")


def phase_of(line: str) -> str | None:
    """The phase of which a line of a run tells that it begins, or "end"; None if of none."""
    if line.startswith("Results in "):
        return "end"
    if line.startswith("step "):
        return "steps"
    if not line.endswith(" ...\n"):
        return None
    return re.sub(r"(: (state )?\d+ of \d+|, \d+ unknowns)$", "", line.removesuffix(" ...\n"))


def rows_of_phases_on_ranks(name: str, ranks: int) -> Iterator[Row]:
    """Seconds of each phase on some ranks, and over those of one rank."""
    one, each = run(name, 1).seconds, run(name, ranks).seconds
    phases = ((each.get(phase, 0.0), one.get(phase, 0.0)) for phase in PHASES)
    yield (
        f"{ranks}",
        *(f"{now:.2f} ({now / alone:.2f})" if alone else f"{now:.2f}" for now, alone in phases),
    )


def rows_of_ranks(name: str, ranks: int) -> Iterator[Row]:
    """Wall time over that of one rank, processor time, and memory of the largest rank."""
    factorisation, one = measured(name)["factorisation"], run(name, 1)
    each = run(name, ranks)
    yield (
        f"{ranks}",
        f"{each.whole.wall:.1f}",
        f"{each.whole.wall / one.whole.wall:.2f}",
        f"{each.whole.processor:.1f}",
        f"{each.whole.processor / factorisation:.1f}",
        f"{max(rank.processor for rank in each.ranks):.1f}",
        f"{max(rank.memory for rank in each.ranks):.2f}",
    )


@cache
def dolfinx_alone() -> Spent:
    """What it takes to import DOLFINx."""
    return least(sys.executable, "-c", "import fretfe.fem._compat")


@cache
def results_of(name: str) -> Path:
    """Results of a demo, without report."""
    output = Path(working_folder().name) / f"results-{name}"
    spent([BIN / "fretfe", "run", demo(name, ROOT), "-o", output, "--no-report", "-q"])
    return output


def report(name: str) -> Spent:
    """What the report of a demo takes."""
    return fretfe("report", results_of(name))


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


COMMANDS: dict[str, Callable[[], Spent]] = {
    "DOLFINx alone": dolfinx_alone,
    "imports until a mesh is begun": partial(least, sys.executable, "-c", BEGUN),
    "imports of a plane run": partial(least, sys.executable, "-c", IMPORTS),
    "`fretfe --help`": partial(fretfe, "--help"),
    "`fretfe check`, hertz demo": partial(fretfe, "check", demo("hertz", ROOT)),
    "`fretfe report`, dovetail demo": partial(report, "dovetail"),
    "`fretfe report`, dovetail of solids": partial(report, "dovetail_solid"),
    "a further friction coefficient in a sweep of the dovetail demo": partial(
        further, "contacts.*.friction=0.6", *FRICTIONS
    ),
    "a further last segment of its loads": partial(further, f"{WAVE}=600", *AMPLITUDES),
}


def rows_of_command(name: str) -> Iterator[Row]:
    """Wall and processor time of a command."""
    each = COMMANDS[name]()
    ratio = each.processor / dolfinx_alone().processor
    yield f"{each.wall:.2f}", f"{each.processor:.2f}", f"{ratio:.2f}"


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        header: names of its columns.
        parts: its rows, if these are the cases that are wanted.
    """

    header: Row
    parts: Callable[[Sequence[str]], Iterable[Part]]


def by_case(
    rows: Callable[[str], Iterable[Row]], names: Sequence[str], cases: Sequence[str]
) -> Iterator[Part]:
    """Rows of those of some cases that are wanted."""
    return ((name, partial(rows, name)) for name in names if name in cases)


def by_ranks(rows: Callable[[str, int], Iterable[Row]], cases: Sequence[str]) -> Iterator[Part]:
    """A row for each case and number of ranks."""
    for name in BY_RANKS:
        if name in cases:
            yield from ((name, partial(rows, name, ranks)) for ranks in RANKS)


TABLES: dict[str, Table] = {
    "runs": Table(
        (
            *("case", "unknowns", "tractions", "whole run, s", "GB", "estimated GB"),
            *("after imports, s", "one factorisation, s", "ratio", "a step, ms"),
        ),
        partial(by_case, rows_of_run, list(CASES)),
    ),
    "phases": Table(
        ("case", *PHASES, "one factorisation"), partial(by_case, rows_of_phases, list(CASES))
    ),
    "factors": Table(
        ("case", "", "LU", "symmetric", "ratio"), partial(by_case, rows_of_factors, BY_FACTORS)
    ),
    "memory": Table(
        ("case", "phase", "resident at its end, MB", "most within it, MB"),
        partial(by_case, rows_of_memory, BY_MEMORY),
    ),
    "ranks": Table(
        (
            *("case", "ranks", "whole run, s", "of 1 rank", "processor, s"),
            *("over one factorisation", "of the busiest rank, s", "GB of the largest"),
        ),
        partial(by_ranks, rows_of_ranks),
    ),
    "phases on ranks": Table(
        ("case", "ranks", *PHASES), partial(by_ranks, rows_of_phases_on_ranks)
    ),
    "commands": Table(
        ("command", "wall, s", "processor, s", "over DOLFINx alone"),
        lambda _: by_case(rows_of_command, list(COMMANDS), list(COMMANDS)),
    ),
}


def print_table(header: Row, parts: Iterable[Part]) -> list[str]:
    """Print a table, row by row; return whose rows failed."""
    failed = []
    print_row(header)
    print(f"|{'---|' * len(header)}", flush=True)
    for name, rows in parts:
        try:
            for row in rows():
                print_row((name, *row))
        except Exception as error:
            failed.append(name)
            print_row((name, f"failed: {type(error).__name__}: {error}"))
    return failed


def print_row(row: Row) -> None:
    """Print a row at once."""
    cells = (cell.replace("|", "/").replace("\n", " ") for cell in row)
    print(f"| {' | '.join(cells)} |", flush=True)


def main(words: Sequence[str]) -> None:
    """Measure and print tables, those of some names, with cases of some names.

    Exit code 1 if something failed.
    """
    if unknown := set(words) - {*TABLES, *CASES}:
        known = ", ".join([*TABLES, *CASES])
        sys.exit(f"expected tables and cases ({known}), found {', '.join(sorted(unknown))}")
    cases = [each for each in CASES if each in words] or list(CASES)
    start, failed = time.perf_counter(), []
    for name in [each for each in TABLES if each in words] or TABLES:
        if parts := list(TABLES[name].parts(cases)):
            print(f"\n{name}\n")
            failed += [f"{name} of {each}" for each in print_table(TABLES[name].header, parts)]
    print(f"\n{(time.perf_counter() - start) / 60:.0f} minutes", flush=True)
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    sys.path.insert(0, str(TESTS))
    if sys.argv[1:2] == [MEASURE]:
        print(json.dumps(measure(Path(sys.argv[2]), int(sys.argv[3]))))
    elif sys.argv[1:2] == [RANK]:
        run_as_rank(Path(sys.argv[2]), sys.argv[3:])
    else:
        main(sys.argv[1:])
