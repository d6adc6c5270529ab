# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes with constant tractions on even elements, a layer between them if there is one.

Independent of fretfe: displacements in the middle of the elements (Johnson, Contact Mechanics,
1985, section 2.3), contact and slip by changing sets until nothing changes any more.
"""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Bools


def compliance(x: Array, modulus: float, layer: float | Array = 0.0) -> Array:
    """(n, n) displacement at places (n,) by tractions on elements around them.

    Of both half-planes together, but for a rigid motion.

    Args:
        x: evenly spaced.
        modulus: E*.
        layer: displacement per traction, of all elements or (n,).
    """
    size = x[1] - x[0]
    ends = x[:, None] - x + size / 2, x[:, None] - x - size / 2
    first, second = (end * (np.log(np.abs(end)) - 1) for end in ends)
    found: Array = -2 / (np.pi * modulus) * (first - second)
    found += np.diag(np.broadcast_to(layer, len(x)))
    return found


def pressed(x: Array, gap: Array, matrix: Array, force: float) -> Array:
    """(n,) pressure under a normal force on surfaces with a gap (n,) before."""
    size = x[1] - x[0]
    closed = np.ones(len(x), dtype=bool)
    while True:
        count = int(closed.sum())
        system = np.ones((count + 1, count + 1))
        system[:-1, :-1], system[:-1, -1], system[-1, -1] = matrix[np.ix_(closed, closed)], -1, 0
        *found, approach = np.linalg.solve(system, np.append(-gap[closed], force / size))
        pressure = np.zeros(len(x))
        pressure[closed] = found
        after = (pressure > 0) | (~closed & (matrix @ pressure + gap < approach))
        if np.array_equal(after, closed):
            return pressure
        closed = after


def partial_slip(x: Array, matrix: Array, bound: Array, force: float) -> tuple[Array, Bools]:
    """Shear (n,) and slipping elements under a first shear force.

    Elements that stick move by one displacement; those that would carry more than the bound (n,)
    slip.
    """
    size = x[1] - x[0]
    slips = np.zeros(len(x), dtype=bool)
    while True:
        stuck = ~slips
        count = int(stuck.sum())
        system = np.ones((count + 1, count + 1))
        system[:-1, :-1], system[-1, -1] = matrix[np.ix_(stuck, stuck)], 0.0
        known = matrix[np.ix_(stuck, slips)] @ bound[slips]
        right = np.append(-known, force / size - bound[slips].sum())
        shear = bound.copy()
        shear[stuck] = np.linalg.solve(system, right)[:-1]
        if not (shear > bound)[stuck].any():
            return shear, slips
        slips = slips | (stuck & (shear > bound))
