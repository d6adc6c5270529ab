# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reasons why factors of plane edges are not known: one for each station, which all tables tell."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from fretfe._typing import Indices
from fretfe.evaluate.contacts import Station
from fretfe.evaluate.edge_zone import WANTED_IN_CONTACT
from fretfe.evaluate.factors import WANTED_NODES
from fretfe.evaluate.loaded import evaluated_states
from fretfe.evaluate.plane.pressure_fit import why_no_root
from fretfe.evaluate.plane.section import main_patch, plane_front
from fretfe.history.solution import ContactHistory, Solution
from fretfe.reason import Kind, Reason


def with_lack(solution: Solution, contact: ContactHistory, station: Station) -> Station:
    """The station with the reason why a factor of it is not known, and without a range then.

    A range without a bar is not known either, if the edge is not known in some state.

    Args:
        solution: the solved history.
        contact: whose station it is.
        station: with its numbers.
    """
    if station.lack.whole:
        return station
    states = evaluated_states(solution, contact)
    located = bool(np.isfinite(station.position[states]).all())
    ranged = math.isfinite(station.k_t_range) and (located or math.isfinite(station.k_range_spread))
    if not ranged:
        station = replace(station, k_t_range=math.nan, k_s_range=math.nan, k_range=math.nan)
    unknown = contact.exists[station.decisive] and not math.isfinite(station.decisive_k_n[0])
    if not unknown and (ranged or solution.cycle is None):
        return station
    if unknown and contact.nodes_pressed_in(np.array([station.decisive])).any():
        # K_N has the reason of its own state, whatever happens in others.
        return replace(station, lack=_reason(contact, station, np.array([station.decisive])))
    return replace(station, lack=_reason(contact, station, states))


def _reason(contact: ContactHistory, station: Station, states: Indices) -> Reason:
    """Of several reasons the one behind the others."""
    nodes, existing = contact.nodes_pressed_in(states), contact.exists[states]
    if not existing.all():
        return Reason(Kind.ABSENT, int(np.count_nonzero(existing)), len(states))
    touching = int(np.count_nonzero(nodes))
    if touching < len(states):
        return Reason(Kind.NO_CONTACT, touching, len(states))
    if nodes.min() < WANTED_NODES:
        return Reason(Kind.FEW_NODES, int(nodes.min()), WANTED_IN_CONTACT)
    unknown = states[~np.isfinite(station.k_n[states])]
    if not len(unknown):
        return Reason(Kind.NO_TRACTIONS)
    state = station.decisive if station.decisive in unknown else unknown[-1]
    pressure = contact.traction[state, :, 0]
    patch = main_patch(contact.surface.arc, pressure)
    return why_no_root(contact.surface.arc, pressure, patch, plane_front(station.front))
