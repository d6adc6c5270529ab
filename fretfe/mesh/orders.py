# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of both orders, raised to the second one: all cells of a mesh are of one order.

Elements of order 1 get nodes in the middle of their edges, faces and cells. Where an element of
order 2 has the same edge or face they get its nodes, so that neighbours fit; others are straight.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.mesh.elements import CORNERS, ELEMENTS, MIDDLES, NUMBERS, PLURALS, PRISMATIC
from fretfe.mesh.gmsh import ElementBlock, RawMesh

_KINDS = {**ELEMENTS, **PRISMATIC}
_NUMBERS = {**NUMBERS, **{kind: number for number, kind in PRISMATIC.items()}}


def of_one_order(raw: RawMesh) -> RawMesh:
    """The mesh with all elements of order 2, if its bodies have some of either order.

    Those with elements of other kinds stay as they are. Notes say what was raised.
    """
    blocks = [block for own in raw.bodies.values() for block in own]
    orders = {_KINDS.get(block.gmsh_type, ("", 0))[1] for block in blocks}
    if orders != {1, 2}:
        return raw
    middles = _Middles(raw.points)
    groups = (raw.bodies, raw.boundaries)
    for block in (block for group in groups for own in group.values() for block in own):
        middles.take(block)
    bodies, boundaries = (
        {name: [middles.raised(block) for block in own] for name, own in group.items()}
        for group in groups
    )
    notes = (_note(name, own) for name, own in raw.bodies.items() if _low(own))
    return replace(raw, points=middles.all_points(), bodies=bodies, boundaries=boundaries,
                   notes=(*raw.notes, *notes))  # fmt: skip


def _low(blocks: Iterable[ElementBlock]) -> list[ElementBlock]:
    """Those of order 1."""
    return [block for block in blocks if _KINDS[block.gmsh_type][1] == 1]


def _note(name: str, blocks: Iterable[ElementBlock]) -> str:
    listed = " and ".join(
        f"{len(block.nodes)} {PLURALS[_KINDS[block.gmsh_type][0]]}" for block in _low(blocks)
    )
    return f"body '{name}' has {listed} of order 1 beside others of order 2, and they are raised"


class _Middles:
    """Nodes in the middle of edges, faces and cells by the corners around them."""

    def __init__(self, points: Array) -> None:
        self._points = [*points]
        self._known: dict[frozenset[int], int] = {}

    def all_points(self) -> Array:
        """(n + added, 3) coordinates."""
        return np.array(self._points)

    def take(self, block: ElementBlock) -> None:
        """Those that elements of order 2 have."""
        shape, order = _KINDS.get(block.gmsh_type, ("", 0))
        if order == 2:
            for place, around in enumerate(MIDDLES[shape], CORNERS[shape]):
                keys = map(frozenset, block.nodes[:, list(around)].tolist())
                self._known |= dict(zip(keys, block.nodes[:, place].tolist(), strict=True))

    def raised(self, block: ElementBlock) -> ElementBlock:
        """Elements of order 1 as such of order 2, and others as they are."""
        shape, order = _KINDS.get(block.gmsh_type, ("", 0))
        if order != 1:
            return block
        # edges come before faces, and these before the cell
        columns = [self._column(block.nodes[:, list(around)]) for around in MIDDLES[shape]]
        return ElementBlock(_NUMBERS[shape, 2], np.column_stack([block.nodes, *columns]))

    def _column(self, corners: Indices) -> Indices:
        """(m,) nodes in the middle of corners (m, 2, 4 or 8)."""
        return np.array([self._middle(own) for own in corners.tolist()])

    def _middle(self, corners: list[int]) -> int:
        key = frozenset(corners)
        if key not in self._known:
            self._known[key] = len(self._points)
            self._points.append(self._place(corners))
        return self._known[key]

    def _place(self, corners: list[int]) -> Array:
        """(3,) mean of two ends; by the functions of elements with nodes on their edges else."""
        ends = np.mean([self._points[corner] for corner in corners], axis=0)
        if len(corners) == 2:
            return np.asarray(ends)
        cyclic = zip(corners, [*corners[1:], corners[0]], strict=True)
        of_cell = ((corners[a], corners[b]) for a, b in MIDDLES["hexahedron"][:12])
        pairs = of_cell if len(corners) == 8 else cyclic
        edges = np.mean([self._points[self._known[frozenset(pair)]] for pair in pairs], axis=0)
        share = len(corners) // 4
        return np.asarray((1 + share) * edges - share * ends)
