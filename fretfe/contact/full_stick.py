# SPDX-License-Identifier: LGPL-3.0-or-later
"""Next to a solved state: increments of full stick, two load levels between which edges move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.interface import Interface, unresisted_motions
from fretfe.contact.linear_operator import Conditions, FactoredOperator, StuckSolution
from fretfe.contact.march import March
from fretfe.contact.newton import NotConverged
from fretfe.contact.state import OPEN, STICK, ContactState, StepLoads

# The loads are raised and lowered by this fraction: edges move by some elements (2.5 % of a Hertz
# contact, 5 % of a wedge either way), and stay well inside the circle of an interaction integral.
FRACTION = 0.05


@dataclass(frozen=True)
class Drivers:
    """Loads that have a full-stick increment.

    Attributes:
        names: channels.
        coordinates: (J,) number of the coordinate whose force drives, -1 for a distributed load.
        loads: (J,) number of the distributed load, -1 for a coordinate.
    """

    names: tuple[str, ...]
    coordinates: Indices
    loads: Indices

    def values(self, forces: Array, amplitudes: Array) -> Array:
        """(T, J) values of the drivers.

        Args:
            forces: (T, m) on the coordinates.
            amplitudes: (T, l) of the distributed loads.
        """
        none = np.zeros((len(forces), len(self.loads)))
        from_coordinates = forces[:, self.coordinates] if forces.shape[1] else none
        from_loads = amplitudes[:, self.loads] if amplitudes.shape[1] else none
        return np.where(self.coordinates >= 0, from_coordinates, from_loads)


def find_drivers(interface: Interface, load_channels: list[str]) -> Drivers:
    """Find every driven coordinate and every distributed load."""
    driven = [j for j, c in enumerate(interface.coordinates) if c.channel]
    found = [interface.coordinates[j] for j in driven]
    # A cut has many of them for one load; their labels differ.
    names = [c.channel if c.course is None else c.label for c in found] + load_channels
    count = len(load_channels)
    return Drivers(
        names=tuple(names),
        coordinates=np.array(driven + [-1] * count, dtype=np.int64),
        loads=np.array([-1] * len(driven) + list(range(count)), dtype=np.int64),
    )


@dataclass(frozen=True)
class Increments:
    """Full-stick increments for a unit of each of J drivers.

    Attributes:
        traction: (N, d, J) weighted tractions y.
        coordinates: (m, J).
    """

    traction: Array
    coordinates: Array

    @classmethod
    def mean(cls, increments: Sequence[Increments]) -> Increments:
        """Mean of some increments for the same drivers."""
        return cls(
            np.mean([each.traction for each in increments], axis=0),
            np.mean([each.coordinates for each in increments], axis=0),
        )


@dataclass(frozen=True)
class Change:
    """Forces (m,), coordinates (m,) and load amplitudes (l,) of a state less those of another."""

    forces: Array
    coordinates: Array
    amplitudes: Array


class FullStickSolver:
    """Solver of full-stick increments for any contact area.

    Args:
        operator: solves linear systems of the interface problem.
        drivers: loads that have an increment.
    """

    def __init__(self, operator: FactoredOperator, drivers: Drivers) -> None:
        interface = operator.interface
        self._operator = operator
        # Boundaries driven by displacement are driven by their force here.
        self._fixed = np.array([c.control == "fixed" for c in interface.coordinates], dtype=bool)
        # Bodies that only these displacements hold float now; the loads on them are in equilibrium.
        self._floating = unresisted_motions(interface, ~self._fixed).shape[1] > 0
        self._free, self._forces = _unit_loads(interface, drivers)
        self._forces[self._fixed] = 0.0
        self._drivers, self._held = drivers, _held_cuts(interface, self._fixed)

    def increments(self, closed: Bools, gap: Array) -> Increments:
        """Increments for a unit of each driver in a contact area.

        Args:
            closed: (N,) nodes in contact.
            gap: (N,) weighted gaps, which tell what may come into contact next.
        """
        amplitudes = np.zeros((self._fixed.sum(), self._forces.shape[1]))
        conditions = self._conditions(closed, self._fixed, amplitudes, self._floating)
        area = self._operator.area(closed, gap)
        return _released(area.stuck(_where(closed, self._free), self._forces), conditions, closed)

    @property
    def has_cuts(self) -> bool:
        """True if another run moves a boundary."""
        return self._held is not None

    def both_ways(self, closed: Bools, gap: Array, change: Change) -> tuple[Array, Array]:
        """(N, d) weighted tractions by a change of the loads in full stick, cuts moved in two ways.

        First by the forces of the shapes of the cuts, as `increments` has it: too little moves at
        the cut; then by the displacements of the cuts and their resultants: too much of the other
        run's slip is in these. The rest of the whole bodies is neither without stiffness nor rigid,
        so that the tractions with it lie between.

        Args:
            closed: (N,) nodes in contact.
            gap: (N,) weighted gaps.
            change: of forces, coordinates and load amplitudes between two states.
        """
        assert self._held is not None
        interface = self._operator.interface
        own = self._drivers.values(change.forces[None], change.amplitudes[None])[0]
        first = self.increments(closed, gap).traction @ own
        forces = change.forces + interface.coordinate_loads @ change.amplitudes
        free = (interface.loads @ change.amplitudes).reshape(*first.shape, 1)
        amplitudes = change.coordinates[self._held, None]
        conditions = self._conditions(closed, self._held, amplitudes, floating=False)
        area = self._operator.area(closed, gap)
        stuck = area.stuck(_where(closed, free), np.where(self._held, 0.0, forces)[:, None])
        return first, _released(stuck, conditions, closed).traction[:, :, 0]

    def _conditions(
        self, closed: Bools, known: Bools, amplitudes: Array, floating: bool
    ) -> Conditions:
        """Full stick where the bodies touch, and known amplitudes (k, J) of some coordinates."""
        count, tangents = len(closed), self._operator.interface.components - 1
        return Conditions(
            status=np.where(closed, STICK, OPEN).astype(np.int8),
            pull=np.zeros((count, tangents)),
            turning=np.zeros(count),
            penalty=np.zeros(count),
            known=known,
            amplitudes=amplitudes,
            floating=floating,
        )


def _where(closed: Bools, free: Array) -> Array:
    """Displacements (N, d, J): where the bodies are apart they only make round-off."""
    return np.where(closed[:, None, None], free, 0.0)


def _released(stuck: StuckSolution, conditions: Conditions, closed: Bools) -> Increments:
    response = stuck.release(conditions)
    return Increments(_where(closed, response.traction), response.coordinates)


def _held_cuts(interface: Interface, fixed: Bools) -> Bools | None:
    """(m,) coordinates that are known if cuts keep their displacements; None without cuts.

    Cuts keep their shapes and may move as rigid bodies, but for those of one body where nothing
    else holds any.
    """
    found = interface.coordinates
    moved = np.array([c.course is not None for c in found], dtype=bool)
    channels = {c.channel for c in found if c.course is not None}
    rigid = [c.resultant is not None and c.resultant.load in channels for c in found]
    turned = fixed & np.array(rigid, dtype=bool)
    if not moved.any():
        return None
    if unresisted_motions(interface, turned).shape[1]:
        turned &= [c.body != found[int(np.argmax(turned))].body for c in found]
    return np.asarray((fixed | moved) & ~turned)


def _unit_loads(interface: Interface, drivers: Drivers) -> tuple[Array, Array]:
    """(N, d, J) displacements without tractions and (m, J) forces, for a unit of each driver."""
    free = np.zeros((interface.size * interface.components, len(drivers.names)))
    forces = np.zeros((len(interface.coordinates), len(drivers.names)))
    for j, (coordinate, load) in enumerate(zip(drivers.coordinates, drivers.loads, strict=True)):
        if coordinate >= 0:
            forces[coordinate, j] = 1.0
        else:
            free[:, j] = interface.loads[:, load]
            forces[:, j] = interface.coordinate_loads[:, load]
    return free.reshape(interface.size, interface.components, -1), forces


def neighbour_states(
    march: March, state: ContactState, loads: StepLoads
) -> tuple[ContactState, ContactState] | None:
    """States after all loads are lowered, and raised, by a fraction; None without a solution."""
    try:
        low, high = (
            march.advance(state, loads, _scaled(loads, 1 + change)).state
            for change in (-FRACTION, FRACTION)
        )
    except NotConverged:
        return None
    return low, high


def _scaled(loads: StepLoads, factor: float) -> StepLoads:
    return replace(loads, amplitudes=factor * loads.amplitudes, values=factor * loads.values)
