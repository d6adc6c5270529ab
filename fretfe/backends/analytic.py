# SPDX-License-Identifier: LGPL-3.0-or-later
"""The backend `analytic`: closed forms for half-planes."""

from __future__ import annotations

import time

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.analytic.edges import dissipation_per_cycle
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.rocking import TiltedContact
from fretfe.backends.closed_form import ASYMPTOTE, ClosedFormBorders
from fretfe.backends.fields_only import field_obstacles
from fretfe.backends.finite_bodies import size_limit, with_size_errors
from fretfe.backends.protocol import DEFAULTS, RunOptions
from fretfe.case import Case
from fretfe.edges.between import excess, load_path
from fretfe.edges.consistency import shear_mismatch, tension_history
from fretfe.edges.factors import add_up
from fretfe.edges.front import (
    ContactSummary,
    CountedCycles,
    RangeSpread,
    SlipZone,
    Station,
    fronts_of,
)
from fretfe.edges.half_plane import half_plane_units
from fretfe.edges.limits import with_limit_warnings
from fretfe.edges.missions import count_cycles, worst_cycle
from fretfe.edges.section import PLANE_FRONTS, PlaneFront
from fretfe.edges.slip_zones import cycle_states, slip_zones
from fretfe.idealise import HalfPlaneProblem, idealise, obstacles
from fretfe.idealise.edges import contact_edges, governing_length
from fretfe.results.model import Result
from fretfe.results.solution import Factor

SMALL_STEP = 1e-4
# Relative slip-zone length from which the asymptote deserves a warning: about 10 % error.
LONG_SLIP_ZONE = 0.2


class AnalyticBackend:
    """Closed forms of `fretfe.analytic` for a pad on a large block."""

    summary = "closed forms for half-planes: pads on large blocks"

    def supports(self, case: Case) -> tuple[str, ...]:
        """Reasons why a case is not a half-plane problem, or asks for fields."""
        return (*obstacles(case), *field_obstacles(case))

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        """Solve a case that is a half-plane problem.

        Raises:
            NotIdealisable: if it is none.
            CaseError: if template, parameters or history are not valid.
        """
        start = time.perf_counter()
        problem = idealise(case, options.history)
        summary, used = solve_closed_form(problem)
        options.progress(
            len(problem.history.times) - 1, len(problem.history.times) - 1, "closed form"
        )
        limits = (size_limit(problem.contact, problem),)
        notes = problem.notes
        if used:
            notes = (*notes, f"slip lengths by: {', '.join(sorted(used))}")
        return Result(
            case=case,
            loads=problem.history,
            contacts=with_limit_warnings([with_size_errors(summary, problem)], limits),
            limits=limits,
            notes=notes,
            seconds={"closed forms": time.perf_counter() - start},
        )


def solve_closed_form(problem: HalfPlaneProblem) -> tuple[ContactSummary, set[str]]:
    """Histories of the contact, and which solutions the slip lengths come from."""
    contact = contact_edges(problem)
    loads = np.column_stack(
        [problem.normal_force, problem.moment, problem.shear_force, problem.bulk_tension]
    )
    units = half_plane_units(np.stack([contact.left, contact.right]))
    histories = add_up(
        units, loads, problem.friction, contact.right > contact.left, problem.history.cycle
    )
    stations, used = [], set()
    for front in PLANE_FRONTS:
        station, solutions = _station(problem, contact, front, histories[front.number])
        stations.append(station)
        used |= solutions
    centre = (contact.left + contact.right) / 2
    half_width = (contact.right - contact.left) / 2
    k_t, cycle = histories[..., Factor.K_T], problem.history.cycle
    dissipation = sum(station.dissipation for station in stations)
    return ContactSummary(
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
        warnings=_warnings(problem, contact, stations, used),
    ), used


def _station(
    problem: HalfPlaneProblem, contact: TiltedContact, front: PlaneFront, factors: Array
) -> tuple[Station, set[str]]:
    """The station of a front, singular factors (T, 2), and where its slip lengths come from."""
    position = (contact.left, contact.right)[front.number]
    k_n = (contact.k_n_left, contact.k_n_right)[front.number]
    exact = np.zeros_like(k_n)
    history = front.history(position, exact, k_n, exact, factors)
    cycle = cycle_states(problem.history.cycle)
    borders = ClosedFormBorders(problem, cycle, history)
    loads = problem.history
    path = load_path(loads.values, loads.between, loads.cycle)
    cycles = count_cycles(cycle, problem.friction, history)
    worst = worst_cycle(cycles, cycle, problem.friction, history)
    zones = slip_zones(cycle, problem.friction, history, borders, path, worst=worst)
    spread = RangeSpread(0.0, 0.0, excess(history.k_t, cycle, path))
    station = Station(
        **vars(history),
        frame=front.frame(across=np.array([0.0, 1.0]), tangent=np.array([1.0, 0.0])),
        k_n_moved=np.nan,
        k_n_moved_spread=np.nan,
        stiffening=_stiffening(problem, contact),
        k_t_range=float(np.ptp(history.k_t[cycle])) if len(cycle) else np.nan,
        k_t_range_spread=spread.total,
        k_t_range_parts=spread,
        k_t_range_fitted=np.nan,
        k_i_range=float(np.ptp(history.k_i[cycle])) if len(cycle) else np.nan,
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


def _warnings(
    problem: HalfPlaneProblem, contact: TiltedContact, stations: list[Station], used: set[str]
) -> tuple[str, ...]:
    if ASYMPTOTE not in used:
        return ()
    half_width = float((contact.right[-1] - contact.left[-1]) / 2)
    length = governing_length(problem, half_width)
    longest = max(zone.length for station in stations for zone in station.slip_zones[-2:])
    if longest <= LONG_SLIP_ZONE * length:
        return ()
    return (
        f"the longest slip zone is {longest / length:.2g} of the length over which the edge "
        "description holds: the asymptote may be wrong by more than 10 %, use the backend "
        "'halfplane'",
    )


BACKEND = AnalyticBackend()
