# SPDX-License-Identifier: LGPL-3.0-or-later
"""Eight-node quadrilaterals with a ninth node in the middle: the same geometry."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.geometry.gmsh_elements import SERENDIPITY_QUADRILATERAL
from fretfe.geometry.gmsh_model import ElementBlock

Points = Array
# The shape functions of the eight nodes (4 corners, 4 mid-side nodes) at the centre.
AT_CENTRE = np.array([-0.25] * 4 + [0.5] * 4)
NINE_NODES = 10


def complete(
    points: Points, groups: dict[str, list[ElementBlock]]
) -> tuple[Points, dict[str, list[ElementBlock]]]:
    """Points (n + new, 3) and groups in which no element has eight nodes.

    The map of an eight-node element is that of the nine-node one whose centre is where the former
    has it, x = sum of corners/(-4) + sum of mid-side nodes/2: the serendipity functions are in the
    span of the nine. (Zienkiewicz, Taylor & Zhu, The Finite Element Method, 7th ed., chapter 6.)
    """
    added: list[Points] = [points]
    count = len(points)
    completed: dict[str, list[ElementBlock]] = {}
    for name, blocks in groups.items():
        completed[name] = []
        for block in blocks:
            if block.gmsh_type == SERENDIPITY_QUADRILATERAL:
                centres = np.einsum("k,mkd->md", AT_CENTRE, points[block.nodes])
                numbers = np.arange(count, count + len(centres))
                added.append(centres)
                count += len(centres)
                block = ElementBlock(NINE_NODES, np.column_stack([block.nodes, numbers]))
            completed[name].append(block)
    return np.vstack(added), completed


def stacked(blocks: Iterable[ElementBlock]) -> list[ElementBlock]:
    """One block for each type of element."""
    types: dict[int, list[Indices]] = {}
    for block in blocks:
        if len(block.nodes):
            types.setdefault(block.gmsh_type, []).append(block.nodes)
    return [ElementBlock(kind, np.concatenate(nodes)) for kind, nodes in types.items()]
