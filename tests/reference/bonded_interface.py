# SPDX-License-Identifier: LGPL-3.0-or-later
"""Crack-tip field of a bonded interface of unlike bodies, in the plane."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array

# Of both bodies.
POISSON = 0.3
KOLOSOV = 3 - 4 * POISSON


def displacement(z: npt.NDArray[np.complex128], epsilon: float, side: int, mu: float) -> Array:
    """(n, 2, 2) of K_I = 1 and of K_T = 1 at the length 1, by complex potentials.

    p + i q = (K_I + i K_T) s^(-1/2 + i epsilon) at z = s.
    """
    # Either body has its cut through the other one.
    z = np.where(z == 0, 1e-12 + 0j, z)
    angle = side * (np.pi / 2 + np.arctan2(-z.real, side * z.imag))
    power = 0.5 + 1j * epsilon
    found = []
    for c in (-0.5 / np.cosh(np.pi * epsilon), -0.5j / np.cosh(np.pi * epsilon)):
        a, b = c * np.exp(side * np.pi * epsilon), c * np.exp(-side * np.pi * epsilon)
        logarithm = np.log(np.abs(z)) + 1j * angle
        phi = a * np.exp(power * logarithm) / power
        omega = b * np.exp(power * np.conj(logarithm)) / power
        slope = a * np.exp((power - 1) * logarithm)
        u = (KOLOSOV * phi - omega - (z - np.conj(z)) * np.conj(slope)) / (2 * mu)
        found.append(np.column_stack([u.real, u.imag]))
    # p + i q = -(s_yy - i s_xy): c is real and negative for pressure, -i K_T/2 for shear.
    return np.stack(found, axis=-1)
