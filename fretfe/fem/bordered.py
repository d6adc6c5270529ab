# SPDX-License-Identifier: LGPL-3.0-or-later
"""A sparse factorisation that also yields the compliance at the contact multipliers.

A stiffness K bordered by the operator B of the multipliers is factorised with the multipliers as
Schur variables:

    [ K  Bᵀ ]
    [ B  0  ]    leaves    −B K⁻¹ Bᵀ,

the compliance itself, while all displacements, those of the contact surfaces too, are eliminated
sparsely. MUMPS computes the complement while it factorises. PETSc offers this, petsc4py does not
bind it, so a few PETSc functions are called through ctypes.

Factors are symmetric, L D Lᵀ: half the operations of LU, and half the memory. MUMPS may update
symmetric fronts with `dgemmt`, which OpenBLAS (0.3.32) does column by column at a third of the
speed of `dgemm` (https://github.com/OpenMathLib/OpenBLAS/issues/4921). So `fretfe/_core/gemmt.cpp`
has one in halves, which `_compat` loads before PETSc; a symmetric factorisation then takes two
thirds of the time of LU, without it as long as LU or longer. In Debian's packages MUMPS does
without `dgemmt`, and symmetric factors are the faster ones too.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import tempfile
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numpy as np
from scipy import sparse

from fretfe.environment import loaded_libraries
from fretfe.errors import MemoryShortError, ModelError
from fretfe.fem._compat import DGEMMT, PETSc, petsc_library
from fretfe.fem.symmetric import SymmetricMatrix

# MUMPS control: the fill-reducing ordering. Approximate minimum degree is analysed several times
# faster than nested dissection, which pays in three dimensions only.
ORDERING_CONTROL = 7
MINIMUM_DEGREE = 0
NESTED_DISSECTION = 5
# MUMPS control: no pivoting. A body that cannot move freely does not need it.
PIVOTING_CONTROL = 1
# MUMPS control: what a solve does with the Schur unknowns. 0: solve for all others, these zero.
SCHUR_SOLVE_CONTROL = 26
INTERIOR_ONLY = 0
# MUMPS control: of the Schur complement of a symmetric matrix only one triangle is returned, the
# lower one by columns unless this says by rows.
SCHUR_CONTROL = 19
BY_ROWS = 1
# The same control says whether there is a complement. MUMPS reads it when it analyses a matrix and
# not again. PETSc reads it before it lets several ranks solve, and refuses with a complement
# (`MatMatSolve_MUMPS`, 3.22 to 3.25), although MUMPS can; so it is taken back after factorisation.
NO_COMPLEMENT = 0
# MUMPS control: a factor goes to files while it is made, and is read from them by each solve. In
# memory stay the fronts of the moment. The environment variable names the folder.
FILES_CONTROL = 22
ON_DISK = 1
FOLDER = "MUMPS_OOC_TMPDIR"
# By this name a factor keeps the folder of its files.
FILES = "fretfe_files"
# MUMPS error: files cannot be written or read.
NO_FILES = -90
# MUMPS errors: work space cannot be allocated, or is too small.
OUT_OF_MEMORY = (-5, -7, -8, -9, -13, -17, -19, -20)


# The environment variable that chooses the factors, for comparisons: "lu" or "symmetric".
SWITCH = "FRETFE_FACTORS"
# Unknowns and multipliers of the trial of a symmetric factorisation, large enough for blocks.
TRIAL = 160
TRIAL_BORDER = 80
# By this much of its largest entry may the compliance of the trial be off.
TRIAL_TOLERANCE = 1e-12


class BorderedFactor:
    """Factorisation of a symmetric matrix K, and the compliance B K⁻¹ Bᵀ. Collective.

    Args:
        matrix: K, assembled.
        border: (n, N) B, all of it on every rank; zero at unknowns that are fixed in K.
        dimension: of space, 2 or 3.
        symmetric: L D Lᵀ, not LU; the same on all ranks.
        on_disk: whether the factor is kept in temporary files, which vanish with it, or at the end
            of the process; the same on all ranks.

    Attributes:
        matrix: K.
        compliance: (n, n), on rank 0; None elsewhere.
    """

    def __init__(
        self,
        matrix: PETSc.Mat,
        border: sparse.csr_matrix,
        dimension: int,
        *,
        symmetric: bool,
        on_disk: bool = False,
    ) -> None:
        self.matrix = matrix
        comm, end = matrix.comm, matrix.getOwnershipRange()[1]
        count = border.shape[0]
        bordered = _bordered(matrix, border)
        solver = _unfactored(bordered, dimension, symmetric, on_disk)
        factor = self._factor = solver.getFactorMatrix()
        # A distributed matrix needs the whole list on the first rank and none on the others.
        mine = end + np.arange(count if comm.rank == 0 else 0)
        index_set = PETSc.IS().createGeneral(mine.astype(PETSc.IntType), comm=comm)
        _call("MatFactorSetSchurIS", factor.handle, index_set.handle)
        _set_up(solver, count)
        _destroy(solver, bordered)
        self.compliance = _take_complement(factor, comm.rank, count)
        factor.setMumpsIcntl(SCHUR_CONTROL, NO_COMPLEMENT)
        factor.setMumpsIcntl(SCHUR_SOLVE_CONTROL, INTERIOR_ONLY)

    def solve(self, sides: list[PETSc.Vec]) -> list[PETSc.Vec]:
        """K⁻¹ times vectors, all at once: reading the factor is most of the work. Collective."""
        if not sides:
            return []
        (rows, size), _ = self._factor.getSizes()
        own = len(sides[0].array)
        values = np.zeros((rows, len(sides)), order="F")
        for column, side in zip(values.T, sides, strict=True):
            column[:own] = side.array
        shape = (rows, size), (None, len(sides))
        rhs = PETSc.Mat().createDense(shape, array=values, comm=self.matrix.comm)
        rhs.assemble()
        found = rhs.duplicate()
        self._factor.matSolve(rhs, found)
        solutions = [side.duplicate() for side in sides]
        for column, solution in zip(found.getDenseArray().T, solutions, strict=True):
            solution.array[:] = column[:own]
        _destroy(rhs, found)
        return solutions


@cache
def unsymmetric_because() -> str:
    """Tell why the factors of bodies are LU here; empty where symmetric ones are used.

    Symmetric ones must pass a trial, and MUMPS must take its updates from `gemmt.cpp` if it takes
    them from a `dgemmt` at all. Each process finds out once, in milliseconds.

    Raises:
        ModelError: if the environment variable asks for another kind of factor.
    """
    asked = os.environ.get(SWITCH, "")
    if asked not in ("", "lu", "symmetric"):
        raise ModelError(f"{SWITCH}: expected lu or symmetric, found {asked}")
    if asked == "lu":
        return f"{SWITCH} asks for it"
    calls = ctypes.c_long.in_dll(DGEMMT, "fretfe_dgemmt_calls")
    before = calls.value
    if (error := _trial_error()) > TRIAL_TOLERANCE:
        return f"a symmetric factor was wrong in a trial (relative error {error:.1e})"
    if calls.value == before and asked != "symmetric" and _needs_dgemmt():
        return "MUMPS calls a dgemmt that may be slow, not that of fretfe"
    return ""


def _trial_error() -> float:
    """Relative error of the compliance that a small symmetric factorisation gives."""
    random = np.random.default_rng(7)
    full = random.standard_normal((TRIAL, TRIAL))
    full = full @ full.T + TRIAL * np.eye(TRIAL)
    border = sparse.csr_matrix(random.standard_normal((TRIAL_BORDER, TRIAL)))
    stored = sparse.csr_matrix(full)
    csr = stored.indptr, stored.indices, stored.data
    matrix = PETSc.Mat().createAIJ(full.shape, csr=csr, comm=PETSc.COMM_SELF)
    try:
        found = BorderedFactor(matrix, border, 2, symmetric=True).compliance
    except ModelError:
        return np.inf
    expected = border @ np.linalg.solve(full, border.T.toarray())
    assert found is not None
    return float(np.abs(found.whole() - expected).max() / np.abs(expected).max())


def _needs_dgemmt() -> bool:
    """Tell whether a library with MUMPS refers to a `dgemmt`, or what it refers to is unknown."""
    libraries = loaded_libraries("mumps", "petsc")
    return not libraries or any(b"\0dgemmt" in Path(each).read_bytes() for each in libraries)


def _unfactored(matrix: PETSc.Mat, dimension: int, symmetric: bool, on_disk: bool) -> PETSc.PC:
    """A MUMPS factorisation that is not set up yet."""
    matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    solver = PETSc.PC().create(matrix.comm)
    solver.setOperators(matrix)
    solver.setType("cholesky" if symmetric else "lu")
    solver.setFactorSolverType("mumps")
    solver.setFactorSetUpSolverType()
    factor = solver.getFactorMatrix()
    factor.setMumpsIcntl(ORDERING_CONTROL, MINIMUM_DEGREE if dimension == 2 else NESTED_DISSECTION)
    factor.setMumpsCntl(PIVOTING_CONTROL, 0.0)
    if on_disk:
        factor.setMumpsIcntl(FILES_CONTROL, ON_DISK)
        # MUMPS takes an error of files that are gone: they live as long as the factor itself.
        factor.setAttr(FILES, _Files())
    return solver


def _destroy(*objects: PETSc.Object) -> None:
    """Destroy large objects now: of several ranks, PETSc keeps what Python drops. Collective."""
    for each in objects:
        each.destroy()


class _Files:
    """A folder for the files of a factor, removed after it or at the end of the process."""

    def __init__(self) -> None:
        self.name = tempfile.mkdtemp(prefix="fretfe-")
        weakref.finalize(self, shutil.rmtree, self.name, ignore_errors=True)


@contextmanager
def _folder(files: _Files | None) -> Iterator[None]:
    """Have MUMPS write its files to a folder, which it asks for while it factorises."""
    before = os.environ.get(FOLDER)
    try:
        if files is not None:
            os.environ[FOLDER] = files.name
        yield
    finally:
        if files is not None and before is None:
            del os.environ[FOLDER]
        elif before is not None:
            os.environ[FOLDER] = before


def _set_up(solver: PETSc.PC, multipliers: int = 0) -> None:
    """Factorise a matrix, some of whose unknowns are multipliers.

    Raises:
        MemoryShortError: if there is not enough memory.
        ModelError: if MUMPS cannot for another reason.
    """
    with _folder(solver.getFactorMatrix().getAttr(FILES)):
        solver.setUp()
    code = solver.getFactorMatrix().getMumpsInfog(1)
    if code < 0:
        short = code in OUT_OF_MEMORY
        reason = "there is not enough memory" if short else "a pivot is zero"
        if code == NO_FILES:
            place = tempfile.gettempdir()
            reason = f"its factor cannot be written to {place} (TMPDIR names another folder)"
        unknowns = solver.getOperators()[0].size[0] - multipliers
        raise (MemoryShortError if short else ModelError)(
            f"a body with {unknowns} unknowns cannot be factorised: {reason} (MUMPS error {code})"
        )


def _bordered(matrix: PETSc.Mat, border: sparse.csr_matrix) -> PETSc.Mat:
    """K, which is referred to, with the border as further rows and columns. Collective.

    The multipliers belong to the first rank: they follow its unknowns.
    """
    comm, (start, end) = matrix.comm, matrix.getOwnershipRange()
    own = border if comm.rank == 0 else border[:0]
    below = _distributed(comm, own, end - start)
    beside = _distributed(comm, border[:, start:end].T.tocsr(), own.shape[0])
    return PETSc.Mat().createNest([[matrix, beside], [below, None]], comm=comm)


def _distributed(comm: PETSc.Comm, rows: sparse.csr_matrix, columns: int) -> PETSc.Mat:
    """A matrix of which this rank has some rows, and so many columns. Collective."""
    csr = *(each.astype(PETSc.IntType) for each in (rows.indptr, rows.indices)), rows.data
    return PETSc.Mat().createAIJ(((rows.shape[0], None), (columns, None)), csr=csr, comm=comm)


def _take_complement(factor: PETSc.Mat, rank: int, size: int) -> SymmetricMatrix | None:
    """(n, n) minus the Schur complement, whose memory is given back; rank 0 only."""
    handle, status = ctypes.c_void_p(), ctypes.c_int()
    schur = ctypes.byref(handle), ctypes.byref(status)
    _call("MatFactorGetSchurComplement", factor.handle, *schur)
    if rank > 0:
        return None
    data = ctypes.POINTER(ctypes.c_double)()
    _call("MatDenseGetArray", handle, ctypes.byref(data))
    values = np.ctypeslib.as_array(data, (size, size))
    by_rows = factor.getMumpsIcntl(SCHUR_CONTROL) == BY_ROWS
    found = SymmetricMatrix(values if by_rows else values.T, -1.0)
    _call("MatDenseRestoreArray", handle, ctypes.byref(data))
    # Full, as large as the matrices of all steps; solves for the interior do not read it.
    _call("MatDenseReplaceArray", handle, None)
    return found


def _call(name: str, *arguments: object) -> None:
    """Call a PETSc function whose arguments are handles or pointers."""
    converted = [ctypes.c_void_p(a) if isinstance(a, int) else a for a in arguments]
    code = getattr(petsc_library(), name)(*converted)
    if code:
        raise PETSc.Error(code)
