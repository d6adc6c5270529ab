# SPDX-License-Identifier: LGPL-3.0-or-later
"""All bodies as one sparse system, nothing condensed: for the monolithic solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fretfe._typing import Array, Bools, Indices
from fretfe.bodies.definition import BodyDefinition, ModelDefinition
from fretfe.contact.interface import coordinate_range
from fretfe.fem.condensation import Body
from fretfe.fem.model import Reduction
from fretfe.fem.restraints import Restraints


@dataclass(frozen=True)
class FullSystem:
    """Operators on n unknowns x: displacements of free nodes and amplitudes of m constraints.

    With l load amplitudes a, forces R on the constraints and N nodal tractions λ of d components,

        K x = F a + R + Bᵀ λ

    Forces are per unit thickness in the plane.

    Attributes:
        stiffness: (n, n) K.
        loads: (n, l) F.
        coupling: (N*d, n) B: ∫ φ_i of gap and tangential displacement.
        gap: (N, d) nodal mean of both in the unloaded state (length).
        weights: (N,) integrals of the hat functions.
        modulus: (N,) Young's moduli of the two bodies in series (stress).
        fields: (n_b, n) displacements of each body in terms of x, in the order of its space.
        contacts: node range of each contact.
        constraints: (m,) where the amplitudes of the constraints stand in x.
        numbers: (m,) their numbers among the coordinates of the interface problem.
        prescribed: (m,) whether the amplitude is known, not the force.
    """

    stiffness: sparse.csr_matrix
    loads: Array
    coupling: sparse.csr_matrix
    gap: Array
    weights: Array
    modulus: Array
    fields: dict[str, sparse.csr_matrix]
    contacts: tuple[slice, ...]
    constraints: Indices
    numbers: Indices
    prescribed: Bools

    def relative(self, x: Array) -> Array:
        """(N, d) nodal mean of gap and tangential displacement."""
        return self.gap + (self.coupling @ x).reshape(self.gap.shape) / self.weights[:, None]


def assemble_system(bodies: dict[str, Body], reduction: Reduction) -> FullSystem:
    """Assemble the system of all bodies. Serial."""
    definitions = reduction.definition.bodies
    expansions = [_expansion(bodies[each.name], each) for each in definitions]
    expansion = sparse.block_diag(expansions).tocsr()
    own = [bodies[definition.name] for definition in definitions]
    stiffness = sparse.block_diag([_raw_stiffness(body) for body in own])
    loads = np.vstack([_load_columns(body, reduction.definition) for body in own])
    starts = _starts([e.shape[0] for e in expansions])
    couplings = [pair.coupling for pair in reduction.pairs]
    weights = np.concatenate([c.surface.weights for c in couplings])
    gap = np.zeros((len(weights), couplings[0].surface.frames.shape[1]))
    gap[:, 0] = np.concatenate([c.gap for c in couplings]) / weights
    constraints, numbers = _constraints(reduction, [e.shape[1] for e in expansions])
    return FullSystem(
        stiffness=(expansion.T @ stiffness @ expansion).tocsr(),
        loads=expansion.T @ loads,
        coupling=(_coupling(bodies, reduction, starts) @ expansion).tocsr(),
        gap=gap,
        weights=weights,
        modulus=_moduli(reduction),
        fields={
            definition.name: expansion[start:end]
            for definition, start, end in zip(definitions, starts[:-1], starts[1:], strict=True)
        },
        contacts=tuple(reduction.interface.contacts.values()),
        constraints=constraints,
        numbers=numbers,
        prescribed=reduction.interface.prescribed[numbers],
    )


def _starts(sizes: list[int]) -> Indices:
    """Where blocks that follow each other start; the end of the last one comes last."""
    return np.concatenate([[0], np.cumsum(sizes)])


def _expansion(body: Body, definition: BodyDefinition) -> sparse.csr_matrix:
    """Displacements of a body in terms of its free ones, then the amplitudes of its constraints."""
    restraints = Restraints(body.elastic, definition.constraints, definition.tie)
    columns = np.zeros((_size(body), len(definition.constraints)))
    for column, shape in zip(columns.T, restraints.shapes, strict=True):
        column[:] = shape.x.array
    unconstrained = np.setdiff1d(np.arange(len(columns)), restraints.constrained)
    free = restraints.turning.tocsc()[:, unconstrained]
    return sparse.hstack([free, sparse.csc_matrix(columns)], format="csr")


def _size(body: Body) -> int:
    """Number of displacement unknowns."""
    dofmap = body.elastic.space.dofmap
    return dofmap.index_map.size_local * dofmap.index_map_bs


def _raw_stiffness(body: Body) -> sparse.csr_matrix:
    """Stiffness of a body without constraints."""
    rows, columns, values = body.elastic.stiffness(np.empty(0, np.int32)).getValuesCSR()
    return sparse.csr_matrix((values, columns, rows))


def _load_columns(body: Body, definition: ModelDefinition) -> Array:
    """(n_b, l) nodal forces of unit loads."""
    columns = np.zeros((_size(body), len(definition.loads)))
    for column, load in zip(columns.T, definition.loads, strict=True):
        column[:] = body.elastic.load_vector(load).array
    return columns


def _coupling(bodies: dict[str, Body], reduction: Reduction, starts: Indices) -> sparse.csr_matrix:
    """(N*d, all displacements) operators of all contacts, one below the other."""
    # The surface unknowns of a body are those of its contact surfaces in the order of the pairs.
    first = {
        body.name: start for body, start in zip(reduction.definition.bodies, starts, strict=False)
    }
    used = dict.fromkeys(first, 0)
    rows = []
    for pair in reduction.pairs:
        shape = (pair.coupling.body1.shape[0], starts[-1])
        row = sparse.csr_matrix(shape)
        for name, operator in (
            (pair.body1, pair.coupling.body1),
            (pair.body2, pair.coupling.body2),
        ):
            end = used[name] + operator.shape[1]
            columns = first[name] + bodies[name].surface_unknowns[used[name] : end]
            used[name] = end
            row += sparse.csr_matrix(
                (operator.data, columns[operator.indices], operator.indptr), shape=shape
            )
        rows.append(row)
    return sparse.vstack(rows).tocsr()


def _constraints(reduction: Reduction, sizes: list[int]) -> tuple[Indices, Indices]:
    """(m,) places of the constraints in x, and their numbers in the interface problem."""
    places, numbers = [], []
    for definition, end in zip(reduction.definition.bodies, _starts(sizes)[1:], strict=True):
        count = len(definition.constraints)
        first = coordinate_range(reduction.interface.coordinates, definition.name).start
        places.append(np.arange(end - count, end))
        numbers.append(np.arange(first, first + count))
    return np.concatenate(places), np.concatenate(numbers)


def _moduli(reduction: Reduction) -> Array:
    """(N,) Young's moduli of the two bodies of each contact in series."""
    young = {body.name: body.material.young for body in reduction.definition.bodies}
    return np.concatenate(
        [
            np.full(
                len(pair.coupling.surface.weights),
                1 / (1 / young[pair.body1] + 1 / young[pair.body2]),
            )
            for pair in reduction.pairs
        ]
    )
