# SPDX-License-Identifier: LGPL-3.0-or-later
"""Factors and products of large matrices against LAPACK and NumPy, on one thread and on several."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy import linalg

from fretfe._typing import Array
from fretfe.contact import dense

# Around the widths of blocks, and parts of unequal size.
SIZES = (0, 1, 2, 191, 192, 193, 256, 257, 700)


@pytest.fixture(params=[1, 3])
def threads(request: pytest.FixtureRequest) -> Iterator[int]:
    dense.use_threads(request.param)
    yield request.param
    dense.use_threads(1)


def random(*shape: int) -> Array:
    return np.random.default_rng(sum(shape)).normal(size=shape)


def positive(size: int) -> Array:
    root = random(size, size)
    return np.asarray(root @ root.T / max(size, 1) + np.eye(size))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(("precision", "error"), [(np.float32, 1e-3), (np.float64, 1e-11)])
def test_factors_solve_as_those_of_lapack(
    size: int, precision: type[np.floating], error: float, threads: int
) -> None:
    """Rows are swapped everywhere: no row is the pivot of its own column."""
    matrix = random(size, size)[::-1] + np.eye(size)[::-1]
    factors, pivots, failed = dense.factorise(np.array(matrix, dtype=precision, order="F"))
    assert not failed
    wanted = random(size, 2)
    if size:
        target = (matrix @ wanted).astype(precision)
        solved = linalg.lu_solve((factors, pivots), target)
        np.testing.assert_allclose(solved, wanted, atol=error * np.linalg.cond(matrix, 1) / 100)


def test_a_row_that_depends_on_others_is_named(threads: int) -> None:
    matrix = random(300, 300)
    matrix[:, 250] = 0.0
    assert dense.factorise(np.array(matrix, order="F"))[2] == 251


@pytest.mark.parametrize("count", [0, 1, 4, 7])
@pytest.mark.parametrize("cases", [1, 2])
def test_rows_are_combined(count: int, cases: int, threads: int) -> None:
    matrix, rows = random(9, 1200), np.arange(9)[::-1][:count].copy()
    weights = random(count, cases)
    expected = matrix[rows, :1100].T @ weights
    np.testing.assert_allclose(
        dense.combine_rows(matrix, rows, weights, 1100), expected, atol=1e-13
    )


@pytest.mark.parametrize("size", SIZES)
def test_inverse_of_the_upper_triangle_leaves_the_lower_one_alone(size: int, threads: int) -> None:
    matrix = positive(size)
    found = dense.invert_triangle(np.array(matrix, order="F"))
    below = np.tril(np.ones((size, size), dtype=bool), -1)
    np.testing.assert_array_equal(found[below], matrix[below])
    inverse = np.triu(found)
    np.testing.assert_allclose(inverse.T @ matrix @ inverse, np.eye(size), atol=1e-10)


def test_a_matrix_that_is_not_positive_definite_is_refused(threads: int) -> None:
    matrix = positive(500)
    matrix[420, 420] = -1.0
    with pytest.raises(np.linalg.LinAlgError, match="row 421"):
        dense.invert_triangle(np.array(matrix, order="F"))


@pytest.mark.parametrize("size", SIZES)
def test_products_are_those_of_numpy(size: int, threads: int) -> None:
    matrix, other, vectors = positive(size), random(size, size + 5), random(size + 5, 3)
    product = dense.multiply_symmetric(matrix, vectors[:size, 1])  # neither contiguous nor whole
    np.testing.assert_allclose(product, matrix @ vectors[:size, 1], atol=1e-11)
    for each in (other, np.asfortranarray(other), other[:, 2:], other[: size // 2]):
        some = vectors[: each.shape[1]]
        np.testing.assert_allclose(dense.multiply(each, some), each @ some, atol=1e-11)
    for transpose, triangle in ((False, np.triu(matrix)), (True, np.triu(matrix).T)):
        found = dense.multiply_triangle(matrix.T, vectors[:size], transpose=transpose)
        np.testing.assert_allclose(found, triangle @ vectors[:size], atol=1e-11)
    rows, columns = np.arange(size)[::-3], np.arange(0, size, 2)
    found = dense.gather(matrix, rows, columns)
    np.testing.assert_array_equal(found, matrix[np.ix_(rows, columns)])
    larger = np.zeros((size + 1, size + 2))
    dense.gather(matrix, rows, columns, larger[: len(rows), : len(columns)])
    np.testing.assert_array_equal(larger[: len(rows), : len(columns)], found)
    assert not larger[len(rows) :].any() and not larger[:, len(columns) :].any()


@pytest.mark.parametrize("size", [0, 1, 300])
@pytest.mark.parametrize("width", [1, 2])
def test_nothing_stays_of_what_was_in_memory_before(
    size: int, width: int, threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Routines for vectors leave it where there are no columns; 0 times NaN is NaN."""
    matrix, vectors = positive(size), random(size, width)
    none, products = np.zeros((7, 0)), matrix @ vectors
    monkeypatch.setattr(np, "empty", lambda shape, order="C": np.full(shape, np.nan, order=order))
    assert (dense.multiply(none, np.zeros((0, width))) == 0.0).all()
    np.testing.assert_allclose(dense.multiply(matrix, vectors), products, atol=1e-11)
    symmetric = dense.multiply_symmetric(matrix, vectors[:, 0])
    np.testing.assert_allclose(symmetric, products[:, 0], atol=1e-11)


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    """A run on more ranks gives the same numbers."""

    def results() -> list[Array]:
        matrix = positive(1100)
        return [
            dense.factorise(np.array(matrix, order="F"))[0],
            dense.invert_triangle(np.array(matrix, order="F")),
            dense.multiply(matrix, matrix[:, :2]),
        ]

    dense.use_threads(1)
    alone = results()
    try:
        for count in (2, 5):
            dense.use_threads(count)
            for one, several in zip(alone, results(), strict=True):
                np.testing.assert_array_equal(one, several)
    finally:
        dense.use_threads(1)
