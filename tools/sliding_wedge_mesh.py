# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write the mesh of the sliding wedge benchmark: python tools/sliding_wedge_mesh.py FILE.

A block on a wedge whose face rises by 0.1; both of linear quadrilaterals that do not match:

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
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SLOPE = 0.1
HEAD = """$Comments
SPDX-License-Identifier: LGPL-3.0-or-later
$EndComments
$MeshFormat
2.2 0 8
$EndMeshFormat
"""


@dataclass(frozen=True)
class Block:
    """A body between an inclined face, y = SLOPE x, and a horizontal one.

    Attributes:
        name: of the body.
        ends: smallest and largest x.
        level: y of the horizontal face.
        far: name of that face.
        cells: number of elements along x and y.
    """

    name: str
    ends: tuple[float, float]
    level: float
    far: str
    cells: tuple[int, int]

    def nodes(self) -> np.ndarray:
        """((columns + 1) * (rows + 1), 2) coordinates, row by row from the lower face."""
        columns, rows = self.cells
        x = np.linspace(*self.ends, columns + 1)
        faces = SLOPE * x, np.full_like(x, self.level)
        bottom, top = faces if self.level > 0 else faces[::-1]
        share = np.linspace(0.0, 1.0, rows + 1)[:, None]
        y = (1 - share) * bottom + share * top
        return np.column_stack([np.broadcast_to(x, y.shape).ravel(), y.ravel()])

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
        return {f"{self.name}_contact": contact, self.far: far}


BLOCKS = (
    Block("upper", (0.0, 2.0), 1.2, "upper_top", (10, 6)),
    Block("lower", (-1.0, 3.0), -1.0, "lower_bottom", (16, 5)),
)


def mesh_text() -> str:
    """The mesh in Gmsh's format, version 2.2."""
    groups: list[str] = []
    nodes: list[str] = []
    elements: list[str] = []
    for block in BLOCKS:
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


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(mesh_text(), encoding="ascii")
