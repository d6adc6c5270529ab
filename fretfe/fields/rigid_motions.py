# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacements of bodies that only move and turn."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array


def rigid_motions(points: Array, components: int | None = None) -> Array:
    """(n, c, k) translations and infinitesimal rotations at points (n, gdim).

    Displacements have as many components as points without another number. Plane bodies turn about
    z only, also those with u_z(x, y): what varies along z is no motion of the plane.
    """
    count, gdim = points.shape
    components = components or gdim
    pairs = [(i, j) for i in range(gdim) for j in range(i + 1, gdim)]
    motions = np.zeros((count, components, components + len(pairs)))
    motions[:, range(components), range(components)] = 1.0
    for number, (i, j) in enumerate(pairs, start=components):
        motions[:, i, number] = -points[:, j]
        motions[:, j, number] = points[:, i]
    return motions
