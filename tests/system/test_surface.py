# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces in the plane: chains of facets with continuous normals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases import blocks

from fretfe._typing import Array
from fretfe.errors import MeshError
from fretfe.mesh.elements import reference_nodes, shape_values
from fretfe.mesh.mesh import BodyMesh
from fretfe.surface.surface import Chain, build_surface

ORDERS = pytest.mark.parametrize("order", [1, 2])


def ring_sector(points: Array) -> Array:
    """Radius 1 to 2, from 60 to 120 degrees; the grid's x runs clockwise."""
    angle = np.radians(120 - 60 * points[:, 0])
    radius = 1 + points[:, 1]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def sector(order: int, facets: int = 6) -> BodyMesh:
    x, y = np.linspace(0, 1, facets + 1), np.linspace(0, 1, 3)
    return blocks.block("b", x, y, order=order, mapping=ring_sector)


def shuffled(mesh: BodyMesh, name: str) -> BodyMesh:
    facets = mesh.boundaries[name]
    order = np.random.default_rng(3).permutation(len(facets))
    assert not np.array_equal(order, np.arange(len(facets)))
    return replace(mesh, boundaries={name: facets[order]})


@ORDERS
@pytest.mark.parametrize("name", ["b_bottom", "b_top"])
def test_facets_are_chained_in_any_order_of_the_file(name: str, order: int) -> None:
    mesh = sector(order)
    straight, other = build_surface(mesh, name), build_surface(shuffled(mesh, name), name)
    np.testing.assert_array_equal(other.nodes, straight.nodes)
    np.testing.assert_array_equal(straight.nodes[:-1, 1], straight.nodes[1:, 0])


@pytest.mark.parametrize(("name", "side"), [("b_bottom", -1.0), ("b_top", 1.0)])
def test_normals_point_out_of_the_body(name: str, side: float) -> None:
    surface = build_surface(sector(2), name)
    radial = surface.nodes / np.linalg.norm(surface.nodes, axis=2, keepdims=True)
    inner = surface.normals[1:-1]
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=2), 1.0, rtol=1e-14)
    # Averages over two equal facets, and the middles of symmetric ones, are exact by symmetry.
    np.testing.assert_allclose(inner, side * radial[1:-1], rtol=0, atol=1e-13)
    # At the two ends a parabola through an arc of 10 degrees: h^3/24 and smaller.
    np.testing.assert_allclose(surface.normals, side * radial, rtol=0, atol=3e-4)


@ORDERS
def test_normals_are_continuous(order: int) -> None:
    surface = build_surface(sector(order), "b_top")
    np.testing.assert_array_equal(surface.normals[:-1, 1], surface.normals[1:, 0])


@pytest.mark.parametrize(("order", "rate"), [(1, 2), (2, 4)])
def test_arc_length_converges(order: int, rate: int) -> None:
    counts = np.array([4, 8, 16])
    lengths = [build_surface(sector(order, n), "b_top").extent for n in counts]
    errors = np.abs(np.array(lengths) - 2 * np.pi / 3)
    observed = np.log2(errors[:-1] / errors[1:])
    np.testing.assert_allclose(observed, rate, atol=0.05)
    assert errors[-1] < {1: 5e-4, 2: 1e-7}[order]


def test_arc_is_measured_from_the_middle() -> None:
    mesh = blocks.block("b", [0.0, 1.0, 1.5, 4.0], [0.0, 1.0])
    np.testing.assert_allclose(
        Chain(build_surface(mesh, "b_bottom")).arc, [-2, -1, -0.5, 2], rtol=1e-14
    )
    np.testing.assert_allclose(Chain(build_surface(mesh, "b_top")).arc, [-2, 0.5, 1, 2], rtol=1e-14)


@ORDERS
@pytest.mark.parametrize("degree", [1, 2])
def test_displacement_points_lie_on_the_surface(degree: int, order: int) -> None:
    surface = build_surface(sector(order), "b_top")
    points, facets = surface.displacement_points(degree), surface.displacement_facets(degree)
    values = shape_values("line", order, reference_nodes("line", degree))
    expected = np.einsum("qk,fkd->fqd", values, surface.nodes)
    np.testing.assert_allclose(points[facets], expected, rtol=0, atol=1e-15)
    assert len(points) == len(np.unique(facets))


@pytest.mark.parametrize(
    ("facets", "message"),
    [
        ([0, 1, 3, 4], "2 separate pieces"),
        ([0, 2, 4], "3 separate pieces"),
    ],
)
def test_separate_pieces_are_an_error(facets: list[int], message: str) -> None:
    mesh = sector(1)
    mesh = replace(mesh, boundaries={"face": mesh.boundaries["b_top"][facets]})
    with pytest.raises(MeshError, match=f"surface 'face' of body 'b'.*{message}"):
        build_surface(mesh, "face")


def test_closed_curve_is_an_error() -> None:
    mesh = sector(1)
    mesh = replace(mesh, boundaries={"rim": np.concatenate(list(mesh.boundaries.values()))})
    with pytest.raises(MeshError, match="a closed curve"):
        build_surface(mesh, "rim")


def test_loop_at_the_end_of_a_curve_is_an_error() -> None:
    """The walk along the facets never ends by itself, and must not count a facet twice."""
    facets = np.array([[0, 1], [1, 2], [2, 1], [5, 6]])
    with pytest.raises(MeshError, match="2 separate pieces"):
        build_surface(replace(sector(1), boundaries={"face": facets}), "face")


def test_closed_curve_next_to_an_open_one_is_an_error() -> None:
    """One chain has a first facet, the other has none."""
    ring = np.array([[10, 11], [11, 12], [12, 10]])
    mesh = sector(1)
    mesh = replace(mesh, boundaries={"face": np.concatenate([mesh.boundaries["b_top"], ring])})
    with pytest.raises(MeshError, match=r"surface 'face' of body 'b'.*an open and a closed"):
        build_surface(mesh, "face")
