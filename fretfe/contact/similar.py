# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear systems that change little from one to the next.

The last iterations of a load step in space leave the status of all nodes as it is and turn their
directions of slip a little, ever less. The factors of the first of these systems precondition the
others: two to seven iterations (measured with 2 400 unknowns) give what another factorisation would
give for five times the work.
"""

from __future__ import annotations

import numpy as np
from scipy import linalg
from scipy.sparse.linalg import LinearOperator, gmres

from fretfe._typing import Array, Indices

# Systems of fewer unknowns are factorised as fast as iterations start.
FEWEST = 500
# Corrections below this fraction of a solution are round-off.
ROUND_OFF = 1e-13
# Iterations and rounds of them after which a factorisation is no more work.
ITERATIONS, ROUNDS = 12, 2


class SimilarSystems:
    """Solver of one linear system after the other, with the factors of an earlier one if they do.

    The solutions are as accurate as those of factors of their own.
    """

    def __init__(self) -> None:
        self._unknowns: Indices | None = None
        self._factors: tuple[Array, Indices]

    def solve(self, unknowns: Indices, matrix: Array, target: Array) -> Array:
        """(k, J) solution of a system.

        Args:
            unknowns: numbers that tell its unknowns from those of other systems.
            matrix: (k, k).
            target: (k, J) right-hand sides.

        Raises:
            numpy.linalg.LinAlgError: if the matrix is singular.
        """
        if len(matrix) < FEWEST:
            return np.linalg.solve(matrix, target)
        if self._unknowns is not None and np.array_equal(unknowns, self._unknowns):
            found = self._iterate(matrix, target)
            if found is not None:
                return found
        factors, pivots, info = linalg.lapack.dgetrf(matrix)
        if info:
            self._unknowns = None
            raise np.linalg.LinAlgError(f"row {info} of the matrix depends on those before it")
        self._unknowns, self._factors = unknowns, (factors, pivots)
        return self._approximate(target)

    def _approximate(self, target: Array) -> Array:
        """Solution with the matrix that was factorised."""
        return np.asarray(linalg.lu_solve(self._factors, target, check_finite=False))

    def _iterate(self, matrix: Array, target: Array) -> Array | None:
        """Solution by preconditioned iterations; None if there would have to be many."""
        columns = [self._column(matrix, column) for column in target.T]
        known = [column for column in columns if column is not None]
        return np.stack(known, axis=1) if len(known) == len(columns) else None

    def _column(self, matrix: Array, target: Array) -> Array | None:
        """(k,) solution of a system with one right-hand side; None as above."""
        similar = LinearOperator(
            matrix.shape, matvec=lambda vector: self._approximate(matrix @ vector), dtype=np.float64
        )
        solution = self._approximate(target)
        for _ in range(ROUNDS + 1):
            missing = self._approximate(target - matrix @ solution)
            round_off = ROUND_OFF * float(np.linalg.norm(solution))
            if np.linalg.norm(missing) <= round_off:
                return np.asarray(solution + missing)
            solution += gmres(
                similar, missing, rtol=0.0, atol=round_off / 100, restart=ITERATIONS, maxiter=1
            )[0]
        return None
