# SPDX-License-Identifier: LGPL-3.0-or-later
"""Resultants of a contact, and the two states between which a load cycle swings.

T is the number of states. Forces, moments and work are those of the whole contact.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.numerics import pressure_moments
from fretfe.history.solution import OPEN, STICK, ContactHistory
from fretfe.history.state_array import blocks

# Shear that varies by less than this fraction of the normal loads is round-off.
SMALLEST_SHEAR = 1e-3
# Part of the largest P below which a force is round-off.
ROUND_OFF = 1e-9


def load_extremes(contacts: Sequence[Contact], cycle: tuple[int, int] | None) -> list[int]:
    """States of the largest and the smallest load in the evaluated cycle.

    In the plane those of `station_extremes`, if a station has K_T in most of the states. Else, and
    between solids, the load is Q of the contact where it varies most, along the direction in which
    it does; where none feels shear, P likewise.

    Args:
        contacts: one at least.
        cycle: its first and last state; None for the whole history without the unloaded state.

    Returns:
        Two states in the order of time, or the last state alone if the load is constant or no step
        was solved.
    """
    first, last = cycle or (1, len(contacts[0].normal_force) - 1)
    states, solid = slice(first, last + 1), contacts[0].solid
    stations = () if solid else [one for each in contacts for one in each.stations]
    known = (np.isfinite(each.k_along[states]).mean() > 0.5 for each in stations)
    if last < first or any(known):
        return station_extremes(stations, cycle) if stations else [last]
    forces = (each.shear_force if solid else each.shear_vectors for each in contacts)
    inside = (each[states] for each in forces)
    shear = max((each @ shear_direction(each) for each in inside), key=np.ptp)
    normal = max((each.normal_force[states] for each in contacts), key=np.ptp)
    load = shear if np.ptp(shear) > SMALLEST_SHEAR * np.abs(normal).max() else normal
    found = sorted({first + int(load.argmax()), first + int(load.argmin())})
    return found if len(found) == 2 else [last]


def shear_direction(force: Array) -> Array:
    """(d,) unit vector along which forces (n, d) vary most, its largest component positive."""
    direction = np.linalg.svd(force - force.mean(axis=0), full_matrices=False)[2][0]
    return np.asarray(direction * np.sign(direction[np.abs(direction).argmax()]))


def shear_line(contact: Contact, states: slice) -> Array:
    """(d - 1,) unit vector along which Q of a plane contact varies most, by arc and z; 1 at d = 2.

    Args:
        contact: between plane bodies.
        states: to look at.
    """
    force = contact.shear_vectors[states]
    return np.ones(1) if force.shape[1] == 1 else shear_direction(force)


def station_extremes(stations: Sequence[Station], cycle: tuple[int, int] | None) -> list[int]:
    """States of the largest and the smallest load of some stations in the evaluated cycle.

    The load is (K_T, K_S) of the station where that varies most, along the direction in which it
    does; where none feels shear, K_I likewise.

    Args:
        stations: one at least.
        cycle: its first and last state; None for the whole history without the unloaded state.

    Returns:
        Two states in the order of time, or the last state alone if the load is constant: the last
        one in which it is known.
    """
    first, last = cycle or (1, len(stations[0].k_along) - 1)
    shear, normal = (
        np.array([getattr(each, name) for each in stations])[:, first : last + 1]
        for name in ("k_along", "k_i")
    )
    ranges = [np.array([_range(each) for each in loads]) for loads in (shear, normal)]
    sheared = ranges[0].max() > SMALLEST_SHEAR * ranges[1].max()
    load = shear[ranges[0].argmax()] if sheared else normal[ranges[1].argmax()]
    known = first + np.flatnonzero(np.isfinite(load))
    if not len(known):
        return [last]
    load = load[known - first]
    states = {int(known[load.argmax()]), int(known[load.argmin()])}
    return sorted(states) if len(states) == 2 else [int(known[-1])]


def _range(load: Array) -> float:
    """Range where a load is known; below zero where it never is."""
    known = load[np.isfinite(load)]
    return float(np.ptp(known)) if len(known) else -1.0


def force_ranges(normal: Array, shear: Array, cycle: tuple[int, int] | None) -> dict[str, Any]:
    """Smallest and largest P and Q in the cycle, or in all, by the names of `Contact`.

    Args:
        normal: (T,) P.
        shear: (T,) Q, or (T, 3) of solids, whose length counts.
        cycle: first and last state.
    """
    first, last = cycle or (0, len(normal) - 1)
    size = np.linalg.norm(shear, axis=1) if shear.ndim == 2 else shear
    found: dict[str, Any] = {}
    for name, force in (("normal_force", normal), ("shear_force", size)):
        # What is left of a contact that carries nothing is round-off.
        nothing = np.abs(force) < ROUND_OFF * np.abs(normal).max(initial=0.0)
        known = np.where(nothing, 0.0, force)[first : last + 1]
        found[f"smallest_{name}"] = float(known.min())
        found[f"largest_{name}"] = float(known.max())
    return found


def plane_resultants(contact: ContactHistory, centre: Array) -> dict[str, Array]:
    """Histories of a plane contact, by the names of `Contact`.

    Args:
        contact: N nodes along the arc.
        centre: (T,) of the contact; moments are about 0 where there is none.
    """

    def own(states: slice, mean: Array) -> dict[str, Array]:
        traction = contact.traction[states]
        middle = np.where(np.isfinite(centre[states]), centre[states], 0.0)
        return {
            "shear_force": traction[..., 1] @ contact.surface.weights,
            "moment": pressure_moments(contact.surface.arc, traction[..., 0], middle),
        }

    return {**_resultants(contact, own), "centre": centre}


def solid_resultants(contact: ContactHistory) -> dict[str, Array]:
    """Histories of a contact between solids, by the names of `Contact`."""
    surface = contact.surface
    weights, points, tangents = surface.weights, surface.points, surface.frames[:, 1:]

    def own(states: slice, mean: Array) -> dict[str, Array]:
        pressure, vectors = mean[..., 0] * weights, traction_vectors(contact, mean)
        normal_force = pressure.sum(axis=1)
        pressed = np.where(normal_force > 0, normal_force, np.nan)
        centre = pressure @ points / pressed[:, None]
        about_origin = np.einsum("n,tnd->td", weights, np.cross(points, vectors))
        return {
            "shear_force": np.einsum("n,tnc,ncd->td", weights, mean[..., 1:], tangents),
            "centre": centre,
            "moment": about_origin - np.cross(centre, weights @ vectors),
        }

    return _resultants(contact, own)


def _resultants(
    contact: ContactHistory, own: Callable[[slice, Array], dict[str, Array]]
) -> dict[str, Array]:
    """Histories of a contact, those that its dimension has of its own behind the common ones.

    Args:
        contact: T states.
        own: gives histories from a block of states and (n, N, d) mean tractions in them.
    """
    parts = []
    for states in blocks(len(contact.traction), contact.traction[0].size):
        # Means around the nodes have the moments of the field itself, nodal values do not.
        mean, status = contact.mean_traction[states], contact.status[states]
        common = {
            # The weights are those of the solution itself: P balances the loads to round-off.
            "normal_force": contact.traction[states, :, 0] @ contact.surface.weights,
            "force": np.einsum(
                "n,tnd->td", contact.surface.weights, traction_vectors(contact, mean)
            ),
            "contact_area": (status != OPEN) @ contact.surface.weights,
            "stick_area": (status == STICK) @ contact.surface.weights,
            "largest_pressure": mean[..., 0].max(axis=1),
            "work": contact.dissipation[states].sum(axis=1),
        }
        parts.append({**common, **own(states, mean)})
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def traction_vectors(contact: ContactHistory, traction: Array) -> Array:
    """(n, N, d) tractions of body 1 on body 2, in the axes of the case, in n states."""
    # On body 2 the pressure acts against its outward normal.
    signs = np.where(np.arange(traction.shape[2]) > 0, 1.0, -1.0)
    return np.einsum("tnc,ncd->tnd", signs * traction, contact.surface.frames)
