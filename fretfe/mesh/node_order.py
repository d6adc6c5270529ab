# SPDX-License-Identifier: LGPL-3.0-or-later
"""Node orders of solid cells in VTK, XDMF and Abaqus files, which are the same, against Gmsh's.

Corners are numbered alike, and so are all nodes of plane cells.
"""

from __future__ import annotations

import functools
from types import MappingProxyType

import numpy as np

from fretfe._typing import Indices
from fretfe.geometry.gmsh_elements import NUMBERS, SERENDIPITY_HEXAHEDRON
from fretfe.mesh.cell_geometry import CORNERS, MIDDLES

# The corners around each node that follows the corners (VTK file formats; Abaqus has no 27th).
VTK_MIDDLES = MappingProxyType(
    {
        "tetrahedron": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
        "hexahedron": (
            *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)),
            *((0, 4), (1, 5), (2, 6), (3, 7)),
            *((0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)),
            tuple(range(8)),
        ),
    }
)
# Shapes of the Gmsh types whose orders differ.
DIFFERENT = MappingProxyType(
    {
        NUMBERS["tetrahedron", 2]: "tetrahedron",
        NUMBERS["hexahedron", 2]: "hexahedron",
        SERENDIPITY_HEXAHEDRON: "hexahedron",
    }
)


def in_gmsh_order(gmsh_type: int, nodes: Indices) -> Indices:
    """Cells (m, k) of a Gmsh type whose nodes are in VTK's order, in Gmsh's."""
    if gmsh_type not in DIFFERENT:
        return nodes
    return nodes[:, _places(DIFFERENT[gmsh_type], nodes.shape[1])]


@functools.cache
def _places(shape: str, count: int) -> Indices:
    """(k,) places in VTK's order of the nodes in Gmsh's."""
    corners = CORNERS[shape]
    found = {frozenset(around): i for i, around in enumerate(VTK_MIDDLES[shape], corners)}
    middles = MIDDLES[shape][: count - corners]
    return np.array([*range(corners), *(found[frozenset(around)] for around in middles)])
