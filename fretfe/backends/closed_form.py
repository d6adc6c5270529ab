# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip zones of half-planes in closed form: exact where such a solution exists, else asymptotic.

Exact are: any profile under P and Q (Cattaneo-Mindlin; Ciavarella-Jäger; with P varying in a steady
cycle the permanent stick zone is the contact area at P* = [min(Q + fP) - max(Q - fP)]/(2f), Barber,
Davies and Hills 2011), and Hertz under Q and a moderate bulk tension in proportion (Nowell and
Hills 1987). Everything else follows from the edge factors.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Indices
from fretfe.analytic.edges import slip_length_cyclic
from fretfe.analytic.moderate_tension import stick_zone_moderate_tension
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.paths import PolygonPath, permanent_stick_load
from fretfe.analytic.profiles import Hertz
from fretfe.edges.front import StationHistory
from fretfe.edges.section import plane_front
from fretfe.edges.slip import SlipBorder, predicted_slip
from fretfe.idealise import HalfPlaneProblem

States = Indices

EXACT, MODERATE, ASYMPTOTE = "exact partial slip", "moderate tension", "edge asymptote"
# Loads that vary by less than this fraction of their size are constant.
CONSTANT = 1e-9


@dataclass
class ClosedFormBorders:
    """Slip zones of one station, and which solutions they come from.

    Args:
        problem: the loads.
        cycle: states of the evaluated cycle.
        station: its position and factors.
    """

    problem: HalfPlaneProblem
    cycle: States
    station: StationHistory
    used: set[str] = field(default_factory=set)

    def __call__(self, start: int, end: int) -> SlipBorder:
        """Slip zone of the half cycle between two states, from the edge at the second one."""
        if end in self.cycle or (len(self.cycle) and start >= self.cycle[0]):
            return self._steady(end)
        states = np.arange(start, end + 1)
        if self.problem.friction[start] == 0:
            return self._first_loading(states)
        history = self._since_friction(end)
        if self._only_shear(history):
            self.used.add(EXACT)
            contact = self._partial_slip(end)
            stick = contact.stick_half_width_after(self.problem.shear_force[history])
            return _zone(contact.half_width - stick)
        # Between first loading and the steady cycle: the range of this half cycle alone.
        self.used.add(ASYMPTOTE)
        return _zone(
            slip_length_cyclic(np.ptp(self.station.k_t[states]), self._k_n(end), self._f(end))
        )

    def _first_loading(self, states: States) -> SlipBorder:
        """From the state in which friction starts to act."""
        end = int(states[-1])
        if self._constant(self.problem.normal_force, states) and self._symmetric(states):
            contact = self._partial_slip(end)
            change = self._change(states)
            if self._constant(self.problem.bulk_tension, states):
                self.used.add(EXACT)
                stick = contact.stick_half_width(change[0])
                return _zone(contact.half_width - stick)
            moderate = self._moderate(states, change)
            if moderate is not None:
                return moderate
        self.used.add(ASYMPTOTE)
        rise = self.station.k_t[end] - self.station.k_t[states[0]]
        return _zone(2 * slip_length_cyclic(abs(rise), self._k_n(end), self._f(end)))

    def _steady(self, end: int) -> SlipBorder:
        """In the steady cycle; `end` may be just behind it."""
        problem, cycle = self.problem, self.cycle
        if self._symmetric(cycle):
            if self._constant(problem.bulk_tension, cycle):
                return self._permanent_stick(end)
            if self._constant(problem.normal_force, cycle):
                moderate = self._moderate(cycle, self._change(cycle) / 2)
                if moderate is not None:
                    return moderate
        self.used.add(ASYMPTOTE)
        states = np.append(cycle, end)
        predicted = predicted_slip(
            self.station.k_t[states],
            self.station.k_i[states],
            self._k_n(end),
            self._f(end),
            reference=-1,
        )
        return _zone(predicted.loop)

    def _permanent_stick(self, end: int) -> SlipBorder:
        problem = self.problem
        loads = np.zeros((len(self.cycle), 4))
        loads[:, 0] = problem.normal_force[self.cycle]
        loads[:, 2] = problem.shear_force[self.cycle]
        stick = float(permanent_stick_load(PolygonPath(loads), self._f(end)))
        self.used.add(EXACT)
        if stick <= 0:
            return SlipBorder(np.nan, resolved=True, gross=True)
        at_end = problem.profile.half_width(problem.normal_force[end])
        return _zone(at_end - problem.profile.half_width(stick))

    def _moderate(self, states: States, change: Array) -> SlipBorder | None:
        """Hertz with tension in proportion to the shear force; None if that is not the case."""
        end, inward = int(states[-1]), plane_front(self.station.front).inward
        if not (isinstance(self.problem.profile, Hertz) and self._proportional(states)):
            return None
        contact = self._partial_slip(end)
        try:
            stick, centre = stick_zone_moderate_tension(contact, change[0], change[1])
        except ValueError:  # the tension is not moderate
            return None
        self.used.add(MODERATE)
        return _zone(contact.half_width - stick + inward * centre)

    def _since_friction(self, end: int) -> States:
        """States from the one in which friction starts to act."""
        return np.arange(max(int(np.argmax(self.problem.friction > 0)) - 1, 0), end + 1)

    def _only_shear(self, states: States) -> bool:
        """True if nothing but Q changes."""
        constant = (self.problem.normal_force, self.problem.bulk_tension)
        return self._symmetric(states) and all(self._constant(load, states) for load in constant)

    def _change(self, states: States) -> Array:
        """(2,) change of Q and sigma0 between the states where Q is smallest and largest.

        From the first state on if there is no cycle.
        """
        loads = np.stack([self.problem.shear_force, self.problem.bulk_tension])[:, states]
        if states is not self.cycle:
            return np.asarray(loads[:, -1] - loads[:, 0])
        return np.asarray(loads[:, np.argmax(loads[0])] - loads[:, np.argmin(loads[0])])

    def _proportional(self, states: States) -> bool:
        """True if Q and sigma0 move along one straight line, and Q moves at all."""
        loads = np.stack([self.problem.shear_force, self.problem.bulk_tension])[:, states]
        loads = loads - loads[:, :1]
        scale = np.abs(loads).max(axis=1)
        if np.any(scale == 0):
            return False
        values = np.linalg.svd(loads / scale[:, None], compute_uv=False)
        return bool(values[1] < 1e-6 * values[0])

    def _constant(self, load: Array, states: States) -> bool:
        return bool(np.ptp(load[states]) <= CONSTANT * max(np.abs(load).max(), 1e-300))

    def _symmetric(self, states: States) -> bool:
        return not np.any(self.problem.moment[states])

    def _partial_slip(self, state: int) -> PartialSlip:
        problem = self.problem
        return PartialSlip(problem.profile, float(problem.normal_force[state]), self._f(state))

    def _k_n(self, state: int) -> float:
        return float(self.station.k_n[state])

    def _f(self, state: int) -> float:
        return float(self.problem.friction[state])


def _zone(length: npt.ArrayLike) -> SlipBorder:
    return SlipBorder(max(float(np.asarray(length)), 0.0), resolved=True, gross=False)
