# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cost of a whole run in units of one factorisation of the same stiffness, in processor time.

Times are compared within one process with one thread, the shortest of several each, so that the
machine does not matter much. Only time outside the kernel counts: what the kernel takes to hand out
memory depends on what ran on the machine before. Imports and the compilation of forms do not count
either: a small run comes first.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import os, sys
from dataclasses import replace
from pathlib import Path
sys.path.insert(0, sys.argv[1])
sys.path.insert(0, sys.argv[1] + "/fem")
import test_b1
from fretfe.case import parse_case
from fretfe.fem._compat import MPI, PETSc
from fretfe.fem.backend import BACKEND
from fretfe.fem.model import Model
from fretfe.surface.load import load_mesh
from fretfe.fem.timing import Clock
from fretfe.results.writer import write_results
from meshes_b1 import write_b1
from scipy.sparse import block_diag, csr_matrix

folder, h, growth = Path(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4])


def case(name, size, growth):
    write_b1(folder / name, order=2, h=size, growth=growth)
    return parse_case(test_b1.b1_case(folder / name, 2, 5.0, "finer"))


def whole_run(case):
    write_results(folder, replace(BACKEND.solve(case), backend="fem"))


whole_run(case("warm.msh", 0.1, 0.3))
measured = case("measured.msh", h, growth)


def shortest(work, times):
    def seconds():
        start = os.times().user
        work()
        return os.times().user - start

    return min(seconds() for _ in range(times))


run_time = shortest(lambda: whole_run(measured), 2)

model = Model(MPI.COMM_WORLD, measured, load_mesh(measured), Clock())
parts = [csr_matrix(body._matrix.getValuesCSR()[::-1]) for body in model.bodies.values()]
whole = block_diag(parts).tocsr()
stiffness = PETSc.Mat().createAIJ(whole.shape, csr=(whole.indptr, whole.indices, whole.data))
stiffness.setOption(PETSc.Mat.Option.SYMMETRIC, True)


def factorise():
    factor = PETSc.PC().create(MPI.COMM_WORLD)
    factor.setOperators(stiffness)
    factor.setType("cholesky")
    factor.setFactorSolverType("mumps")
    factor.setUp()
    factor.destroy()


print(run_time, shortest(factorise, 3))
"""


@pytest.mark.slow
@pytest.mark.speed
@pytest.mark.parametrize(
    ("h", "growth", "limit"), [(0.02, 0.15, 10), (0.005, 0.05, 3)], ids=["h .02", "h .005"]
)
def test_cost_in_factorisations(tmp_path: Path, h: float, growth: float, limit: float) -> None:
    tests = Path(__file__).parents[1]
    arguments = [sys.executable, "-c", SCRIPT, str(tests), str(tmp_path), str(h), str(growth)]
    done = subprocess.run(
        arguments,
        capture_output=True,
        text=True,
        check=True,
        timeout=600,
        env={"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "HOME": str(Path.home())},
    )
    run, factorisation = map(float, done.stdout.split()[-2:])
    print(f"run {run:.2f} s, factorisation {factorisation:.2f} s, ratio {run / factorisation:.2f}")
    assert run < limit * factorisation
