# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gmsh files of a few elements, written as text, right or wrong as a test needs them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

Node = tuple[float, float, float]
# Gmsh element type, name of the physical group, node numbers from 1
Element = tuple[int, str, Sequence[int]]
DIMENSIONS = {
    kind: dim
    for dim, kinds in enumerate([(15,), (1, 8), (2, 3, 9, 10, 16, 21), (4, 5, 6, 7, 11, 12, 17)])
    for kind in kinds
}


@dataclass(frozen=True)
class TinyMesh:
    """Nodes and elements; a group without a name has the name ""."""

    nodes: tuple[Node, ...]
    elements: tuple[Element, ...]

    def write(self, path: Path) -> Path:
        """Write a file of format 2.2."""
        groups = self._groups()
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames"]
        named = {key: tag for key, tag in groups.items() if key[1]}
        lines.append(str(len(named)))
        lines += [f'{dim} {tag} "{name}"' for (dim, name), tag in named.items()]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(self.nodes))]
        lines += [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(self.nodes, 1)]
        lines += ["$EndNodes", "$Elements", str(len(self.elements))]
        for i, (kind, name, nodes) in enumerate(self.elements, 1):
            tag = groups[DIMENSIONS[kind], name]
            lines.append(f"{i} {kind} 2 {tag} {tag} {' '.join(map(str, nodes))}")
        path.write_text("\n".join([*lines, "$EndElements", ""]))
        return path

    def _groups(self) -> Mapping[tuple[int, str], int]:
        keys = dict.fromkeys((DIMENSIONS[kind], name) for kind, name, _ in self.elements)
        return {key: tag for tag, key in enumerate(keys, 1)}

    def add(self, *elements: Element) -> TinyMesh:
        """The mesh with more elements."""
        return replace(self, elements=(*self.elements, *elements))

    def move(self, node: int, x: float, y: float, z: float = 0.0) -> TinyMesh:
        """The mesh with one node elsewhere."""
        nodes = list(self.nodes)
        nodes[node - 1] = (x, y, z)
        return replace(self, nodes=tuple(nodes))

    def with_elements(self, *elements: Element) -> TinyMesh:
        """The same nodes with other elements."""
        return replace(self, elements=elements)


# Two unit squares of two triangles each: lower below y = 0 (nodes 1-4), upper above (5-8).
TWO_SQUARES = TinyMesh(
    nodes=(
        (0, -1, 0), (1, -1, 0), (1, 0, 0), (0, 0, 0),
        (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
    ),
    elements=(
        (2, "lower", (1, 2, 3)), (2, "lower", (1, 3, 4)),
        (2, "upper", (5, 6, 7)), (2, "upper", (5, 7, 8)),
        (1, "lower_face", (3, 4)), (1, "upper_face", (5, 6)), (1, "upper_top", (7, 8)),
    ),
)  # fmt: skip

# One 9-node quadrilateral with a facet on its lower side, whose middle is pulled down by 0.1.
CURVED_QUADRILATERAL = TinyMesh(
    nodes=(
        (0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0),
        (1, -0.1, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 1, 0),
    ),
    elements=((10, "block", (1, 2, 3, 4, 5, 6, 7, 8, 9)), (8, "face", (2, 1, 5))),
)  # fmt: skip

# One 6-node triangle.
CURVED_TRIANGLE = TinyMesh(
    nodes=((0, 0, 0), (2, 0, 0), (0, 2, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)),
    elements=((9, "block", (1, 2, 3, 4, 5, 6)),),
)
