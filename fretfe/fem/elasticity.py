# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear elasticity of one body in DOLFINx: space, forms, stiffness, load vectors."""

from __future__ import annotations

import atexit
import fcntl
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import cache, cached_property
from pathlib import Path
from typing import Any, TextIO, TypeVar

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem
from dolfinx.graph import adjacencylist
from dolfinx.io import distribute_entity_data
from dolfinx.mesh import meshtags_from_entities
from scipy.spatial import cKDTree

from fretfe._typing import Array, Indices
from fretfe.bodies.loads.spread import SpreadLoad, SurfaceTraction
from fretfe.fem._compat import (
    FORM_OPTIONS,
    JIT_OPTIONS,
    MPI,
    PETSc,
    assemble_matrix,
    assemble_vector,
    create_mesh,
    expression,
    vtk_order,
)
from fretfe.files import open_own, require_writable
from fretfe.libraries import cache_folder, elsewhere
from fretfe.materials.crystals import PAIRS, VOIGT
from fretfe.materials.material import Material
from fretfe.mesh.elements import CORNERS, facet_node_count
from fretfe.mesh.mesh import BodyMesh

T = TypeVar("T")

# Of the quadrature over a part of a boundary that is not made of whole elements.
PART_DEGREE = 12
# Nodes are found by their places, to this fraction of the extent of these places.
MATCH_TOLERANCE = 1e-8

# Below the folder for caches: what is there belongs to processes that know the lock.
FOLDER = "fenics/fretfe"
LOCK = "lock"
# Seconds to wait for another process that compiles the same form.
TIMEOUT = 120
# Of the C compiler, in place of DOLFINx's. Sums are reordered and there are no error numbers:
# stiffness matrices of solids take .57 of the time and differ by round-off, interaction integrals
# two thirds, and differ by 1e-11. Not -ffast-math itself, by which older compilers make a whole
# process flush small numbers to zero.
COMPILER_FLAGS = (
    "-O3",
    "-g0",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fno-signed-zeros",
    "-fassociative-math",
    "-freciprocal-math",
)
# Components of a stress that are written, those that do not follow from others.
PLANE_COMPONENTS = ((0, 0), (1, 1), (0, 1))
PLANE_VOIGT = np.array([[0, 2], [2, 1]])
PLANE_TENSOR = ((0, 0), (1, 1), (2, 2), (0, 1))
COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def compiled(comm: MPI.Comm, compiler: Callable[..., T], *arguments: Any) -> T:
    """Call a function of DOLFINx that compiles. Collective.

    Args:
        comm: communicator of what is compiled.
        compiler: `dolfinx.fem.form`, `compile_form` or `Expression`.
        arguments: of the function.
    """
    folder = Path(comm.bcast(_cache_folder() if comm.rank == 0 else ""))
    options: dict[str, Any] = {
        "form_compiler_options": dict(FORM_OPTIONS),
        "jit_options": {
            **JIT_OPTIONS,
            "cache_dir": str(folder),
            "timeout": TIMEOUT,
            "cffi_extra_compile_args": list(COMPILER_FLAGS),
        },
    }
    # CFFI reads settings of setuptools; it compiles in the folder.
    with elsewhere(home=True):
        if comm.rank > 0:  # takes what the first process has compiled
            return compiler(*arguments, **options)
        with open(folder / LOCK, "w", opener=open_own) as lock, _shared(lock, folder):
            return compiler(*arguments, **options)


def _cache_folder() -> str:
    """The folder for what is compiled; one that ends with this process if that cannot be used."""
    folder = cache_folder() / FOLDER
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.close(open_own(folder / LOCK, os.O_RDWR))
        require_writable(folder)
    except OSError:
        return _own_folder()
    return str(folder)


@cache
def _own_folder() -> str:
    folder = tempfile.mkdtemp(prefix="fretfe-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@contextmanager
def _shared(lock: TextIO, folder: Path) -> Iterator[None]:
    """Hold a lock with all others that compile; if there are none, remove leftovers first."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        remove_leftovers(folder)
    except OSError:
        pass  # another process compiles, or this file system has no locks
    try:
        fcntl.flock(lock, fcntl.LOCK_SH)
    except OSError:
        pass
    yield


def remove_leftovers(folder: Path) -> None:
    """Remove the files of forms whose compilation did not end. No process may be compiling."""
    for source in folder.glob("*.c"):
        if not source.with_suffix(".c.cached").exists():
            for path in folder.glob(f"{source.stem}.*"):
                path.unlink(missing_ok=True)


@dataclass(frozen=True)
class Elasticity:
    """Constants of an isotropic material in UFL, as `Material` names them."""

    kolosov: Any
    shear_modulus: Any
    first_lame: Any

    @classmethod
    def of(cls, mesh: Any, material: Material) -> Elasticity:
        """The constants of a material on a mesh."""
        names = (each.name for each in fields(cls))
        return cls(*(fem.Constant(mesh, getattr(material, name)) for name in names))

    def stress(self, strain: Any) -> Any:
        """Stress (d, d) of a strain (d, d)."""
        spread = self.first_lame * ufl.tr(strain) * ufl.Identity(strain.ufl_shape[0])
        return 2 * self.shear_modulus * strain + spread


@dataclass(frozen=True)
class CrystalElasticity:
    """Stiffness of any material in UFL.

    Attributes:
        stiffness: (6, 6), in the plane (3, 3), in some axes, in Voigt's order.
        turn: (3, 3) rows: axes of stress and strain in those axes; None for the same.
    """

    stiffness: Any
    turn: Any = None

    @classmethod
    def of(cls, mesh: Any, material: Material, components: int) -> CrystalElasticity:
        """The stiffness of a material on a mesh, in the axes of the model."""
        return cls(fem.Constant(mesh, of_dimension(material.stiffness, components)))

    def stress(self, strain: Any) -> Any:
        """Stress (d, d) of a strain (d, d)."""
        if self.turn is not None:
            strain = self.turn.T * strain * self.turn
        size = strain.ufl_shape[0]
        number = (VOIGT if size == 3 else PLANE_VOIGT).tolist()
        pairs = PAIRS if size == 3 else PLANE_COMPONENTS
        given = ufl.as_vector([strain[i, j] if i == j else 2 * strain[i, j] for i, j in pairs])
        found = self.stiffness * given
        stress = ufl.as_matrix([[found[number[i][j]] for j in range(size)] for i in range(size)])
        return stress if self.turn is None else self.turn * stress * self.turn.T


def of_dimension(stiffness: Array, size: int) -> Array:
    """(6, 6) or (3, 3) stiffness for strains of displacements with 3 or 2 components."""
    kept = range(6) if size == 3 else [0, 1, 5]
    return stiffness[np.ix_(kept, kept)].copy()


def elasticity_of(mesh: Any, material: Material, components: int) -> Elasticity | CrystalElasticity:
    """Hooke's law of a material on a mesh, for displacements with so many components."""
    if material.crystal is None:
        return Elasticity.of(mesh, material)
    return CrystalElasticity.of(mesh, material, components)


def stress_pairs(size: int) -> tuple[tuple[int, int], ...]:
    """Components of the stress by displacements with 2 or 3 components, those that may be there."""
    return PLANE_TENSOR if size == 2 else COMPONENTS


class ElasticBody:
    """Displacement space, stiffness and load vectors of one body, distributed over all ranks.

    All methods are collective.

    Args:
        comm: communicator.
        mesh: the body's mesh on rank 0, None elsewhere.
        material: elastic constants.
        degree: polynomial degree of the displacement, 1 or 2. Of degree 1 elements are straight.
        components: of the displacement; without it as many as the mesh has coordinates. Plane
            bodies may have a third one, u_z(x, y).

    Attributes:
        gdim: number of coordinates.
        components: of the displacement.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        mesh: BodyMesh | None,
        material: Material,
        degree: int,
        components: int | None = None,
    ) -> None:
        self.comm = comm
        self.material = material
        if mesh and degree < mesh.order:
            mesh = _straightened(mesh)
        name, cell, order, width, gdim = comm.bcast(_mesh_type(mesh) if mesh else None)
        cells = mesh.cells if mesh else np.empty((0, width), np.int64)
        points = mesh.points if mesh else np.empty((0, gdim))
        self.name: str = name
        self.gdim: int = gdim
        self.components = components or gdim
        self.degree, self.order = degree, order
        self.mesh = create_mesh(comm, cells, points, cell, order)
        self.space = fem.functionspace(self.mesh, ("Lagrange", degree, (self.components,)))
        self.groups, self.facet_tags = self._tag_boundaries(mesh, cell, order)
        self._initial_stresses: dict[str, fem.Function] = {}

    def _tag_boundaries(
        self, mesh: BodyMesh | None, cell: str, order: int
    ) -> tuple[dict[str, tuple[int, ...]], Any]:
        """Numbers of each boundary name, and the facet tags that carry these numbers.

        A facet has one number, and may belong to several boundaries.
        """
        facets = np.empty((0, facet_node_count(cell, order)), np.int64)
        values, groups = np.empty(0, np.int32), {}
        if mesh:
            names = sorted(mesh.boundaries)
            counts = [len(mesh.boundaries[name]) for name in names]
            every = np.concatenate([mesh.boundaries[name] for name in names])
            _, first, place = np.unique(
                np.sort(every, axis=1), axis=0, return_index=True, return_inverse=True
            )
            belongs = np.zeros((len(first), len(names)), dtype=bool)
            belongs[place.ravel(), np.repeat(np.arange(len(names)), counts)] = True
            kinds, kind = np.unique(belongs, axis=0, return_inverse=True)
            facets, values = every[first], (kind.ravel() + 1).astype(np.int32)
            groups = {
                name: tuple((np.flatnonzero(own) + 1).tolist())
                for name, own in zip(names, kinds.T, strict=True)
            }
        dim = self.mesh.topology.dim - 1
        self.mesh.topology.create_connectivity(dim, 0)
        self.mesh.topology.create_connectivity(dim, dim + 1)
        local, numbers = distribute_entity_data(self.mesh, dim, facets, values)
        tags = meshtags_from_entities(self.mesh, dim, adjacencylist(local), numbers)
        return self.comm.bcast(groups), tags

    def boundary_facets(self, boundary: str) -> npt.NDArray[np.int32]:
        """Local numbers of the facets of a boundary."""
        return np.sort(np.concatenate([self.facet_tags.find(n) for n in self.groups[boundary]]))

    def boundary_nodes(self, boundary: str) -> npt.NDArray[np.int32]:
        """Local numbers (owned and ghosted) of the displacement nodes on a boundary."""
        facets = self.boundary_facets(boundary)
        dim = self.mesh.topology.dim - 1
        return fem.locate_dofs_topological(self.space, dim, facets)

    @property
    def node_points(self) -> Array:
        """(n, gdim) places of the displacement nodes, owned and ghosted."""
        return np.asarray(self.space.tabulate_dof_coordinates()[:, : self.gdim])

    def stress(self, displacement: Any) -> Any:
        """Stress (UFL) of a displacement."""
        strain = ufl.sym(squared(ufl.grad(displacement)))
        return elasticity_of(self.mesh, self.material, self.components).stress(strain)

    def _energy(self, displacement: Any) -> Any:
        return self._work(self.stress(displacement))

    def _work(self, stress: Any) -> Any:
        """Work of a stress (UFL) in a test function."""
        test = ufl.TestFunction(self.space)
        measure = ufl.dx
        if self.mesh.topology.cell_name() == "hexahedron":
            # As many points in each direction as in a quadrilateral that it may be extruded from.
            measure = ufl.dx(metadata={"quadrature_degree": 2 * (self.degree + self.order)})
        return ufl.inner(stress, ufl.sym(squared(ufl.grad(test)))) * measure

    def stiffness(self, constrained: npt.NDArray[np.int32]) -> PETSc.Mat:
        """Stiffness matrix with unit rows and columns at constrained degrees of freedom.

        Args:
            constrained: local numbers c * node + component, owned and ghosted.
        """
        form = compiled(self.comm, fem.form, self._energy(ufl.TrialFunction(self.space)))
        conditions = [
            fem.dirichletbc(
                PETSc.ScalarType(0),
                constrained[constrained % self.components == component],
                self.space.sub(component),
            )
            for component in range(self.components)
        ]
        matrix = assemble_matrix(form, conditions)
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return matrix

    def forces(self, displacement: fem.Function) -> PETSc.Vec:
        """Nodal forces K u of a displacement, without any constraint."""
        self._given.x.array[:] = displacement.x.array
        return assemble_vector(self._force_form)

    @cached_property
    def _given(self) -> fem.Function:
        """The displacement in the forms that are compiled once."""
        return fem.Function(self.space)

    @cached_property
    def _force_form(self) -> fem.Form:
        return compiled(self.comm, fem.form, self._energy(self._given))

    def load_vector(self, load: SpreadLoad) -> PETSc.Vec:
        """Nodal forces of a load of unit amplitude; zero if its boundary is on another body."""
        test = ufl.TestFunction(self.space)
        initial = self.initial_stress(load)
        if initial is not None:
            form = self._work(in_space_of(initial, self.components))
            return assemble_vector(compiled(self.comm, fem.form, form))
        force = self.body_force(load)
        if force is not None:
            return assemble_vector(compiled(self.comm, fem.form, ufl.inner(force, test) * ufl.dx))
        given = load.traction
        if given is None or given.boundary not in self.groups:
            zero = fem.Function(self.space)  # owns the memory that its vector views
            return zero.x.petsc_vec.copy()
        traction, measure = self._traction(given)
        form = ufl.inner(traction, test) * measure(self.groups[given.boundary])
        return assemble_vector(compiled(self.comm, fem.form, form))

    def _traction(self, given: SurfaceTraction) -> tuple[Any, ufl.Measure]:
        """Traction (c,) on a boundary of the body, and the measure to integrate it."""
        measure = ufl.Measure("ds", self.mesh, subdomain_data=self.facet_tags)
        if given.even:
            return self._even(given, measure)
        traction = padded(ufl.FacetNormal(self.mesh), self.components)
        if given.direction:
            traction = fem.Constant(self.mesh, np.array(given.direction[: self.components]))
        return traction if given.factors is None else self._factors(given) * traction, measure

    def _even(self, given: SurfaceTraction, measure: ufl.Measure) -> tuple[Any, ufl.Measure]:
        """A traction whose resultant is one, on its part of a boundary, even or linear.

        The moments of the area are those by the same points of integration: force and line of
        action are exact. Linear: F/A + ω × (x − c), where T ω = (through − c) × F with T = ∫ (r² 1
        − r r^T) dA about the middle c (Abaqus Theory Guide, Distributing coupling elements).
        """
        place = ufl.SpatialCoordinate(self.mesh)
        part: Any = fem.Constant(self.mesh, 1.0)
        if given.radius:
            away = place - fem.Constant(self.mesh, np.array(given.centre[: self.gdim]))
            limit = fem.Constant(self.mesh, given.radius**2)
            part = ufl.conditional(ufl.le(ufl.inner(away, away), limit), 1.0, 0.0)
        if given.radius or given.through:
            measure = measure(metadata={"quadrature_degree": PART_DEGREE})
        force = np.zeros(3)
        force[: self.components] = given.direction[: self.components]
        on = measure(self.groups[given.boundary])
        if not given.through:
            area = self._integral(part * on)
            return part * fem.Constant(self.mesh, force[: self.components] / area), measure
        area, middle, turning = self._moments_of_area(part, on)
        through = np.zeros(3)
        through[: self.gdim] = given.through[: self.gdim]
        turn = np.linalg.lstsq(turning, np.cross(through - middle, force), rcond=None)[0]
        across = np.cross(turn, np.eye(3)).T
        size, gdim = self.components, self.gdim
        even = fem.Constant(self.mesh, force[:size] / area - (across @ middle)[:size])
        return part * (even + fem.Constant(self.mesh, across[:size, :gdim].copy()) * place), measure

    def _moments_of_area(self, part: Any, on: ufl.Measure) -> tuple[float, Array, Array]:
        """Area, (3,) middle and (3, 3) T of a part of the boundary."""
        gdim = self.gdim
        factors = fem.Constant(self.mesh, np.zeros((gdim + 1, gdim + 1)))
        place = ufl.as_vector([*ufl.SpatialCoordinate(self.mesh), 1.0])
        form = compiled(self.comm, fem.form, part * ufl.inner(place, factors * place) * on)
        moments = np.zeros((4, 4))
        own = [*range(gdim), 3]
        for row, column in np.ndindex(gdim + 1, gdim + 1):
            factors.value[:] = 0.0
            factors.value[row, column] = 1.0
            moments[own[row], own[column]] = self.comm.allreduce(fem.assemble_scalar(form))
        area, middle = moments[3, 3], moments[:3, 3] / moments[3, 3]
        second = moments[:3, :3] - area * np.outer(middle, middle)
        return area, middle, np.trace(second) * np.eye(3) - second

    def _integral(self, integrand: Any) -> float:
        return float(
            self.comm.allreduce(fem.assemble_scalar(compiled(self.comm, fem.form, integrand)))
        )

    def initial_stress(self, load: SpreadLoad) -> fem.Function | None:
        """Stress (3, 3) of the initial strain of a unit of a load in the body, None without any.

        It is linear between the corners of elements, as the strain is that displacements of
        degree 2 can follow. A load is looked at once.
        """
        if not load.strains(self.name):
            return None
        if load.label not in self._initial_stresses:
            space = fem.functionspace(self.mesh, ("Lagrange", 1, (3, 3)))
            places = space.tabulate_dof_coordinates()[:, : self.gdim]
            strain = load.initial_strain(self.name, self.material, places)
            found = self._initial_stresses[load.label] = fem.Function(space)
            found.x.array[:] = self.material.initial_stress(strain).ravel()
        return self._initial_stresses[load.label]

    def body_force(self, load: SpreadLoad) -> fem.Function | None:
        """Force per volume (c,) of a unit of a load, None without any.

        It is linear in the place, as the space is in which the places of elements lie.
        """
        if not load.pushes:
            return None
        space = fem.functionspace(self.mesh, ("Lagrange", self.order, (self.components,)))
        places = space.tabulate_dof_coordinates()[:, : self.gdim]
        force, found = load.body_force(self.material, places), fem.Function(space)
        found.x.array.reshape(-1, self.components)[:, : force.shape[1]] = force
        return found

    def _factors(self, given: SurfaceTraction) -> fem.Function:
        """Factors of a traction at the nodes of its boundary."""
        assert given.factors is not None
        space = fem.functionspace(self.mesh, ("Lagrange", self.degree))
        facets = self.boundary_facets(given.boundary)
        nodes = fem.locate_dofs_topological(space, self.mesh.topology.dim - 1, facets)
        factors = fem.Function(space)
        places = space.tabulate_dof_coordinates()[nodes, : self.gdim]
        factors.x.array[nodes] = given.factors.at(places)
        return factors

    def element_nodes(self) -> Array:
        """(m, k, d) places of the nodes of this rank's m elements, in VTK's order.

        Nodes that elements share have exactly the same place in all of them, on all ranks.
        """
        places = fem.Function(self.space)
        places.x.array.reshape(-1, self.components)[:, : self.gdim] = self.node_points
        places.x.scatter_forward()
        return self.element_displacements(places)[..., : self.gdim]

    def element_displacements(self, displacement: fem.Function) -> Array:
        """(m, k, c) displacement at the nodes of this rank's elements."""
        return displacement.x.array.reshape(-1, self.components)[self._element_nodes]

    def element_stresses(
        self, displacement: fem.Function, initial: fem.Function | None = None
    ) -> Array:
        """(m, k, 4 or 6) stress xx, yy, zz, xy, yz, xz at the nodes of this rank's elements.

        Each element has its own, exactly that of its displacement less the initial one.
        """
        self._given.x.array[:] = displacement.x.array
        cells = np.arange(len(self._element_nodes), dtype=np.int32)
        values = self._stress_expression.eval(self.mesh, cells)
        values = values.reshape(*self._element_nodes.shape, -1)
        if self.components == 2:
            values = np.insert(values, 2, values @ self.material.across, axis=2)
        if initial is not None:
            table = initial.function_space.element.basix_element.tabulate(
                0, np.ascontiguousarray(self._element_points[self._element_order])
            )[0, :, :, 0]
            nodes = initial.function_space.dofmap.list[: len(values)]
            tensors = initial.x.array.reshape(-1, 3, 3)[nodes]
            here = np.einsum("kn,mnij->mkij", table, tensors)
            pairs = stress_pairs(self.components)
            values = values - np.stack([here[..., i, j] for i, j in pairs], axis=2)
        return values

    @cached_property
    def _element_order(self) -> Indices:
        """(k,) the nodes of an element in VTK's order."""
        return vtk_order(self.mesh.topology.cell_type, len(self._element_points))

    @property
    def _element_points(self) -> Array:
        """(k, d) the nodes of the reference element in DOLFINx's order."""
        points: Array = self.space.element.basix_element.points
        return points

    @cached_property
    def _element_nodes(self) -> Indices:
        """(m, k) local numbers of the nodes of this rank's elements, in VTK's order."""
        own = self.mesh.topology.index_map(self.mesh.topology.dim).size_local
        nodes: Indices = self.space.dofmap.list[:own, self._element_order]
        return nodes

    @cached_property
    def _stress_expression(self) -> Any:
        stress = self.stress(self._given)
        pairs = PLANE_COMPONENTS if self.components == 2 else COMPONENTS
        components = ufl.as_vector([stress[pair] for pair in pairs])
        points = self._element_points[self._element_order]
        return compiled(self.comm, expression, components, points)


class PlacedNodes:
    """Displacement nodes of a body at given places, whichever ranks own them.

    Construction and methods are collective; arrays have the local numbers of their rank first.

    Args:
        elastic: the body.
        places: (p, gdim) of nodes, the same on all ranks.
        boundaries: that the nodes are on; any, without them.

    Attributes:
        numbers: (p*c,) global numbers of their displacements, of c components.
        local: (p*c or fewer,) local numbers of those that this rank owns.
        ghosted: local numbers of those that it knows, owned or not.
    """

    def __init__(self, elastic: ElasticBody, places: Array, boundaries: Sequence[str] = ()) -> None:
        self._comm, size, points = elastic.comm, elastic.components, elastic.node_points
        near: Indices = np.arange(len(points))
        if boundaries:
            near = np.unique(np.concatenate([*map(elastic.boundary_nodes, boundaries)]))
        index_map, components = elastic.space.dofmap.index_map, np.arange(size)
        extent = (np.ptp(places, axis=0).max() or np.abs(places).max()) if len(places) else 1.0
        distance, node = (
            cKDTree(points[near]).query(places)
            if len(near) and len(places)
            else (np.full(len(places), np.inf), np.zeros(len(places), int))
        )
        here = np.flatnonzero(distance < MATCH_TOLERANCE * extent)
        known = near[node[here]]
        own, local = here[known < index_map.size_local], known[known < index_map.size_local]
        self._positions = (own[:, None] * size + components).ravel()
        self.local = (local[:, None] * size + components).ravel()
        self.ghosted = known
        offset = index_map.local_range[0] * size
        self.numbers = np.full(len(places) * size, -1)
        for positions, unknowns in self._comm.allgather((self._positions, self.local + offset)):
            self.numbers[positions] = unknowns
        assert np.all(self.numbers >= 0), "a place is not that of a node of the body"

    def gather(self, values: Array) -> Array:
        """(p*c,) values at the nodes, on every rank."""
        found = np.empty(len(self.numbers))
        for positions, part in self._comm.allgather((self._positions, values[self.local])):
            found[positions] = part
        return found

    def add(self, values: Array, added: Array) -> None:
        """Add (p*c,) to values at the nodes that this rank owns, in place."""
        np.add.at(values, self.local, added[self._positions])


def padded(vector: Any, size: int) -> Any:
    """A vector in UFL with zeros behind its components, `size` in all."""
    count = vector.ufl_shape[0]
    if count == size:
        return vector
    return ufl.as_vector([*(vector[i] for i in range(count)), *[0] * (size - count)])


def squared(slopes: Any) -> Any:
    """Slopes (c, d) of a displacement in UFL as (c, c): nothing changes along z in the plane."""
    size, gdim = slopes.ufl_shape
    if size == gdim:
        return slopes
    return ufl.as_matrix([[*(slopes[i, j] for j in range(gdim)), 0] for i in range(size)])


def in_space_of(tensor: Any, size: int) -> Any:
    """Components (size, size) of a tensor (3, 3) in UFL."""
    return ufl.as_matrix([[tensor[i, j] for j in range(size)] for i in range(size)])


def _straightened(mesh: BodyMesh) -> BodyMesh:
    """A mesh of order 1 with the same corners.

    Linear displacements of curved elements contain no rotation and no even strain: turning such a
    body would take a moment, and moments on it would not balance.
    """
    corners, ends = CORNERS[mesh.cell], facet_node_count(mesh.cell, 1)
    kept, cells = np.unique(mesh.cells[:, :corners], return_inverse=True)
    boundaries = {
        name: np.searchsorted(kept, facets[:, :ends]) for name, facets in mesh.boundaries.items()
    }
    return BodyMesh(
        mesh.name, mesh.points[kept], cells.reshape(-1, corners), mesh.cell, 1, boundaries
    )


def _mesh_type(mesh: BodyMesh) -> tuple[str, str, int, int, int]:
    """Name, cell, order, nodes per cell and dimension of a mesh."""
    return mesh.name, mesh.cell, mesh.order, mesh.cells.shape[1], mesh.points.shape[1]
