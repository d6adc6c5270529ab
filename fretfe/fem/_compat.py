# SPDX-License-Identifier: LGPL-3.0-or-later
"""Everything that differs between the DOLFINx versions and distributions that fretfe supports.

Importing this module makes sure that MPI, PETSc and DOLFINx load in the order that the installed
distribution needs. All other modules of `fretfe.fem` import DOLFINx through here or after it.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import importlib.util
import signal
import sys
import threading
import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fretfe._core import _kernels
from fretfe._typing import Array, Indices
from fretfe.environment import too_little_room
from fretfe.errors import DependencyError, MemoryShortError
from fretfe.libraries import elsewhere

# Bytes of address space, which are less of memory: four times 128 MiB.
WORK_SPACE = 4 * 128 * 2**20
if _shortage := too_little_room(WORK_SPACE, "DOLFINx and its linear algebra may take"):
    # Libraries without room end the process while they are loaded.
    raise MemoryShortError(_shortage)
# Where MUMPS is to find its dgemmt, which must be there before PETSc is: fretfe/fem/bordered.py.
# A distribution may have given it the name of an extension module of one Python.
_gemmt = importlib.util.find_spec("fretfe._core._gemmt")
if _gemmt is None or _gemmt.origin is None:
    raise DependencyError(
        f"expected the library _gemmt of fretfe in {Path(_kernels.__file__).parent}, found none. "
        "Install fretfe anew"
    )
DGEMMT = ctypes.CDLL(_gemmt.origin, ctypes.RTLD_GLOBAL)
# Distributions that replace files of the wheel of 0.11, or of one another.
RIVALS = ("petsc", "petsc4py", "slepc", "slepc4py", "dolfinx-solver-complex")


def _may_be_spoiled() -> bool:
    """True if another PETSc stands beside or before that of the wheel; Debian's 0.9 is no wheel."""
    wheel, petsc = (importlib.util.find_spec(name) for name in ("dolfinx_solver", "petsc4py"))
    if wheel is None or petsc is None:
        return wheel is not None
    wheel_folder, folder = (Path(each.origin or "").parents[1] for each in (wheel, petsc))
    names = (importlib.metadata.Distribution.discover(name=name) for name in RIVALS)
    return wheel_folder != folder or any(map(any, names))


if _may_be_spoiled():
    # The wheel says what to remove. It reads all that is installed for that: 0.1 s, or more.
    with elsewhere():
        import dolfinx_solver  # noqa: F401

# Signals that this process ignores: of a pipe that nobody reads, of a closed terminal by `nohup`.
_ignored = [each for each in signal.Signals if signal.getsignal(each) is signal.SIG_IGN]
_petsc_is_new = "petsc4py.PETSc" not in sys.modules
try:
    with elsewhere(), warnings.catch_warnings():
        # 0.9 warns if there is no Numba, which fretfe does not use; later versions do not.
        warnings.filterwarnings("ignore", "Could not import numba", ImportWarning)
        # It finds the MPI library that those of the wheel are linked with: it comes first.
        from mpi4py import MPI  # isort: skip
        import petsc4py

        # Not with files of options; PETSC_OPTIONS of the environment is the user's own.
        petsc4py.init(["fretfe", "-skip_petscrc"])
        from petsc4py import PETSc

        import basix.ufl
        import dolfinx
        import dolfinx.fem.petsc
        import dolfinx.geometry
        import dolfinx.jit
        import dolfinx.mesh
        import ffcx.options
        import ufl
        from dolfinx import cpp as _cpp

        with elsewhere(home=True):
            # They look for their files of options once.
            ffcx.options.get_options()
            dolfinx.jit.get_options()
except ImportError as error:
    raise DependencyError(
        "the finite-element part of fretfe needs DOLFINx with PETSc and MPI, which cannot be "
        f"imported ({error}).\nInstall it with `pip install dolfinx-solver-real` (Linux x86-64, "
        "Python 3.12 or newer) or from your distribution (Debian: python3-dolfinx-real)."
    ) from error

VERSION = tuple(int(part) for part in dolfinx.__version__.split(".")[:2])
# All options of compiling, as they come with DOLFINx: not those that this process was started with.
JIT_OPTIONS = {name: value for name, (value, _) in dolfinx.jit.DOLFINX_DEFAULT_JIT_OPTIONS.items()}
FORM_OPTIONS = {name: value for name, (_, value, *_) in ffcx.options.FFCX_DEFAULT_OPTIONS.items()}


@cache
def petsc_library() -> ctypes.CDLL:
    """The PETSc that DOLFINx uses, for functions without a petsc4py binding."""
    # 0.9 gives the path by dolfinx.utils.get_petsc_lib, 0.10 and later by
    # dolfinx.fem.petsc.get_petsc_lib. A function is found in what the library named here is linked
    # with, in Debian's packages as in the wheels from PyPI.
    return ctypes.CDLL(PETSc.__file__)


def _leave_signals_alone() -> None:
    """Take the handlers of PETSc away: for it every signal is a crash of which it prints a page."""
    if threading.current_thread() is threading.main_thread():
        petsc_library().PetscPopSignalHandler()
        for each in _ignored:
            signal.signal(each, signal.SIG_IGN)


if _petsc_is_new:
    _leave_signals_alone()
# The dgemm that MUMPS calls is the one that PETSc is linked with.
ctypes.c_void_p.in_dll(DGEMMT, "fretfe_dgemm").value = ctypes.cast(
    petsc_library().dgemm_, ctypes.c_void_p
).value


def create_mesh(
    comm: MPI.Comm,
    cells: Indices,
    points: Array,
    cell: str,
    order: int,
) -> dolfinx.mesh.Mesh:
    """Distributed DOLFINx mesh from arrays in Gmsh node order. Collective.

    Args:
        comm: communicator of the mesh.
        cells: (m, k) node numbers on rank 0, (0, k) elsewhere.
        points: (n, gdim) node coordinates on rank 0, (0, gdim) elsewhere.
        cell: "triangle" or "quadrilateral", "tetrahedron" or "hexahedron" of a solid.
        order: polynomial order of the geometry.
    """
    element = basix.ufl.element("Lagrange", cell, order, shape=(points.shape[1],))
    # In Python the permutation is in dolfinx.io.gmshio in 0.9, in dolfinx.io.gmsh later.
    permutation = _cpp.io.perm_gmsh(dolfinx.mesh.to_type(cell), cells.shape[1])
    ordered = np.ascontiguousarray(cells[:, permutation])
    if VERSION < (0, 10):  # 0.9: (comm, cells, x, e); later (comm, cells, e, x)
        return dolfinx.mesh.create_mesh(comm, ordered, points, ufl.Mesh(element))
    return dolfinx.mesh.create_mesh(comm, ordered, ufl.Mesh(element), points)


def entity_nodes(
    mesh: dolfinx.mesh.Mesh, dim: int, entities: npt.NDArray[np.int32]
) -> npt.NDArray[np.int32]:
    """Numbers of the nodes of some entities on this rank, (n, k); n may be zero."""
    if not len(entities):  # 0.9 divides by their number, which ends the process
        return np.empty((0, 1), np.int32)
    nodes: npt.NDArray[np.int32] = dolfinx.mesh.entities_to_geometry(mesh, dim, entities)
    return nodes


def assemble_matrix(form: Any, conditions: list[Any]) -> PETSc.Mat:
    """Assembled matrix with unit diagonal at constrained degrees of freedom. Collective."""
    # 0.9: (a, bcs, diagonal, ...); later (a, bcs, diag, ..., kind). One is the default of both.
    matrix = dolfinx.fem.petsc.assemble_matrix(form, bcs=conditions)
    matrix.assemble()
    return matrix


def assemble_vector(form: Any) -> PETSc.Vec:
    """Assembled vector, contributions to ghosts added to their owners. Collective."""
    # 0.9 has functions assemble_vector, _block and _nest; later versions one with an argument kind.
    vector = dolfinx.fem.petsc.assemble_vector(form)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    return vector


@dataclass(frozen=True)
class ElementVectors:
    """Element vectors of a linear form on any cells and exterior facets, by its own kernels.

    For each choice of them DOLFINx would make a form, and a vector of the whole mesh.

    Args:
        compiled: what `dolfinx.fem.compile_form` gave for a form with one integral over cells and
            one over exterior facets.
        mesh: of the form.
        size: of an element vector.
        coefficients: of the form, in UFL's order. Their functions, and those that the form is
            tested with, must not depend on how elements lie to their neighbours: Lagrange's up to
            degree 2.
    """

    compiled: Any
    mesh: dolfinx.mesh.Mesh
    size: int
    coefficients: tuple[dolfinx.fem.Function, ...] = ()

    def on_cells(self, constants: Array, cells: npt.NDArray[np.integer[Any]]) -> Array:
        """(n, size) vectors of cells (n,), with all constants of the form in UFL's order."""
        return self._vectors(0, constants, cells, np.zeros(len(cells), np.int32))

    def on_sides(self, constants: Array, sides: npt.NDArray[np.int32]) -> Array:
        """(m, size) vectors of exterior facets (m, 2) as of `exterior_sides`; otherwise as that."""
        return self._vectors(1, constants, *np.ascontiguousarray(sides.T))

    def _vectors(
        self,
        kind: int,
        constants: Array,
        cells: npt.NDArray[np.integer[Any]],
        facets: npt.NDArray[np.int32],
    ) -> Array:
        form, cast = self.compiled.ufcx_form, self.compiled.module.ffi.cast
        integral = form.form_integrals[form.form_integral_offsets[kind]]
        values = [np.empty((len(cells), 0))]
        for number in range(form.num_coefficients):
            given = self.coefficients[form.original_coefficient_positions[number]]
            space = given.function_space
            nodes = given.x.array.reshape(-1, space.dofmap.bs)[space.dofmap.list[cells]]
            values.append(nodes.reshape(len(cells), nodes.shape[1] * nodes.shape[2]))
        return _kernels.tabulate(
            int(cast("uintptr_t", integral.tabulate_tensor_float64)),
            constants,
            np.hstack(values),
            self.mesh.geometry.x[_geometry_nodes(self.mesh)[cells]],
            facets,
            self.size,
        )


def _geometry_nodes(mesh: dolfinx.mesh.Mesh) -> npt.NDArray[np.int32]:
    """(n, k) nodes of the cells' geometry."""
    # In 0.9 there is one table; later there is one for each kind of cells.
    return mesh.geometry.dofmap if VERSION < (0, 10) else mesh.geometry.dofmaps[0]


def exterior_sides(mesh: dolfinx.mesh.Mesh, facets: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """(m, 2) cells of exterior facets and the numbers of the facets in them, ghosts left out."""
    # 0.9 leaves out some of those that are not in ascending order.
    facets = np.unique(facets)
    arguments = [dolfinx.fem.IntegralType.exterior_facet, mesh.topology, facets]
    if VERSION < (0, 10):  # the dimension of the facets is told in 0.9, and known later
        arguments.append(mesh.topology.dim - 1)
    sides = dolfinx.fem.compute_integration_domains(*arguments)
    return np.asarray(sides, dtype=np.int32).reshape(-1, 2)


def cells_around(
    mesh: dolfinx.mesh.Mesh, cells: npt.NDArray[np.int32], points: Array, padding: float
) -> tuple[Indices, Indices]:
    """Pairs (n,), (n,) of cells and points whose bounding boxes, a bit larger, hold the points.

    Args:
        mesh: of the cells.
        cells: that are looked at.
        points: (m, 3) places, NaN for none.
        padding: by which the boxes are larger.
    """
    # In 0.9 padding follows the entities, later it comes before them: both by name.
    tree = dolfinx.geometry.bb_tree(mesh, mesh.topology.dim, entities=cells, padding=padding)
    known = np.flatnonzero(np.isfinite(points).all(axis=1))
    met = dolfinx.geometry.compute_collisions_points(tree, points[known])
    numbers = known[np.repeat(np.arange(len(known)), np.diff(met.offsets))]
    return met.array.astype(np.int64), numbers


def vtk_order(cell: dolfinx.mesh.CellType, count: int) -> Indices:
    """(k,) the k nodes of an element, numbered as in DOLFINx, in VTK's order."""
    # It is VTK's quadratic cells that are meant; DOLFINx gives the inverse.
    return np.argsort(_cpp.io.perm_vtk(cell, count))


def expression(value: Any, points: Array, **options: Any) -> dolfinx.fem.Expression:
    """A UFL expression that can be evaluated at points (k, d) of the reference element."""
    # Its values are flat for each element in 0.9, and have all their dimensions later.
    return dolfinx.fem.Expression(value, points, **options)


def versions() -> dict[str, Any]:
    """Versions of DOLFINx, PETSc and the MPI library in use."""
    return {
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(str(part) for part in PETSc.Sys.getVersion()),
        # MPICH (the wheels) answers in several lines, Open MPI (Debian) in one that ends in a zero.
        "mpi": MPI.Get_library_version().splitlines()[0].strip("\x00 "),
    }
