# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks between the parameters of the template `dovetail` (meshes/dovetail.geo)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import SimpleNamespace

from fretfe.geometry.template_checks.bounds import NECK_CLEARANCE, Check, at_least, at_most
from fretfe.geometry.template_checks.flanks import (
    contact_ends_on_roundings,
    edge_size_is_smallest,
    fine_zone_fits,
    flank_size_resolves_flat,
)


def _dovetail(values: Mapping[str, float]) -> SimpleNamespace:
    """The parameters as attributes, and half widths that follow from them (see dovetail.geo)."""
    d = SimpleNamespace(**values)
    d.sin = math.sin(math.radians(d.flank_angle))
    d.cos = math.cos(math.radians(d.flank_angle))
    relief = math.radians(d.flank_angle - d.relief_angle)
    d.upper_x = (
        d.neck_width / 2
        + d.neck_fillet
        + d.upper_radius * d.sin
        - (d.upper_radius + d.neck_fillet) * math.sin(relief)
    )
    d.lower_x = d.upper_x + d.flank_length * d.cos
    d.root = d.lower_x + d.lower_radius * (1 - d.sin)
    d.slot = d.lower_x + d.overhang * d.cos + d.slot_fillet * (1 - d.sin)
    d.mouth = d.upper_x - d.overhang * d.cos - d.mouth_radius * (1 - d.sin)
    d.neck_centre_above_flat = (d.upper_radius + d.neck_fillet) * math.cos(
        relief
    ) - d.upper_radius * d.cos
    d.mouth_centre_above_flat = d.overhang * d.sin + d.mouth_radius * d.cos
    d.disc_top_above_flat = d.mouth_centre_above_flat + d.mouth_height
    return d


def _disc_flank_covers_contact(values: Mapping[str, float]) -> str | None:
    radius = max(values["upper_radius"], values["lower_radius"])
    reach = radius * math.sin(math.radians(values["contact_angle"])) + values["flank_size"]
    why = "the flat of the disc must cover the candidate contact on the larger rounding"
    return at_least("overhang", values, reach, why)


def _root_is_high_enough(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    needed = d.flank_length * d.sin + d.lower_radius * d.cos + d.root_corner + d.flank_size
    why = "flat, lower rounding and root corner take that much; a smaller lower_radius helps"
    return at_least("root_height", values, needed, why)


def _slot_is_deep_enough(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    flank = (d.flank_length + d.overhang) * d.sin
    needed = flank + d.slot_fillet * (1 + d.cos) + d.flank_size - d.root_height
    why = "the flat of the disc and the slot fillets must fit in; a smaller slot_fillet helps"
    return at_least("slot_clearance", values, needed, why)


def _root_clears_slot_wall(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    missing = NECK_CLEARANCE * d.neck_width - (d.slot - d.root)
    why = "the blade root would touch the side wall of the slot; a larger slot_fillet helps too"
    return at_least("overhang", values, d.overhang + missing / d.cos, why)


def _root_corner_clears_slot_fillet(values: Mapping[str, float]) -> str | None:
    """Distance of the convex root corner from the concave slot fillet around it."""
    d = _dovetail(values)
    x = (d.root - d.root_corner) - (d.slot - d.slot_fillet)
    y = (d.slot_fillet - d.slot_clearance) - d.root_corner
    gap = d.slot_fillet - d.root_corner - math.hypot(max(x, 0.0), max(y, 0.0))
    if min(x, y) <= 0 or gap >= NECK_CLEARANCE * d.neck_width:
        return None
    return (
        f"root_corner: the corners of the root, of radius {d.root_corner:g}, come too near to the"
        f" fillets of the slot, of radius {d.slot_fillet:g} (smallest gap {gap:.3g}); a larger"
        " root_corner, overhang or slot_clearance or a smaller slot_fillet helps"
    )


def _neck_passes_mouth(values: Mapping[str, float]) -> str | None:
    """Distance from the edge of the slot to the neck and its fillet, over their directions."""
    d = _dovetail(values)
    x = d.neck_width / 2 + d.neck_fillet - (d.mouth + d.mouth_radius)
    y = d.neck_centre_above_flat - d.mouth_centre_above_flat
    steps = 50
    angles = [math.radians((90 - d.flank_angle) * step / steps) for step in range(steps + 1)]
    gaps = [d.neck_fillet - d.mouth_radius - x * math.cos(t) - y * math.sin(t) for t in angles]
    if min(gaps) >= NECK_CLEARANCE * d.neck_width:
        return None
    return (
        f"neck_width: the neck with its fillets does not pass through the mouth of the slot, which"
        f" is {2 * d.mouth:.6g} wide (neck_width {d.neck_width:g}, smallest gap {min(gaps):.3g}); a"
        " smaller overhang or mouth_radius or a larger neck_fillet helps"
    )


def _corners_fit(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    return at_most(
        "root_corner", values, 0.9 * d.root, "90 % of half the width of the root"
    ) or at_most("slot_fillet", values, 0.9 * d.slot, "90 % of half the width of the slot")


def _shank_rises_above_fillet(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    needed = d.neck_centre_above_flat - d.disc_top_above_flat + d.flank_size
    return at_least("shank_height", values, needed, "the neck fillet must end below the top")


def _disc_is_large_enough(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    depth = d.disc_top_above_flat + d.root_height + d.slot_clearance
    return at_least(
        "disc_width", values, 2 * (d.slot + d.slot_fillet), "width of the slot and its fillets"
    ) or at_least("disc_depth", values, depth + d.slot_fillet, "depth of the slot and its fillets")


CHECKS: tuple[Check, ...] = (
    contact_ends_on_roundings,
    _disc_flank_covers_contact,
    fine_zone_fits,
    _root_is_high_enough,
    _slot_is_deep_enough,
    _root_clears_slot_wall,
    _root_corner_clears_slot_fillet,
    _neck_passes_mouth,
    _corners_fit,
    _shank_rises_above_fillet,
    _disc_is_large_enough,
    flank_size_resolves_flat,
    edge_size_is_smallest,
)
