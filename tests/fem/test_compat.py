# SPDX-License-Identifier: LGPL-3.0-or-later
"""Each entry of fretfe.fem._compat does the same with every DOLFINx."""

from __future__ import annotations

import ctypes
from importlib.util import find_spec
from pathlib import Path

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.mesh import locate_entities_boundary, to_type
from harness.launch import python
from ufl.algorithms.analysis import extract_coefficients

from fretfe.fem._compat import (
    MPI,
    ElementVectors,
    PETSc,
    assemble_matrix,
    assemble_vector,
    create_mesh,
    entity_nodes,
    expression,
    exterior_sides,
    petsc_library,
    versions,
    vtk_order,
)
from fretfe.results.field_files import CELL_TYPES

COMM = MPI.COMM_WORLD
# Two elements each in Gmsh's order: corners, then middles of edges. The middle of the left edge is
# moved out by BULGE, which adds a parabola of 2/3 BULGE to the unit square.
BULGE = 0.1
CORNERS = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
MIDDLES = [(0.5, 0.0), (1.0, 0.5), (0.5, 1.0), (-BULGE, 0.5), (0.5, 0.5)]
HALVES = [(0.5, 0.0), (0.5, 1.0), (0.25, 0.0), (0.5, 0.5), (0.25, 1.0), (-BULGE, 0.5)]
OTHERS = [(0.75, 0.0), (1.0, 0.5), (0.75, 1.0), (0.25, 0.5), (0.75, 0.5)]
MESHES = {
    "triangle, order 1": ("triangle", 1, CORNERS, [[0, 1, 2], [0, 2, 3]], 1.0),
    "triangle, order 2": (
        "triangle",
        2,
        CORNERS + MIDDLES,
        [[0, 1, 2, 4, 5, 8], [0, 2, 3, 8, 6, 7]],
        1.0 + 2 / 3 * BULGE,
    ),
    "quadrilateral, order 1": (
        "quadrilateral",
        1,
        CORNERS + HALVES[:2],
        [[0, 4, 5, 3], [4, 1, 2, 5]],
        1.0,
    ),
    "quadrilateral, order 2": (
        "quadrilateral",
        2,
        CORNERS + HALVES + OTHERS,
        [[0, 4, 5, 3, 6, 7, 8, 9, 13], [4, 1, 2, 5, 10, 11, 12, 7, 14]],
        1.0 + 2 / 3 * BULGE,
    ),
}


def mesh_of(name: str) -> tuple[fem.FunctionSpace, float]:
    """Linear space on a mesh over all ranks, and the area of the mesh."""
    cell, order, points, cells, area = MESHES[name]
    root = COMM.rank == 0
    numbers = np.array(cells, np.int64)
    mesh = create_mesh(
        COMM,
        numbers if root else np.empty((0, numbers.shape[1]), np.int64),
        np.array(points) if root else np.empty((0, 2)),
        cell,
        order,
    )
    return fem.functionspace(mesh, ("Lagrange", 1)), area


def test_libraries_load_by_themselves_and_in_order() -> None:
    """In a new process, where a warning of any library is an error."""
    done = python("-c", "import fretfe.fem._compat")
    assert (done.returncode, done.stderr) == (0, "")


def test_petsc_library_is_the_one_of_petsc4py() -> None:
    numbers = [ctypes.c_int() for _ in range(4)]
    assert petsc_library().PetscGetVersionNumber(*map(ctypes.byref, numbers)) == 0
    assert ".".join(str(number.value) for number in numbers[:3]) == versions()["petsc"]


@pytest.mark.mpi
@pytest.mark.parametrize("name", MESHES)
def test_create_mesh_takes_nodes_in_the_order_of_gmsh(name: str) -> None:
    space, area = mesh_of(name)
    mesh = space.mesh
    x = ufl.SpatialCoordinate(mesh)[0]
    # moment of the bulge 4 BULGE y (1 - y) about x = 0
    moment = 0.5 - (4 / 15 * BULGE**2 if area > 1 else 0.0)
    for power, expected in ((0, area), (1, moment)):
        found = fem.assemble_scalar(fem.form(x**power * ufl.dx(domain=mesh)))
        assert COMM.allreduce(found) == pytest.approx(expected, rel=1e-12)  # round-off


@pytest.mark.mpi
def test_assemble_matrix_has_ones_where_values_are_prescribed() -> None:
    space, area = mesh_of("triangle, order 2")
    trial, test = ufl.TrialFunction(space), ufl.TestFunction(space)
    everywhere = np.arange(space.dofmap.index_map.size_local, dtype=np.int32)
    condition = fem.dirichletbc(PETSc.ScalarType(0), everywhere, space)
    form = fem.form(trial * test * ufl.dx)
    assert assemble_matrix(form, [condition]).getDiagonal().array == pytest.approx(1.0)
    ones = assemble_matrix(form, []).createVecRight()
    ones.set(1.0)
    # with all values one, the quadratic form is the integral of one
    assert ones.dot(assemble_matrix(form, []) * ones) == pytest.approx(area, rel=1e-12)


@pytest.mark.mpi
def test_assemble_vector_adds_what_other_ranks_have() -> None:
    space, area = mesh_of("quadrilateral, order 2")
    vector = assemble_vector(fem.form(ufl.TestFunction(space) * ufl.dx))
    # the hat functions add up to one; only owned entries count
    assert vector.sum() == pytest.approx(area, rel=1e-12)
    assert (vector.array > 0).all()


@pytest.mark.mpi
@pytest.mark.parametrize("name", MESHES)
def test_element_vectors_of_some_cells_and_sides(name: str) -> None:
    space, area = mesh_of(name)
    mesh, test = space.mesh, ufl.TestFunction(space)
    factor, pair = fem.Constant(mesh, 1.0), fem.Constant(mesh, np.array([0.0, 2.0]))
    given, whole = fem.Function(space), fem.Function(fem.functionspace(mesh, ("Lagrange", 1, (2,))))
    given.x.array[:], whole.x.array[1::2] = 3.0, 0.5
    form = factor * given * test * ufl.dx(1, domain=mesh) - whole[1] * pair[1] * test * ufl.ds(
        1, domain=mesh
    )
    compiled = fem.compile_form(mesh.comm, form)
    order = extract_coefficients(form)
    vectors = ElementVectors(compiled, mesh, space.dofmap.list.shape[1], tuple(order))
    dim = mesh.topology.dim
    mesh.topology.create_connectivity(dim - 1, dim)
    cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
    right = locate_entities_boundary(mesh, dim - 1, lambda x: x[0] > 1 - 1e-9)
    constants = np.array([1.0, 0.0, 2.0])
    inside = vectors.on_cells(constants, cells)
    beside = vectors.on_sides(constants, exterior_sides(mesh, right))
    # the right side has length 1; hat functions add up to one
    sums = mesh.comm.allreduce(np.array([inside.sum(), beside.sum()]))
    assert sums == pytest.approx([3 * area, -1.0], rel=1e-12)
    # what DOLFINx adds up
    expected = np.zeros(len(space.tabulate_dof_coordinates()))
    fem.assemble_vector(expected, fem.form(given * test * ufl.dx))
    found = np.zeros_like(expected)
    np.add.at(found, space.dofmap.list[cells], inside)
    assert found == pytest.approx(expected, abs=1e-14)
    assert vectors.on_cells(constants, cells[:0]).shape == (0, vectors.size)


@pytest.mark.mpi
def test_expression_is_evaluated() -> None:
    space, _ = mesh_of("triangle, order 1")
    x = ufl.SpatialCoordinate(space.mesh)
    corners = space.element.basix_element.points
    value = expression(x[0] ** 2 + 3 * x[0] * x[1], corners)
    cells = np.arange(len(space.dofmap.list), dtype=np.int32)
    points = space.tabulate_dof_coordinates()[space.dofmap.list]
    expected = points[..., 0] ** 2 + 3 * points[..., 0] * points[..., 1]
    found = value.eval(space.mesh, cells).reshape(expected.shape)
    assert np.allclose(found, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("cell", "degree", "number", "last"),
    [
        # The edges of a triangle follow each other, those of a quadrilateral too.
        ("triangle", 2, 6, (0, 0.5)),
        ("quadrilateral", 1, 4, (0, 1)),
        ("quadrilateral", 2, 9, (0.5, 0.5)),
        ("tetrahedron", 2, 10, (0, 0.5, 0.5)),
        ("hexahedron", 2, 27, (0.5, 0.5, 0.5)),
    ],
)
def test_nodes_in_the_order_of_vtk(
    cell: str, degree: int, number: int, last: tuple[float, ...]
) -> None:
    element = basix.ufl.element("Lagrange", cell, degree)
    points = element.basix_element.points[vtk_order(to_type(cell), number)]
    assert points[-1] == pytest.approx(np.array(last), abs=1e-15)
    vtk = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    coordinates = vtk.vtkGenericCell.InstantiateCell(
        CELL_TYPES[len(last), number]
    ).GetParametricCoords()
    expected = np.array([coordinates[i] for i in range(3 * number)]).reshape(-1, 3)
    assert points == pytest.approx(expected[:, : len(last)], abs=1e-15)


def test_versions_name_what_is_loaded() -> None:
    found = versions()
    assert list(found) == ["dolfinx", "petsc", "mpi"]
    assert all(
        part.isdecimal() for name in ("dolfinx", "petsc") for part in found[name].split(".")[:2]
    )
    assert found["mpi"].startswith(("MPICH", "Open MPI")) and found["mpi"].isprintable()


IMPORT_BESIDE = "import sys; sys.path.append(sys.argv[1]); import fretfe.fem"


@pytest.mark.skipif(find_spec("dolfinx_solver") is None, reason="not the wheel of DOLFINx")
def test_the_wheel_refuses_another_petsc(tmp_path: Path) -> None:
    assert python("-c", IMPORT_BESIDE, str(tmp_path)).returncode == 0
    metadata = tmp_path / "petsc4py-3.20.0.dist-info" / "METADATA"
    metadata.parent.mkdir()
    metadata.write_text("Metadata-Version: 2.1\nName: petsc4py\nVersion: 3.20.0\n")
    refused = python("-c", IMPORT_BESIDE, str(tmp_path))
    assert refused.returncode == 1
    assert "Uninstall petsc4py" in refused.stderr


@pytest.mark.mpi
def test_nodes_of_facets_of_which_a_rank_may_have_none() -> None:
    mesh = mesh_of("triangle, order 2")[0].mesh
    mesh.topology.create_connectivity(1, 2)
    left = locate_entities_boundary(mesh, 1, lambda x: x[0] < BULGE / 2)
    assert COMM.allreduce(len(left)) == 1
    places = mesh.geometry.x[entity_nodes(mesh, 1, left).ravel(), 0]
    assert len(places) >= 2 * len(left) and (places <= 0.0).all()
    assert len(entity_nodes(mesh, 1, left[:0])) == 0
