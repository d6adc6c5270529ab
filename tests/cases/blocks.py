# SPDX-License-Identifier: LGPL-3.0-or-later
"""Structured meshes of rectangular blocks, straight or mapped, made without Gmsh."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.mesh.mesh import BodyMesh

Map = Callable[[Array], Array]

# Node patterns on the (order + 1)^2 lattice of one grid cell, in Gmsh's order, (column, row).
QUADRILATERAL = {
    1: [(0, 0), (1, 0), (1, 1), (0, 1)],
    2: [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)],
}
LOWER_TRIANGLE = {
    1: [(0, 0), (1, 0), (1, 1)],
    2: [(0, 0), (2, 0), (2, 2), (1, 0), (2, 1), (1, 1)],
}
UPPER_TRIANGLE = {
    1: [(0, 0), (1, 1), (0, 1)],
    2: [(0, 0), (2, 2), (0, 2), (1, 1), (1, 2), (0, 1)],
}


def block(
    name: str,
    x: Sequence[float] | Array,
    y: Sequence[float] | Array,
    *,
    cell: str = "quadrilateral",
    order: int = 1,
    mapping: Map | None = None,
) -> BodyMesh:
    """Mesh of the rectangle with grid lines `x` and `y`, moved by `mapping`.

    Boundaries `<name>_bottom`, `_right`, `_top`, `_left`, each with the body on its left.
    """
    columns, rows = _refine(x, order), _refine(y, order)
    grid = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    number = np.arange(len(grid)).reshape(len(rows), len(columns))
    patterns = (
        [QUADRILATERAL[order]]
        if cell == "quadrilateral"
        else [LOWER_TRIANGLE[order], UPPER_TRIANGLE[order]]
    )
    cells = [
        [number[j + b, i + a] for a, b in pattern]
        for j in range(0, len(rows) - 1, order)
        for i in range(0, len(columns) - 1, order)
        for pattern in patterns
    ]
    sides = {
        "bottom": number[0],
        "right": number[:, -1],
        "top": number[-1, ::-1],
        "left": number[::-1, 0],
    }
    return BodyMesh(
        name=name,
        points=grid if mapping is None else mapping(grid),
        cells=np.array(cells, dtype=np.int64),
        cell=cell,
        order=order,
        boundaries={f"{name}_{side}": _facets(line, order) for side, line in sides.items()},
    )


def _refine(lines: Sequence[float] | Array, order: int) -> Array:
    lines = np.asarray(lines, dtype=float)
    steps = np.arange((len(lines) - 1) * order + 1) / order
    return np.interp(steps, np.arange(len(lines)), lines)


def _facets(line: Indices, order: int) -> Indices:
    ends = [line[:-order:order], line[order::order]]
    return np.stack(ends if order == 1 else [*ends, line[1::2]], axis=1)


def rotated(angle: float) -> Map:
    """Rotation about the origin, in degrees."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, s], [-s, c]])
    return lambda points: points @ turn


def graded(start: float, end: float, count: int, growth: float = 1.3) -> Array:
    """Grid lines whose spacing grows by a constant factor: no two meshes match by chance."""
    sizes = growth ** np.arange(count)
    return start + (end - start) * np.concatenate([[0.0], np.cumsum(sizes)]) / sizes.sum()
