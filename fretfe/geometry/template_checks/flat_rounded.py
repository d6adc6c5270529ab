# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks between the parameters of the template `flat_rounded` (meshes/flat_rounded.geo)."""

from __future__ import annotations

from collections.abc import Mapping

from fretfe.geometry.template_checks.blocks import arc_rise, sides_remain, zone_is_inside_faces
from fretfe.geometry.template_checks.bounds import Check, at_least, at_most


def _roundings_reach_sides(values: Mapping[str, float]) -> str | None:
    needed = (values["upper_width"] - values["flat_half_width"]) / 0.99
    why = "the roundings must reach the sides of the upper body; a smaller upper_width helps"
    return at_least("radius", values, needed, why)


def _zone_ends_on_roundings(values: Mapping[str, float]) -> str | None:
    needed = values["flat_half_width"] + 4 * values["edge_size"]
    why = "the contact ends beyond flat_half_width; four elements of edge_size must fit in there"
    return at_least("zone", values, needed, why)


def _bodies_are_higher_than_roundings(values: Mapping[str, float]) -> str | None:
    rise = arc_rise(values["radius"], values["upper_width"] - values["flat_half_width"])
    return sides_remain(values, upper=rise, lower=0.0)


def _flat_size_resolves_punch(values: Mapping[str, float]) -> str | None:
    return at_most("flat_size", values, values["flat_half_width"] / 2, "half of flat_half_width")


def _edge_size_within_flat_size(values: Mapping[str, float]) -> str | None:
    return at_most("edge_size", values, values["flat_size"], "flat_size")


CHECKS: tuple[Check, ...] = (
    _roundings_reach_sides,
    zone_is_inside_faces,
    _zone_ends_on_roundings,
    _bodies_are_higher_than_roundings,
    _flat_size_resolves_punch,
    _edge_size_within_flat_size,
)
