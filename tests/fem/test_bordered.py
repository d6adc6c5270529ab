# SPDX-License-Identifier: LGPL-3.0-or-later
"""The bordered factorisation by MUMPS against dense algebra, on one rank and on several."""

from __future__ import annotations

from collections.abc import Iterator

import blocks
import numpy as np
import pytest
from petsc_garbage import replace_meshes
from scipy import sparse

from fretfe._typing import Array
from fretfe.errors import ModelError
from fretfe.fem._compat import MPI, PETSc
from fretfe.fem.bordered import BorderedFactor
from fretfe.fem.elasticity import ElasticBody, Material

pytestmark = pytest.mark.mpi


@pytest.fixture(
    params=[("triangle", 1), ("triangle", 2), ("quadrilateral", 2)],
    ids=["triangle-1", "triangle-2", "quadrilateral-2"],
)
def matrix(request: pytest.FixtureRequest) -> Iterator[PETSc.Mat]:
    """Stiffness of a block clamped on one side, which two ranks share."""
    cell, degree = request.param
    comm = MPI.COMM_WORLD
    lines = blocks.graded(0.0, 1.5, 5), blocks.graded(0.0, 1.0, 4)
    mesh = blocks.block("b", *lines, cell=cell) if comm.rank == 0 else None
    body = ElasticBody(comm, mesh, Material(100.0, 0.3, 0.0, "strain"), degree)
    replace_meshes(body.mesh)
    nodes = body.boundary_nodes("b_left")
    constrained = (nodes[:, None] * 2 + np.arange(2)).ravel().astype(np.int32)
    # Not returned: the matrix uses the communicator of the mesh, which lives as long as `body`.
    yield body.stiffness(np.sort(constrained))


def dense(matrix: PETSc.Mat) -> Array:
    """All rows, on every rank."""
    start, end = matrix.getOwnershipRange()
    rows = np.zeros((end - start, matrix.size[1]))
    pointers, columns, values = matrix.getValuesCSR()
    rows[np.repeat(np.arange(end - start), np.diff(pointers)), columns] = values
    return np.vstack(MPI.COMM_WORLD.allgather(rows))


def border(size: int) -> sparse.csr_matrix:
    """A sparse operator of a few multipliers on unknowns from all over the matrix."""
    rng = np.random.default_rng(11)
    return sparse.random(size // 4, size, density=0.1, random_state=rng, format="csr")


@pytest.mark.parametrize("symmetric", [False, True])
def test_compliance_is_that_of_dense_algebra(matrix: PETSc.Mat, symmetric: bool) -> None:
    full = dense(matrix)
    operator = border(len(full))
    expected = operator @ np.linalg.solve(full, operator.T.toarray())
    compliance = BorderedFactor(matrix, operator, 2, symmetric=symmetric).compliance
    assert (compliance is None) == (matrix.comm.rank > 0)
    found = MPI.COMM_WORLD.bcast(compliance)
    # Direct solution of a well conditioned matrix.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_array_equal(found, found.T)


@pytest.mark.parametrize(("dimension", "symmetric"), [(2, False), (3, False), (3, True)])
def test_solution_is_that_of_dense_algebra(
    matrix: PETSc.Mat, dimension: int, symmetric: bool
) -> None:
    """With the ordering for either dimension; more than once, for several at once."""
    full = dense(matrix)
    factor = BorderedFactor(matrix, border(len(full)), dimension, symmetric=symmetric)
    for count in (0, 1, 3):
        loads = np.random.default_rng(count).standard_normal((count, len(full)))
        sides = [matrix.createVecRight() for _ in loads]
        for side, load in zip(sides, loads, strict=True):
            side.array[:] = load[slice(*side.getOwnershipRange())]
        for solution, load in zip(factor.solve(sides), loads, strict=True):
            found = np.concatenate(MPI.COMM_WORLD.allgather(solution.array.copy()))
            expected = np.linalg.solve(full, load)
            largest = np.abs(expected).max()
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * largest)
    np.testing.assert_array_equal(dense(matrix), full)


def test_a_singular_matrix_is_an_error_in_words() -> None:
    full = sparse.csr_matrix(np.ones((20, 20)))
    csr = full.indptr, full.indices, full.data
    singular = PETSc.Mat().createAIJ(full.shape, csr=csr, comm=MPI.COMM_SELF)
    with pytest.raises(ModelError, match="20 unknowns cannot be factorised: a pivot is zero"):
        BorderedFactor(singular, border(20), 2, symmetric=False)
