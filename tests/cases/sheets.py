# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces in space made directly from arrays: no bodies, no elements."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from cases import blocks, chains
from cases.blocks import graded

from fretfe._typing import Array, Indices
from fretfe.mesh.mesh import BodyMesh
from fretfe.surface.surface import Surface, build_surface

__all__ = ["cap", "extruded_pair", "graded", "level", "sheet", "surface"]

# The nodes of a facet in the order in which it runs the other way round.
REVERSED = {
    3: [0, 2, 1],
    4: [0, 3, 2, 1],
    6: [0, 2, 1, 5, 4, 3],
    9: [0, 3, 2, 1, 7, 6, 5, 4, 8],
}
Lift = Callable[[Array], Array]


def surface(name: str, points: Array, facets: Indices) -> Surface:
    cells = np.empty((0, 4), dtype=np.int64)
    mesh = BodyMesh(f"body of {name}", points, cells, "tetrahedron", 1, {name: facets})
    return build_surface(mesh, name)


def level(height: float) -> Lift:
    return lambda points: np.column_stack([points, np.full(len(points), height)])


def sheet(
    name: str,
    x: Array,
    y: Array,
    cell: str,
    order: int,
    lift: Lift,
    *,
    down: bool = False,
    warp: float = 0.0,
) -> Surface:
    """Grid of x and y, lifted into space; its body is below or, looking down, above it.

    Nodes inside the rectangle are moved within it by up to `warp`.
    """
    grid = blocks.block(name, x, y, cell=cell, order=order)
    inside = np.prod([np.sin(np.pi * (p - p.min()) / np.ptp(p)) for p in grid.points.T], axis=0)
    waves = np.sin(5 * grid.points[:, ::-1] + [1.0, 2.0])
    points = lift(grid.points + warp * inside[:, None] * waves)
    return surface(
        name, points, grid.cells[:, REVERSED[grid.cells.shape[1]]] if down else grid.cells
    )


def cap(
    name: str,
    radius: float,
    cell: str,
    order: int,
    count: int,
    *,
    width: float = 0.35,
    down: bool = False,
) -> Surface:
    """Part of a sphere about the origin around the z axis, `count` facets each way."""
    angles = np.linspace(-width, width, count + 1)

    def lift(points: Array) -> Array:
        raised = np.column_stack([np.tan(points), np.ones(len(points))])
        return radius * raised / np.linalg.norm(raised, axis=1, keepdims=True)

    return sheet(name, angles, angles, cell, order, lift, down=down)


def extruded_pair(
    order: int, length: float
) -> tuple[tuple[Surface, Surface], tuple[Surface, Surface]]:
    """Curved chains in the plane that do not match; the same along z, in different layers."""
    plane = chains.random_pair(3, order == 2, chains.Placement())
    layers = (np.linspace(0, length, 4), np.linspace(0, length, 3))
    return plane, (_extruded(plane[0], layers[0], order), _extruded(plane[1], layers[1], order))


def _extruded(chain: Surface, layers: Array, order: int) -> Surface:
    """Quadrilaterals over the facets of a chain, between the layers."""
    if order == 2:
        layers = np.insert(layers, range(1, len(layers)), (layers[1:] + layers[:-1]) / 2)
    sections = [np.column_stack([chain.points, np.full(len(chain.points), z)]) for z in layers]
    # the nodes of the interval in the order in which they lie
    line = chain.facets[:, [0, 2, 1]] if order == 2 else chain.facets
    pattern = blocks.QUADRILATERAL[order]
    facets = [
        [nodes[i] + (start + j) * len(chain.points) for i, j in pattern]
        for start in range(0, len(layers) - 1, order)
        for nodes in line
    ]
    return surface(chain.name, np.vstack(sections), np.array(facets))
