# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies of a few cells of any shape and order, whole, slit or in pieces."""

from __future__ import annotations

from itertools import product

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.mesh.elements import MIDDLES, NUMBERS, SHAPE_DIMENSIONS
from fretfe.mesh.gmsh import ElementBlock, RawMesh

KINDS = [(cell, order) for cell in SHAPE_DIMENSIONS if cell != "line" for order in (1, 2)]
# The two triangles of a square, the six tetrahedra of a cube around its diagonal.
_TRIANGLES = ((0, 1, 2), (0, 2, 3))
_TETRAHEDRA = (
    (0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6),
)  # fmt: skip


class Cells:
    """Points (n, 3) and cells (m, corners), to which bricks are added one after the other."""

    def __init__(self, cell: str, order: int) -> None:
        self.cell, self.order = cell, order
        self.dimension = 3 if cell in ("tetrahedron", "hexahedron") else 2
        self.points: Array = np.zeros((0, 3))
        self.cells: Indices = np.zeros((0, 2**self.dimension), dtype=np.int64)

    def brick(self, low: tuple[float, ...], high: tuple[float, ...], *counts: int) -> Cells:
        """Add a brick with nodes of its own."""
        axes = [
            np.linspace(a, b, count + 1)
            for a, b, count in zip(low, high, counts[: self.dimension], strict=False)
        ]
        shape = [len(axis) for axis in axes]
        grid = np.stack([each.ravel() for each in np.meshgrid(*axes, indexing="ij")], axis=1)
        numbers = np.arange(len(grid)).reshape(shape) + len(self.points)
        square = ((0, 0), (1, 0), (1, 1), (0, 1))
        corners = square if self.dimension == 2 else [(*s, z) for z in (0, 1) for s in square]
        cells = [
            [numbers[tuple(np.add(start, corner))] for corner in corners]
            for start in product(*(range(count - 1) for count in shape))
        ]
        self.points = np.vstack([self.points, np.pad(grid, ((0, 0), (0, 3 - self.dimension)))])
        self.cells = np.vstack([self.cells, cells])
        return self

    def joined(self, at: tuple[float, ...]) -> Cells:
        """Make the nodes at one place one node."""
        place = np.pad(np.array(at, dtype=float), (0, 3 - len(at)))
        there = np.flatnonzero(np.linalg.norm(self.points - place, axis=1) < 1e-9)
        self.cells[np.isin(self.cells, there)] = there[0]
        return self

    def raw(self, name: str = "pad") -> RawMesh:
        """One body; points that no cell has stay."""
        parts = {"triangle": _TRIANGLES, "tetrahedron": _TETRAHEDRA}.get(self.cell)
        cells = self.cells
        if parts is not None:
            cells = np.concatenate([cells[:, list(part)] for part in parts])
        points, cells = _elevated(self.points, cells, self.cell) if self.order == 2 else (
            self.points, cells
        )  # fmt: skip
        block = ElementBlock(NUMBERS[self.cell, self.order], cells)
        return RawMesh(points, self.dimension, {name: [block]}, {})


def _elevated(points: Array, cells: Indices, cell: str) -> tuple[Array, Indices]:
    """The nodes of order 2; those of the same corners are one."""
    added: dict[frozenset[int], int] = {}
    rows = []
    for corners in cells.tolist():
        keys = [frozenset(corners[i] for i in around) for around in MIDDLES[cell]]
        rows.append([*corners, *(added.setdefault(k, len(points) + len(added)) for k in keys)])
    middles = [points[list(key)].mean(axis=0) for key in added]
    return np.vstack([points, *middles]), np.array(rows)
