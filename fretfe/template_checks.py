# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks between the parameters of a geometry template: do they describe a body that can exist.

Each check takes all parameters of its template (lengths in mm, angles in degrees, each inside its
own range) and returns what is wrong in the user's terms, or None.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import SimpleNamespace

Check = Callable[[Mapping[str, float]], str | None]

# Bodies must stay apart by this fraction of the neck width outside the contact surfaces, far more
# than elastic displacements.
NECK_CLEARANCE = 0.01


def _at_least(name: str, values: Mapping[str, float], bound: float, why: str) -> str | None:
    if values[name] >= bound:
        return None
    return f"{name}: expected at least {bound:.6g} ({why}), found {values[name]:g}"


def _at_most(name: str, values: Mapping[str, float], bound: float, why: str) -> str | None:
    if values[name] <= bound:
        return None
    return f"{name}: expected at most {bound:.6g} ({why}), found {values[name]:g}"


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


def _contact_ends_on_roundings(values: Mapping[str, float]) -> str | None:
    limit = min(values["relief_angle"], 90 - values["flank_angle"]) - 5
    why = "5 degrees less than relief_angle and than 90 - flank_angle"
    return _at_most("contact_angle", values, limit, why)


def _disc_flank_covers_contact(values: Mapping[str, float]) -> str | None:
    radius = max(values["upper_radius"], values["lower_radius"])
    reach = radius * math.sin(math.radians(values["contact_angle"])) + values["flank_size"]
    why = "the flat of the disc must cover the candidate contact on the larger rounding"
    return _at_least("overhang", values, reach, why)


def _fine_zone_fits(values: Mapping[str, float]) -> str | None:
    radius = min(values["upper_radius"], values["lower_radius"])
    arc = 0.9 * radius * math.radians(values["contact_angle"])
    bound = min(arc, 0.45 * values["flank_length"])
    why = "90 % of the candidate contact on the smaller rounding, 45 % of the flat"
    return _at_most("edge_zone", values, bound, why)


def _root_is_high_enough(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    needed = d.flank_length * d.sin + d.lower_radius * d.cos + d.root_corner + d.flank_size
    why = "flat, lower rounding and root corner take that much; a smaller lower_radius helps"
    return _at_least("root_height", values, needed, why)


def _slot_is_deep_enough(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    flank = (d.flank_length + d.overhang) * d.sin
    needed = flank + d.slot_fillet * (1 + d.cos) + d.flank_size - d.root_height
    why = "the flat of the disc and the slot fillets must fit in; a smaller slot_fillet helps"
    return _at_least("slot_clearance", values, needed, why)


def _root_clears_slot_wall(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    missing = NECK_CLEARANCE * d.neck_width - (d.slot - d.root)
    why = "the blade root would touch the side wall of the slot; a larger slot_fillet helps too"
    return _at_least("overhang", values, d.overhang + missing / d.cos, why)


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
    return _at_most(
        "root_corner", values, 0.9 * d.root, "90 % of half the width of the root"
    ) or _at_most("slot_fillet", values, 0.9 * d.slot, "90 % of half the width of the slot")


def _shank_rises_above_fillet(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    needed = d.neck_centre_above_flat - d.disc_top_above_flat + d.flank_size
    return _at_least("shank_height", values, needed, "the neck fillet must end below the top")


def _disc_is_large_enough(values: Mapping[str, float]) -> str | None:
    d = _dovetail(values)
    depth = d.disc_top_above_flat + d.root_height + d.slot_clearance
    return _at_least(
        "disc_width", values, 2 * (d.slot + d.slot_fillet), "width of the slot and its fillets"
    ) or _at_least("disc_depth", values, depth + d.slot_fillet, "depth of the slot and its fillets")


def _flank_size_resolves_flat(values: Mapping[str, float]) -> str | None:
    return _at_most("flank_size", values, values["flank_length"] / 4, "a quarter of the flat")


def _edge_size_is_smallest(values: Mapping[str, float]) -> str | None:
    bound = min(values["flank_size"], values["edge_zone"] / 2)
    return _at_most("edge_size", values, bound, "flank_size, and half of edge_zone")


def _faces_are_less_than_half_cylinders(values: Mapping[str, float]) -> str | None:
    problems = [
        _at_most(f"{body}_width", values, 0.99 * values[f"{body}_radius"], f"{body}_radius")
        for body in ("upper", "lower")
        if values[f"{body}_radius"] > 0
    ]
    return next(filter(None, problems), None)


def _zone_is_inside_faces(values: Mapping[str, float]) -> str | None:
    width = min(values["upper_width"], values["lower_width"])
    return _at_most("zone", values, 0.9 * width, "90 % of the smaller of the half widths")


def _sides_remain(values: Mapping[str, float], **rises: float) -> str | None:
    """Each body must be higher than its face rises towards the side; the rises by body."""
    problems = []
    for body, rise in rises.items():
        why = f"the face rises by {rise:.6g} and the body needs a side"
        needed = rise + 0.1 * values[f"{body}_width"]
        problems.append(_at_least(f"{body}_height", values, needed, why))
    return next(filter(None, problems), None)


def _arc_rise(radius: float, length: float) -> float:
    """How far an arc rises over a length from its lowest point; 0 for radius 0, a flat face."""
    return radius - math.sqrt(max(radius**2 - length**2, 0.0))


def _bodies_are_higher_than_faces(values: Mapping[str, float]) -> str | None:
    upper = _arc_rise(values["upper_radius"], values["upper_width"])
    lower = _arc_rise(values["lower_radius"], values["lower_width"])
    return _sides_remain(values, upper=upper, lower=lower)


def _size_resolves_zone(values: Mapping[str, float]) -> str | None:
    return _at_most("size", values, values["zone"] / 4, "a quarter of zone")


def _bodies_are_higher_than_wedge(values: Mapping[str, float]) -> str | None:
    rise = values["upper_width"] * math.tan(math.radians(values["angle"]))
    return _sides_remain(values, upper=rise, lower=0.0)


def _roundings_reach_sides(values: Mapping[str, float]) -> str | None:
    needed = (values["upper_width"] - values["flat_half_width"]) / 0.99
    why = "the roundings must reach the sides of the upper body; a smaller upper_width helps"
    return _at_least("radius", values, needed, why)


def _zone_ends_on_roundings(values: Mapping[str, float]) -> str | None:
    needed = values["flat_half_width"] + 4 * values["edge_size"]
    why = "the contact ends beyond flat_half_width; four elements of edge_size must fit in there"
    return _at_least("zone", values, needed, why)


def _bodies_are_higher_than_roundings(values: Mapping[str, float]) -> str | None:
    rise = _arc_rise(values["radius"], values["upper_width"] - values["flat_half_width"])
    return _sides_remain(values, upper=rise, lower=0.0)


def _flat_size_resolves_punch(values: Mapping[str, float]) -> str | None:
    return _at_most("flat_size", values, values["flat_half_width"] / 2, "half of flat_half_width")


def _edge_size_within_flat_size(values: Mapping[str, float]) -> str | None:
    return _at_most("edge_size", values, values["flat_size"], "flat_size")


CROSS_CHECKS: Mapping[str, tuple[Check, ...]] = {
    "dovetail": (
        _contact_ends_on_roundings,
        _disc_flank_covers_contact,
        _fine_zone_fits,
        _root_is_high_enough,
        _slot_is_deep_enough,
        _root_clears_slot_wall,
        _root_corner_clears_slot_fillet,
        _neck_passes_mouth,
        _corners_fit,
        _shank_rises_above_fillet,
        _disc_is_large_enough,
        _flank_size_resolves_flat,
        _edge_size_is_smallest,
    ),
    "cylinder": (
        _faces_are_less_than_half_cylinders,
        _zone_is_inside_faces,
        _bodies_are_higher_than_faces,
        _size_resolves_zone,
    ),
    "flat_rounded": (
        _roundings_reach_sides,
        _zone_is_inside_faces,
        _zone_ends_on_roundings,
        _bodies_are_higher_than_roundings,
        _flat_size_resolves_punch,
        _edge_size_within_flat_size,
    ),
    "wedge": (
        _zone_is_inside_faces,
        _bodies_are_higher_than_wedge,
        _size_resolves_zone,
    ),
}
