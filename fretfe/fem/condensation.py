# SPDX-License-Identifier: LGPL-3.0-or-later
"""Static condensation of a body to its contact multipliers and rigid boundaries.

With the weighted tractions y at its contact nodes, the coordinates c (amplitudes of constrained
boundaries, then of the motions that only contact restrains) and the load amplitudes a, a body moves
its contact nodes and pulls at its boundaries by

    w_b = C y + G c + L a
    R + H a = −Gᵀ y + K c

exactly: static condensation of a linear body loses nothing. A contact node that belongs to a
constrained boundary as well moves with it and passes its force on. Displacement fields follow by
one solve with the factor that gave C.

A body that can move freely is held at as many displacements as it has free motions. Forces are
balanced on the contact surfaces before, and the mean motion there is taken out after, so that it
does not matter which displacements they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np
from dolfinx import fem
from scipy import sparse
from scipy.linalg import qr

from fretfe._typing import Array, Indices
from fretfe.bodies.constraints import Constraint
from fretfe.bodies.cyclic import Tie
from fretfe.bodies.loads.spread import SpreadLoad
from fretfe.fem._compat import MPI, PETSc
from fretfe.fem.bordered import BorderedFactor, unsymmetric_because
from fretfe.fem.elasticity import ElasticBody, PlacedNodes
from fretfe.fem.restraints import Restraints
from fretfe.fem.symmetric import SymmetricMatrix
from fretfe.fem.timing import Clock
from fretfe.fields.rigid_motions import rigid_motions


@dataclass(frozen=True)
class CondensedBody:
    """Condensed operators of a body; see the module's docstring.

    n weighted tractions, m constraints and k free motions, l loads, c components of the
    displacement. Forces are per unit thickness in the plane.

    Attributes:
        name: body.
        compliance: (n, n) C, symmetric, positive semi-definite.
        motion: (n, m + k) G.
        loads: (n, l) L.
        stiffness: (m + k, m + k) K.
        coordinate_loads: (m + k, l) H.
        load_resultants: (c, l) total force of each load.
        load_sizes: (l,) sum of the lengths of the nodal forces of each load. Initial strains have
            none: they push nothing by themselves.
        contact_resultants: (c, n) total force on the body by tractions.
        moments: (r, n + m + l) sum of the moments of reactions, loads and contact, r of them (one
            in the plane), about the middle of the contact surfaces, by y, coordinates of the
            constraints and a.
        size: largest extent of the body.
        held: true if displacements of its contact surfaces are constrained.
    """

    name: str
    compliance: SymmetricMatrix
    motion: Array
    loads: Array
    stiffness: Array
    coordinate_loads: Array
    load_resultants: Array
    load_sizes: Array
    contact_resultants: Array
    moments: Array
    size: float
    held: bool


class Body:
    """An elastic body, its constraints and loads, factorised once. All methods are collective.

    Args:
        elastic: space and operators of the body.
        constraints: in order of precedence: where boundaries share a node, the first one moves it.
        loads: spread loads.
        surface_points: (p, gdim) displacement points of the contact surfaces.
        operator: (n, p*c) weighted relative displacements of the contact nodes by those of the
            points; the same on all ranks.
        clock: for timings.
        tie: of the sides of a sector, or of the parts of the body; the same on all ranks.
        on_disk: whether the factor is kept in temporary files.

    Attributes:
        elastic: space and operators of the body.
        loads: spread loads.
        surface_unknowns: (p*c,) global numbers of the displacements of the surface points.
        condensed: on rank 0 until it is part of the interface problem, None elsewhere.
    """

    def __init__(
        self,
        elastic: ElasticBody,
        constraints: list[Constraint],
        loads: list[SpreadLoad],
        surface_points: Array,
        operator: sparse.csr_matrix,
        clock: Clock,
        tie: Tie | None = None,
        *,
        on_disk: bool = False,
    ) -> None:
        self.elastic = elastic
        self._index_map = elastic.space.dofmap.index_map
        self._operator = operator
        self._surface_points = surface_points
        self.loads = tuple(loads)
        self._surface = PlacedNodes(elastic, surface_points)
        self.surface_unknowns = self._surface.numbers
        with clock("assembly"):
            self._restraints = Restraints(elastic, constraints, tie)
            shapes = self._restraints.shapes
            self._shapes = [shape.x.petsc_vec.copy() for shape in shapes]
            self._constrained = self._restraints.constrained
            self._motions = self._free_motions()
            self._fixed = np.concatenate([self._constrained, self._pins()])
            matrix = self._restraints.stiffness(self._fixed)
            self._shape_forces = [elastic.forces(shape) for shape in shapes]
            self._loads = [elastic.load_vector(load) for load in loads]
        unknowns = elastic.components * self._index_map.size_global
        with clock("condensation", f"{elastic.name}, {unknowns} unknowns"):
            symmetric = elastic.comm.allreduce(not unsymmetric_because(), op=MPI.LAND)
            kind = {"symmetric": symmetric, "on_disk": on_disk}
            self._factor = BorderedFactor(matrix, self._border(), elastic.gdim, **kind)
        with clock("load columns"):
            self.condensed = self._condense()

    def _free_motions(self) -> list[PETSc.Vec]:
        """Rigid motions that no constraint restrains, orthonormal on the surface nodes."""
        components = self.elastic.components
        centre = self._surface_points.mean(axis=0)
        size = np.ptp(self._surface_points, axis=0).max()
        everywhere = rigid_motions((self.elastic.node_points - centre) / size, components)
        everywhere = everywhere.reshape(-1, everywhere.shape[2])
        turned = everywhere.copy()
        for column in turned.T:
            self._restraints.turn(column)
        rows = turned[_owned(self._constrained, self._own)]
        stretch, combinations = np.linalg.eigh(self.elastic.comm.allreduce(rows.T @ rows))
        # A restrained mode moves many constrained nodes by about one, any other none at all.
        free = combinations[:, stretch < 1e-8 * max(stretch[-1], 1.0)]
        surface = rigid_motions((self._surface_points - centre) / size, components)
        surface = surface.reshape(-1, surface.shape[2])
        self._surface_motions, units = np.linalg.qr(surface @ free)
        motions = []
        for values in np.linalg.solve(units.T, (everywhere @ free).T):
            motion = fem.Function(self.elastic.space)
            motion.x.array[:] = values
            motions.append(motion.x.petsc_vec.copy())
        return motions

    def _pins(self) -> Indices:
        """Local numbers of the displacements that hold the free motions, owned and ghosted."""
        if not self._motions:
            return np.array([], dtype=np.int64)
        start = self._index_map.local_range[0] * self.elastic.components
        values = np.array([motion.array for motion in self._motions])
        for each in values:
            self._restraints.turn(each)
        values[:, _owned(self._constrained, self._own)] = 0.0
        # As far apart as possible: those that a pivoted QR decomposition takes first.
        count = len(values)
        best = qr(values, mode="r", pivoting=True)[1][:count] if values.size else np.array([], int)
        candidates = self.elastic.comm.allgather([(start + j, values[:, j]) for j in best])
        numbers, columns = zip(*(pair for part in candidates for pair in part), strict=True)
        chosen = np.array(numbers)[qr(np.array(columns).T, mode="r", pivoting=True)[1][:count]]
        nodes, component = np.divmod(chosen, self.elastic.components)
        local = self._index_map.global_to_local(nodes.astype(np.int64))
        here = local >= 0
        return np.asarray(local[here] * self.elastic.components + component[here], dtype=np.int64)

    @property
    def _own(self) -> int:
        """Number of displacements that this rank owns."""
        return int(self._index_map.size_local * self.elastic.components)

    def _border(self) -> sparse.csr_matrix:
        """(n, N) operator on all unknowns, zero at fixed ones; on every rank."""
        start = self._index_map.local_range[0] * self.elastic.components
        fixed = start + _owned(self._fixed, self._own)
        everywhere = np.concatenate(self.elastic.comm.allgather(fixed))
        entries = sparse.coo_matrix(self._operator)
        columns = self.surface_unknowns[entries.col]
        size = self._index_map.size_global * self.elastic.components
        shape = self._operator.shape[0], size
        border = sparse.csr_matrix((entries.data, (entries.row, columns)), shape=shape)
        moving = np.ones(size)
        moving[everywhere] = 0.0
        border = border @ self._restraints.turning @ sparse.diags(moving)
        border.eliminate_zeros()
        return border.tocsr()

    def _respond(self, forces: list[PETSc.Vec]) -> list[PETSc.Vec]:
        """Displacements under nodal forces with the constrained boundaries at rest.

        Forces are balanced on the contact surfaces, whose mean free motion is zero.
        """
        fields = self._respond_held([self._balanced(each) for each in forces])
        for field in fields:
            mean = self._surface_motions.T @ self._surface.gather(field.array)
            _add(field, -mean, self._motions)
        return fields

    def _balanced(self, forces: PETSc.Vec) -> PETSc.Vec:
        """Nodal forces with others on the contact surfaces that balance them."""
        balanced = forces.copy()
        excess = [motion.dot(forces) for motion in self._motions]
        self._surface.add(balanced.array, -(self._surface_motions @ np.array(excess)))
        return balanced

    def _respond_held(self, forces: list[PETSc.Vec]) -> list[PETSc.Vec]:
        """Displacements under nodal forces with all that is fixed at rest; changes the forces."""
        fixed = _owned(self._fixed, self._own)
        for each in forces:
            self._restraints.turn_forces(each.array)
            each.array[fixed] = 0.0
        fields = self._factor.solve(forces)
        for each in fields:
            self._restraints.turn_back(each.array)
        return fields

    def _relative(self, vectors: list[PETSc.Vec]) -> Array:
        """(n, len(vectors)) displacements of the contact nodes."""
        surface = [self._surface.gather(vector.array) for vector in vectors]
        return np.asarray(self._operator @ _columns(surface, self._operator.shape[1]))

    def _condense(self) -> CondensedBody | None:
        """All operators; on rank 0 only."""
        whole, held = self._rotations()
        turning = [self.elastic.forces(each) for each in held]
        # All at once: one reading of the factor.
        reactions = [-1.0 * force for force in self._shape_forces + turning]
        responses = iter(self._respond(self._loads + reactions))
        loaded = list(islice(responses, len(self._loads)))
        fields = list(islice(responses, len(self._shapes)))
        free = np.asarray(self._operator @ self._surface_motions)
        compliance, fill = self._compliance(free)
        pushed = _products(self._motions, self._loads)
        driven = [shape + field for shape, field in zip(self._shapes, fields, strict=True)]
        motion = np.hstack([self._relative(driven), free])
        loads = self._relative(loaded) + fill * free @ pushed
        stiffness = np.zeros((motion.shape[1], motion.shape[1]))
        count = len(fields)
        stiffness[:count, :count] = _products(driven, self._shape_forces)
        coordinate_loads = _products(self._shapes, self._loads)
        coordinate_loads -= _products(self._shape_forces, loaded)
        arms = [
            everything.x.petsc_vec - motion.x.petsc_vec - response
            for everything, motion, response in zip(whole, held, responses, strict=True)
        ]
        moments, size = self._moments(arms, turning, driven), self._size()
        resultants, sizes = self._resultants()
        own = np.isin(self._surface.local, self._constrained).any()
        surface_held = self.elastic.comm.allreduce(int(own)) > 0
        if compliance is None:
            return None
        everywhere = np.tile(np.eye(self.elastic.components), (len(self._surface_points), 1))
        return CondensedBody(
            name=self.elastic.name,
            compliance=compliance,
            motion=motion,
            loads=loads,
            stiffness=(stiffness + stiffness.T) / 2,
            coordinate_loads=np.vstack([coordinate_loads, pushed]),
            load_resultants=resultants,
            load_sizes=sizes,
            contact_resultants=(self._operator @ everywhere).T,
            moments=moments,
            size=size,
            held=surface_held,
        )

    def _compliance(self, free: Array) -> tuple[SymmetricMatrix | None, float]:
        """(n, n) compliance on rank 0, and the compliance given to free motions.

        Balancing the forces and taking the mean motion out of the displacements, as `_respond`
        does, is of low rank. The forces along a free motion vanish in equilibrium; a compliance for
        them makes no difference then, and the whole one definite.

        Args:
            free: (n, k) displacements of the contact nodes by the free motions.
        """
        compliance, comm = self._factor.compliance, self.elastic.comm
        if not self._motions:
            return compliance, 0.0
        held = self._respond_held(self._balancing_forces())
        coupling = self._relative(held)
        mean = self._surface_motions.T @ _columns(
            [self._surface.gather(each.array) for each in held], len(self.surface_unknowns)
        )
        fill = 0.0
        if compliance is not None:
            left = np.hstack([free, coupling, free @ mean])
            compliance.add_product(left, np.hstack([-coupling, -free, free]))
            fill = compliance.trace() / float(np.sum(free**2))
            compliance.add_product(fill * free, free)
        return compliance, comm.bcast(fill)

    def _balancing_forces(self) -> list[PETSc.Vec]:
        """Forces on the surface nodes that do unit work in one free motion each."""
        vectors = []
        for column in self._surface_motions.T:
            vector = self._zeros()
            self._surface.add(vector.array, column)
            vectors.append(vector)
        return vectors

    def _moments(
        self, arms: list[PETSc.Vec], turning: list[PETSc.Vec], driven: list[PETSc.Vec]
    ) -> Array:
        """Moments of reactions, loads and contact.

        Reaction by reaction, a coordinate has only the sum of its nodal forces, not their moment:
        that is the reaction on a coordinate that turns the constrained nodes.

        Args:
            arms: displacements that nodal forces do as much work in as they have moments.
            turning: forces that turn the constrained nodes, all others at rest.
            driven: displacement by each constraint.
        """
        moments = [
            self._relative(arms).T,
            _products(turning, driven),
            _products(arms, self._loads),
        ]
        return np.hstack(moments)

    def _size(self) -> float:
        """Largest extent of the body."""
        points = self.elastic.space.tabulate_dof_coordinates()
        ends = self.elastic.comm.allgather([points.min(axis=0), points.max(axis=0)])
        return float(np.ptp(np.vstack(ends), axis=0).max())

    def _rotations(self) -> tuple[list[fem.Function], list[fem.Function]]:
        """Rotations of all nodes, and of the constrained ones alone."""
        components, centre = self.elastic.components, self._surface_points.mean(axis=0)
        motions = rigid_motions(self.elastic.node_points - centre, components)
        whole, held = [], []
        for mode in range(components, motions.shape[2]):
            turned, fixed = fem.Function(self.elastic.space), fem.Function(self.elastic.space)
            turned.x.array[:] = motions[:, :, mode].ravel()
            values = turned.x.array.copy()
            self._restraints.turn(values)
            fixed.x.array[self._constrained] = values[self._constrained]
            self._restraints.turn_back(fixed.x.array)
            fixed.x.scatter_forward()
            whole.append(turned)
            held.append(fixed)
        return whole, held

    def _resultants(self) -> tuple[Array, Array]:
        """(c, l) total force of each load, and (l,) lengths of its nodal forces together."""
        size, strained = self.elastic.components, self.elastic.name
        nodal = [vector.array.reshape(-1, size) for vector in self._loads]
        total = np.array([each.sum(axis=0) for each in nodal]).reshape(-1, size)
        lengths = [
            0.0 if load.strains(strained) else np.linalg.norm(each, axis=1).sum()
            for load, each in zip(self.loads, nodal, strict=True)
        ]
        allreduce = self.elastic.comm.allreduce
        return allreduce(total).T, allreduce(np.array(lengths))

    def recover(self, states: list[tuple[Array, Array, Array]]) -> list[fem.Function]:
        """Displacement fields of solved steps. Collective; same arguments on all ranks.

        Args:
            states: (n,) weighted tractions y, (m + k,) coordinates c and (l,) load amplitudes.
        """
        fields = self._respond([self._forces(*state) for state in states])
        recovered = []
        for field, (_, coordinates, _) in zip(fields, states, strict=True):
            _add(field, coordinates, self._shapes + self._motions)
            displacement = fem.Function(self.elastic.space, name="displacement")
            displacement.x.array[: len(field.array)] = field.array
            displacement.x.scatter_forward()
            recovered.append(displacement)
        return recovered

    def initial_stress(self, amplitudes: Array) -> fem.Function | None:
        """Stress (3, 3) of the initial strains of load amplitudes (l,); None without any."""
        found = [self.elastic.initial_stress(load) for load in self.loads]
        parts = [
            (amplitude, part)
            for amplitude, part in zip(amplitudes, found, strict=True)
            if part is not None
        ]
        if not parts:
            return None
        total = fem.Function(parts[0][1].function_space)
        total.x.array[:] = sum(amplitude * part.x.array for amplitude, part in parts)
        return total

    def _forces(self, traction: Array, coordinates: Array, amplitudes: Array) -> PETSc.Vec:
        """Nodal forces by tractions, constrained boundaries and loads."""
        forces = self._zeros()
        self._surface.add(forces.array, self._operator.T @ traction)
        _add(forces, amplitudes, self._loads)
        _add(forces, -coordinates[: len(self._shapes)], self._shape_forces)
        return forces

    @property
    def stiffness(self) -> PETSc.Mat:
        """Stiffness matrix, with unit rows and columns where the body is held.

        Nodes on inclined rollers have frames of their own in it.
        """
        return self._factor.matrix

    def surface_displacement(self, displacement: fem.Function) -> Array:
        """(p, c) displacements of the nodes of the contact surfaces, on every rank."""
        return self._surface.gather(displacement.x.array).reshape(-1, self.elastic.components)

    def _zeros(self) -> PETSc.Vec:
        """A zero vector of displacements or nodal forces."""
        zero = fem.Function(self.elastic.space)  # owns the memory that its vector views
        vector = zero.x.petsc_vec.copy()
        vector.zeroEntries()
        return vector


def _add(vector: PETSc.Vec, factors: Array, vectors: list[PETSc.Vec]) -> None:
    """Add multiples of vectors to one."""
    for factor, other in zip(factors, vectors, strict=True):
        vector.axpy(factor, other)


def _owned(local: Indices, own: int) -> Indices:
    """Those of some local numbers that belong to the rank, which owns the first ones."""
    return np.asarray(local[local < own])


def _products(left: list[PETSc.Vec], right: list[PETSc.Vec]) -> Array:
    """(len(left), len(right)) scalar products."""
    return np.array([[u.dot(v) for v in right] for u in left]).reshape(len(left), len(right))


def _columns(vectors: list[Array], size: int) -> Array:
    return np.array(vectors, dtype=float).reshape(len(vectors), size).T
