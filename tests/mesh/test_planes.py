# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane meshes that lie elsewhere than in z = 0."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.mesh.gmsh import ElementBlock, RawMesh
from fretfe.mesh.split import mesh_from_raw

SQUARE = np.array([[1.0, 2, 0], [3, 2, 0], [3, 3, 0], [1, 3, 0]])
BODY = {"b": [ElementBlock(3, np.array([[0, 1, 2, 3]]))]}


@pytest.mark.parametrize(
    ("columns", "shift", "note"),
    [
        ((0, 1, 2), 5.0, "the mesh lies in the plane z = 5; it is moved to z = 0"),
        ((0, 2, 1), 0.0, "the mesh lies in the plane y = 0; x and z of the file are x and y here"),
        ((2, 0, 1), -2.0, "the mesh lies in the plane x = -2; y and z of the file are x and y"),
    ],
)
def test_meshes_in_other_planes(columns: tuple[int, ...], shift: float, note: str) -> None:
    moved = (SQUARE + np.array([0, 0, shift]))[:, columns]
    # a node that no element has says nothing of the plane
    points = np.vstack([moved, [[7.0, 7, 7]]])
    mesh = mesh_from_raw(RawMesh(points, 2, BODY, {}), "mesh")
    np.testing.assert_array_equal(mesh.bodies["b"].points, SQUARE[:, :2])
    assert mesh.notes[0].startswith(note)


def test_a_mesh_in_its_plane_stays_without_a_word() -> None:
    mesh = mesh_from_raw(RawMesh(SQUARE + np.array([0, 0, 1e-12]), 2, BODY, {}), "mesh")
    assert mesh.notes == ()
