# SPDX-License-Identifier: LGPL-3.0-or-later
"""Geometry templates without Gmsh: what is read from the .geo files, and refused parameters."""

from __future__ import annotations

import math
import re
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import pytest
from launch import fretfe

from fretfe.errors import CaseError
from fretfe.geometry import templates
from fretfe.geometry.template_checks import CROSS_CHECKS
from fretfe.geometry.templates import Parameter, check_parameters, find_template, template_names
from fretfe.report.page.tables import parameter_rows

NAMES = ("cylinder", "dovetail", "firtree", "flat_rounded", "wedge")


def test_all_templates_are_found() -> None:
    assert template_names() == NAMES


def test_unknown_template() -> None:
    with pytest.raises(CaseError, match=r"geometry\.template.*'dovetale' \(did you mean dovetail"):
        find_template("dovetale")


def test_installed_templates_come_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "fretfe" / "meshes").mkdir(parents=True)
    monkeypatch.setattr(templates, "__file__", str(tmp_path / "fretfe" / "templates.py"))
    assert templates.template_directory() == tmp_path / "fretfe" / "meshes"


def test_parameter_is_read_as_written() -> None:
    parameters = {each.name: each for each in find_template("dovetail").parameters}
    assert parameters["flank_angle"] == Parameter(
        "flank_angle", 45.0, 30.0, 70.0, "Angle of the flank to the x axis", "degrees"
    )
    assert parameters["growth"].unit == "-"


@pytest.mark.parametrize("name", NAMES)
def test_every_constant_of_the_script_is_a_parameter(name: str) -> None:
    template = find_template(name)
    block = template.path.read_text().partition("DefineConstant[")[2].partition("\n];")[0]
    names = [line.split("=")[0].strip() for line in block.strip().splitlines()]
    assert [parameter.name for parameter in template.parameters] == names


@pytest.mark.parametrize("name", NAMES)
def test_defaults_are_valid_and_complete(name: str) -> None:
    template = find_template(name)
    assert check_parameters(template, {}) == {
        each.name: each.default for each in template.parameters
    }


def test_given_values_replace_defaults() -> None:
    values = check_parameters(find_template("dovetail"), {"edge_size": 0.02, "neck_width": 13})
    assert (values["edge_size"], values["neck_width"], values["flank_length"]) == (0.02, 13.0, 6.0)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"neck_widht": 12}, r"no parameter is called 'neck_widht' \(did you mean neck_width"),
        ({"zzz": 12}, r"no parameter is called 'zzz'\n.*the parameters are: flank_angle, "),
        ({"neck_width": 1000}, "neck_width: expected a number from 2 to 100 mm, found 1000"),
        ({"growth": 0}, "growth: expected a number from 0.02 to 0.5, found 0"),
        ({"growth": math.nan}, "growth: expected a number .*, found nan"),
        ({"growth": True}, "growth: expected a number .*, found True"),
        ({"growth": "fast"}, "growth: expected a number .*, found 'fast'"),
    ],
)
def test_refused_values(values: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError, match=rf"parameters of template 'dovetail':\n.*{message}"):
        check_parameters(find_template("dovetail"), values)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (2.5, "lobes: expected a whole number from 2 to 4, found 2.5"),
        (5, "lobes: expected a whole number from 2 to 4, found 5"),
    ],
)
def test_a_number_of_lobes_is_whole(value: float, message: str) -> None:
    firtree = find_template("firtree")
    assert [each.name for each in firtree.parameters if each.whole] == ["lobes"]
    with pytest.raises(CaseError, match=message):
        check_parameters(firtree, {"lobes": value})


@pytest.mark.parametrize(
    ("relaxed", "radius"),
    [("tooth_radius", 1.0), ("groove_radius", 1.1)],
)
def test_the_bound_in_the_message_is_the_true_one(relaxed: str, radius: float) -> None:
    firtree = find_template("firtree")
    with pytest.raises(CaseError) as error:
        check_parameters(firtree, {relaxed: 3 * radius})
    found = re.search(rf"{relaxed}: expected at most ([0-9.]+)", str(error.value))
    assert found is not None
    bound = float(found[1])
    # the message has six digits
    assert check_parameters(firtree, {relaxed: 0.99999 * bound})[relaxed] < bound
    with pytest.raises(CaseError, match=f"{relaxed}: expected at most"):
        check_parameters(firtree, {relaxed: 1.00001 * bound})


def command(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> CompletedProcess[str]:
    monkeypatch.setenv("COLUMNS", "200")
    return fretfe("templates", *arguments)


def test_the_command_lists_the_templates(monkeypatch: pytest.MonkeyPatch) -> None:
    done = command(monkeypatch)
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines()]
    assert [row[0] for row in rows if row and row[0] in NAMES] == list(NAMES)
    assert "Firtree: a blade root with 2 to 4 pairs of lobes" in done.stdout


def test_the_command_lists_the_parameters_of_a_template(monkeypatch: pytest.MonkeyPatch) -> None:
    done = command(monkeypatch, "firtree")
    assert done.returncode == 0, done.stderr
    names = [line.split()[0] for line in done.stdout.splitlines() if " … " in line]
    assert names == [each.name for each in find_template("firtree").parameters]
    assert re.search(r"lobes +3 +2 … 4, whole +Number of pairs of lobes", done.stdout)
    assert re.search(r"flank_angle +45 +30 … 65 +degrees +Angle of the flanks", done.stdout)


def test_the_command_refuses_an_unknown_template(monkeypatch: pytest.MonkeyPatch) -> None:
    done = command(monkeypatch, "firtre")
    assert done.returncode == 2
    assert "NAME: no template is called 'firtre' (did you mean firtree?)" in done.stderr


def test_the_document_has_the_parameters_that_the_templates_have() -> None:
    page = (Path(__file__).parents[1] / "docs" / "templates.md").read_text("utf-8")
    for name in NAMES:
        table = page.partition(f"<!-- parameters of {name} -->\n")[2].partition("<!-- end -->")[0]
        # tools/template_docs.py writes it anew
        assert table == parameter_rows(find_template(name))


# For each template and cross check: parameters that break it, and how the message begins.
BROKEN: dict[tuple[str, str], tuple[dict[str, float], str]] = {
    ("dovetail", "contact_ends_on_roundings"): (
        {"relief_angle": 15, "contact_angle": 12},
        "contact_angle: expected at most 10 ",
    ),
    ("dovetail", "_disc_flank_covers_contact"): (
        {"lower_radius": 15},
        "overhang: expected at least 2.75",
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
}


def test_every_cross_check_has_its_example() -> None:
    checks = {(name, check.__name__) for name in CROSS_CHECKS for check in CROSS_CHECKS[name]}
    assert checks == set(BROKEN)


@pytest.mark.parametrize(("name", "check"), BROKEN)
def test_cross_check(name: str, check: str) -> None:
    values, message = BROKEN[name, check]
    with pytest.raises(CaseError, match=rf"\n  - {re.escape(message)}"):
        check_parameters(find_template(name), values)
    function = next(each for each in CROSS_CHECKS[name] if each.__name__ == check)
    defaults = {each.name: each.default for each in find_template(name).parameters}
    assert function(defaults) is None
    assert function(defaults | values) is not None


def test_a_flat_lower_block_needs_no_radius() -> None:
    values = check_parameters(find_template("cylinder"), {"lower_radius": 0, "lower_width": 50})
    assert values["lower_radius"] == 0.0
