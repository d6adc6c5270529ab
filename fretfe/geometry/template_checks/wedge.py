# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks between the parameters of the template `wedge` (meshes/wedge.geo)."""

from __future__ import annotations

import math
from collections.abc import Mapping

from fretfe.geometry.template_checks.blocks import (
    sides_remain,
    size_resolves_zone,
    zone_is_inside_faces,
)
from fretfe.geometry.template_checks.bounds import Check


def _bodies_are_higher_than_wedge(values: Mapping[str, float]) -> str | None:
    rise = values["upper_width"] * math.tan(math.radians(values["angle"]))
    return sides_remain(values, upper=rise, lower=0.0)


CHECKS: tuple[Check, ...] = (
    zone_is_inside_faces,
    _bodies_are_higher_than_wedge,
    size_resolves_zone,
)
