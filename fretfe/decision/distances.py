# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress around an edge at the critical distances, and its strain.

Of n states at m places along the surface; components as of `critical_planes.PAIRS`.
"""

from __future__ import annotations

import math

import numpy as np

from fretfe._typing import Array
from fretfe.case import Body
from fretfe.decision.endurance import Distance, distance_points
from fretfe.decision.field import EdgeField
from fretfe.evaluate.contacts import Station

# Step between the first places in critical distances, their number, parts of it around the worst.
STEP = 1 / 3
FEWEST = 22
MOST = 100
PARTS = 4


def judged_places(field: EdgeField, station: Station, length: float) -> Array:
    """(m,) x along the surface: a few critical distances around the edge, all of the slip zone.

    The slip zone begins at all places that the edge takes.
    """
    outward, inward = field.smooth.widest
    zone = station.longest_zone
    slip = 0.0 if zone is None or not math.isfinite(zone.length) else zone.length
    known = station.position[field.states]
    known = known[np.isfinite(known)]
    slip += float(np.ptp(known)) if len(known) else 0.0
    first, last = -min(5 * length, outward), min(max(2 * length, slip), inward)
    # The stress at a depth of half of L rises and falls along the surface within L at least.
    count = int(np.clip((last - first) / (STEP * length), FEWEST, MOST))
    return _without_round_off(np.linspace(first, last, count))


def places_around(places: Array, at: int) -> Array:
    """(6,) between a place and its neighbours, of which an outermost one has none on one side."""
    step = (places[1] - places[0]) / PARTS
    around = places[at] + step * np.array([*range(1 - PARTS, 0), *range(1, PARTS)])
    return _without_round_off(np.clip(around, places[0], places[-1]))


def _without_round_off(places: Array) -> Array:
    """Those at the edge itself at zero."""
    return np.where(np.abs(places) < 1e-9 * np.abs(places).max(), 0.0, places)


def mean_stress(field: EdgeField, places: Array, method: Distance, length: float) -> Array:
    """(n, m, 6) mean stress below places of the surface."""
    below, weights = distance_points(method, length)
    points = np.stack([places, np.zeros_like(places)], axis=1)[:, None] + below
    stress = field.stress(points.reshape(-1, 2))
    stress = stress.reshape(len(stress), len(places), len(weights), -1)
    found = np.zeros((len(stress), len(places), 6))
    found[..., : stress.shape[-1]] = np.einsum("npmc,m->npc", stress, weights)
    return found


def elastic_strain(stress: Array, body: Body) -> Array:
    """(n, m, 6) components of the tensor."""
    strain = (1 + body.poisson) / body.young * stress
    strain[..., :3] -= body.poisson / body.young * stress[..., :3].sum(axis=2, keepdims=True)
    return np.asarray(strain)
