# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mesh of a model: one per body, plane or solid."""

from __future__ import annotations

from dataclasses import dataclass

from fretfe._typing import Array, Indices


@dataclass(frozen=True)
class BodyMesh:
    """The mesh of one body, with its own node numbers.

    Attributes:
        name: Physical surface group, or volume group of a solid.
        points: (n, 2) coordinates; (n, 3) of a solid.
        cells: (m, k) node indices in Gmsh node order, with a positive Jacobian determinant: plane
            cells run counter-clockwise.
        cell: "triangle" or "quadrilateral"; "tetrahedron" or "hexahedron" of a solid.
        order: 1, or 2 (elements with 6, 9, 10 or 27 nodes; edges may be curved).
        boundaries: Facets (f, k) by physical group of curves: end, end[, middle]. The body is on
            the left of a facet that is walked from its first to its second end. Of a solid by
            physical group of surfaces, triangles (3 or 6 nodes) or quadrilaterals (4 or 9) that run
            counter-clockwise seen from outside.
        pieces: Number of its pieces, which do not touch each other.
    """

    name: str
    points: Array
    cells: Indices
    cell: str
    order: int
    boundaries: dict[str, Indices]
    pieces: int = 1


@dataclass(frozen=True)
class Mesh:
    """Bodies by name; no two of them share a node.

    Attributes:
        bodies: by name.
        notes: what a reader of the results should know of how it was read, in words.
    """

    bodies: dict[str, BodyMesh]
    notes: tuple[str, ...] = ()

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return next(iter(self.bodies.values())).points.shape[1]


def place_text(point: Array) -> str:
    """A place in words."""
    return f"({', '.join(f'{value:.6g}' for value in point)})"
