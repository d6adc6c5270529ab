# SPDX-License-Identifier: LGPL-3.0-or-later
"""Short cracks that start at an edge: their drive through the cycle at any angle, and arrest.

They are straight edge cracks of a half-plane under the stress of the uncracked body: shorter than
the distance to anything else, and their faces do not touch. That they press the faces together
counts as no drive (`opening_range`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
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
    """

    angles: Array
    lengths: Array
    k_1: Array
    k_2: Array
    ranges: Array
    ratios: Array


def crack_drive(
    field: EdgeField, shortest: float = 0.0, angles: Array = CRACK_ANGLES
) -> CrackDrive:
    """The drive of cracks from the mouth of a field, from an element to all that is known.

    Args:
        field: without cracks.
        shortest: length, if that is longer than an element.
        angles: (A,) in degrees, up to 80.
    """
    turns = np.radians(angles)
    reaches = [field.reach(float(each)) for each in turns]
    lengths = np.geomspace(max(field.size, shortest), max(reaches), 40)
    factors = np.full((2, len(field.states), len(angles), len(lengths)), np.nan)
    for place, (turn, reach) in enumerate(zip(turns, reaches, strict=True)):
        inside = lengths <= reach * (1 + 1e-9)
        if inside.any():
            factors[:, :, place, inside] = _factors(field, float(turn), lengths[inside])
    ranges, ratios = opening_range(factors[0], factors[1])
    return CrackDrive(angles, lengths, factors[0], factors[1], ranges, ratios)


def _factors(field: EdgeField, turn: float, lengths: Array) -> Array:
    """(2, n, C) K_I and K_II of cracks at one angle.

    The stress goes with the root of the distance next to an edge: straight in that between places.
    """
    cracks = EdgeCracks.of([turn])
    roots = np.linspace(0, 1, 120) ** 2 * math.sqrt(lengths[-1])
    stress = field.along(turn, roots**2)[..., [0, 1, 3]]
    wanted = np.sqrt(np.multiply.outer(lengths, cracks.places))
    above = np.clip(np.searchsorted(roots, wanted), 1, len(roots) - 1)
    share = ((wanted - roots[above - 1]) / (roots[above] - roots[above - 1]))[..., None]
    on_crack = (1 - share) * stress[:, above - 1] + share * stress[:, above]
    return np.asarray(cracks.factors(lengths, on_crack[:, None])[:, :, 0])


@dataclass(frozen=True)
class Arrest:
    """Cracks at the angle at which they are least likely to stop.

    Attributes:
        angle: from the inward normal, positive under the contact [degrees].
        length: at which a crack stops: 0 if none starts, infinite if it grows through all lengths.
        longest: of the lengths at this angle.
        margin: factor of all stresses up to which cracks stop within these lengths; infinite where
            the stress of any factor closes them.
        start: factor up to which no crack of the shortest length grows at any angle.
        place: length at which the drive is least against its threshold.
        a0: of short cracks.
        lengths, ranges, threshold: (C,) of cracks at this angle, their ΔK and ΔK_th, as far as
            known.
    """

    angle: float
    length: float
    longest: float
    margin: float
    start: float
    place: float
    a0: float
    lengths: Array
    ranges: Array
    threshold: Array


def judge_arrest(drive: CrackDrive, threshold: Threshold, limit: FatigueLimit) -> Arrest | str:
    """Growth or arrest of cracks at the worst angle, or the reason why it is not known.

    Args:
        drive: of cracks at all angles.
        threshold: of long cracks, in the units of the drive.
        limit: of smooth specimens.
    """
    a0 = short_length(threshold, limit)
    if not math.isfinite(a0):
        return f"the threshold is not known at the R of the limit, {limit.ratio:g}"
    known = np.isfinite(drive.ranges)
    long = threshold.at(np.where(drive.ranges > 0, drive.ratios, 0.0))
    if (lost := known & ~np.isfinite(long)).any():
        return f"the threshold is not known at R = {drive.ratios[lost].max():.2g} of a crack"
    short = short_threshold(drive.lengths, long, a0)
    relative = drive.ranges / short
    worst, least, stop = max(
        (_least(drive, relative, int(each)) for each in np.flatnonzero(known.any(axis=1))),
        key=lambda each: each[1:],
    )
    own, first = known[worst], float(np.nanmax(relative[:, 0]))
    lengths = drive.lengths[own]
    return Arrest(
        angle=float(drive.angles[worst]),
        length=stop,
        longest=float(lengths[-1]),
        margin=1 / least if least > 0 else math.inf,
        start=1 / first if first > 0 else math.inf,
        place=float(lengths[int(np.argmin(relative[worst, own]))]),
        a0=a0,
        lengths=lengths,
        ranges=drive.ranges[worst, own],
        threshold=short[worst, own],
    )


def _least(drive: CrackDrive, relative: Array, place: int) -> tuple[int, float, float]:
    """Number of an angle, the least drive there over its threshold, and where a crack stops."""
    known = np.isfinite(relative[place])
    own = relative[place, known]
    return place, float(own.min()), arrest_length(drive.lengths[known], own)
