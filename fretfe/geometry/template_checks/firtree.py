# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks between the parameters of the template `firtree` (meshes/firtree.geo)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping

from fretfe.geometry.template_checks.bounds import Check, at_least, at_most
from fretfe.geometry.template_checks.firtree_shape import (
    LOWEST_NORMAL,
    Firtree,
    Lobe,
    along,
    direction,
    smallest_pitch,
)
from fretfe.geometry.template_checks.flanks import (
    contact_ends_on_roundings,
    edge_size_is_smallest,
    fine_zone_fits,
    flank_size_resolves_flat,
)

# A gap between curved parts may be smaller than the clearance between straight ones, to this part.
CURVED_GAP = 0.5
# The lowest neck is at least this part of the uppermost.
LOWEST_NECK = 0.15


def _shape(values: Mapping[str, float]) -> Firtree | None:
    """The shape; None where the lobes do not fit into the pitch, which has a check of its own."""
    return Firtree(values) if values["pitch"] >= smallest_pitch(values) else None


def _lobes_fit_pitch(values: Mapping[str, float]) -> str | None:
    why = (
        f"the backs of the lobes must slope by {90 - LOWEST_NORMAL:g} degrees or more; a smaller"
        " flank_length, lower_radius, upper_radius or neck_fillet helps too"
    )
    return at_least("pitch", values, smallest_pitch(values), why)


def _backs_are_straight(values: Mapping[str, float]) -> str | None:
    """A straight piece between the arcs at the back of every lobe, of the blade and of the disc."""
    shape = _shape(values)
    if shape is None:
        return None
    lobes = shape.lobes
    disc = [
        along(lower.tooth, upper.groove, shape.back) for upper, lower in itertools.pairwise(lobes)
    ]
    length = min(shape.back_length, *disc)
    if length >= values["flank_size"]:
        return None
    return (
        f"pitch: the straight backs of the lobes and of the disc teeth are only {length:.3g} long,"
        f" expected at least flank_size, {values['flank_size']:g} (pitch {values['pitch']:g}); a"
        " larger pitch, or smaller neck_fillet, tooth_radius or groove_radius helps"
    )


def _neck_fillets_turn_less_than_half(values: Mapping[str, float]) -> str | None:
    shape = _shape(values)
    if shape is None or math.degrees(shape.relieved - shape.back) <= 170:
        return None
    return (
        f"relief_angle: from the back of a lobe to the rounding below it the neck fillet turns by"
        f" {math.degrees(shape.relieved - shape.back):.4g} degrees, expected at most 170"
        f" (relief_angle {values['relief_angle']:g}); a larger pitch or flank_angle helps too"
    )


def _teeth_leave_room_for_contact(values: Mapping[str, float]) -> str | None:
    reach = values["upper_radius"] * math.sin(math.radians(values["contact_angle"]))
    shape = _shape(values)
    flats = [] if shape is None else [(lobe.above, lobe.upper_flat) for lobe in shape.lobes]
    return _flats_cover_contact(values, "tooth_radius", reach, flats)


def _grooves_leave_room_for_contact(values: Mapping[str, float]) -> str | None:
    reach = values["lower_radius"] * math.sin(math.radians(values["contact_angle"]))
    shape = _shape(values)
    flats = [] if shape is None else [(lobe.below, lobe.lower_flat) for lobe in shape.lobes]
    return _flats_cover_contact(values, "groove_radius", reach, flats)


def _flats_cover_contact(
    values: Mapping[str, float], radius: str, reach: float, flats: list[tuple[float, float]]
) -> str | None:
    """The flats of the disc must go on beyond the flats of the blade as far as the contact may.

    Args:
        values: all parameters.
        radius: the parameter whose rounding the flats lead to.
        reach: how far the contact may go on the rounding of the blade.
        flats: for each lobe the normal of the line behind the rounding, and how far the flat goes.
    """
    normal = math.radians(90 - values["flank_angle"])
    why = "the flat of the disc must cover the candidate contact and an element of flank_size"
    missing = [(normal - other, reach + values["flank_size"] - length) for other, length in flats]
    if all(length <= 0 for _, length in missing):
        return None
    bound = min(values[radius] - length / math.tan(turn / 2) for turn, length in missing)
    if bound > 0:
        return at_most(radius, values, bound, f"{why}; a larger flank_clearance helps too")
    needed = max(length * math.sin(turn) for turn, length in missing) + values["flank_clearance"]
    return at_least("flank_clearance", values, needed, why)


def _teeth_clear_neck_fillets(values: Mapping[str, float]) -> str | None:
    shape = _shape(values)
    if shape is None:
        return None
    gap = min(min(_tooth_gaps(values, shape.normal, lobe)) for lobe in shape.lobes)
    needed = CURVED_GAP * values["flank_clearance"]
    if gap >= needed:
        return None
    return (
        f"tooth_radius: the tips of the disc teeth, of radius {values['tooth_radius']:g}, come too"
        f" near to the neck fillets of the blade, of radius {values['neck_fillet']:g} (smallest gap"
        f" {gap:.3g}, expected half of flank_clearance, {needed:.3g}); a larger tooth_radius or"
        " relief_angle, or a smaller neck_fillet or flank_clearance helps"
    )


def _tooth_gaps(values: Mapping[str, float], normal: float, lobe: Lobe) -> Iterator[float]:
    """Gaps between the tip of a tooth and the fillet around it, over the directions of the tip."""
    steps = 50
    for step in range(steps + 1):
        angle = lobe.above + (normal - lobe.above) * step / steps
        x, y = direction(angle)
        deeper = (lobe.fillet[0] - lobe.tooth[0]) * x + (lobe.fillet[1] - lobe.tooth[1]) * y
        yield values["neck_fillet"] - values["tooth_radius"] - deeper


def _necks_remain(values: Mapping[str, float]) -> str | None:
    narrower = (
        (values["lobes"] - 1) * values["pitch"] * math.sin(math.radians(values["wedge_angle"]))
    )
    why = f"the lowest neck is {2 * narrower:.6g} narrower; a smaller wedge_angle or pitch helps"
    return at_least("neck_width", values, 2 * narrower / (1 - LOWEST_NECK), why)


def _root_is_high_enough(values: Mapping[str, float]) -> str | None:
    angle = math.radians(values["flank_angle"])
    needed = values["flank_length"] * math.sin(angle) + values["lower_radius"] * math.cos(angle)
    needed += values["root_corner"] + values["flank_size"]
    why = "flat, lower rounding and root corner take that much; a smaller lower_radius helps"
    return at_least("root_height", values, needed, why)


def _slot_is_deep_enough(values: Mapping[str, float]) -> str | None:
    shape = _shape(values)
    if shape is None:
        return None
    wall = shape.lobes[-1].groove[1] - values["groove_radius"] - shape.slot_bottom
    needed = values["slot_clearance"] + values["flank_size"] - wall
    why = "the lowest groove and the slot corner must fit in; a smaller groove_radius helps"
    return at_least("slot_clearance", values, needed, why)


def _root_corner_clears_slot_corner(values: Mapping[str, float]) -> str | None:
    """Distance of the convex root corner from the concave slot corner around it."""
    corner, slot = values["root_corner"], values["groove_radius"]
    x = slot - values["flank_clearance"] - corner
    y = slot - values["slot_clearance"] - corner
    gap = slot - corner - math.hypot(max(x, 0.0), max(y, 0.0))
    needed = CURVED_GAP * min(values["flank_clearance"], values["slot_clearance"])
    if min(x, y) <= 0 or gap >= needed:
        return None
    return (
        f"root_corner: the corners of the root, of radius {corner:g}, come too near to the corners"
        f" of the slot, of radius {slot:g} (smallest gap {gap:.3g}, expected {needed:.3g}); a"
        " larger root_corner or a smaller groove_radius helps"
    )


def _corners_fit(values: Mapping[str, float]) -> str | None:
    shape = _shape(values)
    if shape is None:
        return None
    slot = shape.root + values["flank_clearance"]
    return at_most(
        "root_corner", values, 0.7 * shape.root, "70 % of half the width of the root"
    ) or at_most("groove_radius", values, 0.9 * slot, "90 % of half the width of the slot")


def _shank_rises_above_fillet(values: Mapping[str, float]) -> str | None:
    shape = _shape(values)
    if shape is None:
        return None
    needed = shape.lobes[0].fillet[1] - shape.disc_top + values["flank_size"]
    return at_least("shank_height", values, needed, "the neck fillet must end below the top")


def _disc_is_large_enough(values: Mapping[str, float]) -> str | None:
    shape = _shape(values)
    if shape is None:
        return None
    radius = values["groove_radius"]
    width = 2 * max(lobe.groove[0] + 2 * radius for lobe in shape.lobes)
    depth = shape.disc_top - shape.slot_bottom + radius
    return at_least("disc_width", values, width, "width of the slot and its grooves") or at_least(
        "disc_depth", values, depth, "depth of the slot and its corners"
    )


CHECKS: tuple[Check, ...] = (
    _lobes_fit_pitch,
    _backs_are_straight,
    _neck_fillets_turn_less_than_half,
    contact_ends_on_roundings,
    _teeth_leave_room_for_contact,
    _grooves_leave_room_for_contact,
    fine_zone_fits,
    _teeth_clear_neck_fillets,
    _necks_remain,
    _root_is_high_enough,
    _slot_is_deep_enough,
    _root_corner_clears_slot_corner,
    _corners_fit,
    _shank_rises_above_fillet,
    _disc_is_large_enough,
    flank_size_resolves_flat,
    edge_size_is_smallest,
)
