# SPDX-License-Identifier: LGPL-3.0-or-later
"""Next to a solved state: increments of full stick, two load levels between which edges move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.interface import Interface, unresisted_motions
from fretfe.contact.linear_operator import Conditions, FactoredOperator
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
    names = [interface.coordinates[j].channel for j in driven] + load_channels
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

    def increments(self, closed: Bools, gap: Array) -> Increments:
        """Increments for a unit of each driver in a contact area.

        Args:
            closed: (N,) nodes in contact.
            gap: (N,) weighted gaps, which tell what may come into contact next.
        """
        interface = self._operator.interface
        count, tangents = len(closed), interface.components - 1
        conditions = Conditions(
            status=np.where(closed, STICK, OPEN).astype(np.int8),
            pull=np.zeros((count, tangents)),
            turning=np.zeros(count),
            penalty=np.zeros(count),
            known=self._fixed,
            amplitudes=np.zeros((self._fixed.sum(), self._forces.shape[1])),
            floating=self._floating,
        )
        area = self._operator.area(closed, gap)
        # Displacements where the bodies are apart make no difference, but for round-off.
        free = np.where(closed[:, None, None], self._free, 0.0)
        response = area.stuck(free, self._forces).release(conditions)
        traction = np.where(closed[:, None, None], response.traction, 0.0)
        return Increments(traction, response.coordinates)


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
