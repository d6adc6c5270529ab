# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear systems that change little: as accurate as a factorisation of each, with fewer of them."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.contact import dense
from fretfe.contact.nested_inverse import FEWEST, MatrixSystem, SimilarSystems

SIZE = FEWEST + 20
UNKNOWNS = np.arange(SIZE)


@pytest.fixture
def factorised(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, int]]:
    """Precision and size of the matrices that are factorised."""
    sizes: list[tuple[str, int]] = []

    factorise = dense.factorise

    def count(matrix: Array) -> object:
        sizes.append(("s" if matrix.dtype == np.float32 else "d", len(matrix)))
        return factorise(matrix)

    monkeypatch.setattr(dense, "factorise", count)
    return sizes


def random(*shape: int) -> Array:
    return np.random.default_rng(len(shape)).normal(size=shape)


def well_posed() -> Array:
    return np.asarray(2 * np.eye(SIZE) + random(SIZE, SIZE) / np.sqrt(SIZE))


def test_a_small_change_needs_no_factorisation(factorised: list[tuple[str, int]]) -> None:
    systems, matrix, target = SimilarSystems(), well_posed(), random(SIZE, 2, 1)[..., 0]
    change = np.outer(random(SIZE), random(SIZE)) / 50
    for amount in (0.0, 1e-2, 1e-6, 0.0):
        system = matrix + amount * change
        found = systems.solve(UNKNOWNS, MatrixSystem(system), target)
        expected = np.linalg.solve(system, target)
        assert np.allclose(found, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    assert factorised == [("s", SIZE)]


def test_systems_with_other_unknowns_border_the_factors(factorised: list[tuple[str, int]]) -> None:
    """Some are taken away, some come back, in another order."""
    systems, matrix, target = SimilarSystems(), well_posed(), random(SIZE, 2, 1)[..., 0]
    for unknowns in (UNKNOWNS[3:], UNKNOWNS, UNKNOWNS[:-8], np.roll(UNKNOWNS, 5)[:-4]):
        system, rhs = matrix[np.ix_(unknowns, unknowns)], target[unknowns]
        found = systems.solve(unknowns, MatrixSystem(system), rhs)
        expected = np.linalg.solve(system, rhs)
        assert np.allclose(found, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    assert factorised == [("s", SIZE - 3)]


def test_other_systems_are_factorised(factorised: list[tuple[str, int]]) -> None:
    systems, matrix, target = SimilarSystems(), well_posed(), random(SIZE, 2, 1)[..., 0]
    cases = [
        (UNKNOWNS, matrix),
        (UNKNOWNS, random(SIZE, SIZE, 1)[..., 0]),  # nothing like the one before
        (UNKNOWNS + 1, matrix),
        (UNKNOWNS[:-1], matrix[1:, 1:]),
    ]
    for unknowns, system in cases:
        rhs = target[: len(system)]
        found = systems.solve(unknowns, MatrixSystem(system), rhs)
        expected = np.linalg.solve(system, rhs)
        assert np.allclose(found, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    assert factorised == [("s", SIZE)] * 3 + [("s", SIZE - 1)]


def test_a_singular_matrix_is_an_error_and_leaves_no_factors(
    factorised: list[tuple[str, int]],
) -> None:
    systems, target = SimilarSystems(), np.ones((SIZE, 1))
    with pytest.raises(np.linalg.LinAlgError):
        systems.solve(UNKNOWNS, MatrixSystem(np.zeros((SIZE, SIZE))), target)
    assert np.array_equal(systems.solve(UNKNOWNS, MatrixSystem(np.eye(SIZE)), target), target)
    assert [precision for precision, _ in factorised] == ["s", "d", "s"]


def test_what_single_precision_cannot_solve_is_factorised_in_double(
    factorised: list[tuple[str, int]],
) -> None:
    """Equations of sizes from 1 to 1e-12, mixed: a condition of 1e12, but an answer of 1e-4."""
    scale = np.logspace(0, -12, SIZE)
    rotation, _ = np.linalg.qr(well_posed())
    matrix, exact = rotation * scale @ rotation.T, random(SIZE, 1)
    found = SimilarSystems().solve(UNKNOWNS, MatrixSystem(matrix), matrix @ exact)
    assert np.linalg.norm(matrix @ (found - exact)) < 1e-13 * np.linalg.norm(matrix @ exact)
    assert [precision for precision, _ in factorised] == ["s", "d"]
