# SPDX-License-Identifier: LGPL-3.0-or-later
"""Record of accepted steps, and the `Solution` in physical units that it makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Protocol

import numpy as np

from fretfe._typing import Array
from fretfe.contact.certificate import Certificate
from fretfe.contact.full_stick import FullStickSolver, Increments, find_drivers
from fretfe.contact.interface import Interface
from fretfe.contact.march import March, StepResult
from fretfe.contact.state import ContactState, StepLoads, unloaded
from fretfe.loads import History
from fretfe.results.solution import ContactHistory, FullStickUnits, Solution

# Tractions and gaps below this fraction of what the motion of the bodies would cause are round-off.
ROUND_OFF = 1e-9


class Averaging(Protocol):
    """A linear map of nodal values, such as a sparse matrix."""

    def __matmul__(self, values: Array) -> Array:
        """Return the mapped values."""


class Nodes(Protocol):
    """The multiplier nodes of a contact; see `ContactHistory` for arrays of the same name."""

    @property
    def arc(self) -> Array:
        """(N,) arc length."""

    @property
    def points(self) -> Array:
        """(N, d) coordinates."""

    @property
    def frames(self) -> Array:
        """(N, d, d) normal and tangents."""

    @property
    def weights(self) -> Array:
        """(N,) length of each node."""

    @property
    def averaging(self) -> Averaging:
        """(N, N) from nodal values to means around the nodes."""


@dataclass(frozen=True)
class Place:
    """One contact: its name, its bodies and its nodes."""

    name: str
    body1: str
    body2: str
    nodes: Nodes


class Recorder:
    """All accepted states, and the full-stick increments of every contact area met.

    Args:
        march: advances the states; the full-stick increments share its interface operator.
        places: the contacts, in the order of the interface.
        steps: loads of all steps, the unloaded state first.
        channels: channel of each distributed load of the interface.
        degree: of the displacements.
    """

    def __init__(
        self,
        march: March,
        places: Sequence[Place],
        steps: list[StepLoads],
        channels: list[str],
        degree: int,
    ) -> None:
        interface = march.interface
        self._interface: Interface = interface
        self._places = places
        self._degree = degree
        self._steps = steps
        self.drivers = find_drivers(interface, channels)
        self._full_stick = FullStickSolver(march.operator, self.drivers)
        self._areas: dict[bytes, int] = {}
        self.increments: list[Increments] = []
        self.area_of_state = [-1]
        self.states: list[ContactState] = [unloaded(interface)]
        self.results: list[StepResult] = []

    def add(self, result: StepResult) -> None:
        """Record an accepted step."""
        self.states.append(result.state)
        self.results.append(result)
        closed = result.state.closed
        if not closed.any():
            self.area_of_state.append(-1)
            return
        key = closed.tobytes()
        if key not in self._areas:
            self._areas[key] = len(self.increments)
            self.increments.append(self._full_stick.increments(result.state))
        self.area_of_state.append(self._areas[key])

    def nodes_of(self, contact: str) -> slice:
        """Range of the nodes of a contact among all nodes."""
        return self._interface.contacts[contact]

    @property
    def steps(self) -> list[StepLoads]:
        """Loads of the states recorded so far."""
        return self._steps[: len(self.states)]

    def requests(self, states: list[int]) -> list[tuple[ContactState, StepLoads]]:
        """Some of the states with their loads, to recover displacement fields from."""
        return [(self.states[number], self._steps[number]) for number in states]

    def smallest_gap(self) -> float:
        """Smallest nodal gap over all states."""
        roots = self._interface.roots
        return float(min((state.relative[:, 0] / roots).min() for state in self.states))

    def gap_round_off(self) -> float:
        """Gap below which surfaces count as touching."""
        roots = self._interface.roots
        largest = max(np.abs(state.relative[:, 0] / roots).max() for state in self.states)
        return float(ROUND_OFF * largest)

    def contact_carries(self) -> bool:
        """Tell whether any contact deforms the bodies by more than round-off of their motion."""
        interface = self._interface
        pressure = max(state.traction[:, 0].max() for state in self.states)
        motion = max(np.abs(interface.motion * state.coordinates).max() for state in self.states)
        return bool(interface.compliance.level * pressure > ROUND_OFF * motion)

    def bodies_restrained_by_contact(self) -> list[str]:
        """Bodies with rigid modes restrained only by contact."""
        coordinates = self._interface.coordinates
        return sorted({c.body for c in coordinates if c.control == "free"})

    def solution(self, history: History, balance: dict[str, Array]) -> Solution:
        """Everything recorded so far, in physical units.

        Args:
            history: the loads.
            balance: (T,) measures of equilibrium by name, stored with the certificates.
        """
        count = len(self.states)
        forces = np.array([state.forces for state in self.states])
        amplitudes = np.array([step.amplitudes for step in self.steps])
        interface = self._interface
        complete = count == len(history.times)
        named = [j for j, c in enumerate(interface.coordinates) if c.control != "free"]
        return Solution(
            degree=self._degree,
            times=history.times[:count],
            channels=history.channels,
            values=history.values[:count],
            cycle=history.cycle if complete else None,
            coordinates=tuple(interface.coordinates[j].label for j in named),
            amplitudes=np.array([state.coordinates for state in self.states])[:, named],
            forces=forces[:, named],
            drivers=self.drivers.names,
            driver_values=np.array(
                [self.drivers.values(f, a) for f, a in zip(forces, amplitudes, strict=True)]
            ),
            contacts=tuple(self._contact(place) for place in self._places),
            iterations=np.array([0] + [r.iterations for r in self.results]),
            parts=np.array([0] + [r.parts for r in self.results]),
            fallbacks=np.array([0] + [r.fallbacks for r in self.results]),
            certificates=self._certificates() | balance,
            between=None if history.between is None else history.between[: count - 1],
        )

    def _contact(self, place: Place) -> ContactHistory:
        interface = self._interface
        nodes = interface.contacts[place.name]
        roots = interface.roots[nodes]
        relative = np.array([state.relative[nodes] for state in self.states])
        traction = np.array([s.traction[nodes] for s in self.states]) / roots[:, None]
        zero = np.zeros(len(roots))
        units = [each.traction[nodes] / roots[:, None, None] for each in self.increments]
        shape = (0, len(roots), interface.components, len(self.drivers.names))
        return ContactHistory(
            name=place.name,
            pair=place.name,
            body1=place.body1,
            body2=place.body2,
            arc=place.nodes.arc,
            points=place.nodes.points,
            frames=place.nodes.frames,
            weights=place.nodes.weights,
            friction=np.array([step.friction[nodes.start] for step in self.steps]),
            traction=traction,
            mean_traction=np.array([place.nodes.averaging @ t for t in traction]),
            gap=relative[..., 0] / roots,
            slip=-relative[..., 1:] / roots[:, None],
            status=np.array([state.status[nodes] for state in self.states]),
            dissipation=np.array([zero] + [r.dissipation[nodes] for r in self.results]),
            full_stick=FullStickUnits(
                fields=np.array(units) if units else np.zeros(shape),
                area=np.array(self.area_of_state),
            ),
        )

    def _certificates(self) -> dict[str, Array]:
        """Violations of the contact conditions by name, (T,) each."""
        names = [field.name for field in fields(Certificate)]
        columns = {
            name: np.array([0.0] + [getattr(r.certificate, name) for r in self.results])
            for name in names
        }
        columns["worst"] = np.array([0.0] + [r.certificate.worst for r in self.results])
        return columns
