# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of a solved history: resultants, fronts, slip zones and warnings of every contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.edges.consistency import full_stick_shear_force, shear_mismatch, tension_history
from fretfe.edges.factors import UnitFactors, add_up, edge_fits, edge_movement, integral_units
from fretfe.edges.front import ContactSummary, Frame, Station, fronts_of
from fretfe.edges.patches import resultants
from fretfe.edges.pressure import EdgeFit
from fretfe.edges.section import PLANE_FRONTS, PlaneFront, nearest_front
from fretfe.edges.slip import cycle_change
from fretfe.edges.slip_zones import States, cycle_states, slip_border_of, slip_zones
from fretfe.results.solution import OPEN, ContactHistory, Factor, Solution

# From solution, contact and positions (stations, T) along the arc.
FindUnits = Callable[[Solution, ContactHistory, Array], UnitFactors]
# Change of the shear from one cycle to the next, relative to f p_max, below which it is steady.
STEADY_CHANGE = 1e-3


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
    fits = edge_fits(contact)
    positions = np.array([fit.position for fit in fits])
    centre, half_width = positions.mean(axis=0), (positions[1] - positions[0]) / 2
    histories = _factor_histories(solution, contact, positions, find_units)
    stations = tuple(
        _evaluate_station(solution, contact, front, fit, histories, centre)
        for front, fit in zip(PLANE_FRONTS, fits, strict=True)
    )
    # The weights are those of the solution itself: P and Q balance the loads to round-off.
    forces = np.einsum("n,tnc->tc", contact.weights, contact.traction)
    moments = [
        resultants(contact.arc, t[:, 0], t[:, 1], c if np.isfinite(c) else 0.0).moment
        for t, c in zip(contact.traction, centre, strict=True)
    ]
    change = _cycle_change(solution, contact)
    cycle = cycle_states(solution.cycle)
    k_t = np.array([station.k_t for station in stations])
    return ContactSummary(
        name=contact.name,
        fronts=fronts_of(stations),
        normal_force=forces[:, 0],
        shear_force=forces[:, 1],
        moment=np.array(moments),
        centre=centre,
        half_width=half_width,
        effective_tension=tension_history(k_t, half_width),
        shear_mismatch=shear_mismatch(
            k_t, half_width, full_stick_shear_force(solution, contact), cycle
        ),
        cycle_change=change,
        steady=bool(change < STEADY_CHANGE),
        dissipation=float(_over_cycle(solution, contact.dissipation).sum()),
        dissipation_change=_dissipation_change(solution, contact),
        warnings=_warnings(contact, stations, change),
    )


@dataclass(frozen=True)
class _Histories:
    """Singular factors (R, stations, T, d) in R ways, and (stations, T, d) by fits, if any."""

    ways: Array
    fitted: Array | None


def _factor_histories(
    solution: Solution, contact: ContactHistory, positions: Array, find_units: FindUnits
) -> _Histories:
    drivers, friction = solution.driver_values, contact.friction
    units = find_units(solution, contact, positions)
    ways = np.array([add_up(each, drivers, friction) for each in units.main])
    if units.fitted is None:
        return _Histories(ways, None)
    return _Histories(ways, add_up(units.fitted, drivers, friction))


def _evaluate_station(
    solution: Solution,
    contact: ContactHistory,
    front: PlaneFront,
    fit: EdgeFit,
    histories: _Histories,
    centre: Array,
) -> Station:
    by_way = histories.ways[:, front.number]
    history = front.history(fit.position, fit.k_n, fit.spread_k_n, by_way.mean(axis=0))
    cycle = cycle_states(solution.cycle)
    movement = edge_movement(contact, front, abs(float((centre - fit.position)[-1])))
    ranges = [_range(each, cycle) for each in by_way[..., Factor.K_T]]
    fitted = histories.fitted
    end = centre[cycle[-1] if len(cycle) else -1]
    here = nearest_front(contact.arc, float(end)) == front.number
    border = slip_border_of(contact, front, fit.position)
    return Station(
        **vars(history),
        frame=_frame(contact, front, fit.position),
        k_n_moved=movement.k_n,
        stiffening=movement.stiffening,
        k_t_range=_range(history.k_t, cycle),
        k_t_range_spread=float(np.ptp(ranges)) / 2,
        k_t_range_fitted=(
            _range(fitted[front.number, :, Factor.K_T], cycle) if fitted is not None else np.nan
        ),
        k_i_range=_range(history.k_i, cycle),
        slip_zones=slip_zones(cycle, contact.friction, history, border),
        dissipation=float(_over_cycle(solution, contact.dissipation)[here].sum()),
    )


def _frame(contact: ContactHistory, front: PlaneFront, position: Array) -> Frame:
    """Frame in the last state in which the position (T,) is known."""
    known = position[np.isfinite(position)]
    place = known[-1] if len(known) else np.nan
    rows = contact.frames.reshape(len(contact.arc), -1).T
    across, tangent = np.reshape([np.interp(place, contact.arc, row) for row in rows], (2, 2))
    return front.frame(across, tangent)


def _range(history: Array, cycle: States) -> float:
    return float(np.ptp(history[cycle])) if len(cycle) else np.nan


def _over_cycle(solution: Solution, per_step: Array) -> Array:
    """Sum of a quantity of each step over the evaluated cycle, or over everything without one."""
    cycle = cycle_states(solution.cycle)
    return per_step[cycle[1:]].sum(axis=0) if len(cycle) else per_step.sum(axis=0)


def _dissipation_change(solution: Solution, contact: ContactHistory) -> float:
    """Friction work of the evaluated cycle over that of as many steps before it, less 1."""
    if solution.cycle is None:
        return np.nan
    first, last = solution.cycle
    count, work = last - first, contact.dissipation.sum(axis=1)
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
    pressure = contact.traction[last, :, 0].max()
    if contact.friction[last] == 0 or pressure <= 0:
        return np.nan
    shear = contact.traction[:, :, 1]
    return cycle_change(shear[last], shear[first], float(contact.friction[last]), float(pressure))


def _warnings(
    contact: ContactHistory, stations: tuple[Station, ...], change: float
) -> tuple[str, ...]:
    warnings = []
    closed = contact.status != OPEN
    if not closed.any():
        smallest = contact.gap.min()
        warnings.append(f"the surfaces never touch; the smallest gap is {smallest:.4g}")
    for front in PLANE_FRONTS:
        if front.from_front(closed)[:, 0].any():
            warnings.append(
                f"the contact reaches the {front.name} end of its surface: extend the physical "
                "group, the edge there is not that of the contact"
            )
    if change >= STEADY_CHANGE:
        warnings.append(
            f"not in steady state: the shear changes by {change:.2g} f p_max over the evaluated "
            "cycle; add cycles"
        )
    for station in stations:
        if station.uncertain:
            warnings.append(
                f"K_N at the {station.front} edge is {station.k_n[-1]:.3g} ± "
                f"{station.k_n_spread[-1]:.2g}: refine the mesh at this edge"
            )
        if any(zone.gross for zone in station.slip_zones[-2:]):
            warnings.append(f"gross slip in the last half cycles ({station.front} edge)")
        elif any(not zone.resolved for zone in station.slip_zones[-2:]):
            warnings.append(f"the {station.front} slip zone is not resolved by the mesh")
    return tuple(warnings)
