# SPDX-License-Identifier: LGPL-3.0-or-later
"""The search for opposite facets leaves nothing out and finds little more."""

from __future__ import annotations

import numpy as np
import pytest
from cases import chains
from cases.blocks import block

from fretfe._core import _kernels
from fretfe._typing import Array, Indices
from fretfe.mesh.elements import quadrature, shape_values
from fretfe.mesh.mesh import BodyMesh
from fretfe.surface.normals import contact_normals
from fretfe.surface.overlap import opposite_candidates, project, search_reach
from fretfe.surface.surface import Surface, build_surface

CURVED = pytest.mark.parametrize("curved", [False, True], ids=["straight", "curved"])


def wavy(rng: np.random.Generator, facets: int, curved: bool, height: float, noise: float) -> Array:
    """Points (facets or twice as many, + 1) from left to right: waves, and noise per spacing."""
    count = facets * (2 if curved else 1)
    x = np.linspace(-1, 1, count + 1) + rng.uniform(-0.2, 0.2, count + 1) / count
    waves = sum(np.cos(k * x + rng.uniform(0, 6)) / k**2 for k in (1, 3, 7, 20))
    return np.stack([x, height * waves + noise * rng.uniform(-1, 1, count + 1) / count], axis=1)


def wavy_pair(
    seed: int, facets: tuple[int, int], curved: bool, height: float, noise: float = 0.5
) -> tuple[Surface, Surface]:
    """Surfaces 1 and 2 with waves of their own, which cross each other."""
    rng = np.random.default_rng(seed)
    upper, lower = (wavy(rng, count, curved, height, noise) for count in facets)
    return chains.surface("upper", upper, curved), chains.surface("lower", lower[::-1], curved)


@CURVED
@pytest.mark.parametrize("height", [0.01, 0.2, 1.0])
@pytest.mark.parametrize("seed", range(1, 6))
def test_same_points_as_with_all_pairs(seed: int, height: float, curved: bool) -> None:
    """The same bits, in the same order."""
    far, near = wavy_pair(seed, (37, 50), curved, height)
    at, weights = quadrature("line", 5)
    normals = contact_normals(far, near)
    every = len(near.facets), len(far.facets)
    facet2, facet1, xi, eta, *rest = _kernels.overlap_points(
        near.nodes,
        normals,
        far.nodes,
        np.arange(every[0] + 1) * every[1],
        np.tile(np.arange(every[1]), every[0]),
        at[:, 0],
        weights,
        search_reach(near, far),
    )
    found = project(near, normals, far, (at[:, 0], weights))
    # Steep waves meet over a few facets only.
    assert len(xi) >= 5 * {0.01: 40, 0.2: 40, 1.0: 3}[height]
    np.testing.assert_array_equal(found.facet1, facet1)
    np.testing.assert_array_equal(found.facet2, facet2)
    np.testing.assert_array_equal(found.at1[:, 0], eta)
    np.testing.assert_array_equal(found.at2[:, 0], xi)
    for column, expected in zip((found.weights, found.gap, found.normals), rest, strict=True):
        np.testing.assert_array_equal(column, expected)


@CURVED
@pytest.mark.parametrize("noise", [0.0, 0.05], ids=["smooth", "rough"])
def test_long_chains_try_few_pairs(noise: float, curved: bool) -> None:
    """Each facet of 10 000 meets about two; tried are few more, of 10 000."""
    far, near = wavy_pair(3, (10_000, 10_000), curved, 0.05, noise)
    reach = search_reach(near, far)
    found = opposite_candidates(near, contact_normals(far, near), far, reach)
    assert found.starts[0] == 0 and found.starts[-1] == len(found.facets)
    assert 10_000 < len(found.facets) < 30 * 10_000


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("order", [1, 2])
def test_nothing_is_left_out_in_space(order: int, cell: str) -> None:
    """A facet somewhere on a normal of every facet of a wavy sheet."""
    rng = np.random.default_rng(7)
    near = sheet(rng, cell, order)
    reach = 0.7
    at = rng.dirichlet(np.ones(3), len(near.facets))[:, :2]
    values = shape_values(near.shape, order, at)
    points, normals = (
        np.einsum("fk,fkd->fd", values, nodal) for nodal in (near.nodes, near.normals)
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    met = points + rng.uniform(-reach, reach, (len(at), 1)) * normals
    # small triangles around the places that the normals reach
    corners = 0.01 * rng.uniform(-1, 1, (len(met), 3, 3))
    corners += (met - corners.mean(axis=1))[:, None]
    far = from_facets(corners.reshape(-1, 3), np.arange(3 * len(met)).reshape(-1, 3))
    found = opposite_candidates(near, near.normals, far, reach)
    lists = np.split(found.facets, found.starts[1:-1])
    assert all(number in each for number, each in enumerate(lists))
    assert all(np.all(np.diff(each) > 0) for each in lists)
    # The sheet is some facets wide only.
    assert len(found.facets) < 0.4 * len(near.facets) ** 2


def sheet(rng: np.random.Generator, cell: str, order: int) -> Surface:
    """Wavy facets over the square [0, 1]², with a little noise."""
    lines = np.linspace(0, 1, 9)
    grid = block("sheet", lines, lines, cell=cell, order=order)
    x, y = grid.points.T
    height = 0.1 * np.sin(3 * x) * np.cos(4 * y) + 0.0005 * rng.uniform(-1, 1, len(x))
    return from_facets(np.column_stack([x, y, height]), grid.cells)


def from_facets(points: Array, facets: Indices) -> Surface:
    cells = np.empty((0, 4), dtype=np.int64)
    mesh = BodyMesh("body", points, cells, "tetrahedron", 1, {"face": facets})
    return build_surface(mesh, "face")


def test_single_facet() -> None:
    ends = np.array([[0.0, 0.0], [1.0, 0.0]])
    far, near = (chains.surface("face", each, False) for each in (ends + 0.1, ends[::-1]))
    found = opposite_candidates(near, near.normals, far, 0.5)
    np.testing.assert_array_equal(found.starts, [0, 1])
    np.testing.assert_array_equal(found.facets, [0])
