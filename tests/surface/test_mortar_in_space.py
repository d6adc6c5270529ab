# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mortar coupling of surfaces in space: areas, gaps, balance, and the plane inside space."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from cases import sheets
from reference import mortar_space_twin
from scipy.spatial.transform import Rotation

from fretfe._typing import Array
from fretfe.mesh.elements import quadrature
from fretfe.surface.checks import contact_quality, initial_gap
from fretfe.surface.mortar import Coupling, couple
from fretfe.surface.normals import contact_normals
from fretfe.surface.overlap import overlap_points, project, search_reach
from fretfe.surface.surface import Surface, deviations, mean_curvature

CELLS = ("triangle", "quadrilateral")
PAIRS = pytest.mark.parametrize(
    ("cell1", "cell2", "order"), [(a, b, o) for a in CELLS for b in CELLS for o in (1, 2)]
)
KINDS = pytest.mark.parametrize(("cell", "order"), [(c, o) for c in CELLS for o in (1, 2)])
SIDES = pytest.mark.parametrize("side", ["surface1", "surface2"])
# Overlap of the rectangles of `flat_pair`.
AREA = 1.5 * 1.85


def flat_pair(
    cell1: str, cell2: str, order: int, gap: float = 0.0, warp: float = 0.0
) -> tuple[Surface, Surface]:
    """Rectangles above each other that do not match; each is covered by the other in part."""
    x1, y1 = sheets.graded(-1, 0.8, 5), sheets.graded(-0.9, 1, 6, 0.8)
    x2, y2 = sheets.graded(-0.7, 1, 7), sheets.graded(-1, 0.95, 5, 0.8)
    upper = sheets.sheet("upper", x1, y1, cell1, order, sheets.level(gap), down=True, warp=warp)
    return upper, sheets.sheet("lower", x2, y2, cell2, order, sheets.level(0.0), warp=-warp)


def wavy_pair(cell1: str, cell2: str, order: int) -> tuple[Surface, Surface]:
    """Few curved facets with gaps of both signs, which reach beyond each other."""

    def lift(phase: float) -> sheets.Lift:
        return lambda p: np.column_stack(
            [p, 0.04 * np.sin(2 * p[:, 0] + phase) * np.cos(1.7 * p[:, 1] - phase)]
        )

    x, y = sheets.graded(-1, 0.7, 2), sheets.graded(-0.8, 1, 2, 0.8)
    upper = sheets.sheet("upper", x, y, cell1, order, lift(0.3), down=True, warp=0.06)
    x, y = sheets.graded(-0.7, 1, 2), sheets.graded(-1, 0.9, 2, 0.7)
    return upper, sheets.sheet("lower", x, y, cell2, order, lift(0.5), warp=-0.06)


@PAIRS
def test_kernel_and_twin_give_the_same_points(cell1: str, cell2: str, order: int) -> None:
    far, near = wavy_pair(cell1, cell2, order)
    rules = quadrature("quadrilateral", 2), quadrature("triangle", 2)
    found = project(near, near.normals, far, *rules)
    twin = mortar_space_twin.overlap_points(
        near.nodes, near.normals, far.nodes, *rules, search_reach(near, far)
    )
    assert len(found.weights) > 30
    assert found.gap.min() < 0 < found.gap.max()
    np.testing.assert_array_equal(found.facet1, twin.facet1)
    np.testing.assert_array_equal(found.facet2, twin.facet2)
    for name in ("at1", "at2", "weights", "gap", "normals"):
        # Newton in the kernel stops at steps of 1e-10; quadratic convergence leaves round-off.
        np.testing.assert_allclose(getattr(found, name), getattr(twin, name), rtol=0, atol=1e-11)


@PAIRS
@pytest.mark.parametrize(("scale", "origin"), [(1.0, 0.0), (2e-3, 1e3)], ids=["here", "far"])
def test_turned_surfaces_give_the_same_points(
    cell1: str, cell2: str, order: int, scale: float, origin: float
) -> None:
    """Far away, round-off of coordinates is 1e-10 of a facet."""
    pair = wavy_pair(cell1, cell2, order)
    turn = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    moved = [
        sheets.surface(each.name, scale * each.points @ turn.T + origin, each.facets)
        for each in pair
    ]
    expected, found = overlap_points(*pair), overlap_points(*moved)
    tolerance = 1e-13 if origin == 0 else 1e-8
    assert len(found.gap) == len(expected.gap)
    close = partial(np.testing.assert_allclose, rtol=0, atol=tolerance)
    close(found.at1, expected.at1)
    close(found.at2, expected.at2)
    close(found.weights / scale**2, expected.weights)
    close(found.gap / scale, expected.gap)
    close(found.normals @ turn, expected.normals)


@PAIRS
def test_weights_add_up_to_the_area_of_the_overlap(cell1: str, cell2: str, order: int) -> None:
    pair = flat_pair(cell1, cell2, order, gap=0.1)
    overlap = overlap_points(*pair)
    assert overlap.weights.sum() == pytest.approx(AREA, rel=1e-13)
    np.testing.assert_allclose(overlap.gap, 0.1, rtol=1e-13)
    np.testing.assert_allclose(overlap.normals, [[0, 0, 1]] * len(overlap.gap), atol=1e-15)


@PAIRS
@SIDES
def test_hats_are_a_partition_of_unity(cell1: str, cell2: str, order: int, side: str) -> None:
    pair = flat_pair(cell1, cell2, order, gap=0.1)
    coupling = couple("main", *pair, side, order)
    assert coupling.surface.weights.sum() == pytest.approx(AREA, rel=1e-13)
    assert coupling.gap == pytest.approx(0.1 * coupling.surface.weights, rel=1e-12)
    ones = np.ones(len(coupling.surface.weights))
    np.testing.assert_allclose(coupling.averaging @ ones, ones, rtol=1e-12)
    assert len(coupling.surface.arc) == 0
    # Constant tractions act on both bodies alike: n = z, t1 = n × e, t2 = n × t1.
    tractions = np.tile([3.0, 0.5, -0.2], len(ones))
    force1, force2 = (
        (body.T @ tractions).reshape(-1, 3).sum(axis=0) for body in (coupling.body1, coupling.body2)
    )
    expected = AREA * np.array([3.0, -0.5, 0.2]) @ coupling.surface.frames[0]
    np.testing.assert_allclose(force1, expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(force2, -expected, rtol=0, atol=1e-12)


@PAIRS
@SIDES
def test_linear_fields_on_flat_surfaces_give_no_jump(
    cell1: str, cell2: str, order: int, side: str
) -> None:
    """The facets have curved edges and middles that are off the middle."""
    pair = flat_pair(cell1, cell2, order, warp=0.05)
    coupling = couple("main", *pair, side, order)
    assert jump(coupling, pair, order).max() < 1e-12


@pytest.mark.parametrize(("count", "allowed"), [(8, 1e-5), (16, 1e-6)])
@pytest.mark.parametrize(("cell1", "cell2"), [(a, b) for a in CELLS for b in CELLS])
def test_linear_fields_on_spheres_give_the_jump_of_their_gap(
    cell1: str, cell2: str, count: int, allowed: float
) -> None:
    """Two meshes of one sphere: what is left is their distance from it, which falls with h⁴."""
    pair = (
        sheets.cap("cavity", 1.0, cell1, 2, count, width=0.4, down=True),
        sheets.cap("ball", 1.0, cell2, 2, count + 1),
    )
    coupling = couple("main", *pair, "finer", 2)
    assert jump(coupling, pair, 2).max() < allowed
    tractions = np.random.default_rng(0).standard_normal(coupling.body1.shape[0])
    forces = [(b.T @ tractions).reshape(-1, 3) for b in (coupling.body1, coupling.body2)]
    np.testing.assert_allclose(forces[0].sum(axis=0), -forces[1].sum(axis=0), rtol=0, atol=1e-15)
    moments = [
        np.cross(surface.displacement_points(2), force).sum(axis=0)
        for surface, force in zip(pair, forces, strict=True)
    ]
    np.testing.assert_allclose(moments[0], -moments[1], rtol=0, atol=allowed / 50)


def jump(coupling: Coupling, pair: tuple[Surface, Surface], degree: int) -> Array:
    """(N * 3,) mean relative displacement around the nodes of a linear field on both surfaces."""
    gradient = np.array([[0.3, -1.1, 0.2], [0.7, 0.4, -0.5], [-0.6, 0.9, 0.8]])
    fields = [surface.displacement_points(degree) @ gradient.T for surface in pair]
    found = coupling.body1 @ fields[0].ravel() + coupling.body2 @ fields[1].ravel()
    return np.abs(found) / np.repeat(coupling.surface.weights, 3)


@SIDES
@KINDS
def test_facets_of_the_nodes_look_out_of_body_2(cell: str, order: int, side: str) -> None:
    pair = flat_pair(cell, cell, order)
    surface = couple("main", *pair, side, order).surface
    assert surface.facets is not None
    corners = surface.points[surface.facets]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(normals[:, 2] > 0) and np.all(normals[:, :2] == 0)
    assert set(np.unique(surface.facets)) <= set(range(len(surface.points)))
    # All facets that overlap somewhere; those of the first surface are 5 × 6, of the second 7 × 5.
    per_cell = 2 if cell == "triangle" else 1
    assert len(surface.facets) <= per_cell * (30 if side == "surface1" else 35)
    assert len(surface.facets) >= per_cell * (20 if side == "surface1" else 28)
    # The rectangles reach beyond each other: nodes at the end have cut hats.
    ends = np.concatenate([surface.points.min(axis=0), surface.points.max(axis=0)])[[0, 1, 3, 4]]
    assert np.all(np.abs(ends) >= np.array([0.7, 0.9, 0.8, 0.95]) - 1e-12)


@pytest.mark.parametrize(("cell1", "cell2"), [(a, b) for a in CELLS for b in CELLS])
def test_gap_of_concentric_spheres(cell1: str, cell2: str) -> None:
    """A cavity of radius 1.05 around a ball of 1; facets of .06 with curved edges."""
    ball = sheets.cap("ball", 1.0, cell2, 2, 13)
    cavity = sheets.cap("cavity", 1.05, cell1, 2, 12, width=0.4, down=True)
    overlap = overlap_points(cavity, ball)
    np.testing.assert_allclose(overlap.gap, 0.05, rtol=4e-4)
    # All of the ball is below the cavity.
    assert overlap.weights.sum() == pytest.approx(ball.measures.sum(), rel=1e-10)


@pytest.mark.parametrize("counts", [(2, 20), (20, 2), (6, 7)])
@pytest.mark.parametrize(("order1", "order2"), [(1, 2), (2, 1), (2, 2)])
@pytest.mark.parametrize(("cell1", "cell2"), [(a, b) for a in CELLS for b in CELLS])
def test_nothing_is_missed_or_counted_twice(
    cell1: str, cell2: str, order1: int, order2: int, counts: tuple[int, int]
) -> None:
    """Facets of very different sizes and kinds, one mesh turned about the other."""
    far = sheets.cap("far", 1.05, cell1, order1, counts[0], width=0.6, down=True)
    turn = Rotation.from_rotvec([0, 0, 0.4]).as_matrix()
    far = sheets.surface("far", far.points @ turn.T, far.facets)
    near = sheets.cap("near", 1.0, cell2, order2, counts[1], width=0.3)
    overlap = overlap_points(far, near)
    shares = np.bincount(overlap.facet2, overlap.weights, len(near.facets))
    np.testing.assert_allclose(shares, near.measures, rtol=1e-8)


@KINDS
def test_the_nearest_of_two_layers_counts(cell: str, order: int) -> None:
    """The second one looks down too, from above the first one, and reaches further."""
    y = sheets.graded(-1.1, 1.1, 5)
    below = sheets.sheet("below", sheets.graded(-1, 1, 6), y / 1.1, cell, order, sheets.level(0.0))
    layers = [
        sheets.sheet(
            "near", sheets.graded(-1.2, 0.0, 4), y, cell, order, sheets.level(0.1), down=True
        ),
        sheets.sheet(
            "far", sheets.graded(-1.2, 1.2, 4), y, cell, order, sheets.level(0.6), down=True
        ),
    ]
    points = np.vstack([layer.points for layer in layers])
    facets = np.vstack([layers[0].facets, layers[1].facets + len(layers[0].points)])
    overlap = overlap_points(sheets.surface("both", points, facets), below)
    near = overlap.gap < 0.3
    np.testing.assert_allclose(overlap.gap[near], 0.1, rtol=1e-12)
    assert overlap.weights[near].sum() == pytest.approx(2.0, rel=1e-13)
    # The end of the first layer cuts facets of the second: points of these count or do not.
    assert overlap.weights[~near].sum() == pytest.approx(2.0, rel=0.06)


@pytest.mark.parametrize("order", [1, 2])
def test_mean_curvature_of_an_extrusion_is_that_of_the_plane(order: int) -> None:
    for plane, solid in zip(*sheets.extruded_pair(order, 0.8), strict=True):
        assert mean_curvature(solid) == pytest.approx(mean_curvature(plane), rel=1e-13)


@KINDS
def test_curvature_of_a_sphere(cell: str, order: int) -> None:
    surface = sheets.cap("cap", 2.0, cell, order, 12)
    # At the rim of flat facets the normal is that of one side: some turning is missing.
    assert mean_curvature(surface) == pytest.approx(np.sqrt(2) / 2, rel={1: 0.08, 2: 1e-3}[order])
    size = 0.7 * 2 / 12
    # half of the diagonal, squared, over the diameter
    expected = (size / np.sqrt(2)) ** 2 / 4
    found = deviations(surface).max()
    if order == 1:
        assert found == pytest.approx(expected, rel=1.2) and found > 0.8 * expected
    else:
        assert found < expected / 1000


@KINDS
def test_normals_of_flat_against_round_are_those_of_the_flat(cell: str, order: int) -> None:
    line = np.linspace(-0.5, 0.5, 7)
    flat = sheets.sheet("flat", line, line, cell, order, sheets.level(1.0))
    below = sheets.sheet("below", line, line, cell, order, sheets.level(1.0), down=True)
    ball = sheets.cap("ball", 1.0, cell, order, 8)
    normals = contact_normals(below, ball)
    np.testing.assert_allclose(normals, np.broadcast_to([0, 0, 1.0], normals.shape), atol=1e-14)
    assert contact_normals(ball, flat) is flat.normals


@pytest.mark.parametrize("order", [1, 2])
@SIDES
def test_the_plane_inside_space(order: int, side: str) -> None:
    """Extruded quadrilaterals: sums over z are the operators of the plane, times the length."""
    plane, solid = sheets.extruded_pair(order, length=0.8)
    flat, deep = (couple("main", *pair, side, order) for pair in (plane, solid))
    at_ends = deep.surface.points[:, 2] == 0
    assert at_ends.sum() == len(flat.surface.weights)
    same_section = [
        np.flatnonzero(np.all(deep.surface.points[:, :2] == x, axis=1)) for x in flat.surface.points
    ]
    weights = np.array([deep.surface.weights[nodes].sum() for nodes in same_section])
    np.testing.assert_allclose(weights, 0.8 * flat.surface.weights, rtol=1e-12)
    gaps = np.array([deep.gap[nodes].sum() for nodes in same_section])
    np.testing.assert_allclose(gaps, 0.8 * flat.gap, rtol=0, atol=1e-12 * np.abs(flat.gap).max())
    rng = np.random.default_rng(2)
    for number in (0, 1):
        shallow, thick = (pair[number].displacement_points(order) for pair in (plane, solid))
        field = rng.standard_normal(shallow.shape)
        found = np.array([np.flatnonzero(np.all(shallow == x[:2], axis=1))[0] for x in thick])
        moved = np.insert(field[found], 2, 0.0, axis=1)
        body = ("body1", "body2")[number]
        expected = 0.8 * (getattr(flat, body) @ field.ravel()).reshape(-1, 2)
        rows = (getattr(deep, body) @ moved.ravel()).reshape(-1, 3)
        sums = np.array([rows[nodes].sum(axis=0) for nodes in same_section])
        np.testing.assert_allclose(sums[:, :2], expected, rtol=0, atol=1e-12)
        np.testing.assert_allclose(sums[:, 2], 0.0, atol=1e-12)


@KINDS
def test_quality_of_a_ball_above_a_flat(cell: str, order: int) -> None:
    line = np.linspace(-0.5, 0.5, 7)
    flat = sheets.sheet("flat", line, line, cell, order, sheets.level(1.02), down=True)
    ball = sheets.cap("ball", 1.0, cell, order, 8)
    (found,) = contact_quality({"main": initial_gap(flat, ball)})
    # The side of an even triangle with half of a square.
    share = np.sqrt(2 / np.sqrt(3)) if cell == "triangle" else 1.0
    first, second = found.surfaces
    assert first.measure == pytest.approx(1.0, rel=1e-12)
    assert first.smallest == pytest.approx(share / 6, rel=1e-12)
    assert first.radius == np.inf
    assert second.opposite == second.facets == len(ball.facets)
    assert found.measure == pytest.approx(second.measure, rel=1e-10)
    assert found.extent == pytest.approx(np.sqrt(found.measure))
    assert second.radius == pytest.approx(1.0, rel=0.15)
    assert found.gap == pytest.approx(0.02, abs=0.002)
    assert found.nearest == pytest.approx([0, 0, 1], abs=0.05)
