# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of a solved history: resultants, fronts, slip zones and warnings of every contact."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.edges.consistency import full_stick_shear_force, shear_mismatch, tension_history
from fretfe.edges.factors import (
    FEWEST_NODES,
    UnitFactors,
    add_up,
    edge_fits,
    edge_movement,
    integral_units,
)
from fretfe.edges.front import ContactSummary, Frame, Station, fronts_of
from fretfe.edges.patches import contact_patches, resultants
from fretfe.edges.pressure import EdgeFit
from fretfe.edges.section import PLANE_FRONTS, PlaneFront, nearest_front
from fretfe.edges.slip import cycle_change
from fretfe.edges.slip_zones import States, cycle_states, slip_border_of, slip_zones
from fretfe.results.solution import OPEN, ContactHistory, Factor, Solution

# From solution, contact and positions (stations, T) along the arc.
FindUnits = Callable[[Solution, ContactHistory, Array], UnitFactors]
# Change of the shear from one cycle to the next, relative to f p_max, below which it is steady.
STEADY_CHANGE = 1e-3
# Patches that carry less than this share of the normal force are traces of round-off.
SMALLEST_PATCH = 1e-3


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
    k_t = np.array([station.k_t for station in stations])
    return ContactSummary(
        name=contact.name,
        fronts=fronts_of(stations),
        normal_force=forces[:, 0],
        shear_force=forces[:, 1],
        moment=np.array(moments),
        centre=centre,
        half_width=half_width,
        effective_tension=tension_history(k_t, half_width, solution.cycle),
        shear_mismatch=shear_mismatch(
            k_t, half_width, full_stick_shear_force(solution, contact), solution.cycle
        ),
        cycle_change=change,
        steady=bool(change < STEADY_CHANGE),
        dissipation=float(_over_cycle(solution, contact.dissipation).sum()),
        dissipation_change=_dissipation_change(solution, contact),
        warnings=(*_unknown(solution, contact, stations), *_warnings(contact, stations, change)),
    )


@dataclass(frozen=True)
class _Histories:
    """Singular factors (R, stations, T, d) in R ways, and (stations, T, d) by fits, if any."""

    ways: Array
    fitted: Array | None
    exact: bool


def _factor_histories(
    solution: Solution, contact: ContactHistory, positions: Array, find_units: FindUnits
) -> _Histories:
    units = find_units(solution, contact, positions)
    touching = np.any(contact.traction[:, :, 0] > 0, axis=1)

    def history(each: Array) -> Array:
        drivers = solution.driver_values
        return add_up(each, drivers, contact.friction, touching, solution.cycle)

    fitted = history(units.fitted) if units.fitted is not None else None
    return _Histories(np.array([history(each) for each in units.main]), fitted, units.exact)


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
        k_n_moved_spread=movement.k_n_spread,
        stiffening=movement.stiffening,
        k_t_range=_range(history.k_t, cycle),
        k_t_range_spread=_spread(ranges, histories.exact),
        k_t_range_fitted=(
            _range(fitted[front.number, :, Factor.K_T], cycle) if fitted is not None else np.nan
        ),
        k_i_range=_range(history.k_i, cycle),
        slip_zones=slip_zones(cycle, contact.friction, history, border),
        dissipation=float(_over_cycle(solution, contact.dissipation)[here].sum()),
    )


def _spread(ranges: list[float], exact: bool) -> float:
    """Half the difference of several ways; one alone has no spread unless it is exact."""
    if len(ranges) > 1:
        return float(np.ptp(ranges)) / 2
    return 0.0 if exact else np.nan


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


def _unknown(
    solution: Solution, contact: ContactHistory, stations: tuple[Station, ...]
) -> Iterator[str]:
    """Factors that cannot be told, and why."""
    states = cycle_states(solution.cycle)
    states = states if len(states) else np.array([len(solution.times) - 1])
    nodes = np.count_nonzero(contact.traction[states, :, 0] > 0, axis=1)
    if not nodes.any():
        return
    finer = FEWEST_NODES / max(int(nodes.min()), 1)
    reason = (
        f"{nodes.min()} nodes are in contact, {FEWEST_NODES} are wanted at least: make the "
        f"elements {math.ceil(2 * finer) / 2:g} times smaller"
        if finer > 1
        else "the pressure does not fall to zero like a root there"
    )
    for station in stations:
        missing = ["K_N"] if not math.isfinite(station.k_n[-1]) else []
        if len(cycle_states(solution.cycle)) and not math.isfinite(station.k_t_range):
            missing.append("ΔK_T")
        if missing:
            yield f"{' and '.join(missing)} at the {station.front} edge: unknown, because {reason}"


def _patches(contact: ContactHistory) -> Iterator[str]:
    """A contact of several patches, of which only the main one is evaluated."""
    shares = [_main_share(contact.arc, pressure) for pressure in contact.traction[:, :, 0]]
    several = [share for share in shares if share < 1 - SMALLEST_PATCH]
    if several:
        yield (
            f"several patches are in contact in {len(several)} of {len(shares) - 1} states: "
            "edges, half-width and slip zones are those of the patch that carries most, as little "
            f"as {min(several):.0%} of P; P and Q are those of all. Make a contact of each patch"
        )


def _main_share(arc: Array, pressure: Array) -> float:
    patches = contact_patches(arc, np.maximum(pressure, 0.0))
    forces = [patch.force for patch in patches]
    return max(forces) / sum(forces) if forces else 1.0


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
    warnings += _patches(contact)
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
