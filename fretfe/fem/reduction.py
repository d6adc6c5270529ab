# SPDX-License-Identifier: LGPL-3.0-or-later
"""Condensed bodies and couplings reduced to the interface problem of `fretfe.contact.interface`."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.linalg import cholesky, solve_triangular

from fretfe._typing import Array
from fretfe.bodies.pairs import Pair
from fretfe.contact.compliance import DenseCompliance
from fretfe.contact.interface import Coordinate, Interface, coordinate_range, require_restraint
from fretfe.fem.condensation import CondensedBody


class ReducedBody:
    """A condensed body solved for its surface displacements.

    u = C (f + F a − S_c c) + T c + Q g with C the (generalised) inverse of S at unconstrained nodes
    and Q the rigid modes restrained only by contact.

    Args:
        body: condensed body.
        operator: (N*d, n) scaled coupling operator of all contacts on this body's surface.
    """

    def __init__(self, body: CondensedBody, operator: sparse.csr_matrix) -> None:
        self.body = body
        self._operator = operator
        # Rigid modes get an artificial stiffness; equilibrium makes the forces on them vanish.
        level = np.trace(body.stiffness) / len(body.stiffness)
        pinned = body.stiffness + level * body.modes @ body.modes.T
        self._factor = cholesky(pinned, lower=True, overwrite_a=True, check_finite=False)
        unconstrained = ~body.prescribed.any(axis=1)
        self._own = operator @ sparse.diags(unconstrained.astype(float))
        self._half = self._forward(self._own.T.toarray())

    def _forward(self, rhs: Array) -> Array:
        return solve_triangular(self._factor, rhs, lower=True, check_finite=False)

    def add_to(self, system: dict[str, Array], columns: slice) -> None:
        """Add this body to A, L, G, K and H; `columns` are its coordinates, rigid modes last."""
        body = self.body
        half_loads = self._forward(body.surface_loads)
        half_coupling = self._forward(body.coupling)
        count = body.coupling.shape[1]
        driven = slice(columns.start, columns.start + count)
        rigid = slice(driven.stop, columns.stop)
        system["compliance"] += self._half.T @ self._half
        system["loads"] += self._half.T @ half_loads
        system["motion"][:, driven] = self._operator @ body.prescribed
        system["motion"][:, driven] -= self._half.T @ half_coupling
        system["motion"][:, rigid] = self._operator @ body.modes
        system["stiffness"][driven, driven] = (
            body.coordinate_stiffness - half_coupling.T @ half_coupling
        )
        system["coordinate_loads"][driven] = body.coordinate_loads - half_coupling.T @ half_loads
        system["coordinate_loads"][rigid] = body.modes.T @ body.surface_loads

    def contact_forces(self, y: Array) -> Array:
        """(T, d) sum of the contact forces on this body for weighted tractions (T, N*d)."""
        nodal = self._operator.T @ y.T
        return nodal.reshape(-1, len(self.body.load_resultants), len(y)).sum(axis=0).T

    def moments(self, y: Array, coordinates: Array, amplitudes: Array) -> Array:
        """(T, k) sum of all moments on this body, for arguments of `surface_displacement` in rows.

        They are those of reactions, loads and contact, about the middle of its contact surfaces.
        """
        parts = self.body.moments
        surface = self.surface_displacement(y.T, coordinates.T, amplitudes.T)
        total = parts.displacement @ surface + parts.loads @ amplitudes.T
        total += parts.coordinates @ coordinates[:, : parts.coordinates.shape[1]].T
        total += parts.forces @ (self._operator.T @ y.T)
        return np.asarray(total.T)

    def relative_displacement(self, y: Array, coordinates: Array, amplitudes: Array) -> Array:
        """(T, N*d) part of this body in w, for arguments of `surface_displacement` in T rows."""
        surface = self.surface_displacement(y.T, coordinates.T, amplitudes.T)
        return np.asarray((self._operator @ surface).T)

    def surface_displacement(self, y: Array, coordinates: Array, amplitudes: Array) -> Array:
        """(n,) displacements of the surface nodes.

        Args:
            y: (N*d,) weighted tractions.
            coordinates: (m_b + k,) coordinates of this body, rigid modes last.
            amplitudes: (l,) load amplitudes.
        """
        body = self.body
        count = body.coupling.shape[1]
        force = self._own.T @ y + body.surface_loads @ amplitudes
        force -= body.coupling @ coordinates[:count]
        half = self._forward(force)
        elastic = solve_triangular(self._factor, half, lower=True, trans="T", check_finite=False)
        return elastic + body.prescribed @ coordinates[:count] + body.modes @ coordinates[count:]


def build_interface(
    bodies: list[CondensedBody], pairs: list[Pair], coordinates: list[Coordinate]
) -> tuple[Interface, dict[str, ReducedBody]]:
    """Assemble the interface problem.

    Args:
        bodies: condensed bodies.
        pairs: contact pairs.
        coordinates: one for each constraint of each body, in the order of `bodies`.

    Returns:
        The interface problem, whose coordinates include the rigid modes, and the reduced bodies.
    """
    d = pairs[0].coupling.frames.shape[1]
    roots = np.sqrt(np.concatenate([pair.coupling.weights for pair in pairs]))
    scale = sparse.diags(np.repeat(1 / roots, d))
    reduced = {b.name: ReducedBody(b, scale @ _stacked_operator(b.name, pairs)) for b in bodies}
    everything = _with_rigid_modes(bodies, coordinates)
    size, count = len(roots) * d, len(everything)
    load_count = bodies[0].surface_loads.shape[1]
    system = {
        "compliance": np.zeros((size, size)),
        "loads": np.zeros((size, load_count)),
        "motion": np.zeros((size, count)),
        "stiffness": np.zeros((count, count)),
        "coordinate_loads": np.zeros((count, load_count)),
    }
    for name, body in reduced.items():
        body.add_to(system, coordinate_range(everything, name))
    gap = np.zeros((len(roots), d))
    gap[:, 0] = np.concatenate([pair.coupling.gap for pair in pairs]) / roots
    interface = Interface(
        components=d,
        gap=gap.ravel(),
        roots=roots,
        coordinates=tuple(everything),
        contacts=_node_ranges(pairs),
        compliance=DenseCompliance(system.pop("compliance")),
        **system,
    )
    require_restraint(interface)
    return interface, reduced


def _stacked_operator(body: str, pairs: list[Pair]) -> sparse.csr_matrix:
    """(N*d, n) operator of all contacts on the surface unknowns of one body.

    The surface unknowns of a body are those of its contact surfaces one after the other, in the
    order of the contacts.
    """
    parts = [
        pair.coupling.body1 if pair.body1 == body else pair.coupling.body2
        for pair in pairs
        if body in (pair.body1, pair.body2)
    ]
    columns = sparse.block_diag(parts).tocsr()
    rows, start = [], 0
    for pair in pairs:
        height = pair.coupling.body1.shape[0]
        if body in (pair.body1, pair.body2):
            rows.append(columns[start : start + height])
            start += height
        else:
            rows.append(sparse.csr_matrix((height, columns.shape[1])))
    return sparse.vstack(rows).tocsr()


def _with_rigid_modes(
    bodies: list[CondensedBody], coordinates: list[Coordinate]
) -> list[Coordinate]:
    everything = []
    for body in bodies:
        everything += [c for c in coordinates if c.body == body.name]
        everything += [
            Coordinate(f"free motion {number + 1}", body.name, "free")
            for number in range(body.modes.shape[1])
        ]
    return everything


def _node_ranges(pairs: list[Pair]) -> dict[str, slice]:
    ends = np.cumsum([len(pair.coupling.weights) for pair in pairs])
    starts = np.concatenate([[0], ends[:-1]])
    return {
        pair.name: slice(int(start), int(end))
        for pair, start, end in zip(pairs, starts, ends, strict=True)
    }
