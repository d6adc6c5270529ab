# SPDX-License-Identifier: LGPL-3.0-or-later
"""The Schur complement of MUMPS against dense algebra, on one rank and on several."""

from __future__ import annotations

from collections.abc import Iterator

import blocks
import numpy as np
import pytest
from numpy.typing import NDArray
from petsc_garbage import replace_meshes

from fretfe._typing import Array
from fretfe.bodies.body import Material
from fretfe.fem._compat import MPI, PETSc
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.schur import SchurFactorization

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


def split(size: int, retained: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    return retained, np.setdiff1d(np.arange(size), retained)


def chosen(size: int) -> NDArray[np.intp]:
    """Unknowns from all over the matrix, in no order."""
    return np.random.default_rng(11).permutation(size)[: size // 4]


def test_complement_is_that_of_dense_algebra(matrix: PETSc.Mat) -> None:
    full = dense(matrix)
    r, i = split(len(full), chosen(len(full)))
    coupling = np.linalg.solve(full[np.ix_(i, i)], full[np.ix_(i, r)])
    expected = full[np.ix_(r, r)] - full[np.ix_(r, i)] @ coupling
    complement = SchurFactorization(matrix, r).complement
    assert (complement is None) == (matrix.comm.rank > 0)
    found = MPI.COMM_WORLD.bcast(complement)
    # Direct solution of a well conditioned matrix.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_array_equal(found, found.T)


def test_interior_solution_is_that_of_dense_algebra(matrix: PETSc.Mat) -> None:
    full = dense(matrix)
    r, i = split(len(full), chosen(len(full)))
    load = np.random.default_rng(2).standard_normal(len(full))
    load[r] = 0.0
    expected = np.linalg.solve(full[np.ix_(i, i)], load[i])
    rhs = matrix.createVecRight()
    rhs.array[:] = load[slice(*rhs.getOwnershipRange())]
    factor = SchurFactorization(matrix, r)
    parts = MPI.COMM_WORLD.allgather(factor.solve_interior(rhs).array.copy())
    found = np.concatenate(parts)[i]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_a_matrix_is_solved_more_than_once(matrix: PETSc.Mat) -> None:
    """The factorisation stays what it was, and so does the matrix."""
    before = dense(matrix)
    factor = SchurFactorization(matrix, chosen(len(before)))
    rhs = matrix.createVecRight()
    rhs.array[:] = 1.0
    own = np.arange(*rhs.getOwnershipRange())
    rhs.array[np.isin(own, chosen(len(before)))] = 0.0
    first = factor.solve_interior(rhs).array.copy()
    second = factor.solve_interior(rhs).array.copy()
    # On several ranks contributions are added in the order of their arrival.
    np.testing.assert_allclose(second, first, rtol=0, atol=1e-13 * np.abs(first).max())
    np.testing.assert_array_equal(dense(matrix), before)
