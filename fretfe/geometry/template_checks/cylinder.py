# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks between the parameters of the template `cylinder` (meshes/cylinder.geo)."""

from __future__ import annotations

from collections.abc import Mapping

from fretfe.geometry.template_checks.blocks import (
    arc_rise,
    sides_remain,
    size_resolves_zone,
    zone_is_inside_faces,
)
from fretfe.geometry.template_checks.bounds import Check, at_most


def _faces_are_less_than_half_cylinders(values: Mapping[str, float]) -> str | None:
    problems = [
        at_most(f"{body}_width", values, 0.99 * values[f"{body}_radius"], f"{body}_radius")
        for body in ("upper", "lower")
        if values[f"{body}_radius"] > 0
    ]
    return next(filter(None, problems), None)


def _bodies_are_higher_than_faces(values: Mapping[str, float]) -> str | None:
    upper = arc_rise(values["upper_radius"], values["upper_width"])
    lower = arc_rise(values["lower_radius"], values["lower_width"])
    return sides_remain(values, upper=upper, lower=lower)


CHECKS: tuple[Check, ...] = (
    _faces_are_less_than_half_cylinders,
    zone_is_inside_faces,
    _bodies_are_higher_than_faces,
    size_resolves_zone,
)
