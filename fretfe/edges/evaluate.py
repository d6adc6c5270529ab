# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of a solved history: resultants, fronts, slip zones and warnings of every contact."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.edges.between import LoadPath, load_path
from fretfe.edges.consistency import full_stick_shear_force, shear_mismatch, tension_history
from fretfe.edges.factors import (
    UnitFactors,
    add_up,
    edge_fits,
    edge_movement,
    integral_units,
    one_sided_share,
)
from fretfe.edges.front import (
    LARGEST_SPREAD,
    ContactSummary,
    Frame,
    RangeSpread,
    Station,
    fronts_of,
)
from fretfe.edges.lives import by_life, in_evaluated_life
from fretfe.edges.missions import count_cycles, worst_cycle
from fretfe.edges.patches import pressure_moments
from fretfe.edges.pressure import EdgeFit
from fretfe.edges.range_spread import FactorHistories, cycle_range, range_spreads
from fretfe.edges.section import PLANE_FRONTS, PlaneFront, nearest_front
from fretfe.edges.slip import cycle_change
from fretfe.edges.slip_zones import States, cycle_states, slip_border_of, slip_zones
from fretfe.edges.warnings import STEADY_CHANGE, warnings_about
from fretfe.results.solution import ContactHistory, Factor, Solution
from fretfe.results.states import blocks

# From solution, contact and positions (stations, T) along the arc.
FindUnits = Callable[[Solution, ContactHistory, Array], UnitFactors]
# Linear elements are too stiff: K_N was 1.6 % (cylinder) to 2.8 % (flat with rounded ends) high
# with them, however fine the mesh at the edges.
LINEAR_ELEMENTS = 0.025


def evaluate(
    solution: Solution, find_units: FindUnits = integral_units
) -> tuple[ContactSummary, ...]:
    """Evaluate every contact of a solution.

    Args:
        solution: the solved history.
        find_units: gives the singular factors for a unit of each driver: by interaction integrals
            and fits, unless there is a closed form.
    """
    return tuple(_evaluate_contact(solution, contact, find_units) for contact in solution.contacts)


def _evaluate_contact(
    solution: Solution, contact: ContactHistory, find_units: FindUnits
) -> ContactSummary:
    fits = edge_fits(contact, solution.source)
    positions = np.array([fit.position for fit in fits])
    centre, half_width = positions.mean(axis=0), (positions[1] - positions[0]) / 2
    histories = _factor_histories(solution, contact, positions, find_units)
    cycle = cycle_states(solution.cycle)
    path = load_path(solution.values, solution.between, solution.cycle)
    spreads = range_spreads(histories, fits, contact.arc, cycle, path)
    work = _friction_work(solution, contact)
    stations = tuple(
        _evaluate_station(
            solution,
            contact,
            front,
            fit,
            histories,
            spreads[front.number],
            centre,
            path,
            work.in_cycle,
        )
        for front, fit in zip(PLANE_FRONTS, fits, strict=True)
    )
    forces, moments = _resultants(contact, centre)
    change = _cycle_change(solution, contact)
    k_t = np.array([station.k_t for station in stations])

    def tension(life: slice, cycle: tuple[int, int] | None) -> Array:
        return tension_history(k_t[:, life], half_width[life], cycle)

    return ContactSummary(
        name=contact.name,
        pair=contact.pair,
        fronts=fronts_of(stations),
        normal_force=forces[:, 0],
        shear_force=forces[:, 1],
        moment=moments,
        centre=centre,
        half_width=half_width,
        effective_tension=by_life(contact, solution.cycle, tension),
        shear_mismatch=shear_mismatch(
            k_t, half_width, full_stick_shear_force(solution, contact), solution.cycle
        ),
        cycle_change=change,
        steady=bool(change < STEADY_CHANGE),
        dissipation=float(work.in_cycle.sum()),
        dissipation_change=_dissipation_change(solution, contact, work.by_step),
        warnings=tuple(warnings_about(solution, contact, stations, change)),
    )


def _resultants(contact: ContactHistory, centre: Array) -> tuple[Array, Array]:
    """(T, 2) P and Q, and (T,) moments about the centre, or about 0 where there is none."""
    forces, moments = np.zeros((len(centre), 2)), np.zeros(len(centre))
    for states in blocks(len(centre), contact.traction[0].size):
        traction = contact.traction[states]
        # The weights are those of the solution itself: P and Q balance the loads to round-off.
        forces[states] = np.einsum("n,tnc->tc", contact.weights, traction[..., :2])
        middle = np.where(np.isfinite(centre[states]), centre[states], 0.0)
        moments[states] = pressure_moments(contact.arc, traction[..., 0], middle)
    return forces, moments


def _factor_histories(
    solution: Solution, contact: ContactHistory, positions: Array, find_units: FindUnits
) -> FactorHistories:
    units = find_units(solution, contact, positions)
    touching = contact.pressed_nodes > 0

    def history(each: Array) -> Array:
        def count(life: slice, cycle: tuple[int, int] | None) -> Array:
            drivers, friction = solution.driver_values[life], contact.friction[life]
            return add_up(each[life], drivers, friction, touching[life], cycle).swapaxes(0, 1)

        return by_life(contact, solution.cycle, count).swapaxes(0, 1)

    ways, one_sided = [], []
    for each in units.main:
        ways.append(history(each))
        one_sided.append(one_sided_share(each, solution.driver_values, solution.cycle))
    return FactorHistories(
        ways=np.array(ways),
        fitted=history(units.fitted) if units.fitted is not None else None,
        exact=units.exact,
        one_sided=one_sided[0],
    )


def _evaluate_station(
    solution: Solution,
    contact: ContactHistory,
    front: PlaneFront,
    fit: EdgeFit,
    histories: FactorHistories,
    spread: RangeSpread,
    centre: Array,
    path: LoadPath | None,
    work: Array,
) -> Station:
    by_way = histories.ways[:, front.number]
    cycle = cycle_states(solution.cycle)
    movement = edge_movement(contact, front, abs(float((centre - fit.position)[-1])))
    k_n_spread = _k_n_spread(solution, fit, movement.k_n, histories.exact)
    history = front.history(
        fit.position, fit.spread_position, fit.k_n, k_n_spread, by_way.mean(axis=0)
    )
    fitted = histories.fitted
    here = nearest_front(contact.arc, last_known(centre, cycle)) == front.number
    evaluated = in_evaluated_life(contact, solution.cycle, history)
    cycles = count_cycles(cycle, contact.friction, evaluated)
    worst = worst_cycle(cycles, cycle, contact.friction, evaluated)
    outer = worst.outer if worst else np.ones(len(solution.times), dtype=bool)
    return Station(
        **vars(history),
        frame=_frame(contact, front, fit.position),
        k_n_moved=movement.k_n,
        k_n_moved_spread=movement.k_n_spread,
        stiffening=movement.stiffening,
        k_t_range=cycle_range(history.k_t, cycle),
        k_t_range_spread=spread.total,
        k_t_range_parts=spread,
        k_t_range_fitted=(
            cycle_range(fitted[front.number, :, Factor.K_T], cycle)
            if fitted is not None
            else np.nan
        ),
        k_i_range=cycle_range(history.k_i, cycle),
        cycles=cycles,
        slip_zones=slip_zones(
            cycle,
            contact.friction,
            evaluated,
            slip_border_of(contact, front, fit.position, outer),
            path,
            worst=worst,
        ),
        dissipation=float(work[here].sum()),
    )


def _k_n_spread(solution: Solution, fit: EdgeFit, moved: float, exact: bool) -> Array:
    """(T,) error bars of K_N: the fits see nothing of what the elements of the bodies do to p.

    Where the fits of the last state disagree, so may all of them; K_N by the movement of the edge
    does not depend on them.
    """
    spread = fit.spread_k_n.copy()
    if solution.degree == 1 and not exact:
        spread = np.hypot(spread, LINEAR_ELEMENTS * fit.k_n)
    if spread[-1] > LARGEST_SPREAD * fit.k_n[-1] and math.isfinite(moved):
        spread[-1] = max(spread[-1], abs(fit.k_n[-1] - moved))
    return spread


def last_known(values: Array, cycle: States) -> float:
    """The last of values (T,) that is known, up to the end of the cycle; NaN if none is."""
    values = values[: cycle[-1] + 1] if len(cycle) else values
    known = values[np.isfinite(values)]
    return float(known[-1]) if len(known) else np.nan


def _frame(contact: ContactHistory, front: PlaneFront, position: Array) -> Frame:
    """Frame in the last state in which the position (T,) is known."""
    place = last_known(position, np.array([], dtype=np.int64))
    rows = contact.frames.reshape(len(contact.arc), -1).T
    across, tangent = np.reshape([np.interp(place, contact.arc, row) for row in rows], (2, 2))
    return front.frame(across, tangent)


@dataclass(frozen=True)
class _Work:
    """Friction work.

    Attributes:
        by_step: (T,) of all nodes.
        in_cycle: (N,) of each node in the evaluated cycle, or in everything without one.
    """

    by_step: Array
    in_cycle: Array


def _friction_work(solution: Solution, contact: ContactHistory) -> _Work:
    count = len(contact.dissipation)
    by_step, in_cycle = np.zeros(count), np.zeros(len(contact.arc))
    first, last = solution.cycle or (-1, count - 1)
    for states in blocks(count, len(contact.arc)):
        work = contact.dissipation[states]
        by_step[states] = work.sum(axis=1)
        begin, end = max(first + 1 - states.start, 0), max(last + 1 - states.start, 0)
        in_cycle += work[begin:end].sum(axis=0)
    return _Work(by_step, in_cycle)


def _dissipation_change(solution: Solution, contact: ContactHistory, work: Array) -> float:
    """Friction work of the evaluated cycle over that of as many steps before it, less 1."""
    if solution.cycle is None:
        return np.nan
    first, last = solution.cycle
    count = last - first
    before = work[first - count + 1 : first + 1].sum() if first >= count else 0.0
    earlier = contact.friction[first - count + 1 : first + 1] if first >= count else np.zeros(1)
    if not (before > 0 and np.all(earlier > 0)):
        return np.nan
    return float(work[first + 1 : last + 1].sum() / before - 1)


def _cycle_change(solution: Solution, contact: ContactHistory) -> float:
    """Largest change of the shear between the ends of the cycle, relative to f p_max."""
    if solution.cycle is None:
        return np.nan
    first, last = solution.cycle
    begin, end = contact.traction[first], contact.traction[last]
    pressure = end[:, 0].max()
    if contact.friction[last] == 0 or pressure <= 0:
        return np.nan
    return cycle_change(end[:, 1], begin[:, 1], float(contact.friction[last]), float(pressure))
