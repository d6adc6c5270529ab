# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear algebra of matrices that change little: inverses of leading blocks, and nearby systems."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.sparse.linalg import LinearOperator, gmres

from fretfe._typing import Array, Indices
from fretfe.contact import dense

# Room for rows that is made at a time, over those that are needed.
ROOM_AHEAD = 1.5
# Rows of M that are taken at a time: they stay in the processor's cache from one use to the next.
ROWS = 64
# Systems of fewer unknowns are factorised as fast as iterations start.
FEWEST = 500
# Corrections below this fraction of a solution are the last ones: what they leave is round-off, of
# 1e-13 with 1 000 unknowns.
ROUND_OFF = 1e-12
# Corrections that fall so fast need no iterations of GMRES.
FALLS = 0.03
# Work of reading an entry of a matrix, and of making one of a system, over that of a multiplication
# and addition in a product of matrices.
READING = 12
MAKING = 150
# Unknowns that border factors, over those of the factors, from which on it is factorised anew.
WIDEST = 1 / 16
# Iterations of GMRES at a time; products with a system after which its own factors are of no use.
ITERATIONS = 12
MOST = 72


class NestedInverse:
    """Inverses of the leading blocks of a matrix.

    Args:
        matrix: (N, N) in Fortran's order, symmetric, positive definite; it is overwritten.

    Raises:
        numpy.linalg.LinAlgError: if the matrix is not positive definite.
    """

    def __init__(self, matrix: Array) -> None:
        # The triangle that is left alone keeps A: one array holds M below and A above.
        self._rows = dense.invert_triangle(matrix).T

    @property
    def size(self) -> int:
        """Number of rows N of the whole matrix."""
        return len(self._rows)

    def solve(self, size: int, rhs: Array) -> Array:
        """(n, J) inverse of the leading block of n rows, times (n, J)."""
        inverse = self._rows[:size, :size].T
        projection = dense.multiply_triangle(inverse, rhs, transpose=True)
        return dense.multiply_triangle(inverse, projection)

    def beyond(self, size: int) -> Array:
        """(n, N - n) of A: the rows of the leading block, the columns beyond it; a view."""
        return self._rows[:size, size:]

    def projections(self, vectors: Array) -> Array:
        """(J, N) rows: M times (N, J) vectors."""
        return dense.multiply_triangle(self._rows.T, vectors, transpose=True).T

    def accumulate(
        self, sums: Array, projections: Array, components: Indices, begin: int, end: int
    ) -> None:
        """Add the terms m_i (m_i·v) with begin <= i < end to sums of them; subtract if end < begin.

        Args:
            sums: (J + k, N) changed in place.
            projections: (J, N) of the first vectors v, as rows.
            components: (k,) of the unit vectors that the others are.
            begin: of the terms.
            end: of the terms.
        """
        sign = 1.0 if begin < end else -1.0
        for first, last in _parts(min(begin, end), max(begin, end)):
            units = self._rows[first:last, components].T
            units[np.arange(first, last) < components[:, None]] = 0.0
            weights = sign * np.vstack([projections[:, first:last], units])
            rows = self._rows[first:last]
            sums[:, :first] += dense.multiply(rows[:, :first].T, weights.T).T
            sums[:, first:last] += weights @ np.tril(rows[:, first:last])


@dataclass(frozen=True)
class UnitRows:
    """Rows of the inverse of a leading block of n rows, until other ones are asked for.

    Attributes:
        rows: (r, N) that these are among.
        places: (k,) theirs.
        size: n.
    """

    rows: Array
    places: Indices
    size: int

    def block(self, columns: Indices, into: Array | None = None) -> Array:
        """(k, c) some columns of them; see `dense.gather`."""
        return dense.gather(self.rows, self.places, columns, into)

    def combined(self, weights: Array) -> Array:
        """(n, J) sum of the rows times weights (k, J)."""
        return dense.combine_rows(self.rows, self.places, weights, self.size)


class InverseRows:
    """Rows of the inverse of a leading block, kept while the block grows and shrinks.

    Each row follows the block when it is asked for.

    Args:
        inverse: of all blocks.
        vectors: (N, m) which are multiplied with the inverse as well.
    """

    def __init__(self, inverse: NestedInverse, vectors: Array) -> None:
        self._inverse = inverse
        self._place = np.full(inverse.size, -1)
        self._projections = inverse.projections(vectors)
        self._units = np.zeros(0, dtype=np.int64)
        self._rows = np.zeros_like(self._projections)  # and room for more
        self._sizes = np.zeros(len(self._rows), dtype=np.int64)

    def vectors(self, size: int) -> Array:
        """(m, n) inverse of a leading block times the vectors, as rows; a view."""
        count = len(self._projections)
        self._resize(np.arange(count), size)
        return self._rows[:count, :size]

    def units(self, size: int, components: Indices) -> UnitRows:
        """Rows of the inverse of a leading block."""
        if self.missing(components):
            self._append(components[self._place[components] < 0])
        places = self._place[components]
        self._resize(places, size)
        return UnitRows(self._rows, places, size)

    def missing(self, components: Indices) -> int:
        """Number of rows that are not there yet."""
        return int(np.count_nonzero(self._place[components] < 0))

    def memory(self) -> dict[str, NDArray[Any]]:
        """The rows, which are sums in the order in which the block grew; see `recall`."""
        return {
            "operator_rows": self._rows[: len(self._sizes)],
            "operator_units": self._units,
            "operator_sizes": self._sizes,
        }

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Go on with the rows of `memory`, of the same inverse: with the same round-off."""
        self._append(memory["operator_units"])
        self._rows, self._sizes = memory["operator_rows"], memory["operator_sizes"]

    def _resize(self, places: Indices, size: int) -> None:
        """Bring rows at some places to the size of a block."""
        # From nothing if that is less work.
        restart = places[np.abs(size - self._sizes[places]) > size]
        self._rows[restart], self._sizes[restart] = 0.0, 0
        places = places[self._sizes[places] != size]
        for old in sorted(set(self._sizes[places].tolist())):
            self._accumulate(places[self._sizes[places] == old], old, size)
        self._sizes[places] = size

    def _accumulate(self, places: Indices, old: int, size: int) -> None:
        count = len(self._projections)
        vectors, units = places[places < count], places[places >= count]
        rows, components = self._rows[[*vectors, *units]], self._units[units - count]
        # Terms before the first component are zero.
        first = old if old or len(vectors) else int(components.min(initial=size))
        self._inverse.accumulate(rows, self._projections[vectors], components, first, size)
        self._rows[[*vectors, *units]] = rows

    def _append(self, components: Indices) -> None:
        """Make room for the rows of some components."""
        count = len(self._sizes)
        self._place[components] = count + np.arange(len(components))
        self._units = np.concatenate([self._units, components])
        self._sizes = np.concatenate([self._sizes, np.zeros(len(components), dtype=np.int64)])
        if len(self._sizes) > len(self._rows):
            room = np.zeros((int(ROOM_AHEAD * len(self._sizes)), self._inverse.size))
            room[:count] = self._rows[:count]
            self._rows = room


def _parts(begin: int, end: int) -> list[tuple[int, int]]:
    """Ranges of rows from multiple to multiple of `ROWS`."""
    cuts = [begin, *range((begin // ROWS + 1) * ROWS, end, ROWS), end]
    return list(itertools.pairwise(cuts)) if begin < end else []


class LinearSystem(Protocol):
    """A linear system of k unknowns, as a matrix and without one."""

    @property
    def entries(self) -> float:
        """Number of entries of matrices that a product reads."""

    def matrix(self, precision: type[np.floating[Any]]) -> NDArray[Any]:
        """(k, k) in C's order, of numbers of some precision; it may be overwritten."""

    def block(self, rows: Indices, columns: Indices) -> Array:
        """(r, c) of it; rows and columns in increasing order."""

    def apply(self, vector: Array) -> Array:
        """(k,) the matrix times a vector (k,)."""


@dataclass(frozen=True)
class MatrixSystem:
    """A linear system whose matrix is there.

    Attributes:
        known: (k, k) the matrix.
    """

    known: Array

    @property
    def entries(self) -> float:
        """Those of the matrix."""
        return self.known.size

    def matrix(self, precision: type[np.floating[Any]]) -> NDArray[Any]:
        """(k, k) a copy."""
        return self.known.astype(precision)

    def block(self, rows: Indices, columns: Indices) -> Array:
        """(r, c) of it."""
        return self.known[np.ix_(rows, columns)]

    def apply(self, vector: Array) -> Array:
        """(k,) the matrix times a vector (k,)."""
        return dense.multiply(self.known, vector[:, None])[:, 0]


# Solves a system about as another one does: (k, J) for right-hand sides (k, J).
Approximate = Callable[[Array], Array]


class SimilarSystems:
    """Solver of one linear system after the other, with the factors of an earlier one if they do.

    The solutions are as accurate as those of factors of their own. Factors are of single precision,
    which takes half of the time and memory; iterations with the system itself make up for it, and
    where they do not, factors are of double precision. Unknowns that the factorised system has not,
    or has alone, border it.
    """

    def __init__(self) -> None:
        self._unknowns: Indices | None = None
        self._factors: tuple[NDArray[Any], NDArray[np.int32]]

    def solve(self, unknowns: Indices, system: LinearSystem, target: Array) -> Array:
        """(k, J) solution of a system.

        Args:
            unknowns: (k,) numbers that tell its unknowns from one another and from those of other
                systems.
            system: of k unknowns.
            target: (k, J) right-hand sides.

        Raises:
            numpy.linalg.LinAlgError: if the matrix is singular.
        """
        if len(target) < FEWEST:
            return np.linalg.solve(system.matrix(np.float64), target)
        bordered = self._bordered(unknowns, system)
        if bordered is not None:
            size = len(target)
            work = size**3 / 6 + MAKING * size**2
            products = int(work / (READING * (system.entries + size**2 / 2)))
            found = _iterate(system, target, bordered, products)
            if found is not None:
                return found
        self._unknowns = None
        for precision in (np.float32, np.float64):
            if self._factorise(system, precision):
                found = _iterate(system, target, self._approximate, MOST)
                if found is not None:
                    self._unknowns = unknowns
                    return found
        return self._approximate(target)

    def _factorise(self, system: LinearSystem, precision: type[np.floating[Any]]) -> bool:
        """Factorise a matrix with numbers of some precision; False if single precision fails."""
        single = precision is np.float32
        # Of the transposed matrix, in its place.
        factors, pivots, info = dense.factorise(system.matrix(precision).T)
        self._factors = factors, pivots
        if info and not single:
            raise np.linalg.LinAlgError(f"row {info} of the matrix depends on those before it")
        return not info

    def _approximate(self, target: Array) -> Array:
        """Solution with the matrix that was factorised."""
        target = target.astype(self._factors[0].dtype, copy=False)
        solved = linalg.lu_solve(self._factors, target, trans=1, check_finite=False)
        return np.asarray(solved, dtype=np.float64)

    def _bordered(self, unknowns: Indices, system: LinearSystem) -> Approximate | None:
        """Solver with the factors and a border; None if that were wide.

        What is factorised keeps the unknowns that the system has not, each with a further one that
        makes it zero.
        """
        if self._unknowns is None:
            return None
        before, size = self._unknowns, len(self._unknowns)
        _, kept, places = np.intersect1d(unknowns, before, assume_unique=True, return_indices=True)
        kept, places = np.sort(kept), places[np.argsort(kept)]
        added = np.setdiff1d(np.arange(len(unknowns)), kept, assume_unique=True)
        removed = np.setdiff1d(np.arange(size), places, assume_unique=True)
        count, width = len(added), len(added) + len(removed)
        if width > WIDEST * size:
            return None
        columns, rows = np.zeros((size, width)), np.zeros((width, size))
        columns[places, :count], rows[:count, places] = (
            system.block(kept, added),
            system.block(added, kept),
        )
        columns[removed, count + np.arange(len(removed))] = 1.0
        rows[count + np.arange(len(removed)), removed] = 1.0
        solved, corner = self._approximate(columns), np.zeros((width, width))
        corner[:count, :count] = system.block(added, added)
        try:
            inverse = np.linalg.inv(corner - rows @ solved)
        except np.linalg.LinAlgError:
            return None

        def approximate(target: Array) -> Array:
            padded, border = (
                np.zeros((size, *target.shape[1:])),
                np.zeros((width, *target.shape[1:])),
            )
            padded[places], border[:count] = target[kept], target[added]
            found = self._approximate(padded)
            border = inverse @ (border - rows @ found)
            solution = np.empty_like(target)
            solution[kept], solution[added] = (found - solved @ border)[places], border[:count]
            return solution

        return approximate


def _iterate(
    system: LinearSystem, target: Array, approximate: Approximate, most: int
) -> Array | None:
    """Solution by preconditioned iterations; None if one takes more products than `most`."""
    solution = np.empty_like(target)
    for case, column in enumerate(target.T):
        found = _column(system, column, approximate, most)
        if found is None:
            return None
        solution[:, case] = found
    return solution


def _column(
    system: LinearSystem, target: Array, approximate: Approximate, most: int
) -> Array | None:
    """(k,) solution of a system with one right-hand side; None as above."""
    count = 0

    def product(vector: Array) -> Array:
        nonlocal count
        count += 1
        return system.apply(vector)

    similar = LinearOperator(
        (len(target), len(target)),
        matvec=lambda vector: approximate(product(vector)),
        dtype=np.float64,
    )
    solution = approximate(target)
    first = before = float(np.linalg.norm(solution))
    while True:
        missing = approximate(target - product(solution))
        size = float(np.linalg.norm(missing))
        round_off = ROUND_OFF * float(np.linalg.norm(solution))
        if size <= round_off:
            return np.asarray(solution + missing)
        # As fast as so far.
        fallen = np.log(first / size) / count
        if count >= most or (count > 1 and not np.log(first / round_off) <= most * fallen):
            return None
        if not size <= FALLS * before:
            missing = gmres(
                similar,
                missing,
                rtol=0.0,
                atol=round_off / 10,
                restart=min(ITERATIONS, most - count),
                maxiter=1,
            )[0]
        solution, before = solution + missing, size
