# SPDX-License-Identifier: LGPL-3.0-or-later
"""The interface problem with an elastic layer between the bodies."""

from __future__ import annotations

import numpy as np
from scipy import linalg

from fretfe._typing import Array
from fretfe.contact.interface import Interface, coordinate_scale
from fretfe.contact.nested import NestedInverse


class RegularisedFactor:
    """The interface problem with an elastic layer between the bodies, factorised.

    Args:
        interface: the interface problem; its prescribed coordinates are left out.
        penalty: compliance of the layer.
    """

    def __init__(self, interface: Interface, penalty: float) -> None:
        released = np.flatnonzero(~interface.prescribed)
        everything = np.arange(interface.size * interface.components)
        matrix = interface.compliance.block(everything, everything).T  # Fortran's order
        matrix[everything, everything] += penalty
        self._inverse = NestedInverse(matrix)
        scale = coordinate_scale(interface)[released] * interface.compliance.level
        self._scale = scale
        self._motion = interface.motion[:, released] * scale
        self._response = self._inverse.solve(len(everything), self._motion)
        stiffness = interface.stiffness[np.ix_(released, released)] * np.outer(scale, scale)
        self._flexibility = linalg.pinvh(stiffness + self._motion.T @ self._response)

    def tractions(self, displacement: Array, forces: Array) -> Array:
        """(N*d,) tractions that give a displacement; see `Regularised`."""
        held = self._inverse.solve(len(displacement), displacement)
        moved = self._flexibility @ (self._motion.T @ held - forces * self._scale)
        return np.asarray(held - self._response @ moved)
