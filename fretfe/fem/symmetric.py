# SPDX-License-Identifier: LGPL-3.0-or-later
"""Large symmetric matrices of which half is kept."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Indices

# Rows that are worked on at a time.
BLOCK = 256


class SymmetricMatrix:
    """The lower half of a symmetric matrix, in blocks of rows up to their last one's diagonal.

    Args:
        triangle: (n, n) whose entries above the diagonal may be anything; it is copied.
        factor: that they are multiplied by.
    """

    def __init__(self, triangle: Array, factor: float = 1.0) -> None:
        self._size = len(triangle)
        entries = sum((rows.stop - rows.start) * rows.stop for rows in _ranges(self._size))
        self._values: NDArray[Any] = np.empty(entries)  # one array: its memory is given back whole
        for rows, block in self._parts():
            np.multiply(factor, triangle[rows, : rows.stop], out=block)
            _mirror_small(block[:, rows])

    def add_product(self, left: Array, right: Array) -> None:
        """Add a symmetric product of (n, k) and, transposed, (n, k)."""
        for rows, block in self._parts():
            block += left[rows] @ right[: rows.stop].T

    def trace(self) -> float:
        """Sum of the diagonal."""
        return float(sum(np.trace(block[:, rows]) for rows, block in self._parts()))

    def add_to(self, matrix: Array, places: Indices) -> None:
        """Add it to some rows and columns, in increasing order, of the lower half of another."""
        ordered = len(places) == len(matrix)
        for rows, block in self._parts():
            if ordered:  # several times faster
                matrix[rows, : rows.stop] += block
            else:
                matrix[np.ix_(places[rows], places[: rows.stop])] += block

    def shorten(self) -> None:
        """Keep single precision only."""
        self._values = self._values.astype(np.float32)

    def multiply(self, vectors: Array, wanted: slice) -> Array:
        """(w, J) some rows of it times vectors (n, J), with numbers as precise as its own."""
        vectors = vectors.astype(self._values.dtype)
        found = np.zeros((self._size, vectors.shape[1]))
        for rows, block in self._parts():
            own = slice(max(rows.start, wanted.start), min(rows.stop, wanted.stop))
            if own.start < own.stop:
                inside = slice(own.start - rows.start, own.stop - rows.start)
                found[own] += block[inside] @ vectors[: rows.stop]
            above = slice(wanted.start, min(rows.start, wanted.stop))
            if above.start < above.stop:
                found[above] += block[:, above].T @ vectors[rows]
        return found[wanted]

    def whole(self) -> Array:
        """(n, n) all of it."""
        matrix = np.zeros((self._size, self._size))
        self.add_to(matrix, np.arange(self._size))
        mirror_lower(matrix)
        return matrix

    def _parts(self) -> Iterator[tuple[slice, NDArray[Any]]]:
        """Blocks and their rows."""
        end = 0
        for rows in _ranges(self._size):
            begin, height = end, rows.stop - rows.start
            end += height * rows.stop
            yield rows, self._values[begin:end].reshape(height, rows.stop)


def mirror_lower(matrix: Array) -> None:
    """Write the lower half of a matrix (n, n) to the upper one, in place."""
    for rows in _ranges(len(matrix)):
        matrix[: rows.start, rows] = matrix[rows, : rows.start].T
        _mirror_small(matrix[rows, rows])


def _mirror_small(corner: Array) -> None:
    corner[:] = np.tril(corner) + np.tril(corner, -1).T


def _ranges(size: int) -> Iterator[slice]:
    """Blocks of rows."""
    return (slice(begin, min(begin + BLOCK, size)) for begin in range(0, size, BLOCK))
