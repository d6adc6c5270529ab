# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress below elliptical tractions in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array


def elliptical_stress(
    x: ArrayLike, depth: ArrayLike, half_width: float, pressure: float, shear: float
) -> Array:
    """Return the stress in body 2 under p = p0 sqrt(1 - x^2/b^2) and q = q0 sqrt(1 - x^2/b^2).

    Exact for a half-plane, in plane strain as in plane stress. Singular nowhere.

    Args:
        x: positions, any shape.
        depth: distances below the surface, >= 0; broadcasts with x.
        half_width: b of both ellipses.
        pressure: p0, of either sign.
        shear: q0 on body 2, positive in +x. On body 1, whose y axis points the other way, the
            stress is that of q0 with the other sign.

    Returns:
        (..., 3) sigma_xx, sigma_yy, sigma_xy, in the unit of p0 and q0.
    """
    height = np.asarray(depth, dtype=np.float64)
    place = np.asarray(x, dtype=np.float64) + 1j * height
    # The ellipse is real: below the axis it is conjugate to what it is above, cut included.
    root = np.sqrt(place - half_width) * np.sqrt(place + half_width)
    unit = np.pi / half_width * np.conj(place - root)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.pi / half_width * np.conj(1 - place / root)
    # y times the slope vanishes on the surface, at the ends of the ellipse too.
    slope = np.where(height == 0, 0.0, -height * slope)
    trace = -2 / np.pi * (shear * unit.real + pressure * unit.imag)
    across = (-pressure * unit.imag + pressure * slope.real - shear * slope.imag) / np.pi
    sheared = (shear * unit.imag + shear * slope.real + pressure * slope.imag) / np.pi
    return np.stack([trace - across, across, sheared], axis=-1)
