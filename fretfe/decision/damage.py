# SPDX-License-Identifier: LGPL-3.0-or-later
"""Damage of counted cycles, added up after Palmgren (1924) and Miner (J. Appl. Mech. 12, 1945).

Each counted cycle has the life of smooth specimens with the same parameter of Smith, Watson and
Topper, here at the critical distance and on the worst plane of each cycle: the sum is that of one
plane or more. The order of cycles does not count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Body
from fretfe.decision.distances import elastic_strain, judged_places, mean_stress, places_around
from fretfe.decision.field import EdgeField
from fretfe.evaluate.contacts import Station
from fretfe.evaluate.critical_planes import find_critical, smith_watson_topper


@dataclass(frozen=True)
class SmoothLife:
    """Lives of smooth specimens over σ_max ε_a, for m lives between which it is a power.

    Attributes:
        cycles: (m,) lives, increasing.
        elastic: (m,) E σ_max ε_a by the elastic strain [stress^2].
        plastic: (m,) σ_max ε_a by the plastic strain [stress].
    """

    cycles: Array
    elastic: Array
    plastic: Array

    @classmethod
    def of_amplitudes(cls, cycles: Array, amplitudes: Array, ratio: float) -> SmoothLife:
        """From amplitudes of the stress at one R."""
        return cls(cycles, 2 * amplitudes**2 / (1 - ratio), np.zeros_like(amplitudes))

    @classmethod
    def coffin_manson(
        cls, span: tuple[float, float], strength: tuple[float, float], strain: tuple[float, float]
    ) -> SmoothLife:
        """σ_f' (2 N)^b and ε_f' (2 N)^c, factor and exponent of each, between two tested lives."""
        cycles = np.geomspace(*span, 200)
        stress, plastic = (factor * (2 * cycles) ** power for factor, power in (strength, strain))
        return cls(cycles, stress**2, stress * plastic)

    def damage(self, values: Array, young: float) -> tuple[Array, Array]:
        """Least and largest damage of one cycle with σ_max ε_a of any shape.

        Below that of the longest tested life it lies between none and that of this life; above that
        of the shortest one it is NaN.
        """
        known = np.log(self.elastic / young + self.plastic)[::-1]
        logarithms = np.log(np.maximum(values, 1e-300))
        each = np.exp(-np.interp(logarithms, known, np.log(self.cycles)[::-1], right=np.nan))
        return np.where(logarithms < known[0], 0.0, each), each


@dataclass(frozen=True)
class Damage:
    """Of one repetition of the evaluated cycle, or of the whole history without one.

    Attributes:
        low, high: ends of its sum over all counted cycles; NaN where unknown.
        cycles: number of counted cycles.
        place: at which it is largest, along the surface, inward from the edge.
        reason: why it is unknown; empty if it is known.
    """

    low: float = math.nan
    high: float = math.nan
    cycles: float = math.nan
    place: float = math.nan
    reason: str = ""


def counted_damage(
    field: EdgeField, station: Station, life: SmoothLife, body: Body, length: float
) -> Damage:
    """The sum at the place where it is largest.

    Args:
        field: through all states of the counted cycles.
        station: edge whose cycles were counted.
        life: of smooth specimens.
        body: its constants.
        length: L of critical distances.
    """
    counted = station.cycles
    if counted.reason:
        return Damage(reason=f"no cycles are counted: {counted.reason}")

    def sums(places: Array) -> Array:
        """(2, m) least and largest sum."""
        stress, both = mean_stress(field, places, "point", length), np.zeros((2, len(places)))
        for start, end, count in zip(counted.start, counted.end, counted.count, strict=True):
            way = stress[_way(field.states, int(start), int(end))]
            found = find_critical(way, elastic_strain(way, body), smith_watson_topper).value
            both += count * np.array(life.damage(found, body.young))
        return both

    grid = judged_places(field, station, length)
    first = sums(grid)
    finer = places_around(grid, int(np.argmax(first[1])))
    (low, high), places = np.hstack([first, sums(finer)]), np.concatenate([grid, finer])
    if np.isnan(high).any():
        return Damage(reason="a cycle has a shorter life than those of fatigue.life")
    at = int(np.argmax(high))
    total = float(counted.count.sum())
    return Damage(float(low.max()), float(high[at]), total, float(places[at]))


def _way(states: Indices, start: int, end: int) -> Indices:
    """Places of the states between two reversals; a later start goes on in the next repetition."""
    inside = (states >= start) & (states <= end)
    return np.flatnonzero(inside if start <= end else (states >= start) | (states <= end))
