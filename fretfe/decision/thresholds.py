# SPDX-License-Identifier: LGPL-3.0-or-later
"""Growth and arrest of short cracks: thresholds, ranges that count, lives.

Faces that are pressed together have no stress intensity: K counts where it opens the crack, so all
load ratios R = K_min/K_max are 0 or more, and data at R < 0 count with their tension alone. Nothing
is extrapolated: what the data do not cover is NaN.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array

# K_I over √(π c) of a normal edge crack under uniform tension.
EDGE_CRACK = 1.12152


@dataclass(frozen=True)
class Threshold:
    """ΔK_th of long cracks.

    Attributes:
        ratios: (m,) R, increasing; one with an exponent.
        ranges: (m,) ΔK_th there.
        exponent: γ of ΔK_th ~ (1 - R)^γ (Walker, ASTM STP 462, 1970), as tests of the alloy give
            it; NaN of a table, which is interpolated.
    """

    ratios: Array
    ranges: Array
    exponent: float = math.nan

    def at(self, ratio: Array) -> Array:
        """ΔK_th at load ratios R of any shape; NaN beyond a table, and of R outside of 0 <= R < 1.

        Of negative R the tension counts: K_max at the threshold.
        """
        inside = (ratio >= 0) & (ratio < 1)
        open_ratios, opening = np.maximum(self.ratios, 0.0), self._opening
        if np.isfinite(self.exponent):
            rest = np.where(inside, 1 - ratio, np.nan) / (1 - open_ratios[0])
            return np.asarray(opening[0] * rest**self.exponent)
        # Of several negative ratios the last one is nearest to a crack that just closes.
        first = max(int(np.count_nonzero(self.ratios <= 0)) - 1, 0)
        found = np.interp(ratio, open_ratios[first:], opening[first:], left=np.nan, right=np.nan)
        return np.asarray(np.where(inside, found, np.nan))

    @property
    def _opening(self) -> Array:
        """(m,) the part of the ranges that is tension."""
        return np.asarray(self.ranges / (1 - np.minimum(self.ratios, 0.0)))


@dataclass(frozen=True)
class FatigueLimit:
    """Range of the stress that smooth specimens endure under push and pull, and its R < 1."""

    stress_range: float
    ratio: float

    @property
    def tension(self) -> float:
        """The part of the range that is tension."""
        return self.stress_range / (1 - min(self.ratio, 0.0))


def short_length(threshold: Threshold, limit: FatigueLimit) -> float:
    """a0 = (1/π)(ΔK_th/(1.1215 Δσ_fl))² of surface cracks, both at the R of the limit.

    El Haddad, Topper and Smith (Eng. Fract. Mech. 11, 1979), with the factor of an edge crack. NaN
    if the threshold is not known there.
    """
    found = float(threshold.at(np.array(max(limit.ratio, 0.0))))
    return (found / (EDGE_CRACK * limit.tension)) ** 2 / math.pi


def critical_length(threshold: Threshold, limit: FatigueLimit) -> float:
    """L = (1/π)(ΔK_th/Δσ_fl)², both at the R of the limit.

    Of the theory of critical distances (Taylor, Int. J. Fatigue 21, 1999). NaN if the threshold is
    not known there.
    """
    return EDGE_CRACK**2 * short_length(threshold, limit)


def short_threshold(lengths: Array, threshold: Array, a0: float) -> Array:
    """ΔK_th √(c/(c + a0)) of cracks of lengths c (El Haddad, Topper and Smith 1979).

    Args:
        lengths: c; any shape that broadcasts with the threshold.
        threshold: ΔK_th of long cracks.
        a0: of the material.
    """
    return np.asarray(threshold * np.sqrt(lengths / (lengths + a0)))


def opening_range(k_1: Array, k_2: Array) -> tuple[Array, Array]:
    """ΔK and R (...) of cracks through n states (n, ...), straight between them; NaN as given.

    ΔK is the longest chord of the way of (K_I, K_II) while the crack is open, K_I >= 0: the root of
    ΔG E', as the release of energy by both modes adds up. Faces that are pressed together keep
    their shift, so the way goes on from where it closed to where it opens: friction of the faces
    after Coulomb (Dubourg and Villechaise, J. Tribol. 114, 1992) that does not let them slide.
    Growth by shear under pressure is left out. R is that of max(K_I, 0); 0 of cracks that never
    open.
    """
    is_open = k_1 > 0
    turned = is_open[:-1] != is_open[1:]
    share = k_1[:-1] / np.where(turned, k_1[:-1] - k_1[1:], 1.0)
    shifts = k_2[:-1] + share * np.diff(k_2, axis=0)
    # The places at which it closes or opens are as much of the way as the states are.
    opening = np.concatenate([np.where(is_open, k_1, np.nan), np.where(turned, 0.0, np.nan)])
    sliding = np.concatenate([k_2, shifts])
    longest = np.where(np.isnan(k_1).any(axis=0), np.nan, 0.0)
    for place in range(1, len(opening)):
        chords = np.hypot(opening[:place] - opening[place], sliding[:place] - sliding[place])
        longest = np.maximum(longest, np.fmax.reduce(chords, axis=0, initial=0.0))
    pulls = np.maximum(k_1, 0.0)
    largest = pulls.max(axis=0)
    return longest, pulls.min(axis=0) / np.where(largest > 0, largest, 1.0)


def arrest_length(lengths: Array, drive: Array) -> float:
    """Length at which a crack stops that starts from nothing.

    The shortest one beyond which the drive is less than its threshold: 0 if a crack does not start,
    infinite if it grows through all lengths. Between lengths by straight lines in their logarithms.

    Args:
        lengths: (C,) c > 0, increasing.
        drive: (C,) ΔK over the threshold of a crack of that length.

    Returns:
        The length; NaN if the drive is not known before the crack stops.
    """
    below = np.flatnonzero(~(drive >= 1))
    if not len(below):
        return math.inf
    at = int(below[0])
    if not np.isfinite(drive[at]):
        return math.nan
    if at == 0:
        return 0.0
    share = (drive[at - 1] - 1) / (drive[at - 1] - drive[at])
    return float(lengths[at - 1] * (lengths[at] / lengths[at - 1]) ** share)


@dataclass(frozen=True)
class GrowthLaw:
    """Growth of long cracks per cycle, a table; two points are the law of Paris between them.

    Attributes:
        ranges: (m,) ΔK, increasing.
        rates: (m,) dc/dN, in length per cycle; straight lines between in logarithms.
    """

    ranges: Array
    rates: Array

    @classmethod
    def paris(cls, factor: float, exponent: float, bounds: tuple[float, float]) -> GrowthLaw:
        """dc/dN = C ΔK^m (Paris and Erdogan, J. Basic Eng. 85, 1963), between two tested ΔK."""
        ranges = np.array(bounds)
        return cls(ranges, factor * ranges**exponent)

    def rate(self, ranges: Array) -> Array:
        """dc/dN at ΔK of any shape; NaN outside of the data."""
        logarithms = np.log(np.where(ranges > 0, ranges, np.nan))
        known = np.interp(
            logarithms, np.log(self.ranges), np.log(self.rates), left=np.nan, right=np.nan
        )
        return np.asarray(np.exp(known))


def growth_life(lengths: Array, ranges: Array, law: GrowthLaw, start: float, end: float) -> float:
    """Cycles in which a crack grows from one length to another: the integral of dc/(dc/dN).

    Args:
        lengths: (C,) c > 0, increasing.
        ranges: (C,) ΔK of a crack of that length; a power of it between two of them.
        law: of the material, at the R of the crack.
        start: length at first.
        end: length at last.

    Returns:
        The cycles; NaN if the lengths or the data do not reach so far.
    """
    if not lengths[0] <= start < end <= lengths[-1]:
        return math.nan
    logarithms = np.linspace(math.log(start), math.log(end), 400)
    known = np.where(ranges > 0, ranges, np.nan)
    here = np.exp(np.interp(logarithms, np.log(lengths), np.log(known)))
    return float(np.trapezoid(np.exp(logarithms) / law.rate(here), logarithms))
