# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reference facets: Lagrange functions, their slopes, and quadrature."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.mesh.elements import (
    BULGE,
    CORNERS,
    KINDS,
    SHAPE_DIMENSIONS,
    lattice,
    quadrature,
    reference_nodes,
    seven_points,
    shape_slopes,
    shape_values,
)

SHAPES = pytest.mark.parametrize("shape", list(BULGE))
DEGREES = pytest.mark.parametrize("degree", [1, 2])


def scattered(shape: str) -> Array:
    """Places in and around the reference facet."""
    return np.random.default_rng(2).uniform(-0.2, 1.2, (20, SHAPE_DIMENSIONS[shape]))


@SHAPES
@DEGREES
def test_functions_are_one_at_their_own_node(shape: str, degree: int) -> None:
    nodes = reference_nodes(shape, degree)
    np.testing.assert_allclose(shape_values(shape, degree, nodes), np.eye(len(nodes)), atol=1e-15)
    assert KINDS[nodes.shape[1] + 1, len(nodes)] == (shape, degree)


@SHAPES
@DEGREES
def test_functions_interpolate_polynomials_of_their_degree(shape: str, degree: int) -> None:
    at, nodes = scattered(shape), reference_nodes(shape, degree)
    weights = np.arange(1.0, 1 + at.shape[1])
    values = shape_values(shape, degree, at)
    np.testing.assert_allclose(
        values @ (0.3 + nodes @ weights) ** degree, (0.3 + at @ weights) ** degree, rtol=1e-12
    )


@SHAPES
@DEGREES
def test_slopes_are_those_of_the_functions(shape: str, degree: int) -> None:
    at, step = scattered(shape), 1e-6
    ahead, behind = (
        np.stack([shape_values(shape, degree, at + sign * step * axis) for axis in axes], axis=1)
        for sign, axes in ((1, np.eye(at.shape[1])), (-1, np.eye(at.shape[1])))
    )
    # Central differences are exact for polynomials of degree 2 along each axis but for round-off.
    difference = (ahead - behind) / (2 * step)
    np.testing.assert_allclose(shape_slopes(shape, degree, at), difference, rtol=0, atol=1e-9)


@SHAPES
@pytest.mark.parametrize("count", [1, 2, 4, 5])
def test_quadrature_is_exact(shape: str, count: int) -> None:
    at, weights = quadrature(shape, count)
    degree = 2 * count - 2
    x, y = at[:, 0], at[:, -1]
    expected = {
        "line": [1 / (degree + 1)] * (degree + 1),
        "triangle": [
            factorial(i) * factorial(degree - i) / factorial(degree + 2) for i in range(degree + 1)
        ],
        "quadrilateral": [1 / ((i + 1) * (degree - i + 1)) for i in range(degree + 1)],
    }[shape]
    found = [weights @ (x**i * y ** (degree - i)) for i in range(degree + 1)]
    np.testing.assert_allclose(found, expected, rtol=1e-13)


@SHAPES
def test_bound_of_what_other_nodes_add_to_corners(shape: str) -> None:
    functions = shape_values(shape, 2, lattice(shape, 121))[:, CORNERS[shape] :]
    sums = np.abs(functions).sum(axis=1)
    assert 0.999 * BULGE[shape] < sums.max() <= BULGE[shape] * (1 + 1e-14)


def test_seven_points_in_a_triangle() -> None:
    at, weights = seven_points()
    powers = [(i, j) for i in range(6) for j in range(6 - i)]
    found = [weights @ (at[:, 0] ** i * at[:, 1] ** j) for i, j in powers]
    expected = [factorial(i) * factorial(j) / factorial(i + j + 2) for i, j in powers]
    np.testing.assert_allclose(found, expected, rtol=1e-14)


@SHAPES
def test_lattice_holds_the_nodes(shape: str) -> None:
    at = lattice(shape, 5)
    distances = np.linalg.norm(reference_nodes(shape, 2)[:, None] - at, axis=2)
    np.testing.assert_allclose(distances.min(axis=1), 0, atol=1e-15)
    assert len(at) == {"line": 5, "triangle": 15, "quadrilateral": 25}[shape]
