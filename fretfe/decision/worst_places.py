# SPDX-License-Identifier: LGPL-3.0-or-later
"""Worst places along the surface around an edge, by the criteria at critical distances.

Each criterion is looked at on one grid, and on a finer one around its own worst place there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.case import Body
from fretfe.decision.assessment import Criterion
from fretfe.decision.distances import elastic_strain, judged_places, mean_stress, places_around
from fretfe.decision.endurance import Distance, ShearAndPressure, crossland, dang_van
from fretfe.decision.field import EdgeField
from fretfe.decision.thresholds import FatigueLimit
from fretfe.evaluate.contacts import Station
from fretfe.evaluate.critical_planes import PAIRS, find_critical, findley, smith_watson_topper

OF_TENSION = Criterion.POINT, Criterion.LINE, Criterion.AREA
OF_TORSION = Criterion.CROSSLAND, Criterion.DANG_VAN, Criterion.FINDLEY
METHODS: dict[Distance, tuple[Criterion, ...]] = {
    "point": (Criterion.POINT, *OF_TORSION),
    "line": (Criterion.LINE,),
    "area": (Criterion.AREA,),
}
# Of each criterion (m,) x along the surface, or (n, m, 6) stress there.
Each = dict[Criterion, Array]


@dataclass(frozen=True)
class Limits:
    """Endured by a body.

    Attributes:
        limit: of push and pull.
        torsion: amplitude of reversed torsion; None where it is not known.
        body: its constants.
        length: L of critical distances.
    """

    limit: FatigueLimit
    torsion: float | None
    body: Body
    length: float


@dataclass(frozen=True)
class WorstPlace:
    """Of one criterion.

    Attributes:
        used: stress over that endured, the inverse of the margin; 0 where any factor is endured.
        place: x along the surface.
        weight: error of `used` by one of the stress, over that of a stress of the size endured.
        outermost: whether it is the first or the last place that is judged.
        steps: change of `used` by every other state; NaN where these do not tell.
    """

    used: float
    place: float
    weight: float
    outermost: bool
    steps: float


def worst_places(field: EdgeField, station: Station, limits: Limits) -> dict[Criterion, WorstPlace]:
    """Those of all criteria whose limits are known."""
    first = judged_places(field, station, limits.length)
    criteria = OF_TENSION if limits.torsion is None else (*OF_TENSION, *OF_TORSION)
    grid = dict.fromkeys(criteria, first)
    found = _used(field, grid, limits)
    finer = {key: places_around(first, int(np.argmax(found[key][0]))) for key in criteria}
    again = _used(field, finer, limits)
    places = {key: np.concatenate([grid[key], finer[key]]) for key in criteria}
    both = {key: np.concatenate([found[key], again[key]], axis=1) for key in criteria}
    at = {key: int(np.argmax(both[key][0])) for key in criteria}
    steps = dict.fromkeys(criteria, math.nan)
    if (coarser := field.coarser) is not None:
        there = _used(coarser, {key: places[key][[at[key]]] for key in criteria}, limits)
        steps = {key: abs(float(both[key][0, at[key]] - there[key][0, 0])) for key in criteria}
    worst = {}
    for key in criteria:
        (used, weight), place = both[key][:, at[key]], float(places[key][at[key]])
        outermost = bool(used > 0) and place in (first[0], first[-1])
        worst[key] = WorstPlace(float(used), place, float(weight), outermost, steps[key])
    return worst


def _used(field: EdgeField, places: Each, limits: Limits) -> Each:
    """(2, m) `used` and `weight` of each criterion as of `WorstPlace`, at its own m places."""
    stresses: Each = {}
    for method, criteria in METHODS.items():
        own = [each for each in criteria if each in places]
        together = np.concatenate([places[each] for each in own])
        found = mean_stress(field, together, method, limits.length)
        stresses |= zip(own, np.split(found, len(own), axis=1), strict=True)
    return _by_tension(stresses, limits) | _by_torsion(stresses, limits)


def _by_tension(stresses: Each, limits: Limits) -> Each:
    """By Smith, Watson and Topper, all together."""
    every = np.concatenate([stresses[each] for each in OF_TENSION], axis=1)
    found = find_critical(every, elastic_strain(every, limits.body), smith_watson_topper)
    young, limit = limits.body.young, limits.limit
    endured = limit.stress_range**2 / (1 - limit.ratio) / (2 * young)
    both = np.array([
        np.sqrt(found.value / endured), error_weights(every, found.normal, young * found.value)
    ])  # fmt: skip
    return dict(zip(OF_TENSION, np.split(both, len(OF_TENSION), axis=1), strict=True))


def error_weights(stress: Array, normals: Array, product: Array) -> Array:
    """(m,) error of √(σ_max E ε_a) by one of the stress: more than 1 unless both are equal.

    A small tension is as uncertain as the large range, and its relative error counts.

    Args:
        stress: (n, m, 6).
        normals: (m, 3) of the critical planes.
        product: (m,) σ_max E ε_a on them.
    """
    parts = np.stack([normals[:, i] * normals[:, j] * (1 + (i != j)) for i, j in PAIRS], axis=1)
    pull = np.einsum("nmc,mc->nm", stress, parts).max(axis=0)
    pulled = product > 0
    pull, product = np.where(pulled, pull, 1.0), np.where(pulled, product, 1.0)
    return np.where(pulled, (pull + product / pull) / (2 * np.sqrt(product)), 1.0)


def _by_torsion(stresses: Each, limits: Limits) -> Each:
    """By the criteria that need limits of reversed tension and of reversed torsion."""
    tension, torsion = limits.limit.tension, limits.torsion
    if torsion is None:
        return {}
    # Both limits give the same value on the plane where that is largest.
    excess = 2 - tension / torsion
    k = excess / (2 * math.sqrt(1 - excess))
    shear = stresses[Criterion.FINDLEY]
    values = (
        crossland(stresses[Criterion.CROSSLAND], ShearAndPressure.crossland(tension, torsion)),
        dang_van(stresses[Criterion.DANG_VAN], ShearAndPressure.dang_van(tension, torsion)),
        find_critical(shear, elastic_strain(shear, limits.body), findley(k)).value
        / (torsion * math.sqrt(1 + k**2)),
    )
    return {
        key: np.array([np.maximum(each, 0.0), np.ones_like(each)])
        for key, each in zip(OF_TORSION, values, strict=True)
    }
