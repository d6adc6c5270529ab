# SPDX-License-Identifier: LGPL-3.0-or-later
"""Singular edge factors of half-planes at full stick in closed form, for any contact area."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.edges import normal_increment_factor, tangential_factor
from fretfe.edges.section import PLANE_FRONTS
from fretfe.results.solution import Factor


def half_plane_units(positions: Array) -> Array:
    """(T, 2, 2, 4) station, `Factor`, for a unit of P, M, Q and sigma0; NaN without contact.

    ``fretfe.analytic.edges.tangential_factor`` and ``normal_increment_factor``; M is about x = 0,
    so that a load P has the moment -P (left + right)/2 about the centre of the contact.

    Args:
        positions: (2, T) of the left and the right edge.
    """
    left, right = positions
    units = np.full((len(left), 2, 2, 4), np.nan)
    known = right > left
    a, centre = (right - left)[known] / 2, (right + left)[known] / 2
    zero, one = np.zeros_like(a), np.ones_like(a)
    for front in PLANE_FRONTS:
        shear = tangential_factor(1.0, 0.0, a, front.name)
        tension = tangential_factor(0.0, 1.0, a, front.name)
        normal = normal_increment_factor(one, -centre, a, front.name)
        moment = normal_increment_factor(0.0, one, a, front.name)
        at_front = units[:, front.number]
        at_front[known, Factor.K_I] = np.column_stack([normal, moment, zero, zero])
        at_front[known, Factor.K_T] = np.column_stack([zero, zero, shear, tension])
    return units
