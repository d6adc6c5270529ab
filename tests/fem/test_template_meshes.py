# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of the geometry templates: do they show the geometry that the parameters describe."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping

import gmsh
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fretfe.errors import CaseError
from fretfe.fem.mesh_groups import BodySummary, facet_lengths, mesh_summary
from fretfe.fem.meshing import BodyMesh, Mesh, mesh_template
from fretfe.templates import check_parameters, find_template

COARSE = {"edge_size": 0.05, "edge_zone": 0.15, "flank_size": 0.3, "growth": 0.3}
COARSE_CYLINDER = COARSE_WEDGE = {"size": 0.05, "growth": 0.3}
COARSE_PUNCH = {"edge_size": 0.02, "flat_size": 0.1, "growth": 0.3}
PUNCH_GROUPS = {
    "upper": {"upper_contact", "upper_top"},
    "lower": {"lower_contact", "lower_bottom", "lower_left", "lower_right"},
}
GROUPS = {
    "dovetail": {
        "blade": {"blade_top", "blade_flank_left", "blade_flank_right"},
        "disc": {
            "disc_bottom",
            "disc_side_left",
            "disc_side_right",
            "disc_flank_left",
            "disc_flank_right",
        },
    },
    "cylinder": PUNCH_GROUPS,
    "flat_rounded": PUNCH_GROUPS,
    "wedge": PUNCH_GROUPS,
}


def dovetail(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("dovetail"), COARSE | parameters, order)


def cylinder(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("cylinder"), COARSE_CYLINDER | parameters, order)


def flat_rounded(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("flat_rounded"), COARSE_PUNCH | parameters, order)


def wedge(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("wedge"), COARSE_WEDGE | parameters, order)


@pytest.fixture(scope="module")
def coarse_dovetail() -> Mesh:
    return dovetail()


@pytest.fixture(scope="module")
def default_dovetail() -> Mesh:
    return mesh_template(find_template("dovetail"), {}, 2)


def facet_nodes(body: BodyMesh, name: str) -> NDArray[np.float64]:
    """Coordinates of all nodes of a boundary."""
    return body.points[np.unique(body.boundaries[name])]


def along_and_above(points: NDArray[np.float64], side: int) -> NDArray[np.float64]:
    """Position along the 45-degree flank, downwards from its middle, and height above its plane.

    The disc side is positive. The lower end of the flat of the default geometry lies at s = 3.
    """
    values = find_template("dovetail").parameters
    default = {each.name: each.default for each in values}
    flank = math.radians(default["flank_angle"])
    relief = math.radians(default["flank_angle"] - default["relief_angle"])
    radius, fillet = default["upper_radius"], default["neck_fillet"]
    upper = default["neck_width"] / 2 + fillet + radius * math.sin(flank)
    upper -= (radius + fillet) * math.sin(relief)
    middle = np.array([upper + default["flank_length"] / 2 * math.cos(flank), 0.0])
    tangent = np.array([math.cos(flank), -math.sin(flank)])
    normal = np.array([math.sin(flank), math.cos(flank)])
    return (points * [side, 1] - middle) @ np.column_stack([tangent, normal])


@pytest.mark.parametrize("name", GROUPS)
@pytest.mark.parametrize("order", [1, 2])
def test_groups(name: str, order: int) -> None:
    meshers = {
        "dovetail": dovetail,
        "cylinder": cylinder,
        "flat_rounded": flat_rounded,
        "wedge": wedge,
    }
    mesh = meshers[name](order)
    assert {body.name: set(body.boundaries) for body in mesh.bodies.values()} == GROUPS[name]
    assert {body.order for body in mesh.bodies.values()} == {order}


@pytest.mark.parametrize(
    ("name", "largest"),
    [("dovetail", 30_000), ("cylinder", 20_000), ("flat_rounded", 30_000), ("wedge", 20_000)],
)
def test_default_size(name: str, largest: int) -> None:
    summary = mesh_summary(mesh_template(find_template(name), {}, 2))
    assert 5_000 < sum(body.nodes for body in summary) < largest
    assert min(body.smallest_angle for body in summary) > 25


@pytest.mark.parametrize("side", [-1, 1], ids=["left", "right"])
def test_flats_touch_and_roundings_curve_away(coarse_dovetail: Mesh, side: int) -> None:
    name = "flank_left" if side < 0 else "flank_right"
    blade = facet_nodes(coarse_dovetail.bodies["blade"], f"blade_{name}")
    disc = facet_nodes(coarse_dovetail.bodies["disc"], f"disc_{name}")
    s, height = along_and_above(blade, side).T
    flat = np.abs(s) <= 3 + 1e-9
    # round-off of coordinates of size 10 computed twice
    np.testing.assert_allclose(height[flat], 0.0, atol=1e-13)
    np.testing.assert_allclose(along_and_above(disc, side)[:, 1], 0.0, atol=1e-13)
    beyond = np.abs(s[~flat]) - 3
    circle = np.sqrt(16 - beyond**2) - 4
    # ends lie on the circle, middles too: Gmsh puts them on the curve
    np.testing.assert_allclose(height[~flat], circle, atol=1e-9)
    assert beyond.max() == pytest.approx(4 * math.sin(math.radians(10)), rel=1e-9)


def test_contact_surfaces_face_each_other(coarse_dovetail: Mesh) -> None:
    blade = facet_nodes(coarse_dovetail.bodies["blade"], "blade_flank_right")
    disc = facet_nodes(coarse_dovetail.bodies["disc"], "disc_flank_right")
    ends = [
        [along_and_above(points, 1)[:, 0].min(), along_and_above(points, 1)[:, 0].max()]
        for points in (blade, disc)
    ]
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)  # Gmsh's tolerance on curves
    np.testing.assert_allclose(ends[0], [-ends[0][1], ends[0][1]], atol=1e-9)


def largest_mirror_error(body: BodyMesh) -> float:
    """Distance of the mirror image of any node in x = 0 from the nearest node."""
    distances, _ = cKDTree(body.points).query(body.points * [-1, 1])
    return float(distances.max())


@pytest.mark.parametrize("name", ["blade", "disc"])
def test_mesh_is_its_own_mirror_image(default_dovetail: Mesh, name: str) -> None:
    # Gmsh finds the mirror images of nodes on arcs to about 1e-6 of their radius
    assert largest_mirror_error(default_dovetail.bodies[name]) < 1e-5


def test_meshes_do_not_match_on_the_flat(coarse_dovetail: Mesh) -> None:
    blade = along_and_above(facet_nodes(coarse_dovetail.bodies["blade"], "blade_flank_right"), 1)
    disc = along_and_above(facet_nodes(coarse_dovetail.bodies["disc"], "disc_flank_right"), 1)
    distance = np.abs(blade[:, :1] - disc[:, 0]).min(axis=1)
    inside = np.abs(blade[:, 0]) < 2.5
    assert np.mean(distance[inside] > 0.01) > 0.5


def test_both_sides_are_fine_at_the_contact_edges() -> None:
    mesh = dovetail(edge_size=0.02)
    blade, disc = mesh.bodies["blade"], mesh.bodies["disc"]
    sizes = [
        facet_lengths(body.points, body.boundaries[name]).min()
        for body, name in ((blade, "blade_flank_left"), (disc, "disc_flank_left"))
    ]
    # whole elements have to fit into edge_zone; the disc is 7 % coarser
    np.testing.assert_allclose(sizes, [0.02, 0.0214], rtol=0.1)


def test_order_two_is_curved(coarse_dovetail: Mesh) -> None:
    blade = coarse_dovetail.bodies["blade"]
    facets = blade.boundaries["blade_flank_right"]
    chord_middle = blade.points[facets[:, :2]].mean(axis=1)
    sagitta = np.linalg.norm(blade.points[facets[:, 2]] - chord_middle, axis=1)
    lengths = facet_lengths(blade.points, facets)
    s = along_and_above(chord_middle, 1)[:, 0]
    on_arc = np.abs(s) > 3
    # sagitta of a chord h of a circle R = 4: h^2/(8 R), here to (h/R)^2/16 < 1 %
    np.testing.assert_allclose(sagitta[on_arc], lengths[on_arc] ** 2 / 32, rtol=0.01)
    np.testing.assert_allclose(sagitta[~on_arc], 0.0, atol=1e-9)


def test_parameters_change_the_geometry(coarse_dovetail: Mesh) -> None:
    wide = dovetail(neck_width=16.0, disc_depth=50.0)
    top = facet_nodes(wide.bodies["blade"], "blade_top")
    assert np.ptp(top[:, 0]) == pytest.approx(16.0)
    assert np.ptp(wide.bodies["disc"].points[:, 1]) == pytest.approx(50.0)
    # and nothing is left of them in this process
    again = dovetail()
    np.testing.assert_array_equal(
        again.bodies["blade"].points, coarse_dovetail.bodies["blade"].points
    )


def test_parameters_of_another_session_do_not_leak() -> None:
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.onelab.setNumber("Parameters/02 Half of the width of the upper body [mm]", [3.0])
        gmsh.parser.setNumber("upper_width", [4.0])
        upper = cylinder(lower_height=9.0).bodies["upper"]
    finally:
        gmsh.finalize()
    assert np.ptp(upper.points[:, 0]) == pytest.approx(14.0)


def test_bad_parameters_are_refused_before_meshing() -> None:
    with pytest.raises(CaseError, match="root_height: expected at least"):
        dovetail(root_height=5.0)


@pytest.mark.parametrize("radius", [0.0, 20.0], ids=["flat", "cylinder"])
def test_lower_body(radius: float) -> None:
    mesh = cylinder(lower_radius=radius, lower_width=15.0, lower_height=16.0)
    lower = facet_nodes(mesh.bodies["lower"], "lower_contact")
    profile = radius - np.sqrt(radius**2 - lower[:, 0] ** 2) if radius else 0.0
    np.testing.assert_allclose(lower[:, 1], -profile, atol=1e-9)  # Gmsh's tolerance on curves
    assert np.abs(lower[:, 0]).max() == pytest.approx(1.0)
    assert mesh.bodies["lower"].points[:, 1].min() == -16.0
    assert facet_nodes(mesh.bodies["lower"], "lower_left")[:, 0] == pytest.approx(-15.0)


def test_cylinders_touch_in_the_origin() -> None:
    mesh = cylinder()
    upper = facet_nodes(mesh.bodies["upper"], "upper_contact")
    lower = facet_nodes(mesh.bodies["lower"], "lower_contact")
    np.testing.assert_allclose(upper[:, 1], 8 - np.sqrt(64 - upper[:, 0] ** 2), atol=1e-9)
    np.testing.assert_allclose(lower[:, 1], np.sqrt(64 - lower[:, 0] ** 2) - 8, atol=1e-9)
    assert upper[:, 1].min() == lower[:, 1].max() == 0.0


def random_parameters(name: str, fixed: Mapping[str, float], seed: int) -> dict[str, float]:
    """Valid parameters between 0.6 and 1.7 times the defaults, other than the fixed ones."""
    generator = random.Random(seed)
    template = find_template(name)
    while True:
        values = dict(fixed) | {
            each.name: each.default * generator.uniform(0.6, 1.7)
            for each in template.parameters
            if each.name not in fixed
        }
        try:
            return check_parameters(template, values)
        except CaseError:
            continue


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize(
    ("name", "fixed"),
    [
        ("dovetail", COARSE),
        ("cylinder", COARSE_CYLINDER),
        ("flat_rounded", COARSE_PUNCH),
        ("wedge", COARSE_WEDGE),
    ],
    ids=GROUPS,
)
def test_valid_parameters_give_good_meshes(
    name: str, fixed: Mapping[str, float], seed: int
) -> None:
    # that no element is inverted and none overlap is checked by mesh_template itself
    template = find_template(name)
    summary = mesh_summary(mesh_template(template, random_parameters(name, fixed, seed), 2))
    assert min(body.smallest_angle for body in summary) > 15


def flat_rounded_gap(values: Mapping[str, float], x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Gap at |x|, 0 and then a circle; without the cancellation in R - sqrt(R^2 - s^2)."""
    radius = values["radius"]
    beside = np.maximum(np.abs(x) - values["flat_half_width"], 0.0)
    gap: NDArray[np.float64] = beside**2 / (radius + np.sqrt(radius**2 - beside**2))
    return gap


def wedge_gap(values: Mapping[str, float], x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Gap slope |x|."""
    gap: NDArray[np.float64] = math.tan(math.radians(values["angle"])) * np.abs(x)
    return gap


PROFILES = {
    "flat_rounded": (COARSE_PUNCH, flat_rounded_gap),
    "wedge": (COARSE_WEDGE, wedge_gap),
}


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("name", PROFILES)
def test_random_punch_has_its_gap_and_is_symmetric(name: str, seed: int) -> None:
    fixed, gap = PROFILES[name]
    values = random_parameters(name, fixed, seed)
    bodies = mesh_template(find_template(name), values, 2).bodies
    assert {body: set(mesh.boundaries) for body, mesh in bodies.items()} == PUNCH_GROUPS
    x, y = facet_nodes(bodies["upper"], "upper_contact").T
    # round-off of coordinates up to 16
    np.testing.assert_allclose(y, gap(values, x), atol=1e-13)
    np.testing.assert_array_equal(facet_nodes(bodies["lower"], "lower_contact")[:, 1], 0.0)
    for body, mesh in bodies.items():
        ends = facet_nodes(mesh, f"{body}_contact")[:, 0]
        np.testing.assert_allclose([ends.min(), ends.max()], [-values["zone"], values["zone"]])
        # as for the dovetail; the bodies are as large
        assert largest_mirror_error(mesh) < 1e-5


@pytest.mark.parametrize("radius", [100.0, 1e4])
def test_a_large_radius_loses_no_accuracy(radius: float) -> None:
    upper = flat_rounded(radius=radius).bodies["upper"]
    x, y = facet_nodes(upper, "upper_contact").T
    values = {"flat_half_width": 1.0, "radius": radius}
    # round-off of the coordinates of the centre; the gap at the end of the zone is 8e-6 or more
    np.testing.assert_allclose(y, flat_rounded_gap(values, x), atol=1e-15 * radius)


def test_punch_is_graded_smoothly_from_the_flat_to_a_tiny_rounding() -> None:
    mesh = flat_rounded(
        flat_half_width=0.95, zone=1.04, radius=50.0, edge_size=0.002, flat_size=0.08, growth=0.2
    )
    for name, coarser in (("upper", 1.0), ("lower", 1.07)):
        body = mesh.bodies[name]
        facets = body.boundaries[f"{name}_contact"]
        middle = body.points[facets[:, :2]].mean(axis=1)[:, 0]
        lengths = facet_lengths(body.points, facets)[np.argsort(middle)]
        x = np.sort(middle)
        # a whole number of elements has to fit into each of three pieces
        np.testing.assert_allclose(lengths[np.abs(x) > 0.95], 0.002 * coarser, rtol=0.05)
        # at the centre it has just reached flat_size, less half an element times growth
        assert lengths[np.abs(x).argmin()] == pytest.approx(0.08 * coarser, rel=0.15)
        # a size that grows by 0.2 per distance makes each element 1.2 times its neighbour
        assert np.abs(np.diff(np.log(lengths))).max() < math.log(1.3)


def test_summary_counts_and_measures() -> None:
    mesh = cylinder(order=1)
    upper: BodySummary = mesh_summary(mesh)[0]
    body = mesh.bodies["upper"]
    assert (upper.name, upper.nodes, upper.elements) == ("upper", len(body.points), len(body.cells))
    assert (upper.cell, upper.order) == ("triangle", 1)
    top = {each.name: each for each in upper.boundaries}["upper_top"]
    assert top.length == pytest.approx(14.0)
    assert top.facets == len(body.boundaries["upper_top"])
    assert 0 < top.smallest_facet <= top.length / top.facets <= top.largest_facet
