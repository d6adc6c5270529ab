# SPDX-License-Identifier: LGPL-3.0-or-later
"""The bordered factorisation by MUMPS against dense algebra, on one rank and on several."""

from __future__ import annotations

import ctypes
import gc
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from cases import blocks
from harness.petsc_garbage import replace_meshes
from scipy import sparse

from fretfe._typing import Array
from fretfe.case import Solid
from fretfe.errors import ModelError
from fretfe.fem import bordered
from fretfe.fem._compat import DGEMMT, MPI, PETSc
from fretfe.fem.bordered import BorderedFactor
from fretfe.fem.elasticity import ElasticBody, Material
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh

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
    found = MPI.COMM_WORLD.bcast(compliance and compliance.whole())
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


@pytest.mark.parametrize("symmetric", [False, True])
def test_a_factor_on_disk_is_the_same_and_leaves_no_files(
    matrix: PETSc.Mat, symmetric: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two of them at the same time, each with files of its own."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.delenv(bordered.FOLDER, raising=False)
    operator, side = border(matrix.size[0]), matrix.createVecRight()
    side.array[:] = np.cos(np.arange(*side.getOwnershipRange()))
    factors = [
        BorderedFactor(matrix, operator, 3, symmetric=symmetric, on_disk=on_disk)
        for on_disk in (False, True, True)
    ]
    assert bordered.FOLDER not in os.environ
    folders = list(tmp_path.iterdir())
    assert len(folders) == 2
    # A rank may have no part of so small a factor.
    sizes = [sum(file.stat().st_size for file in each.iterdir()) for each in folders]
    assert all(size > 0 for size in MPI.COMM_WORLD.allreduce(np.array(sizes)))
    there = factors[0].solve([side])[0].array.copy()
    for other in factors[1:]:
        found = other.solve([side])[0].array
        # MUMPS distributes its work as it comes: sums differ by round-off on several ranks.
        np.testing.assert_allclose(found, there, rtol=0, atol=1e-12 * np.abs(there).max())
        own, first = other.compliance, factors[0].compliance
        if own is not None and first is not None:
            expected = first.whole()
            largest = np.abs(expected).max()
            np.testing.assert_allclose(own.whole(), expected, rtol=0, atol=1e-12 * largest)
    del factors, other
    gc.collect()
    PETSc.garbage_cleanup(matrix.comm)
    assert not any(tmp_path.iterdir())


def test_a_factor_that_cannot_be_written_is_an_error_in_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = sparse.csr_matrix(np.eye(20))
    csr = full.indptr, full.indices, full.data
    one = PETSc.Mat().createAIJ(full.shape, csr=csr, comm=MPI.COMM_SELF)
    monkeypatch.setattr(tempfile, "mkdtemp", lambda prefix: str(tmp_path / prefix / "gone"))
    with pytest.raises(ModelError, match=r"cannot be written to .* \(TMPDIR names another folder"):
        BorderedFactor(one, border(20), 2, symmetric=True, on_disk=True)


@pytest.mark.parametrize("symmetric", [False, True])
def test_a_singular_matrix_is_an_error_in_words(symmetric: bool) -> None:
    full = sparse.csr_matrix(np.ones((20, 20)))
    csr = full.indptr, full.indices, full.data
    singular = PETSc.Mat().createAIJ(full.shape, csr=csr, comm=MPI.COMM_SELF)
    with pytest.raises(ModelError, match="20 unknowns cannot be factorised: a pivot is zero"):
        BorderedFactor(singular, border(20), 2, symmetric=symmetric)


def test_both_kinds_of_factor_agree_for_a_solid() -> None:
    """With fronts of several hundred unknowns, whose updates are in blocks."""
    comm = MPI.COMM_WORLD
    lines = blocks.graded(0.0, 1.0, 8), blocks.graded(0.0, 1.0, 8)
    flat = Mesh({"b": blocks.block("b", *lines)})
    mesh = extrude(flat, Solid(length=1.0, skew=0.0, layers=6)) if comm.rank == 0 else None
    material = Material(2e5, 0.3, 0.0, "strain")
    body = ElasticBody(comm, mesh.bodies["b"] if mesh else None, material, 2)
    replace_meshes(body.mesh)
    nodes = body.boundary_nodes("b_left")
    matrix = body.stiffness(np.sort((nodes[:, None] * 3 + np.arange(3)).ravel()).astype(np.int32))
    random = np.random.default_rng(4)
    operator = sparse.random(300, matrix.size[0], 0.003, format="csr", random_state=random)
    side = matrix.createVecRight()
    side.array[:] = np.cos(np.arange(*side.getOwnershipRange()))
    found = []
    for symmetric in (False, True):
        factor = BorderedFactor(matrix, operator, 3, symmetric=symmetric)
        compliance = factor.compliance and factor.compliance.whole()
        found.append((compliance, factor.solve([side])[0].array))
    for lu, ldl in zip(*found, strict=True):
        if lu is not None:
            np.testing.assert_allclose(ldl, lu, rtol=0, atol=1e-12 * np.abs(lu).max())


@pytest.fixture
def anew() -> Iterator[None]:
    """The kind of factors is found out in this test, and again afterwards."""
    bordered.unsymmetric_because.cache_clear()
    yield
    bordered.unsymmetric_because.cache_clear()


@pytest.mark.usefixtures("anew")
def test_factors_are_symmetric(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(bordered.SWITCH, raising=False)
    assert bordered.unsymmetric_because() == ""


@pytest.mark.usefixtures("anew")
def test_the_kind_of_factors_can_be_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(bordered.SWITCH, "lu")
    assert bordered.unsymmetric_because() == "FRETFE_FACTORS asks for it"
    bordered.unsymmetric_because.cache_clear()
    monkeypatch.setenv(bordered.SWITCH, "cholesky")
    with pytest.raises(ModelError, match="expected lu or symmetric, found cholesky"):
        bordered.unsymmetric_because()


@pytest.mark.usefixtures("anew")
def test_a_wrong_update_means_lu(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where MUMPS calls a dgemmt, this one adds nothing; elsewhere the trial itself is wrong."""
    monkeypatch.delenv(bordered.SWITCH, raising=False)
    nothing = ctypes.CFUNCTYPE(None)(lambda: None)
    dgemm = ctypes.c_void_p.in_dll(DGEMMT, "fretfe_dgemm")
    before, dgemm.value = dgemm.value, ctypes.cast(nothing, ctypes.c_void_p).value
    if not bordered._needs_dgemmt():
        monkeypatch.setattr(bordered, "_trial_error", lambda: 1.0)
    try:
        assert bordered.unsymmetric_because().startswith("a symmetric factor was wrong in a trial")
    finally:
        dgemm.value = before


PETSC_FIRST = """
try:
    import dolfinx_solver
except ImportError:
    pass
import petsc4py.PETSc
from fretfe.fem.bordered import _needs_dgemmt, unsymmetric_because
print(_needs_dgemmt(), unsymmetric_because())
"""


@pytest.mark.skipif(MPI.COMM_WORLD.size > 1, reason="starts a process")
@pytest.mark.parametrize("asked", ["", "symmetric"])
def test_a_slow_update_means_lu_unless_asked_for(asked: str) -> None:
    """Where PETSc was there before fretfe, MUMPS has found the dgemmt of OpenBLAS."""
    done = subprocess.run(
        [sys.executable, "-P", "-c", PETSC_FIRST],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, bordered.SWITCH: asked},
    )
    slow = done.stdout.startswith("True") and not asked
    assert ("MUMPS calls a dgemmt that may be slow" in done.stdout) is slow
