# SPDX-License-Identifier: LGPL-3.0-or-later
"""Static condensation of a body to its contact surfaces and rigid boundaries.

The retained unknowns are the displacements u of the nodes on the contact surfaces and the
coordinates c: the amplitude of every constrained boundary (platen, prescribed displacement,
support). With contact forces f on the surface nodes and load amplitudes a, the body obeys

    f + F a = S u + S_c c            forces on the surface nodes
    R + H a = S_cᵀ u + S_cc c        forces R that the boundaries exert on the body

exactly: static condensation of a linear body loses nothing. A surface node that belongs to a
constrained boundary as well moves with it, u = T c, and passes its force on: its rows of S, S_c and
F are those of an unknown without coupling, and Tᵀ f joins R. Displacements inside are recovered by
one back-substitution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from dolfinx import fem
from scipy.spatial import cKDTree

from fretfe._typing import Array, Indices
from fretfe.bodies.body import Constraint, DistributedLoad
from fretfe.bodies.rigid_modes import rigid_motions
from fretfe.fem._compat import PETSc
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.schur import SchurFactorization
from fretfe.fem.timing import Clock

# Surface nodes are found by their coordinates, to this fraction of the size of the surface.
MATCH_TOLERANCE = 1e-8


@dataclass(frozen=True)
class MomentOperators:
    """Moments on a body about the middle of its contact surfaces, k of them: one in the plane.

    Attributes:
        displacement: (k, n) of the reactions of constrained boundaries, by surface displacements,
        coordinates: (k, m) by coordinates,
        loads: (k, l) and by loads: together with the moments of the loads themselves.
        forces: (k, n) of contact forces on the surface nodes that are not constrained; those on
            the others are reactions too.
        size: largest extent of the body.
    """

    displacement: Array
    coordinates: Array
    loads: Array
    forces: Array
    size: float


@dataclass(frozen=True)
class CondensedBody:
    """Condensed operators of a body; see the module's docstring.

    n surface unknowns (node by node, components together), m coordinates, l loads. Forces are per
    unit thickness in the plane.

    Attributes:
        name: body.
        stiffness: (n, n) S, symmetric, singular if the body can move freely.
        coupling: (n, m) S_c.
        coordinate_stiffness: (m, m) S_cc.
        surface_loads: (n, l) F.
        coordinate_loads: (m, l) H.
        prescribed: (n, m) T, zero but for surface nodes on constrained boundaries.
        modes: (n, k) orthonormal motions of the surface nodes in the rigid modes that are
            restrained only by contact.
        load_resultants: (gdim, l) total force of each load.
        moments: what moments on the body follow from.
    """

    name: str
    stiffness: Array
    coupling: Array
    coordinate_stiffness: Array
    surface_loads: Array
    coordinate_loads: Array
    prescribed: Array
    modes: Array
    load_resultants: Array
    moments: MomentOperators


class Body:
    """An elastic body, its constraints and loads, factorised once. All methods are collective.

    Args:
        elastic: space and operators of the body.
        constraints: in order of precedence: where boundaries share a node, the first one moves it.
        loads: distributed loads.
        surface_points: (n, gdim) displacement points of the contact surfaces.
        clock: for timings.
    """

    def __init__(
        self,
        elastic: ElasticBody,
        constraints: list[Constraint],
        loads: list[DistributedLoad],
        surface_points: Array,
        clock: Clock,
    ) -> None:
        self.elastic = elastic
        self._index_map = elastic.space.dofmap.index_map
        self._shapes = shapes = constraint_shapes(elastic, constraints)
        self._constrained = np.flatnonzero(np.any([s.x.array != 0 for s in shapes], axis=0))
        self._retain(surface_points)
        with clock("assembly"):
            self._matrix = elastic.stiffness(self._constrained.astype(np.int32))
        with clock("condensation"):
            self._factor = SchurFactorization(self._matrix, self.retained)
        # Displacement fields of a unit coordinate and a unit load with all else at zero.
        self._coordinate_fields: list[PETSc.Vec] = []
        self._load_fields: list[PETSc.Vec] = []
        with clock("load columns"):
            self.condensed = self._condense(shapes, [elastic.load_vector(load) for load in loads])

    def _retain(self, surface_points: Array) -> None:
        """Find the surface nodes: their global unknowns, and which of them this rank owns."""
        gdim, comm = self.elastic.gdim, self.elastic.comm
        owned = self._index_map.size_local
        coordinates = self.elastic.space.tabulate_dof_coordinates()[:owned, :gdim]
        extent = np.ptp(surface_points, axis=0).max()
        distance, node = (
            cKDTree(coordinates).query(surface_points)
            if owned
            else (np.full(len(surface_points), np.inf), np.zeros(len(surface_points), int))
        )
        mine = np.flatnonzero(distance < MATCH_TOLERANCE * extent)
        components = np.arange(gdim)
        self._own_positions = (mine[:, None] * gdim + components).ravel()
        self._own_local = (node[mine][:, None] * gdim + components).ravel()
        offset = self._index_map.local_range[0] * gdim
        found = comm.allgather((self._own_positions, self._own_local + offset))
        self.retained = np.full(len(surface_points) * gdim, -1)
        for positions, unknowns in found:
            self.retained[positions] = unknowns
        assert np.all(self.retained >= 0), "a surface node is not a node of the body"
        self._surface_points = surface_points

    def _condense(
        self, shapes: list[fem.Function], load_vectors: list[PETSc.Vec]
    ) -> CondensedBody | None:
        """Schur complement and condensed columns; the result is on rank 0 only."""
        coordinate_forces = [self.elastic.forces(shape) for shape in shapes]
        for force in coordinate_forces:
            self._coordinate_fields.append(self._interior_response(-1.0 * force))
        for vector in load_vectors:
            self._load_fields.append(self._interior_response(vector))
        coupling = [
            self._gather_unconstrained(force + self._matrix * field)
            for force, field in zip(coordinate_forces, self._coordinate_fields, strict=True)
        ]
        surface_loads = [
            self._gather_unconstrained(vector - self._matrix * field)
            for vector, field in zip(load_vectors, self._load_fields, strict=True)
        ]
        shape_vectors = [shape.x.petsc_vec for shape in shapes]
        stiffness = _products(shape_vectors, coordinate_forces) + _products(
            coordinate_forces, self._coordinate_fields
        )
        coordinate_loads = _products(shape_vectors, load_vectors) - _products(
            coordinate_forces, self._load_fields
        )
        resultants = self._resultants(load_vectors)
        moments = self._moments(shape_vectors, coordinate_forces, load_vectors)
        modes = self._rigid_modes()
        prescribed = [self._gather(vector) for vector in shape_vectors]
        if self.elastic.comm.rank != 0:
            return None
        assert self._factor.complement is not None
        assert moments is not None
        size = len(self.retained)
        return CondensedBody(
            name=self.elastic.name,
            stiffness=self._factor.complement,
            coupling=_columns(coupling, size),
            coordinate_stiffness=(stiffness + stiffness.T) / 2,
            surface_loads=_columns(surface_loads, size),
            coordinate_loads=coordinate_loads,
            prescribed=_columns(prescribed, size),
            modes=modes,
            load_resultants=resultants,
            moments=moments,
        )

    def _moments(
        self,
        shapes: list[PETSc.Vec],
        coordinate_forces: list[PETSc.Vec],
        load_vectors: list[PETSc.Vec],
    ) -> MomentOperators | None:
        """Reactions on one more coordinate each, which turns the constrained nodes; on rank 0.

        Reaction by reaction, a coordinate has only the sum of its nodal forces, not their moment.
        """
        whole, held = self._rotations()
        turning = [each.x.petsc_vec for each in held]
        forces = [self.elastic.forces(each) for each in held]
        fields = [self._interior_response(-1.0 * force) for force in forces]
        coupling = [
            self._gather_unconstrained(force + self._matrix * field)
            for force, field in zip(forces, fields, strict=True)
        ]
        coordinates = _products(turning, coordinate_forces) + _products(
            forces, self._coordinate_fields
        )
        reactions = _products(turning, load_vectors) - _products(forces, self._load_fields)
        everything = [each.x.petsc_vec for each in whole]
        unconstrained = [self._gather_unconstrained(each.copy()) for each in everything]
        points = self.elastic.space.tabulate_dof_coordinates()
        size = float(np.ptp(np.vstack(self.elastic.comm.allgather(points)), axis=0).max())
        loads = _products(everything, load_vectors) - reactions
        if self.elastic.comm.rank != 0:
            return None
        return MomentOperators(
            displacement=_columns(coupling, len(self.retained)).T,
            coordinates=coordinates,
            loads=loads,
            forces=_columns(unconstrained, len(self.retained)).T,
            size=size,
        )

    def _rotations(self) -> tuple[list[fem.Function], list[fem.Function]]:
        """Rotations of all nodes, and of the constrained ones alone."""
        gdim = self.elastic.gdim
        points = self.elastic.space.tabulate_dof_coordinates()[:, :gdim]
        motions = rigid_motions(points - self._surface_points.mean(axis=0))
        whole, held = [], []
        for mode in range(gdim, motions.shape[2]):
            turned, fixed = fem.Function(self.elastic.space), fem.Function(self.elastic.space)
            turned.x.array[:] = motions[:, :, mode].ravel()
            fixed.x.array[self._constrained] = turned.x.array[self._constrained]
            whole.append(turned)
            held.append(fixed)
        return whole, held

    def _interior_response(self, forces: PETSc.Vec) -> PETSc.Vec:
        """Displacement under nodal forces with surface nodes and coordinates at zero."""
        rhs = forces.copy()
        rhs.array[self._own_constrained()] = 0.0
        rhs.array[self._own_local] = 0.0
        field = self._factor.solve_interior(rhs)
        field.array[self._own_local] = 0.0
        return field

    def _own_constrained(self) -> Indices:
        owned = self._index_map.size_local * self.elastic.gdim
        return self._constrained[self._constrained < owned]

    def _gather_unconstrained(self, vector: PETSc.Vec) -> Array | None:
        """(n,) values at the retained unknowns, zero where they are constrained; on rank 0."""
        vector.array[self._own_constrained()] = 0.0
        return self._gather(vector)

    def _gather(self, vector: PETSc.Vec) -> Array | None:
        """(n,) values at the retained unknowns, on rank 0."""
        comm = self.elastic.comm
        parts = comm.gather((self._own_positions, vector.array[self._own_local].copy()))
        if parts is None:
            return None
        values = np.empty(len(self.retained))
        for positions, part in parts:
            values[positions] = part
        return values

    def _resultants(self, vectors: list[PETSc.Vec]) -> Array:
        """(gdim, l) sums of nodal force vectors."""
        gdim = self.elastic.gdim
        local = np.array([v.array.reshape(-1, gdim).sum(axis=0) for v in vectors])
        return self.elastic.comm.allreduce(local.reshape(len(vectors), gdim)).T

    def _rigid_modes(self) -> Array:
        """(n, k) motions of the surface nodes in rigid modes that no constraint restrains."""
        gdim = self.elastic.gdim
        points = self.elastic.space.tabulate_dof_coordinates()
        centre = self._surface_points.mean(axis=0)
        size = np.ptp(self._surface_points, axis=0).max()
        own = self._own_constrained()
        values = rigid_motions((points[own // gdim, :gdim] - centre) / size)
        rows = values[np.arange(len(own)), own % gdim]
        gram = self.elastic.comm.allreduce(rows.T @ rows)
        stretch, combinations = np.linalg.eigh(gram)
        # A restrained mode moves many constrained nodes by about one, any other none at all.
        free = combinations[:, stretch < 1e-8 * max(stretch[-1], 1.0)]
        surface = rigid_motions((self._surface_points - centre) / size)
        return np.linalg.qr(surface.reshape(-1, surface.shape[2]) @ free)[0]

    def recover(self, surface: Array, coordinates: Array, amplitudes: Array) -> fem.Function:
        """Displacement field of a solved step. Collective; same arguments on all ranks.

        Args:
            surface: (n,) displacements of the surface nodes.
            coordinates: (m,) amplitudes of the constraints.
            amplitudes: (l,) load amplitudes.
        """
        moved = self._matrix.createVecRight()
        moved.array[self._own_local] = surface[self._own_positions]
        moved.array[self._own_constrained()] = 0.0
        field = self._interior_response(-1.0 * (self._matrix * moved))
        field.axpy(1.0, moved)
        for c, shape, response in zip(
            coordinates, self._shapes, self._coordinate_fields, strict=True
        ):
            field.axpy(c, shape.x.petsc_vec)
            field.axpy(c, response)
        for a, response in zip(amplitudes, self._load_fields, strict=True):
            field.axpy(a, response)
        displacement = fem.Function(self.elastic.space, name="displacement")
        displacement.x.array[: len(field.array)] = field.array
        displacement.x.scatter_forward()
        return displacement


def constraint_shapes(elastic: ElasticBody, constraints: list[Constraint]) -> list[fem.Function]:
    """Displacements of the constrained nodes by a unit amplitude of each constraint."""
    gdim = elastic.gdim
    shapes = [fem.Function(elastic.space) for _ in constraints]
    holder = np.full((len(elastic.space.tabulate_dof_coordinates()), gdim), "", dtype=object)
    for constraint, shape in zip(constraints, shapes, strict=True):
        nodes = elastic.boundary_nodes(constraint.boundary)
        values = shape.x.array.reshape(-1, gdim)
        for component in np.flatnonzero(constraint.direction):
            holders = holder[nodes, component]
            free = nodes[(holders == "") | (holders == constraint.boundary)]
            values[free, component] = constraint.direction[component]
            holder[free, component] = constraint.boundary
    return shapes


def _products(left: list[PETSc.Vec], right: list[PETSc.Vec]) -> Array:
    """(len(left), len(right)) scalar products."""
    return np.array([[u.dot(v) for v in right] for u in left]).reshape(len(left), len(right))


def _columns(vectors: list[Array | None], size: int) -> Array:
    return np.array(vectors, dtype=float).reshape(len(vectors), size).T
