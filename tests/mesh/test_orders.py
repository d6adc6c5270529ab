# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies with elements of both orders."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.mesh.elements import NUMBERS, jacobian_determinants, reference_nodes
from fretfe.mesh.gmsh import ElementBlock, RawMesh
from fretfe.mesh.orders import of_one_order


@pytest.mark.parametrize("cell", ["quadrilateral", "hexahedron"])
@pytest.mark.parametrize("bulge", [0.0, 0.1])
def test_an_element_beside_one_of_order_2(cell: str, bulge: float) -> None:
    """It has the nodes of the common side, which may be bent; nothing is lost of the volume."""
    curved = reference_nodes(cell, 2)
    dimension = curved.shape[1]
    curved[:, 0] += bulge * curved[:, 0] * 4 * curved[:, 1] * (1 - curved[:, 1])
    corners = reference_nodes(cell, 1) + np.eye(dimension)[0]
    points = np.zeros((len(curved) + len(corners), 3))
    points[:, :dimension] = np.vstack([curved, corners])
    own = np.arange(len(corners)) + len(curved)
    for number, corner in enumerate(corners):  # on the common side
        for same in np.flatnonzero((curved == corner).all(axis=1)):
            own[number] = same
    blocks = [ElementBlock(NUMBERS[cell, order], nodes[None])
              for order, nodes in ((2, np.arange(len(curved))), (1, own))]  # fmt: skip
    facet = {2: "line", 3: "quadrilateral"}[dimension]
    side = [node for node in own if node < len(curved)]
    ends = ElementBlock(NUMBERS[facet, 1], np.array([side[:2] if dimension == 2 else
                        [side[0], side[1], side[3], side[2]]]))  # fmt: skip
    raw = of_one_order(RawMesh(points, dimension, {"b": blocks}, {"side": [ends]}))
    assert [block.gmsh_type for block in raw.bodies["b"]] == [NUMBERS[cell, 2]] * 2
    first, second = (block.nodes[0] for block in raw.bodies["b"])
    common = {2: 3, 3: 9}[dimension]
    assert len({*first} & {*second}) == common
    assert {*raw.boundaries["side"][0].nodes[0]} == {*first} & {*second}
    assert len(raw.points) == len(points) + len(curved) - len(corners) - common + len(side)
    found = jacobian_determinants(raw.points[:, :dimension], second[None], cell, 2)
    assert found.min() > 0.5
    if not bulge:
        np.testing.assert_allclose(found, 1.0, rtol=1e-12)
    assert raw.notes == (
        f"body 'b' has 1 {cell[:-2] + 'a' if dimension == 3 else cell + 's'} of order 1 beside "
        "others of order 2, and they are raised",
    )


def test_meshes_of_one_order_stay_as_they_are() -> None:
    block = ElementBlock(NUMBERS["triangle", 1], np.array([[0, 1, 2]]))
    raw = RawMesh(np.eye(3), 2, {"b": [block]}, {})
    assert of_one_order(raw) is raw
