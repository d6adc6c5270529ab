# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks of the templates that press a body with some face on a block."""

from __future__ import annotations

import math
from collections.abc import Mapping

from fretfe.geometry.template_checks.bounds import at_least, at_most


def zone_is_inside_faces(values: Mapping[str, float]) -> str | None:
    """The candidate contact zone must end well before the narrower of the two faces does."""
    width = min(values["upper_width"], values["lower_width"])
    return at_most("zone", values, 0.9 * width, "90 % of the smaller of the half widths")


def sides_remain(values: Mapping[str, float], **rises: float) -> str | None:
    """Each body must be higher than its face rises towards the side; the rises by body."""
    problems = []
    for body, rise in rises.items():
        why = f"the face rises by {rise:.6g} and the body needs a side"
        needed = rise + 0.1 * values[f"{body}_width"]
        problems.append(at_least(f"{body}_height", values, needed, why))
    return next(filter(None, problems), None)


def arc_rise(radius: float, length: float) -> float:
    """How far an arc rises over a length from its lowest point; 0 for radius 0, a flat face."""
    return radius - math.sqrt(max(radius**2 - length**2, 0.0))


def size_resolves_zone(values: Mapping[str, float]) -> str | None:
    """Four elements or more to half of the candidate contact zone."""
    return at_most("size", values, values["zone"] / 4, "a quarter of zone")
