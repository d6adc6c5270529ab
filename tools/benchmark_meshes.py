# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write the meshes of three benchmarks: python tools/benchmark_meshes.py FOLDER.

An upper body on a lower one, both of linear quadrilaterals: a block on a wedge whose face rises by
0.1, a pad with a radius on a block, fine where they touch, both of which do not match, and half of
a plate on a support.

             upper_top
        +----------------+ y = 1.2
        |     upper      |               lower_contact is longer than upper_contact,
    ____|____..---"------+--             so that the block can slide
   +--""                   |
   |          lower        |
   +-----------------------+ y = -1
  x = -1  0              2  3
          lower_bottom
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SLOPE = 0.1
# Of the face of the pad; half of the width that is meshed finely, elements there, at the other body
# and below the faces, and what they grow by from one to the next.
RADIUS, ZONE, SIZE, LOWER_SIZE, DEPTH, GROWTH = 2.0, 0.22, 0.011, 0.012, 0.015, 1.7
HEAD = """$Comments
SPDX-License-Identifier: LGPL-3.0-or-later
$EndComments
$MeshFormat
2.2 0 8
$EndMeshFormat
"""


@dataclass(frozen=True)
class Block:
    """A body between a contact face and a horizontal one.

    Attributes:
        name: of the body.
        x: of the columns of nodes.
        face: y of the contact face at x.
        level: y of the horizontal face.
        far: name of that face.
        share: of the height at the rows of nodes, from the lower face.
        sides: names of the sides with the smallest and the largest x; empty for none.
    """

    name: str
    x: np.ndarray
    face: Callable[[np.ndarray], np.ndarray]
    level: float
    far: str
    share: np.ndarray
    sides: tuple[str, str] = ("", "")

    @property
    def cells(self) -> tuple[int, int]:
        """Number of elements along x and y."""
        return len(self.x) - 1, len(self.share) - 1

    def nodes(self) -> np.ndarray:
        """((columns + 1) * (rows + 1), 2) coordinates, row by row from the lower face."""
        faces = self.face(self.x), np.full_like(self.x, self.level)
        bottom, top = faces if self.level > 0 else faces[::-1]
        share = self.share[:, None]
        y = (1 - share) * bottom + share * top
        return np.column_stack([np.broadcast_to(self.x, y.shape).ravel(), y.ravel()])

    def quadrilaterals(self) -> list[tuple[int, ...]]:
        """Nodes of each element, counted from 0."""
        columns, rows = self.cells
        corners = (r * (columns + 1) + c for r in range(rows) for c in range(columns))
        return [(n, n + 1, n + columns + 2, n + columns + 1) for n in corners]

    def lines(self) -> dict[str, list[tuple[int, ...]]]:
        """Nodes of the elements of both faces, by name."""
        columns, rows = self.cells
        bottom: list[tuple[int, ...]] = [(c, c + 1) for c in range(columns)]
        top: list[tuple[int, ...]] = [
            (c + rows * (columns + 1), c + 1 + rows * (columns + 1)) for c in range(columns)
        ]
        contact, far = (bottom, top) if self.level > 0 else (top, bottom)
        found = {f"{self.name}_contact": contact, self.far: far}
        for name, start in zip(self.sides, (0, columns), strict=True):
            if name:
                rises = range(start, start + rows * (columns + 1), columns + 1)
                found[name] = [(node, node + columns + 1) for node in rises]
        return found


def wedge() -> tuple[Block, Block]:
    """The block on the wedge."""

    def rows(count: int) -> np.ndarray:
        return np.linspace(0.0, 1.0, count + 1)

    def face(x: np.ndarray) -> np.ndarray:
        return SLOPE * x

    return (
        Block("upper", np.linspace(0.0, 2.0, 11), face, 1.2, "upper_top", rows(6)),
        Block("lower", np.linspace(-1.0, 3.0, 17), face, -1.0, "lower_bottom", rows(5)),
    )


def pad() -> tuple[Block, Block]:
    """The pad on the block: 3 and 6 wide, 2 and 3 high, for a contact 0.33 wide."""

    def rounding(x: np.ndarray) -> np.ndarray:
        return np.asarray(x**2 / (2 * RADIUS))

    upper, lower = graded(0.0, DEPTH, 2.0) / 2.0, graded(0.0, DEPTH, 3.0) / 3.0
    return (
        Block("upper", columns(SIZE, 1.5), rounding, 2.0, "upper_top", upper),
        Block(
            "lower", columns(LOWER_SIZE, 3.0), np.zeros_like, -3.0, "lower_bottom", 1 - lower[::-1]
        ),
    )


def plate() -> tuple[Block, Block]:
    """Half of a plate of 80 by 40, whose middle is at x = 40, on a support that is longer."""
    level = np.zeros_like
    upper, lower = (np.linspace(start, 40.0, count) for start, count in ((0.0, 33), (-10.0, 41)))
    return (
        Block(
            "upper", upper, level, 40.0, "upper_top", np.linspace(0.0, 1.0, 33),
            sides=("upper_left", "upper_middle"),
        ),
        Block(
            "lower", lower, level, -10.0, "lower_bottom", np.linspace(0.0, 1.0, 9),
            sides=("", "lower_middle"),
        ),
    )  # fmt: skip


def columns(size: float, end: float) -> np.ndarray:
    """Places from -end to end, even in the zone of contact."""
    inner = np.linspace(-ZONE, ZONE, round(2 * ZONE / size) + 1)
    outer = graded(ZONE, GROWTH * size, end)[1:]
    return np.concatenate([-outer[::-1], inner, outer])


def graded(start: float, size: float, end: float) -> np.ndarray:
    """Places from start to end at distances that grow."""
    places = [start]
    while places[-1] + 1.5 * size < end:
        places.append(places[-1] + size)
        size *= GROWTH
    return np.array([*places, end])


def mesh_text(blocks: Sequence[Block]) -> str:
    """A mesh in Gmsh's format, version 2.2."""
    groups: list[str] = []
    nodes: list[str] = []
    elements: list[str] = []
    for block in blocks:
        first = len(nodes) + 1
        nodes += [f"{first + i} {x:.10g} {y:.10g} 0" for i, (x, y) in enumerate(block.nodes())]
        curves = [(1, name, lines) for name, lines in block.lines().items()]
        for dimension, name, members in (*curves, (2, block.name, block.quadrilaterals())):
            tag = len(groups) + 1
            groups.append(f'{dimension} {tag} "{name}"')
            for member in members:
                numbers = " ".join(str(first + node) for node in member)
                shape = 3 if dimension == 2 else 1
                elements.append(f"{len(elements) + 1} {shape} 2 {tag} {tag} {numbers}")
    sections = {"PhysicalNames": groups, "Nodes": nodes, "Elements": elements}
    return HEAD + "".join(
        f"${name}\n{len(lines)}\n" + "\n".join(lines) + f"\n$End{name}\n"
        for name, lines in sections.items()
    )


MESHES = {"sliding_wedge.msh": wedge, "pad.msh": pad, "plate.msh": plate}

if __name__ == "__main__":
    for name, blocks in MESHES.items():
        Path(sys.argv[1], name).write_text(mesh_text(blocks()), encoding="ascii")
