# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gmsh's numbers of element types, and their shapes and orders."""

from __future__ import annotations

from types import MappingProxyType

# Shape and polynomial order of the elements that bodies and boundaries may have.
ELEMENTS = MappingProxyType(
    {
        1: ("line", 1),
        8: ("line", 2),
        2: ("triangle", 1),
        9: ("triangle", 2),
        3: ("quadrilateral", 1),
        10: ("quadrilateral", 2),
        4: ("tetrahedron", 1),
        11: ("tetrahedron", 2),
        5: ("hexahedron", 1),
        12: ("hexahedron", 2),
    }
)
NUMBERS = MappingProxyType({kind: number for number, kind in ELEMENTS.items()})
SHAPE_DIMENSIONS = MappingProxyType(
    {"line": 1, "triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}
)
# Nodes on their edges only: elements of order 2 without the nodes inside.
SERENDIPITY_QUADRILATERAL, SERENDIPITY_HEXAHEDRON = 16, 17
# Names of others that users meet, for messages.
UNSUPPORTED = MappingProxyType(
    dict.fromkeys((6, 13, 18), "prisms") | dict.fromkeys((7, 14, 19), "pyramids")
)
