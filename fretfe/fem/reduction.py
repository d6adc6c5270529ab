# SPDX-License-Identifier: LGPL-3.0-or-later
"""Condensed bodies and couplings reduced to the interface problem of `fretfe.contact.interface`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dpstrf

from fretfe._typing import Array, Indices
from fretfe.bodies.definition import Pair
from fretfe.bodies.loads.spread import SpreadLoad
from fretfe.contact.interface import (
    Coordinate,
    DenseCompliance,
    Interface,
    add_layers,
    coordinate_range,
)
from fretfe.fem.condensation import CondensedBody
from fretfe.fem.symmetric import mirror_lower

# Pivots of the compliance below this fraction of its largest entry are round-off.
DEPENDENT = 1e-11


class ReducedBody:
    """A condensed body and its place in the interface problem.

    Args:
        body: condensed body.
        rows: (n,) its tractions among those of all contacts.
    """

    def __init__(self, body: CondensedBody, rows: Indices) -> None:
        self.body = body
        self.rows = rows

    def add_to(self, system: dict[str, Array], columns: slice) -> None:
        """Add this body to L, G, K, H and the lower half of A; `columns` are its coordinates."""
        body, rows = self.body, self.rows
        body.compliance.add_to(system["compliance"], rows)
        body.compliance.shorten()  # only slopes of its surfaces are found with it from here on
        system["loads"][rows] += body.loads
        system["motion"][rows, columns] = body.motion
        system["stiffness"][columns, columns] = body.stiffness
        system["coordinate_loads"][columns] = body.coordinate_loads

    def contact_forces(self, y: Array) -> Array:
        """(T, d) sum of the contact forces on this body for weighted tractions (T, N*d)."""
        return np.asarray(y[:, self.rows] @ self.body.contact_resultants.T)

    def moments(self, y: Array, coordinates: Array, amplitudes: Array) -> Array:
        """(T, r) sum of all moments on this body, for arguments of `relative_displacement`.

        They are those of reactions, loads and contact, about the middle of its contact surfaces.
        """
        moments = self.body.moments
        tractions, count = len(self.rows), amplitudes.shape[1]
        driven = coordinates[:, : moments.shape[1] - tractions - count]
        return np.asarray(np.hstack([y[:, self.rows], driven, amplitudes]) @ moments.T)

    def relative_displacement(
        self, y: Array, coordinates: Array, amplitudes: Array, components: slice
    ) -> Array:
        """(T, k) part of this body in w, with the compliance in single precision.

        Args:
            y: (T, N*d) weighted tractions.
            coordinates: (T, m + k) coordinates of this body.
            amplitudes: (T, l) load amplitudes.
            components: of w that are wanted, those of a contact of this body.
        """
        first = int(np.searchsorted(self.rows, components.start))
        own = slice(first, first + components.stop - components.start)
        return np.asarray(
            self.body.compliance.multiply(y[:, self.rows].T, own).T
            + coordinates @ self.body.motion[own].T
            + amplitudes @ self.body.loads[own].T
        )


def build_interface(
    bodies: list[CondensedBody],
    pairs: list[Pair],
    coordinates: list[Coordinate],
    loads: Sequence[SpreadLoad] = (),
) -> tuple[Interface, dict[str, ReducedBody]]:
    """Assemble the interface problem.

    Args:
        bodies: condensed bodies.
        pairs: contact pairs.
        coordinates: one for each constraint of each body, in the order of `bodies`.
        loads: spread loads, of which interferences close gaps whatever the bodies do.

    Returns:
        The interface problem, whose coordinates include the rigid modes, and the reduced bodies.
    """
    d = pairs[0].coupling.surface.frames.shape[1]
    roots = np.sqrt(np.concatenate([pair.coupling.surface.weights for pair in pairs]))
    reduced = {b.name: ReducedBody(b, _rows(b.name, pairs)) for b in bodies}
    everything = _with_rigid_modes(bodies, coordinates)
    size, count = len(roots) * d, len(everything)
    load_count = bodies[0].loads.shape[1]
    system = {
        "compliance": np.zeros((size, size)),
        "loads": np.zeros((size, load_count)),
        "motion": np.zeros((size, count)),
        "stiffness": np.zeros((count, count)),
        "coordinate_loads": np.zeros((count, load_count)),
    }
    for name, body in reduced.items():
        body.add_to(system, coordinate_range(everything, name))
    mirror_lower(system["compliance"])
    nodes = _node_ranges(pairs)
    for number, load in enumerate(loads):
        if load.closes:
            rows = nodes[load.closes]
            system["loads"][rows.start * d : rows.stop * d : d, number] -= roots[rows]
    if sum(body.held for body in bodies) > 1:
        decouple_dependent(system)
    add_layers(system["compliance"], nodes, {pair.name: pair.layer for pair in pairs}, d)
    gap = np.zeros((len(roots), d))
    gap[:, 0] = np.concatenate([pair.coupling.gap for pair in pairs]) / roots
    interface = Interface(
        components=d,
        gap=gap.ravel(),
        roots=roots,
        coordinates=tuple(everything),
        contacts=nodes,
        compliance=DenseCompliance(system.pop("compliance")),
        laws={pair.name: pair.law for pair in pairs if pair.law is not None},
        slid={p.name: p.coupling.slid for p in pairs if p.coupling.slid is not None},
        **system,
    )
    return interface, reduced


def decouple_dependent(system: dict[str, Array]) -> None:
    """Take tractions that move nothing by themselves out of an interface problem, in place.

    Where both bodies are held in the same direction at the end of a contact surface, as on a plane
    of symmetry, there are more tractions along it than displacements that they could move. Those
    beyond the rank of the compliance vanish: nothing but a compliance of their own resists them.

    Args:
        system: `compliance`, and `motion` and `loads` with its rows.
    """
    compliance = system["compliance"]
    level = float(compliance.diagonal().mean())
    tolerance = DEPENDENT * float(compliance.diagonal().max())
    _, order, rank, _ = dpstrf(compliance, tol=tolerance, lower=1)
    dependent = order[rank:] - 1
    compliance[dependent] = 0.0
    compliance[:, dependent] = 0.0
    compliance[dependent, dependent] = level
    system["motion"][dependent] = 0.0
    system["loads"][dependent] = 0.0


def weighted_operator(body: str, pairs: Sequence[Pair]) -> sparse.csr_matrix:
    """(n, p*d) weighted displacements of the contact nodes of a body by its surface displacements.

    The surface displacements of a body are those of its contact surfaces one after the other, in
    the order of the contacts.
    """
    parts = []
    for pair in pairs:
        if body in (pair.body1, pair.body2):
            coupling = pair.coupling
            operator = coupling.body1 if pair.body1 == body else coupling.body2
            roots = np.repeat(np.sqrt(coupling.surface.weights), coupling.surface.frames.shape[1])
            parts.append(sparse.diags(1 / roots) @ operator)
    return sparse.block_diag(parts).tocsr()


def _rows(body: str, pairs: list[Pair]) -> Indices:
    """(n,) numbers of the tractions on a body among those of all contacts."""
    everything = np.split(
        np.arange(sum(pair.coupling.body1.shape[0] for pair in pairs)),
        np.cumsum([pair.coupling.body1.shape[0] for pair in pairs])[:-1],
    )
    own = [
        rows
        for rows, pair in zip(everything, pairs, strict=True)
        if body in (pair.body1, pair.body2)
    ]
    return np.concatenate(own)


def _with_rigid_modes(
    bodies: list[CondensedBody], coordinates: list[Coordinate]
) -> list[Coordinate]:
    everything = []
    for body in bodies:
        own = [c for c in coordinates if c.body == body.name]
        everything += own
        everything += [
            Coordinate(f"free motion {number + 1}", body.name, "free")
            for number in range(body.motion.shape[1] - len(own))
        ]
    return everything


def _node_ranges(pairs: list[Pair]) -> dict[str, slice]:
    ends = np.cumsum([len(pair.coupling.surface.weights) for pair in pairs])
    starts = np.concatenate([[0], ends[:-1]])
    return {
        pair.name: slice(int(start), int(end))
        for pair, start, end in zip(pairs, starts, ends, strict=True)
    }
