# SPDX-License-Identifier: LGPL-3.0-or-later
"""The interface operator by dense inverses, one for each contact area.

With a set of nodes stuck, their tractions y and all coordinates c obey

    [ A   G ] [y]   [ w − w0 − L a ]
    [ Gᵀ −K ] [c] = [ −R − H a     ]

Prescribed coordinates get a spring in K, so that the inverse exists when they hold a body. A
component that is let go of moves by an unknown amount: an unknown right-hand side, as is the force
of a spring that is taken away. There are few of them, and they follow from as many conditions on
the rows and columns of the inverse that belong to them.
"""

from __future__ import annotations

import numpy as np
from scipy import linalg

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.interface import Interface, coordinate_scale
from fretfe.contact.operator import Conditions, Response
from fretfe.contact.state import OPEN, SLIP

# Open nodes that an inverse includes, as a fraction of those in contact.
MARGIN = 0.05
SMALLEST_MARGIN = 8
# Singular values below this fraction of the largest belong to motions that nothing resists.
UNRESISTED = 1e-10


class InverseOperator:
    """Interface operator that inverts the stuck system of each contact area.

    Args:
        interface: the interface problem.
        memory: bytes for the inverses of other contact areas, which the next history that is solved
            meets again.
    """

    def __init__(self, interface: Interface, memory: int = 0) -> None:
        self.interface = interface
        self._memory = memory
        self._areas: list[InverseArea] = []  # the one used last stands last

    def area(self, closed: Bools, gap: Array) -> InverseArea:
        """Inverse that includes a contact area; see `InterfaceOperator`."""
        nodes = np.flatnonzero(closed)
        margin = int(SMALLEST_MARGIN + MARGIN * len(nodes))
        for area in reversed(self._areas):
            spare = len(area.nodes) - len(nodes)
            if 0 <= spare <= 2 * margin and np.isin(nodes, area.nodes).all():
                self._areas.remove(area)
                self._areas.append(area)
                return area
        others = np.flatnonzero(~closed)
        nearest = others[np.argsort(gap[others], kind="stable")[:margin]]
        area = InverseArea(self.interface, np.sort(np.concatenate([nodes, nearest])))
        self._areas.append(area)
        while sum(older.bytes for older in self._areas[:-1]) > self._memory:
            self._areas.pop(0)
        return area

    def regularised(self, penalty: float) -> RegularisedInverse:
        """Bodies with an elastic layer between them; see `InterfaceOperator`."""
        return RegularisedInverse(self.interface, penalty)


class InverseArea:
    """Inverse of the interface problem with a set of nodes stuck.

    Args:
        interface: the interface problem.
        nodes: nodes that take part; all others have no traction.

    Attributes:
        interface: the interface problem.
        nodes: (n,) nodes that take part.
        rows: (n*d,) their components.
        springs: (m,) stiffness of the springs on prescribed coordinates.
        inverse: (n*d + m, n*d + m), symmetric.
        others: components of the nodes that take no part.
        effect: (N*d - n*d, n*d + m) their displacements by the unknowns.
    """

    def __init__(self, interface: Interface, nodes: Indices) -> None:
        d, level = interface.components, interface.compliance.level
        self.interface = interface
        self.nodes = nodes
        self.rows = (nodes[:, None] * d + np.arange(d)).ravel()
        scale = coordinate_scale(interface) * level
        self.springs = np.where(interface.prescribed, level / scale**2, 0.0)
        split = len(self.rows)
        size = split + len(scale)
        matrix = np.empty((size, size))
        matrix[:split, :split] = interface.compliance.block(self.rows, self.rows)
        matrix[:split, split:] = interface.motion[self.rows]
        matrix[split:, :split] = interface.motion[self.rows].T
        matrix[split:, split:] = -interface.stiffness - np.diag(self.springs)
        # Equilibrated: every diagonal entry of A about 1, every column of G of comparable size.
        units = np.concatenate([np.full(split, level**-0.5), scale / level**0.5])
        matrix *= units
        matrix *= units[:, None]
        self.inverse = np.linalg.inv(matrix)
        self.inverse *= units
        self.inverse *= units[:, None]
        self.others = np.delete(np.arange(interface.size * d), self.rows)
        self.effect = np.hstack(
            [interface.compliance.block(self.others, self.rows), interface.motion[self.others]]
        )

    @property
    def bytes(self) -> int:
        """Memory that the inverse takes."""
        return int(self.inverse.nbytes + self.effect.nbytes)

    def stuck(self, free: Array, forces: Array) -> StuckSolution:
        """Full stick of the area under loads; see `ContactArea`."""
        flat = free.reshape(-1, free.shape[-1])
        return StuckSolution(self, flat, self.inverse @ np.concatenate([-flat[self.rows], -forces]))


class StuckSolution:
    """Solution with every node of an area stuck, from which nodes and coordinates are released.

    Args:
        area: the inverse.
        free: (N*d, J) displacements without tractions and coordinates.
        unknowns: (n*d + m, J) tractions of the area's nodes, then the coordinates.
    """

    def __init__(self, area: InverseArea, free: Array, unknowns: Array) -> None:
        self._area = area
        self._free = free
        self._unknowns = unknowns

    @property
    def coordinates(self) -> Array:
        """(m, J) coordinates, the prescribed ones held by their springs."""
        return self._unknowns[len(self._area.rows) :]

    def release(self, conditions: Conditions) -> Response:
        """Let go of what is open, slipping, known or without its spring; see `StuckContact`."""
        area, stuck = self._area, self._unknowns
        released = _Released(area, conditions)
        response = area.inverse[released.all].T  # the inverse is symmetric; rows are contiguous
        matrix, target = response[released.all], -stuck[released.all]
        released.let_slip(conditions, matrix, target, response, stuck)
        target[released.known] += conditions.amplitudes
        # A free coordinate without its spring: the right-hand side is minus the spring's force.
        springs = area.springs[released.unsprung, None]
        matrix[released.freed] *= springs
        target[released.freed] *= springs
        diagonal = np.arange(len(matrix))[released.freed]
        matrix[diagonal, diagonal] += 1.0
        residual = 0.0
        if conditions.floating:
            changes, residual = _least_motion(matrix, target)
        else:
            changes = np.linalg.solve(matrix, target)
        return self._response(stuck + response @ changes, released, changes, residual)

    def _response(
        self, unknowns: Array, released: _Released, changes: Array, residual: float
    ) -> Response:
        area, split = self._area, len(self._area.rows)
        traction, relative = np.zeros_like(self._free), np.zeros_like(self._free)
        traction[area.rows] = unknowns[:split]
        relative[area.rows[released.all[: released.moved]]] = changes[: released.moved]
        relative[area.others] = self._free[area.others] + area.effect @ unknowns
        shape = (area.interface.size, area.interface.components, -1)
        return Response(
            traction.reshape(shape), relative.reshape(shape), unknowns[split:], residual
        )


class _Released:
    """Unknowns of an area whose right-hand sides conditions leave open, and where they stand.

    Attributes:
        all: numbers of the unknowns: open nodes, shear of slipping nodes, coordinates of known
            amplitude, prescribed coordinates that a force drives now.
        moved: how many of them are displacements of nodes.
        sliding: the shear, known: known coordinates, freed: freed coordinates; ranges in `all`.
        unsprung: numbers of the freed coordinates among all coordinates.
    """

    def __init__(self, area: InverseArea, conditions: Conditions) -> None:
        d, split = area.interface.components, len(area.rows)
        status = conditions.status[area.nodes]
        start = np.arange(len(area.nodes)) * d
        opened = (start[status == OPEN][:, None] + np.arange(d)).ravel()
        self._slipping = area.nodes[status == SLIP]
        self._normal = start[status == SLIP]
        self._shear = (self._normal[:, None] + np.arange(1, d)).ravel()
        known = np.flatnonzero(conditions.known)
        self.unsprung = np.flatnonzero(area.interface.prescribed & ~conditions.known)
        self.all = np.concatenate([opened, self._shear, split + known, split + self.unsprung])
        self.moved = len(opened) + len(self._shear)
        self.sliding = slice(len(opened), self.moved)
        self.known = slice(self.moved, self.moved + len(known))
        self.freed = slice(self.known.stop, len(self.all))

    def let_slip(
        self, conditions: Conditions, matrix: Array, target: Array, response: Array, stuck: Array
    ) -> None:
        """Replace "no shear" in the rows of slipping nodes by the conditions of slip.

        Args:
            conditions: conditions.
            matrix: (k, k) changed in place: released unknowns by unit right-hand sides.
            target: (k, J) changed in place.
            response: (n*d + m, k) all unknowns by unit right-hand sides.
            stuck: (n*d + m, J) all unknowns in full stick.
        """
        rows, nodes = self.sliding, self._slipping
        per_node = conditions.pull.shape[1]
        bound = np.repeat(self._normal, per_node)
        pull = conditions.pull[nodes].ravel()[:, None]
        matrix[rows] -= pull * response[bound]
        target[rows] += pull * stuck[bound]
        if per_node > 1:
            turning = conditions.turning[nodes]
            trial = response[self._shear]  # of q − r Δ; Δ is the unknown right-hand side itself
            trial[np.arange(len(trial)), np.arange(rows.start, rows.stop)] -= np.repeat(
                conditions.penalty[nodes], per_node
            )
            matrix[rows] -= _by_node(turning, trial)
            target[rows] += _by_node(turning, stuck[self._shear])


def _least_motion(matrix: Array, target: Array) -> tuple[Array, float]:
    """Smallest solution of a system that leaves some motions free, and its relative residual.

    Rows and columns are of different units: they are brought to one size first.
    """
    rows = np.linalg.norm(matrix, axis=1)[:, None]
    matrix, target = matrix / rows, target / rows
    columns = np.linalg.norm(matrix, axis=0)[:, None]
    matrix = matrix / columns.T
    # By a pivoted QR decomposition: several times faster than by singular values. The second time
    # for what the first one leaves, a small difference of large tractions.
    changes = _least_squares(matrix, target)
    changes += _least_squares(matrix, target - matrix @ changes)
    size = max(float(np.linalg.norm(target)), np.finfo(np.float64).tiny)
    return changes / columns, float(np.linalg.norm(matrix @ changes - target)) / size


def _least_squares(matrix: Array, target: Array) -> Array:
    changes: Array = linalg.lstsq(matrix, target, cond=UNRESISTED, lapack_driver="gelsy")[0]
    return changes


def _by_node(blocks: Array, values: Array) -> Array:
    """Products of (n, k, k) blocks with values (n * k, J)."""
    parts = values.reshape(*blocks.shape[:2], values.shape[1])
    return np.einsum("nij,nj...->ni...", blocks, parts).reshape(values.shape)


class RegularisedInverse:
    """Inverse of the interface problem with an elastic layer between the bodies.

    Args:
        interface: the interface problem; its prescribed coordinates are left out.
        penalty: compliance of the layer.
    """

    def __init__(self, interface: Interface, penalty: float) -> None:
        released = np.flatnonzero(~interface.prescribed)
        n = interface.size * interface.components
        everything = np.arange(n)
        self._scale = coordinate_scale(interface)[released] * interface.compliance.level
        matrix = np.empty((n + len(released), n + len(released)))
        matrix[:n, :n] = interface.compliance.block(everything, everything)
        matrix[everything, everything] += penalty
        matrix[:n, n:] = interface.motion[:, released] * self._scale
        matrix[n:, :n] = matrix[:n, n:].T
        matrix[n:, n:] = -interface.stiffness[np.ix_(released, released)]
        matrix[n:, n:] *= np.outer(self._scale, self._scale)
        self._inverse = np.linalg.inv(matrix)[:n]

    def tractions(self, displacement: Array, forces: Array) -> Array:
        """(N*d,) tractions that give a displacement; see `Regularised`."""
        return self._inverse @ np.concatenate([displacement, forces * self._scale])
