# SPDX-License-Identifier: LGPL-3.0-or-later
"""The zone next to an edge in which the pressure rises, and the elements that tell K_N there.

Foresight, reasons and meshes that refine themselves decide by this alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

# Elements over the rise of a pressure with which K_N is known to a twentieth. Finite elements: 5 on
# cylinders and wedges, 7 on flats with rounded ends, 8 with what is not foreseen. Fits along fronts
# of solids take fewer: spheres have a front with 14 across, and bars of .04 with 20.
WANTED_OVER_RISE = {2: 8, 3: 5}
# Nodes from the edge to the largest pressure, which is two rises away for Hertz and on flats with
# rounded ends, and in a contact that rises up to its middle.
WANTED_TO_PEAK = 2 * WANTED_OVER_RISE[2]
WANTED_IN_CONTACT = 2 * WANTED_TO_PEAK


def rise_length(peak: float, k_n: float, half_width: float) -> float:
    """Distance from an edge in which p = K_N sqrt(s) would rise to the largest pressure.

    Half of the half-width for Hertz; about a third of the length of the rounding in contact for a
    flat and rounded punch. At most the half-width.
    """
    return min((peak / k_n) ** 2, half_width) if k_n > 0 else half_width


# Part of the elements wanted from which K_N may well be known: loads and lengths are guesses.
MARGIN = 0.7


@dataclass(frozen=True)
class EdgeZone:
    """The rise of the pressure at an edge, as it is expected, and the elements there.

    Attributes:
        rise: its length, of `rise_length`.
        element: length of an element across the edge.
        dimension: of the bodies.
        shortest: part of the rise that it may be.
    """

    rise: float
    element: float
    dimension: int = 2
    shortest: float = 1.0

    @property
    def elements(self) -> float:
        """Number of elements over the rise."""
        return self.rise / self.element

    @property
    def wanted(self) -> int:
        """Number with which K_N is known to a twentieth, also if the rise is the shortest one."""
        return round(WANTED_OVER_RISE[self.dimension] / self.shortest)

    @property
    def size(self) -> float:
        """Length of elements with which it is."""
        return self.rise / self.wanted

    @property
    def coarse(self) -> bool:
        """True if elements are likely to be too large for K_N, by a rise between both."""
        return math.sqrt(self.shortest) * self.elements < MARGIN * WANTED_OVER_RISE[self.dimension]
