# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies that mix shapes, and prisms and pyramids, as triangles or tetrahedra.

A solver's mesh has cells of one shape. A quadrilateral face is divided along the diagonal from its
node of lowest number, so that neighbours of any shape agree, and a solid is the cone over its faces
from its node of lowest number, whose own faces are divided so already (Dompierre et al. 1999, How
to subdivide pyramids, prisms and hexahedra into tetrahedra). No nodes are added: those in the
middle of faces and cells of order 2 become those of the diagonals.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.mesh.elements import (
    CORNERS,
    ELEMENTS,
    FACETS,
    MIDDLES,
    NUMBERS,
    PLURALS,
    PRISMATIC,
    SIMPLICES,
)
from fretfe.mesh.gmsh import ElementBlock, RawMesh

# Two diagonals whose lengths differ by less are the same.
SAME = 1e-9
_KINDS = {**ELEMENTS, **PRISMATIC}


def as_simplices(raw: RawMesh) -> RawMesh:
    """The mesh with triangles or tetrahedra where a body is not of one shape that is solved.

    Bodies with elements of other kinds or of several orders stay as they are.

    Returns:
        The mesh; its notes say which bodies were divided.
    """
    divided = {name: blocks for name, blocks in raw.bodies.items() if _to_be_divided(blocks)}
    if not divided:
        return raw
    inside = np.zeros(len(raw.points), dtype=bool)
    for blocks in divided.values():
        for block in blocks:
            inside[block.nodes] = True
    bodies = {
        name: [_divided(block, raw.points) for block in blocks] if name in divided else blocks
        for name, blocks in raw.bodies.items()
    }
    boundaries = raw.boundaries
    if raw.dimension == 3:
        boundaries = {
            name: [part for block in blocks for part in _divided_where(block, inside, raw.points)]
            for name, blocks in boundaries.items()
        }
    notes = (_note(name, blocks) for name, blocks in divided.items())
    return replace(raw, bodies=bodies, boundaries=boundaries, notes=(*raw.notes, *notes))


def _to_be_divided(blocks: Sequence[ElementBlock]) -> bool:
    """True for shapes that are known, of one order, and not one that is solved."""
    kinds = {_KINDS.get(block.gmsh_type) for block in blocks}
    known = {kind for kind in kinds if kind is not None}
    shapes, orders = {shape for shape, _ in known}, {order for _, order in known}
    several = len(shapes) > 1 or not kinds <= {*ELEMENTS.values()}
    return None not in kinds and len(orders) == 1 and several


def _note(name: str, blocks: Sequence[ElementBlock]) -> str:
    counts: dict[str, int] = {}
    for block in blocks:
        shape, order = _KINDS[block.gmsh_type]
        counts[PLURALS[shape]] = counts.get(PLURALS[shape], 0) + len(block.nodes)
    listed = " and ".join(f"{count} {shape}" for shape, count in counts.items())
    simplices = PLURALS[_simplex(shape)]
    stiff = ", which are stiffer in order 1: compare with a mesh of order 2" if order == 1 else ""
    return f"body '{name}' has {listed}, and is divided into {simplices}{stiff}"


def _simplex(shape: str) -> str:
    return "triangle" if shape in ("triangle", "quadrilateral") else "tetrahedron"


def _divided_where(block: ElementBlock, inside: Bools, points: Array) -> Iterator[ElementBlock]:
    """Facets that lie on bodies that are divided, divided alike, and the others."""
    shape, _ = ELEMENTS.get(block.gmsh_type, ("", 0))
    own = inside[block.nodes].all(axis=1) & (shape == "quadrilateral")
    if own.any():
        yield _of_faces(replace(block, nodes=block.nodes[own]))
    if not own.all():
        yield replace(block, nodes=block.nodes[~own])


def _of_faces(block: ElementBlock) -> ElementBlock:
    """Triangles on the faces of solids that are quadrilaterals."""
    shape, order = ELEMENTS[block.gmsh_type]
    parts = [
        block.nodes[rows][:, _places(shape, corners, order)]
        for corners, rows in _triangles(block.nodes, (0, 1, 2, 3))
    ]
    return ElementBlock(NUMBERS["triangle", order], np.concatenate(parts))


def _divided(block: ElementBlock, points: Array) -> ElementBlock:
    """Triangles or tetrahedra in place of cells."""
    shape, order = _KINDS[block.gmsh_type]
    if shape in SIMPLICES:
        return block
    parts = [
        block.nodes[rows][:, _places(shape, corners, order)]
        for corners, rows in (
            _halves(block.nodes, points)
            if shape == "quadrilateral"
            else _tetrahedra(block.nodes, shape)
        )
    ]
    return ElementBlock(NUMBERS[_simplex(shape), order], np.concatenate(parts))


def _halves(cells: Indices, points: Array) -> Iterator[tuple[tuple[int, ...], Bools]]:
    """Corners of the triangles on either side of the shorter diagonal of plane cells (m, k).

    Of equal ones that from the lowest node counts.
    """
    corners = points[cells[:, :4]]
    first = np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1)
    second = np.linalg.norm(corners[:, 3] - corners[:, 1], axis=1)
    even = cells[:, :4].argmin(axis=1) % 2 == 0
    from_first = np.where(np.abs(first - second) < SAME * first, even, first < second)
    for start, rows in ((0, from_first), (1, ~from_first)):
        turned = [(start + step) % 4 for step in range(4)]
        yield (turned[0], turned[1], turned[2]), rows
        yield (turned[0], turned[2], turned[3]), rows


def _tetrahedra(cells: Indices, shape: str) -> Iterator[tuple[tuple[int, ...], Bools]]:
    """Corners of the tetrahedra in solid cells (m, k), and the cells that have these."""
    apexes = cells[:, : CORNERS[shape]].argmin(axis=1)
    for apex in range(CORNERS[shape]):
        for face in FACETS[shape]:
            if apex not in face:
                for corners, rows in _triangles(cells, face):
                    yield (apex, *corners), rows & (apexes == apex)


def _triangles(cells: Indices, face: tuple[int, ...]) -> Iterator[tuple[tuple[int, ...], Bools]]:
    """Corners of the triangles of a face of cells (m, k), and the cells that have these."""
    if len(face) == 3:
        yield face, np.ones(len(cells), dtype=bool)
        return
    lowest = cells[:, list(face)].argmin(axis=1)
    for start in range(4):
        turned = face[start:] + face[:start]
        yield turned[:3], lowest == start
        yield (turned[0], *turned[2:]), lowest == start


@functools.cache
def _places(shape: str, corners: tuple[int, ...], order: int) -> list[int]:
    """Places in a cell of the nodes of a simplex with some of its corners.

    A node of order 2 is that in the middle of an edge, or of the face or cell that a diagonal
    crosses.
    """
    if order == 1:
        return list(corners)
    simplex = "triangle" if len(corners) == 3 else "tetrahedron"
    around = {frozenset(each): place for place, each in enumerate(MIDDLES[shape], CORNERS[shape])}
    ends = [{corners[end] for end in pair} for pair in MIDDLES[simplex]]
    middles = [min((each for each in around if pair <= each), key=len) for pair in ends]
    return [*corners, *(around[each] for each in middles)]
