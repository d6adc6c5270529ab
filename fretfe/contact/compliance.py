# SPDX-License-Identifier: LGPL-3.0-or-later
"""The compliance A of the bodies at the contact nodes, as the few operations that solvers need."""

from __future__ import annotations

from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.linalg import blas

from fretfe._typing import Array, Indices


class Compliance(Protocol):
    """Relative displacements by tractions: (N*d, N*d), symmetric, positive semi-definite."""

    @property
    def diagonal(self) -> Array:
        """(N*d,) displacement of each component by its own unit traction."""

    @property
    def level(self) -> float:
        """Mean of the diagonal: the scale of the compliance."""

    def apply(self, traction: Array) -> Array:
        """(N*d,) displacements by tractions (N*d,)."""

    def block(self, rows: Indices, columns: Indices) -> Array:
        """(rows, columns) displacements of some components by unit tractions at others; a copy."""


class DenseCompliance:
    """A compliance that is known as a matrix.

    Args:
        matrix: (N*d, N*d), symmetric.
    """

    def __init__(self, matrix: Array) -> None:
        self._matrix = matrix

    @cached_property
    def diagonal(self) -> Array:
        """(N*d,) displacement of each component by its own unit traction."""
        return np.diagonal(self._matrix)

    @cached_property
    def level(self) -> float:
        """Mean of the diagonal: the scale of the compliance."""
        return float(np.trace(self._matrix) / len(self._matrix))

    def apply(self, traction: Array) -> Array:
        """(N*d,) displacements by tractions (N*d,)."""
        # Symmetric: half of the matrix is read, which takes half of the time.
        product: Array = blas.dsymv(1.0, self._matrix.T, traction)
        return product

    def block(self, rows: Indices, columns: Indices) -> Array:
        """(rows, columns) displacements of some components by unit tractions at others; a copy."""
        return self._matrix[np.ix_(rows, columns)]
