# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress in a half-plane under elliptical tractions, at its surface and below.

The body is body 2 of ``fretfe.analytic.edges``: y = 0 is its surface, a depth h > 0 lies below.
With Flamant's solution the traction (q, -p) dt at t gives the radial stress -(2/pi) F·r/r^2
(Johnson 1985, section 2.3), so that everything follows from the Cauchy integrals

    I_g(z) = int g(t)/(z - t) dt,    z = x - i h,

of g = p and q:

    sigma_xx + sigma_yy = -(2/pi) [Re I_q + Im I_p]
    sigma_yy            =  (1/pi) [-Im I_p + y Re I_p' - y Im I_q']
    sigma_xy            =  (1/pi) [Im I_q + y Re I_q' + y Im I_p']

An ellipse g = g0 sqrt(1 - t^2/b^2) has I_g = (pi g0/b)(z - sqrt(z^2 - b^2)): McEwen's solution
(Johnson 1985, section 4.2) in one term. Partial slip is a sum of ellipses.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.analytic._numerics import check_positive, check_range


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

    Raises:
        ValueError: if a depth is negative or the half-width is not positive.
    """
    check_positive("half_width", half_width)
    height = check_range("depth", depth, low=0.0)
    place = np.asarray(x, dtype=np.float64) + 1j * height
    # The ellipse is real: below the axis it is conjugate to what it is above, cut included.
    root = np.sqrt(place - half_width) * np.sqrt(place + half_width)
    unit = np.pi / half_width * np.conj(place - root)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.pi / half_width * np.conj(1 - place / root)
    # y times the slope vanishes on the surface, at the ends of the ellipse too.
    slope = np.where(height == 0, 0.0, -height * slope)
    return _sum(pressure * unit, pressure * slope, shear * unit, shear * slope)


def _sum(normal: Any, normal_slope: Any, shear: Any, shear_slope: Any) -> Array:
    """(..., 3) stress from I_p, y I_p', I_q and y I_q'."""
    trace = -2 / np.pi * (shear.real + normal.imag)
    across = (-normal.imag + normal_slope.real - shear_slope.imag) / np.pi
    sheared = (shear.imag + shear_slope.real + normal_slope.imag) / np.pi
    return np.stack([trace - across, across, sheared], axis=-1)
