# SPDX-License-Identifier: LGPL-3.0-or-later
"""Factor histories: position and K_N by fits, K_T, K_S and K_I by increments; their error bars.

The factors of shear add up the increments of full stick over the steps, each with the mean of the
contact areas before and after it; only steps with friction count. They are counted from the first
state, or from the last one before the cycle at which an increment is unknown: what is not known is
NaN, never zero.

The loads are known at any time, edge factors only at the ends of steps. Within a step a factor
leaves the straight line between its ends by as much as the loads leave theirs, times what a unit of
each load changes it by in this cycle (least squares over its steps; exact for factors that are
linear in the loads, as at a constant contact area).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.edges import (
    at_length,
    full_stick_factor,
    oscillation,
    shear_moment,
    sliding_exponent,
)
from fretfe.evaluate.contacts import LARGEST_SPREAD, RangeSpread
from fretfe.evaluate.numerics import count_up
from fretfe.evaluate.plane.full_stick_fit import OVERHANG, effective_edges, full_stick_factors
from fretfe.evaluate.plane.pressure_fit import (
    FEWEST_NODES,
    RISEN,
    EdgeFit,
    fit_edge,
)
from fretfe.evaluate.plane.section import (
    PLANE_FRONTS,
    PlaneFront,
    main_patch,
    plane_sections,
)
from fretfe.history.solution import ContactHistory, Factor, Solution
from fretfe.history.state_array import MOST_STATES

# Edges that move less than this fraction of the surface between two loads do not tell anything.
SMALLEST_MOVE = 1e-6
# Nodes in contact that factors and useful error bars need: as many as fits to full stick.
WANTED_NODES = 16
# Between unlike bodies K_T and K_I are those at these parts of the reference length: with K_N at
# the length of the slip zone (11) then holds to first order in f beta. K_N(d) exceeds that of the
# mean of both ends of the cycle by (2 - 2 ln 2) f beta/pi, and that has f d K_N = dK_T + f dK_I(d)
# + (1 + 2 ln 2) f beta/pi dK_T: together K_I at exp(-3) d. At the border of stick the traction of
# full stick counts with 1/sqrt(s (d - s)), over which the mean of ln s is ln(d/4).
K_T_LENGTH = 0.25
K_I_LENGTH = math.exp(-3)
# A slip zone of which nothing is known is taken for so long, in half-widths.
UNKNOWN_ZONE = 0.1
# Iterations for the reference length, which hardly matters.
LENGTH_ITERATIONS = 5
# Loads that leave the straight line by less than this part of their range are lines.
STRAIGHT = 1e-9
# Components of a direction below this are round-off.
ROUND_OFF = 1e-9
# The edge of a discrete contact area may lie anywhere in an element, half of it to either side with
# equal chance: nineteen of twenty are nearer than this.
WITHIN_ELEMENT = 0.475
# Half-planes know the forces on an element exactly; elements that grow inward leave the edge open
# by this part of the smallest ones. Measured: .01 with 300 elements on all profiles.
WITHIN_GRID = 0.02


def add_up(
    units: Array,
    drivers: Array,
    friction: Bools,
    touching: Bools,
    cycle: tuple[int, int] | None,
    unlike: bool = False,
) -> Array:
    """(stations, T, d) singular factors at each station, in the order of `Factor`.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        drivers: (T, J) values of the drivers.
        friction: (T,) whether there is any in the step that ends at each state.
        touching: (T,) states in which there is contact.
        cycle: its first and last state, or None.
        unlike: whether the bodies are: K_I and K_T are then one number, and counted together.
    """
    steps = np.diff(drivers, axis=0)
    increments = _mean_of_ends(units, steps)
    increments[~steps.any(axis=1) | ~(touching[1:] | touching[:-1])] = 0.0
    increments[~friction[1:], :, 0 if unlike else Factor.K_T :] = 0.0
    return count_up(increments, cycle).swapaxes(0, 1)


def _mean_of_ends(units: Array, steps: Array) -> Array:
    """(n, stations, d) what n steps add.

    The mean of what the factors at both ends give, or what those of the known end do.

    Args:
        units: (n + 1, stations, d, J) factors for a unit of each driver; NaN where unknown.
        steps: (n, J) increments of the drivers.
    """
    known = np.isfinite(units).all(axis=(1, 2, 3))
    ends = [np.einsum("tsdj,tj->tsd", each, steps) for each in (units[:-1], units[1:])]
    both, first, last = known[:-1] & known[1:], known[:-1], known[1:]
    found = np.where(first[:, None, None], ends[0], np.where(last[:, None, None], ends[1], np.nan))
    return np.where(both[:, None, None], (ends[0] + ends[1]) / 2, found)


def within_known(units: Array, step: Indices | None) -> Array:
    """Units of all states, those unknown within a step taken from the next known state in it.

    Where none follows, from the last one before, back to the end of the step before: as far as a
    contact that touches or opens is too small to tell its factors, a divided step counts like an
    undivided one, with the factors of the end that is known.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        step: (T,) number of the step in which each state lies; None if each is the end of one.
    """
    if step is None:
        return units
    count = len(units)
    states, known = np.arange(count), np.isfinite(units).all(axis=(1, 2, 3))
    inside = np.append(step[1:] == step[:-1], False)
    later = np.minimum.accumulate(np.where(known, states, count)[::-1])[::-1]
    earlier = np.maximum.accumulate(np.where(known, states, -1))
    follows = (later < count) & (step[np.minimum(later, count - 1)] == step)
    begin = np.searchsorted(step, step) - 1
    precedes = (earlier >= 0) & (earlier >= begin)
    source = np.where(follows, later, np.where(precedes, earlier, states))
    return np.asarray(units[np.where(inside & ~known, source, states)])


def one_sided_share(
    units: Array, filled: Array, drivers: Array, cycle: tuple[int, int] | None
) -> Array:
    """(stations,) half of what the steps of a cycle add to |K| of which one end only is known.

    Their increments take the factors of that end for those of both, and factors may change as much
    within a step as over it where the contact is about to open or hardly resolved.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        filled: the same, as of `within_known`.
        drivers: (T, J) values of the drivers.
        cycle: its first and last state, or None.
    """
    if cycle is None:
        return np.zeros(units.shape[1])
    states = slice(cycle[0], cycle[1] + 1)
    known = np.isfinite(units[states]).all(axis=(1, 2, 3))
    steps = np.diff(drivers[states], axis=0)
    increments = _mean_of_ends(filled[states], steps)[:, :, Factor.K_T :]
    increments = np.linalg.norm(increments, axis=2)
    one_end = ~(known[1:] & known[:-1]) & np.isfinite(increments).all(axis=1)
    return np.asarray(increments[one_end].sum(axis=0) / 2)


def uneven_share(
    units: Array, drivers: Array, friction: Bools, cycle: tuple[int, int] | None
) -> Array:
    """(stations,) error bar by what the steps of a cycle may be wrong by in |K| as an edge moves.

    Within a step the factors for a unit of a load change as the edge moves, and not evenly. The
    mean of both ends exceeds their harmonic mean by du^2/(2 (u1 + u2)); for loads on a line and any
    movement of the edge of a cylinder or a wedge the truth is below by no more than twice that
    (P up to 40 times as large at one end of the step: 1.5 and 1.9 times). Flats with rounded ends
    need more (P three times as large at one end: 2.3 times du^2/(2 (u1 + u2))).

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        drivers: (T, J) values of the drivers.
        friction: (T,) whether there is any in the step that ends at each state.
        cycle: its first and last state, or None.
    """
    if cycle is None:
        return np.zeros(units.shape[1])
    states = slice(cycle[0], cycle[1] + 1)
    factors, steps = units[states, :, Factor.K_T :], np.diff(drivers[states], axis=0)
    shear, change = (
        np.linalg.norm(factors, axis=2),
        np.linalg.norm(np.diff(factors, axis=0), axis=2),
    )
    size = shear[1:] + shear[:-1]
    uneven = np.divide(change**2, size, where=size > 0, out=np.zeros_like(size))
    steps[~friction[states][1:]] = 0.0
    errors = np.einsum("tsj,tj->ts", np.nan_to_num(uneven), np.abs(steps))
    return np.asarray(1.5 * errors.sum(axis=0))


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
            factors[some] = _area_factors(contact.surface.arc, fields, edges, overhang)
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
        return UnitFactors([np.full_like(fits, np.nan) if contact.surface.dundurs else fits])
    fitted = np.array([_at_own_edges(solution, contact, int(area)) for area in integrals.areas])
    half_widths = (integrals.positions[:, 1] - integrals.positions[:, 0]) / 2
    # The fits know nothing of beta: they see K of unlike bodies at a length in proportion to a.
    beta = contact.surface.dundurs
    own = rotated(integrals.factors, beta, half_widths)
    missed = own - fitted[:, None]
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
            alone = own[order, way]
            filled = _interpolate(half_width[lost], half_widths[order], alone)
            factors[lost] = np.where(np.isfinite(factors[lost]), factors[lost], filled)
        return rotated(factors, beta, 1 / half_width)

    checks = None if beta else fits
    return UnitFactors(map(by_way, range(len(integrals.reaches))), checks)


def rotated(units: Array, dundurs: float, ratio: Array) -> Array:
    """Unit factors (n, ..., d, J) of unlike bodies at lengths that are ratios (n,) of theirs."""
    if not dundurs:
        return units
    ratio = ratio.reshape(-1, *[1] * (units.ndim - 2))
    whole = units[..., Factor.K_I, :] + 1j * units[..., Factor.K_T, :]
    turned = at_length(whole, oscillation(dundurs), ratio)
    found = units.copy()
    found[..., Factor.K_I, :], found[..., Factor.K_T, :] = turned.real, turned.imag
    return found


def _at_own_edges(solution: Solution, contact: ContactHistory, area: int) -> Array:
    """(stations, d, J) fitted unit factors of an area at the edges that its increments have.

    The edges of a discrete increment are a fraction of an element away from those of the contact,
    and the integral is that of the increment.
    """
    fields, overhang = contact.full_stick.fields[area], OVERHANG[solution.degree]
    edges = effective_edges(contact.surface.arc, fields.transpose(1, 2, 0), overhang)
    return _area_factors(contact.surface.arc, fields, edges[None], overhang)[0]


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


def edge_movement(
    contact: ContactHistory, front: PlaneFront, half_width: float, exponent: float = 0.5
) -> Movement:
    """Movement of an edge between the two neighbours of the last state, whose half-width is given.

    NaN if the edge does not move, or reaches the end of the surface. Between unlike bodies, whose
    edges shear moves as well, K_N is NaN, and the growth is that of the pressure behind the edge,
    which falls like s^exponent.
    """
    unknown = Movement(np.nan, np.nan, np.nan)
    neighbours = contact.nearby_loads
    if neighbours is None or np.any(neighbours.pressure[:, [0, -1]] > 0):
        return unknown
    if np.count_nonzero(neighbours.pressure > 0, axis=1).min() < FEWEST_NODES:
        return unknown
    if contact.surface.dundurs:
        return Movement(np.nan, np.nan, _growth_behind(contact, front, half_width, exponent))
    patches = [main_patch(contact.surface.arc, pressure) for pressure in neighbours.pressure]
    fit = fit_edge(front.section(contact.surface.arc, neighbours.pressure, patches), solved=True)
    outward = -front.inward * float(fit.position[1] - fit.position[0])
    if not outward > SMALLEST_MOVE * np.ptp(contact.surface.arc):
        return unknown
    # The last way is the one with the largest circle, which the edge stays away from.
    k_i = float(neighbours.k_i[-1, front.number])
    growth = float(np.log(fit.k_n[1] / fit.k_n[0]) / outward)
    k_n = 2 * k_i / outward
    shift = float(np.linalg.norm(fit.spread_position)) / outward
    # If the edge moved less than it seems by as much, K_N is larger by more than that.
    between = shift / (1 - shift) if shift < 1 else np.inf
    spread = abs(k_n) * between + float(np.ptp(neighbours.k_i[:, front.number])) / outward
    return Movement(k_n, spread, growth + 0.5 / half_width)


def _growth_behind(
    contact: ContactHistory, front: PlaneFront, half_width: float, exponent: float
) -> float:
    """(d2P/da2)/(dP/da) between unlike bodies, from the pressure of the last state behind an edge.

    With dP/da growing at the relative rate g a symmetric
    contact of half-planes has p^2 = K_N^2 s (1 + c s), c = 5/(6a) - 4g/3 (from (A0)).
    """
    x, pressure = contact.surface.arc, contact.mean_traction[-1, :, 0]
    section = plane_sections(x, pressure[None])[front.number]
    s, p = section.s[0, : section.nodes[0]], section.values[0, : section.nodes[0]]
    risen = s[int(np.argmax(p >= RISEN * p.max()))]
    near = (s > 0) & (s <= risen)
    slope, square = np.polyfit(s[near], p[near] ** (1 / exponent) / s[near], 1)
    return float(0.75 * (5 / (6 * half_width) - 2 * exponent * slope / square))


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
        factors[:, front.number, Factor.K_S :] *= -front.inward  # `along` is -z at the left
    return factors


def half_plane_units(positions: Array, dundurs: float = 0.0, guided: bool = False) -> Array:
    """(T, 2, 2, 4) station, `Factor`, for a unit of P, M, Q and sigma0; NaN without contact.

    `fretfe.analytic.edges.full_stick_factor` at the reference length 1; M is about x = 0, so that a
    load P has the moment -P (left + right)/2 about the centre of the contact.

    Args:
        positions: (2, T) of the left and the right edge.
        dundurs: beta.
        guided: whether body 1 does not turn; M then takes no part.
    """
    left, right = positions
    units = np.full((len(left), 2, 2, 4), np.nan)
    known = right > left
    a, centre = (right - left)[known] / 2, (right + left)[known] / 2
    zero, one = np.zeros_like(a), np.ones_like(a)
    # P, M, Q, sigma0 and the moment about the centre. Shear of unlike bodies turns one that is free
    # to; a moment holds one that is not.
    reaction = 0.0 if guided else shear_moment(dundurs, a)
    loads = [
        (one, zero, zero, zero if guided else -centre),
        (zero, zero, zero, zero if guided else one),
        (zero, one, zero, reaction),
        (zero, zero, one, zero),
    ]
    for front in PLANE_FRONTS:
        at_front = units[:, front.number]
        for column, (normal, shear, tension, moment) in enumerate(loads):
            found = full_stick_factor(normal, moment, shear, tension, a, front.name, dundurs)
            at_front[known, Factor.K_I, column] = found.real
            at_front[known, Factor.K_T, column] = found.imag
    return units


@dataclass(frozen=True)
class LoadPath:
    """The loads of a cycle of n steps, at the ends of its steps and at S places within each.

    Attributes:
        first: state in which the cycle begins.
        steps: (n, C) increments of the steps over the range of each load.
        bulges: (n, S, C) deviation from the straight line within each step, over the same.
    """

    first: int
    steps: Array
    bulges: Array

    def refine(self, factor: Array) -> Array:
        """A factor (T,) of all states at the (n (S + 1) + 1,) instants of the cycle."""
        count, inner, _ = self.bulges.shape
        values = factor[self.first : self.first + count + 1]
        if not np.isfinite(values).all():
            return np.full(count * (inner + 1) + 1, np.nan)
        slopes = np.linalg.lstsq(self.steps, np.diff(values), rcond=None)[0]
        shares = np.arange(1, inner + 1) / (inner + 1)
        within = values[:-1, None] + np.diff(values)[:, None] * shares + self.bulges @ slopes
        return np.append(np.column_stack([values[:-1], within]).ravel(), values[-1])

    def instants(self, state: int) -> slice:
        """The instants of `refine` that are less than a step from a state of the cycle."""
        parts = self.bulges.shape[1] + 1
        place = parts * (state - self.first)
        return slice(max(place - parts + 1, 0), place + parts)


def excess(factor: Array, cycle: Indices, path: LoadPath | None) -> float:
    """Excess of a factor (T,) between the steps of a cycle over its range at them; 0 if unknown."""
    if path is None or not len(cycle):
        return 0.0
    fine = path.refine(factor)
    return float(np.ptp(fine) - np.ptp(factor[cycle])) if np.isfinite(fine).all() else 0.0


def load_path(
    loads: Array, between: Array | None, cycle: tuple[int, int] | None
) -> LoadPath | None:
    """The loads of a cycle between its steps; None if they are straight lines there, or not known.

    Args:
        loads: (T, C) at the states.
        between: (T-1, S, C) within all steps, or None.
        cycle: its first and last state, or None.
    """
    if cycle is None or between is None:
        return None
    first, last = cycle
    values, between = loads[first : last + 1], between[first:last]
    shares = np.arange(1, between.shape[1] + 1) / (between.shape[1] + 1)
    steps = np.diff(values, axis=0)
    bulges = between - values[:-1, None] - shares[:, None] * steps[:, None]
    ranges = np.ptp(values, axis=0)
    varying = ranges > 0
    bulges = np.where(varying, bulges, 0.0) / np.where(varying, ranges, 1.0)
    if not np.abs(bulges).max(initial=0.0) > STRAIGHT:
        return None
    return LoadPath(first, steps / np.where(varying, ranges, 1.0), bulges)


def main_direction(history: Array, cycle: Indices) -> tuple[Array, float]:
    """(k,) unit vector along which factors of shear (T, k) vary most, and how much it turns.

    Its first component is positive: K along it has the sign of K_T, or of K_S without any K_T.
    """
    vectors = history[cycle] if len(cycle) else history
    vectors = vectors[np.isfinite(vectors).all(axis=1)]
    if len(vectors) < 2 or not np.ptp(vectors[:, 1:], axis=0).any():
        return np.eye(history.shape[1])[0], 0.0
    axes = np.linalg.svd(vectors - vectors.mean(axis=0), full_matrices=False)[2]
    along, across = (np.ptp(vectors @ axis) for axis in axes)
    leading = axes[0, 0] if abs(axes[0, 0]) > ROUND_OFF else axes[0, 1]
    direction = axes[0] * (1.0 if leading >= 0 else -1.0)
    return np.asarray(direction), float(across / along)


def along_line(factors: Array, direction: Array) -> Array:
    """(..., T) factors (..., T, d) of shear along a direction (2,) of (K_T, K_S), or of K_T."""
    shear = factors[..., Factor.K_T :]
    return np.asarray(shear @ direction[: shear.shape[-1]])


@dataclass(frozen=True)
class FactorHistories:
    """Singular factors of all stations in every state.

    Attributes:
        ways: (R, stations, T, d) in R ways.
        fitted: (stations, T, d) by fits to tractions; None without them.
        exact: True for closed forms.
        one_sided: (stations,) what steps of the cycle may be wrong by in |K| of which one end only
            is known.
        uneven: (stations,) what they may be wrong by as edges move within them.
    """

    ways: Array
    fitted: Array | None
    exact: bool
    one_sided: Array
    uneven: Array

    def directions(self, cycle: Indices) -> list[tuple[Array, float]]:
        """Direction of (K_T, K_S) and how much it turns at each station, by `main_direction`."""
        shear = self.ways.mean(axis=0)[..., Factor.K_T :]
        padded = np.pad(shear, ((0, 0), (0, 0), (0, 2 - shear.shape[2])))
        return [main_direction(each, cycle) for each in padded]

    def at(self, dundurs: float, lengths: Array) -> FactorHistories:
        """The same of unlike bodies at the reference lengths (stations,), from those at 1."""

        def turned(factors: Array) -> Array:
            own = [
                factors_at(factors[..., station, :, :], dundurs, length)
                for station, length in enumerate(lengths)
            ]
            return np.stack(own, axis=-3)

        fitted = None if self.fitted is None else turned(self.fitted)
        return replace(self, ways=turned(self.ways), fitted=fitted)


def pressed_on(
    factors: Array, dundurs: float, length: float, friction: Array, cycle: Indices
) -> bool:
    """True if P alone drives an edge: there is no cycle, and K_T grows by less than f K_I.

    Args:
        factors: (T, d) of the edge, between unlike bodies at the length 1.
        dundurs: beta.
        length: at which P adds nothing to K_T of unlike bodies, about the width of the contact.
        friction: (T,) coefficient in the step that ends at each state.
        cycle: states of the evaluated cycle.
    """
    if len(cycle) or not friction.any():
        return False
    own = factors_at(factors, dundurs, length / K_T_LENGTH) if dundurs else factors
    begin = max(int(np.argmax(friction > 0)) - 1, 0)
    known = own[begin:][np.isfinite(own[begin:]).all(axis=1)]
    if not len(known):
        return False
    # What pressed before the last way of the shear has no part in the slip of that.
    known = known[_last_way(known[:, Factor.K_T :]) :]
    ranges = np.ptp(known, axis=0)
    shear = float(np.linalg.norm(ranges[Factor.K_T :]))
    # Loads that stay as they are drive nothing: what K_I then varies by is round-off.
    if ranges[Factor.K_I] <= 1e-9 * np.abs(known[:, Factor.K_I]).max():
        return False
    return shear < float(friction.max() * ranges[Factor.K_I])


def _last_way(shear: Array) -> int:
    """State from which on the shear (T, c) goes one way until the end, along its principal line."""
    centred = shear - shear.mean(axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][0]
    way = np.diff(shear @ axis)
    still = np.abs(way) <= 1e-9 * np.abs(way).max(initial=0.0)
    signs = np.where(still, 0.0, np.sign(way))
    last = signs[np.flatnonzero(signs)[-1]] if signs.any() else 0.0
    against = np.flatnonzero(signs == -last) if last else np.arange(0)
    return int(against[-1]) + 1 if len(against) else 0


def reference_length(
    contact: ContactHistory,
    fit: EdgeFit,
    factors: Array,
    friction: Array,
    half_width: float,
    cycle: Indices,
    pressed: bool = False,
) -> float:
    """Length at which edge factors between unlike bodies are told: that of the predicted slip zone.

    Args:
        contact: the contact.
        fit: K_N of a station, at the length 1.
        factors: (T, d) its singular factors, at the length 1.
        friction: (T,) coefficient there.
        half_width: of the contact.
        cycle: states of the evaluated cycle; without one the zone is that of first loading.
        pressed: whether P alone drives the edge; the zone is then not predicted.
    """
    length, share = UNKNOWN_ZONE * half_width, 1.0 if len(cycle) else 2.0
    states = cycle if len(cycle) else np.flatnonzero(np.isfinite(factors).all(axis=1))
    for _ in range(LENGTH_ITERATIONS):
        if pressed or not len(states):
            break
        shear = factors_at(factors, contact.surface.dundurs, length)[:, Factor.K_T :]
        reach = float(np.ptp(shear[states] @ main_direction(shear, cycle)[0]))
        found = share * reach / (friction.max() * fit.told(length)[states[-1]])
        if not SMALLEST_MOVE * half_width < found < half_width:
            break
        length = float(found)
    return length


def sliding_apart(dundurs: float, friction: float, direction: Array) -> float:
    """|lambda - 1/2| where an edge between unlike bodies slides.

    Args:
        dundurs: beta.
        friction: coefficient at the edge.
        direction: (2,) of the slip, as of `main_direction`: its inward part meets the pressure.
    """
    return float(abs(sliding_exponent(dundurs, friction * float(direction[0])) - 0.5))


def reversed_share(along: Array, cycle: Indices) -> Array:
    """(T,) part of the range of a factor of shear that has passed since its last extreme.

    To first order the slip zone of the state is so much of that of the whole reversal; 1 outside
    the cycle, where nothing changes, and without a cycle.

    Args:
        along: (T,) factor of shear, NaN where unknown.
        cycle: states of the evaluated cycle, of which the last one is like the first one.
    """
    shares = np.ones(len(along))
    values, steps = along[cycle], max(len(cycle) - 1, 1)
    if not len(cycle) or not np.ptp(values) > 0:
        return shares
    far = np.array([values.max(), values.min()])
    near = np.isclose(values, far[:, None], rtol=0.0, atol=STRAIGHT * np.ptp(values))
    # A cycle hardly ever closes to round-off: its last state ends what its first one ended.
    near[:, [0, -1]] = near[:, [0, -1]].any(axis=1, keepdims=True)
    at = np.argmax(near, axis=1)
    since = (np.arange(len(cycle)) - at[:, None]) % steps
    passed = np.abs(values - far[np.argmin(since, axis=0)]) / np.ptp(values)
    # An extreme ends a reversal, as long as it holds.
    shares[cycle] = np.where(near.any(axis=0), 1.0, passed)
    return shares


def factors_at(factors: Array, dundurs: float, length: float) -> Array:
    """(..., d) singular factors at their parts of a reference length, from those at 1.

    K_S does not depend on it.
    """
    whole, epsilon = factors[..., Factor.K_I] + 1j * factors[..., Factor.K_T], oscillation(dundurs)
    found = factors.copy()
    found[..., Factor.K_I] = at_length(whole, epsilon, K_I_LENGTH * length).real
    found[..., Factor.K_T] = at_length(whole, epsilon, K_T_LENGTH * length).imag
    return found


def whole_factor(
    k_i: Array, k_t: Array, dundurs: float, length: float, wanted: float
) -> npt.NDArray[np.complex128]:
    """K_I + i K_T (complex, any shape) at a wanted length, from both at parts of another one.

    Args:
        k_i: at `K_I_LENGTH` times the length.
        k_t: at `K_T_LENGTH` times the length.
        dundurs: beta.
        length: the reference length.
        wanted: the other length.
    """
    epsilon = oscillation(dundurs)
    # K_I + i K_T where K_I is told, whose imaginary part follows from K_T farther out.
    turn = np.exp(1j * epsilon * np.log(K_T_LENGTH / K_I_LENGTH))
    whole = k_i + 1j * (k_t - k_i * turn.imag) / turn.real
    return at_length(whole, epsilon, wanted / (K_I_LENGTH * length))


def range_spreads(
    histories: FactorHistories,
    fits: Sequence[EdgeFit],
    arc: Array,
    cycle: Indices,
    path: LoadPath | None,
) -> tuple[RangeSpread, ...]:
    """Error bar of the range of (K_T, K_S) along a direction over a cycle at each station.

    The discretisation is what integral and fits differ by, what steps add of which one end only is
    known, and what it means that a discrete contact area ends somewhere within an element: K_T goes
    with the root of its half-width, so that an error of the edge counts half, and by the largest
    range of all stations, since K_T of one may be a small difference.

    Args:
        histories: the factors.
        fits: position of each station, and its error bar.
        arc: (N,) nodes of the contact.
        cycle: states of the evaluated cycle.
        path: loads of the cycle between its steps, unless they are straight lines.
    """
    directions = [direction for direction, _ in histories.directions(cycle)]
    along = [
        along_line(histories.ways[:, station], direction)
        for station, direction in enumerate(directions)
    ]
    mean = [each.mean(axis=0) for each in along]
    largest = max((cycle_range(each, cycle) for each in mean), default=np.nan)
    misplaced = _misplaced(fits, arc, cycle, WITHIN_GRID if histories.exact else WITHIN_ELEMENT)
    spreads = []
    for station, history in enumerate(mean):
        ranges = [cycle_range(way, cycle) for way in along[station]]
        # One way alone has no spread unless it is exact.
        alone = 0.0 if histories.exact else np.nan
        parts = [histories.one_sided[station], misplaced[station] * largest]
        if histories.fitted is not None:
            told = along_line(histories.fitted[station], directions[station])
            fitted = cycle_range(told, cycle)
            # Where there are too few nodes for fits, integrals stand alone.
            parts.append(fitted - cycle_range(history, cycle) if np.isfinite(fitted) else 0.0)
        spreads.append(
            RangeSpread(
                extraction=float(np.ptp(ranges)) / 2 if len(ranges) > 1 else alone,
                discretisation=float(np.linalg.norm(parts)),
                steps=excess(history, cycle, path) + float(histories.uneven[station]),
            )
        )
    return tuple(spreads)


def _misplaced(fits: Sequence[EdgeFit], arc: Array, cycle: Indices, elements: float) -> list[float]:
    """Half the error of each edge over the half-width, where that is largest in the cycle."""
    positions = np.array([fit.position[cycle] for fit in fits])
    half_width = np.ptp(positions, axis=0) / 2
    sizes = np.diff(arc)
    shares = []
    for position, fit in zip(positions, fits, strict=True):
        size = sizes[np.clip(np.searchsorted(arc, position) - 1, 0, len(sizes) - 1)]
        # The two errors have nothing to do with each other, but the larger one counts.
        error = np.hypot(elements * size, fit.spread_position[cycle])
        shares.append(float(np.max(error / (2 * half_width), initial=0.0)))
    return shares


def with_moved(k_n: Array, spread: Array, moved: float) -> Array:
    """(T,) error bars of K_N that hold K_N by the movement of the edge, where it is known.

    Where the fits of the last state disagree, so may all of them; K_N by the movement of the edge
    does not depend on them.

    Args:
        k_n: (T,) by fits.
        spread: (T,) their error bars.
        moved: K_N of the last state by the movement; NaN if unknown.
    """
    wider = spread.copy()
    if spread[-1] > LARGEST_SPREAD * k_n[-1] and math.isfinite(moved):
        wider[-1] = max(spread[-1], abs(k_n[-1] - moved))
    return wider


def cycle_range(history: Array, cycle: Indices) -> float:
    """Largest less smallest of a history (T,) over the states of a cycle; NaN without one."""
    return float(np.ptp(history[cycle])) if len(cycle) else np.nan
