# SPDX-License-Identifier: LGPL-3.0-or-later
"""Collects accepted steps and turns them into a `Solution` in physical units."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import numpy.typing as npt

from fretfe.fem.bonded import BondedSolver, find_drivers
from fretfe.fem.certificate import Certificate
from fretfe.fem.interface import Pair, coordinate_range
from fretfe.fem.march import March, StepResult
from fretfe.fem.model import Reduction
from fretfe.fem.plan import BodyPlan
from fretfe.fem.state import ContactState, StepLoads, unloaded
from fretfe.loads import History
from fretfe.solution import BondedUnits, ContactHistory, Solution

Array = npt.NDArray[np.float64]

# Tractions and gaps below this fraction of what the motion of the bodies would cause are round-off.
ROUND_OFF = 1e-9


class Recorder:
    """Keeps every accepted state, and the bonded increments of every contact area met.

    Args:
        reduction: the interface problem and what it was made from.
        degree: of the displacements.
        steps: loads of all steps, the unloaded state first.
        march: whose stuck operator the companion solutions share.
    """

    def __init__(
        self, reduction: Reduction, degree: int, steps: list[StepLoads], march: March
    ) -> None:
        interface = reduction.interface
        self._reduction = reduction
        self._degree = degree
        self._steps = steps
        self._drivers = find_drivers(interface, [load.channel for load in reduction.plan.loads])
        self._bonded = BondedSolver(interface, march.newton, self._drivers)
        self._areas: dict[bytes, int] = {}
        self._units: list[Array] = []
        self._area_of_state = [-1]
        self.states: list[ContactState] = [unloaded(interface)]
        self.results: list[StepResult] = []

    def add(self, result: StepResult) -> None:
        """Keep an accepted step."""
        self.states.append(result.state)
        self.results.append(result)
        closed = result.state.closed
        if not closed.any():
            self._area_of_state.append(-1)
            return
        key = closed.tobytes()
        if key not in self._areas:
            self._areas[key] = len(self._units)
            self._units.append(self._bonded.units(result.state))
        self._area_of_state.append(self._areas[key])

    def requests(self, states: list[int]) -> list[tuple[ContactState, StepLoads]]:
        """Some of the states with their loads, to recover displacement fields from."""
        return [(self.states[number], self._steps[number]) for number in states]

    def smallest_gap(self) -> float:
        """Smallest nodal gap over all states."""
        roots = self._reduction.interface.roots
        return float(min((state.relative[:, 0] / roots).min() for state in self.states))

    def gap_round_off(self) -> float:
        """Gap below which surfaces count as touching."""
        roots = self._reduction.interface.roots
        largest = max(np.abs(state.relative[:, 0] / roots).max() for state in self.states)
        return float(ROUND_OFF * largest)

    def contact_carries(self) -> bool:
        """Whether any contact deforms the bodies by more than round-off of their motion."""
        interface = self._reduction.interface
        level = np.trace(interface.compliance) / len(interface.compliance)
        pressure = max(state.traction[:, 0].max() for state in self.states)
        motion = max(np.abs(interface.motion * state.coordinates).max() for state in self.states)
        return bool(level * pressure > ROUND_OFF * motion)

    def bodies_with_free_motions(self) -> list[str]:
        """Bodies that only contact holds in some direction."""
        coordinates = self._reduction.interface.coordinates
        return sorted({c.body for c in coordinates if c.control == "free"})

    def solution(self, history: History) -> Solution:
        """Everything kept so far, in physical units."""
        count = len(self.states)
        forces = np.array([state.forces for state in self.states])
        amplitudes = np.array([step.amplitudes for step in self._steps[:count]])
        interface = self._reduction.interface
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
            drivers=self._drivers.names,
            driver_values=np.array(
                [self._drivers.values(f, a) for f, a in zip(forces, amplitudes, strict=True)]
            ),
            contacts=tuple(self._contact(pair) for pair in self._reduction.pairs),
            iterations=np.array([0] + [r.iterations for r in self.results]),
            parts=np.array([0] + [r.parts for r in self.results]),
            fallbacks=np.array([0] + [r.fallbacks for r in self.results]),
            certificates=self._certificates(),
        )

    def _contact(self, pair: Pair) -> ContactHistory:
        interface, coupling = self._reduction.interface, pair.coupling
        nodes = interface.contacts[pair.name]
        roots = interface.roots[nodes]
        relative = np.array([state.relative[nodes] for state in self.states])
        traction = np.array([s.traction[nodes] for s in self.states]) / roots[:, None]
        zero = np.zeros(len(roots))
        units = [unit[nodes] for unit in self._units]
        shape = (0, len(roots), interface.components, len(self._drivers.names))
        steps = self._steps[: len(self.states)]
        return ContactHistory(
            name=pair.name,
            body1=pair.body1,
            body2=pair.body2,
            arc=coupling.arc,
            points=coupling.points,
            frames=coupling.frames,
            weights=coupling.weights,
            friction=np.array([step.friction[nodes.start] for step in steps]),
            traction=traction,
            mean_traction=np.array([coupling.averaging @ t for t in traction]),
            gap=relative[..., 0] / roots,
            slip=-relative[..., 1:] / roots[:, None],
            status=np.array([state.status[nodes] for state in self.states]),
            dissipation=np.array([zero] + [r.dissipation[nodes] for r in self.results]),
            bonded=BondedUnits(
                fields=np.array(units) if units else np.zeros(shape),
                area=np.array(self._area_of_state),
            ),
        )

    def _certificates(self) -> dict[str, Array]:
        """Violations of the contact conditions and of equilibrium, by name, (T,) each."""
        names = [field.name for field in fields(Certificate)]
        columns = {
            name: np.array([0.0] + [getattr(r.certificate, name) for r in self.results])
            for name in names
        }
        columns["worst"] = np.array([0.0] + [r.certificate.worst for r in self.results])
        columns["force_imbalance"], columns["force_scale"] = self._balance()
        return columns

    def _balance(self) -> tuple[Array, Array]:
        """(T,) largest sum of all forces on a body, and the largest force, in each state."""
        imbalance, scale = np.zeros(len(self.states)), np.zeros(len(self.states))
        amplitudes = np.array([s.amplitudes for s in self._steps[: len(self.states)]])
        tractions = np.array([state.traction.ravel() for state in self.states])
        for plan in self._reduction.plan.bodies:
            body = self._reduction.bodies[plan.name]
            parts = np.stack(
                [
                    self._reactions(plan),
                    amplitudes @ body.body.load_resultants.T,
                    body.contact_forces(tractions),
                ]
            )
            imbalance = np.maximum(imbalance, np.abs(parts.sum(axis=0)).max(axis=1))
            scale = np.maximum(scale, np.abs(parts).max(axis=(0, 2)))
        return imbalance, scale

    def _reactions(self, plan: BodyPlan) -> Array:
        """(T, d) sum of the forces that the constrained boundaries exert on a body."""
        d, count = self._reduction.interface.components, len(plan.constraints)
        own = coordinate_range(self._reduction.interface.coordinates, plan.name)
        directions = np.array([c.direction for c in plan.constraints]).reshape(count, d)
        # Free motions come last, and no force acts on them.
        return np.array([state.forces[own][:count] @ directions for state in self.states])
