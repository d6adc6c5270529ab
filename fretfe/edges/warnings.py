# SPDX-License-Identifier: LGPL-3.0-or-later
"""Texts about an evaluated contact that a reader must know: unknown, uncertain, not steady."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.rainflow import reversals
from fretfe.edges.factors import WANTED_NODES
from fretfe.edges.front import Station
from fretfe.edges.patches import contact_patches
from fretfe.edges.section import PLANE_FRONTS
from fretfe.edges.slip_zones import cycle_states
from fretfe.edges.tracks import SMALLEST_PATCH
from fretfe.results.solution import OPEN, ContactHistory, Solution
from fretfe.results.states import blocks

# Change of the shear from one cycle to the next, relative to f p_max, below which it is steady.
STEADY_CHANGE = 1e-3
# Part of the range of K_T that may lie between the steps without a warning.
LARGEST_STEPS = 0.02
# Loads with fewer reversals, their first and last value included, have no cycles to be counted.
FEWEST_TURNS = 5


def warnings_about(
    solution: Solution, contact: ContactHistory, stations: tuple[Station, ...], change: float
) -> Iterator[str]:
    """Warnings about a contact, most serious first.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        stations: evaluated.
        change: of the shear over the evaluated cycle, relative to f p_max; NaN without a cycle.
    """
    yield from _unknown(solution, contact, stations)
    yield from _uncounted(solution, stations)
    yield from _surfaces(contact)
    yield from _patches(contact)
    if change >= STEADY_CHANGE:
        yield (
            f"not in steady state: the shear changes by {change:.2g} f p_max over the evaluated "
            "cycle; add cycles"
        )
    for station in stations:
        yield from _uncertain(station)


def _unknown(
    solution: Solution, contact: ContactHistory, stations: tuple[Station, ...]
) -> Iterator[str]:
    """Factors that cannot be told, and why."""
    states = cycle_states(solution.cycle)
    states = states if len(states) else np.array([len(solution.times) - 1])
    nodes = contact.nodes_pressed_in(states)
    if not nodes.any():
        return
    finer = WANTED_NODES / max(int(nodes.min()), 1)
    existing = contact.exists[states]
    reason = (
        f"the patch exists in {np.count_nonzero(existing)} of the {len(states)} states of the cycle"
        if not existing.all()
        else f"{nodes.min()} nodes are in contact, {WANTED_NODES} are wanted at least: make the "
        f"elements {math.ceil(2 * finer) / 2:g} times smaller"
        if finer > 1
        else "the pressure does not fall to zero like a root there"
    )
    for station in stations:
        unknown = contact.exists[-1] and not math.isfinite(station.k_n[-1])
        missing = ["K_N"] if unknown else []
        if len(cycle_states(solution.cycle)) and not math.isfinite(station.k_t_range):
            missing.append("ΔK_T")
        if missing:
            yield f"{' and '.join(missing)} at the {station.front} edge: unknown, because {reason}"


def _uncounted(solution: Solution, stations: tuple[Station, ...]) -> Iterator[str]:
    """Irregular loads without a cycle whose cycles cannot be counted, and why."""
    if solution.cycle is not None:
        return
    turns = max((len(reversals(each)) for each in solution.values.T), default=0)
    for station in stations:
        known = np.isfinite(station.k_t)
        if turns >= FEWEST_TURNS and not station.cycles.count.size and not known.all():
            yield f"cycles at the {station.front} edge are not counted: {station.cycles.reason}"


def _patches(contact: ContactHistory) -> Iterator[str]:
    """The fate of a patch, and nodes that belong to it but lie apart."""
    if contact.fate:
        yield (
            f"not there all the time, as one of several patches of {contact.pair!r}: it "
            f"{'; it '.join(contact.fate)}. It has edges only where it exists, and K_T and K_I "
            "begin anew whenever it appears"
        )
    shares = []
    for states in blocks(len(contact.traction), contact.traction[0].size):
        pressure = contact.traction[states, :, 0]
        borders = np.diff(pressure > 0, axis=1, prepend=False, append=False)
        apart = np.count_nonzero(borders, axis=1) > 2
        shares += [_main_share(contact.arc, state) for state in pressure[apart]]
    several = [share for share in shares if share < 1 - SMALLEST_PATCH]
    if several:
        yield (
            f"in {len(several)} of {len(contact.traction) - 1} states up to {1 - min(several):.1%} "
            "of P is on single nodes apart from the patch, too few for edges of their own: make "
            "the elements smaller there"
        )


def _main_share(arc: Array, pressure: Array) -> float:
    patches = contact_patches(arc, np.maximum(pressure, 0.0))
    forces = [patch.force for patch in patches]
    return max(forces) / sum(forces) if forces else 1.0


def _surfaces(contact: ContactHistory) -> Iterator[str]:
    """Surfaces that never touch, or end where they are in contact."""
    closed, smallest = np.zeros(len(contact.arc), dtype=bool), np.inf
    for states in blocks(len(contact.status), len(contact.arc)):
        closed |= np.any(contact.status[states] != OPEN, axis=0)
        smallest = min(smallest, float(contact.gap[states].min()))
    if not closed.any():
        yield f"the surfaces never touch; the smallest gap is {smallest:.4g}"
    for front in PLANE_FRONTS:
        if front.from_front(closed)[0]:
            yield (
                f"the contact reaches the {front.name} end of its surface: extend the physical "
                "group; the edge found there is not a true contact edge"
            )


def _uncertain(station: Station) -> Iterator[str]:
    """Numbers of a station that the mesh or the steps leave open."""
    if station.uncertain:
        yield (
            f"K_N at the {station.front} edge is {station.k_n[-1]:.3g} ± "
            f"{station.k_n_spread[-1]:.2g}: refine the mesh at this edge"
        )
    steps = station.k_t_range_parts.steps
    if steps > LARGEST_STEPS * station.k_t_range:
        yield (
            f"K_T at the {station.front} edge exceeds its range by {steps / station.k_t_range:.1%} "
            "between the steps: take more steps per cycle"
        )
    if any(zone.gross for zone in station.slip_zones[-2:]):
        irregular = station.cycles.irregular
        which = "in the worst counted cycle" if irregular else "in the last half cycles"
        yield f"gross slip {which} ({station.front} edge)"
    elif any(not zone.resolved for zone in station.slip_zones[-2:]):
        yield f"the {station.front} slip zone is not resolved by the mesh"
