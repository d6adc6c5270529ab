# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts that are expected between half-spaces with an initial gap."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array

# A paraboloid is fitted to the gaps within so many half axes around the lowest one, so often; it
# describes them if it misses no more than this part of what they differ by.
REACH = 1.5
FITS = 8
RESIDUAL = 0.2
# A smaller curvature, as part of the larger one, is none.
STRAIGHT = 1e-6


@dataclass(frozen=True)
class HertzContact:
    """A contact between half-spaces, or a cylinder between its ends.

    Attributes:
        half_axes: (2,) a >= b; a is infinite of a cylinder, both where the gap is neither.
        across: (2,) direction of b in the tangent plane, (3,) in space.
        peak: largest pressure, over E* if the load is.
    """

    half_axes: Array
    across: Array
    peak: float

    def k_n(self, curvature: float) -> float:
        """K_N = p0 sqrt(2 g) where the front has a curvature g³ a² b² = 1/curvature.

        g is 1/b beside a cylinder. Source: the pressure p0 sqrt(1 - x²/a² - y²/b²) next to its
        border; checked with circles and at the ends of the half axes.
        """
        a, b = self.half_axes
        g = 1 / b if math.isinf(a) else (curvature * (a * b) ** 2) ** (-1 / 3)
        return float(self.peak * math.sqrt(2 * g))


def expected_contact(places: Array, gap: Array, load: float, nearest: float) -> HertzContact:
    """The contact that is expected between half-spaces with an initial gap.

    The gap near its lowest place is taken for a paraboloid. The contact of a cylinder ends where
    the surfaces do: half-planes under the mean force per length.

    Args:
        places: (n, 2) from the lowest one.
        gap: (n,) initial gap there.
        load: P/E*.
        nearest: gaps up to this distance are looked at in any case.
    """
    inside = np.ones(len(gap), dtype=bool)
    missed, none = np.inf, np.full(2, np.inf)
    peak = np.nan
    for _ in range(FITS):
        (x, y), g = places[inside].T, gap[inside]
        terms = np.stack([np.ones_like(x), x, y, x * x / 2, x * y, y * y / 2], axis=1)
        found = np.linalg.lstsq(terms, g, rcond=None)[0]
        missed = np.ptp(g) and np.std(terms @ found - g) / np.std(g)
        curvatures, axes = np.linalg.eigh([[found[3], found[4]], [found[4], found[5]]])
        if curvatures[1] <= 0:
            return HertzContact(none, axes[:, 1], np.nan)
        own = places @ axes
        half_axes = hertz_half_axes(np.maximum(curvatures, STRAIGHT * curvatures[1]), load)
        length, peak = np.ptp(own[:, 0]), 1.5 * load / (np.pi * half_axes.prod())
        if 2 * half_axes[0] > length:
            half_axes = np.array([np.inf, np.sqrt(4 * load / (length * np.pi * curvatures[1]))])
            peak = 2 * load / (np.pi * length * half_axes[1])
        inside = np.sum((own / half_axes) ** 2, axis=1) < REACH**2
        inside |= np.sum(own**2, axis=1) < nearest**2
    return HertzContact(half_axes if missed < RESIDUAL else none, axes[:, 1], float(peak))


def hertz_half_axes(curvatures: Array, load: float) -> Array:
    """(2,) half axes a >= b of the contact of half-spaces with the gap k1 x²/2 + k2 y²/2.

    With e² = 1 - (b/a)² and the complete elliptic integrals K and E of the modulus e,

        k2/k1 = ((a/b)² E - K) / (K - E),    a³ = 3 (P/E*) E / (pi (b/a)² (k1 + k2))

    Source: Hertz; K. L. Johnson, Contact Mechanics, section 4.2. Valid for elastic bodies without
    friction, or of equal elastic constants, and axes that are small against the radii.

    Args:
        curvatures: (2,) 0 < k1 <= k2.
        load: P/E*.
    """
    # Imported where it is needed: SciPy's functions take a tenth of a second, and to import its
    # root finders three times as long as all bisections.
    from scipy.special import ellipe, ellipkm1

    def excess(logarithm: float) -> float:
        t = np.exp(2 * logarithm)
        first, second = ellipkm1(t), ellipe(1 - t)
        return float((second / t - first) / (first - second) - curvatures[1] / curvatures[0])

    circle = -1e-6  # of log(b/a): nearer to a circle both differences are round-off
    low, high = -12.0, circle if excess(circle) < 0 else 0.0
    while high < 0 and low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    logarithm = high
    t = np.exp(2 * logarithm)
    a = np.cbrt(3 * load * ellipe(1 - t) / (np.pi * t * curvatures.sum()))
    return np.array([a, a * np.exp(logarithm)])
