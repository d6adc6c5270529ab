# SPDX-License-Identifier: LGPL-3.0-or-later
"""Room for the work space of the linear algebra, which ends the process where it finds none.

OpenBLAS takes its work space when it is first called. Without room it ends the process by itself or
crashes, and nobody is told. There are as many copies as packages that bring their own, four with
the wheels from PyPI.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import scipy.linalg

from fretfe.environment import address_room
from fretfe.errors import MemoryShortError
from fretfe.fem._compat import MPI, PETSc, basix

# Bytes of address space, which are less of memory: four times 128 MiB.
WORK_SPACE = 4 * 128 * 2**20


def secure_work_space(comm: MPI.Comm) -> None:
    """Have the linear algebra take its work space now, before anything is solved. Collective.

    Raises:
        MemoryShortError: if the address space of a process is limited, and too little is left.
    """
    room = comm.allreduce(address_room(), MPI.MIN)
    if take_work_space.cache_info().currsize == 0 and room < WORK_SPACE:
        raise MemoryShortError(
            f"there is not enough memory: a process may take {room / 2**20:.0f} MiB more (its "
            f"address space is limited, see ulimit -v); expected {WORK_SPACE / 2**20:.0f} MiB, "
            "which the linear algebra may take, and more for the case itself"
        )
    take_work_space()


@cache
def take_work_space() -> None:
    """Call each copy of OpenBLAS once in a process."""
    one = np.eye(2)
    np.linalg.solve(one, one)
    scipy.linalg.solve(one, one)
    basix.create_element(basix.ElementFamily.P, basix.CellType.triangle, 2)
    matrix = PETSc.Mat().createDense((2, 2), array=one, comm=MPI.COMM_SELF)
    matrix.assemble()
    solver = PETSc.KSP().create(MPI.COMM_SELF)
    solver.setOperators(matrix)
    solver.setType("preonly")
    solver.getPC().setType("lu")
    right = matrix.createVecRight()
    solver.solve(right, matrix.createVecRight())
    for each in (solver, matrix, right):
        each.destroy()
