# SPDX-License-Identifier: LGPL-3.0-or-later
"""dgemmt of the library that MUMPS finds in place of OpenBLAS's, against NumPy."""

from __future__ import annotations

import ctypes
import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from fretfe._core import _kernels
from fretfe._typing import Array, Bools
from fretfe.contact.dense import routine_addresses

# Around the size of the blocks that go through a buffer, and parts of unequal size.
SIZES, INNER = (1, 2, 47, 48, 49, 97, 203), (0, 1, 5, 64)
FACTORS = ((1.0, 1.0), (-1.0, 1.0), (2.5, 0.0), (0.0, -0.5), (-0.5, 3.0))


@pytest.fixture(scope="module")
def library() -> Iterator[ctypes.CDLL]:
    loaded = ctypes.CDLL(str(Path(_kernels.__file__).with_name("_gemmt.so")))
    dgemm = ctypes.c_void_p.in_dll(loaded, "fretfe_dgemm")
    before, dgemm.value = dgemm.value, routine_addresses("d")[0]
    yield loaded
    dgemm.value = before  # that of PETSc, if this process has it


def stored(values: Array, spare: int) -> Array:
    """A matrix by columns, with spare rows of ones below."""
    whole = np.ones((values.shape[0] + spare, values.shape[1]), order="F")
    whole[: len(values)] = values
    return whole


def call(
    library: ctypes.CDLL,
    flags: str,
    sizes: tuple[int, int],
    factors: tuple[float, float],
    matrices: tuple[Array, Array, Array],
) -> None:
    """C := alpha op(A) op(B) + beta C in place, with the leading dimensions of the arrays."""
    a, b, c = matrices
    n, k, *leading = (ctypes.byref(ctypes.c_int(v)) for v in (*sizes, *(len(m) for m in matrices)))
    alpha, beta = (ctypes.byref(ctypes.c_double(v)) for v in factors)
    pointers = [ctypes.c_void_p(each.ctypes.data) for each in (a, b, c)]
    letters = [flag.encode() for flag in flags]
    library.dgemmt_(
        *letters, n, k, alpha, pointers[0], leading[0], pointers[1], leading[1], beta,
        pointers[2], leading[2],
    )  # fmt: skip


def triangle(n: int, uplo: str) -> Bools:
    full = np.ones((n, n), dtype=bool)
    return np.tril(full) if uplo in "Ll" else np.triu(full)


@pytest.mark.parametrize("flags", ["".join(f) for f in itertools.product("LU", "NT", "NT")])
def test_one_triangle_is_updated(library: ctypes.CDLL, flags: str) -> None:
    random = np.random.default_rng(3)
    for n, k, (alpha, beta) in itertools.product(SIZES, INNER, FACTORS):
        left, right = random.standard_normal((n, k)), random.standard_normal((k, n))
        c = stored(random.standard_normal((n, n)), 4)
        a = stored(left if flags[1] == "N" else left.T, 3)
        b = stored(right if flags[2] == "N" else right.T, 2)
        expected = c.copy()
        mine = triangle(n, flags[0])
        expected[:n][mine] = (alpha * left @ right + beta * c[:n])[mine]
        call(library, flags, (n, k), (alpha, beta), (a, b, c))
        # Sums of at most 64 products of about 1.
        np.testing.assert_allclose(c, expected, rtol=0, atol=1e-13, err_msg=f"{n} {k} {alpha}")
        others = np.ones(c.shape, dtype=bool)
        others[:n][mine] = False
        np.testing.assert_array_equal(c[others], expected[others])


@pytest.mark.parametrize("flags", ["LNN", "UNN"])
@pytest.mark.parametrize("n", [30, 100])
def test_what_is_no_number_is_overwritten(library: ctypes.CDLL, flags: str, n: int) -> None:
    left, right = np.random.default_rng(5).standard_normal((2, n, n))
    c = np.full((n, n), np.nan, order="F")
    call(library, flags, (n, n), (1.0, 0.0), (stored(left, 0), stored(right, 0), c))
    mine = triangle(n, flags[0])
    np.testing.assert_allclose(c[mine], (left @ right)[mine], rtol=0, atol=1e-12)
    assert np.isnan(c[~mine]).all()


def test_small_letters_and_conjugates(library: ctypes.CDLL) -> None:
    left, right = np.random.default_rng(6).standard_normal((2, 60, 60))
    c = np.zeros((60, 60), order="F")
    call(library, "lcn", (60, 60), (1.0, 0.0), (stored(left, 0), stored(right, 0), c))
    np.testing.assert_allclose(c, np.tril(left.T @ right), rtol=0, atol=1e-12)


def test_nothing_to_do_is_not_counted(library: ctypes.CDLL) -> None:
    calls = ctypes.c_long.in_dll(library, "fretfe_dgemmt_calls")
    before, c = calls.value, np.full((1, 1), np.nan)
    one = np.ones((1, 1))
    call(library, "LNN", (0, 1), (1.0, 0.0), (one, one, c))
    assert calls.value == before
    assert np.isnan(c[0, 0])
    call(library, "LNN", (1, 1), (1.0, 0.0), (one, one, c))
    assert calls.value == before + 1
    assert c[0, 0] == 1.0
