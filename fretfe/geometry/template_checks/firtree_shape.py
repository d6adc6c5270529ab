# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the arcs of a firtree lie, computed as meshes/firtree.geo does; right half, lengths in mm.

Directions are angles to the x axis in radians. Normals point out of the blade.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

Point = tuple[float, float]

# The normals of the backs of the lobes point down by at most this: the lobes narrow outwards.
LOWEST_NORMAL = 80.0


def direction(angle: float) -> Point:
    """The unit vector at an angle."""
    return math.cos(angle), math.sin(angle)


def along(end: Point, start: Point, normal: float) -> float:
    """Distance from start to end along the line of a normal, positive towards the blade."""
    x, y = direction(normal - math.pi / 2)
    return (end[0] - start[0]) * x + (end[1] - start[1]) * y


@dataclass(frozen=True)
class Lobe:
    """One lobe of the right half.

    Attributes:
        above: normal of the straight piece above the lobe: the neck, or the back of the next lobe.
        below: normal of the straight piece below the lobe.
        fillet: centre of the neck fillet.
        tooth: centre of the tip of the disc tooth.
        groove: centre of the groove of the disc.
        upper_flat: how far the flat of the disc goes beyond the upper end of that of the blade.
        lower_flat: the same at the lower end.
    """

    above: float
    below: float
    fillet: Point
    tooth: Point
    groove: Point
    upper_flat: float
    lower_flat: float


class Firtree:
    """Arcs and levels of a firtree whose pitch is not below `smallest_pitch`.

    Attributes:
        normal: of the flanks.
        relieved: normal where an upper rounding meets the neck fillet.
        back: normal of the backs of the lobes.
        back_length: length of the straight backs of the blade.
        root: half of the width of the root.
        slot_bottom: y of the bottom of the slot; y = 0 half way down the first flank.
        disc_top: y of the top of the disc.
        lobes: from the top down.
    """

    def __init__(self, values: Mapping[str, float]) -> None:
        self._values = values
        self.normal = math.radians(90 - values["flank_angle"])
        self.relieved = self.normal + math.radians(values["relief_angle"])
        fillet, lower = _first_lobe(values)
        step = _step(values)
        x, y = fillet[0] + step[0] - lower[0], fillet[1] + step[1] - lower[1]
        radii = values["lower_radius"] + values["neck_fillet"]
        self.back = math.atan2(y, x) + math.acos(radii / math.hypot(x, y))
        self.back_length = math.sqrt(x**2 + y**2 - radii**2)
        count = round(values["lobes"])
        self.lobes = tuple(self._lobe(number, count) for number in range(count))
        self.root = lower[0] + (count - 1) * step[0] + values["lower_radius"]
        upper_end = values["flank_length"] / 2 * math.cos(self.normal) + (count - 1) * step[1]
        self.slot_bottom = upper_end - values["root_height"] - values["slot_clearance"]
        self.disc_top = self.lobes[0].tooth[1] + values["rim_height"]

    def _lobe(self, number: int, count: int) -> Lobe:
        values = self._values
        above = self.back if number > 0 else 0.0
        below = self.back if number < count - 1 else 0.0
        first, crest = _first_lobe(values)
        step = _step(values)
        fillet = (first[0] + number * step[0], first[1] + number * step[1])
        crest = (crest[0] + number * step[0], crest[1] + number * step[1])
        level = _dot(crest, self.normal) + values["lower_radius"] + self._gap(number, count)
        behind = _dot(fillet, above) - values["neck_fillet"] + values["flank_clearance"]
        beyond = _dot(crest, below) + values["lower_radius"] + values["flank_clearance"]
        tooth_radius, groove_radius = values["tooth_radius"], values["groove_radius"]
        tooth = _crossing(self.normal, level + tooth_radius, above, behind + tooth_radius)
        groove = _crossing(self.normal, level - groove_radius, below, beyond - groove_radius)
        from_lower_end = along(tooth, crest, self.normal)
        return Lobe(
            above,
            below,
            fillet,
            tooth,
            groove,
            upper_flat=-from_lower_end - values["flank_length"],
            lower_flat=along(groove, crest, self.normal),
        )

    def _gap(self, number: int, count: int) -> float:
        """Initial gap of a lobe along its normal."""
        step = self._values["lobe_gap"]
        return step * number if step >= 0 else -step * (count - 1 - number)


def smallest_pitch(values: Mapping[str, float]) -> float:
    """The pitch at which the backs of the lobes have the normal `LOWEST_NORMAL`.

    The back touches the circles of the lower rounding (centre L) and of the next fillet (centre F)
    from different sides, so (F - L) . m = sum of their radii, with m its normal; F moves along the
    wedge with the pitch.
    """
    lowest = math.radians(-LOWEST_NORMAL)
    fillet, lower = _first_lobe(values)
    radii = values["lower_radius"] + values["neck_fillet"]
    missing = radii - _dot(fillet, lowest) + _dot(lower, lowest)
    return missing * values["pitch"] / _dot(_step(values), lowest)


def _first_lobe(values: Mapping[str, float]) -> tuple[Point, Point]:
    """Centres of the neck fillet and of the lower rounding of lobe 1."""
    normal = math.radians(90 - values["flank_angle"])
    x, y = direction(normal)
    relieved_x, relieved_y = direction(normal + math.radians(values["relief_angle"]))
    radius, fillet, length = (values[k] for k in ("upper_radius", "neck_fillet", "flank_length"))
    fillet_x = values["neck_width"] / 2 + fillet
    upper_x = fillet_x - (radius + fillet) * relieved_x
    upper_y = length / 2 * x - radius * y
    lower_x = upper_x + (radius - values["lower_radius"]) * x + length * y
    lower_y = upper_y + (radius - values["lower_radius"]) * y - length * x
    return (fillet_x, upper_y + (radius + fillet) * relieved_y), (lower_x, lower_y)


def _step(values: Mapping[str, float]) -> Point:
    """From a lobe to the next one below it."""
    x, y = direction(math.radians(values["wedge_angle"]))
    return -values["pitch"] * y, -values["pitch"] * x


def _dot(point: Point, normal: float) -> float:
    x, y = direction(normal)
    return point[0] * x + point[1] * y


def _crossing(first: float, level1: float, second: float, level2: float) -> Point:
    """Where two lines cross, each given by its normal and the distance from the origin."""
    (x1, y1), (x2, y2) = direction(first), direction(second)
    cross = x1 * y2 - y1 * x2
    return (level1 * y2 - level2 * y1) / cross, (x1 * level2 - x2 * level1) / cross
