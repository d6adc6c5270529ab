# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies that mix shapes, and prisms and pyramids, as triangles or tetrahedra.

A solver's mesh has cells of one shape. Nodes have ranks. A quadrilateral face is divided along the
diagonal from its node of lowest rank, so that neighbours of any shape agree, and a solid is the
cone over its faces from its node of lowest rank, whose own faces are divided so already (Dompierre
et al. 1999, How to subdivide pyramids, prisms and hexahedra into tetrahedra). Ranks are the numbers
of the nodes, but where two triangles of neighbours lie on a quadrilateral: their diagonal counts.
No nodes are added: those in the middle of faces and cells of order 2 become those of the diagonals.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.errors import MeshError
from fretfe.mesh.elements import (
    CORNERS,
    ELEMENTS,
    FACETS,
    MIDDLES,
    NUMBERS,
    PLURALS,
    PRISMATIC,
    SIMPLICES,
    row_keys,
)
from fretfe.mesh.gmsh import ElementBlock, RawMesh

# Two diagonals whose lengths differ by less are the same.
SAME = 1e-9
_KINDS = {**ELEMENTS, **PRISMATIC}


def as_simplices(raw: RawMesh, source: str) -> RawMesh:
    """The mesh with triangles or tetrahedra where a body is not of one shape that is solved.

    Bodies with elements of other kinds or of several orders stay as they are.

    Returns:
        The mesh; its notes say which bodies were divided.

    Raises:
        MeshError: faces of neighbours cannot be divided alike.
    """
    divided = {name: blocks for name, blocks in raw.bodies.items() if _to_be_divided(blocks)}
    if not divided:
        return raw
    ranks, middles = np.arange(len(raw.points)), np.arange(len(raw.points))
    inside = np.zeros(len(raw.points), dtype=bool)
    for name, blocks in divided.items():
        for block in blocks:
            inside[block.nodes] = True
        if raw.dimension == 3 and len(faces := _on_triangles(blocks)):
            _rank(ranks, faces, f"{source}: body '{name}'")
            _join_middles(middles, blocks, faces)
    bodies = {
        name: [_divided(block, raw.points, ranks, middles) for block in blocks]
        if name in divided
        else blocks
        for name, blocks in raw.bodies.items()
    }
    boundaries = raw.boundaries
    if raw.dimension == 3:
        boundaries = {
            name: [part for block in blocks for part in _divided_where(block, inside, ranks)]
            for name, blocks in boundaries.items()
        }
    notes = (_note(name, blocks) for name, blocks in divided.items())
    return replace(raw, bodies=bodies, boundaries=boundaries, notes=(*raw.notes, *notes))


def _on_triangles(blocks: Sequence[ElementBlock]) -> Indices:
    """(f, 4) corners of quadrilateral faces on which two triangles lie, along the first and third.

    Meshers put prisms so on hexahedra.
    """
    faces: dict[int, list[Indices]] = {3: [], 4: []}
    for block in blocks:
        for corners in FACETS[_KINDS[block.gmsh_type][0]]:
            faces[len(corners)].append(block.nodes[:, list(corners)])
    if not faces[3] or not faces[4]:
        return np.empty((0, 4), dtype=np.int64)
    triangles, squares = np.concatenate(faces[3]), np.concatenate(faces[4])
    halves = [squares[:, list(each)] for each in ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3))]
    keys = row_keys(np.sort(np.concatenate([triangles, *halves]), axis=1))
    there = np.isin(keys[len(triangles) :], keys[: len(triangles)]).reshape(4, -1)
    ahead, across = squares[there[0] & there[1]], squares[there[2] & there[3]]
    return np.concatenate([ahead, np.roll(across, -1, axis=1)])


def _rank(ranks: Indices, faces: Indices, place: str) -> None:
    """Give nodes ranks with which each face has its lowest on the diagonal from first to third.

    The next node is one that is off the diagonal of no face whose lowest node is not known yet.
    """
    off = Counter(faces[:, [1, 3]].ravel().tolist())
    ends: dict[int, list[int]] = {}
    for number, node in ((n, node) for n, face in enumerate(faces.tolist()) for node in face[::2]):
        ends.setdefault(node, []).append(number)
    ready = [node for node in ends if not off[node]]
    open_faces = set(range(len(faces)))
    lowest = -len(ranks)
    while ready:
        node = ready.pop()
        ranks[node], lowest = lowest, lowest + 1
        for number in open_faces.intersection(ends.get(node, ())):
            open_faces.discard(number)
            for other in faces[number, [1, 3]].tolist():
                off[other] -= 1
                if not off[other]:
                    ready.append(other)
    if open_faces:
        raise MeshError(
            f"{place} has quadrilateral faces on triangles of neighbours in {len(open_faces)} "
            "places, which cannot be divided alike; expected hexahedra or tetrahedra only"
        )


def _join_middles(middles: Indices, blocks: Sequence[ElementBlock], faces: Indices) -> None:
    """Have nodes in the middle of faces be those of the diagonals of triangles that lie there."""
    found: dict[int, list[tuple[Indices, Indices]]] = {2: [], 4: []}
    for block in blocks:
        shape, order = _KINDS[block.gmsh_type]
        for place, around in enumerate(MIDDLES[shape] if order == 2 else (), CORNERS[shape]):
            if len(around) < 8:
                rows = block.nodes[:, list(around)], block.nodes[:, place]
                found[len(around)].append(rows)
    if not found[2]:
        return
    of_faces, of_edges = (
        _numbers_of(wanted, *map(np.concatenate, zip(*found[count], strict=True)))
        for count, wanted in ((4, faces), (2, faces[:, ::2]))
    )
    middles[of_faces] = of_edges


def _numbers_of(wanted: Indices, rows: Indices, numbers: Indices) -> Indices:
    """(f,) the number of each of the wanted sets of nodes (f, k), all of which are among rows."""
    keys = row_keys(np.sort(np.concatenate([wanted, rows]), axis=1))
    order = np.argsort(keys[len(wanted) :], kind="stable")
    places = np.searchsorted(keys[len(wanted) :], keys[: len(wanted)], sorter=order)
    return numbers[order[places]]


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


def _divided_where(block: ElementBlock, inside: Bools, ranks: Indices) -> Iterator[ElementBlock]:
    """Facets that lie on bodies that are divided, divided alike, and the others."""
    shape, _ = ELEMENTS.get(block.gmsh_type, ("", 0))
    own = inside[block.nodes].all(axis=1) & (shape == "quadrilateral")
    if own.any():
        yield _of_faces(replace(block, nodes=block.nodes[own]), ranks)
    if not own.all():
        yield replace(block, nodes=block.nodes[~own])


def _of_faces(block: ElementBlock, ranks: Indices) -> ElementBlock:
    """Triangles on the faces of solids that are quadrilaterals."""
    shape, order = ELEMENTS[block.gmsh_type]
    parts = [
        block.nodes[rows][:, _places(shape, corners, order)]
        for corners, rows in _triangles(ranks[block.nodes], (0, 1, 2, 3))
    ]
    return ElementBlock(NUMBERS["triangle", order], np.concatenate(parts))


def _divided(block: ElementBlock, points: Array, ranks: Indices, middles: Indices) -> ElementBlock:
    """Triangles or tetrahedra in place of cells, with nodes that are one in place of others."""
    shape, order = _KINDS[block.gmsh_type]
    if shape in SIMPLICES:
        return block
    parts = [
        block.nodes[rows][:, _places(shape, corners, order)]
        for corners, rows in (
            _halves(block.nodes, points)
            if shape == "quadrilateral"
            else _tetrahedra(ranks[block.nodes], shape)
        )
    ]
    return ElementBlock(NUMBERS[_simplex(shape), order], middles[np.concatenate(parts)])


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


def _tetrahedra(ranks: Indices, shape: str) -> Iterator[tuple[tuple[int, ...], Bools]]:
    """Corners of the tetrahedra in solid cells with nodes of ranks (m, k), and which have them."""
    apexes = ranks[:, : CORNERS[shape]].argmin(axis=1)
    for apex in range(CORNERS[shape]):
        for face in FACETS[shape]:
            if apex not in face:
                for corners, rows in _triangles(ranks, face):
                    yield (apex, *corners), rows & (apexes == apex)


def _triangles(ranks: Indices, face: tuple[int, ...]) -> Iterator[tuple[tuple[int, ...], Bools]]:
    """Corners of the triangles of a face of cells with ranks (m, k), and which have them."""
    if len(face) == 3:
        yield face, np.ones(len(ranks), dtype=bool)
        return
    lowest = ranks[:, list(face)].argmin(axis=1)
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
