# SPDX-License-Identifier: LGPL-3.0-or-later
"""A sparse factorisation that also yields the dense Schur complement on chosen unknowns.

MUMPS computes the complement while it factorises. PETSc offers this, petsc4py does not bind it, so
three PETSc functions are called through ctypes.
"""

from __future__ import annotations

import ctypes

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array
from fretfe.fem._compat import PETSc, petsc_library

# MUMPS control: the fill-reducing ordering. Approximate minimum degree is analysed several times
# faster than the default, nested dissection, which does not pay before some million unknowns.
ORDERING_CONTROL = 7
MINIMUM_DEGREE = 0
# MUMPS control: no pivoting. A body fixed at the retained unknowns does not need it.
PIVOTING_CONTROL = 1
# MUMPS control: what a solve does with the Schur unknowns. 0: solve for all others, these fixed.
SCHUR_SOLVE_CONTROL = 26
INTERIOR_ONLY = 0


class SchurFactorization:
    """Factorisation of a symmetric matrix with some unknowns retained. Collective.

    Args:
        matrix: assembled symmetric matrix.
        retained: global numbers of the retained unknowns; the same on all ranks.
    """

    def __init__(self, matrix: PETSc.Mat, retained: npt.NDArray[np.integer]) -> None:
        solver = _unfactored(matrix)
        factor = solver.getFactorMatrix()
        # A distributed matrix needs the whole list on the first rank and none on the others.
        mine = retained if matrix.comm.rank == 0 else retained[:0]
        index_set = PETSc.IS().createGeneral(mine.astype(PETSc.IntType), comm=matrix.comm)
        _call("MatFactorSetSchurIS", factor.handle, index_set.handle)
        solver.setUp()
        self.complement = _read_complement(factor, matrix.comm.rank, len(retained))
        if matrix.comm.size == 1:
            factor.setMumpsIcntl(SCHUR_SOLVE_CONTROL, INTERIOR_ONLY)
            self._interior = solver
        else:  # PETSc cannot solve with a distributed factor that has a Schur complement
            solver.destroy()
            self._interior = _unfactored(_fix(matrix, retained))
            self._interior.setUp()

    def solve_interior(self, rhs: PETSc.Vec) -> PETSc.Vec:
        """Solve for the other unknowns with the retained ones zero. Collective.

        Args:
            rhs: zero at the retained unknowns. The result is undefined there.
        """
        solution = rhs.duplicate()
        self._interior.apply(rhs, solution)
        return solution


def _unfactored(matrix: PETSc.Mat) -> PETSc.PC:
    """A MUMPS factorisation that is not set up yet.

    LU, although the matrix is symmetric: twice the operations, in a third less time. The update of
    a symmetric front needs `dgemmt`, which OpenBLAS (0.3.32) does column by column at a tenth of
    the speed of `dgemm` (https://github.com/OpenMathLib/OpenBLAS/issues/4921).
    """
    solver = PETSc.PC().create(matrix.comm)
    solver.setOperators(matrix)
    solver.setType("lu")
    solver.setFactorSolverType("mumps")
    solver.setFactorSetUpSolverType()
    factor = solver.getFactorMatrix()
    factor.setMumpsIcntl(ORDERING_CONTROL, MINIMUM_DEGREE)
    factor.setMumpsCntl(PIVOTING_CONTROL, 0.0)
    return solver


def _fix(matrix: PETSc.Mat, retained: npt.NDArray[np.integer]) -> PETSc.Mat:
    """The matrix with unit rows and columns at the retained unknowns."""
    start, end = matrix.getOwnershipRange()
    own = retained[(retained >= start) & (retained < end)]
    fixed = matrix.copy()
    fixed.zeroRowsColumns(own.astype(PETSc.IntType), diag=1.0)
    fixed.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return fixed


def _read_complement(factor: PETSc.Mat, rank: int, size: int) -> Array | None:
    """(n, n) Schur complement in the order of the retained unknowns; rank 0 only."""
    handle, status = ctypes.c_void_p(), ctypes.c_int()
    _call(
        "MatFactorCreateSchurComplement",
        factor.handle,
        ctypes.byref(handle),
        ctypes.byref(status),
    )
    complement = _copy_dense(handle, size) if rank == 0 else None
    _call("MatDestroy", ctypes.byref(handle))
    return complement


def _copy_dense(matrix: ctypes.c_void_p, size: int) -> Array:
    """Copy of a sequential dense PETSc matrix, made exactly symmetric."""
    data = ctypes.POINTER(ctypes.c_double)()
    _call("MatDenseGetArrayRead", matrix, ctypes.byref(data))
    values = np.ctypeslib.as_array(data, shape=(size, size))
    copy = (values + values.T) / 2
    _call("MatDenseRestoreArrayRead", matrix, ctypes.byref(data))
    return copy


def _call(name: str, *arguments: object) -> None:
    """Call a PETSc function whose arguments are handles or pointers."""
    converted = [ctypes.c_void_p(a) if isinstance(a, int) else a for a in arguments]
    code = getattr(petsc_library(), name)(*converted)
    if code:
        raise PETSc.Error(code)
