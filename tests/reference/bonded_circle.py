# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two equal half-spaces bonded in a circle of radius 1: exact displacements, and edge factors.

Body 2 is y < 0. Under a pressure P, a shear force Q along x and a moment M about y, all on body 2,
the tractions in the circle are, with t = 1/sqrt(1 - r²) (Johnson 1985, chapters 2 and 3; Reissner
and Sagoci 1944)

    p = P t/(2 pi),   q_x = Q t/(2 pi),   q_theta = 3 M r t/(4 pi)

Displacements follow from Boussinesq's and Cerruti's potentials of t, which are imaginary parts of
functions of R = sqrt(r² + w²), w = z + i, z the depth: that of a charged disc is 2 pi ln(R + w).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array

Complex = NDArray[Any]

# Signs of the axes of a half-space, depth last, and the axes of the model that they lie along.
AXES = np.array([0, 2, 1])
# Depth at which displacements of the surface are computed; they differ by its square root.
BELOW = 1e-12
SIGNS = {True: np.array([1.0, -1.0, 1.0]), False: np.array([1.0, 1.0, -1.0])}


def displacements(points: Array, upper: bool, shear_modulus: float, poisson: float) -> Array:
    """(n, 3, 3) displacements of points (n, 3) of one body by a unit of P, Q and M."""
    signs = SIGNS[upper]
    x, y, z = points[:, AXES].T * signs[:, None]
    # Points of the surface may be outside by round-off; on the circle potentials have no slopes.
    z = np.maximum(np.abs(z), BELOW)
    # Body 1 has the opposite shear and moment; M turns about y, which points out of body 2.
    sign = -1.0 if upper else 1.0
    fields = np.stack(
        [
            normal(x, y, z, poisson),
            sign * tangential(x, y, z, poisson),
            -torsion(x, y, z),
        ],
        axis=2,
    )
    found = np.empty_like(fields)
    found[:, AXES] = fields * signs[:, None]
    return found / shear_modulus


def potentials(x: Array, y: Array, z: Array) -> tuple[Complex, Complex, Complex, Complex]:
    """w, R, ln(R + w) and 1/(R + w)."""
    w = z + 1j
    root = np.sqrt(x**2 + y**2 + w**2)
    root = np.where(root.imag < 0, -root, root)
    return w, root, np.log(root + w), 1 / (root + w)


def normal(x: Array, y: Array, z: Array, poisson: float) -> Array:
    """(n, 3) displacements under a unit pressure force, times the shear modulus."""
    _, root, logarithm, inverse = potentials(x, y, z)
    aside = (1 - 2 * poisson) * inverse - z * inverse / root
    down = 2 * (1 - poisson) * logarithm - z / root
    return np.stack([x * aside.imag, y * aside.imag, down.imag], axis=1) / (4 * np.pi)


def tangential(x: Array, y: Array, z: Array, poisson: float) -> Array:
    """(n, 3) displacements under a unit force along x, times the shear modulus."""
    w, root, logarithm, inverse = potentials(x, y, z)
    # psi = -x inverse and psi_1 = -x mean, but for the factor of the traction
    mean = (w * inverse + logarithm) / 2
    fall = -(inverse**2) / root
    mean_fall = (w * fall + inverse / root) / 2
    along = 2 * logarithm - 2 * poisson * (mean + x**2 * mean_fall) + z * (inverse + x**2 * fall)
    beside = x * y * (z * fall - 2 * poisson * mean_fall)
    down = -x * inverse * ((1 - 2 * poisson) + z / root)
    return np.stack([along.imag, beside.imag, down.imag], axis=1) / (4 * np.pi)


def torsion(x: Array, y: Array, z: Array) -> Array:
    """(n, 3) displacements under a unit moment about z, the circle at rest, times the modulus."""
    stretch = potentials(x, y, z)[1].real
    turn = 2 / np.pi * (np.arctan2(1, stretch) - stretch / (1 + stretch**2)) - 1
    return 3 / 16 * np.stack([-y * turn, x * turn, 0 * z], axis=1)


def factors(angles: Array) -> Array:
    """(n, 3, 3) K_I, K_T, K_S at angles from x by P, Q and M."""
    found = np.zeros((len(angles), 3, 3))
    unit = 1 / (2 * np.pi * np.sqrt(2))
    found[:, 0, 0] = unit
    found[:, 1, 1], found[:, 2, 1] = -unit * np.cos(angles), unit * np.sin(angles)
    found[:, 2, 2] = -1.5 * unit
    return found


def frames(angles: Array) -> tuple[Array, Array]:
    """(n, 3) points at angles from x, and (n, 3, 3) rows across, inward, along there."""
    points = np.stack([np.cos(angles), 0 * angles, -np.sin(angles)], axis=1)
    across = np.tile([0.0, 1.0, 0.0], (len(angles), 1))
    return points, np.stack([across, -points, np.cross(across, -points)], axis=1)
