# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of a plane contact: its edges, resultants and friction work.

A patch that exists in some of the states only has a history in each interval of contact by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.edges import oscillation
from fretfe.evaluate.contacts import Front, Station, fronts_of, unknown_station
from fretfe.evaluate.factors import K_T_LENGTH, factors_at
from fretfe.evaluate.friction_work import friction_work
from fretfe.evaluate.increments import ContactSteps, Cycle, UnitFactors
from fretfe.evaluate.loaded import evaluated_states, normal_force, with_own_cycle
from fretfe.evaluate.numerics import last_known, most_loaded
from fretfe.evaluate.plane.edge_fits import edge_fits, with_areas
from fretfe.evaluate.plane.edges import PlaneEdges, with_stiff_elements
from fretfe.evaluate.plane.half_planes import (
    full_stick_shear_force,
    shear_mismatch,
    tension_history,
)
from fretfe.evaluate.plane.lacks import with_lack
from fretfe.evaluate.plane.section import PLANE_FRONTS
from fretfe.evaluate.plane.symmetry import NO_EDGE
from fretfe.evaluate.resultants import plane_resultants
from fretfe.evaluate.seen_slip import pressed_on
from fretfe.evaluate.slip import cycle_states
from fretfe.history.solution import ContactHistory, Factor, Solution

# Degrees from inward beyond which the range of (K_T, K_S) has next to no K_T to be compared.
NEARLY_ALONG_Z = 89.0
# From solution, contact and positions (stations, T) along the arc.
FindUnits = Callable[[Solution, ContactHistory, Array], UnitFactors]


def evaluate_plane(
    solution: Solution, contact: ContactHistory, find_units: FindUnits, told: float | None
) -> dict[str, Any]:
    """Edges, resultants and friction work of a plane contact, by the names of `Contact`.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        find_units: gives the singular factors for a unit of each driver.
        told: reference length of factors between unlike bodies; None for the predicted slip zones.
    """
    edges = plane_edges(solution, contact, find_units)
    resultants = plane_resultants(contact, edges.centre)
    k_i = resultants["normal_force"] / (np.pi * np.sqrt(2 * edges.half_width))
    own = edges.steps.solution
    stations = [
        with_lack(own, contact, with_stiff_elements(each, contact, solution.degree, k_i))
        for each in edges.stations(told)
    ]
    return {
        **resultants,
        "fronts": tuple(Front(each.front, (each,)) for each in stations),
        "half_width": edges.half_width,
        **_by_half_planes(contact, edges, stations),
        "dissipation": sum(each.dissipation for each in stations),
        "dissipation_spread": sum(each.dissipation_spread for each in stations),
    }


def evaluate_endless(solution: Solution, contact: ContactHistory) -> dict[str, Any]:
    """Resultants and friction work of a plane contact without edges, by the names of `Contact`."""
    lost = np.full(len(contact.traction), np.nan)
    stations = [unknown_station(each.name, 0, len(lost), NO_EDGE) for each in PLANE_FRONTS]
    work, spread = friction_work(solution, contact)
    return {
        **plane_resultants(contact, lost),
        "fronts": fronts_of(stations),
        "half_width": lost,
        "effective_tension": lost,
        "shear_mismatch": np.nan,
        "dissipation": float(work.sum()),
        "dissipation_spread": float(spread.sum()),
    }


def plane_edges(solution: Solution, contact: ContactHistory, find_units: FindUnits) -> PlaneEdges:
    """Both edges of a plane contact, of unlike bodies at the reference length 1.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        find_units: gives the singular factors for a unit of each driver.
    """
    own, force = with_own_cycle(solution, contact), normal_force(contact)
    steps = ContactSteps.of(own, contact, solution)
    states = evaluated_states(own, contact)
    fits = with_areas(
        edge_fits(contact, solution.source), contact, states, most_loaded(force, states)
    )
    positions = np.array([fit.position for fit in fits])
    factors = steps.histories(find_units(solution, contact, positions), alone=False)
    frictions = [contact.edge_friction(each) for each in positions]
    steps = steps.without_small(factors.known)
    cycle, beta = cycle_states(steps.solution.cycle), contact.surface.dundurs
    a = last_known((positions[1] - positions[0]) / 2, cycle)
    histories = zip(factors.ways.mean(axis=0), frictions, strict=True)
    return PlaneEdges(
        contact=contact,
        steps=steps,
        fits=fits,
        factors=factors,
        frictions=frictions,
        half_widths=np.full(len(fits), a),
        pressed=[pressed_on(each, beta, 2 * a, friction, cycle) for each, friction in histories],
        last=int(cycle[-1]) if len(cycle) else len(solution.times) - 1,
        force=force,
        works=friction_work(solution, contact),
    )


def _by_half_planes(
    contact: ContactHistory, edges: PlaneEdges, stations: list[Station]
) -> dict[str, Any]:
    """Loads that half-planes need for the factors, as if the bodies were similar.

    Args:
        contact: the contact.
        edges: at the reference length 1.
        stations: of the edges.
    """
    solution, beta = edges.steps.solution, contact.surface.dundurs
    whole, half_width = edges.factors.ways.mean(axis=0), edges.half_width
    if beta:
        # At the length where shear adds nothing to K_I.
        whole = factors_at(whole, beta, 2 * float(edges.half_widths[0]) / K_T_LENGTH)
        whole[..., : Factor.K_S] /= np.cosh(np.pi * oscillation(beta))
    k_t = whole[..., Factor.K_T]

    def tension(interval: slice, cycle: Cycle) -> Array:
        return tension_history(k_t[:, interval], half_width[interval], cycle)

    inward = all(abs(each.k_angle) < NEARLY_ALONG_Z for each in stations)
    shear = full_stick_shear_force(solution, contact)
    return {
        "effective_tension": edges.steps.by_interval(tension),
        "shear_mismatch": shear_mismatch(k_t, half_width, shear, solution.cycle)
        if inward
        else np.nan,
    }
