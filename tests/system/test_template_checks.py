# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the parameters of the geometry templates must satisfy together: refused before meshing."""

from __future__ import annotations

import re

import pytest
from cases.template_parameters import checked, defaults

from fretfe.errors import CaseError
from fretfe.mesh.templates import find_template, template_names


@pytest.mark.parametrize(
    ("relaxed", "radius"),
    [("tooth_radius", 1.0), ("groove_radius", 1.1)],
)
def test_the_bound_in_the_message_is_the_true_one(relaxed: str, radius: float) -> None:
    firtree = find_template("firtree")
    with pytest.raises(CaseError) as error:
        checked(firtree, {relaxed: 3 * radius})
    found = re.search(rf"{relaxed}: expected at most ([0-9.]+)", str(error.value))
    assert found is not None
    bound = float(found[1])
    # the message has six digits
    assert checked(firtree, {relaxed: 0.99999 * bound})[relaxed] < bound
    with pytest.raises(CaseError, match=f"{relaxed}: expected at most"):
        checked(firtree, {relaxed: 1.00001 * bound})


# For each check of each template: parameters that break it, and how the message begins.
BROKEN: dict[tuple[str, str], tuple[dict[str, float], str]] = {
    ("dovetail", "contact_ends_on_roundings"): (
        {"relief_angle": 15, "contact_angle": 12},
        "contact_angle: expected at most 10 ",
    ),
    ("dovetail", "_disc_flank_covers_contact"): (
        {"lower_radius": 15},
        "overhang: expected at least 2.75",
    ),
    ("dovetail", "upper_front_fits"): (
        {"upper_front": 3},
        "upper_front: expected at most",
    ),
    ("dovetail", "fine_zone_begins_on_the_flat_of_the_disc"): (
        {"upper_on_disc": 1, "upper_front": 0.26, "edge_zone": 0.25},
        "upper_front: expected at most 0.247 with upper_on_disc",
    ),
    ("dovetail", "rounding_of_the_disc_clears_the_neck"): (
        {"upper_on_disc": 1, "upper_radius": 8},
        "upper_radius: the rounding of the disc would touch the fillet",
    ),
    ("dovetail", "lower_front_fits"): (
        {"lower_front": 3},
        "lower_front: expected at most",
    ),
    ("dovetail", "fine_zone_fits"): (
        {"upper_radius": 1},
        "edge_zone: expected at most 0.157",
    ),
    ("dovetail", "_root_is_high_enough"): (
        {"root_height": 8},
        "root_height: expected at least 9.22",
    ),
    ("dovetail", "_slot_is_deep_enough"): (
        {"slot_fillet": 6},
        "slot_clearance: expected at least 4.04",
    ),
    ("dovetail", "_root_clears_slot_wall"): (
        {"lower_radius": 8, "slot_fillet": 0.5},
        "overhang: expected at least 3.2",
    ),
    ("dovetail", "_root_corner_clears_slot_fillet"): (
        {"root_corner": 0.2, "slot_fillet": 4.5, "root_height": 16, "slot_clearance": 0.3},
        "root_corner: the corners of the root",
    ),
    ("dovetail", "_neck_passes_mouth"): (
        {"overhang": 5, "slot_clearance": 4},
        "neck_width: the neck with its fillets does not pass",
    ),
    ("dovetail", "_corners_fit"): (
        {"root_corner": 16, "root_height": 40},
        "root_corner: expected at most 13.5",
    ),
    ("dovetail", "_shank_rises_above_fillet"): (
        {"neck_fillet": 12, "shank_height": 1},
        "shank_height: expected at least 7.655",
    ),
    ("dovetail", "_disc_is_large_enough"): (
        {"disc_width": 30},
        "disc_width: expected at least 38",
    ),
    ("dovetail", "flank_size_resolves_flat"): (
        {"flank_size": 1.6},
        "flank_size: expected at most 1.5 ",
    ),
    ("dovetail", "edge_size_is_smallest"): (
        {"edge_size": 0.15},
        "edge_size: expected at most 0.1 ",
    ),
    ("cylinder", "_faces_are_less_than_half_cylinders"): (
        {"lower_width": 9},
        "lower_width: expected at most 7.92 ",
    ),
    ("cylinder", "zone_is_inside_faces"): (
        {"zone": 6.5},
        "zone: expected at most 6.3 ",
    ),
    ("cylinder", "_bodies_are_higher_than_faces"): (
        {"upper_height": 4},
        "upper_height: expected at least 4.8",
    ),
    ("cylinder", "size_resolves_zone"): (
        {"size": 0.3},
        "size: expected at most 0.25 ",
    ),
    ("firtree", "_lobes_fit_pitch"): (
        {"pitch": 6},
        "pitch: expected at least 7.143",
    ),
    ("firtree", "_backs_are_straight"): (
        {"groove_radius": 1.17, "pitch": 6.47, "tooth_radius": 2.61, "neck_fillet": 0.84},
        "pitch: the straight backs of the lobes",
    ),
    ("firtree", "_neck_fillets_turn_less_than_half"): (
        {"relief_angle": 57},
        "relief_angle: from the back of a lobe",
    ),
    ("firtree", "contact_ends_on_roundings"): (
        {"relief_angle": 16, "contact_angle": 12},
        "contact_angle: expected at most 11 ",
    ),
    ("firtree", "_teeth_leave_room_for_contact"): (
        {"tooth_radius": 2},
        "tooth_radius: expected at most 1.386",
    ),
    ("firtree", "_grooves_leave_room_for_contact"): (
        {"groove_radius": 1.5},
        "groove_radius: expected at most 1.211",
    ),
    ("firtree", "fine_zone_fits"): (
        {"edge_zone": 0.2},
        "edge_zone: expected at most 0.188",
    ),
    ("firtree", "_teeth_clear_neck_fillets"): (
        {"neck_fillet": 3, "pitch": 12, "tooth_radius": 0.2},
        "tooth_radius: the tips of the disc teeth",
    ),
    ("firtree", "_necks_remain"): (
        {"pitch": 18},
        "neck_width: expected at least 20.4",
    ),
    ("firtree", "_root_is_high_enough"): (
        {"root_height": 3.5},
        "root_height: expected at least 3.716",
    ),
    ("firtree", "_slot_is_deep_enough"): (
        {"root_height": 3.8, "root_corner": 0.3, "slot_clearance": 0.1},
        "slot_clearance: expected at least 0.274",
    ),
    ("firtree", "_root_corner_clears_slot_corner"): (
        {"root_corner": 0.1, "slot_clearance": 0.3},
        "root_corner: the corners of the root",
    ),
    ("firtree", "_corners_fit"): (
        {"root_corner": 6, "root_height": 12},
        "root_corner: expected at most 5.233",
    ),
    ("firtree", "_shank_rises_above_fillet"): (
        {"shank_height": 0.5, "neck_fillet": 3, "rim_height": 0.1, "pitch": 12},
        "shank_height: expected at least 0.613",
    ),
    ("firtree", "_disc_is_large_enough"): (
        {"disc_width": 20},
        "disc_width: expected at least 25.5",
    ),
    ("firtree", "flank_size_resolves_flat"): (
        {"flank_size": 0.7},
        "flank_size: expected at most 0.625",
    ),
    ("firtree", "edge_size_is_smallest"): (
        {"edge_size": 0.09},
        "edge_size: expected at most 0.06 ",
    ),
    ("flat_rounded", "_roundings_reach_sides"): (
        {"upper_width": 12},
        "radius: expected at least 11.1111 (the roundings must reach the sides",
    ),
    ("flat_rounded", "zone_is_inside_faces"): (
        {"lower_width": 1.5},
        "zone: expected at most 1.35 ",
    ),
    ("flat_rounded", "_zone_ends_on_roundings"): (
        {"zone": 0.9},
        "zone: expected at least 1.02 (the contact ends beyond flat_half_width",
    ),
    ("flat_rounded", "_bodies_are_higher_than_roundings"): (
        {"upper_height": 4.5},
        "upper_height: expected at least 4.92",
    ),
    ("flat_rounded", "_flat_size_resolves_punch"): (
        {"flat_half_width": 0.08},
        "flat_size: expected at most 0.04 ",
    ),
    ("flat_rounded", "_edge_size_within_flat_size"): (
        {"edge_size": 0.06},
        "edge_size: expected at most 0.05 (flat_size)",
    ),
    ("wedge", "zone_is_inside_faces"): (
        {"zone": 7.5},
        "zone: expected at most 7.2 ",
    ),
    ("wedge", "_bodies_are_higher_than_wedge"): (
        {"angle": 20, "upper_height": 3},
        "upper_height: expected at least 3.71",
    ),
    ("wedge", "size_resolves_zone"): (
        {"zone": 0.03},
        "size: expected at most 0.0075 ",
    ),
    ("dovetail", "slot corners"): (
        {
            "slot_fillet": 15,
            "flank_angle": 70,
            "flank_length": 2,
            "upper_radius": 0.5,
            "lower_radius": 0.5,
            "neck_width": 2,
            "neck_fillet": 0.5,
        },
        "slot_fillet: expected at most ",
    ),
    ("dovetail", "disc depth"): ({"disc_depth": 15}, "disc_depth: expected at least "),
    ("dovetail", "two sectors"): ({"sectors": 2}, "sectors: expected 0 (a block) or at least 3"),
    ("dovetail", "sectors as wide as the slot"): (
        {"sectors": 60},
        "sectors: expected at least 3 between the slot and the sides of the sector, found ",
    ),
    ("dovetail", "disc around its axis"): (
        {"sectors": 3, "pitch_radius": 35},
        "pitch_radius: expected at least ",
    ),
    ("firtree", "two sectors"): ({"sectors": 2}, "sectors: expected 0 (a block) or at least 3"),
    ("firtree", "sectors as wide as the slot"): (
        {"sectors": 60},
        "sectors: expected at least 2.2 between the slot and the sides of the sector, found ",
    ),
    ("firtree", "disc around its axis"): (
        {"sectors": 3, "pitch_radius": 35},
        "pitch_radius: expected at least ",
    ),
    ("cylinder", "upper half cylinder"): (
        {"upper_width": 9},
        "upper_width: expected at most 7.92 ",
    ),
    ("cylinder", "lower height"): ({"lower_height": 4}, "lower_height: expected at least 4.8"),
    ("flat_rounded", "lower height"): ({"lower_height": 0.5}, "lower_height: expected at least 1 "),
    ("wedge", "lower height"): ({"lower_height": 0.5}, "lower_height: expected at least 1 "),
    ("sphere", "upper corners"): ({"upper_width": 31}, "upper_width: expected at most 30.05"),
    ("sphere", "upper corners of an ellipsoid"): (
        {"upper_width": 20, "radius_z": 20},
        "upper_width: expected at most 14.36",
    ),
    ("sphere", "lower corners"): ({"lower_radius": 30}, "lower_width: expected at most 18.03"),
    ("sphere", "zone in x"): ({"contact_x": 12}, "contact_x: expected at most 11.25 "),
    ("sphere", "zone in z"): ({"contact_z": 12}, "contact_z: expected at most 11.25 "),
    ("sphere", "size"): ({"contact_z": 0.1}, "size: expected at most 0.05 "),
    ("sphere", "number of elements"): ({"size": 1e-5}, "size: expected at least "),
    ("sphere", "upper height"): ({"upper_height": 10}, "upper_height: expected at least 10.76"),
    ("sphere", "lower height"): ({"lower_height": 3}, "lower_height: expected at least 3.6 "),
    ("cylinder_finite", "half cylinder"): (
        {"upper_width": 28},
        "upper_width: expected at most 27 ",
    ),
    ("cylinder_finite", "zone"): ({"zone": 9.5}, "zone: expected at most 9 "),
    ("cylinder_finite", "height"): ({"upper_height": 2}, "upper_height: expected at least 2.71"),
    ("cylinder_finite", "size"): ({"size": 0.8}, "size: expected at most 0.75 "),
    ("cylinder_finite", "end size"): ({"length": 0.8}, "end_size: expected at most 0.2 "),
    ("cylinder_finite", "length size"): (
        {"length_size": 0.2},
        "length_size: expected at least 0.25 ",
    ),
    ("cylinder_finite", "overhang"): (
        {"overhang": 0.1},
        "overhang: expected 0, or at least 0.25 ",
    ),
    ("firtree", "disc depth"): ({"disc_depth": 15}, "disc_depth: expected at least "),
    ("firtree", "groove corners"): ({"groove_radius": 12}, "groove_radius: expected at most "),
    ("firtree", "clearance at teeth"): (
        {
            "pitch": 10.8,
            "wedge_angle": 20.8,
            "flank_length": 3.3,
            "upper_radius": 0.7,
            "neck_fillet": 0.8,
            "relief_angle": 18.5,
            "flank_clearance": 0.5,
            "tooth_radius": 1.6,
            "flank_size": 0.15,
        },
        "flank_clearance: expected at least ",
    ),
}


# What the examples are changes of: smaller roundings and shorter fine zones than by default.
SMALL = {
    "dovetail": {"edge_zone": 0.2},
    "firtree": {"upper_radius": 1.2, "lower_radius": 1.2, "edge_size": 0.006},
}


def refusal(name: str, values: dict[str, float]) -> list[str]:
    """The lines of the message that refuses parameters, without its first one."""
    values = SMALL.get(name, {}) | values
    with pytest.raises(CaseError, match=rf"^geometry.parameters of template '{name}':\n") as caught:
        checked(find_template(name), values)
    return str(caught.value).splitlines()[1:]


@pytest.mark.parametrize("name", template_names())
def test_every_check_of_a_template_has_its_example(name: str) -> None:
    formats = re.findall(r'Error\("([^"]+)"', find_template(name).path.read_text())
    examples = [values for (other, _), (values, _) in BROKEN.items() if other == name]
    lines = [line for values in examples for line in refusal(name, values)]
    assert formats
    for text in formats:
        pattern = r"[-+.e\d]+".join(map(re.escape, re.split(r"%[.\d]*g", text)))
        assert any(re.fullmatch(f"  - {pattern}", line) for line in lines), text


@pytest.mark.parametrize(("name", "check"), BROKEN)
def test_cross_check(name: str, check: str) -> None:
    values, message = BROKEN[name, check]
    assert any(line.startswith(f"  - {message}") for line in refusal(name, values))


@pytest.mark.parametrize("name", template_names())
def test_defaults_fit_together(name: str) -> None:
    template = find_template(name)
    assert checked(template, {}) == defaults(template)


def test_a_flat_lower_block_needs_no_radius() -> None:
    values = checked(find_template("cylinder"), {"lower_radius": 0, "lower_width": 50})
    assert values["lower_radius"] == 0.0
