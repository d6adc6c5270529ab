# SPDX-License-Identifier: LGPL-3.0-or-later
"""Summary of every contact of a solution: resultants, edges, slip zones, warnings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fretfe.edges import EdgeFit, Side, cycle_change, resultants
from fretfe.evaluate.factors import SIDES, edge_fits, edge_histories
from fretfe.evaluate.slip_zones import SlipZone, cycle_states, slip_zones
from fretfe.solution import OPEN, ContactHistory, Solution

Array = npt.NDArray[np.float64]

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
        k_t_range: range of K_T over the evaluated cycle, NaN without one.
        k_i_range: the same for K_I.
        slip_zones: one for each half cycle, in time order.
        dissipation: friction work at this edge in the evaluated cycle, per unit thickness.
    """

    side: Side
    position: Array
    k_n: Array
    k_n_spread: Array
    k_t: Array
    k_i: Array
    k_t_range: float
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
        cycle_change: change of the shear over the evaluated cycle relative to f p_max.
        steady: whether that is below the limit; False without a cycle.
        dissipation: friction work in the evaluated cycle, per unit thickness.
        warnings: what a reader must know, in words.
    """

    name: str
    edges: tuple[Edge, Edge]
    normal_force: Array
    shear_force: Array
    moment: Array
    centre: Array
    half_width: Array
    cycle_change: float
    steady: bool
    dissipation: float
    warnings: tuple[str, ...]


def evaluate(solution: Solution) -> tuple[ContactSummary, ...]:
    """Evaluate every contact of a solution."""
    return tuple(_evaluate_contact(solution, contact) for contact in solution.contacts)


def _evaluate_contact(solution: Solution, contact: ContactHistory) -> ContactSummary:
    fits = edge_fits(contact)
    positions = np.array([fit.position for fit in fits])
    centre = positions.mean(axis=0)
    histories = edge_histories(solution, contact, positions)
    edges = tuple(
        _evaluate_edge(solution, contact, side, fit, history, centre)
        for side, fit, history in zip(SIDES, fits, histories, strict=True)
    )
    # The weights are those of the solution itself: P and Q balance the loads to round-off.
    forces = np.einsum("n,tnc->tc", contact.weights, contact.traction)
    moments = [
        resultants(contact.arc, t[:, 0], t[:, 1], c if np.isfinite(c) else 0.0).moment
        for t, c in zip(contact.traction, centre, strict=True)
    ]
    change = _cycle_change(solution, contact)
    return ContactSummary(
        name=contact.name,
        edges=(edges[0], edges[1]),
        normal_force=forces[:, 0],
        shear_force=forces[:, 1],
        moment=np.array(moments),
        centre=centre,
        half_width=(positions[1] - positions[0]) / 2,
        cycle_change=change,
        steady=bool(change < STEADY_CHANGE),
        dissipation=float(_over_cycle(solution, contact.dissipation).sum()),
        warnings=_warnings(contact, edges, change),
    )


def _evaluate_edge(
    solution: Solution,
    contact: ContactHistory,
    side: Side,
    fit: EdgeFit,
    history: Array,
    centre: Array,
) -> Edge:
    k_t, k_i = history.T
    cycle = cycle_states(solution)
    reference = cycle[-1] if len(cycle) else -1
    outer = contact.arc < centre[reference]
    mine = outer if side == "left" else ~outer
    return Edge(
        side=side,
        position=fit.position,
        k_n=fit.k_n,
        k_n_spread=fit.spread_k_n,
        k_t=k_t,
        k_i=k_i,
        k_t_range=float(np.ptp(k_t[cycle])) if len(cycle) else np.nan,
        k_i_range=float(np.ptp(k_i[cycle])) if len(cycle) else np.nan,
        slip_zones=slip_zones(solution, contact, side, fit.position, fit.k_n, k_t, k_i),
        dissipation=float(_over_cycle(solution, contact.dissipation)[mine].sum()),
    )


def _over_cycle(solution: Solution, per_step: Array) -> Array:
    """Sum of a quantity of each step over the evaluated cycle, or over everything without one."""
    cycle = cycle_states(solution)
    return per_step[cycle[1:]].sum(axis=0) if len(cycle) else per_step.sum(axis=0)


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
