# SPDX-License-Identifier: LGPL-3.0-or-later
"""Factor histories of a plane contact: position and K_N by fits, K_T and K_I by increments.

K_T and K_I add up the increments of full stick over the steps, each with the mean of the contact
areas before and after it; K_T counts only steps with friction. They are counted from the first
state, or from the last one before the cycle at which an increment is unknown: what is not known is
NaN, never zero.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.edges.counting import count_up
from fretfe.edges.full_stick import OVERHANG, effective_edges, full_stick_factors
from fretfe.edges.patches import main_patch
from fretfe.edges.pressure import FEWEST_NODES, EdgeFit, fit_edge
from fretfe.edges.section import PLANE_FRONTS, PlaneFront, plane_sections
from fretfe.results.solution import ContactHistory, Factor, Solution
from fretfe.results.states import MOST_STATES, blocks

# Edges that move less than this fraction of the surface between two loads do not tell anything.
SMALLEST_MOVE = 1e-6
# Nodes in contact that factors and useful error bars need: as many as fits to full stick.
WANTED_NODES = 16


def edge_fits(contact: ContactHistory, source: Indices) -> tuple[EdgeFit, ...]:
    """Position and K_N with their spreads at each front; NaN where they cannot be fitted.

    Args:
        contact: one contact.
        source: (T,) the state that each state is the same as.
    """
    states = np.unique(source)
    parts = np.full((len(PLANE_FRONTS), len(fields(EdgeFit)), len(states)), np.nan)
    for block in blocks(len(states), contact.traction[0].size):
        pressure = contact.traction[states[block], :, 0]
        fitted = np.count_nonzero(pressure > 0, axis=1) >= FEWEST_NODES
        there = block.start + np.flatnonzero(fitted)
        for front, section in enumerate(plane_sections(contact.arc, pressure[fitted])):
            parts[front][:, there] = astuple(fit_edge(section))
    known = parts[..., np.searchsorted(states, source)]
    return tuple(EdgeFit(*front) for front in known)


def add_up(
    units: Array,
    drivers: Array,
    friction: Array,
    touching: Bools,
    cycle: tuple[int, int] | None,
) -> Array:
    """(stations, T, d) singular factors at each station, in the order of `Factor`.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        drivers: (T, J) values of the drivers.
        friction: (T,) coefficient in the step that ends at each state.
        touching: (T,) states in which there is contact.
        cycle: its first and last state, or None.
    """
    steps = np.diff(drivers, axis=0)
    increments = _mean_of_ends(units, steps)[0]
    increments[~steps.any(axis=1) | ~(touching[1:] | touching[:-1])] = 0.0
    increments[friction[1:] == 0, :, Factor.K_T :] = 0.0
    return count_up(increments, cycle).swapaxes(0, 1)


def _mean_of_ends(units: Array, steps: Array) -> tuple[Array, Bools]:
    """(n, stations, d) what n steps add, and (n,) whether factors are known at one end only.

    The mean of what the factors at both ends give, or what those of the known end do.

    Args:
        units: (n + 1, stations, d, J) factors for a unit of each driver; NaN where unknown.
        steps: (n, J) increments of the drivers.
    """
    known = np.isfinite(units).all(axis=(1, 2, 3))
    ends = [np.einsum("tsdj,tj->tsd", each, steps) for each in (units[:-1], units[1:])]
    both, first, last = known[:-1] & known[1:], known[:-1], known[1:]
    found = np.where(first[:, None, None], ends[0], np.where(last[:, None, None], ends[1], np.nan))
    return np.where(both[:, None, None], (ends[0] + ends[1]) / 2, found), first ^ last


def one_sided_share(units: Array, drivers: Array, cycle: tuple[int, int] | None) -> Array:
    """(stations,) half of what the steps of a cycle add to K_T of which one end only is known.

    Their increments take the factors of that end for those of both, and factors may change as much
    within a step as over it where the contact is about to open or hardly resolved.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        drivers: (T, J) values of the drivers.
        cycle: its first and last state, or None.
    """
    if cycle is None:
        return np.zeros(units.shape[1])
    states = slice(cycle[0], cycle[1] + 1)
    increments, one_end = _mean_of_ends(units[states], np.diff(drivers[states], axis=0))
    return np.asarray(np.abs(increments[one_end, :, Factor.K_T]).sum(axis=0) / 2)


@dataclass(frozen=True)
class UnitFactors:
    """Singular factors, as `Factor`, for a unit of each of J drivers; NaN where unknown.

    Attributes:
        main: for each of R ways to determine them: (T, stations, d, J). They are made one after
            the other, and only once.
        fitted: (T, stations, d, J) by fits to tractions, as a check; None without them.
        exact: True for closed forms.
    """

    main: Iterable[Array]
    fitted: Array | None = None
    exact: bool = False


def full_stick_units(
    solution: Solution, contact: ContactHistory, positions: Array, overhang: float
) -> Array:
    """(T, stations, d, J) unit factors, fitted to the tractions of full stick; NaN where unknown.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        positions: (stations, T) along the arc.
        overhang: of the increments.
    """
    shape = (len(solution.times), len(positions), *contact.full_stick.fields.shape[2:])
    factors = np.full(shape, np.nan)
    areas = np.where(positions[1] > positions[0], contact.full_stick.area, -1)
    order = np.argsort(areas, kind="stable")
    for states in np.split(order, np.flatnonzero(np.diff(areas[order])) + 1):
        if areas[states[0]] < 0:
            continue
        fields = contact.full_stick.fields[areas[states[0]]]
        for first in range(0, len(states), MOST_STATES):
            some = states[first : first + MOST_STATES]
            edges = positions[:, some].T
            factors[some] = _area_factors(contact.arc, fields, edges, overhang)
    return factors


def integral_units(solution: Solution, contact: ContactHistory, positions: Array) -> UnitFactors:
    """Unit factors by the interaction integral, for each of its R radii, and by fits.

    The integrals are taken at a few contact areas; what the fits miss there is interpolated over
    the half-width to the other states. Without integrals there are only the fits, and no check.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        positions: (stations, T) along the arc.
    """
    fits = full_stick_units(solution, contact, positions, OVERHANG[solution.degree])
    integrals = contact.integrals
    if integrals is None:
        return UnitFactors([fits])
    fitted = np.array([_at_own_edges(solution, contact, int(area)) for area in integrals.areas])
    missed = integrals.factors - fitted[:, None]
    half_widths = (integrals.positions[:, 1] - integrals.positions[:, 0]) / 2
    order = np.argsort(half_widths)
    half_width = (positions[1] - positions[0]) / 2

    def by_way(way: int) -> Array:
        factors = _interpolate(half_width, half_widths[order], missed[order, way])
        for number, area in enumerate(integrals.areas):
            factors[contact.full_stick.area == area] = missed[number, way]
        factors += fits
        # Few elements carry an integral where they carry no fit.
        lost = ~np.isfinite(factors).all(axis=(1, 2, 3))
        if lost.any():
            alone = integrals.factors[order, way]
            filled = _interpolate(half_width[lost], half_widths[order], alone)
            factors[lost] = np.where(np.isfinite(factors[lost]), factors[lost], filled)
        return factors

    return UnitFactors(map(by_way, range(len(integrals.reaches))), fits)


def _at_own_edges(solution: Solution, contact: ContactHistory, area: int) -> Array:
    """(stations, d, J) fitted unit factors of an area at the edges that its increments have.

    The edges of a discrete increment are a fraction of an element away from those of the contact,
    and the integral is that of the increment.
    """
    fields, overhang = contact.full_stick.fields[area], OVERHANG[solution.degree]
    edges = effective_edges(contact.arc, fields.transpose(1, 2, 0), overhang)
    return _area_factors(contact.arc, fields, edges[None], overhang)[0]


@dataclass(frozen=True)
class Movement:
    """Movement of an edge between two loads, as factors; NaN if it does not move.

    Attributes:
        k_n: 2 dK_I/da. Needs no assumption about the profile; exact for a small step (central
            difference).
        k_n_spread: error bar of it: of the places of the edge, and the difference between the ways
            to find K_I.
        stiffening: (d2P/da2)/(dP/da) = d ln K_N/da + 1/(2a), by K_N = (1/pi) sqrt(2/a) dP/da.
    """

    k_n: float
    k_n_spread: float
    stiffening: float


def edge_movement(contact: ContactHistory, front: PlaneFront, half_width: float) -> Movement:
    """Movement of an edge between the two neighbours of the last state, whose half-width is given.

    NaN if the edge does not move, or reaches the end of the surface.
    """
    unknown = Movement(np.nan, np.nan, np.nan)
    neighbours = contact.neighbours
    if neighbours is None or np.any(neighbours.pressure[:, [0, -1]] > 0):
        return unknown
    if np.count_nonzero(neighbours.pressure > 0, axis=1).min() < FEWEST_NODES:
        return unknown
    patches = [main_patch(contact.arc, pressure) for pressure in neighbours.pressure]
    fit = fit_edge(front.section(contact.arc, neighbours.pressure, patches))
    outward = -front.inward * float(fit.position[1] - fit.position[0])
    if not outward > SMALLEST_MOVE * np.ptp(contact.arc):
        return unknown
    # The last way is the one with the largest circle, which the edge stays away from.
    k_i = float(neighbours.k_i[-1, front.number])
    growth = float(np.log(fit.k_n[1] / fit.k_n[0]) / outward)
    k_n = 2 * k_i / outward
    shift = float(np.linalg.norm(fit.spread_position)) / outward
    spread = abs(k_n) * shift + float(np.ptp(neighbours.k_i[:, front.number])) / outward
    return Movement(k_n, spread, growth + 0.5 / half_width)


def _interpolate(at: Array, x: Array, values: Array) -> Array:
    """(T, ...) values (S, ...) known at x (S,), linear between them and constant outside."""
    upper = np.clip(np.searchsorted(x, at), 1, max(len(x) - 1, 1))
    lower, upper = upper - 1, np.minimum(upper, len(x) - 1)
    width = np.where(upper > lower, x[upper] - x[lower], 1.0)
    share = np.clip((at - x[lower]) / width, 0.0, 1.0)
    share = share.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray((1 - share) * values[lower] + share * values[upper])


def _area_factors(arc: Array, fields: Array, edges: Array, overhang: float) -> Array:
    """(S, stations, d, J) unit factors of S states with the same contact area.

    Args:
        arc: (N,) nodes.
        fields: (N, d, J) traction for a unit of each driver.
        edges: (S, stations) positions.
        overhang: of the increments.
    """
    factors = np.zeros((*edges.shape, *fields.shape[1:]))
    increments = fields.transpose(1, 2, 0)
    largest = np.abs(fields).max(axis=(0, 1))
    # Less than that is round-off, for instance of a distant load.
    effective = np.abs(increments).max(axis=2) > 1e-9 * largest
    if not effective.any():
        return factors
    fits = full_stick_factors(arc, increments[effective], edges, overhang)
    for front, fit in zip(PLANE_FRONTS, fits, strict=True):
        factors[:, front.number, effective] = fit.k
        factors[:, front.number, Factor.K_T] *= front.inward
    return factors
