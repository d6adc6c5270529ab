# SPDX-License-Identifier: LGPL-3.0-or-later
"""Summary of every contact of a solution: resultants, edges, slip zones, warnings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.edges import EdgeFit, Side, cycle_change, resultants
from fretfe.edges.consistency import shear_mismatch, stuck_shear_force, tension_history
from fretfe.edges.factors import (
    SIDES,
    UnitFactors,
    add_up,
    edge_fits,
    edge_movement,
    integral_units,
)
from fretfe.edges.slip_zones import SlipZone, States, cycle_states, slip_border_of, slip_zones
from fretfe.results.solution import OPEN, ContactHistory, Solution

# From solution, contact and positions (2, T) of its edges.
FindUnits = Callable[[Solution, ContactHistory, Array], UnitFactors]
# Change of the shear from one cycle to the next, relative to f p_max, below which it is steady.
STEADY_CHANGE = 1e-3
# Spread of the fits of K_N, relative to K_N, from which it is marked as uncertain.
LARGEST_SPREAD = 0.05


@dataclass(frozen=True)
class Edge:
    """One edge of a contact.

    Attributes:
        side: "left" or "right" in the frame of the contact.
        position: (T,) along the arc; NaN where there is no contact or it cannot be fitted.
        k_n: (T,) pressure factor.
        k_n_spread: (T,) uncertainty of the fit.
        k_t: (T,) shear factor, counted from the first state with friction.
        k_i: (T,) factor of the normal increments, counted from the first state in contact.
        k_n_moved: (,) K_N in the last state from the movement of the edge between two load levels,
            2 dK_I/da; NaN without them.
        stiffening: (,) relative growth of dP/da with the half-width a in the last state, from the
            same two loads; it tells how long a slip zone may be for the edge description.
        k_t_range: range of K_T over the evaluated cycle, NaN without one.
        k_t_range_spread: half the difference of the ranges that the radii of the interaction
            integral give; 0 if K_T is known in closed form.
        k_t_range_fitted: range of K_T by fits to the tractions of the companion increments; NaN
            without them.
        k_i_range: range of K_I.
        slip_zones: one for each half cycle, in time order.
        dissipation: friction work at this edge in the evaluated cycle, per unit thickness.
    """

    side: Side
    position: Array
    k_n: Array
    k_n_spread: Array
    k_t: Array
    k_i: Array
    k_n_moved: float
    stiffening: float
    k_t_range: float
    k_t_range_spread: float
    k_t_range_fitted: float
    k_i_range: float
    slip_zones: tuple[SlipZone, ...]
    dissipation: float

    @property
    def uncertain(self) -> bool:
        """Whether the fits of K_N at the last state spread too far for a prediction."""
        return bool(self.k_n_spread[-1] > LARGEST_SPREAD * self.k_n[-1])


@dataclass(frozen=True)
class ContactSummary:
    """One contact, evaluated.

    Attributes:
        name: of the contact.
        edges: left and right.
        normal_force, shear_force: (T,) P and Q per unit thickness.
        moment: (T,) moment of the pressure about the centre of the contact.
        centre, half_width: (T,) of the contact, NaN where it has none.
        effective_tension: (T,) bulk tension that gives half-planes the same mean of K_T over the
            two edges, counted like K_T.
        shear_mismatch: (range of Q that half-planes need for K_T at the two edges)/(range of Q of
            the stuck contact) - 1 over the cycle: zero if the half-plane description holds; NaN
            without a cycle.
        cycle_change: change of the shear over the evaluated cycle relative to f p_max.
        steady: whether that is below the limit; False without a cycle.
        dissipation: friction work in the evaluated cycle, per unit thickness.
        dissipation_change: relative change of it from the cycle before; NaN if there is none.
        warnings: what a reader must know, in words.
    """

    name: str
    edges: tuple[Edge, Edge]
    normal_force: Array
    shear_force: Array
    moment: Array
    centre: Array
    half_width: Array
    effective_tension: Array
    shear_mismatch: float
    cycle_change: float
    steady: bool
    dissipation: float
    dissipation_change: float
    warnings: tuple[str, ...]


def evaluate(
    solution: Solution, find_units: FindUnits = integral_units
) -> tuple[ContactSummary, ...]:
    """Evaluate every contact of a solution.

    Args:
        solution: the solved history.
        find_units: gives K_T and K_I for a unit of each driver: by interaction integrals and fits,
            unless there is a closed form.
    """
    return tuple(_evaluate_contact(solution, contact, find_units) for contact in solution.contacts)


def _evaluate_contact(
    solution: Solution, contact: ContactHistory, find_units: FindUnits
) -> ContactSummary:
    fits = edge_fits(contact)
    positions = np.array([fit.position for fit in fits])
    centre, half_width = positions.mean(axis=0), (positions[1] - positions[0]) / 2
    histories = _factor_histories(solution, contact, positions, find_units)
    edges = tuple(
        _evaluate_edge(solution, contact, number, fit, histories, centre)
        for number, fit in enumerate(fits)
    )
    # The weights are those of the solution itself: P and Q balance the loads to round-off.
    forces = np.einsum("n,tnc->tc", contact.weights, contact.traction)
    moments = [
        resultants(contact.arc, t[:, 0], t[:, 1], c if np.isfinite(c) else 0.0).moment
        for t, c in zip(contact.traction, centre, strict=True)
    ]
    change = _cycle_change(solution, contact)
    cycle = cycle_states(solution.cycle)
    k_t = np.array([edge.k_t for edge in edges])
    return ContactSummary(
        name=contact.name,
        edges=(edges[0], edges[1]),
        normal_force=forces[:, 0],
        shear_force=forces[:, 1],
        moment=np.array(moments),
        centre=centre,
        half_width=half_width,
        effective_tension=tension_history(k_t, half_width),
        shear_mismatch=shear_mismatch(k_t, half_width, stuck_shear_force(solution, contact), cycle),
        cycle_change=change,
        steady=bool(change < STEADY_CHANGE),
        dissipation=float(_over_cycle(solution, contact.dissipation).sum()),
        dissipation_change=_dissipation_change(solution, contact),
        warnings=_warnings(contact, edges, change),
    )


@dataclass(frozen=True)
class _Histories:
    """K_T and K_I at both edges: (R, 2, T, 2) in R ways, and (2, T, 2) by fits if there are any."""

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


def _evaluate_edge(
    solution: Solution,
    contact: ContactHistory,
    number: int,
    fit: EdgeFit,
    histories: _Histories,
    centre: Array,
) -> Edge:
    side = SIDES[number]
    by_way = histories.ways[:, number]
    k_t, k_i = by_way.mean(axis=0).T
    cycle = cycle_states(solution.cycle)
    outer = contact.arc < centre[cycle[-1] if len(cycle) else -1]
    movement = edge_movement(contact, side, float((centre - fit.position)[-1]))
    fitted = histories.fitted[number, :, 0] if histories.fitted is not None else None
    return Edge(
        side=side,
        position=fit.position,
        k_n=fit.k_n,
        k_n_spread=fit.spread_k_n,
        k_t=k_t,
        k_i=k_i,
        k_n_moved=movement.k_n,
        stiffening=movement.stiffening,
        k_t_range=_range(k_t, cycle),
        k_t_range_spread=float(np.ptp([_range(each, cycle) for each in by_way[..., 0]])) / 2,
        k_t_range_fitted=_range(fitted, cycle) if fitted is not None else np.nan,
        k_i_range=_range(k_i, cycle),
        slip_zones=slip_zones(
            cycle,
            contact.friction,
            side,
            fit.position,
            (fit.k_n, k_t, k_i),
            slip_border_of(contact, side, fit.position),
        ),
        dissipation=float(
            _over_cycle(solution, contact.dissipation)[outer if number == 0 else ~outer].sum()
        ),
    )


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


def _warnings(contact: ContactHistory, edges: tuple[Edge, ...], change: float) -> tuple[str, ...]:
    warnings = []
    closed = contact.status != OPEN
    if not closed.any():
        smallest = contact.gap.min()
        warnings.append(f"the surfaces never touch; the smallest gap is {smallest:.4g}")
    for end, place in ((0, "left"), (-1, "right")):
        if closed[:, end].any():
            warnings.append(
                f"the contact reaches the {place} end of its surface: extend the physical group, "
                "the edge there is not that of the contact"
            )
    if change >= STEADY_CHANGE:
        warnings.append(
            f"not in steady state: the shear changes by {change:.2g} f p_max over the evaluated "
            "cycle; add cycles"
        )
    for edge in edges:
        if edge.uncertain:
            warnings.append(
                f"K_N at the {edge.side} edge is {edge.k_n[-1]:.3g} ± {edge.k_n_spread[-1]:.2g}: "
                "refine the mesh at this edge"
            )
        if any(zone.gross for zone in edge.slip_zones[-2:]):
            warnings.append(f"gross slip in the last half cycles ({edge.side} edge)")
        elif any(not zone.resolved for zone in edge.slip_zones[-2:]):
            warnings.append(f"the {edge.side} slip zone is not resolved by the mesh")
    return tuple(warnings)
