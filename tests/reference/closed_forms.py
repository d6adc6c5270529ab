# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closed forms of half-planes under a history of loads, exact where there is such a solution."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import numpy.typing as npt
from cases.edge_histories import in_cycle

from fretfe._typing import Array, Indices
from fretfe.analytic.edges import dissipation_per_cycle, slip_length_cyclic, slip_length_loop
from fretfe.analytic.partial_slip import PartialSlip, stick_zone_moderate_tension
from fretfe.analytic.paths import PolygonPath, permanent_stick_load
from fretfe.analytic.profiles import Hertz
from fretfe.analytic.rocking import TiltedContact
from fretfe.backends.halfplane import with_size_errors
from fretfe.case import Case
from fretfe.contact.march import LARGEST_MOVE, TOLERATED
from fretfe.evaluate.contacts import (
    Contact,
    CountedCycles,
    RangeSpread,
    SlipZone,
    Station,
    StationHistory,
    fronts_of,
)
from fretfe.evaluate.cycles import count_cycles
from fretfe.evaluate.edge_loads import edge_loads, returned
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.factors import cycle_range
from fretfe.evaluate.increments import add_up
from fretfe.evaluate.load_path import excess, load_path
from fretfe.evaluate.loaded import decisive_state
from fretfe.evaluate.plane.half_planes import shear_mismatch, tension_history
from fretfe.evaluate.plane.section import PLANE_FRONTS, PlaneFront
from fretfe.evaluate.plane.unit_factors import half_plane_units
from fretfe.evaluate.slip import (
    SlipBorder,
    cycle_states,
    half_cycles,
    last_state,
    zones_of,
)
from fretfe.evaluate.step_ends import StepEnds
from fretfe.history.solution import Factor
from fretfe.idealise import (
    HalfPlaneProblem,
    idealise,
)
from fretfe.idealise.problem import contact_edges

States = Indices

EXACT, MODERATE, ASYMPTOTE = "exact partial slip", "moderate tension", "edge asymptote"
# Loads that vary by less than this fraction of their size are constant.
CONSTANT = 1e-9
SMALL_STEP = 1e-4
# Steps in which an edge moves far are halved so many times at most.
HALVINGS = 10


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
        # From the state in which friction starts to act.
        history = np.arange(max(int(np.argmax(self.problem.friction > 0)) - 1, 0), end + 1)
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
        k_t, k_i = self.station.k_t[states], self.station.k_i[states]
        return _zone(float(slip_length_loop(k_t, k_i, self._k_n(end), self._f(end), -1)))

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
        end, inward = int(states[-1]), self.station.inward
        if not (isinstance(self.problem.profile, Hertz) and self._proportional(states)):
            return None
        contact = self._partial_slip(end)
        try:
            stick, centre = stick_zone_moderate_tension(contact, change[0], change[1])
        except ValueError:  # the tension is not moderate
            return None
        self.used.add(MODERATE)
        return _zone(contact.half_width - stick + inward * centre)

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


def closed_contact(case: Case) -> Contact:
    """The contact of a case that is a half-plane problem."""
    problem = idealise(case)
    steps, shares = divide(problem)
    divided = problem.divided(steps, shares)
    contact, _ = solve_closed_form(divided)
    ends = StepEnds(divided.history.times, np.flatnonzero(shares == 1.0))
    return with_size_errors(ends.contact(contact), problem)


def divide(problem: HalfPlaneProblem) -> tuple[Indices, Array]:
    """(n,) number of the step in which each state lies, and the share of it: 1 at its end.

    Parts with friction are halved until no edge moves farther in them than in those of steps that
    are marched through.
    """
    steps, shares = np.arange(len(problem.history.times)), np.ones(len(problem.history.times))
    for _ in range(HALVINGS):
        finer = problem.divided(steps, shares)
        edges = contact_edges(finer)
        width = np.nan_to_num(edges.right - edges.left)
        places = np.nan_to_num([edges.left, edges.right])
        moved = np.abs(np.diff(places, axis=1)).max(axis=0)
        too_far = moved > TOLERATED * LARGEST_MOVE * (width[1:] + width[:-1]) / 4
        far = np.flatnonzero(too_far & (finer.friction[1:] > 0)) + 1
        if not len(far):
            break
        begin = np.where(steps[far - 1] == steps[far], shares[far - 1], 0.0)
        steps = np.insert(steps, far, steps[far])
        shares = np.insert(shares, far, (begin + shares[far]) / 2)
    return steps, shares


def solve_closed_form(problem: HalfPlaneProblem) -> tuple[Contact, set[str]]:
    """Histories of the contact, and which solutions the slip lengths come from."""
    contact = contact_edges(problem)
    loads = _loads(problem)
    units = half_plane_units(np.stack([contact.left, contact.right]))
    histories = add_up(
        units, loads, problem.friction > 0, contact.right > contact.left, problem.history.cycle
    )
    stations, used = [], set()
    for front in PLANE_FRONTS:
        own = histories[front.number], units[:, front.number]
        station, solutions = _station(problem, contact, front, *own)
        stations.append(station)
        used |= solutions
    centre = (contact.left + contact.right) / 2
    half_width = (contact.right - contact.left) / 2
    k_t, cycle = histories[..., Factor.K_T], problem.history.cycle
    dissipation = sum(station.dissipation for station in stations)
    return Contact(
        name=problem.contact,
        pair=problem.contact,
        fronts=fronts_of(stations),
        normal_force=problem.normal_force,
        shear_force=problem.shear_force,
        moment=problem.moment - np.nan_to_num(centre) * problem.normal_force,
        centre=centre,
        half_width=half_width,
        effective_tension=tension_history(k_t, half_width, cycle),
        shear_mismatch=shear_mismatch(k_t, half_width, problem.shear_force, cycle),
        cycle_change=np.nan,
        # The closed forms are those of the steady cycle.
        steady=problem.history.cycle is not None,
        dissipation=dissipation,
        dissipation_change=np.nan,
        warnings=(),
    ), used


def _loads(problem: HalfPlaneProblem) -> Array:
    """(T, 4) P, M, Q and sigma0."""
    return np.column_stack(
        [problem.normal_force, problem.moment, problem.shear_force, problem.bulk_tension]
    )


def _station(
    problem: HalfPlaneProblem,
    contact: TiltedContact,
    front: PlaneFront,
    factors: Array,
    units: Array,
) -> tuple[Station, set[str]]:
    """The station of a front, singular factors (T, 2), and where its slip lengths come from.

    Its factors (T, 2, 4) for a unit of each load tell what the edge remembers.
    """
    position = (contact.left, contact.right)[front.number]
    k_n = (contact.k_n_left, contact.k_n_right)[front.number]
    exact = np.zeros_like(k_n)
    k_i, k_t = factors.T
    cycle, values = cycle_states(problem.history.cycle), _loads(problem)
    last = int(cycle[-1]) if len(cycle) else len(position) - 1
    own = [] if problem.history.cycle is None else [problem.history.cycle]
    touching, rough = contact.right > contact.left, problem.friction > 0
    held = edge_loads(units, values, rough, problem.normal_force, np.array([1.0, 0.0]), last)
    held = returned(held, values, rough & touching, own)
    history = StationHistory(
        front.name, 0, position, exact, k_n, exact,
        k_t=k_t, k_s=0 * k_t, k_i=k_i, slid=exact, **vars(held),
    )  # fmt: skip
    history = in_cycle(cycle, history)
    borders = ClosedFormBorders(problem, cycle, history)
    loads = problem.history
    path = partial(load_path, loads.values, loads.between)
    ends = np.arange(len(position))
    state = decisive_state(problem.normal_force, history.k_t, cycle, ends)
    history = replace(history, decisive=state)
    a, end = float((contact.right - contact.left)[last] / 2), last_state(cycle, history)
    memory = EdgeMemory.of(history, problem.friction, end, half_width=a, path=path)
    cycles = count_cycles(cycle, problem.friction, history, memory, problem.history.returns)
    zones: tuple[SlipZone, ...] = ()
    if memory is not None:
        halves = half_cycles(cycle, memory, cycles.irregular, False)
        zones = zones_of(cycle, memory, halves, borders)
    spread = RangeSpread(0.0, 0.0, excess(history.k_t, path(loads.cycle)))
    k_range = cycle_range(history.k_t, cycle)
    station = Station(
        **vars(history),
        frame=front.frame(across=np.array([0.0, 1.0]), tangent=np.array([1.0, 0.0])),
        k_n_moved=np.nan,
        k_n_moved_spread=np.nan,
        stiffening=_stiffening(problem, contact),
        k_t_range=k_range,
        k_range=k_range,
        k_range_spread=spread.total,
        k_range_parts=spread,
        k_i_range=cycle_range(history.k_i, cycle),
        friction=float(problem.friction[state]),
        cycles=cycles,
        slip_zones=zones,
        dissipation=_dissipation(problem, cycle, zones, k_n, cycles),
    )
    return station, borders.used


def _stiffening(problem: HalfPlaneProblem, contact: TiltedContact) -> float:
    """(d2P/da2)/(dP/da) in the last state; that of the contact without moment."""
    a = float(contact.right[-1] - contact.left[-1]) / 2
    slopes = problem.profile.load_slope(a * np.array([1 - SMALL_STEP, 1.0, 1 + SMALL_STEP]))
    return float((slopes[2] - slopes[0]) / (2 * SMALL_STEP * a * slopes[1]))


def _dissipation(
    problem: HalfPlaneProblem,
    cycle: Indices,
    zones: tuple[SlipZone, ...],
    k_n: Array,
    cycles: CountedCycles,
) -> float:
    """Friction work at one front in the cycle; NaN without a cycle or with varying P.

    Each counted cycle is a loop of its own, nested in the larger ones.
    """
    normal = problem.normal_force[cycle] if len(cycle) else np.array([0.0, 1.0])
    last = int(cycle[-1]) if len(cycle) else 0
    friction = float(problem.friction[last])
    if np.ptp(normal) > 1e-9 * normal.max() or friction == 0 or not zones:
        return np.nan
    if not np.ptp(problem.bulk_tension[cycle]) and not np.any(problem.moment[cycle]):
        shares = cycles.k_t_range / cycles.k_t_range.max() if cycles.irregular else np.ones(1)
        amplitudes = shares * float(np.ptp(problem.shear_force[cycle])) / 2
        contact = PartialSlip(problem.profile, float(normal[0]), friction)
        return sum(contact.dissipation(float(each)) for each in amplitudes) / 2
    lengths = cycles.slip if cycles.irregular else np.array([zones[-1].length])
    work = dissipation_per_cycle(k_n[last], lengths, friction, problem.profile.e_star)
    return float(np.sum(work))
