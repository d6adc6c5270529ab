# SPDX-License-Identifier: LGPL-3.0-or-later
"""Halves of symmetric matrices against whole ones, over several blocks of rows."""

from __future__ import annotations

import numpy as np

from fretfe.fem.symmetric import BLOCK, SymmetricMatrix, mirror_lower

SIZE = 2 * BLOCK + 30


def test_half_a_matrix_does_what_the_whole_one_does() -> None:
    random = np.random.default_rng(3)
    full = random.standard_normal((SIZE, SIZE))
    full += full.T
    half = SymmetricMatrix(np.where(np.tri(SIZE, dtype=bool), full, np.nan), -1.0)
    np.testing.assert_array_equal(half.whole(), -full)
    vectors = random.standard_normal((SIZE, 3))
    half.add_product(vectors, vectors)
    full = vectors @ vectors.T - full
    np.testing.assert_allclose(half.whole(), full, rtol=0, atol=1e-13)  # round-off
    assert abs(half.trace() - np.trace(full)) < 1e-10
    for wanted in (slice(0, SIZE), slice(40, 300), slice(BLOCK, BLOCK + 1)):
        found = half.multiply(vectors, wanted)
        np.testing.assert_allclose(found, full[wanted] @ vectors, rtol=0, atol=1e-11)
    places = np.sort(random.permutation(SIZE + 50)[:SIZE])
    larger = np.zeros((SIZE + 50, SIZE + 50))
    half.add_to(larger, places)
    mirror_lower(larger)
    np.testing.assert_allclose(larger[np.ix_(places, places)], full, rtol=0, atol=1e-13)
    assert np.count_nonzero(larger) == SIZE**2
    half.shorten()
    np.testing.assert_array_equal(half.whole(), half.whole().astype(np.float32))
