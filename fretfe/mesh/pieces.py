# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pieces of a body: which cells hang together, and whether they do so wherever they touch.

A body whose parts were not merged has two nodes in one place, and comes apart there when it is
loaded: a crack that nobody drew. SciPy is imported by the functions that need it, as in
`body_overlap`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.errors import MeshError
from fretfe.mesh.body_overlap import body_overlaps
from fretfe.mesh.elements import (
    CORNERS,
    FACET_SHAPES,
    directed_facets,
    facet_feet,
    row_keys,
    shortest_edges,
)
from fretfe.mesh.mesh import BodyMesh, Mesh, place_text

# Nodes nearer than this part of the shortest facets around them are meant to be one: within a
# piece, where a slot may be narrow, and between pieces, which are either joined or apart.
NEAR_IN_PIECE = 1e-3
NEAR_BETWEEN = 0.05
# Depth below a facet, in parts of its size, up to which a node is on it in spite of round-off.
ROUND_OFF = 1e-6
# Parts of its size by which the nearest place of a curved facet may be beside its flat one.
BESIDE = 0.1
ABOVE = 0.5


@dataclass(frozen=True)
class Joints:
    """Places where a body does not hang together.

    Attributes:
        pieces: number of pieces, joined by whole facets within themselves.
        doubled: (p, 2) nodes in the same place that are not joined.
        apart: (p,) distance of the two.
        hanging: (h,) nodes on facets that they are no nodes of.
        loose: (l,) corners that two pieces have in common, without a facet.
        halved: (m,) nodes between the common corners of two cells that only one of these has.
    """

    pieces: int
    doubled: Indices
    apart: Array
    hanging: Indices
    loose: Indices
    halved: Indices


def cell_pieces(cells: Indices, cell: str) -> Indices:
    """(m,) number of the piece that each cell is in: neighbours there share a whole facet."""
    facets = directed_facets(cells[:, : CORNERS[cell]], cell, 1)
    keys = row_keys(np.sort(facets, axis=1))
    order = np.argsort(keys, kind="stable")
    same = keys[order[1:]] == keys[order[:-1]]
    owner = order // (len(facets) // len(cells))
    return connected_groups(len(cells), owner[:-1][same], owner[1:][same])


def connected_groups(count: int, first: Indices, second: Indices) -> Indices:
    """(count,) number of the connected group that each of some things is in.

    Args:
        count: of the things.
        first: (p,) numbers of those that are connected,
        second: (p,) with these.
    """
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    graph = sparse.coo_matrix((np.ones(len(first)), (first, second)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])


def point_pieces(body: BodyMesh) -> Indices:
    """(n,) number of the piece that each node is in, of pieces without common nodes."""
    return _of_points(body, cell_pieces(body.cells, body.cell))


def _of_points(body: BodyMesh, pieces: Indices) -> Indices:
    """(n,) number of the piece of each node, that of a cell (m,) which has it."""
    labels = np.zeros(len(body.points), dtype=np.int64)
    labels[body.cells] = pieces[:, None]
    return labels


def find_joints(body: BodyMesh, outside: Indices) -> Joints:
    """Look for places where a body does not hang together.

    Args:
        body: with any cells.
        outside: (f, k) facets that only one cell has.
    """
    pieces = cell_pieces(body.cells, body.cell)
    corners = body.cells[:, : CORNERS[body.cell]]
    sizes = _sizes(body, outside)
    labels = _of_points(body, pieces)
    first, second, apart = _doubled(body, outside, labels, sizes)
    is_corner = np.zeros(len(body.points), dtype=bool)
    is_corner[corners] = True
    middles = np.unique(body.cells[:, corners.shape[1] :])
    # a corner where the neighbour has the middle of a facet stays loose however nodes are merged
    uneven = is_corner[first] != is_corner[second]
    hanging = [
        _on_facets(body, outside, labels, sizes),
        np.where(is_corner[first], first, second)[uneven],
        middles[is_corner[middles]],
    ]
    return Joints(
        pieces=int(pieces.max()) + 1,
        doubled=np.column_stack([first, second])[~uneven],
        apart=apart[~uneven],
        hanging=np.unique(np.concatenate(hanging)),
        loose=_loose(corners, pieces, len(body.points)),
        halved=_halved(body),
    )


def _sizes(body: BodyMesh, outside: Indices) -> Array:
    """(n,) shortest edge of the facets around each node of the outside, infinite inside."""
    shortest = shortest_edges(body.points, outside, FACET_SHAPES[body.cell])
    sizes = np.full(len(body.points), np.inf)
    for column in outside.T:
        np.minimum.at(sizes, column, shortest)
    return sizes


def _near(labels: Indices, first: Indices, second: Indices) -> Array:
    """(p,) part of their size within which two nodes are in the same place."""
    return np.where(labels[first] == labels[second], NEAR_IN_PIECE, NEAR_BETWEEN)


def _doubled(
    body: BodyMesh, outside: Indices, labels: Indices, sizes: Array
) -> tuple[Indices, Indices, Array]:
    """Pairs of nodes in the same place: both, and their distance (p,)."""
    from scipy.spatial import cKDTree

    free = np.unique(outside)
    distances, others = cKDTree(body.points[free]).query(body.points[free], k=2)
    # of nodes in the very same place any may come first
    own = others[:, 0] == np.arange(len(free))
    nearest = np.where(own, others[:, 1], others[:, 0])
    apart = np.where(own, distances[:, 1], distances[:, 0])
    first, second = free, free[nearest]
    close = apart <= _near(labels, first, second) * np.minimum(sizes[first], sizes[second])
    ends = np.sort(np.column_stack([first, second])[close], axis=1)
    ends, rows = np.unique(ends, axis=0, return_index=True)
    kept = ~_through_a_layer(body, outside, sizes, ends[:, 0], ends[:, 1])
    return ends[kept, 0], ends[kept, 1], apart[close][rows][kept]


def _through_a_layer(
    body: BodyMesh, outside: Indices, sizes: Array, first: Indices, second: Indices
) -> Bools:
    """(p,) whether two nodes are on the two sides of a thin layer of cells, not beside a gap."""
    if not len(first):
        return np.zeros(0, dtype=bool)
    outward = np.zeros_like(body.points)
    _, normals = facet_feet(body.points, outside, body.points[outside].mean(axis=1))
    for column in outside.T:
        np.add.at(outward, column, normals)
    height = np.sum((body.points[second] - body.points[first]) * outward[first], axis=1)
    inward = height < -ROUND_OFF * np.minimum(sizes[first], sizes[second])
    found = inward.copy()
    found[inward] = _neighbours(body.cells, first[inward], second[inward])
    return found


def _neighbours(cells: Indices, first: Indices, second: Indices) -> Bools:
    """(p,) whether there is a node that has cells in common with both of two nodes."""
    if not len(first):
        return np.zeros(0, dtype=bool)
    from scipy import sparse

    rows = np.repeat(np.arange(len(cells)), cells.shape[1])
    table = sparse.csr_matrix((np.ones(cells.size), (cells.ravel(), rows)))
    common = (table[first] @ table.T).multiply(table[second] @ table.T).sum(axis=1)
    return np.asarray(common).ravel() > 0


def _on_facets(body: BodyMesh, outside: Indices, labels: Indices, sizes: Array) -> Indices:
    """Nodes that lie on facets away from the nodes of these."""
    facet, node = _beside(body, outside)
    feet, normals = facet_feet(body.points, outside[facet], body.points[node])
    seen = body.points[node] - feet
    facets = outside[facet]
    size = np.minimum(sizes[facets].min(axis=1), sizes[node])
    near = _near(labels, facets[:, 0], node) * size
    close = np.flatnonzero(np.linalg.norm(seen, axis=1) <= near)
    # a node that is doubled by one of the facet is none of those that hang
    apart = np.linalg.norm(body.points[facets[close]] - body.points[node[close], None], axis=2)
    close = close[(apart > near[close, None]).all(axis=1)]
    below = np.sum(seen[close] * normals[close], axis=1) < -ROUND_OFF * size[close]
    kept = ~below
    if below.any():
        deep = close[below]
        joined = [_neighbours(body.cells, node[deep], column) for column in facets[deep].T]
        kept[below] = ~np.any(joined, axis=0)
    return np.unique(node[close[kept]])


def _beside(body: BodyMesh, outside: Indices) -> tuple[Indices, Indices]:
    """Facets and nodes of the outside that are near each other, as pairs of numbers."""
    from scipy.spatial import cKDTree

    free = np.unique(outside)
    corners = body.points[outside[:, : CORNERS[FACET_SHAPES[body.cell]]]]
    centres = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    found = cKDTree(body.points[free]).query_ball_point(centres, reach)
    counts = np.fromiter(map(len, found), dtype=np.int64, count=len(found))
    facet = np.repeat(np.arange(len(outside)), counts)
    node = free[np.fromiter(chain.from_iterable(found), dtype=np.int64, count=counts.sum())]
    other = (outside[facet] != node[:, None]).all(axis=1)
    facet, node = facet[other], node[other]
    over = _over(corners[facet], body.points[node])
    return facet[over], node[over]


def _over(corners: Array, points: Array) -> Bools:
    """(p,) whether points (p, d) are above or below flat facets with corners (p, c, d)."""
    along = np.roll(corners, -1, axis=1) - corners
    sizes = np.linalg.norm(along, axis=2).max(axis=1)
    seen = points[:, None] - corners
    if points.shape[1] == 2:
        t = np.sum(seen[:, 0] * along[:, 0], axis=1) / sizes**2
        return np.asarray((t > -BESIDE) & (t < 1 + BESIDE))
    normals = np.cross(along[:, 0], along[:, 1])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    heights = np.abs(np.sum(seen[:, 0] * normals, axis=1))
    across = np.cross(normals[:, None], along) / np.linalg.norm(along, axis=2)[..., None]
    inside = (np.sum(across * seen, axis=2) > -BESIDE * sizes[:, None]).all(axis=1)
    return np.asarray(inside & (heights < ABOVE * sizes))


def _loose(corners: Indices, pieces: Indices, count: int) -> Indices:
    """Corners that cells of different pieces have in common."""
    if not pieces.any():
        return np.zeros(0, dtype=np.int64)
    low, high = np.full(count, pieces.max() + 1), np.full(count, -1)
    for column in corners.T:
        np.minimum.at(low, column, pieces)
        np.maximum.at(high, column, pieces)
    return np.flatnonzero(low < high)


def _halved(body: BodyMesh) -> Indices:
    """Nodes between the corners of common facets that only one of the two cells has."""
    count = CORNERS[FACET_SHAPES[body.cell]]
    facets = directed_facets(body.cells, body.cell, body.order)
    if facets.shape[1] == count:
        return np.zeros(0, dtype=np.int64)
    keys = row_keys(np.sort(facets[:, :count], axis=1))
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order[1:]] == keys[order[:-1]])
    ahead, behind = (np.sort(facets[order[same + i], count:], axis=1) for i in (0, 1))
    return np.unique(behind[ahead != behind])


def require_joined(
    body: BodyMesh, outside: Indices, source: str, free: Bools, *, mergeable: bool
) -> int:
    """Check that a body hangs together wherever its cells touch, and count its pieces.

    Args:
        body: with any cells.
        outside: (f, k) facets that only one cell has.
        source: file, for messages.
        free: (n,) nodes that are at no tied boundary: at these elements need no common nodes.
        mergeable: whether nodes of it can be merged, for the remedy.

    Returns:
        The number of pieces, which are apart from each other.

    Raises:
        MeshError: says where, how often, and what to do.
    """
    joints = _away_from_ties(find_joints(body, outside), free)
    start = f"{source}: body '{body.name}'"
    pieces = f" of {joints.pieces} pieces" if joints.pieces > 1 else ""
    _refuse_overlap(body, joints.pieces, start)
    if len(joints.hanging):
        raise MeshError(
            f"{start}{pieces}: expected elements that share their nodes, found hanging nodes "
            f"{_where(body, joints.hanging)}: they lie on sides of other elements that do not "
            "have them as nodes, so that the body would come apart there. Mesh both sides "
            "together; merging nodes does not help, as the two sides do not match"
        )
    count = len(joints.doubled) + len(joints.halved)
    if count:
        what = "pairs of nodes" if len(joints.doubled) else "mid-side nodes"
        nodes = np.concatenate([joints.doubled[:, 0], joints.halved])
        raise MeshError(
            f"{start}{pieces}: expected one node in each place, found {what} in the same place "
            f"that are not joined {_where(body, nodes)}. The body would open there like a "
            f"crack. {_remedy(body, outside, joints, mergeable=mergeable)}"
        )
    if len(joints.loose):
        raise MeshError(
            f"{start}: expected elements that share whole sides, found {joints.pieces} pieces "
            f"that hang together at single nodes or edges only {_where(body, joints.loose)}. "
            "Join them by whole sides, or separate them"
        )
    return joints.pieces


def _away_from_ties(joints: Joints, free: Bools) -> Joints:
    """Places that no tie joins."""
    loose = free[joints.doubled].any(axis=1)
    return replace(
        joints,
        doubled=joints.doubled[loose],
        apart=joints.apart[loose],
        hanging=joints.hanging[free[joints.hanging]],
    )


def _where(body: BodyMesh, nodes: Indices) -> str:
    """Number and places of nodes, in words."""
    points = body.points[nodes]
    text = f"({len(nodes)}, the first at {place_text(points[0])}"
    if len(nodes) > 1:
        low, high = points.min(axis=0), points.max(axis=0)
        text += f", all from {place_text(low)} to {place_text(high)}"
    return text + ")"


def _remedy(body: BodyMesh, outside: Indices, joints: Joints, *, mergeable: bool) -> str:
    if not mergeable:
        return (
            "Make one part of the pieces in the geometry: a union in the CAD program, "
            "BooleanFragments or Coherence in a Gmsh script"
        )
    sizes = _sizes(body, outside)
    smallest = float(sizes.min())
    tolerance = max(2 * float(joints.apart.max(initial=0.0)), 1e-4 * smallest)
    return (
        "Join the parts in the mesh generator (in Gmsh Mesh > Remove duplicate nodes, within "
        f"this body only), or give geometry.merge = {tolerance:.2g}, which joins nodes of a body "
        "that are no farther apart, or bond two boundaries there by [ties.NAME] with their names "
        "in the mesh"
    )


def _refuse_overlap(body: BodyMesh, count: int, start: str) -> None:
    """Pieces in the same place would be counted twice."""
    if count == 1:
        return
    overlaps = body_overlaps(Mesh(dict(_pieces_of(body))))
    if overlaps:
        worst = max(overlaps, key=lambda each: each.depth)
        raise MeshError(
            f"{start}: expected pieces that are apart or joined, found some of its {count} pieces "
            f"in the same place: they overlap by {worst.depth:.3g} at {place_text(worst.point)}"
        )


def _pieces_of(body: BodyMesh) -> Sequence[tuple[str, BodyMesh]]:
    """The pieces of a body as bodies without boundaries, with what they are called."""
    labels = cell_pieces(body.cells, body.cell)
    found = []
    for number in range(int(labels.max()) + 1):
        nodes, cells = np.unique(body.cells[labels == number], return_inverse=True)
        name = f"{body.name}, piece {number + 1}"
        shape = (-1, body.cells.shape[1])
        piece = BodyMesh(name, body.points[nodes], cells.reshape(shape), body.cell, body.order, {})
        found.append((name, piece))
    return found
