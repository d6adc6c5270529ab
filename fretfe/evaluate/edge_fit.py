# SPDX-License-Identifier: LGPL-3.0-or-later
"""Position and K_N of an edge, with their error bars, between similar and unlike bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array

# Error of K_N between unlike bodies, over |lambda - 1/2| of an edge that slides: with slip zones of
# some elements at least, and how much larger with fewer, up to so many times. Coarse half-planes
# beside fine ones, and solids with their pressures, are off by up to 2.8 with less than an element
# to a zone, 2.7 with one, 2.2 with two and .7 with more than four.
BEYOND_SLIP = 0.75
WINDOW = 6.0
MOST_BEYOND = 4.0


@dataclass(frozen=True)
class EdgeFit:
    """Position along the arc and K_N (stress over root of length), with error bars; (T,) each.

    Of solids the position is that of the front, inward from the reference front. A spread is half
    the width of an interval that is meant to hold the truth with 95 %. The pressure is
    K_N s^exponent; where that is not a root, K_N is that at the reference length 1.
    """

    position: Array
    k_n: Array
    spread_position: Array
    spread_k_n: Array
    exponent: Array | float = 0.5

    def told(self, length: float) -> Array:
        """Return K_N = p(length)/sqrt(length) of the power law."""
        return np.asarray(length ** (np.asarray(self.exponent) - 0.5) * self.k_n)

    def at(self, length: float, zone: Array | float, sliding: float) -> EdgeFit:
        """Return the fit with K_N as told at a length.

        Its error bar holds what the fits cannot see, the more the fewer elements the zone has.

        Args:
            length: at which K_N is told.
            zone: (T,) length of the slip zone in elements, or one for all.
            sliding: |lambda - 1/2| where the edge slides. Just after a reversal, and in zones
                shorter than an element, lambda is not known any better.
        """
        apart, k_n = np.asarray(self.exponent) - 0.5, self.told(length)
        beyond = BEYOND_SLIP * np.clip(WINDOW / np.maximum(zone, WINDOW / MOST_BEYOND), 1.0, None)
        largest = np.maximum(sliding, np.fmax.reduce(np.atleast_1d(np.abs(apart))))
        spread = np.hypot(length**apart * self.spread_k_n, beyond * largest * k_n)
        return replace(self, k_n=k_n, spread_k_n=spread)
