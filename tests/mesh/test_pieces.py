# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies that do not hang together where they touch are refused, or their nodes are merged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.pieces_of_cells import KINDS, Cells

from fretfe.errors import MeshError
from fretfe.mesh.gmsh import ElementBlock, RawMesh
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.pieces import point_pieces
from fretfe.mesh.split import mesh_from_raw

pytestmark = pytest.mark.parametrize(("cell", "order"), KINDS, ids=lambda each: str(each))
LOW, MIDDLE, HIGH = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 1.0, 1.0)


def halves(cell: str, order: int, shift: float = 0.0, finer: int = 1) -> Cells:
    """Two bricks side by side with nodes of their own, the second moved away by some distance."""
    n = 2 * finer
    low, high = (1.0 + shift, 0.0, 0.0), (2.0 + shift, 1.0, 1.0)
    return Cells(cell, order).brick(LOW, (1.0, 1.0, 1.0), 2, 2, 2).brick(low, high, n, n, n)


def mesh(raw: RawMesh, merge: float | None = None) -> Mesh:
    return mesh_from_raw(raw, "pad.msh", merge, mergeable=True)


def refused(raw: RawMesh, merge: float | None = None) -> str:
    with pytest.raises(MeshError) as caught:
        mesh(raw, merge)
    return str(caught.value)


def pairs(cell: str, order: int) -> int:
    """Nodes on the square, or the side, between the two bricks."""
    along = 3 if order == 1 else 5
    return along if cell in ("triangle", "quadrilateral") else along**2


def slit(cell: str, order: int, opening: float = 0.0) -> Cells:
    """A brick that is cut half through: two bricks whose common nodes are joined up to y = 0."""
    cells = halves(cell, order)
    depth = (0.0, 0.5, 1.0) if cells.dimension == 3 else (0.0,)
    for z in depth:
        for y in (0.0, 0.5):
            cells.joined((1.0, y, z)[: cells.dimension])
    far = (cells.points[:, 0] == 1) & (cells.points[:, 1] > 0.5)
    second = np.arange(len(cells.points)) >= len(cells.points) // 2
    cells.points[far & second, 0] += opening
    return cells


def test_whole_bodies(cell: str, order: int) -> None:
    """Bodies in one piece, also with a slot, and those whose pieces are apart, are valid."""
    whole = Cells(cell, order).brick(LOW, HIGH, 4, 3, 2)
    assert mesh(whole.raw()).notes == ()
    assert mesh(slit(cell, order, 0.01).raw()).notes == ()
    apart = mesh(halves(cell, order, 0.1).raw())
    assert apart.notes == ("body 'pad' consists of 2 pieces that do not touch each other",)
    assert np.bincount(point_pieces(apart.bodies["pad"])).tolist()[0] > 0
    thin = Cells(cell, order).brick(LOW, (1.0, 1e-5, 1.0), 2, 1, 2)
    assert mesh(thin.raw()).notes == ()


@pytest.mark.parametrize("shift", [0.0, 1e-7, 1e-3, -1e-6])
def test_halves(cell: str, order: int, shift: float) -> None:
    raw = halves(cell, order, shift).raw()
    count = pairs(cell, order)
    message = refused(raw)
    assert "body 'pad' of 2 pieces: expected one node in each place, found" in message
    assert f"({count}, the first at (1, 0" in message
    tolerance = float(message.partition("geometry.merge = ")[2].split(",")[0])
    joined = mesh(raw, tolerance)
    whole = mesh(Cells(cell, order).brick(LOW, HIGH, 4, 2, 2).raw()).bodies["pad"]
    assert len(joined.bodies["pad"].points) == len(whole.points)
    assert joined.notes == (
        f"merge = {tolerance:g}: nodes joined with others in the same place: {count} of 'pad'",
    )


def test_half_a_crack(cell: str, order: int) -> None:
    """Within one piece."""
    message = refused(slit(cell, order).raw())
    assert "body 'pad': expected one node in each place" in message
    assert "(1, 1" in message
    assert mesh(slit(cell, order).raw(), 1e-6).notes


def test_hanging_nodes(cell: str, order: int) -> None:
    """Halves that do not match, joined at their ends or not at all."""
    cells = halves(cell, order, finer=2)
    message = refused(cells.raw())
    assert "body 'pad' of 2 pieces: expected elements that share their nodes" in message
    assert "hanging nodes" in message
    assert "hanging nodes" in refused(cells.raw(), 1e-6)


def test_joined_at_a_corner(cell: str, order: int) -> None:
    cells = Cells(cell, order).brick(LOW, (1.0, 1.0, 1.0), 2, 2, 2)
    cells.brick((1.0, 1.0, 1.0), (2.0, 2.0, 2.0), 2, 2, 2).joined(
        (1.0, 1.0, 1.0)[: cells.dimension]
    )
    assert "2 pieces that hang together at single nodes or edges only (1" in refused(cells.raw())


def test_pieces_in_the_same_place(cell: str, order: int) -> None:
    message = refused(halves(cell, order, -0.4).raw())
    assert "found some of its 2 pieces in the same place: they overlap by" in message


def test_merging_never_collapses_elements(cell: str, order: int) -> None:
    message = refused(halves(cell, order, 0.1).raw(), 0.6)
    assert "geometry.merge: expected a distance smaller than all elements" in message


def test_bodies_in_contact_stay_apart(cell: str, order: int) -> None:
    """Nodes of different bodies in the same place are a contact, with merging too."""
    raw = halves(cell, order).raw()
    (block,) = raw.bodies["pad"]
    half = len(block.nodes) // 2
    if cell in ("triangle", "tetrahedron"):
        first = raw.points[block.nodes].mean(axis=1)[:, 0] < 1
    else:
        first = np.arange(len(block.nodes)) < half
    parts = {"pad": block.nodes[first], "block": block.nodes[~first]}
    named = {name: [ElementBlock(block.gmsh_type, nodes)] for name, nodes in parts.items()}
    two = replace(raw, bodies=named)
    assert mesh(two).notes == ()
    merged = mesh(two, 1e-3)
    assert merged.notes[0].endswith("0 of 'pad', 0 of 'block'")
    assert sum(len(body.points) for body in merged.bodies.values()) == len(raw.points)
