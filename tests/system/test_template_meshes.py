# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of the geometry templates: do they show the geometry that the parameters describe."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
from campaign.extent import by_extent
from cases.template_parameters import checked
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fretfe.bodies.cyclic import tie_sides
from fretfe.case import Symmetry
from fretfe.errors import CaseError, MeshError
from fretfe.mesh.elements import directed_facets, exterior_facets, facet_measures
from fretfe.mesh.make import mesh_template
from fretfe.mesh.mesh import BodyMesh, BodySummary, Mesh, mesh_summary
from fretfe.mesh.templates import Template, find_template

COARSE = {"edge_size": 0.05, "edge_zone": 0.15, "flank_size": 0.3, "growth": 0.3}
COARSE_CYLINDER = COARSE_WEDGE = {"size": 0.05, "growth": 0.3}
# With the radii that the numbers of the tests below are of.
COARSE_FIRTREE = {
    **{"edge_size": 0.03, "flank_size": 0.2, "growth": 0.3},
    **{"upper_radius": 1.2, "lower_radius": 1.2},
}
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
    "firtree": {
        "blade": {"blade_top"}
        | {f"blade_flank_{side}_{n}" for side in ("left", "right") for n in (1, 2, 3)},
        "disc": {"disc_bottom", "disc_side_left", "disc_side_right"}
        | {f"disc_flank_{side}_{n}" for side in ("left", "right") for n in (1, 2, 3)},
    },
    "flat_rounded": PUNCH_GROUPS,
    "wedge": PUNCH_GROUPS,
}


def dovetail(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("dovetail"), COARSE | parameters, order)


def cylinder(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("cylinder"), COARSE_CYLINDER | parameters, order)


def flat_rounded(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("flat_rounded"), COARSE_PUNCH | parameters, order)


def firtree(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("firtree"), COARSE_FIRTREE | parameters, order)


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
        "firtree": firtree,
        "flat_rounded": flat_rounded,
        "wedge": wedge,
    }
    mesh = meshers[name](order)
    assert {body.name: set(body.boundaries) for body in mesh.bodies.values()} == GROUPS[name]
    assert {body.order for body in mesh.bodies.values()} == {order}


@pytest.mark.parametrize(
    ("name", "largest"),
    [
        ("dovetail", 36_000),
        ("cylinder", 20_000),
        ("firtree", 70_000),
        ("flat_rounded", 30_000),
        ("wedge", 20_000),
    ],
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
        facet_measures(body.points, body.boundaries[name]).min()
        for body, name in ((blade, "blade_flank_left"), (disc, "disc_flank_left"))
    ]
    # whole elements have to fit into edge_zone; the disc is 7 % coarser
    np.testing.assert_allclose(sizes, [0.02, 0.0214], rtol=0.1)


@pytest.mark.parametrize(("upper", "lower"), [(0.25, 0.05), (0.07, 0.3)])
def test_the_fine_mesh_follows_fronts(upper: float, lower: float) -> None:
    """Fronts on the roundings, so far from the flat of half the length 3, with 0.06 around them."""
    mesh = dovetail(edge_size=0.02, edge_zone=0.06, upper_front=upper, lower_front=lower)
    for name, body in mesh.bodies.items():
        facets = body.boundaries[f"{name}_flank_right"]
        s = along_and_above(body.points[facets[:, :2]].mean(axis=1), 1)[:, 0]
        sizes = facet_measures(body.points, facets)
        away = np.minimum(np.abs(s + 3 + upper), np.abs(s - 3 - lower))
        assert sizes[away < 0.04].max() < 0.026 and sizes[away > 0.12].min() > 0.026


def test_order_two_is_curved(coarse_dovetail: Mesh) -> None:
    blade = coarse_dovetail.bodies["blade"]
    facets = blade.boundaries["blade_flank_right"]
    chord_middle = blade.points[facets[:, :2]].mean(axis=1)
    sagitta = np.linalg.norm(blade.points[facets[:, 2]] - chord_middle, axis=1)
    lengths = facet_measures(blade.points, facets)
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


# How far random parameters go from the defaults, as a factor either way; coarse for speed.
SPREAD = {"cylinder": 4.0, "dovetail": 3.0, "firtree": 2.0, "flat_rounded": 3.0, "wedge": 4.0}
COARSER = {"edge_size": 4.0, "size": 4.0, "flank_size": 1.5}


def drawn(template: Template, generator: random.Random) -> dict[str, float]:
    """Random parameters within their ranges, valid or not; angles between half and twice."""
    values: dict[str, float] = {}
    for each in template.parameters:
        spread = 2.0 if each.unit == "degrees" else SPREAD[template.name]
        value = each.default * COARSER.get(each.name, 1.0) * spread ** generator.uniform(-1, 1)
        if each.whole:
            value = generator.randint(round(each.minimum), round(each.maximum))
        if each.name == "lobe_gap":
            value = generator.uniform(-0.02, 0.02)
        if each.name == "lower_radius" and each.minimum == 0 and generator.random() < 0.5:
            value = 0.0
        values[each.name] = min(max(value, each.minimum), each.maximum)
    return values


def random_parameters(
    name: str, seed: int, fixed: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Random parameters that pass the checks."""
    generator = random.Random(seed)
    template = find_template(name)
    while True:
        values = drawn(template, generator) | dict(fixed or {})
        try:
            return checked(template, values)
        except CaseError:
            continue


SEEDS = [
    *range(5),
    *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(5, by_extent(8, 50))),
]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", GROUPS)
def test_valid_parameters_give_good_symmetric_meshes(name: str, seed: int) -> None:
    # that no element is inverted and none overlap is checked by mesh_template itself
    values = random_parameters(name, seed)
    mesh = mesh_template(find_template(name), values, 2)
    assert min(body.smallest_angle for body in mesh_summary(mesh)) > 15
    for body in mesh.bodies.values():
        for group in (name for name in body.boundaries if "left" not in name):
            other = group.replace("right", "left")
            facets, mirrored = (body.points[body.boundaries[each]] for each in (group, other))
            distance, _ = cKDTree(mirrored.mean(axis=1) * [-1, 1]).query(facets.mean(axis=1))
            # Gmsh finds the mirror images of nodes on arcs to about 1e-6 of their radius
            assert len(facets) == len(mirrored)
            assert distance.max() < 1e-6 * max(10.0, np.abs(body.points).max())


@pytest.mark.parametrize("name", GROUPS)
def test_refused_parameters_are_named(name: str) -> None:
    template = find_template(name)
    known = [each.name for each in template.parameters]
    generator = random.Random(1)
    refused = 0
    while refused < 50:
        try:
            checked(template, drawn(template, generator))
        except CaseError as error:
            lines = str(error).splitlines()[1:]
            assert lines and all(line.removeprefix("  - ").split(":")[0] in known for line in lines)
            refused += 1


# Parameters that a check refuses, and its message. The geometry is bad: the bodies cross, or one
# crosses itself, so that it cannot be meshed.
BAD: dict[str, tuple[str, str, dict[str, float]]] = {
    "dovetail neck": (
        "dovetail",
        "neck_width: the neck with its fillets",
        {"overhang": 5, "slot_clearance": 4},
    ),
    "dovetail wall": (
        "dovetail",
        "overhang: .*would touch the side wall",
        {"lower_radius": 9, "slot_fillet": 0.5, "edge_size": 0.008},
    ),
    "firtree teeth": (
        "firtree",
        "tooth_radius: the tips of the disc teeth",
        {"neck_fillet": 3, "pitch": 12, "tooth_radius": 0.2},
    ),
    "firtree necks": (
        "firtree",
        "neck_width: .*the lowest neck",
        {"pitch": 24, "disc_depth": 80},
    ),
    "firtree corner": (
        "firtree",
        "root_corner: the corners of the root",
        {"root_corner": 0.1, "slot_clearance": 0.05, "flank_clearance": 0.2, "groove_radius": 1.3},
    ),
    "firtree grooves": (
        "firtree",
        "(groove_radius|flank_clearance): .*the flat of the disc must cover",
        {"groove_radius": 4},
    ),
    "wedge height": (
        "wedge",
        "upper_height: .*the body needs a side",
        {"angle": 20, "upper_height": 2},
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_refused_geometry_is_bad(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Gmsh may never end with coarse meshes of curves that cross.
    monkeypatch.setattr("fretfe.mesh.make.require_room", lambda *_: None)
    name, message, parameters = BAD[case]
    template = find_template(name)
    with pytest.raises(CaseError, match=rf"\n  - {message}"):
        checked(template, parameters)
    # the same script without its checks
    script = re.sub(r"(?m)^.*Error\(.*$", "", template.path.read_text())
    unchecked = replace(template, path=tmp_path / "unchecked.geo")
    unchecked.path.write_text(script)
    try:
        mesh = mesh_template(unchecked, parameters, 1)
    except MeshError:
        return
    first, second = mesh.bodies.values()
    crossing = points_inside(first, second) or points_inside(second, first)
    assert crossing or min(body.smallest_angle for body in mesh_summary(mesh)) < 5


def points_inside(body: BodyMesh, other: BodyMesh) -> bool:
    """Whether nodes of the outline of a body are well inside a triangle of another."""
    edges, _ = exterior_facets(directed_facets(body.cells, body.cell, body.order), "line")
    points = body.points[np.unique(edges)]
    corners = other.points[other.cells[:, :3]]
    tree = cKDTree(corners.mean(axis=1))
    _, near = tree.query(points, k=12)
    a, b, c = (corners[near][:, :, k] for k in range(3))

    def area(p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64]) -> Any:
        u, v = q - p, r - p
        return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]

    x = points[:, None]
    parts = np.stack([area(x, a, b), area(x, b, c), area(x, c, a)]) / area(a, b, c)
    return bool((parts.min(axis=0) > 1e-3).any())


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
    values = random_parameters(name, seed, fixed)
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
        lengths = facet_measures(body.points, facets)[np.argsort(middle)]
        x = np.sort(middle)
        # a whole number of elements has to fit into each of three pieces
        np.testing.assert_allclose(lengths[np.abs(x) > 0.95], 0.002 * coarser, rtol=0.05)
        # at the centre it has just reached flat_size, less half an element times growth
        assert lengths[np.abs(x).argmin()] == pytest.approx(0.08 * coarser, rel=0.15)
        # a size that grows by 0.2 per distance makes each element 1.2 times its neighbour
        assert np.abs(np.diff(np.log(lengths))).max() < math.log(1.3)


@pytest.fixture(scope="module")
def stepped_firtree() -> Mesh:
    return firtree(lobes=4, lobe_gap=0.02, groove_radius=1.0, disc_depth=55.0)


def lobe_frame(points: NDArray[np.float64], lobe: int, side: int) -> NDArray[np.float64]:
    """Position along the flank of a lobe, downwards from its middle, and height above its flat."""
    default = {each.name: each.default for each in find_template("firtree").parameters}
    default |= COARSE_FIRTREE
    angle, relief, wedge_angle = (
        math.radians(default[f"{name}_angle"]) for name in ("flank", "relief", "wedge")
    )
    radius, fillet = default["upper_radius"], default["neck_fillet"]
    # from the neck: the fillet turns to the relieved direction, the rounding back to the flank
    x = default["neck_width"] / 2 + fillet + radius * math.sin(angle)
    x -= (radius + fillet) * math.sin(angle - relief)
    x += default["flank_length"] / 2 * math.cos(angle)
    down = (lobe - 1) * default["pitch"]
    middle = np.array([x - down * math.sin(wedge_angle), -down * math.cos(wedge_angle)])
    tangent, normal = (math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))
    return (points * [side, 1] - middle) @ np.array([tangent, normal]).T


@pytest.mark.parametrize("side", [-1, 1], ids=["left", "right"])
@pytest.mark.parametrize("lobe", [1, 2, 3, 4])
def test_firtree_flanks(stepped_firtree: Mesh, lobe: int, side: int) -> None:
    name = f"flank_{'left' if side < 0 else 'right'}_{lobe}"
    blade = facet_nodes(stepped_firtree.bodies["blade"], f"blade_{name}")
    disc = facet_nodes(stepped_firtree.bodies["disc"], f"disc_{name}")
    s, height = lobe_frame(blade, lobe, side).T
    beyond = np.maximum(np.abs(s) - 1.25, 0)
    # flat and circles of radius 1.2; Gmsh's tolerance on curves
    np.testing.assert_allclose(height, np.sqrt(1.44 - beyond**2) - 1.2, atol=1e-9)
    reach = 1.25 + 1.2 * math.sin(math.radians(10))
    along, gap = lobe_frame(disc, lobe, side).T
    np.testing.assert_allclose(gap, 0.02 * (lobe - 1), atol=1e-12)
    for ends in (s, along):
        np.testing.assert_allclose([ends.min(), ends.max()], [-reach, reach], atol=1e-9)


@pytest.mark.parametrize(("gap", "lowest"), [(0.01, 0.02), (-0.01, 0.0)])
def test_lobes_engage_from_the_top_or_from_the_bottom(gap: float, lowest: float) -> None:
    mesh = firtree(lobe_gap=gap)
    disc = facet_nodes(mesh.bodies["disc"], "disc_flank_right_3")
    np.testing.assert_allclose(lobe_frame(disc, 3, 1)[:, 1], lowest, atol=1e-12)


def test_backs_and_walls_of_the_firtree_keep_their_clearance(stepped_firtree: Mesh) -> None:
    outlines = []
    for body in stepped_firtree.bodies.values():
        edges, _ = exterior_facets(directed_facets(body.cells, body.cell, body.order), "line")
        contact = [f for name, f in body.boundaries.items() if "flank" in name]
        inner = np.unique(np.concatenate(contact))
        outlines.append(np.setdiff1d(np.unique(edges), inner))
    blade, disc = stepped_firtree.bodies.values()
    distance, _ = cKDTree(disc.points[outlines[1]]).query(blade.points[outlines[0]])
    # just behind the contact the rounding is 1.2 (1 - cos 10°) = .018 away
    assert distance.min() > 0.018
    y = blade.points[outlines[0], 1]
    wall = (y > 2.5) & (y < 4.0)  # the neck beside the rim
    assert wall.any()
    np.testing.assert_allclose(distance[wall], 0.3, rtol=0.2)  # node to node, not to line


def test_summary_counts_and_measures() -> None:
    mesh = cylinder(order=1)
    upper: BodySummary = mesh_summary(mesh)[0]
    body = mesh.bodies["upper"]
    assert (upper.name, upper.nodes, upper.elements) == ("upper", len(body.points), len(body.cells))
    assert (upper.cell, upper.order) == ("triangle", 1)
    top = {each.name: each for each in upper.boundaries}["upper_top"]
    assert top.measure == pytest.approx(14.0)
    assert top.facets == len(body.boundaries["upper_top"])
    assert 0 < top.smallest_facet <= top.measure / top.facets <= top.largest_facet


@pytest.mark.parametrize("make", [dovetail, firtree])
def test_sides_of_a_sector_match_node_by_node(make: Callable[..., Mesh]) -> None:
    disc = make(sectors=36, pitch_radius=300.0, disc_depth=100.0).bodies["disc"]
    sides = {"boundary1": "disc_side_left", "boundary2": "disc_side_right"}
    table = {"type": "cyclic", "sectors": 36, "centre": (0.0, -300.0), **sides}
    tie = tie_sides(
        Symmetry.model_validate(table), ("symmetry", "disc"), Path("case.toml"), disc, 2
    )
    np.testing.assert_array_equal(tie.weights.data, 1.0)
    assert len(tie.weights.data) == len(tie.followers) > 10
    # The bore: as far below the top of the disc as the disc is deep.
    x, y = facet_nodes(disc, "disc_bottom").reshape(-1, 2).T
    bore = np.hypot(x, y + 300.0)
    np.testing.assert_allclose(bore, bore[0], rtol=1e-5)
