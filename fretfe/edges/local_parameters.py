# SPDX-License-Identifier: LGPL-3.0-or-later
"""Local parameters of fretting damage along a contact, of the evaluated cycle.

They are of the contact surface alone; `stress_parameters` has those that need the stress in the
bodies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.results.solution import OPEN, ContactHistory
from fretfe.results.states import blocks


@dataclass(frozen=True)
class LocalParameters:
    """Of each of the N nodes of a contact, in the units of the case; zero where nothing slips.

    Attributes:
        slip_range: (N,) delta, largest distance between two places of the slip while in contact
            [length]. Its amplitude is half of that.
        path: (N,) length of the way that slips under pressure in the cycle [length].
        work: (N,) friction work per area in the cycle, the integral of q ds [force/length]. Its
            integral over the contact is the friction work of the cycle.
        pressed_path: (N,) integral of p |ds| [force/length]. Wear after Archard (1953): depth per
            cycle = k times this, k the specific wear rate (volume per force and way).
        ruiz: (N,) first parameter of Ruiz, Boddington and Chen (Exp. Mech. 24, 1984): largest |q|
            in the cycle times `slip_range` [force/length].
    """

    slip_range: Array
    path: Array
    work: Array
    pressed_path: Array
    ruiz: Array


def local_parameters(contact: ContactHistory, states: tuple[int, int]) -> LocalParameters:
    """Local parameters between two states.

    The traction in a step is the mean of that at its two ends, but for the friction work, which the
    solver gives. The pressure and shear of a node are means over the length that belongs to it: at
    an edge they are those of half an element.

    Args:
        contact: the contact; all states in between have to be kept.
        states: first and last state.
    """
    first, last = states
    count, directions = contact.slip.shape[1:]
    path, pressed, work, shear = (np.zeros(count) for _ in range(4))
    for part in blocks(last - first, count):
        steps = slice(first + part.start, first + part.stop + 1)
        traction = np.asarray(contact.mean_traction[steps])
        inside = np.asarray(contact.status[steps])[1:] != OPEN
        moved = inside * np.linalg.norm(np.diff(contact.slip[steps], axis=0), axis=2)
        path += moved.sum(axis=0)
        pressed += (moved * (traction[1:, :, 0] + traction[:-1, :, 0]) / 2).sum(axis=0)
        work += np.asarray(contact.dissipation[steps])[1:].sum(axis=0) / contact.weights
        shear = np.maximum(shear, np.linalg.norm(traction[..., 1:], axis=2).max(axis=0))
    extent = np.zeros(count) if last == first else _extent(contact, states, directions)
    return LocalParameters(extent, path, work, pressed, shear * extent)


def _extent(contact: ContactHistory, states: tuple[int, int], directions: int) -> Array:
    """(N,) largest distance between two places of the slip, of the states in contact."""
    first, last = states
    slip = np.asarray(contact.slip[first : last + 1])
    touched = np.asarray(contact.status[first : last + 1]) != OPEN
    # The state before the first step belongs to the slip if the node is in contact after it.
    touched[0] = touched[1]
    slip = np.where(touched[..., None], slip, np.nan)
    found = np.zeros(slip.shape[1])
    if directions == 1:
        low, high = np.fmin.reduce(slip[..., 0]), np.fmax.reduce(slip[..., 0])
        return np.nan_to_num(high - low)
    for later in range(1, len(slip)):
        distance = np.linalg.norm(slip[:later] - slip[later], axis=2)
        found = np.fmax(found, np.fmax.reduce(distance))
    return found
