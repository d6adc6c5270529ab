# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of a half-space under tractions on a circle, by integrals over point loads.

Boussinesq's and Cerruti's solutions (Johnson, Contact Mechanics, 1985, sections 3.2 and 3.6). Under
Hertz's pressure and q in proportion to it they are those of Hamilton and Goodman (1966).
"""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array

RINGS, TURNS = 48, 72


def under_normal(x: Array, y: Array, z: Array, poisson: float) -> Array:
    """(..., 6) xx, yy, zz, xy, yz, xz by a unit force along +z at the origin; z is the depth."""
    r2, big = x**2 + y**2, np.sqrt(x**2 + y**2 + z**2)
    k, flat = 1 - 2 * poisson, 1 - z / big
    xx = k / r2 * (flat * (x**2 - y**2) / r2 + z * y**2 / big**3) - 3 * z * x**2 / big**5
    yy = k / r2 * (flat * (y**2 - x**2) / r2 + z * x**2 / big**3) - 3 * z * y**2 / big**5
    xy = k / r2 * (flat * 2 * x * y / r2 - x * y * z / big**3) - 3 * x * y * z / big**5
    rest = [-3 * part * z**2 / big**5 for part in (z, y, x)]
    return np.stack([xx, yy, rest[0], xy, rest[1], rest[2]], axis=-1) / (2 * np.pi)


def under_shear(x: Array, y: Array, z: Array, poisson: float) -> Array:
    """The same by a unit force along +x."""
    big = np.sqrt(x**2 + y**2 + z**2)
    k, deep = 1 - 2 * poisson, big + z
    square, cube = 1 / (big**3 * deep**2), 2 / (big**2 * deep**3)
    xx = -3 * x**3 / big**5 + k * (
        x / big**3 - 3 * x / (big * deep**2) + x**3 * (square + cube)
    )  # fmt: skip
    yy = -3 * x * y**2 / big**5 + k * (
        x / big**3 - x / (big * deep**2) + x * y**2 * (square + cube)
    )  # fmt: skip
    xy = -3 * x**2 * y / big**5 + k * (-y / (big * deep**2) + x**2 * y * (square + cube))
    rest = [-3 * x * part / big**5 for part in (z**2, y * z, x * z)]
    return np.stack([xx, yy, rest[0], xy, rest[1], rest[2]], axis=-1) / (2 * np.pi)


def hertzian(points: Array, radius: float, pressure: float, shear: float, poisson: float) -> Array:
    """(M, 6) stress at points (M, 3) with depths z > 0 by p0 √(1 - r²/a²) and q0 √(1 - r²/a²).

    Args:
        points: x, y along the surface.
        radius: a.
        pressure: p0.
        shear: q0 along x on the half-space.
        poisson: its ratio.
    """
    # r = a sin t makes the root smooth: rings by Gauss, turns by the trapezoidal rule.
    nodes, weights = np.polynomial.legendre.leggauss(RINGS)
    t = np.pi / 4 * (nodes + 1)
    turn = 2 * np.pi * (np.arange(TURNS) + 0.5) / TURNS
    r, share = radius * np.sin(t), np.cos(t)
    area = np.pi / 4 * weights * radius**2 * np.sin(t) * np.cos(t) * 2 * np.pi / TURNS
    force = np.repeat(area * share, TURNS)
    at = np.stack([np.outer(r, np.cos(turn)).ravel(), np.outer(r, np.sin(turn)).ravel()], axis=1)
    found = np.zeros((len(points), 6))
    for row, (x, y, z) in enumerate(points):
        own = x - at[:, 0], y - at[:, 1], np.full(len(at), z), poisson
        found[row] = force @ (pressure * under_normal(*own) + shear * under_shear(*own))
    return found
