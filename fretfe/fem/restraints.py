# SPDX-License-Identifier: LGPL-3.0-or-later
"""Constrained displacements of a body: platens, tilts, supports, inclined rollers, tied sides.

Nodes on inclined rollers have frames of their own, one axis of which is the direction in which they
are held: there a constraint is a zero component like any other. So it is where one side of a sector
follows the other one: there the unknowns of a node are what it moves more than it has to.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from dolfinx import fem
from scipy import sparse

from fretfe._typing import Array, Indices
from fretfe.bodies.constraints import Constraint
from fretfe.bodies.cyclic import Tie
from fretfe.fem._compat import PETSc
from fretfe.fem.elasticity import ElasticBody, PlacedNodes

# Sine of the angle between a roller and the directions in which a node is held already, below which
# the roller adds nothing.
SMALLEST_ANGLE = 1e-6


class Restraints:
    """Displacements that constraints prescribe on the nodes of a body. Construction is collective.

    Args:
        elastic: the body.
        constraints: in order of precedence: where boundaries share a node, the first one moves it.
        tie: of the sides of a sector, or of parts; where they are constrained, they are so alike.

    Attributes:
        shapes: displacement by a unit amplitude of each constraint.
        constrained: local numbers of the constrained components, c * node + component, owned and
            ghosted; of nodes on rollers in their frames.
    """

    def __init__(
        self, elastic: ElasticBody, constraints: Sequence[Constraint], tie: Tie | None = None
    ) -> None:
        self._elastic = elastic
        points = elastic.node_points
        unknowns = len(points), elastic.components
        # The last one is of what the axis of a sector holds.
        values, self._held = (
            np.zeros((len(constraints) + 1, *unknowns)),
            np.zeros(unknowns, dtype=bool),
        )
        # By node: rows are the axes.
        self._frames: dict[int, Array] = {}
        holder = np.full(unknowns, "", dtype=object)
        for number, constraint in enumerate(constraints):
            if constraint.overlap:
                continue
            nodes = elastic.boundary_nodes(constraint.boundary)
            nodes = nodes[constraint.holds(points[nodes])]
            if constraint.roller:
                for node, along in zip(
                    nodes.tolist(), constraint.along(points[nodes]), strict=True
                ):
                    self._hold_along(node, along, values[:, node], number)
                continue
            moved = constraint.displacement(points[nodes])
            for component in constraint.components:
                taken = holder[nodes, component]
                own = (taken == "") | (taken == constraint.boundary)
                values[number, nodes[own], component] = moved[own, component]
                holder[nodes[own], component] = constraint.boundary
                self._held[nodes[own], component] = True
        self._tie = tie
        if tie is not None:
            self._tie_sides(tie, values)
            for number, constraint in enumerate(constraints):
                if constraint.overlap:  # what followers move more than they have to
                    nodes = elastic.boundary_nodes(constraint.boundary)
                    values[number, nodes] = constraint.direction
        self._nodes = np.array(sorted(self._frames), dtype=np.int64)
        axes = [self._frames[node] for node in self._nodes.tolist()]
        self._axes = np.array(axes).reshape(len(axes), elastic.components, elastic.components)
        self.constrained: Indices = np.flatnonzero(self._held)
        self.shapes = [self._function(each) for each in values[:-1]]

    def _tie_sides(self, tie: Tie, values: Array) -> None:
        """Let nodes follow those of the other side, whatever else constrains them."""
        self._followers = PlacedNodes(self._elastic, tie.followers, tie.groups[0])
        self._leaders = PlacedNodes(self._elastic, tie.leaders, tie.groups[1])
        followers = self._followers.ghosted
        values[:, followers] = 0.0
        self._held[followers] = True
        for node in followers.tolist():
            self._frames.pop(node, None)
        for node in PlacedNodes(self._elastic, tie.on_axis).ghosted.tolist():
            for direction in tie.across:
                self._hold_along(node, direction, values[:, node], len(values) - 1)

    def _hold_along(self, node: int, direction: Array, values: Array, number: int) -> None:
        """Hold a node along a direction, in what freedom others have left to it.

        Args:
            node: its local number.
            direction: unit vector.
            values: (m, c) displacement of the node by each constraint, in its frame; changed.
            number: of the roller among the constraints.
        """
        frame = self._frames.get(node, np.eye(len(direction)))
        seen, free = frame @ direction, np.flatnonzero(~self._held[node])
        length = np.linalg.norm(seen[free])
        if length < SMALLEST_ANGLE:
            return
        # The first free axis is turned into what is left of the direction.
        turned = np.linalg.qr(np.column_stack([seen[free] / length, np.eye(len(free))]))[0].T
        turned *= np.sign(turned[0] @ seen[free])
        frame = frame.copy()
        frame[free] = turned @ frame[free]
        self._frames[node] = frame
        # What the others prescribe at the node may move it along the direction: not so.
        values[:number, free[0]] = -(values[:number] @ seen) / length
        values[number, free[0]] = 1 / length
        self._held[node, free[0]] = True

    def _function(self, values: Array) -> fem.Function:
        """A displacement from values (n, c) in the frames of the nodes."""
        function = fem.Function(self._elastic.space)
        function.x.array[:] = values.ravel()
        self.turn_back(function.x.array)
        function.x.scatter_forward()
        return function

    def turn(self, values: Array) -> None:
        """Turn displacements (local numbers,) into the frames of the nodes, in place.

        Collective. Ghosts of nodes that follow others are not valid afterwards.
        """
        if self._tie is not None:
            self._followers.add(values, -self._following(values))
        self._apply(values, self._axes)

    def turn_back(self, values: Array) -> None:
        """Turn displacements back from the frames of the nodes, as `turn` turns them."""
        self._apply(values, self._axes.swapaxes(1, 2))
        if self._tie is not None:
            self._followers.add(values, self._following(values))

    def turn_forces(self, values: Array) -> None:
        """Turn forces (local numbers,) into the frames of the nodes, in place. Collective.

        Forces on nodes that follow others act on these.
        """
        if self._tie is not None:
            forces = self._followers.gather(values).reshape(-1, self._elastic.components)
            self._leaders.add(values, self._tie.passed_on(forces).ravel())
        self._apply(values, self._axes)

    def _following(self, values: Array) -> Array:
        """(s*c,) displacements of the nodes that follow those in `values`."""
        assert self._tie is not None
        leading = self._leaders.gather(values).reshape(-1, self._elastic.components)
        return self._tie.image(leading).ravel()

    def _apply(self, values: Array, axes: Array) -> None:
        rows = values.reshape(-1, self._elastic.components)
        known = self._nodes < len(rows)  # a vector of PETSc has no ghosts
        nodes = self._nodes[known]
        rows[nodes] = np.einsum("nij,nj->ni", axes[known], rows[nodes])

    def stiffness(self, fixed: Indices) -> PETSc.Mat:
        """Stiffness in the frames of the nodes, with unit rows and columns at fixed components.

        Collective.

        Args:
            fixed: local numbers as of `constrained`.
        """
        if self._tie is None and not self._elastic.comm.allreduce(len(self._nodes)):
            return self._elastic.stiffness(fixed.astype(np.int32))
        matrix = self._elastic.stiffness(np.empty(0, dtype=np.int32))
        start, end = matrix.getOwnershipRange()
        own = self.turning[start:end]
        integers = (each.astype(PETSc.IntType) for each in (own.indptr, own.indices))
        sizes = matrix.getSizes()
        turning = PETSc.Mat().createAIJ(sizes, csr=(*integers, own.data), comm=matrix.comm)
        turned = matrix.ptap(turning)
        rows = start + fixed[fixed < end - start]
        turned.zeroRowsColumns(rows.astype(PETSc.IntType), 1.0)
        turned.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return turned

    @cached_property
    def turning(self) -> sparse.csr_matrix:
        """(N, N) from displacements in the frames of the nodes, global numbers. Collective."""
        components, index_map = self._elastic.components, self._elastic.space.dofmap.index_map
        own = self._nodes < index_map.size_local
        numbers = self._nodes[own] + index_map.local_range[0]
        parts = self._elastic.comm.allgather((numbers, self._axes[own]))
        nodes = np.concatenate([part[0] for part in parts])
        axes = np.concatenate([part[1] for part in parts])
        size = index_map.size_global * components
        unknowns = nodes[:, None] * components + np.arange(components)
        others = np.delete(np.arange(size), unknowns.ravel())
        rows = np.concatenate([others, np.repeat(unknowns, components, axis=1).ravel()])
        columns = np.concatenate([others, np.tile(unknowns, (1, components)).ravel()])
        values = np.concatenate([np.ones(len(others)), axes.swapaxes(1, 2).ravel()])
        frames = sparse.csr_matrix((values, (rows, columns)), shape=(size, size))
        if self._tie is None:
            return frames
        shares = sparse.kron(self._tie.weights, self._tie.turn).tocoo()
        entries = (
            shares.data,
            (self._followers.numbers[shares.row], self._leaders.numbers[shares.col]),
        )
        return frames + sparse.csr_matrix(entries, shape=frames.shape) @ frames
