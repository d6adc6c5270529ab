# SPDX-License-Identifier: LGPL-3.0-or-later
"""Singular factors of plane edges for a unit of each load, by integrals, fits and closed forms."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.edges import full_stick_factor, shear_moment
from fretfe.evaluate.factors import rotated
from fretfe.evaluate.increments import UnitFactors
from fretfe.evaluate.plane.full_stick_fit import OVERHANG, effective_edges, full_stick_factors
from fretfe.evaluate.plane.section import PLANE_FRONTS
from fretfe.history.solution import ContactHistory, Factor, Solution
from fretfe.history.state_array import MOST_STATES


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
    areas = [_own_area(solution, contact, int(area)) for area in integrals.areas]
    fitted, extents = np.array([each[0] for each in areas]), np.array([each[1] for each in areas])
    half_widths = (integrals.positions[:, 1] - integrals.positions[:, 0]) / 2
    # Fits see K of unlike bodies at a length in proportion to a, whatever beta is.
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
            alone = _without_fits(half_width[lost], extents, own[:, way])
            factors[lost] = np.where(np.isfinite(factors[lost]), factors[lost], alone)
        return rotated(factors, beta, 1 / half_width)

    return UnitFactors(map(by_way, range(len(integrals.reaches))), None if beta else fits)


def _own_area(solution: Solution, contact: ContactHistory, area: int) -> tuple[Array, float]:
    """(stations, d, J) fitted unit factors of an area at the edges of its increments; half-width.

    The edges of a discrete increment are a fraction of an element away from those of the contact,
    and the integral is that of the increment.
    """
    fields, overhang = contact.full_stick.fields[area], OVERHANG[solution.degree]
    edges = effective_edges(contact.surface.arc, fields.transpose(1, 2, 0), overhang)
    fits = _area_factors(contact.surface.arc, fields, edges[None], overhang)[0]
    return fits, float(edges[1] - edges[0]) / 2


def _without_fits(at: Array, half_widths: Array, integrals: Array) -> Array:
    """(T, ...) unit factors at half-widths (T,), from integrals (S, ...) at others (S,).

    K_T = Q/(pi sqrt(2 a)) + sigma0 sqrt(a/2)/4 of half-planes is a line, times the root of a.
    """
    order = np.argsort(half_widths)

    def root(a: Array) -> Array:
        return np.sqrt(a).reshape(-1, *[1] * (integrals.ndim - 1))

    lines = (root(half_widths) * integrals)[order]
    return np.asarray(_interpolate(at, half_widths[order], lines) / root(at))


def _interpolate(at: Array, x: Array, values: Array) -> Array:
    """(T, ...) values (S, ...) known at x (S,), linear between them and constant outside."""
    upper = np.clip(np.searchsorted(x, at), 1, max(len(x) - 1, 1))
    lower, upper = upper - 1, np.minimum(upper, len(x) - 1)
    # Two increments may have the same area.
    width = np.where(x[upper] > x[lower], x[upper] - x[lower], 1.0)
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
