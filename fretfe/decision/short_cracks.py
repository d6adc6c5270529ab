# SPDX-License-Identifier: LGPL-3.0-or-later
"""Short cracks that start at an edge: their drive through the cycle at any angle, and arrest.

They are straight edge cracks of a half-plane under the stress of the uncracked body: shorter than
the distance to anything else. While their faces are pressed together they have no drive
(`opening_range`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.analytic.cracks import EdgeCracks
from fretfe.decision.field import EdgeField
from fretfe.decision.thresholds import (
    FatigueLimit,
    Threshold,
    arrest_length,
    opening_range,
    short_length,
    short_threshold,
)

# Degrees from the inward normal.
CRACK_ANGLES = np.arange(-60.0, 61.0, 10.0)


@dataclass(frozen=True)
class CrackDrive:
    """Stress intensity of cracks at A angles and C lengths; NaN beyond what is known.

    Attributes:
        angles: (A,) from the inward normal, positive under the contact [degrees].
        lengths: (C,) along the cracks, increasing [length].
        k_1, k_2: (n, A, C) through the cycle.
        ranges: (A, C) ΔK as of `opening_range`.
        ratios: (A, C) R of the part that opens them.
        cut: (A,) whether cracks leave what is known aside, before the depth to which that is.
    """

    angles: Array
    lengths: Array
    k_1: Array
    k_2: Array
    ranges: Array
    ratios: Array
    cut: Bools


def crack_drive(field: EdgeField, shortest: float, angles: Array = CRACK_ANGLES) -> CrackDrive:
    """The drive of cracks from the mouth of a field, of all lengths that are known.

    Args:
        field: without cracks.
        shortest: length.
        angles: (A,) in degrees, up to 80.
    """
    turns = np.radians(angles)
    reaches = [field.reach(float(each)) for each in turns]
    # Fifteen a decade, between which lengths of arrest are interpolated.
    longest = max(reaches)
    lengths = np.geomspace(shortest, longest, 2 + int(15 * math.log10(longest / shortest)))
    factors = np.full((2, len(field.states), len(angles), len(lengths)), np.nan)
    for place, (turn, reach) in enumerate(zip(turns, reaches, strict=True)):
        inside = lengths <= reach * (1 + 1e-9)
        if inside.any():
            factors[:, :, place, inside] = _factors(field, float(turn), lengths[inside])
    ranges, ratios = opening_range(factors[0], factors[1])
    cut = np.array(reaches) < field.reach(0.0) * (1 - 1e-9)
    return CrackDrive(angles, lengths, factors[0], factors[1], ranges, ratios, cut)


@cache
def _cracks(turn: float) -> EdgeCracks:
    """Cracks at one angle: those of every edge are judged at the same ones."""
    return EdgeCracks.of([turn])


def _factors(field: EdgeField, turn: float, lengths: Array) -> Array:
    """(2, n, C) K_I and K_II of cracks at one angle.

    The stress goes with the root of the distance next to an edge: straight in that between places.
    """
    cracks = _cracks(turn)
    roots = np.linspace(0, 1, 120) ** 2 * math.sqrt(lengths[-1])
    stress = field.along(turn, roots**2)[..., [0, 1, 3]]
    wanted = np.sqrt(np.multiply.outer(lengths, cracks.places))
    above = np.clip(np.searchsorted(roots, wanted), 1, len(roots) - 1)
    share = ((wanted - roots[above - 1]) / (roots[above] - roots[above - 1]))[..., None]
    on_crack = (1 - share) * stress[:, above - 1] + share * stress[:, above]
    return np.asarray(cracks.factors(lengths, on_crack[:, None])[:, :, 0])


def first_length(a0: float) -> float:
    """A tenth of a0, of a crack that starts: its threshold is 5 % below that of the limit."""
    return 0.1 * a0


@dataclass(frozen=True)
class Crack:
    """A crack at one angle.

    Attributes:
        angle: from the inward normal, positive under the contact [degrees].
        stop: length at which it stops: 0 if the shortest one does not grow, infinite if it grows
            through all lengths.
        lengths, ranges, threshold: (C,) its lengths, ΔK and ΔK_th, as far as known.
        cut: as of `CrackDrive`: it may stop beyond.
    """

    angle: float
    stop: float
    lengths: Array
    ranges: Array
    threshold: Array
    cut: bool = False

    @property
    def relative(self) -> Array:
        """(C,) ΔK over ΔK_th."""
        return self.ranges / self.threshold

    @property
    def followed(self) -> bool:
        """True if it is nearest to stopping before the last length: it may not stop beyond."""
        return not self.cut and int(np.argmin(self.relative)) < len(self.lengths) - 1


@dataclass(frozen=True)
class Arrest:
    """Growth and arrest of the cracks of an edge at all angles.

    Attributes:
        deepest: the one that stops last, or is farthest from stopping.
        critical: the one that sets the margin. As the stress rises, cracks at other angles may stop
            deeper, but this one is the first that grows through.
        margin: factor of all stresses up to which cracks stop within the lengths; infinite where
            the stress of any factor closes them.
        largest: the same of the cracks that are `followed`: the margin if all others stop beyond.
        start: factor up to which no crack of a tenth of a0 grows at any angle; NaN where the
            shortest cracks that are looked at are longer.
        a0: of short cracks.
    """

    deepest: Crack
    critical: Crack
    margin: float
    largest: float
    start: float
    a0: float


def judge_arrest(drive: CrackDrive, threshold: Threshold, limit: FatigueLimit) -> Arrest | str:
    """Growth or arrest of cracks at all angles, or the reason why it is not known.

    Args:
        drive: of cracks at all angles.
        threshold: of long cracks, in the units of the drive, known at the R of the limit.
        limit: of smooth specimens.
    """
    a0 = short_length(threshold, limit)
    known = np.isfinite(drive.ranges)
    long = threshold.at(np.where(drive.ranges > 0, drive.ratios, 0.0))
    if (lost := known & ~np.isfinite(long)).any():
        return f"the threshold is not known at R = {drive.ratios[lost].max():.2g} of a crack"
    short = short_threshold(drive.lengths, long, a0)
    cracks = [
        Crack(angle, arrest_length(drive.lengths[own], ranges[own] / least[own]),
              drive.lengths[own], ranges[own], least[own], cut)
        for angle, own, ranges, least, cut in zip(
            map(float, drive.angles), known, drive.ranges, short, drive.cut.tolist(), strict=True
        ) if own.any()
    ]  # fmt: skip
    critical = max(cracks, key=lambda each: (each.relative.min(), each.stop))
    followed = [float(each.relative.min()) for each in cracks if each.followed]
    first = max(float(each.relative[0]) for each in cracks)
    return Arrest(
        deepest=max(cracks, key=lambda each: (each.stop, each.relative.min())),
        critical=critical,
        margin=_factor(float(critical.relative.min())),
        largest=_factor(max(followed, default=0.0)),
        start=_factor(first) if drive.lengths[0] <= first_length(a0) * (1 + 1e-9) else math.nan,
        a0=a0,
    )


def _factor(relative: float) -> float:
    """By which a drive over its threshold becomes 1."""
    return 1 / relative if relative > 0 else math.inf
