# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges and K_N of a plane contact through its history, between similar and unlike bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, fields, replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.edges import sliding_exponent
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.factors import WANTED_NODES
from fretfe.evaluate.missing_shear import (
    MissingShear,
    widened,
    without_every_other,
    without_missing,
)
from fretfe.evaluate.plane.gap_shape import with_gap_shape
from fretfe.evaluate.plane.kink_fit import find_kink, fit_beside_kink, near_kink
from fretfe.evaluate.plane.pressure_fit import FEWEST_NODES, fit_edge
from fretfe.evaluate.plane.section import PLANE_FRONTS, PlaneFront, plane_sections
from fretfe.history.solution import ContactHistory
from fretfe.history.state_array import blocks

# Nodes whose shear over pressure tells which way an edge slips.
NEXT_TO_EDGE = 3


def edge_fits(contact: ContactHistory, source: Indices) -> tuple[EdgeFit, ...]:
    """Position and K_N with their spreads at each front; NaN where they cannot be fitted.

    Args:
        contact: one contact.
        source: (T,) the state that each state is the same as.
    """
    states = np.unique(source)
    arc, beta = contact.surface.arc, contact.surface.dundurs
    couple = MissingShear(arc, beta) if beta else None
    parts = np.full((len(PLANE_FRONTS), len(fields(EdgeFit)), len(states)), np.nan)
    for block in blocks(len(states), contact.traction[0].size):
        pressure, shear = np.moveaxis(contact.traction[states[block]], 2, 0)[:2]
        fitted = np.count_nonzero(pressure > 0, axis=1) >= FEWEST_NODES
        there = block.start + np.flatnonzero(fitted)
        sections = plane_sections(arc, pressure[fitted])
        if couple is not None:
            tractions = pressure[fitted], shear[fitted]
            fits = [_unlike_fit(contact, couple, front, *tractions) for front in PLANE_FRONTS]
        else:
            fits = [fit_edge(section, solved=True) for section in sections]
        beside = None if contact.beside is None else contact.beside[states[there]]
        shaped = with_gap(fits, contact, pressure[fitted], beside)
        for front, section, fit in zip(PLANE_FRONTS, sections, shaped, strict=True):
            # At the end of the surface the contact ends with the body, at a corner.
            inside = section.origin != front.from_front(arc)[0]
            parts[front.number][:, there[inside]] = np.array(astuple(fit))[:, inside]
    known = parts[..., np.searchsorted(states, source)]
    return tuple(EdgeFit(*front) for front in known)


def with_gap(
    fits: Sequence[EdgeFit], contact: ContactHistory, pressure: Array, beside: Array | None = None
) -> tuple[EdgeFit, ...]:
    """Fits at both edges with what the gap makes of the pressure, of wedges beside their kink.

    Args:
        fits: of any contact.
        contact: of which they are.
        pressure: (T, N) in each state.
        beside: (T, N) of other patches of the pair, if there are any.
    """
    kink = find_kink(contact, pressure)
    if kink is not None:
        arc = contact.surface.arc
        near = near_kink(arc, pressure, kink)
        others = [_without(fit, each) for fit, each in zip(fits, near, strict=True)]
        fits = [*map(_preferred, fit_beside_kink(arc, pressure, kink), others)]
    return with_gap_shape(fits, contact, pressure, beside)


def _without(fit: EdgeFit, states: Bools) -> EdgeFit:
    """A fit that knows nothing in some states."""
    return EdgeFit(*(np.where(states, np.nan, each) for each in astuple(fit)))


def _preferred(first: EdgeFit, second: EdgeFit) -> EdgeFit:
    """The first fit in the states in which there is one, elsewhere the second."""
    known = np.isfinite(first.k_n)
    parts = zip(astuple(first), astuple(second), strict=True)
    return EdgeFit(*(np.where(known, *pair) for pair in parts))


def with_areas(
    fits: Sequence[EdgeFit], contact: ContactHistory, states: Indices, decisive: int
) -> tuple[EdgeFit, ...]:
    """Edges with their places by the nodes under pressure where the pressures do not show them.

    Of flats with rounded ends under little load they do not, as no element of the rounding carries
    much. Full stick depends on the place of the edge alone, which is then known to an element.

    Args:
        fits: of both fronts.
        contact: whose edges.
        states: of the cycle.
        decisive: state in which the places of both edges must be known: elsewhere they are corners.
    """
    places = np.array([fit.position for fit in fits])
    if not np.isfinite(places[:, decisive]).all():
        return tuple(fits)
    lost = states[~np.isfinite(places[:, states]).all(axis=0)]
    lost = lost[contact.nodes_pressed_in(lost) >= WANTED_NODES] if len(lost) else lost
    if not len(lost):
        return tuple(fits)
    pressed = np.asarray(contact.traction[lost, :, 0]) > 0
    found = []
    for front, fit in zip(PLANE_FRONTS, fits, strict=True):
        arc, rows = front.from_front(contact.surface.arc), front.from_front(pressed)
        inner = np.maximum(np.argmax(rows, axis=1), 1)
        position, spread = fit.position.copy(), fit.spread_position.copy()
        own = ~np.isfinite(position[lost])
        position[lost[own]] = ((arc[inner] + arc[inner - 1]) / 2)[own]
        spread[lost[own]] = np.abs(arc[inner] - arc[inner - 1])[own]
        found.append(replace(fit, position=position, spread_position=spread))
    return tuple(found)


def _unlike_fit(
    contact: ContactHistory, couple: MissingShear, front: PlaneFront, pressure: Array, shear: Array
) -> EdgeFit:
    """Fit at an edge between unlike bodies, with the exponent by the way the edge slips.

    Args:
        contact: one contact.
        couple: of its nodes.
        front: of the edge.
        pressure: (T, n) of T states.
        shear: (T, n)
    """
    arc = contact.surface.arc
    section, across = (
        plane_sections(arc, pressure, each)[front.number] for each in (pressure, shear)
    )
    # Next to the edge, without the outermost node.
    pulled, pressed = (x.values[:, 1 : NEXT_TO_EDGE + 1].sum(axis=1) for x in (across, section))
    ratio = pulled / pressed
    exponent = sliding_exponent(contact.surface.dundurs, front.inward * ratio)
    missing = front.inward * (shear - ratio[:, None] * pressure)
    # The status of the outermost node means nothing.
    missing[arc == section.origin[:, None]] = 0.0
    fit = fit_edge(section, solved=True, exponent=exponent)

    def refit(known: EdgeFit, missing: Array) -> EdgeFit:
        coupled = couple.pressure(missing, exponent, front.inward, known.position)
        alone = np.where(pressure > 0, np.maximum(pressure - coupled, 0.0), 0.0)
        section = plane_sections(arc, pressure, alone)[front.number]
        return fit_edge(section, solved=True, exponent=exponent)

    coarser = without_every_other(arc, missing)
    fit, others = without_missing(fit, missing, coarser, refit)
    position = widened(fit.spread_position, fit.position, [each.position for each in others])
    k_n = widened(fit.spread_k_n, fit.k_n, [each.k_n for each in others])
    return replace(fit, spread_position=position, spread_k_n=k_n)
