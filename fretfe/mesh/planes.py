# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane models that do not lie in the plane z = 0, moved or turned there."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Indices

# Out-of-plane coordinates below this fraction of the size of the mesh are round-off.
PLANE_TOLERANCE = 1e-9
# The coordinates that become x and y where another one is constant, which becomes z.
_TURNED = {2: (0, 1, 2), 1: (0, 2, 1), 0: (1, 2, 0)}


def upright(points: Array, nodes: Indices) -> tuple[Array, str]:
    """Points in the plane z = 0, if they lie in a plane of constant z, y or x.

    Args:
        points: (n, 3).
        nodes: (k,) those of plane bodies.

    Returns:
        (n, 3) points, the same where they lie in no such plane or in z = 0, and what was done, in
        words.
    """
    own = points[nodes]
    extent = np.ptp(own, axis=0)
    (flat,) = np.nonzero(extent <= PLANE_TOLERANCE * extent.max())
    if len(flat) != 1:
        return points, ""
    axis = int(flat[0])
    height = float(own[:, axis].mean())
    if axis == 2 and np.abs(own[:, 2]).max() <= PLANE_TOLERANCE * extent.max():
        return points, ""
    moved = points[:, list(_TURNED[axis])]
    moved[:, 2] = 0.0
    first, second, across = ("xyz"[place] for place in _TURNED[axis])
    if axis == 2:
        return moved, f"the mesh lies in the plane z = {height:g}; it is moved to z = 0"
    return moved, (
        f"the mesh lies in the plane {across} = {height:g}; {first} and {second} of the file are "
        "x and y here"
    )
