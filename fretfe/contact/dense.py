# SPDX-License-Identifier: LGPL-3.0-or-later
"""Large dense matrices, worked on by as many cores as the run has.

The interface lies in one process. Its matrices are factorised and multiplied block by block, each
block by one thread of the BLAS that SciPy has; the result does not depend on how many threads there
are, but for the round-off of symmetric products. The threads of a BLAS itself would wait for one
another in the middle of a product, for very long where others want the same cores.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cython_blas, cython_lapack

from fretfe._core import _kernels
from fretfe._typing import Array, Indices

# In the order of the table of the extension.
ROUTINES: tuple[tuple[Mapping[str, Any], tuple[str, ...]], ...] = (
    (cython_blas.__pyx_capi__, ("gemm", "gemv", "syrk", "trsm", "trmm", "symv")),
    (cython_lapack.__pyx_capi__, ("getrf", "potrf", "trtri")),
)


def routine_addresses(precision: str) -> list[int]:
    """Addresses of SciPy's routines, which it tells in capsules for compiled code.

    Args:
        precision: "s" or "d".
    """
    api = ctypes.pythonapi
    name = ctypes.PYFUNCTYPE(ctypes.c_char_p, ctypes.py_object)(("PyCapsule_GetName", api))
    pointer = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(
        ("PyCapsule_GetPointer", api)
    )
    capsules = [known[precision + each] for known, names in ROUTINES for each in names]
    return [pointer(capsule, name(capsule)) for capsule in capsules]


_kernels.use_routines(routine_addresses("s"), routine_addresses("d"))


def use_threads(count: int) -> None:
    """Have so many threads work on large matrices from now on; one until this is called."""
    _kernels.use_threads(count)


def factorise(matrix: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int32], int]:
    """LU factors and pivots, as `scipy.linalg.lu_factor`, and the first dependent row, or 0.

    Args:
        matrix: (n, n) by columns, of single or double precision; it is overwritten.
    """
    pivots = np.empty(len(matrix), np.int32)
    failed = _kernels.factorise(matrix, pivots)
    return matrix, pivots, failed


def invert_triangle(matrix: Array) -> Array:
    """Inverse of the upper triangle U of A = U^T U in the place of that of A.

    Args:
        matrix: (n, n) A by columns, symmetric; its lower triangle is left alone.

    Raises:
        numpy.linalg.LinAlgError: if A is not positive definite.
    """
    if row := _kernels.invert_triangle(matrix):
        raise np.linalg.LinAlgError(f"row {row} of the matrix is not positive definite")
    return matrix


def multiply_symmetric(matrix: Array, vector: Array) -> Array:
    """(n,) a symmetric matrix (n, n) by rows times a vector (n,): half of it is read."""
    found = np.empty(len(vector))
    _kernels.multiply_symmetric(matrix, np.ascontiguousarray(vector), found)
    return found


def multiply(matrix: Array, vectors: Array) -> Array:
    """(r, J) a matrix (r, n), whose rows or columns are contiguous, times vectors (n, J)."""
    found = np.empty((len(matrix), vectors.shape[1]), order="F")
    _kernels.multiply(matrix, np.asfortranarray(vectors), found)
    return found


def multiply_triangle(matrix: Array, vectors: Array, *, transpose: bool = False) -> Array:
    """(n, J) the upper triangle of a matrix (n, n) by columns times vectors (n, J)."""
    found = np.empty(vectors.shape, order="F")
    _kernels.multiply_triangle(matrix, transpose, np.asfortranarray(vectors), found)
    return found


def gather(matrix: Array, rows: Indices, columns: Indices, into: Array | None = None) -> Array:
    """(r, c) some rows and columns of a matrix by rows; a copy.

    Args:
        matrix: matrix.
        rows: (r,) numbers.
        columns: (c,) numbers.
        into: (r, c) rows of another matrix that it is written to.
    """
    found = np.empty((len(rows), len(columns))) if into is None else into
    _kernels.gather(matrix, rows, columns, found)
    return found


def combine_rows(matrix: Array, rows: Indices, weights: Array, size: int) -> Array:
    """(n, J) sum of some rows of a matrix by rows, times weights.

    Args:
        matrix: matrix.
        rows: (k,) numbers.
        weights: (k, J).
        size: n, of the columns that are wanted, the first ones.
    """
    found = np.zeros((size, weights.shape[1]), order="F")
    _kernels.combine_rows(matrix, rows, np.asfortranarray(weights), found)
    return found
