# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cells with nodes on their edges only, completed by those inside: the same geometry.

An eight-node quadrilateral is the nine-node one whose centre is where the former has it, as the
serendipity functions are in the span of the nine; so is a 20-node hexahedron a 27-node one.
(Zienkiewicz, Taylor & Zhu, The Finite Element Method, 7th ed., chapter 6.)
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.geometry.gmsh_elements import (
    NUMBERS,
    SERENDIPITY_HEXAHEDRON,
    SERENDIPITY_QUADRILATERAL,
)
from fretfe.geometry.gmsh_model import ElementBlock, RawMesh
from fretfe.mesh.cell_geometry import FACETS, MIDDLES

# The shape functions of corners and of mid-side nodes at the centre of a quadrilateral and of a
# hexahedron.
AT_CENTRE = {
    SERENDIPITY_QUADRILATERAL: np.array([-1 / 4] * 4 + [1 / 2] * 4),
    SERENDIPITY_HEXAHEDRON: np.array([-1 / 4] * 8 + [1 / 4] * 12),
}


def complete(raw: RawMesh) -> RawMesh:
    """The mesh with nodes inside all cells and facets that have them on their edges only."""
    centres = _Centres(raw.points)
    bodies, boundaries = (
        {name: [centres.completed(block) for block in blocks] for name, blocks in groups.items()}
        for groups in (raw.bodies, raw.boundaries)
    )
    return RawMesh(centres.all_points(), raw.dimension, bodies, boundaries)


class _Centres:
    """Nodes that are added to a mesh; cells with a face in common share its centre."""

    def __init__(self, points: Array) -> None:
        self._points = points
        self._added: list[Array] = []
        self._count = len(points)
        self._of_faces: dict[frozenset[int], int] = {}

    def all_points(self) -> Array:
        """(n + added, 3) coordinates."""
        return np.vstack([self._points, *self._added])

    def completed(self, block: ElementBlock) -> ElementBlock:
        """The elements with all their nodes, if they are of a kind that lacks some."""
        kind, nodes = block.gmsh_type, block.nodes
        if kind == SERENDIPITY_QUADRILATERAL:
            return ElementBlock(NUMBERS["quadrilateral", 2], self._with_centres(nodes))
        if kind != SERENDIPITY_HEXAHEDRON:
            return block
        faces = [self._with_centres(nodes[:, list(face)])[:, 8:] for face in _faces()]
        own = self._numbers(np.einsum("k,mkd->md", AT_CENTRE[kind], self._points[nodes]))
        return ElementBlock(NUMBERS["hexahedron", 2], np.column_stack([nodes, *faces, own]))

    def _with_centres(self, nodes: Indices) -> Indices:
        """(f, 9) nodes of quadrilaterals (f, 8); a face that is known has its centre already."""
        keys = [frozenset(corners) for corners in nodes[:, :4].tolist()]
        new = [number for number, key in enumerate(keys) if key not in self._of_faces]
        places = np.einsum(
            "k,fkd->fd", AT_CENTRE[SERENDIPITY_QUADRILATERAL], self._points[nodes[new]]
        )
        for number, centre in zip(new, self._numbers(places).tolist(), strict=True):
            self._of_faces[keys[number]] = centre
        return np.column_stack([nodes, [self._of_faces[key] for key in keys]])

    def _numbers(self, places: Array) -> Indices:
        """Numbers (k,) of new nodes at places (k, 3)."""
        self._added.append(places)
        self._count += len(places)
        return np.arange(self._count - len(places), self._count)


def _faces() -> Iterator[tuple[int, ...]]:
    """Places of the eight nodes of each face among the 20 of a hexahedron."""
    edges = {frozenset(ends): i for i, ends in enumerate(MIDDLES["hexahedron"][:12], 8)}
    for corners in FACETS["hexahedron"]:
        ahead = (*corners[1:], corners[0])
        yield *corners, *(edges[frozenset(pair)] for pair in zip(corners, ahead, strict=True))


def stacked(blocks: Iterable[ElementBlock]) -> list[ElementBlock]:
    """One block for each type of element."""
    types: dict[int, list[Indices]] = {}
    for block in blocks:
        if len(block.nodes):
            types.setdefault(block.gmsh_type, []).append(block.nodes)
    return [ElementBlock(kind, np.concatenate(nodes)) for kind, nodes in types.items()]
