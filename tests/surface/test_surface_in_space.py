# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces of solids: meshes of triangles or quadrilaterals, flat or curved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases import blocks, sheets

from fretfe._typing import Array, Indices
from fretfe.case import Solid
from fretfe.errors import MeshError, ModelError
from fretfe.mesh.elements import reference_nodes, shape_values
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.surface import (
    Chain,
    Surface,
    build_surface,
    facet_turns,
    tangent_frames,
)

KINDS = pytest.mark.parametrize(
    ("shape", "order"), [(s, o) for s in ("triangle", "quadrilateral") for o in (1, 2)]
)
DEGREES = pytest.mark.parametrize("degree", [1, 2])


def faced(name: str, points: Array, facets: Indices) -> BodyMesh:
    """A body of which only its boundary `face` is there."""
    cells = np.empty((0, 4), dtype=np.int64)
    return BodyMesh(f"body of {name}", points, cells, "tetrahedron", 1, {"face": facets})


def sheet(shape: str, order: int, count: int = 4) -> BodyMesh:
    """The square [-1, 1]² seen from above, as facets of uneven sizes."""
    lines = blocks.graded(-1, 1, count), blocks.graded(-1, 1, count + 1, 0.8)
    grid = blocks.block("sheet", *lines, cell=shape, order=order)
    points = np.column_stack([grid.points, np.zeros(len(grid.points))])
    return faced("sheet", points, grid.cells)


def flat(shape: str, order: int) -> Surface:
    return build_surface(sheet(shape, order), "face")


def dome(shape: str, order: int, count: int = 4) -> Surface:
    """The square over the sixth of the unit sphere around the z axis."""
    lines = np.tan(np.linspace(-np.pi / 4, np.pi / 4, count + 1))
    grid = blocks.block("dome", lines, lines, cell=shape, order=order)
    points = np.column_stack([grid.points, np.ones(len(grid.points))])
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return build_surface(faced("dome", points, grid.cells), "face")


@KINDS
def test_normals_of_a_sphere(shape: str, order: int) -> None:
    surface = dome(shape, order, 8)
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=2), 1, rtol=1e-14)
    # Facets of about 0.2: flat ones turn by half of that; curved ones err by its square and less.
    allowed = {1: 0.15, 2: 0.03}[order]
    np.testing.assert_allclose(surface.normals, surface.nodes, rtol=0, atol=allowed)


@KINDS
def test_normals_are_equal_where_facets_meet(shape: str, order: int) -> None:
    surface = dome(shape, order)
    common = np.empty((len(surface.points), 3))
    common[surface.facets] = surface.normals
    np.testing.assert_array_equal(common[surface.facets], surface.normals)


@KINDS
def test_area_of_a_sphere_converges(shape: str, order: int) -> None:
    areas = np.array([dome(shape, order, count).measures.sum() for count in (4, 8, 16)])
    errors = np.abs(areas - 4 * np.pi / 6)
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2 * order, atol=0.3)
    assert dome(shape, order, 16).extent == pytest.approx(np.sqrt(areas[-1]), rel=1e-14)
    assert errors[-1] < {1: 5e-3, 2: 1e-5}[order]


@KINDS
def test_sizes_are_roots_of_areas(shape: str, order: int) -> None:
    surface = flat(shape, order)
    np.testing.assert_allclose(surface.sizes**2, surface.measures, rtol=1e-14)
    assert surface.measures.sum() == pytest.approx(4.0, rel=1e-14)


@KINDS
def test_hats_integrate_linear_functions(shape: str, order: int) -> None:
    surface = flat(shape, order)
    hats = surface.hat_products.sum(axis=1)
    assert len(hats) == 5 * 6
    # ∫ x, ∫ y and ∫ 1 over the square; hats hold linear functions exactly.
    np.testing.assert_allclose(hats @ surface.vertices, 0, atol=1e-14)
    assert hats.sum() == pytest.approx(4.0, rel=1e-14)
    assert hats.min() > 0


@KINDS
@DEGREES
def test_displacement_points_lie_on_the_surface(shape: str, order: int, degree: int) -> None:
    surface = dome(shape, order)
    points, facets = surface.displacement_points(degree), surface.displacement_facets(degree)
    values = shape_values(surface.shape, order, reference_nodes(surface.shape, degree))
    expected = np.einsum("qk,fkd->fqd", values, surface.nodes)
    np.testing.assert_allclose(points[facets], expected, rtol=0, atol=1e-15)
    # A grid of 4 x 4, and all lines halved: neighbours share nodes.
    assert len(points) == len(np.unique(facets)) == (4 * degree + 1) ** 2
    np.testing.assert_array_equal(points[: len(surface.vertices)], surface.vertices)


@KINDS
def test_facets_may_come_in_any_order(shape: str, order: int) -> None:
    mesh = sheet(shape, order)
    facets = np.random.default_rng(1).permutation(mesh.boundaries["face"])
    surface = build_surface(replace(mesh, boundaries={"face": facets}), "face")
    np.testing.assert_array_equal(surface.nodes, mesh.points[facets])
    assert len(surface.points) == len(mesh.points)


@KINDS
def test_facet_turned_over_is_an_error(shape: str, order: int) -> None:
    mesh = sheet(shape, order)
    corners = {"triangle": 3, "quadrilateral": 4}[shape]
    facets = mesh.boundaries["face"].copy()
    facets[5, :corners] = facets[5, :corners][::-1]
    with pytest.raises(MeshError, match=r"surface 'face' of body.*counter-clockwise"):
        build_surface(replace(mesh, boundaries={"face": facets}), "face")


@KINDS
def test_nearest_places_and_normals(shape: str, order: int) -> None:
    surface = dome(shape, order)
    rng = np.random.default_rng(5)
    directions = np.column_stack([rng.uniform(-0.6, 0.6, (30, 2)), np.ones(30)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    places, normals = surface.nearest(1.3 * directions)
    # Samples are an eighth of a facet of 0.4 apart; flat facets of 0.4 are within 0.03 of the arc.
    np.testing.assert_allclose(places, directions, rtol=0, atol=0.08)
    np.testing.assert_allclose(normals, directions, rtol=0, atol={1: 0.2, 2: 0.08}[order])
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=1e-14)


@pytest.mark.parametrize("order", [1, 2])
def test_boundaries_of_an_extruded_block_look_outwards(order: int) -> None:
    plane = blocks.block("b", [0.0, 1.0, 2.0], [0.0, 1.5, 3.0], cell="triangle", order=order)
    body = extrude(Mesh({"b": plane}), Solid(length=5.0, skew=0.0, layers=2)).bodies["b"]
    expected = {
        "b_bottom": ((0, -1, 0), 10.0),
        "b_right": ((1, 0, 0), 15.0),
        "b_top": ((0, 1, 0), 10.0),
        "b_left": ((-1, 0, 0), 15.0),
        "b_front": ((0, 0, 1), 6.0),
        "b_back": ((0, 0, -1), 6.0),
    }
    surfaces = {name: build_surface(body, name) for name in body.boundaries}
    areas = {name: pytest.approx(area, rel=1e-14) for name, (_, area) in expected.items()}
    assert {name: surface.measures.sum() for name, surface in surfaces.items()} == areas
    for name, (normal, _) in expected.items():
        found = surfaces[name].normals
        np.testing.assert_allclose(found, np.broadcast_to(normal, found.shape), atol=1e-14)


def around(axis: int, sign: float, spread: float = 0.3) -> Array:
    """Unit normals that turn by up to about 40 degrees from a coordinate axis."""
    t = np.linspace(-spread, spread, 21)
    grid = np.stack(np.meshgrid(t, t), axis=-1).reshape(-1, 2)
    normals = np.insert(grid, axis, sign * 0.5, axis=1)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_frames_are_right_handed_and_smooth(axis: int, sign: float) -> None:
    normals = around(axis, sign)
    frames = tangent_frames(normals)
    products = np.einsum("nid,njd->nij", frames, frames)
    np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), products.shape), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(frames), 1, rtol=1e-14)
    np.testing.assert_array_equal(frames[:, 0], normals)
    steps = np.linalg.norm(np.diff(frames.reshape(21, 21, 3, 3), axis=1), axis=-1)
    # The axis is 50 degrees or more from the normals: tangents turn little faster than these.
    assert steps.max() < 2 * steps[..., 0].max()


def test_frames_of_an_extrusion_are_those_of_the_plane() -> None:
    angles = np.linspace(0, 6, 50)
    plane = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    frames = tangent_frames(np.insert(plane, 2, 0.0, axis=1))
    np.testing.assert_allclose(frames[:, :2, :2], tangent_frames(plane), atol=1e-15)
    np.testing.assert_allclose(frames[:, 2], np.tile([0, 0, -1.0], (50, 1)), atol=1e-15)


def test_arc_length_is_of_the_plane_only() -> None:
    with pytest.raises(ModelError, match=r"surface 'face' of body.*a curve in the plane"):
        Chain(flat("triangle", 1))


@pytest.mark.parametrize("length", [0.01, 10.0])
def test_facets_of_a_sweep_turn_as_its_section_does(length: float) -> None:
    """However long they are, there are as many of them to a radius."""
    radius, places = 2.0, np.linspace(-0.1, 0.1, 11)

    def arc(points: Array) -> Array:
        return np.column_stack([points, np.sqrt(radius**2 - points[:, 0] ** 2) - radius])

    swept = sheets.sheet("s", places, np.array([0.0, length]), "triangle", 2, arc)
    # arcs of 0.1 over chords: 1 + 0.05²/6
    assert facet_turns(swept) == pytest.approx(np.full(20, 0.02 / radius), rel=2e-3)
