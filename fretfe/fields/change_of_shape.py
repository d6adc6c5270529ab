# SPDX-License-Identifier: LGPL-3.0-or-later
"""By how much displacements change the shape of a boundary: a wrong unit of theirs shows there."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import orth

from fretfe._typing import Array
from fretfe.fields.rigid_motions import rigid_motions

# Changes over the size of a boundary, beyond which a unit is doubted: 1e-5 is 2 MPa in steel, and
# .05 is beyond the strain that linear elasticity describes.
LEAST = 1e-5
MOST = 0.05
# By how much one unit may be mistaken for another: m, mm and µm.
MISTAKES = (1e3, 1e-3, 1e6, 1e-6)
# Changes below this part of the displacements, or so many roundings of them, are none.
ROUND_OFF = 1e-9
ROUNDINGS = 10


def change_of_shape(places: Array, moved: Array, rounding: float = 0.0) -> float:
    """Largest change of the shape of a boundary over its size, both as roots of mean squares.

    It is what the rigid motion that is nearest to the displacements leaves of them. A line that is
    stretched has its strain, a circle e in both directions e, in one of them e/√2, sheared by an
    angle half of that.

    Args:
        places: (m, d) nodes of the boundary.
        moved: (T, m, d) small displacements.
        rounding: of these, relative.

    Returns:
        The change, >= 0; 0 for rigid motions up to their rounding, NaN for a single place.
    """
    arms = places - places.mean(axis=0)
    size = float(np.linalg.norm(arms))
    if size == 0:
        return math.nan
    rigid = orth(rigid_motions(arms).reshape(arms.size, -1))
    largest = 0.0
    for step in moved.reshape(len(moved), -1):
        left = float(np.linalg.norm(step - rigid @ (rigid.T @ step)))
        if left > max(ROUND_OFF, ROUNDINGS * rounding) * np.linalg.norm(step):
            largest = max(largest, left)
    return largest / size


def doubt_of_unit(places: Array, moved: Array, scale: float, rounding: float = 0.0) -> str:
    """Reason to doubt the unit of displacements of a cut, in words; empty without one.

    Args:
        places: as of `change_of_shape`, and so are the displacements and their rounding.
        moved: in the unit of the case.
        scale: factor that brought them there.
        rounding: of them, relative.
    """
    change = change_of_shape(places, moved, rounding)
    if not change > 0 or LEAST <= change <= MOST:
        return ""
    text = (
        f"the displacements change the shape of the cut by {change:.2g} of its size at most, where "
        f"{LEAST:g} to {MOST:g} is usual: is their unit that of the case, after displacement_factor"
        " (or factor)?"
    )
    usual = (each for each in MISTAKES if LEAST <= each * change <= MOST)
    if mistake := next(usual, None):
        text += f" displacement_factor = {mistake * scale:g} would make it {mistake * change:.2g}"
    return text
