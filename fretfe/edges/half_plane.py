# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors of stuck half-planes in closed form, for any contact area."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.edges import normal_increment_factor, tangential_factor
from fretfe.edges.factors import SIDES


def half_plane_units(positions: Array) -> Array:
    """(T, 2, 2, 4) edge, factor (K_T, K_I), for a unit of P, Q, M and sigma0; NaN without contact.

    ``fretfe.analytic.edges.tangential_factor`` and ``normal_increment_factor``; M is about x = 0,
    so that a load P has the moment -P (left + right)/2 about the centre of the contact.

    Args:
        positions: (2, T) of the edges.
    """
    left, right = positions
    units = np.full((len(left), 2, 2, 4), np.nan)
    known = right > left
    a, centre = (right - left)[known] / 2, (right + left)[known] / 2
    zero, one = np.zeros_like(a), np.ones_like(a)
    for i, side in enumerate(SIDES):
        shear = tangential_factor(1.0, 0.0, a, side)
        tension = tangential_factor(0.0, 1.0, a, side)
        normal = normal_increment_factor(one, -centre, a, side)
        moment = normal_increment_factor(0.0, one, a, side)
        units[known, i, 0] = np.column_stack([zero, zero, shear, tension])
        units[known, i, 1] = np.column_stack([normal, moment, zero, zero])
    return units
