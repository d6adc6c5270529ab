# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear systems that change little: as accurate as a factorisation of each, with fewer of them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from fretfe._typing import Array
from fretfe.contact.nested_inverse import FEWEST, SimilarSystems

SIZE = FEWEST + 20
UNKNOWNS = np.arange(SIZE)


@pytest.fixture
def factorised(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sizes of the matrices that are factorised."""
    sizes: list[int] = []
    factorise = linalg.lapack.dgetrf

    def count(matrix: Array, **options: int) -> object:
        sizes.append(len(matrix))
        return factorise(matrix, **options)

    monkeypatch.setattr(linalg.lapack, "dgetrf", count)
    return sizes


def random(*shape: int) -> Array:
    return np.random.default_rng(len(shape)).normal(size=shape)


def well_posed() -> Array:
    return np.asarray(2 * np.eye(SIZE) + random(SIZE, SIZE) / np.sqrt(SIZE))


def test_a_small_change_needs_no_factorisation(factorised: list[int]) -> None:
    systems, matrix, target = SimilarSystems(), well_posed(), random(SIZE, 2, 1)[..., 0]
    change = np.outer(random(SIZE), random(SIZE)) / 50
    for amount in (0.0, 1e-2, 1e-6, 0.0):
        system = matrix + amount * change
        found = systems.solve(UNKNOWNS, system.copy(), target)
        expected = np.linalg.solve(system, target)
        assert np.allclose(found, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    assert factorised == [SIZE]


def test_other_systems_are_factorised(factorised: list[int]) -> None:
    systems, matrix, target = SimilarSystems(), well_posed(), random(SIZE, 2, 1)[..., 0]
    cases = [
        (UNKNOWNS, matrix),
        (UNKNOWNS, random(SIZE, SIZE, 1)[..., 0]),  # nothing like the one before
        (UNKNOWNS + 1, matrix),
        (UNKNOWNS[:-1], matrix[1:, 1:]),
    ]
    for unknowns, system in cases:
        rhs = target[: len(system)]
        found = systems.solve(unknowns, system.copy(), rhs)
        expected = np.linalg.solve(system, rhs)
        assert np.allclose(found, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    assert factorised == [SIZE, SIZE, SIZE, SIZE - 1]


def test_a_singular_matrix_is_an_error_and_leaves_no_factors(factorised: list[int]) -> None:
    systems, target = SimilarSystems(), np.ones((SIZE, 1))
    with pytest.raises(np.linalg.LinAlgError):
        systems.solve(UNKNOWNS, np.zeros((SIZE, SIZE)), target)
    assert np.array_equal(systems.solve(UNKNOWNS, np.eye(SIZE), target), target)
    assert len(factorised) == 2
