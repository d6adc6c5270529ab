#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Times of whole runs, of their steps and of ranks, side by side: `make bench`.

Prints the tables of docs/performance.md. Times of one table come from one hour and one machine;
ratios to a plain factorisation of the same stiffness, measured in the same process, compare
machines.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
TESTS = ROOT / "tests"
# Name, element size at the contact and growth of the sizes; a cylinder on a block.
CYLINDERS = (("B1, h = .02", 0.02, 0.15), ("B1, h = .01", 0.01, 0.1), ("B1, h = .005", 0.005, 0.05))
COLUMNS = (
    "case",
    "unknowns",
    "tractions",
    "whole run, s",
    "after imports, s",
    "one factorisation, s",
    "ratio",
    "a step, ms",
    "2 ranks, s",
    "of 1 rank",
)
# Runs and factorisations that take turns; the shortest of each counts.
ROUNDS = 3
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def write_cylinder(folder: Path, size: float, growth: float) -> Path:
    """Write the benchmark of a cylinder, mesh and case file."""
    sys.path.insert(0, str(TESTS))
    from cases_b1 import b1_case
    from meshes_b1 import write_b1

    from fretfe.case import case_text, parse_case

    folder.mkdir()
    write_b1(folder / "b1.msh", order=2, h=size, growth=growth)
    path = folder / "b1.toml"
    path.write_text(case_text(parse_case(b1_case(folder / "b1.msh", 2, 5.0, "finer"))))
    return path


def shortest(works: Sequence[Callable[[], object]]) -> list[float]:
    """Shortest times of some works that take turns, so that a slow minute hits all of them alike.

    Processor time outside the kernel, which no other process changes much.
    """

    def seconds(work: Callable[[], object]) -> float:
        start = os.times().user
        work()
        return os.times().user - start

    rounds = [[seconds(work) for work in works] for _ in range(ROUNDS)]
    return [min(times) for times in zip(*rounds, strict=True)]


def measure(path: Path) -> dict[str, Any]:
    """A run without imports, and plain factorisations of its stiffness, in this process."""
    from fretfe.case import load_case
    from fretfe.fem._compat import MPI
    from fretfe.fem.backend import BACKEND
    from fretfe.fem.model import Model
    from fretfe.fem.timing import Clock
    from fretfe.results.writer import write_results
    from fretfe.surface.checks import load_mesh

    case = load_case(path)
    with tempfile.TemporaryDirectory() as folder:

        def run() -> Any:
            result = replace(BACKEND.solve(case), backend="fem")
            write_results(Path(folder), result)
            return result

        result = run()  # forms are compiled, files are read
        model = Model(MPI.COMM_WORLD, case, load_mesh(case), Clock())
        unknowns, factorise = factorisation(model)
        run_time, factorisation_time = shortest([run, factorise])
    return {
        "unknowns": unknowns,
        "tractions": 2 * model.reduction.interface.size,
        "steps": len(result.loads.times) - 1,
        "run": run_time,
        "factorisation": factorisation_time,
        "seconds": result.seconds,
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


def in_a_process(path: Path) -> dict[str, Any]:
    """`measure` in a process of its own, with one thread."""
    command = [sys.executable, __file__, "--measure", str(path)]
    environment = {**os.environ, **ONE_THREAD}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def wall(path: Path, ranks: int) -> float:
    """Wall time of a whole `fretfe run` without report."""
    folder = Path(sys.executable).parent
    launcher = [str(folder / "mpirun"), "-n", str(ranks)] if ranks > 1 else []
    with tempfile.TemporaryDirectory() as output:
        words = ["run", str(path), "-o", output, "--no-report", "-q"]
        start = time.perf_counter()
        subprocess.run(
            [*launcher, str(folder / "fretfe"), *words],
            check=True,
            capture_output=True,
            env={**os.environ, **ONE_THREAD},
        )
        return time.perf_counter() - start


def main() -> None:
    """Measure all cases and print the tables."""
    with tempfile.TemporaryDirectory() as folder:
        cases = {
            name: write_cylinder(Path(folder) / str(size), size, growth)
            for name, size, growth in CYLINDERS
        }
        cases["dovetail demo"] = ROOT / "demos" / "dovetail.toml"
        print(f"| {' | '.join(COLUMNS)} |")
        print(f"|{'---|' * len(COLUMNS)}")
        for name, path in cases.items():
            found = in_a_process(path)
            one, two = (min(wall(path, ranks) for _ in range(2)) for ranks in (1, 2))
            cells = (
                name,
                f"{found['unknowns']}",
                f"{found['tractions']}",
                f"{one:.1f}",
                f"{found['run']:.2f}",
                f"{found['factorisation']:.2f}",
                f"{found['run'] / found['factorisation']:.1f}",
                f"{1e3 * found['seconds']['steps'] / found['steps']:.1f}",
                f"{two:.1f}",
                f"{two / one:.2f}",
            )
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--measure"]:
        print(json.dumps(measure(Path(sys.argv[2]))))
    else:
        main()
