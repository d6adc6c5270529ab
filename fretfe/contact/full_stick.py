# SPDX-License-Identifier: LGPL-3.0-or-later
"""Companion increments: the contact of a solved state stuck everywhere, under a unit of each load.

The edge factor K_T is the strength of the singularity that the shear has when all slip is
prevented. It is linear in the loads, so its history follows by superposition from one solution for
each load. A displacement-driven boundary counts with its force: slip makes the contact more
compliant, so the force on it, not its displacement, is what the edge feels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.contact.interface import Interface, free_motions
from fretfe.contact.newton import Newton
from fretfe.contact.state import ContactState


@dataclass(frozen=True)
class Drivers:
    """Loads that companion increments are made for.

    Attributes:
        names: channels.
        coordinates: (J,) number of the coordinate whose force drives, -1 for a distributed load.
        loads: (J,) number of the distributed load, -1 for a coordinate.
    """

    names: tuple[str, ...]
    coordinates: Indices
    loads: Indices

    def values(self, forces: Array, amplitudes: Array) -> Array:
        """(J,) values of the drivers from the forces on coordinates and the load amplitudes."""
        from_coordinates = forces[self.coordinates] if len(forces) else np.zeros(len(self.loads))
        from_loads = amplitudes[self.loads] if len(amplitudes) else np.zeros(len(self.loads))
        return np.where(self.coordinates >= 0, from_coordinates, from_loads)


def find_drivers(interface: Interface, load_channels: list[str]) -> Drivers:
    """Every driven coordinate and every distributed load."""
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
    """Stuck increments for a unit of each of J drivers.

    Attributes:
        traction: (N, d, J) weighted tractions y.
        coordinates: (m, J).
    """

    traction: Array
    coordinates: Array


class BondedSolver:
    """Unit increments for any contact area; shares the stuck operator with the march."""

    def __init__(self, interface: Interface, newton: Newton, drivers: Drivers) -> None:
        self._interface = interface
        self._newton = newton
        self._drivers = drivers
        held = np.array([c.control == "fixed" for c in interface.coordinates], dtype=bool)
        self._held = np.flatnonzero(held)
        # Driven by displacement: held in the step, driven by its force here.
        self._freed = np.flatnonzero(interface.prescribed & ~held)
        # Bodies that only these displacements hold float now; the loads on them are in equilibrium.
        self._floats = free_motions(interface, ~held).shape[1] > 0

    def increments(self, state: ContactState) -> Increments:
        """Increments for a unit of each driver, the contact area of a state stuck."""
        interface, d = self._interface, self._interface.components
        operator = self._newton.operator_for(state.closed, state.relative[:, 0])
        rhs = self._right_hand_sides(operator.rows)
        split = len(operator.rows)
        start = np.flatnonzero(~state.closed[operator.nodes]) * d
        opened = (start[:, None] + np.arange(d)).ravel()
        zero = np.concatenate([opened, split + self._held])
        freed = split + self._freed
        released = np.concatenate([zero, freed])
        known = rhs.copy()
        known[released] = 0.0
        held = operator.inverse @ known
        response = operator.inverse[released].T
        matrix, target = response[released], -held[released]
        # The operator holds freed coordinates by a spring: its force is taken away again.
        rows = slice(len(zero), len(released))
        springs = operator.springs[self._freed]
        matrix[rows] = springs[:, None] * matrix[rows] + np.eye(len(released))[rows]
        target[rows] = springs[:, None] * target[rows] + rhs[freed]
        solve = _least_squares if self._floats else np.linalg.solve
        solution = held + response @ solve(matrix, target)
        traction = np.zeros((interface.size * d, rhs.shape[1]))
        traction[operator.rows] = solution[:split]
        nodal = traction.reshape(interface.size, d, -1)
        nodal[~state.closed] = 0.0
        return Increments(nodal, solution[split:])

    def _right_hand_sides(self, rows: Indices) -> Array:
        """(n + m, J) right-hand sides of the stuck operator for a unit of each driver."""
        interface, drivers = self._interface, self._drivers
        split = len(rows)
        rhs = np.zeros((split + len(interface.coordinates), len(drivers.names)))
        for j, (coordinate, load) in enumerate(
            zip(drivers.coordinates, drivers.loads, strict=True)
        ):
            if coordinate >= 0:
                rhs[split + coordinate, j] = -1.0
            else:
                rhs[:split, j] = -interface.loads[rows, load]
                rhs[split:, j] = -interface.coordinate_loads[:, load]
        return rhs


def _least_squares(matrix: Array, target: Array) -> Array:
    return np.linalg.lstsq(matrix, target, rcond=1e-10)[0]
