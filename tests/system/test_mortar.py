# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mortar kernel against its slow twin, and what the coupling operators must conserve."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from cases import chains
from cases.chains import Placement
from reference import mortar_twin
from scipy.integrate import quad

from fretfe._typing import Array
from fretfe.errors import ModelError
from fretfe.surface.mortar import Coupling, couple
from fretfe.surface.normals import contact_normals
from fretfe.surface.overlap import project, search_reach
from fretfe.surface.surface import Surface

HERE = Placement()
INCLINED = Placement(angle=37.0)
OVERHEAD = Placement(angle=170.0)
# Facets of about 1e-3 at coordinates of 1e3: round-off of coordinates is 1e-10 of a facet.
FAR = Placement(angle=-52.0, scale=2e-3, origin=(1e3, -1e3))
PLACES = pytest.mark.parametrize(
    "place", [HERE, INCLINED, OVERHEAD, FAR], ids=["here", "inclined", "overhead", "far"]
)
CURVED = pytest.mark.parametrize("curved", [False, True], ids=["straight", "curved"])
SIDES = pytest.mark.parametrize("side", ["surface1", "surface2"])
DEGREES = pytest.mark.parametrize("degree", [1, 2])
SEEDS = pytest.mark.parametrize("seed", range(4))


def round_off(place: Placement) -> float:
    """Error of coordinates relative to a facet, times 20 for what follows from them."""
    return 20 * np.finfo(float).eps * (1 + np.abs(place.origin).max() / place.scale)


@PLACES
@CURVED
@SEEDS
def test_kernel_and_twin_give_the_same_points(seed: int, curved: bool, place: Placement) -> None:
    near, far = chains.random_pair(seed, curved, place)
    points, weights = np.polynomial.legendre.leggauss(4)
    rule = (points + 1) / 2, weights / 2
    found = project(near, near.normals, far, rule)
    twin = mortar_twin.overlap_points(
        near.nodes, near.normals, far.nodes, *rule, search_reach(near, far)
    )
    assert len(found.weights) > 4 * 10
    np.testing.assert_array_equal(found.facet1, twin.facet1)
    np.testing.assert_array_equal(found.facet2, twin.facet2)
    # Newton in the kernel stops at steps of 1e-10; quadratic convergence leaves round-off.
    close = partial(np.testing.assert_allclose, rtol=0, atol=1e-12 + round_off(place))
    close(found.at1, twin.at1)
    close(found.at2, twin.at2)
    close(found.normals, twin.normals)
    close(found.weights / place.scale, twin.weights / place.scale)
    close(found.gap / place.scale, twin.gap / place.scale)


def coupling(pair: tuple[Surface, Surface], side: str, degree: int) -> Coupling:
    return couple("main", *pair, side, degree)


def components(values: Array) -> tuple[Array, Array]:
    """Normal and tangential rows."""
    return values[0::2], values[1::2]


@SIDES
@PLACES
@CURVED
def test_weights_add_up_to_the_length_of_the_overlap(
    curved: bool, place: Placement, side: str
) -> None:
    operators = coupling(chains.straight_pair(3, curved, place), side, 1)
    start, end = chains.OVERLAP
    # Geometry is straight: quadrature is exact, only round-off remains.
    tolerance = 10 * round_off(place)
    assert operators.surface.weights.sum() == pytest.approx(
        (end - start) * place.scale, rel=tolerance
    )


@SIDES
@SEEDS
def test_overlap_on_curved_facets_is_an_arc_length_of_body_2(seed: int, side: str) -> None:
    upper, lower = chains.random_pair(seed, True, HERE)
    operators = coupling((upper, lower), side, 2)
    count, normals = len(lower.facets), contact_normals(upper, lower)
    # The lower chain runs backwards, and from the foot of the upper one's end to its own end.
    facet, xi = next(
        (f, foot[0])
        for f in range(count)
        if (foot := mortar_twin.feet(lower.nodes[f], normals[f], upper.nodes[-1, 1]))
    )
    starts = [xi if f == facet else 0.0 for f in range(count)]
    expected = sum(
        quad(lambda t, n=lower.nodes[f]: np.hypot(*mortar_twin.slope(n, t)), starts[f], 1)[0]
        for f in range(facet, count)
    )
    # Five Gauss points on a root of a quadratic, facets that turn by about 0.05.
    assert operators.surface.weights.sum() == pytest.approx(expected, rel=1e-7)


@SIDES
@DEGREES
@PLACES
@CURVED
@SEEDS
def test_forces_on_the_bodies_are_opposite(
    seed: int, curved: bool, place: Placement, degree: int, side: str
) -> None:
    pair = chains.random_pair(seed, curved, place)
    operators = coupling(pair, side, degree)
    tractions = np.random.default_rng(seed).standard_normal(operators.body1.shape[0])
    force1 = (operators.body1.T @ tractions).reshape(-1, 2).sum(axis=0)
    force2 = (operators.body2.T @ tractions).reshape(-1, 2).sum(axis=0)
    # Partition of unity of both traces at every integration point: round-off.
    np.testing.assert_allclose(force1, -force2, rtol=0, atol=1e-12 * place.scale)
    assert np.linalg.norm(force1) > 1e-3 * place.scale


@SIDES
@DEGREES
@PLACES
@CURVED
def test_moments_on_touching_bodies_are_opposite(
    curved: bool, place: Placement, degree: int, side: str
) -> None:
    pair = chains.straight_pair(5, curved, place)
    operators = coupling(pair, side, degree)
    tractions = np.random.default_rng(1).standard_normal(operators.body1.shape[0])
    arms = [s.displacement_points(degree) - np.array(place.origin) for s in pair]
    forces = [(b.T @ tractions).reshape(-1, 2) for b in (operators.body1, operators.body2)]
    moments = [
        arm[:, 0] @ force[:, 1] - arm[:, 1] @ force[:, 0]
        for arm, force in zip(arms, forces, strict=True)
    ]
    # The lever of the round-off is the size of the surfaces.
    tolerance = 10 * round_off(place) * place.scale**2
    assert moments[0] == pytest.approx(-moments[1], abs=tolerance)
    assert abs(moments[0]) > 1e-3 * place.scale**2


@SIDES
@DEGREES
@PLACES
def test_linear_fields_are_transferred_exactly(place: Placement, degree: int, side: str) -> None:
    """u = B x on both sides of a touching interface: no jump at any node."""
    pair = chains.straight_pair(7, False, place)
    operators = coupling(pair, side, degree)
    gradient = np.array([[0.3, -1.1], [0.7, 0.4]])
    fields = [(s.displacement_points(degree) - np.array(place.origin)) @ gradient.T for s in pair]
    jump = operators.body1 @ fields[0].ravel() + operators.body2 @ fields[1].ravel()
    size = place.scale * np.repeat(operators.surface.weights, 2)
    # Fields of size place.scale: round-off of coordinates.
    np.testing.assert_allclose(jump / size, 0.0, atol=10 * round_off(place))


@SIDES
@PLACES
@CURVED
@SEEDS
def test_position_and_rotation_measure_the_gap(
    seed: int, curved: bool, place: Placement, side: str
) -> None:
    """x1 - x2 = gap n at every pair of points, on curved surfaces with isoparametric traces too."""
    degree = 2 if curved else 1
    pair = chains.random_pair(seed, curved, place)
    operators = coupling(pair, side, degree)
    positions = [s.displacement_points(degree) - np.array(place.origin) for s in pair]
    turned = [np.stack([-x[:, 1], x[:, 0]], axis=1) for x in positions]
    stretch = operators.body1 @ positions[0].ravel() + operators.body2 @ positions[1].ravel()
    rotation = operators.body1 @ turned[0].ravel() + operators.body2 @ turned[1].ravel()
    scale = operators.surface.weights * place.scale
    expected = {"normal": operators.gap / scale, "none": np.zeros(len(scale))}
    normal, tangential = components(stretch)
    # Round-off of coordinates; a node at the edge of the overlap has a weight of 1e-3 or more.
    close = partial(np.testing.assert_allclose, rtol=0, atol=100 * round_off(place))
    close(normal / scale, expected["normal"])
    close(tangential / scale, expected["none"])
    # A rotation moves body 2 relative to body 1 by gap times t, and opens nothing.
    normal, tangential = components(rotation)
    close(normal / scale, expected["none"])
    close(tangential / scale, expected["normal"])


@SIDES
def test_gap_is_positive_where_bodies_are_apart(side: str) -> None:
    operators = coupling(chains.straight_pair(1, False, INCLINED, gap=0.125), side, 1)
    np.testing.assert_allclose(operators.gap / operators.surface.weights, 0.125, rtol=1e-12)


@SIDES
@PLACES
def test_pressure_pushes_the_bodies_apart_and_shear_drags_body_2_along(
    place: Placement, side: str
) -> None:
    operators = coupling(chains.straight_pair(2, True, place), side, 2)
    normal, tangent = place.vector((0.0, 1.0)), place.vector((1.0, 0.0))
    pressure, shear = 3.0, 0.5
    tractions = np.tile([pressure, shear], len(operators.surface.weights))
    force1 = (operators.body1.T @ tractions).reshape(-1, 2).sum(axis=0)
    force2 = (operators.body2.T @ tractions).reshape(-1, 2).sum(axis=0)
    length = operators.surface.weights.sum()
    expected = length * (pressure * normal - shear * tangent)
    tolerance = 10 * round_off(place) * length
    np.testing.assert_allclose(force1, expected, rtol=0, atol=tolerance)
    np.testing.assert_allclose(force2, -expected, rtol=0, atol=tolerance)


@SIDES
@PLACES
@CURVED
def test_nodes_run_along_t_with_right_handed_frames(
    curved: bool, place: Placement, side: str
) -> None:
    operators = coupling(chains.straight_pair(4, curved, place), side, 1)
    normal, tangent = place.vector((0.0, 1.0)), place.vector((1.0, 0.0))
    expected = np.broadcast_to(np.stack([normal, tangent]), operators.surface.frames.shape)
    np.testing.assert_allclose(
        operators.surface.frames, expected, rtol=0, atol=10 * round_off(place)
    )
    steps = np.diff(operators.surface.points, axis=0)
    assert np.all(np.diff(operators.surface.arc) > 0)
    np.testing.assert_allclose(
        steps / place.scale,
        np.diff(operators.surface.arc)[:, None] * tangent / place.scale,
        rtol=0,
        atol=10 * round_off(place),
    )


def test_finer_side_carries_the_multipliers() -> None:
    first, second = chains.straight_pair(3, False, HERE)
    assert np.median(second.measures) < np.median(first.measures)
    chosen = coupling((first, second), "finer", 1)
    expected = coupling((first, second), "surface2", 1)
    np.testing.assert_array_equal(chosen.surface.points, expected.surface.points)


def arc_of(radius: float, angles: Array) -> Array:
    """Points on a circle through the origin with its centre at (0, -radius)."""
    return radius * np.stack([np.sin(angles), np.cos(angles) - 1], axis=1)


def flat(x: Array) -> Array:
    return np.stack([x, np.zeros_like(x)], axis=1)


ANGLES = np.linspace(-0.1, 0.1, 33)
MORE_ANGLES = np.linspace(-0.12, 0.12, 25)
ROUND, UPSIDE_DOWN = arc_of(1.0, ANGLES), arc_of(-1.0, -MORE_ANGLES)


@SIDES
@pytest.mark.parametrize(
    ("upper", "lower", "turn", "tolerance"),
    [
        (flat(np.linspace(-0.11, 0.11, 13)), ROUND, 0.0, 1e-12),
        (arc_of(-1.0, -ANGLES), flat(np.linspace(-0.11, 0.11, 25)), 0.0, 1e-12),
        # Normals of the upper surface are taken from the nearest of 17 samples of a facet of 0.02,
        # and nearest is not quite opposite.
        (UPSIDE_DOWN, ROUND, 0.0, 1e-3),
        (arc_of(1.0, MORE_ANGLES), ROUND, 1.0, 1e-3),
    ],
    ids=["flat on round", "round on flat", "equal cylinders", "conforming"],
)
def test_normals_of_curved_contacts(
    upper: Array, lower: Array, turn: float, tolerance: float, side: str
) -> None:
    pair = chains.surface("upper", upper, True), chains.surface("lower", lower[::-1], True)
    operators = coupling(pair, side, 2)
    theta = turn * np.arctan2(operators.surface.points[:, 0], 1 + operators.surface.points[:, 1])
    expected = np.stack([np.sin(theta), np.cos(theta)], axis=1)
    inner = slice(1, -1)  # at the two ends the mean around a node is to one side of it
    np.testing.assert_allclose(
        operators.surface.frames[inner, 0], expected[inner], rtol=0, atol=tolerance
    )


def test_arc_length_on_a_curved_surface() -> None:
    """On a convex body 2 of radius 1 arc runs clockwise, along t."""
    pair = (
        chains.surface("upper", flat(np.linspace(-0.11, 0.11, 13)), True),
        chains.surface("lower", ROUND[::-1], True),
    )
    operators = coupling(pair, "surface2", 2)
    theta = np.arctan2(operators.surface.points[:, 0], 1 + operators.surface.points[:, 1])
    # Facets of angle 0.0125 and order 2: arc lengths to h^4.
    np.testing.assert_allclose(operators.surface.arc, theta, rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    "place",
    [Placement(origin=(0.0, 10.0)), Placement(origin=(20.0, 0.0)), Placement(angle=180.0)],
    ids=["far apart", "side by side", "back to back"],
)
def test_surfaces_that_never_meet_are_named(place: Placement) -> None:
    lower = chains.straight_pair(1, False, HERE)[1]
    upper = chains.straight_pair(1, False, place)[0]
    with pytest.raises(ModelError, match=r"'main'.*'upper' and 'lower' never face each other"):
        coupling((upper, lower), "finer", 1)
