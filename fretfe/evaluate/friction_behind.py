# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coefficient of friction behind an edge where it is not the same at all places.

Where an edge stands on a hold H, shear f p between it and the place of the hold H - h takes F h of
the shear, with the mean

    F = (4/pi) int_0^(pi/2) f(place of H - h sin^2 t) sin^2 t dt

of the coefficient. On a cylinder, whose hold grows with the square of its half-width, it is that of
f p t/sqrt(t^2 - c^2) over places t from the stick zone c to a, the weight of shear on both sides of
it (Tada, Paris and Irwin 2000); on other contacts that to first order. F = f if it is the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fretfe._typing import Array

# Points of the mean, evenly spaced in t: of a coefficient quadratic in H exact.
POINTS = 24


@dataclass(frozen=True)
class FrictionBehind:
    """Coefficient behind an edge over that at the edge, in one state.

    Attributes:
        place: (n,) inward, counted as positions of the edge are; increasing. Empty if it is the
            same at all of them.
        share: (n,) coefficient there over that at the edge.
    """

    place: Array = field(default_factory=lambda: np.zeros(0))
    share: Array = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def of(cls, place: Array, friction: Array, at_edge: float) -> FrictionBehind:
        """That of coefficients (n,) at places (n,)."""
        if not (at_edge > 0 and np.ptp(friction) > 0):
            return cls()
        order = np.argsort(place)
        return cls(place[order], friction[order] / at_edge)

    @property
    def varies(self) -> bool:
        """True if it is not the same at all places."""
        return len(self.place) > 0

    def at(self, place: Array) -> Array:
        """(m,) that at places (m,)."""
        return np.interp(place, self.place, self.share)

    def made(self, hold: Array, place: Array, edge: float) -> Array:
        """(n,) what the coefficient makes of holds (n,) from 0 on, whose places are given.

        Behind an edge with the hold `edge` by the mean, outside of it by that of each place. Where
        it falls inward so steeply that a longer zone takes less, slip goes on by itself.
        """
        weight = np.sin((np.arange(POINTS) + 0.5) * np.pi / (2 * POINTS)) ** 2
        behind, outside = np.maximum(edge - hold, 0.0), np.maximum(hold - edge, 0.0)
        places = np.interp(edge - behind[:, None] * weight, hold, place)
        taken = behind * (2 / POINTS * self.at(places) @ weight)
        here = self.at(place)
        steps = np.diff(outside, prepend=0.0) * (here + np.append(here[0], here[:-1])) / 2
        return np.maximum.accumulate(taken[0] - taken + np.cumsum(steps))


def straight_inward(s: Array, along: Array, values: Array, size: float) -> tuple[Array, Array]:
    """Places inward (m,) and values there, linear between those of nodes (n,) around a station."""
    if not np.ptp(values) > 0:
        return s[:1], values[:1]
    # Imported where it is needed: SciPy's interpolation takes a second.
    from scipy.interpolate import LinearNDInterpolator

    places = np.arange(s.min(), s.max(), size / 2)
    found = LinearNDInterpolator(np.column_stack([s, along]), values)(places, 0.0)
    inside = np.isfinite(found)
    return places[inside], found[inside]
