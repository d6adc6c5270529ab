# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors, slip zones and resultants of a solved history.

For plane contacts, whose nodes form one line. K_T and K_I are counted from the first state: they
add up the companion increments over the steps, each with the mean of the contact areas before and
after it. K_T counts only steps with friction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fretfe.analytic.edges import slip_length_first_loading
from fretfe.edges import (
    OVERHANG,
    Side,
    bonded_factors,
    cycle_change,
    edge_factor_k_t,
    fit_edge,
    main_patch,
    predicted_slip,
    resultants,
    slip_border,
)
from fretfe.loads import turning_points
from fretfe.solution import OPEN, SLIP, ContactHistory, Solution

Array = npt.NDArray[np.float64]
SIDES: tuple[Side, Side] = ("left", "right")

# Change of the shear from one cycle to the next, relative to f p_max, below which it is steady.
STEADY_CHANGE = 1e-3
# Nodes whose slip in a half cycle is below this fraction of the largest slip have not slipped.
SMALLEST_SLIP = 1e-6
# The history ends with a complete half cycle if K_T is this close to its extreme, as a fraction of
# its range.
AT_EXTREME = 1e-2
# Fewer nodes than this in contact cannot be fitted.
FEWEST_NODES = 16


@dataclass(frozen=True)
class SlipZone:
    """Slip between two successive reversals of K_T at one edge.

    Attributes:
        start, end: states between which the nodes slipped.
        length: slip-zone length from the edge at `end`, inward; NaN if the whole contact slipped.
        border: position of its inner end along the arc.
        resolved: whether the mesh resolves the zone.
        gross: whether the whole contact slipped.
        predicted: slip length from K_T and K_N: 2 K_T/(f K_N) for first loading, ΔK_T/(f K_N) in
            the evaluated cycle; NaN elsewhere.
        predicted_loop: the same with varying normal load, from `end`; NaN outside the cycle.
    """

    start: int
    end: int
    length: float
    border: float
    resolved: bool
    gross: bool
    predicted: float
    predicted_loop: float


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
    fits = _fit_edges(contact)
    positions, factors, spreads = fits[..., 0], fits[..., 1], fits[..., 3]
    centre = positions.mean(axis=0)
    histories = _edge_histories(solution, contact, positions)
    edges = tuple(
        _evaluate_edge(
            solution, contact, side, positions[i], factors[i], spreads[i], histories[i], centre
        )
        for i, side in enumerate(SIDES)
    )
    totals = [
        resultants(contact.arc, t[:, 0], t[:, 1], c if np.isfinite(c) else 0.0)
        for t, c in zip(contact.traction, centre, strict=True)
    ]
    change = _cycle_change(solution, contact)
    return ContactSummary(
        name=contact.name,
        edges=(edges[0], edges[1]),
        normal_force=np.array([r.normal_force for r in totals]),
        shear_force=np.array([r.shear_force for r in totals]),
        moment=np.array([r.moment for r in totals]),
        centre=centre,
        half_width=(positions[1] - positions[0]) / 2,
        cycle_change=change,
        steady=bool(change < STEADY_CHANGE),
        dissipation=float(_over_cycle(solution, contact.dissipation).sum()),
        warnings=_warnings(contact, edges, change),
    )


def _fit_edges(contact: ContactHistory) -> Array:
    """(2, T, 4) position, K_N and their spreads at both edges."""
    fits = np.full((2, len(contact.traction), 4), np.nan)
    for state, traction in enumerate(contact.traction):
        if np.count_nonzero(traction[:, 0] > 0) < FEWEST_NODES:
            continue
        for i, side in enumerate(SIDES):
            fit = fit_edge(contact.arc, traction[:, 0], side)
            fits[i, state] = fit.position, fit.k_n, fit.spread_position, fit.spread_k_n
    return fits


def _edge_histories(solution: Solution, contact: ContactHistory, positions: Array) -> Array:
    """(2, T, 2) K_T and K_I at both edges."""
    count = len(solution.times)
    units = _unit_factors(solution, contact, positions)
    histories = np.zeros((2, count, 2))
    for state in range(1, count):
        step = solution.driver_values[state] - solution.driver_values[state - 1]
        known = [units[s] for s in (state - 1, state) if np.isfinite(units[s]).all()]
        increment = np.mean(known, axis=0) @ step if known else np.zeros((2, 2))
        increment[:, 0] *= contact.friction[state] > 0
        histories[:, state] = histories[:, state - 1] + increment
    return histories


def _unit_factors(solution: Solution, contact: ContactHistory, positions: Array) -> Array:
    """(T, 2, 2, J) edge (left, right), factor (K_T, K_I) for a unit of each driver."""
    count, drivers = len(solution.times), len(solution.drivers)
    factors = np.full((count, 2, 2, drivers), np.nan)
    by_area: dict[int, Array] = {}
    for state in range(count):
        area = int(contact.bonded.area[state])
        if area < 0 or not np.isfinite(positions[:, state]).all():
            continue
        if area not in by_area:
            edges = (float(positions[0, state]), float(positions[1, state]))
            by_area[area] = _area_factors(contact, area, edges, OVERHANG[solution.degree])
        factors[state] = by_area[area]
    return factors


def _area_factors(
    contact: ContactHistory, area: int, edges: tuple[float, float], overhang: float
) -> Array:
    """(2, 2, J) unit factors of one contact area."""
    fields = contact.bonded.fields[area]
    factors = np.zeros((2, 2, fields.shape[2]))
    largest = np.abs(fields).max(axis=(0, 1))
    for driver in range(fields.shape[2]):
        for component, row in ((1, 0), (0, 1)):  # shear gives K_T, pressure gives K_I
            field = fields[:, component, driver]
            if np.abs(field).max() <= 1e-9 * largest[driver]:
                continue  # no effect but round-off, for instance of a distant load
            left, right = bonded_factors(contact.arc, field, edges, overhang)
            if component == 1:
                pair = edge_factor_k_t(left.k, "left"), edge_factor_k_t(right.k, "right")
            else:
                pair = left.k, right.k
            factors[:, row, driver] = pair
    return factors


def _evaluate_edge(
    solution: Solution,
    contact: ContactHistory,
    side: Side,
    position: Array,
    k_n: Array,
    k_n_spread: Array,
    history: Array,
    centre: Array,
) -> Edge:
    k_t, k_i = history.T
    cycle = _cycle_states(solution)
    reference = cycle[-1] if len(cycle) else -1
    outer = contact.arc < centre[reference]
    mine = outer if side == "left" else ~outer
    return Edge(
        side=side,
        position=position,
        k_n=k_n,
        k_n_spread=k_n_spread,
        k_t=k_t,
        k_i=k_i,
        k_t_range=float(np.ptp(k_t[cycle])) if len(cycle) else np.nan,
        k_i_range=float(np.ptp(k_i[cycle])) if len(cycle) else np.nan,
        slip_zones=_slip_zones(solution, contact, side, position, k_n, k_t, k_i),
        dissipation=float(_over_cycle(solution, contact.dissipation)[mine].sum()),
    )


def _cycle_states(solution: Solution) -> npt.NDArray[np.int64]:
    """States of the evaluated cycle, first and last included; empty without a cycle."""
    if solution.cycle is None:
        return np.array([], dtype=np.int64)
    return np.arange(solution.cycle[0], solution.cycle[1] + 1)


def _over_cycle(solution: Solution, per_step: Array) -> Array:
    """Sum of a quantity of each step over the evaluated cycle, or over everything without one."""
    cycle = _cycle_states(solution)
    return per_step[cycle[1:]].sum(axis=0) if len(cycle) else per_step.sum(axis=0)


def _slip_zones(
    solution: Solution,
    contact: ContactHistory,
    side: Side,
    position: Array,
    k_n: Array,
    k_t: Array,
    k_i: Array,
) -> tuple[SlipZone, ...]:
    frictional = np.flatnonzero((contact.friction > 0) & np.isfinite(position))
    if not len(frictional):
        return ()
    first, last = int(frictional[0]) - 1, len(k_t) - 1
    turns = first + turning_points(k_t[first:])
    ends = [int(turn) for turn in turns if first < turn < last]
    if not ends or _at_extreme(solution, k_t, last):
        ends.append(last)
    zones = []
    for number, (start, end) in enumerate(zip([first, *ends[:-1]], ends, strict=True)):
        if not np.isfinite(position[end]):
            continue
        border = _border(contact, side, start, end, float(position[end]))
        cyclic, loop = _prediction(solution, contact, start, end, k_n, k_t, k_i)
        if number == 0:
            rise = abs(k_t[end] - k_t[first])
            cyclic = float(slip_length_first_loading(rise, k_n[end], contact.friction[end]))
        inward = 1.0 if side == "left" else -1.0
        zones.append(
            SlipZone(
                start=start,
                end=end,
                length=border.length,
                border=float(position[end]) + inward * border.length,
                resolved=border.resolved,
                gross=border.gross,
                predicted=cyclic,
                predicted_loop=loop,
            )
        )
    return tuple(zones)


def _at_extreme(solution: Solution, k_t: Array, state: int) -> bool:
    """Whether K_T is at its largest or smallest of the cycle: the half cycle is complete."""
    cycle = _cycle_states(solution)
    history = k_t[cycle] if len(cycle) else k_t
    distance = min(history.max() - k_t[state], k_t[state] - history.min())
    return bool(distance < AT_EXTREME * np.ptp(history))


def _border(contact: ContactHistory, side: Side, start: int, end: int, edge: float):  # type: ignore[no-untyped-def]
    """Slip zone between two states, from the slip that happened while in contact."""
    steps = np.arange(start + 1, end + 1)
    slipping = contact.status[steps] == SLIP
    increments = contact.slip[steps, :, 0] - contact.slip[steps - 1, :, 0]
    slip = np.where(slipping, increments, 0.0).sum(axis=0)
    closed = contact.status[end] != OPEN
    patch = main_patch(contact.arc, contact.traction[end, :, 0])
    closed[: patch.first] = closed[patch.last + 1 :] = False
    moved = np.abs(slip) > SMALLEST_SLIP * np.abs(slip).max()
    return slip_border(contact.arc[closed], slip[closed], moved[closed], edge, side)


def _prediction(
    solution: Solution,
    contact: ContactHistory,
    start: int,
    end: int,
    k_n: Array,
    k_t: Array,
    k_i: Array,
) -> tuple[float, float]:
    """Slip length by ΔK_T/(f K_N) and by the general loop, if the zone is in the cycle."""
    cycle = _cycle_states(solution)
    if not len(cycle) or end <= cycle[0] or not np.isfinite(k_n[end]):
        return np.nan, np.nan
    states = cycle if end in cycle else np.append(cycle, end)
    reference = int(np.flatnonzero(states == end)[0])
    predicted = predicted_slip(
        k_t[states], k_i[states], float(k_n[end]), float(contact.friction[end]), reference
    )
    return predicted.cyclic, predicted.loop


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
        if any(zone.gross for zone in edge.slip_zones[-2:]):
            warnings.append(f"gross slip in the last half cycles ({edge.side} edge)")
        elif any(not zone.resolved for zone in edge.slip_zones[-2:]):
            warnings.append(f"the {edge.side} slip zone is not resolved by the mesh")
    return tuple(warnings)
